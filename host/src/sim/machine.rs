//! The MSP430G2553's machine, as a model: carries out [`Effect`]s in simulated microseconds against a world. Times are
//! those of that chip, which plans a line at a time. The MSP430F5529's firmware runs itself ([`super::native`]).
//!
//! An engine calls [`Machine::statement`] before each statement and [`Machine::begin`] for each
//! effect; both come back with a [`Step`]. The machine decides when an event handler is due, when
//! a pause holds everything, and when the run is over; the engine owns the control flow.

pub(crate) mod axes;
mod books;
mod buttons;
mod clock;
mod course;
mod ending;
mod events;
mod feel;
mod finish;
mod inputs;
mod modal;
mod motion;
mod moves;
mod operate;
mod other;
mod outputs;
mod path;
mod pause;
mod perform;
mod pieces;
mod plant;
mod print;
mod search;
mod seek;
mod view;
mod wait;
mod waits;

#[cfg(test)]
mod tests;

use lang::axis::Axis;
use lang::effect::Effect;
use lang::profile::Profile;
use lang::record::MachineRecord;

use self::axes::Axes;
pub use self::axes::scaled;
use self::buttons::Buttons;
use self::clock::Clock;
use self::ending::Ending;
use self::events::Events;
use self::inputs::Inputs;
use self::modal::Modal;
use self::motion::Motion;
use self::outputs::Outputs;
use self::pause::Pause;
use self::pieces::Pieces;
use self::plant::Plant;
use self::print::Print;
use self::search::Search;
use self::waits::Waits;
use super::log::Log;
use super::step::Step;
use super::trace::{PerAxis, What};
use super::unattended::Unattended;
use super::world::{Registers, Scenario, World};
use super::{End, Options, SimError, Sink};

/// Statements between two questions whether the user wants an end.
const QUESTION: u64 = 4_096;

/// See the module.
pub struct Machine {
    profile: Profile,
    scenario: Scenario,
    log: Log,
    clock: Clock,
    /// Line of the statement that runs.
    line: u32,
    modal: Modal,
    events: Events,
    waits: Waits,
    print: Print,
    pause: Pause,
    buttons: Buttons,
    ending: Ending,
    motion: Motion,
    axes: Axes,
    pieces: Pieces,
    search: Search,
    plant: Plant,
    inputs: Inputs,
    outputs: Outputs,
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
            log: Log::new(options, record.axes, sink),
            clock: Clock::new(options),
            line: 1,
            modal: Modal::new(profile),
            events: Events::default(),
            waits: Waits::default(),
            print: Print::new(texts),
            pause: Pause::default(),
            buttons: Buttons::default(),
            ending: Ending::new(options.interrupted),
            motion: Motion::new(record.axes, record.corner, options.part),
            axes: Axes::new(profile, &record, options.part.renews()),
            pieces: Pieces::default(),
            search: Search::default(),
            plant: Plant::new(profile, &record, &scenario),
            inputs: Inputs::new(profile),
            outputs: Outputs::new(profile),
            profile: profile.clone(),
            scenario,
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
        let asked = self.clock.statements() / QUESTION;
        if let Some(to) = self.clock.pass(count) {
            self.advance_to(to);
        }
        // Where nothing happens nobody else looks.
        if self.clock.statements() / QUESTION != asked {
            self.look_for_interruption();
        }
    }

    /// Whether there is something for [`Machine::look`].
    pub fn needs_attention(&self) -> bool {
        self.events.attention || self.clock.is_unsure()
    }

    /// Line of the statement that runs: what follows is its doing.
    pub fn set_line(&mut self, line: u32) {
        self.line = line;
        self.log.begin(self.clock.now(), line);
    }

    /// Simulated time, us.
    pub fn now_us(&self) -> u64 {
        self.clock.now()
    }

    /// Line of the statement that runs.
    pub fn line(&self) -> u32 {
        self.line
    }

    /// Looks at everything that may come between two statements.
    pub fn look(&mut self) -> Step {
        loop {
            self.find_next();
            if self.is_halted() {
                return Step::Stop;
            }
            if self.pause.is_on() {
                self.tick(None);
                continue;
            }
            if !self.events.may_interrupt() {
                break;
            }
            let Some(step) = self.events.interruption() else { break };
            // A handler acts on the machine: the path's end comes first.
            if self.motion.is_path_idle() {
                self.events.take(step);
                return step;
            }
            self.tick(None);
        }
        self.events.attention = self.is_halted()
            || self.pause.is_on()
            || self.events.late.is_some()
            || self.events.pending_slot().is_some();
        Step::Done(0)
    }

    /// Carries out an effect to its end or to the first event during its wait.
    pub fn begin(&mut self, effect: &Effect) -> Step {
        self.log.effect(Some((self.line, *effect)));
        let result = self.execute(effect);
        self.clock.look_anew();
        if self.is_halted() {
            return Step::Stop;
        }
        result.unwrap_or_else(Step::Fault)
    }

    /// A text of PRINT that is in no list.
    pub fn print_text(&mut self, text: &str) {
        self.print.push(text);
    }

    /// Whether the wait that begins now lets no handler come between: it is a part of a larger
    /// statement.
    pub fn hold_events(&mut self, hold: bool) {
        self.events.hold(hold);
    }

    /// A handler, of an event or of errors, begins.
    pub fn enter_handler(&mut self) {
        self.events.set_in_handler(true);
        self.modal.enter_handler();
    }

    /// A handler has ended; `open` says whether another one is still open below it.
    pub fn leave_handler(&mut self, open: bool) {
        self.modal.leave_handler();
        self.events.set_in_handler(open);
    }

    /// A GOTO left every handler: what they interrupted is dropped.
    pub fn leave_all(&mut self) {
        self.modal.leave_all();
        self.waits.drop_all();
        self.events.set_in_handler(false);
    }

    /// Where the axes are, steps.
    fn steps(&self) -> PerAxis {
        self.axes.named(self.motion.positions(self.clock.now()))
    }

    /// Commanded targets of all axes, steps.
    fn targets(&self) -> PerAxis {
        let at = self.motion.positions(self.clock.now());
        let mut to = [0; 3];
        for axis in Axis::ALL {
            to[axis.index()] =
                if self.axes.is_running(axis) { at[axis.index()] } else { self.axes.steps(axis) };
        }
        self.axes.named(to)
    }

    fn write(&mut self, what: What) {
        self.log.write(self.clock.now(), what);
        self.look_for_interruption();
    }

    /// What the run did that nobody told it, with [`World::unattended`].
    pub fn unattended(&self) -> Unattended {
        if !self.scenario.is_unattended() {
            return Unattended::default();
        }
        Unattended {
            released: self.waits.released.clone(),
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
        let (summary, record) = self.log.results(
            end,
            self.ending.stopped,
            self.clock.now(),
            self.clock.statements(),
            travelled,
        );
        (summary, record, failures)
    }
}
