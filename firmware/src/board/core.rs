//! What the board is between two passes of the main loop.

use crate::check;
use crate::commands::{BUFFER, SILENCE};
use crate::flash::{Area, Image};
use crate::lock::Lock;
use crate::motor::Motor;
use crate::moves::Plan;
use crate::vm::vm;
use crate::{chain, link, vm_core};
use ::core::ptr::addr_of_mut;
use firmware::inputs::Inputs;
use firmware::keep::{KEEPS, Keep};
use firmware::motion::Feed;
use firmware::print::Print;
use firmware::session::{Order, Session};
use firmware::store::Store;
use firmware::verify::{self, Bytes, Limits};
use lang::fault::Fault;
use lang::isa::Op;
use lang::part;
use lang::record::{BoardRecord, FULL_POWER, feature};
use lang::vm::flag;
#[cfg(feature = "stream")]
use lang::wire::Called;
use lang::wire::{Control, End, RunState, TRACE_OK, TraceKind};

/// Image features of this firmware.
pub const FEATURES: u16 =
    part::G2955.features & if cfg!(feature = "stream") { !0 } else { !feature::STREAM };

/// What the chip can run.
pub const LIMITS: Limits = Limits {
    bytes: Store::area::<Area>(),
    features: FEATURES as u8,
    pool: crate::vm::POOL_LIMITS,
    event_pool: lang::part::G2955.event_pool,
};

/// An effect under way.
#[derive(Clone, Copy)]
pub struct Effect {
    /// Its code, 0 for none.
    pub code: u8,
    /// What it has come to.
    pub phase: u8,
    /// Input or output number, character, axis.
    pub n: u8,
    /// Flags of the instruction.
    pub bits: u8,
    /// Milliseconds to go; negative is for ever.
    pub left: i32,
}

impl Effect {
    /// None.
    pub const NONE: Effect = Effect { code: 0, phase: 0, n: 0, bits: 0, left: 0 };

    /// A millisecond less for what waits; others keep something else in `left`.
    fn count_down(&mut self) {
        const HOME: u8 = Op::Home as u8;
        const HOME_QUERY: u8 = Op::HomeQuery as u8;
        const WAIT: u8 = Op::Wait as u8;
        const WAIT_IN: u8 = Op::WaitIn as u8;
        const WAIT_CHAR: u8 = Op::WaitChar as u8;
        let waits = matches!(self.code, HOME..=HOME_QUERY | WAIT | WAIT_IN | WAIT_CHAR);
        if waits && self.left > 0 {
            self.left -= 1;
        }
    }
}

/// The event that a host in trace mode has not received yet.
pub struct Trace {
    /// Trace mode.
    pub on: bool,
    /// The slot holds an event that was not received.
    pub full: bool,
    /// Number of the last event.
    pub number: u16,
    /// [`TraceKind`] and argument.
    pub kind: u8,
    /// See `kind`.
    pub argument: u8,
    /// Where the effect stands in the code.
    pub pc: u16,
    /// Its value.
    pub value: i32,
}

/// An ON line.
#[derive(Clone, Copy)]
pub struct Event {
    /// 0 none, 1 rise, 2 fall, 3 every; bit 7: it has come and was not served.
    pub kind: u8,
    /// Input number.
    pub n: u8,
    /// Period, ms.
    pub period: i32,
    /// Milliseconds to the next tick.
    pub left: i32,
}

/// Autorun gives up after so many watchdog resets in a row.
const BITES: u16 = 3;

const PULSE: u8 = Op::Pulse as u8;
/// Phase of a Pulse that lasts; behind it the pulse is over and was told.
pub const PULSE_BEGUN: u8 = 1;

/// Codes from here on are effects.
const FIRST_EFFECT: u16 = lang::isa::EFFECTS as u16;
/// Code of the pseudo-effect that ends a run.
pub const END: u8 = 0xFF;

/// [`Event::kind`]: it has come and was not served.
pub const PENDING: u8 = 0x80;

