//! The `vm` engine: the device's own VM on the simulated machine.
//!
//! The VM knows no time: it leaves at each effect, and this driver counts its statements by the
//! marks that the compiler puts beside the code.

use lang::back::{Compiled, MarkKind};
use lang::effect::Effect;
use lang::fault::Fault;
use lang::hir::{Program, Storage};
use lang::image::Image;
use lang::isa::Op;
use lang::vm::{Exit, NO_HANDLER, State, Vm, flag};
use rhai::Dynamic;

use super::chain::{Chain, RUN_STATEMENTS};
use super::controlled::Machine;
use super::record::{Change, RECORD_LIMIT};
use super::step::Step;
use super::world::{Registers, World, put};
use super::{Options, Outcome, SimError, Sink, VarValue, outcome};
use crate::course;

/// What a handler came between.
#[derive(Clone, Copy, Debug)]
enum Before {
    /// A statement that waits: the address of its effect, and the one behind.
    Wait(usize, usize),
    /// Two statements; the second has been counted.
    Statement,
    /// Nothing: the statement failed.
    Fault,
}

/// How a run ended, as the engine sees it.
enum Final {
    End(u32),
    Fault(Fault, u32),
    Stopped(u32),
    /// RUN: that program of the chain begins.
    Run(usize),
    /// RUN in this line, which is the end of a program alone, of this name.
    Onward(u32, String),
}

/// Lines and beginnings of statements, by address.
struct Places {
    lines: Vec<u32>,
    /// Statements that begin there; those that left no code begin with the one behind them.
    begins: Vec<u8>,
}

impl Places {
    fn new(compiled: &Compiled, code: usize) -> Places {
        let mut places = Places { lines: vec![1; code + 1], begins: vec![0; code + 1] };
        let marks = &compiled.sidecar.marks;
        for (index, mark) in marks.iter().enumerate() {
            let end = marks.get(index + 1).map_or(code + 1, |next| next.pc).min(code + 1);
            if let Some(lines) = places.lines.get_mut(mark.pc..end) {
                lines.fill(mark.line);
            }
            if let Some(begins) = places.begins.get_mut(mark.pc) {
                let counts = matches!(mark.kind, MarkKind::Statement | MarkKind::LoopEnd);
                *begins = begins.saturating_add(counts.into());
            }
        }
        places
    }

    fn count(&self, pc: usize) -> u8 {
        self.begins.get(pc).copied().unwrap_or(0)
    }
}

/// A place between two statements.
pub struct At<'s, 'a, 'm> {
    /// Address of the statement that is about to run, or that failed.
    pub pc: usize,
    /// Its line.
    pub line: u32,
    /// Cells and open calls.
    pub vm: &'s mut Vm<'a, 'm>,
    /// The machine.
    pub machine: &'s Machine,
}

