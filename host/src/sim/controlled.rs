//! The machine that an engine drives: the firmware's own ([`super::native`]), or a model of it ([`super::machine`]), which
//! follows the MSP430G2553, too.

use lang::effect::Effect;
use lang::fault::Fault;
#[cfg(feature = "desktop")]
use lang::part::F5529;
use lang::profile::Profile;

use super::machine::Machine as Model;
#[cfg(feature = "desktop")]
use super::native::Native;
use super::record::{Record, Summary};
use super::step::Step;
use super::unattended::Unattended;
use super::view::View;
use super::world::{Registers, World};
use super::{End, Options, Rules, SimError, Sink};
use crate::course::LineEnds;
use crate::scene::Report;

/// See the module.
pub enum Machine {
    /// The firmware's machine.
    #[cfg(feature = "desktop")]
    Native(Box<Native>),
    /// The model.
    Model(Box<Model>),
}

/// The same of whichever it is.
macro_rules! of_each {
    ($own:expr, $machine:ident => $what:expr) => {
        match $own {
            #[cfg(feature = "desktop")]
            Machine::Native($machine) => $what,
            Machine::Model($machine) => $what,
        }
    };
}

/// The firmware's machine, which is the MSP430F5529's alone.
#[cfg(feature = "desktop")]
fn firmware(
    profile: &Profile,
    world: &World,
    options: &Options,
    texts: Vec<String>,
    registers: &Registers,
    sink: Sink,
) -> Result<Machine, SimError> {
    if options.part.name != F5529.name {
        return Err(SimError::Engine(format!(
            "the firmware's rules are those of the {}, and the run is to show the times of the {}: run it with the \
             model's rules, or on the emulated board (`--engine board`)",
            F5529.name, options.part.name
        )));
    }
    let own = Native::new(profile, world, options, texts, registers, sink)?;
    Ok(Machine::Native(Box::new(own)))
}

