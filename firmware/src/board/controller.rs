//! What the board is between two passes of the main loop: a room for all that changes together.

mod command;
mod control;
mod effect;
mod events;
mod handlers;
mod io;
mod keep;
mod library;
mod light;
mod power;
mod program;
mod run;
mod seek;
mod session;
mod talk;
mod tick;
pub mod trace;

pub use effect::{END, Effect, PULSE_BEGUN};
pub use events::{Event, PENDING};
pub use seek::Plan;

use crate::boot::Reset;
use crate::chip::PART;
use crate::flash::Area;
use crate::lines::Lines;
use crate::lock::Lock;
use crate::motor::Motor;
use crate::vm::vm;
use command::Command;
use core::ptr::addr_of_mut;
use firmware::session::Session;
use firmware::store::Store;
use io::Io;
use keep::{Carried, LEFT, Left};
use lang::record::{BoardRecord, feature};
use library::{Incoming, Library};
use light::Light;
use program::Program;
use seek::Seek;
use talk::Talk;
use tick::Clock;
use trace::Trace;

/// Image features of this firmware.
pub const FEATURES: u16 =
    PART.features & if cfg!(feature = "stream") { !0 } else { !feature::STREAM };

/// The board.
pub struct Controller {
    /// The profile.
    pub record: &'static BoardRecord,
    /// The lock of program and profile.
    pub lock: Lock,
    /// The last reset, and the next one.
    pub reset: Reset,
    /// The lines of the link.
    pub lines: Lines,
    /// Milliseconds.
    pub clock: Clock,
    /// Inputs and outputs.
    pub io: Io,
    /// A laser without a PWM.
    light: Light,
    /// Positions and what moves.
    pub motor: Motor,
    /// Run state.
    pub session: Session,
    /// The program that runs.
    pub program: Program,
    /// What it and the host say to each other.
    pub talk: Talk,
    /// What a host in trace mode is told.
    pub trace: Trace,
    /// What a reference run or a probe move looks for.
    pub seek: Seek,
    /// InterpCNC commands.
    pub command: Command,
    /// Program store.
    pub store: Store,
    /// Which of its programs is meant.
    pub library: Library,
    /// What comes into it.
    pub incoming: Incoming,
    /// KEEP values of the program that an upload replaces.
    carried: Carried,
    /// Those of programs that RUN has left.
    left: [Left; LEFT],
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
            Program::init(addr_of_mut!((*controller).program));
            addr_of_mut!((*controller).lines.rests).write(true);
            let record = crate::boot::newest_profile();
            addr_of_mut!((*controller).record).write(record);
            addr_of_mut!((*controller).lock).write(Lock::new(record.lock));
            &mut *controller
        }
    }

    /// After a reset: outputs, program, what was going on.
    pub fn mount(&mut self) {
        self.io.outputs = self.record.reset_on;
        self.store.mount(&mut Area);
        self.reselect();
        self.stored();
        if let Some([number, pc, _]) = crate::boot::logged() {
            self.session.fault = number as u8;
            self.program.fault_input = (number >> 8) as u8;
            vm().fault = number as u8;
            vm().fault_pc = vm().code.wrapping_add(pc);
        }
        if let Some(fault) = crate::boot::interrupted(self.reset.cause) {
            self.session.latch(fault);
        }
    }

    /// Address of the stored image.
    pub fn image(&self) -> Option<u16> {
        self.store.image::<Area>().map(|offset| crate::flash::AREA + offset)
    }
}
