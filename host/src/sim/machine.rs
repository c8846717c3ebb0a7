//! The simulated machine: carries out [`Effect`]s in simulated microseconds against a world.
//!
//! An engine calls [`Machine::statement`] before each statement and [`Machine::begin`] for each
//! effect; both come back with a [`Step`]. The machine decides when an event handler is due, when
//! a pause holds everything, and when the run is over; the engine owns the control flow.

pub(crate) mod axes;
mod clock;
mod inputs;
mod log;
mod motion;
mod moves;
mod outputs;
mod path;
mod perform;
mod seek;
mod view;
mod waits;

#[cfg(test)]
mod tests;

use lang::axis::Axis;
use lang::effect::{Effect, Rate};
use lang::fault::Fault;
use lang::profile::Profile;
use lang::record::MachineRecord;

use self::axes::Axes;
pub use self::axes::scaled;
use self::inputs::{Inputs, Plant};
use self::log::Log;
use self::motion::Motion;
use self::moves::Pieces;
use self::outputs::Outputs;
use self::seek::Seek;
pub use self::view::{AxisView, View};
use self::waits::{Slot, Wait};
use super::record::StopReason;
use super::trace::{PerAxis, Status, What};
use super::unattended::Unattended;
use super::world::{Registers, Scenario, World, WorldError};
use super::{End, Options, SimError, Sink};

/// Simulated time that a statement takes, us (lang/README.md, The machine).
pub const STATEMENT_US: u64 = 20;

/// What an engine does next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Go on; the value of a [`Effect::Read`], else 0.
    Done(i32),
    /// Serve the handler of this event slot, then the statement that was about to run, or
    /// [`Machine::resume`] when it came from a wait.
    Event(u8),
    /// The statement failed.
    Fault(Fault),
    /// A fault that came by itself (MoveSpeed at a soft limit): ERL is the statement about to run
    /// or waiting, and RESUME NEXT goes on with it.
    Late(Fault),
    /// The run is over; call [`Machine::finish`].
    Stop,
}

/// Why the run is over although the program has not ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Halt {
    /// The run was stopped.
    Stopped(StopReason),
    /// A fault that no handler may take.
    Fault(Fault),
}

/// See the module.
pub struct Machine {
    profile: Profile,
    scenario: Scenario,
    log: Log,
    motion: Motion,
    axes: Axes,
    plant: Plant,
    inputs: Inputs,
    outputs: Outputs,
    /// Simulated time, us.
    now: u64,
    /// When something happens next; 0 when that must be found out.
    next: u64,
    limit: u64,
    statements: u64,
    line: u32,
    feed: Option<Rate>,
    /// S, a laser's power.
    power: i32,
    feeds_aside: Vec<Option<Rate>>,
    handler: bool,
    held: bool,
    slots: [Option<Slot>; 4],
    waits: Vec<Wait>,
    timed_out: bool,
    /// Time of a statement, us.
    statement_us: u64,
    /// Blocks of a path run into one another.
    look_ahead: bool,
    char_in: i32,
    print: String,
    texts: Vec<String>,
    late: Option<Fault>,
    halt: Option<Halt>,
    stopped: Option<StopReason>,
    interrupted: fn() -> bool,
    /// Something but the clock must be looked at before the next statement.
    attention: bool,
    /// Line of the path's block that a fault has cut.
    cut: Option<u32>,
    paused_since: Option<u64>,
    paused_us: u64,
    outputs_paused: bool,
    resume_at: Option<u64>,
    stop_held_since: Option<u64>,
    start_presses: u64,
    /// Lines whose wait for Start an unattended world ended.
    released: Vec<u32>,
    started: bool,
    world_error: Option<WorldError>,
    pieces: Pieces,
    seek: Option<Seek>,
    homing_axis: Option<Axis>,
}

