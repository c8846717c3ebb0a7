//! What the board is between two passes of the main loop.

mod control;
mod effect;
mod events;
mod io;
mod keep;
mod library;
mod power;
mod run;
mod tick;
pub mod trace;

pub use effect::{END, Effect, PULSE_BEGUN};
pub use events::{Event, PENDING};
use keep::Carried;
use trace::Trace;

use crate::chip::PART;
use crate::flash::Area;
use crate::home::Plan;
use crate::library::{Library, Staged};
use crate::lock::Lock;
use crate::motor::Motor;
use crate::vm::vm;
use core::ptr::addr_of_mut;
use firmware::inputs::Inputs;
use firmware::motion::Feed;
use firmware::print::Print;
use firmware::session::Session;
use firmware::store::Store;
use lang::fault::Fault;
use lang::record::{BoardRecord, feature};

/// Image features of this firmware.
pub const FEATURES: u16 =
    PART.features & if cfg!(feature = "stream") { !0 } else { !feature::STREAM };

/// Registers of the command buffer.
const BUFFER: usize = 21;

/// The board.
pub struct Controller {
    /// Run state.
    pub session: Session,
    /// Program store.
    pub store: Store,
    /// Filtered inputs 1..16.
    pub inputs: Inputs,
    /// Start and Stop as they were accepted: bit 0 Stop, bit 1 Start.
    pub buttons: Inputs,
    /// Outputs 1..16.
    pub outputs: u16,
    /// Outputs as they were before a pause.
    pub resume_outputs: u16,
    /// Positions.
    pub motor: Motor,
    /// Print ring.
    pub print: Print,
    /// Trace slot.
    pub trace: Trace,
    /// The effect that runs and the one that an event handler interrupted.
    pub effect: Effect,
    /// See `effect`.
    pub outer: Effect,
    /// Address of that one's instruction.
    outer_pc: u16,
    /// The level that the effect gives: bit 0.
    pub level: u8,
    /// An output that is given it follows the feed's power.
    pub follows: bool,
    /// F.
    pub feed: Feed,
    /// What F was where a handler began: the outer one's, and that of an error handler within an
    /// event handler.
    pub feeds_aside: [Feed; 2],
    /// Light that a laser owes, thousandths of the timer's ticks; negative when it gave too much.
    shine: i32,
    /// When this was last seen to, by that timer.
    shone: u16,
    /// The laser is lit.
    lit: bool,
    /// Reference run under way.
    pub plan: Plan,
    /// Bit per axis: homing by command failed.
    pub homing_error: u8,
    /// Bit per axis: probing by command failed.
    pub probe_error: u8,
    /// No reply is being sent: flash may be written, which would tear it apart.
    pub line_rests: bool,
    /// Which program is meant.
    pub library: Library,
    /// What the last request of an upload brought.
    pub staged: Staged,
    /// KEEP values of the one that an upload replaces.
    carried: Carried,
    /// The lock of program and profile.
    pub lock: Lock,
    /// Reset the chip once the reply is out.
    pub restart: bool,
    /// A motion by 102 or 1111 is under way.
    pub jog: bool,
    /// Milliseconds that what commands move still goes on, 0 without such a bound.
    pub hold: u16,
    /// Milliseconds since the last sound request.
    pub silence: u16,
    /// Command buffer.
    pub command: [u16; BUFFER],
    /// Milliseconds until motion goes on after a pause.
    pub spin: u16,
    /// Millisecond of the status lamp.
    pub blink: u16,
    /// What ends a probe move.
    pub probe_and: u32,
    /// See `probe_and`.
    pub probe_xor: u32,
    /// Levels of the inputs before the filter.
    pub raw: u16,
    /// Level of input 17, which has no filter, in the last millisecond.
    probe: bool,
    /// ON lines.
    pub events: [Event; 4],
    /// Address of the effect's instruction.
    pub effect_pc: u16,
    /// Milliseconds of the run.
    pub timer: i32,
    /// Milliseconds handled.
    pub tick: u16,
    /// Milliseconds for which Stop has been held; then until autorun.
    pub held: u16,
    /// Millisecond phase of the input filter.
    pub phase: u8,
    /// TIMEDOUT.
    pub timed_out: bool,
    /// The host knows of the line that is being printed.
    pub announced: bool,
    /// A fault found while a path moved, and where: it is raised at the path's end.
    late: Option<(Fault, u16)>,
    /// Input that caused the last fault.
    pub fault_input: u8,
    /// Last Send: character and count.
    pub char_out: u16,
    /// Character from the host.
    pub char_in: u8,
    /// Upload: announced length, bit 15 KEEP.
    pub upload_length: u16,
    /// [`lang::wire::Refusal`]
    pub refusal: u8,
    /// The line that is served: 0 the back channel, 1 RS-485.
    pub line: u8,
    /// The line that wrote last, and one more; 0 for none since reset.
    pub helm: u8,
    /// Milliseconds that it still holds the helm.
    pub helm_left: u16,
    /// Of each line: high half of a 32-bit value being read.
    pub latch: [u16; 2],
    /// Of each line: address after the one whose value is latched.
    pub latched: [u16; 2],
    /// Milliseconds served late.
    pub missed: u16,
    /// IFG1 at reset.
    pub cause: u8,
    /// Watchdog resets in a row.
    pub bites: u16,
    /// Half a second has passed since reset.
    pub booted: bool,
    /// A host has spoken since reset.
    pub host: bool,
    /// The profile.
    pub record: &'static BoardRecord,
}

impl Controller {
    /// At reset. Built as a value it would be made on the stack and copied: 650 bytes of RAM and 400
    /// of flash.
    ///
    /// # Safety
    /// `controller` points to zeroed memory that nothing else refers to.
    pub unsafe fn init(controller: *mut Controller) -> &'static mut Controller {
        // SAFETY: the caller's; what is not written is integers and booleans, of which zeroes are
        // a value.
        unsafe {
            addr_of_mut!((*controller).session).write(Session::new());
            addr_of_mut!((*controller).store).write(Store::new());
            Motor::init(addr_of_mut!((*controller).motor));
            addr_of_mut!((*controller).feed).write(Feed::Rapid);
            addr_of_mut!((*controller).feeds_aside).write([Feed::Rapid; 2]);
            addr_of_mut!((*controller).line_rests).write(true);
            addr_of_mut!((*controller).late).write(None);
            let record = crate::boot::newest_profile();
            addr_of_mut!((*controller).record).write(record);
            addr_of_mut!((*controller).lock).write(Lock::new(record.lock));
            &mut *controller
        }
    }

    /// After a reset: outputs, program, what was going on.
    pub fn mount(&mut self) {
        self.outputs = self.record.reset_on;
        self.store.mount(&mut Area);
        self.reselect();
        self.stored();
        if let Some([number, pc, _]) = crate::boot::logged() {
            self.session.remember(number as u8);
            self.fault_input = (number >> 8) as u8;
            vm().fault = number as u8;
            vm().fault_pc = vm().code.wrapping_add(pc);
        }
        if let Some(fault) = crate::boot::interrupted(self.cause) {
            let order = self.session.end(Some(fault));
            self.obey(order);
        }
    }

    /// Address of the stored image.
    pub fn image(&self) -> Option<u16> {
        self.store.image::<Area>().map(|offset| crate::flash::AREA + offset)
    }
}