/// The board.
pub struct Core {
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
    /// F.
    pub feed: Feed,
    /// What F was where a handler began: the outer one's, and that of an error handler within an
    /// event handler.
    pub feeds_aside: [Feed; 2],
    /// Light that a laser owes, thousandths of 0.5 us; negative when it gave too much.
    shine: i32,
    /// When this was last seen to, by the timer of 0.5 us.
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
    /// The lock of program and profile.
    pub lock: Lock,
    /// Reset the chip once the reply is out.
    pub restart: bool,
    /// A motion by 102 or 1111 is under way.
    pub jog: bool,
    /// Milliseconds since the last sound request.
    pub silence: u16,
    /// Command buffer.
    pub command: [u16; BUFFER],
    /// KEEP journal.
    pub keep: Keep,
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
    /// High half of a 32-bit value being read.
    pub latch: u16,
    /// Address after the one whose value is latched.
    pub latched: u16,
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

/// Handlers that are open: at most one of an event and one of errors.
fn handlers() -> usize {
    usize::from(vm().flags & flag::EVENT != 0) + usize::from(vm().flags & flag::ERROR != 0)
}

/// A millisecond of light, thousandths of 0.5 us.
const A_MILLISECOND: i32 = 2000 * FULL_POWER as i32;
/// As much light is owed, or was given too much, at most: what a lost line owes is not for the next.
const MOST: i32 = 8 * A_MILLISECOND;

impl Core {
    /// At reset. Built as a value it would be made on the stack and copied: 650 bytes of RAM and 400
    /// of flash.
    ///
    /// # Safety
    /// `core` points to zeroed memory that nothing else refers to.
    pub unsafe fn init(core: *mut Core) -> &'static mut Core {
        // SAFETY: the caller's; what is not written is integers and booleans, of which zeroes are
        // a value.
        unsafe {
            addr_of_mut!((*core).session).write(Session::new());
            addr_of_mut!((*core).store).write(Store::new());
            Motor::init(addr_of_mut!((*core).motor));
            addr_of_mut!((*core).feed).write(Feed::Rapid);
            addr_of_mut!((*core).feeds_aside).write([Feed::Rapid; 2]);
            addr_of_mut!((*core).line_rests).write(true);
            addr_of_mut!((*core).late).write(None);
            let record = crate::boot::newest_profile();
            addr_of_mut!((*core).record).write(record);
            addr_of_mut!((*core).lock).write(Lock::new(record.lock));
            &mut *core
        }
    }