/// Without the feature `desktop` there is no chip for the firmware's machine.
#[cfg(not(feature = "desktop"))]
fn firmware(
    _: &Profile,
    _: &World,
    _: &Options,
    _: Vec<String>,
    _: &Registers,
    _: Sink,
) -> Result<Machine, SimError> {
    Err(SimError::Engine("this build has the model's rules only".to_owned()))
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
        if options.rules == Rules::Firmware {
            return firmware(profile, world, options, texts, registers, sink);
        }
        let own = Model::new(profile, world, options, texts, registers, sink)?;
        Ok(Machine::Model(Box::new(own)))
    }

    /// Lines end as slow points say, one after the other.
    pub fn set_ends(&mut self, ends: Option<LineEnds>) {
        match self {
            #[cfg(feature = "desktop")]
            Machine::Native(_) => {}
            Machine::Model(own) => own.set_ends(ends),
        }
    }

    /// `count` statements without effects are about to run.
    pub fn pass(&mut self, count: u32) {
        of_each!(self, own => own.pass(count));
    }

    /// Whether the program has a handler for errors from now on.
    #[cfg_attr(
        not(feature = "desktop"),
        expect(unused_variables, reason = "the model asks the engine")
    )]
    pub fn set_handled(&mut self, on: bool) {
        match self {
            #[cfg(feature = "desktop")]
            Machine::Native(own) => own.set_handled(on),
            Machine::Model(_) => {}
        }
    }

    /// Whether there is something for [`Machine::look`].
    pub fn needs_attention(&self) -> bool {
        of_each!(self, own => own.needs_attention())
    }

    /// Line of the statement that runs: what follows is its doing.
    pub fn set_line(&mut self, line: u32) {
        of_each!(self, own => own.set_line(line));
    }

    /// Simulated time, us.
    pub fn now_us(&self) -> u64 {
        of_each!(self, own => own.now_us())
    }

    /// Line of the statement that runs.
    pub fn line(&self) -> u32 {
        of_each!(self, own => own.line())
    }

    /// Looks at everything that may come between two statements.
    pub fn look(&mut self) -> Step {
        of_each!(self, own => own.look())
    }

    /// Carries out an effect to its end or to the first event during its wait.
    pub fn begin(&mut self, effect: &Effect) -> Step {
        of_each!(self, own => own.begin(effect))
    }

    /// A text of PRINT that is in no list.
    pub fn print_text(&mut self, text: &str) {
        of_each!(self, own => own.print_text(text));
    }

    /// Whether the wait that begins now lets no handler come between: it is a part of a larger statement.
    pub fn hold_events(&mut self, hold: bool) {
        of_each!(self, own => own.hold_events(hold));
    }

    /// A handler, of an event or of errors, begins.
    pub fn enter_handler(&mut self) {
        match self {
            // It has begun it itself.
            #[cfg(feature = "desktop")]
            Machine::Native(_) => {}
            Machine::Model(own) => own.enter_handler(),
        }
    }

    /// A handler has ended; `open` says whether another one is still open below it.
    pub fn leave_handler(&mut self, open: bool) {
        match self {
            #[cfg(feature = "desktop")]
            Machine::Native(own) => own.leave_handler(),
            Machine::Model(own) => own.leave_handler(open),
        }
    }

    /// A GOTO left every handler: what they interrupted is dropped.
    pub fn leave_all(&mut self) {
        of_each!(self, own => own.leave_all());
    }

    /// Goes on with the innermost wait after an event handler.
    pub fn resume(&mut self) -> Step {
        of_each!(self, own => own.resume())
    }

    /// A fault is about to be handled, or to end the run. Gives the fault to report: an emergency stop on the way comes
    /// first.
    pub fn ramp_down(&mut self, fault: Fault) -> Fault {
        of_each!(self, own => own.ramp_down(fault))
    }

    /// Whether the run is over whatever the program wants.
    pub fn is_halted(&self) -> bool {
        of_each!(self, own => own.is_halted())
    }

    /// The engine has executed as many statements as it may.
    pub fn give_up(&mut self) {
        of_each!(self, own => own.give_up());
    }

    /// END: STARTed moves come to their ends, MoveSpeed axes ramp down.
    pub fn end(&mut self) -> Step {
        of_each!(self, own => own.end())
    }

    /// RUN of the program of this name, if there is one. `shown` tells whether the other one is the program whose lines
    /// the record has.
    pub fn run_other(&mut self, name: Option<&String>, shown: bool) -> Step {
        of_each!(self, own => own.run_other(name, shown))
    }

    /// The other program begins: what belongs to a run is as at its start; places and what is homed stay.
    pub fn set_out_anew(&mut self, texts: Vec<String>, registers: &Registers) {
        of_each!(self, own => own.set_out_anew(texts, registers));
    }

    /// Ends the run: `fault` is the program's, `None` its END or whatever stopped it. `line` is that of the statement
    /// under way.
    ///
    /// # Errors
    /// The world's script failed on the way.
    pub fn finish(&mut self, fault: Option<Fault>, line: u32) -> Result<End, SimError> {
        of_each!(self, own => own.finish(fault, line))
    }

    /// Closes the books: the numbers of the run, the record, and what the world expected in vain.
    pub fn results(&mut self, end: &End) -> (Summary, Record, Vec<String>) {
        of_each!(self, own => own.results(end))
    }

    /// What the run did that nobody told it, in a world of nobody.
    pub fn unattended(&self) -> Unattended {
        of_each!(self, own => own.unattended())
    }

    /// What the cell around it gives, if there is one.
    #[cfg_attr(not(feature = "desktop"), expect(unused_variables, reason = "the model has none"))]
    pub fn report(&mut self, end: &End) -> Option<Report> {
        match self {
            #[cfg(feature = "desktop")]
            Machine::Native(own) => own.report(end),
            Machine::Model(_) => None,
        }
    }

    /// What can be seen of it now.
    pub fn view(&self) -> View {
        of_each!(self, own => own.view())
    }
}
