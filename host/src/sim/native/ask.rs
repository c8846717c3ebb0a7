//! What an engine asks of the machine: effects, handlers and their ends, faults, the end of the program.

use lang::axis::Axis;
use lang::effect::{Effect, Unit};
use lang::fault::Fault;
use lang::isa::Op;
use lang::vm::encode::{Encoded, encode};
use lang::vm::entry;

use super::{Native, Request, Step, driven};
use crate::sim::record::StopReason;
use crate::sim::trace::What;
use crate::sim::world::Registers;

/// An instruction without values.
fn plain(code: &[u8], more: bool) -> Request {
    let mut bytes = [0; 4];
    bytes[..code.len()].copy_from_slice(code);
    Request::Code { code: bytes, length: code.len(), values: [0; 5], count: 0, more }
}

fn request(own: &Encoded, more: bool) -> Request {
    let mut values = [0; 5];
    values[..own.values().len()].copy_from_slice(own.values());
    let Request::Code { code, length, .. } = plain(own.code(), more) else {
        return plain(&[], more);
    };
    Request::Code { code, length, values, count: own.values().len(), more }
}

impl Native {
    /// Carries out an effect to its end or to the first event during its wait.
    pub fn begin(&mut self, effect: &Effect) -> Step {
        if self.is_halted() {
            return Step::Stop;
        }
        self.pressed = false;
        // Beside an axis that MoveSpeed runs nobody knows whose target a fault is about.
        let alone = self.board.controller().motor.running() == 0;
        self.log.effect(alone.then_some((self.line, *effect)));
        match *effect {
            Effect::EnterHandler | Effect::LeaveHandler | Effect::Keep { .. } => Step::Done(0),
            Effect::Run(_) => Step::Fault(Fault::NoProgram),
            Effect::PrintText(index) => match self.texts.get(usize::from(index)).cloned() {
                Some(text) => self.print(&text),
                None => Step::Done(0),
            },
            Effect::PrintValue(value, unit) if unit.decimals().is_some() => {
                self.print(&unit.show(value).to_string())
            }
            Effect::PrintValue(_, unit) => match self.ask_for(effect) {
                Step::Done(_) if unit != Unit::None => self.print(unit.suffix()),
                step => step,
            },
            Effect::Home { axis, .. } => {
                self.put_switch(axis);
                self.ask_for(effect)
            }
            _ => self.ask_for(effect),
        }
    }

    fn ask_for(&mut self, effect: &Effect) -> Step {
        let Some(own) = encode(effect) else { return Step::Fault(Fault::ImageRefused) };
        let waits = effect.waits() && !self.held;
        self.pieces.announce(effect, self.line, &self.board, &self.profile);
        self.board.desk().ask(request(&own, !waits));
        let step = self.until_done();
        match (effect, step) {
            (Effect::Read(_), Step::Done(_)) => Step::Done(self.board.controller_mut().vm.pop()),
            _ => step,
        }
    }

    /// A text of PRINT that is in no list.
    pub fn print_text(&mut self, text: &str) {
        self.print(text);
    }

    fn print(&mut self, text: &str) -> Step {
        for part in text.as_bytes().chunks(driven::LONGEST_TEXT) {
            let offset = self.board.desk().put_text(part).to_le_bytes();
            let code = [Op::PrintTextFar.code(), offset[0], offset[1]];
            self.board.desk().ask(plain(&code, true));
            let step = self.until_done();
            if !matches!(step, Step::Done(_)) {
                return step;
            }
        }
        Step::Done(0)
    }

    /// The axis is about to be homed: a switch that was out of the way stands 20 mm beyond all that the axis has reached.
    fn put_switch(&mut self, axis: Axis) {
        let i = axis.index();
        if !self.scene.scenario.is_unattended() || self.board.plant().switches[i].is_some() {
            return;
        }
        while !self.is_halted() && !self.board.controller().motor.path_rests() {
            self.turn_idle();
        }
        let away = self.scene.away(axis);
        let [least, greatest] = self.reached[i];
        let place = away + if away < 0 { least } else { greatest };
        self.scene.put_switch(axis, Some(place), &mut self.board.plant_mut());
    }