impl Machine {
    /// A machine at power-up; `texts` are those of PRINT, by index, `registers` the AT variables.
    ///
    /// # Errors
    /// The world's script fails at its start.
    pub fn new(
        profile: &Profile,
        world: &World,
        options: &Options,
        texts: Vec<String>,
        registers: &Registers,
        sink: Sink,
    ) -> Result<Machine, SimError> {
        let scenario = world.start(registers)?;
        let record = MachineRecord::of(profile);
        let mut machine = Machine {
            plant: Plant::new(profile, &record, &scenario),
            motion: Motion::new(record.axes, record.corner, options.part),
            axes: Axes::new(profile, &record),
            inputs: Inputs::new(profile),
            outputs: Outputs::new(profile),
            log: Log::new(options, record.axes, sink),
            profile: profile.clone(),
            scenario,
            now: 0,
            next: 0,
            limit: options.limit_us,
            statement_us: options.statement_us,
            look_ahead: options.part.look_ahead,
            statements: 0,
            line: 1,
            feed: None,
            power: profile.full_power(),
            feeds_aside: Vec::new(),
            handler: false,
            held: false,
            slots: [None; 4],
            waits: Vec::new(),
            timed_out: false,
            char_in: 0,
            print: String::new(),
            texts,
            late: None,
            halt: None,
            stopped: None,
            interrupted: options.interrupted,
            attention: false,
            cut: None,
            paused_since: None,
            paused_us: 0,
            outputs_paused: false,
            resume_at: None,
            stop_held_since: None,
            start_presses: 0,
            released: Vec::new(),
            started: false,
            world_error: None,
            pieces: Pieces::default(),
            seek: None,
            homing_axis: None,
        };
        machine.process();
        machine.inputs.settle();
        for n in machine.inputs.on() {
            machine.log.input(0, n, true);
        }
        Ok(machine)
    }

    /// A statement of `line` is about to run.
    pub fn statement(&mut self, line: u32) -> Step {
        self.set_line(line);
        self.pass(1);
        if self.needs_attention() { self.look() } else { Step::Done(0) }
    }

    /// `count` statements without effects are about to run.
    pub fn pass(&mut self, count: u32) {
        self.statements += u64::from(count);
        if !self.started {
            self.started = true;
            return;
        }
        let to = self.now + self.statement_us * u64::from(count);
        if to < self.next {
            self.now = to;
        } else {
            self.advance_to(to);
        }
    }

    /// Whether there is something for [`Machine::look`].
    pub fn needs_attention(&self) -> bool {
        self.attention || self.next == 0
    }

    /// Line of the statement that runs: what follows is its doing.
    pub fn set_line(&mut self, line: u32) {
        self.line = line;
        self.log.begin(self.now, line);
    }

    /// Simulated time, us.
    pub fn now_us(&self) -> u64 {
        self.now
    }

    /// Line of the statement that runs.
    pub fn line(&self) -> u32 {
        self.line
    }

    /// The engine has executed as many statements as it may.
    pub fn give_up(&mut self) {
        self.halt = Some(Halt::Stopped(StopReason::Statements));
        self.attention = true;
    }

    /// Ends the run when its user wants that.
    fn look_for_interruption(&mut self) {
        if self.halt.is_none() && (self.interrupted)() {
            self.halt = Some(Halt::Stopped(StopReason::Interrupted));
            self.attention = true;
        }
    }

    /// Looks at everything that may come between two statements.
    pub fn look(&mut self) -> Step {
        loop {
            self.find_next();
            if self.halt.is_some() {
                return Step::Stop;
            }
            if self.paused_since.is_some() {
                self.tick(None);
                continue;
            }
            if self.handler || self.held {
                break;
            }
            let Some(step) = self.interruption() else { break };
            // A handler acts on the machine: the path's end comes first.
            if self.motion.is_path_idle() {
                if let Step::Event(slot) = step {
                    self.take_event(slot);
                }
                if let Step::Late(_) = step {
                    self.late = None;
                }
                return step;
            }
            self.tick(None);
        }
        self.attention = self.halt.is_some()
            || self.paused_since.is_some()
            || self.late.is_some()
            || self.pending_slot().is_some();
        Step::Done(0)
    }

    /// What asks for a handler.
    fn interruption(&self) -> Option<Step> {
        self.late.map(Step::Late).or_else(|| self.pending_slot().map(Step::Event))
    }

    /// Carries out an effect to its end or to the first event during its wait.
    pub fn begin(&mut self, effect: &Effect) -> Step {
        let result = self.execute(effect);
        self.next = 0;
        match (self.halt, result) {
            (Some(_), _) => Step::Stop,
            (None, Ok(step)) => step,
            (None, Err(fault)) => Step::Fault(fault),
        }
    }

    /// A text of PRINT that is in no list.
    pub fn print_text(&mut self, text: &str) {
        self.print.push_str(text);
    }

    /// Whether the wait that begins now lets no handler come between: it is a part of a larger
    /// statement.
    pub fn hold_events(&mut self, hold: bool) {
        self.held = hold;
        self.attention = true;
    }

    /// A handler, of an event or of errors, begins.
    pub fn enter_handler(&mut self) {
        self.handler = true;
        self.feeds_aside.push(self.feed.take());
    }

    /// A handler has ended; `open` says whether another one is still open below it.
    pub fn leave_handler(&mut self, open: bool) {
        if let Some(feed) = self.feeds_aside.pop() {
            self.feed = feed;
        }
        self.handler = open;
        self.attention = true;
    }