/// Somebody who looks on, statement by statement.
pub trait Watcher {
    /// A statement is about to run; `false` ends the run.
    fn before(&mut self, at: At<'_, '_, '_>) -> bool;
    /// A statement failed; `false` ends the run.
    fn failed(&mut self, at: At<'_, '_, '_>, fault: Fault) -> bool;
}

struct Driver<'a, 'm, 'w> {
    watcher: Option<&'w mut dyn Watcher>,
    vm: Vm<'a, 'm>,
    image: Image<'a>,
    machine: Machine,
    places: Places,
    handlers: Vec<Before>,
    again: bool,
    left: u64,
    /// Values of the cells at the last effect, where the run is recorded.
    cells: Vec<i32>,
    changes: Vec<Change>,
    /// Cells of AT variables, with the values that the world shares.
    shared: Vec<(u8, Dynamic)>,
    chain: &'a Chain<'a>,
}

/// Runs a program.
///
/// # Errors
/// As [`super::run`].
pub fn run(
    program: &Program,
    compiled: &Compiled,
    world: &World,
    options: &Options,
    sink: Sink,
) -> Result<Outcome, SimError> {
    watched(program, compiled, world, options, sink, None)
}

/// As [`run`], with a [`Watcher`].
/// # Errors
/// As [`super::run`].
pub fn watched(
    program: &Program,
    compiled: &Compiled,
    world: &World,
    options: &Options,
    sink: Sink,
    watcher: Option<&mut dyn Watcher>,
) -> Result<Outcome, SimError> {
    let compiled = std::slice::from_ref(compiled);
    run_chain(&Chain::alone(program), compiled, world, options, sink, watcher)
}

/// Runs the first program of a chain, and those that RUN begins; `compiled` are theirs.
///
/// # Errors
/// As [`super::run`].
pub fn run_chain(
    chain: &Chain<'_>,
    compiled: &[Compiled],
    world: &World,
    options: &Options,
    sink: Sink,
    mut watcher: Option<&mut dyn Watcher>,
) -> Result<Outcome, SimError> {
    let refused = |flaw: &dyn std::fmt::Debug| SimError::Engine(format!("vm: {flaw:?}"));
    let [first, ..] = chain.programs() else { return Err(refused(&"no program")) };
    let mut registers = Registers::of(first);
    let mut machine = Machine::new(&first.profile, world, options, Vec::new(), &registers, sink)?;
    machine.set_ends(course::ends(first, &options.part));
    let mut keeps = vec![Vec::new(); compiled.len()];
    let (mut left, mut changes, mut known) = (options.statements, Vec::new(), Vec::new());
    let mut number = 0;
    loop {
        let (Some(program), Some(own)) = (chain.programs().get(number), compiled.get(number))
        else {
            return Err(refused(&"a program that there is not"));
        };
        let image = Image::new(&own.image).map_err(|flaw| refused(&flaw))?;
        let mut state = State::new(&image.header);
        let mut pool = vec![0; image.header.pool_bytes()];
        let shown = options.record && number == 0;
        let mut cells = if shown { std::mem::take(&mut known) } else { Vec::new() };
        cells.resize(if shown { image.header.cells.into() } else { 0 }, 0);
        let mut driver = Driver {
            watcher,
            vm: Vm::new(image, &mut state, &mut pool),
            image,
            machine,
            places: Places::new(own, image.code.len()),
            handlers: Vec::new(),
            again: false,
            left,
            cells,
            changes,
            shared: registers
                .by_cell()
                .filter_map(|(n, at)| Some((u8::try_from(n).ok()?, at)))
                .collect(),
            chain,
        };
        let kept = image.header.keep_base..image.header.keep_base + image.header.keeps;
        for (cell, value) in kept.clone().zip(&keeps[number]) {
            driver.vm.set_cell(cell, *value);
        }
        let mut onward = None;
        let (fault, line) = match driver.execute() {
            Final::Onward(line, name) => {
                onward = Some(name);
                (None, line)
            }
            Final::End(line) | Final::Stopped(line) => (None, line),
            Final::Fault(fault, line) => (Some(fault), line),
            Final::Run(next) => {
                driver.note_changes();
                keeps[number] = kept.map(|cell| driver.vm.cell(cell)).collect();
                if next != number {
                    let other = chain.programs().get(next).copied().unwrap_or(program);
                    registers = Registers::of(other);
                }
                driver.machine.set_out_anew(Vec::new(), &registers);
                left = driver.left.saturating_sub(RUN_STATEMENTS);
                Driver { watcher, machine, changes, .. } = driver;
                if shown {
                    known = driver.cells;
                }
                number = next;
                continue;
            }
        };
        let vars = variables(program, own, &driver.vm);
        driver.note_changes();
        let mut outcome = outcome(&mut driver.machine, fault, line, vars)?;
        outcome.record.changes = driver.changes;
        outcome.program = number;
        outcome.onward = onward;
        return Ok(outcome);
    }
}

impl Driver<'_, '_, '_> {
    fn line(&self) -> u32 {
        self.places.lines.get(self.vm.state.pc).copied().unwrap_or(1)
    }

    fn execute(&mut self) -> Final {
        self.accept();
        loop {
            let pc = self.vm.state.pc;
            if self.places.count(pc) > 0
                && let Err(end) = self.with_world(|driver| driver.statement(pc))
            {
                return end;
            }
            let pc = self.vm.state.pc;
            let exit = self.vm.step();
            let done = match exit {
                None | Some(Exit::Budget | Exit::Course(_)) => Ok(()),
                Some(Exit::Effect) => self.with_world(Driver::effect),
                Some(Exit::HandlerEnd) => self.with_world(|driver| driver.handler_end(pc)),
                Some(Exit::Fault(fault)) => {
                    self.with_world(|driver| driver.fault(fault, Before::Fault))
                }
                Some(Exit::End) => return self.with_world(Driver::end),
            };
            if let Err(end) = done {
                return end;
            }
        }
    }