    /// Whether the wait that begins now lets no handler come between: it is a part of a larger statement.
    pub fn hold_events(&mut self, hold: bool) {
        self.held = hold;
    }

    /// Goes on with the innermost wait after an event handler.
    pub fn resume(&mut self) -> Step {
        if self.is_halted() {
            return Step::Stop;
        }
        let open = firmware::machine::controller::is_in_handler(self.board.controller().vm.flags);
        self.may_come_between(!open && !self.held);
        self.board.desk().wake();
        self.until_done()
    }

    /// The handler of an event or of errors has ended.
    pub fn leave_handler(&mut self) {
        let event = self.board.controller().vm.newest().1 == entry::EVENT;
        let op = if event { Op::Return } else { Op::ResumeNext };
        self.board.desk().ask(plain(&[op.code()], false));
        self.until_taken();
        self.board.desk().leave_handler();
        self.may_come_between(false);
    }

    /// A GOTO left every handler: what they interrupted is dropped.
    pub fn leave_all(&mut self) {
        self.board.desk().ask(plain(&[Op::Leave.code()], false));
        self.until_taken();
        self.board.desk().leave_all();
        self.may_come_between(false);
    }

    /// Goes on until the machine has taken what it was asked for.
    fn until_taken(&mut self) {
        while self.board.desk().is_asked() && !self.is_halted() {
            self.turn();
        }
    }

    /// A fault is about to be handled, or to end the run. Gives the fault to report: an emergency stop on the way comes
    /// first.
    pub fn ramp_down(&mut self, fault: Fault) -> Fault {
        if !std::mem::take(&mut self.raised) && !self.is_halted() {
            self.board.desk().ask(Request::Fault(fault));
            self.until_done();
            self.raised = false;
        }
        self.ended.and_then(|end| end.fault).unwrap_or(fault)
    }

    /// END: STARTed moves come to their ends, MoveSpeed axes ramp down.
    pub fn end(&mut self) -> Step {
        if self.is_halted() {
            return Step::Stop;
        }
        self.board.desk().ask(plain(&[Op::End.code()], false));
        while self.ended.is_none() && self.stop.is_none() {
            self.turn();
        }
        match self.ended {
            Some(end) if end.status == crate::sim::trace::Status::Done => Step::Done(0),
            _ => Step::Stop,
        }
    }

    /// RUN of the program of this name, if there is one: everything comes to rest and the outputs take their states as
    /// after END. `shown` tells whether the other one is the program whose lines the record has.
    pub fn run_other(&mut self, name: Option<&String>, shown: bool) -> Step {
        self.settle();
        loop {
            if self.board.controller().motor.path_rests() {
                self.board.controller_mut().flush_actions(None);
            }
            let rests = self.board.controller().motor.path_rests()
                && self.board.controller_mut().come_to_rest()
                && self.board.controller().motor.settled();
            if self.is_halted() {
                return Step::Stop;
            }
            if rests {
                break;
            }
            self.turn_idle();
        }
        let Some(name) = name else { return Step::Fault(Fault::NoProgram) };
        self.board.desk().forget_requests();
        self.board.controller_mut().go_on_at(driven::IMAGE);
        self.may_come_between(false);
        self.collect();
        let (us, line) = (self.now_us(), self.line);
        self.log.write(us, What::Run { line, program: name.clone() });
        self.log.turn(us, (!shown).then_some(line));
        if self.is_halted() { Step::Stop } else { Step::Done(0) }
    }

    /// The other program begins: what belongs to a run is as at its start; places and what is homed stay.
    pub fn set_out_anew(&mut self, texts: Vec<String>, registers: &Registers) {
        self.texts = texts;
        self.scene.scenario.set_registers(registers);
    }

    /// The engine has executed as many statements as it may.
    pub fn give_up(&mut self) {
        self.halt(StopReason::Statements);
    }
}