    /// After a reset: outputs, program, what was going on.
    pub fn mount(&mut self) {
        self.outputs = self.record.reset_on;
        self.store.mount(&mut Area);
        self.keep.mount(&Area);
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

    /// No effect is under way any more.
    #[inline(never)]
    pub fn forget(&mut self) {
        self.effect = Effect::NONE;
    }

    /// The stored program has changed: it is checked and its profile holds.
    pub fn stored(&mut self) {
        let image = self.image().filter(|&image| self.check(image));
        vm().attach(image.unwrap_or(0));
        self.session.stored(image.is_some());
    }

    fn keep_count(&self) -> u16 {
        // A streamed run has no KEEP, whatever is stored; the VM may still stand in its last piece.
        if vm().code == 0 || crate::streams() && self.session.is_active() {
            return 0;
        }
        self.image().map_or(0, |image| u16::from(Image(image).byte(16) & 15))
    }

    /// KEEP value `index`: of the running program its cell.
    pub fn kept(&self, index: u16) -> i32 {
        if self.session.is_active() && index < self.keep_count() {
            return vm().cell(self.keep_base() + index);
        }
        self.keep.read(&Area, index)
    }

    /// Changes a KEEP value.
    pub fn set_kept(&mut self, index: u16, value: i32) -> bool {
        if index >= self.keep_count() {
            return false;
        }
        if self.session.is_active() {
            return vm().set_cell(self.keep_base() + index, value);
        }
        self.keep.claim(&mut Area, self.keep_count());
        self.keep.write(&mut Area, index, value);
        true
    }

    fn keep_base(&self) -> u16 {
        u16::from(Image(self.image().unwrap_or(0)).byte(17))
    }

    /// Writes changed KEEP values to flash; nothing may move.
    fn save(&mut self) {
        let mut index = self.keep_count();
        while index != 0 {
            index -= 1;
            let value = vm().cell(self.keep_base() + index);
            self.keep.write(&mut Area, index, value);
        }
    }

    /// Address of the stored image.
    pub fn image(&self) -> Option<u16> {
        self.store.image().map(|offset| crate::flash::AREA + offset)
    }

    /// Checks the image at an address; the pool must be free.
    pub fn check(&mut self, image: u16) -> bool {
        // SAFETY: no program runs, so the pool is free for the check's anchors.
        let scratch = unsafe {
            &mut *core::ptr::addr_of_mut!(crate::vm::CALLS).cast::<[u8; check::SCRATCH]>()
        };
        self.refusal = check::verify(image, LIMITS.features, scratch).err().unwrap_or(0);
        self.refusal == 0
    }

    /// Does what the session decided.
    pub fn obey(&mut self, order: Order) {
        match order {
            Order::None => {}
            Order::Begin => self.begin(),
            Order::Brake => {
                self.motor.pause(true);
            }
            Order::Resume => {
                let before = self.outputs;
                self.outputs = self.resume_outputs;
                let spindle = self.record.spindle;
                let bit = if spindle == 0 { 0 } else { 1 << ((spindle - 1) & 15) };
                self.spin = 1;
                if self.outputs & !before & bit != 0 {
                    self.spin += self.record.spin_up;
                }
            }
            Order::Finish => self.motor.stop(0b111),
        }
    }

    fn begin(&mut self) {
        let Some(image) = self.image() else { return };
        // The host has not read how the last run ended: the press comes too early.
        if self.trace.full {
            return;
        }
        if verify::sound(&Image(image), LIMITS.bytes).is_none() || !self.check(image) {
            self.fail(Fault::ImageRefused);
            return;
        }
        vm().begin(image);
        let keeps = self.keep_count();
        if keeps != 0 {
            self.keep.claim(&mut Area, keeps);
            let mut index = 0;
            while index < keeps.min(KEEPS) {
                vm().set_cell(self.keep_base() + index, self.keep.read(&Area, index));
                index += 1;
            }
        }
        #[cfg(feature = "stream")]
        crate::stream::close();
        self.begun();
    }

    /// The VM stands at the beginning of a run.
    pub fn begun(&mut self) {
        crate::boot::mark(true);
        self.jog = false;
        self.session.begun();
        self.motor.begin();
        self.forget();
        self.outer = Effect::NONE;
        self.feed = self.default_feed();
        self.motor.power = FULL_POWER as u16;
        self.late = None;
        for event in &mut self.events {
            event.kind = 0;
        }
        self.trace.number = 0;
        self.trace.full = false;
        self.timer = 0;
        self.timed_out = false;
        self.announced = false;
        self.print.abandon();
        self.fault_input = 0;
    }

    /// A control code from the link.
    pub fn control(&mut self, control: Control) {
        let program = self.store.image().is_some();
        let blocked = self.blocked();
        let order = match control {
            Control::Start => self.session.start(blocked, program),
            Control::Stop => self.session.stop(),
            Control::Pause => self.session.pause(),
            Control::Resume if !blocked => self.session.resume(),
            Control::EmergencyStop => {
                self.emergency(0);
                Order::None
            }
            Control::Restart if !self.session.is_active() && self.motor.moving() == 0 => {
                self.restart = true;
                Order::None
            }
            Control::Acknowledge if self.session.state() as u8 == RunState::Fault as u8 => {
                self.session.start(blocked, program)
            }
            _ => Order::None,
        };
        self.obey(order);
    }

    /// Steps cease at once, outputs go to their safe states, F14 is latched.
    pub fn emergency(&mut self, input: u8) {
        self.motor.halt();
        self.motor.homed = 0;
        self.fault_input = input;
        self.effect.code = if self.session.is_active() { self.effect.code } else { 0 };
        self.fail(Fault::EmergencyStop);
        if !self.session.is_active() {
            self.outputs = self.outputs & self.record.fault.keep | self.record.fault.on;
        }
    }

    /// A fault that ends the run.
    pub fn fail(&mut self, fault: Fault) {
        if vm().fault != fault.number() {
            vm().fault = fault.number();
            vm().fault_pc = self.effect_pc;
        }
        let order = self.session.end(Some(fault));
        self.obey(order);
    }

    /// A fault of the program: its handler, or the end of the run.
    pub fn raise(&mut self, fault: Fault, pc: u16, between: bool) {
        self.motor.stop(0b111);
        let open = handlers();
        let waits = self.effect.code != 0;
        self.forget();
        self.print.abandon();
        if vm().raise(fault, pc, between) {
            self.put_feed_aside(open);
            #[cfg(feature = "stream")]
            if crate::stream::owns() {
                let place = match (between, waits) {
                    (false, _) => Called::Failed,
                    (true, false) => Called::Behind,
                    (true, true) => Called::Within,
                };
                crate::stream::call(place, 0, fault.number());
            }
        } else {
            self.fail(fault);
        }
    }

    /// A handler begins inside `open` others, without F.
    fn put_feed_aside(&mut self, open: usize) {
        self.feeds_aside[open & 1] = self.feed;
        self.feed = Feed::Rapid;
    }

    /// A fault of the statement at `pc`: what was commanded before it ends first.
    fn found(&mut self, fault: Fault, pc: u16) {
        if self.motor.path_rests() {
            self.raise(fault, pc, false);
        } else {
            self.forget();
            self.late = Some((fault, pc));
        }
    }

    /// Whether Stop is held or a hold, door or emergency stop input is active.
    pub fn blocked(&self) -> bool {
        self.buttons.accepted() & 1 != 0 || self.blocking() != 0
    }

    /// The input that blocks, 0 for none.
    pub fn blocking(&self) -> u8 {
        for n in [self.record.stop, self.record.hold, self.record.door, self.record.emergency] {
            if n != 0 && self.input(n) {
                return n;
            }
        }
        0
    }

    /// Input `n` from 1; false beyond those there are.
    pub fn input(&self, n: u8) -> bool {
        match n {
            1..=16 => self.inputs.levels() >> (n - 1) & 1 != 0,
            17 if self.chained() => chain::probe() != (self.record.input_invert_high != 0),
            _ => false,
        }
    }

    /// Chain wiring, otherwise direct.
    pub fn chained(&self) -> bool {
        self.record.flags & BoardRecord::CHAIN != 0
    }

    /// Sets an output, numbered from 1; `false` beyond those there are.
    pub fn set_output(&mut self, n: u16, on: bool) -> bool {
        let most = if self.chained() { 16 } else { 2 };
        if n == 0 || n > most {
            return false;
        }
        let bit = 1 << (n - 1);
        self.outputs &= !bit;
        if on {
            self.outputs |= bit;
        }
        true
    }

    /// One event for the host; the slot is free when this is called.
    pub fn emit(&mut self, kind: TraceKind, argument: u8, value: i32) {
        if !self.trace.on {
            return;
        }
        self.trace.number = self.trace.number.wrapping_add(1);
        self.trace.full = true;
        self.trace.kind = kind as u8;
        self.trace.argument = argument;
        self.trace.pc = self.effect_pc.wrapping_sub(vm().code);
        self.trace.value = value;
    }

    /// An event with an outcome.
    pub fn emit_outcome(&mut self, kind: TraceKind, argument: u8, ok: bool, value: i32) {
        self.emit(kind, argument | if ok { TRACE_OK } else { 0 }, value);
    }

    /// The host has received every event before number `number`.
    pub fn received(&mut self, odd: bool) {
        // Reading the slot of the other parity says that the event in this one was received.
        if self.trace.full && (self.trace.number & 1 != 0) != odd {
            self.trace.full = false;
        }
    }

    /// One pass of the program.
    pub fn run(&mut self) {
        if self.session.is_paused() {
            let ramping = self.session.state() == RunState::Stopping;
            if ramping && self.motor.rests() && !self.trace.full && self.line_rests {
                self.rested();
            } else if ramping && self.seeks() {
                // What it looks for may come on the way to rest, too.
                self.go_on();
            }
            return;
        }
        if !self.session.executes() {
            if !self.session.is_active() && self.effect.code != 0 {
                self.direct_effect();
            }
            return;
        }
        // The handler comes over the link.
        #[cfg(feature = "stream")]
        if crate::stream::waits() {
            return;
        }
        if self.motor.take_limited() != 0 {
            let pc = if self.effect.code != 0 { self.effect_pc } else { vm().pc };
            self.raise(Fault::SoftLimit, pc, true);
            return;
        }
        if let Some((fault, pc)) = self.late {
            if self.motor.path_rests() {
                self.late = None;
                self.raise(fault, pc, false);
            }
            return;
        }
        self.pulse_over();
        if self.effect.code == 0 {
            self.step();
        }
        self.go_on();
    }

    /// Goes on with the effect under way, if there is one.
    fn go_on(&mut self) {
        // A line longer than the ring was announced by the event that fills the slot, and the host
        // takes it before it asks for the next one.
        const PRINTS: ::core::ops::RangeInclusive<u8> = Op::PrintText as u8..=Op::PrintEnd as u8;
        let free = !self.trace.full || self.announced && PRINTS.contains(&self.effect.code);
        if self.effect.code != 0 && free {
            match self.perform() {
                Ok(true) => {
                    self.forget();
                    self.serve();
                }
                Ok(false) => self.serve(),
                Err(fault) => {
                    let pc = self.effect_pc;
                    self.found(fault, pc);
                }
            }
        }
    }

    /// Goes on with a homing or probing command.
    fn direct_effect(&mut self) {
        let result = self.perform();
        if let Ok(false) = result {
            return;
        }
        if result.is_err() {
            let bit = 1 << self.effect.n;
            if self.effect.code == Op::Probe as u8 {
                self.probe_error |= bit;
            } else {
                self.homing_error |= bit;
            }
        }
        self.forget();
    }

    fn rested(&mut self) {
        self.save();
        let stopped = self.session.rested();
        let states = match stopped {
            None => self.record.pause,
            Some(End::Fault) => self.record.fault,
            Some(_) => self.record.end,
        };
        self.resume_outputs = self.outputs;
        self.outputs = self.outputs & states.keep | states.on;
        if let Some(end) = stopped {
            crate::boot::mark(false);
            if let End::Fault = end {
                self.log();
            }
            if end as u8 == End::Fault as u8 {
                self.effect_pc = vm().fault_pc;
            } else if end as u8 != End::Done as u8 && self.effect.code == 0 {
                self.effect_pc = vm().pc;
            }
            self.emit(TraceKind::End, end as u8, i32::from(self.session.fault()));
            self.forget();
            // A streamed run leaves what is stored, or nothing.
            self.session.stored(self.store.image().is_some());
        }
    }

    /// The last fault with its place and input survives power-off.
    fn log(&mut self) {
        let pc = vm().fault_pc.wrapping_sub(vm().code);
        let number = u16::from(self.session.fault());
        crate::boot::log([number | u16::from(self.fault_input) << 8, pc, vm().line(vm().fault_pc)]);
    }

    /// Lets the VM run to its next effect, or for a slice.
    fn step(&mut self) {
        vm().poll = 0;
        let exit = vm_core::run();
        let vm = vm();
        // Codes above a byte leave the core between two instructions.
        // Behind an instruction, and behind the wait that a handler goes back to.
        let behind = exit <= 0xFF || exit == vm_core::HANDLER_END;
        self.effect_pc = vm.pc.wrapping_sub(u16::from(behind));
        match exit {
            vm_core::YIELD => self.serve(),
            vm_core::HANDLER_END => {
                vm.flags &= !flag::EVENT;
                self.handler_left();
            }
            #[cfg(feature = "stream")]
            0 if crate::stream::follow(self) => {
                if crate::stream::is_dry() {
                    self.serve();
                }
            }
            0 => self.effect.code = END,
            FIRST_EFFECT..=0xFF => {
                let more = vm.flags & flag::MORE != 0;
                vm.flags &= !(flag::MORE | flag::WITHIN);
                if more {
                    vm.flags |= flag::WITHIN;
                }
                self.effect.code = exit as u8;
            }
            0x01..FIRST_EFFECT => match vm.soft(exit as u8) {
                Ok(false) => {}
                // A GOTO left the error handler and with it what it had interrupted.
                Ok(true) if exit as u8 == Op::Leave as u8 => {
                    self.outer = Effect::NONE;
                    self.serve();
                }
                Ok(true) => self.handler_left(),
                Err(fault) => self.found(fault, vm.pc.wrapping_sub(1)),
            },
            _ => {
                let fault = Fault::from_number(exit as u8).unwrap_or(Fault::ImageRefused);
                self.found(fault, vm.pc.wrapping_sub(1));
            }
        }
    }

    fn handler_left(&mut self) {
        let open = handlers();
        self.feed = self.feeds_aside[open & 1];
        if open == 0 {
            self.effect = self.outer;
            self.outer = Effect::NONE;
        }
        // A wait that was interrupted may be over: then that comes first.
        if self.effect.code == 0 {
            self.serve();
        }
    }

    /// Begins the handler of the first event that has come, between statements and in waits.
    fn serve(&mut self) {
        let vm = vm();
        // Never inside a move: only waits are interrupted, once they have begun.
        const WAITS: [u8; 7] = [
            0,
            PULSE,
            Op::Wait as u8,
            Op::WaitIn as u8,
            Op::WaitChar as u8,
            Op::WaitStart as u8,
            Op::WaitMove as u8,
        ];
        let code = self.effect.code;
        let waits = WAITS.iter().any(|&wait| wait == code);
        if !vm.can_interrupt() || !waits || (code != 0 && self.effect.phase == 0) {
            return;
        }
        let mut slot = 0;
        while slot < self.events.len() {
            let event = &mut self.events[slot];
            if event.kind & PENDING != 0 {
                event.kind &= !PENDING;
                self.outer = self.effect;
                self.outer_pc = self.effect_pc;
                self.forget();
                self.put_feed_aside(0);
                #[cfg(feature = "stream")]
                if crate::stream::owns() {
                    vm.flags |= flag::EVENT;
                    let place = if code == 0 { Called::Behind } else { Called::Within };
                    crate::stream::call(place, slot as u8, 0);
                    return;
                }
                if !vm.interrupt(slot as u8) {
                    self.raise(Fault::Stack, vm.pc, true);
                }
                return;
            }
            slot += 1;
        }
    }

    /// Milliseconds that have passed since the last call, one by one.
    pub fn ticks(&mut self) {
        let late = link::millis().wrapping_sub(self.tick);
        if late == 0 {
            return;
        }
        if late > 2 {
            self.missed = self.missed.wrapping_add(late - 2);
        }
        self.tick = self.tick.wrapping_add(1);
        self.millisecond();
    }

    /// Outputs as they go out: a laser is off whenever nothing moves, and on for as much of the time
    /// as its power is of the full one. Milliseconds that come late are as long as they were.
    fn levels(&mut self) -> u16 {
        let laser = self.record.laser;
        if laser == 0 {
            return self.outputs;
        }
        let now = crate::reg::timer0().tar.read().bits();
        let since = now.wrapping_sub(self.shone);
        self.shone = now;
        let was = core::mem::replace(&mut self.lit, false);
        if crate::step::is_running() {
            let power = self.motor.shine() as i16;
            let owed = if was { power - FULL_POWER as i16 } else { power };
            self.shine = (self.shine + i32::from(owed) * i32::from(since)).clamp(-MOST, MOST);
            self.lit = power != 0 && self.shine >= A_MILLISECOND;
        }
        if self.lit { self.outputs } else { self.outputs & !(1 << ((laser - 1) & 15)) }
    }

    fn millisecond(&mut self) {
        let before = self.inputs.levels();
        let levels = self.levels() ^ self.record.output_invert;
        let raw = if self.chained() { chain::exchange(levels) } else { chain::pins(levels) };
        let raw = raw ^ self.record.input_invert;
        self.raw = raw;
        self.limits();
        self.phase += 1;
        if self.phase * 4 >= self.record.filter {
            self.phase = 0;
            self.inputs.sample(raw);
            let pressed = self.buttons.accepted();
            // An input may be a second Start button.
            let second = u16::from(self.input(self.record.start)) << 1;
            self.buttons.sample(chain::buttons() | second);
            self.pressed(self.buttons.accepted() & !pressed);
            // Hold, door and a second Stop.
            if self.blocking() != 0 {
                self.control(Control::Pause);
            }
        }
        let now = self.inputs.levels();
        let probe = self.input(17);
        let probe_was = core::mem::replace(&mut self.probe, probe);
        let emergency = self.record.emergency;
        // Not filtered: a stop must not wait, and one too many does no harm.
        // An acknowledged fault can still be read: only one that is latched has been dealt with,
        // unless something moves all the same.
        let latched = self.session.state() as u8 == RunState::Fault as u8
            && self.session.fault() == Fault::EmergencyStop.number();
        let dealt_with = latched && self.motor.moving() == 0;
        if emergency != 0 && self.unfiltered(emergency) && !dealt_with {
            self.emergency(emergency);
        }
        if self.buttons.accepted() & 1 != 0 {
            self.held = self.held.saturating_add(1);
            if self.held == 2000 {
                let order = self.session.stop();
                self.obey(order);
            }
        } else {
            self.held = 0;
        }
        self.silence = self.silence.saturating_add(1);
        if self.jog && self.silence > SILENCE {
            self.jog = false;
            self.motor.stop(0b111);
        }
        // Once: the count stays at its end.
        if crate::streams() && self.silence == SILENCE + 1 && self.session.is_active() {
            self.fail(Fault::LinkLost);
        }
        if self.spin != 0 {
            self.spin -= 1;
            if self.spin == 0 {
                self.motor.pause(false);
            }
        }
        self.lamp();
        self.autorun();
        self.pulse_tick();
        if !self.session.is_active() {
            self.effect.count_down();
        }
        if self.session.executes() {
            self.timer = self.timer.wrapping_add(1);
            self.effect.count_down();
            self.outer.count_down();
            if self.timer as u16 % 1024 == 0 && self.motor.rests() && self.line_rests {
                self.save();
            }
        }
        let was = u32::from(before) | u32::from(probe_was) << 16;
        let is = u32::from(now) | u32::from(self.probe) << 16;
        self.listen(is & !was, was & !is);
    }

    /// A millisecond of the ON lines: inputs that went on and off, input n in bit n - 1. Edges in a
    /// pause are remembered, the clocks of ON EVERY stand still.
    fn listen(&mut self, rose: u32, fell: u32) {
        let executes = self.session.executes();
        for event in &mut self.events {
            let edges = match event.kind & !PENDING {
                1 => rose,
                2 => fell,
                3 if executes => {
                    event.left -= 1;
                    if event.left > 0 {
                        continue;
                    }
                    event.left = event.period;
                    event.kind |= PENDING;
                    continue;
                }
                _ => continue,
            };
            if edges >> ((event.n - 1) & 31) & 1 != 0 {
                event.kind |= PENDING;
            }
        }
    }

    /// A pulse ends in time even in a pause or while a handler runs.
    fn pulse_tick(&mut self) {
        for effect in [&mut self.effect, &mut self.outer] {
            if effect.code == PULSE && effect.phase == PULSE_BEGUN && effect.left > 0 {
                effect.left -= 1;
                if effect.left == 0 {
                    let bit = 1 << ((effect.n - 1) & 15);
                    self.outputs &= !bit;
                    self.resume_outputs &= !bit;
                }
            }
        }
    }

    /// A pulse that ended while a handler runs is told before the handler does anything more.
    fn pulse_over(&mut self) {
        let pulse = &mut self.outer;
        if pulse.code != PULSE || pulse.phase != PULSE_BEGUN || pulse.left != 0 || self.trace.full {
            return;
        }
        pulse.phase += 1;
        let n = pulse.n;
        let pc = core::mem::replace(&mut self.effect_pc, self.outer_pc);
        self.emit(TraceKind::Out, n, 0);
        self.effect_pc = pc;
    }

    /// The status lamp: off without a program, lit when ready, blinking slowly in a run and fast in
    /// a pause, a fault's number in blinks.
    fn lamp(&mut self) {
        let n = self.record.lamp;
        if n == 0 {
            return;
        }
        self.blink = self.blink.wrapping_add(1);
        let on = match self.session.state() {
            RunState::Empty => false,
            RunState::Ready => true,
            RunState::Running | RunState::WaitStart => self.blink & 512 != 0,
            RunState::Paused | RunState::Stopping => self.blink & 128 != 0,
            RunState::Fault => {
                let blinks = u16::from(self.session.fault());
                if self.blink >= (blinks + 4) * 256 {
                    self.blink = 0;
                }
                self.blink < blinks * 256 && self.blink & 128 != 0
            }
        };
        self.set_output(u16::from(n), on);
    }

    /// Auto-run half a second after power-up, unless a host has spoken or Stop is held.
    fn autorun(&mut self) {
        if self.tick != 500 || self.booted {
            return;
        }
        self.booted = true;
        let wanted = self.record.flags & BoardRecord::AUTORUN != 0 && self.bites < BITES;
        if wanted && !self.host && !self.blocked() {
            // The first start acknowledges what a watchdog reset has latched.
            if self.bites != 0 && self.session.state() as u8 == RunState::Fault as u8 {
                self.control(Control::Start);
            }
            self.control(Control::Start);
        }
    }

    fn pressed(&mut self, keys: u16) {
        if keys & 1 != 0 {
            self.control(Control::Pause);
        }
        if keys & 2 != 0 {
            self.control(Control::Start);
        }
    }
}