    /// Does what lets time pass: the world sees the AT variables as they are, and may change them.
    fn with_world<T>(&mut self, what: impl FnOnce(&mut Self) -> T) -> T {
        self.share();
        let result = what(self);
        self.accept();
        result
    }

    /// The world sees the cells as they are.
    fn share(&mut self) {
        for (cell, value) in &mut self.shared {
            put(value, self.vm.cell(*cell));
        }
    }

    /// The cells take over what the world made of them.
    fn accept(&mut self) {
        for (cell, value) in &self.shared {
            self.vm.set_cell(*cell, value.as_int().unwrap_or(0));
        }
    }

    /// Counts the statement at `pc` and serves what comes before it.
    fn statement(&mut self, pc: usize) -> Result<(), Final> {
        self.machine.set_line(self.line());
        self.machine.set_handled(self.vm.state.handler != NO_HANDLER);
        let line = self.line();
        let Driver { watcher, vm, machine, .. } = self;
        if let Some(watcher) = watcher
            && !watcher.before(At { pc, line, vm, machine })
        {
            return Err(Final::Stopped(line));
        }
        if self.watcher.is_some() {
            // Who looks on may have changed some.
            self.share();
        }
        if !std::mem::take(&mut self.again) {
            let count = self.places.count(pc);
            self.machine.pass(count.into());
            self.left = self.left.saturating_sub(count.into());
            if self.left == 0 {
                self.machine.give_up();
            }
        }
        while self.machine.needs_attention() {
            match self.machine.look() {
                Step::Done(_) => break,
                Step::Stop => return Err(Final::Stopped(self.line())),
                Step::Event(slot) => self.interrupt(slot, Before::Statement)?,
                Step::Fault(fault) | Step::Late(fault) => {
                    self.fault(fault, Before::Statement)?;
                }
            }
            if self.vm.state.pc != pc {
                // The handler begins with a statement of its own.
                let pc = self.vm.state.pc;
                return if self.places.count(pc) > 0 { self.statement(pc) } else { Ok(()) };
            }
        }
        Ok(())
    }

    fn interrupt(&mut self, slot: u8, before: Before) -> Result<(), Final> {
        let line = self.line();
        if let Err(fault) = self.vm.interrupt(slot) {
            let fault = self.machine.ramp_down(fault);
            return Err(self.over(fault, line));
        }
        self.handlers.push(before);
        self.machine.enter_handler();
        Ok(())
    }

    fn over(&self, fault: Fault, line: u32) -> Final {
        if self.machine.is_halted() { Final::Stopped(line) } else { Final::Fault(fault, line) }
    }

    /// The statement at `pc` failed, or a fault came before it or in its wait.
    fn fault(&mut self, fault: Fault, before: Before) -> Result<(), Final> {
        let line = self.line();
        self.machine.set_line(line);
        self.machine.set_handled(self.vm.state.handler != NO_HANDLER);
        let Driver { watcher, vm, machine, .. } = self;
        let pc = vm.state.pc;
        if let Some(watcher) = watcher
            && !watcher.failed(At { pc, line, vm, machine }, fault)
        {
            return Err(Final::Stopped(line));
        }
        let fault = self.machine.ramp_down(fault);
        if self.machine.is_halted() {
            return Err(Final::Stopped(line));
        }
        let raised = match before {
            Before::Fault => self.vm.fault(fault),
            Before::Wait(..) | Before::Statement => self.vm.fault_between(fault),
        };
        raised.map_err(|fault| Final::Fault(fault, line))?;
        self.handlers.push(before);
        self.machine.enter_handler();
        Ok(())
    }

    /// Notes what the statements since the last effect changed.
    fn note_changes(&mut self) {
        let us = self.machine.now_us();
        for (n, known) in self.cells.iter_mut().enumerate() {
            let Ok(cell) = u8::try_from(n) else { return };
            let value = self.vm.cell(cell);
            if value != *known && self.changes.len() < RECORD_LIMIT {
                *known = value;
                self.changes.push(Change { us, cell, value });
            }
        }
    }