    /// A GOTO left every handler: what they interrupted is dropped.
    pub fn leave_all(&mut self) {
        self.feeds_aside.clear();
        self.waits.clear();
        self.handler = false;
        self.attention = true;
    }

    /// A fault is about to be handled, or to end the run: the path comes to its end and every
    /// other axis ramps down. Gives the fault to report: an emergency stop on the way comes first.
    pub fn ramp_down(&mut self, fault: Fault) -> Fault {
        self.print.clear();
        self.sync_path();
        for axis in Axis::ALL {
            self.motion.stop(axis, self.now);
        }
        self.next = 0;
        while self.halt.is_none() && !self.all_rest() && self.tick(None) {}
        for axis in Axis::ALL {
            self.adopt(axis);
        }
        self.next = 0;
        match self.halt {
            Some(Halt::Fault(fault)) => fault,
            _ => fault,
        }
    }

    /// Whether the run is over whatever the program wants.
    pub fn is_halted(&self) -> bool {
        self.halt.is_some()
    }

    /// END: STARTed moves come to their ends, MoveSpeed axes ramp down.
    pub fn end(&mut self) -> Step {
        self.sync_path();
        for axis in Axis::ALL {
            if self.axes.is_running(axis) {
                self.motion.stop(axis, self.now);
            }
        }
        self.next = 0;
        while self.halt.is_none() && !self.all_rest() && self.tick(None) {}
        if self.halt.is_some() { Step::Stop } else { Step::Done(0) }
    }

    /// Ends the run: `fault` is the program's, `None` its END or whatever stopped it. `line` is that of the
    /// statement under way; what cuts a path does so in the line of the block that plays.
    ///
    /// # Errors
    /// The world's script failed on the way.
    pub fn finish(&mut self, fault: Option<Fault>, line: u32) -> Result<End, SimError> {
        if let Some(error) = self.world_error.take() {
            return Err(error.into());
        }
        let (status, fault) = match (self.halt, fault) {
            (Some(Halt::Fault(fault)), _) | (None, Some(fault)) => (Status::Fault, Some(fault)),
            (Some(Halt::Stopped(reason)), _) => {
                self.stopped = Some(reason);
                (Status::Stopped, None)
            }
            (None, None) => (Status::Done, None),
        };
        // What still moves after a stop ramps down before the outputs take their end states.
        if !self.motion.stands() {
            self.halt = None;
            self.limit = u64::MAX;
            self.motion.pause(true, self.now);
            while !self.motion.stands() {
                let Some(at) = self.motion.next_us() else { break };
                self.now = self.now.max(at);
                self.motion.advance(self.now);
            }
            self.log_milestones();
        }
        let line = self.cut.or(self.pieces.line).unwrap_or(line);
        self.motion.forget(self.now);
        self.log_milestones();
        self.outputs.safe(status == Status::Fault);
        self.outputs_changed();
        let pos = self.steps();
        self.write(What::end(status, fault, line, pos));
        self.log.close(self.now, &self.outputs);
        Ok(End { status, fault, line })
    }

    /// Where the axes are, steps.
    fn steps(&self) -> PerAxis {
        self.axes.named(self.motion.positions(self.now))
    }

    /// Commanded targets of all axes, steps.
    fn targets(&self) -> PerAxis {
        let at = self.motion.positions(self.now);
        let mut to = [0; 3];
        for axis in Axis::ALL {
            to[axis.index()] =
                if self.axes.is_running(axis) { at[axis.index()] } else { self.axes.steps(axis) };
        }
        self.axes.named(to)
    }

    fn write(&mut self, what: What) {
        self.log.write(self.now, what);
        self.look_for_interruption();
    }

    /// What the run did that nobody told it, with [`World::unattended`].
    pub fn unattended(&self) -> Unattended {
        if !self.scenario.is_unattended() {
            return Unattended::default();
        }
        Unattended {
            released: self.released.clone(),
            reached: Axis::ALL.map(|axis| self.plant.reached(axis)),
            switches: Axis::ALL.map(|axis| self.plant.switch_place(axis, &self.scenario)),
        }
    }

    /// Closes the books: the numbers of the run, the record, and what the world expected in vain.
    pub fn results(
        &mut self,
        end: &End,
    ) -> (super::record::Summary, super::record::Record, Vec<String>) {
        let pos = self.steps();
        let failures = self.scenario.failures(&|n| self.outputs.read(n).unwrap_or(false), &pos);
        let travelled = self.motion.travelled;
        let (summary, record) =
            self.log.results(end, self.stopped, self.now, self.statements, travelled);
        (summary, record, failures)
    }
}
