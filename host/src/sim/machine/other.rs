//! RUN: one program ends and another begins, on the same machine and in the same time.

use lang::axis::Axis;
use lang::fault::Fault;

use super::Machine;
use super::events::Events;
use super::modal::Modal;
use super::print::Print;
use crate::sim::step::Step;
use crate::sim::trace::What;
use crate::sim::world::Registers;

impl Machine {
    /// RUN of the program of this name, if there is one: everything comes to rest and the outputs take their states as
    /// behind END. `shown` tells whether the other one is the program whose lines the record has.
    pub fn run_other(&mut self, name: Option<&String>, shown: bool) -> Step {
        if self.end() == Step::Stop {
            return Step::Stop;
        }
        let Some(name) = name else { return Step::Fault(Fault::NoProgram) };
        self.outputs.safe(false);
        self.outputs_changed();
        let line = self.line;
        self.write(What::Run { line, program: name.clone() });
        self.log.turn(self.clock.now(), (!shown).then_some(line));
        if self.is_halted() { Step::Stop } else { Step::Done(0) }
    }

    /// The other program begins: what belongs to a run is as at its start; places and what is homed stay.
    pub fn set_out_anew(&mut self, texts: Vec<String>, registers: &Registers) {
        for axis in Axis::ALL {
            self.axes.begin_run(axis);
        }
        self.modal = Modal::new(&self.profile);
        self.events = Events::default();
        self.events.attention = true;
        self.waits.drop_all();
        self.waits.timed_out = false;
        self.print = Print::new(texts);
        self.pause.program_us = self.run_clock();
        self.scenario.set_registers(registers);
        self.clock.look_anew();
    }
}