    fn effect(&mut self) -> Result<(), Final> {
        self.note_changes();
        let pc = self.vm.state.pc;
        let line = self.line();
        self.machine.set_line(line);
        self.machine.set_handled(self.vm.state.handler != NO_HANDLER);
        let Some(effect) = self.vm.effect() else {
            return Err(Final::Fault(Fault::ImageRefused, line));
        };
        if let Effect::Run(name) = effect {
            return self.run_other(usize::from(name));
        }
        let waits = effect.waits();
        if waits {
            // Its arguments are in the effect: the stack is clear for a handler.
            self.vm.complete(0);
            self.machine.hold_events(!self.vm.can_interrupt());
        }
        let next = self.vm.state.pc;
        let step = self.machine.begin(&effect);
        if let (Effect::PrintText(offset), Step::Done(_)) = (effect, step) {
            let text = self.image.text(usize::from(offset)).unwrap_or_default();
            self.machine.print_text(&String::from_utf8_lossy(text));
        }
        if !waits && let Step::Done(value) = step {
            self.vm.complete(value);
            return Ok(());
        }
        self.waited(step, pc, next)
    }

    /// RUN of the program whose name is that text.
    fn run_other(&mut self, name: usize) -> Result<(), Final> {
        let name = String::from_utf8_lossy(self.image.text(name).unwrap_or_default()).into_owned();
        if self.chain.is_alone() {
            return Err(match self.end() {
                Final::End(line) => Final::Onward(line, name),
                stopped => stopped,
            });
        }
        let number = self.chain.find(&name);
        let step = self
            .machine
            .run_other(number.and_then(|number| self.chain.names().get(number)), number == Some(0));
        if let (Step::Done(_), Some(number)) = (step, number) {
            return Err(Final::Run(number));
        }
        let pc = self.vm.state.pc;
        self.waited(step, pc, pc)
    }

    /// What came of an effect at `pc` that goes on at `next`.
    fn waited(&mut self, step: Step, pc: usize, next: usize) -> Result<(), Final> {
        self.machine.hold_events(false);
        match step {
            Step::Done(_) => {
                self.vm.state.pc = next;
                Ok(())
            }
            Step::Event(slot) => {
                self.vm.state.pc = next;
                self.interrupt(slot, Before::Wait(pc, next))
            }
            Step::Fault(fault) | Step::Late(fault) => {
                self.vm.state.pc = pc;
                // A statement in which a fault came by itself is done anew after the handler, from its beginning.
                let late = matches!(step, Step::Late(_));
                self.fault(fault, if late { Before::Statement } else { Before::Fault })
            }
            Step::Stop => {
                self.vm.state.pc = pc;
                Err(Final::Stopped(self.line()))
            }
        }
    }

    /// The instruction at `pc` left a handler, or all of them.
    fn handler_end(&mut self, pc: usize) -> Result<(), Final> {
        if self.image.code.get(pc) == Some(&(Op::Leave as u8)) {
            self.handlers.clear();
            self.machine.leave_all();
            return Ok(());
        }
        self.machine.leave_handler(self.vm.state.flags & flag::EVENT != 0);
        match self.handlers.pop() {
            Some(Before::Wait(effect, next)) => {
                let step = self.machine.resume();
                self.waited(step, effect, next)
            }
            Some(Before::Statement) => {
                self.again = true;
                Ok(())
            }
            Some(Before::Fault) | None => Ok(()),
        }
    }

    fn end(&mut self) -> Final {
        let line = self.line();
        self.machine.set_line(line);
        match self.machine.end() {
            Step::Stop => Final::Stopped(line),
            _ => Final::End(line),
        }
    }
}

/// Final values of the globals and KEEPs that have cells.
fn variables(program: &Program, compiled: &Compiled, vm: &Vm<'_, '_>) -> Vec<VarValue> {
    let mut values = Vec::new();
    // Cells are given out by storage; the outcome lists variables as they were declared.
    let mut places: Vec<_> = compiled.vars.iter().collect();
    places.sort_by_key(|place| place.var);
    for place in places {
        let var = program.var(place.var);
        if matches!(var.storage, Storage::Local(_)) || var.name.contains(' ') {
            continue;
        }
        let cells = (place.cell..place.cell + place.len).filter_map(|n| u8::try_from(n).ok());
        values
            .push(VarValue { name: var.name.clone(), values: cells.map(|n| vm.cell(n)).collect() });
    }
    values
}
