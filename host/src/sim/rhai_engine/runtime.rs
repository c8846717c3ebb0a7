//! What a running script leans on: the machine, the call stack, faults and handlers.

use lang::fault::Fault;

use super::cycle::{self, Broken};
use super::effects::Template;
use super::emit::Info;
use super::translate::Translation;
use crate::sim::chain;
use crate::sim::controlled::Machine;
use crate::sim::step::Step;

/// Why the script stops for a moment, or for good.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Break {
    /// The statement failed.
    Fault(Fault),
    /// Go on in the block that [`Runtime::caught`] names.
    Jump,
    /// The run is over.
    Over,
}

impl From<Fault> for Break {
    fn from(fault: Fault) -> Break {
        Break::Fault(fault)
    }
}

/// How a run ended, as the engine sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Final {
    /// END, or the text's end.
    End(u32),
    /// A fault that nobody handles.
    Fault(Fault, u32),
    /// The machine stopped it, in the current statement.
    Stopped(u32),
    /// RUN: that program of the chain begins.
    Run(usize),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Gosub,
    Sub,
    Event,
    Error,
}

#[derive(Clone, Copy, Debug)]
struct Frame {
    kind: Kind,
    back: i32,
    /// Where RESUME comes back to: the beginning of what failed.
    start: i32,
    /// Values on the stack when it began.
    base: usize,
    /// It comes back to the beginning of a statement that has been counted already.
    between: bool,
}

/// See the module.
pub struct Runtime {
    /// The machine.
    pub machine: Machine,
    templates: Vec<Template>,
    cycles: Vec<cycle::Plan>,
    infos: Vec<Info>,
    tables: Vec<(i32, Vec<i32>)>,
    frames: Vec<Frame>,
    depth: usize,
    values: Vec<i32>,
    current: usize,
    handlers: [i32; 4],
    on_error: Option<i32>,
    err: i32,
    erl: i32,
    jump: Option<i32>,
    fault: Option<Fault>,
    again: bool,
    ended: Option<Final>,
    /// By the machine, in the current statement.
    stopped: bool,
    /// Statements that may still be executed.
    pub left: u64,
    texts: Vec<String>,
    /// Names of the programs that RUN finds.
    names: Vec<String>,
    /// What RUN would begin, where nobody knows of others.
    pub onward: Option<String>,
}

impl Runtime {
    /// At the beginning of a run; `depth` calls may be open at once, `statements` executed; RUN finds `names`.
    pub fn new(
        machine: Machine,
        program: &Translation,
        depth: usize,
        statements: u64,
        names: Vec<String>,
    ) -> Runtime {
        Runtime {
            machine,
            templates: program.templates.clone(),
            cycles: program.cycles.clone(),
            infos: program.script.infos.clone(),
            tables: program.tables.clone(),
            frames: Vec::new(),
            depth,
            values: Vec::new(),
            current: 0,
            handlers: [0; 4],
            on_error: None,
            err: 0,
            erl: 0,
            jump: None,
            fault: None,
            again: false,
            ended: None,
            stopped: false,
            left: statements,
            texts: program.texts.clone(),
            names,
            onward: None,
        }
    }

    /// Line of the current statement.
    pub fn line(&self) -> u32 {
        self.infos.get(self.current).map_or(1, |info| info.line)
    }

    /// What follows belongs to this statement.
    pub fn set_current(&mut self, id: usize) {
        self.current = id;
    }

    /// `count` statements were begun behind the last look at the machine, when the run broke off.
    pub fn begun(&mut self, count: u32) {
        if !self.stopped && self.ended.is_none() {
            self.machine.pass(count);
        }
    }

    /// `count` statements without a look at the machine.
    ///
    /// # Errors
    /// The run is over.
    pub fn pass(&mut self, count: u32) -> Result<(), Break> {
        self.machine.pass(count);
        self.left = self.left.saturating_sub(u64::from(count));
        if self.left == 0 {
            self.machine.give_up();
        }
        if self.machine.needs_attention() {
            match self.machine.look() {
                Step::Stop => return Err(self.stop()),
                Step::Late(fault) | Step::Fault(fault) => return Err(fault.into()),
                Step::Done(_) | Step::Event(_) => {}
            }
        }
        Ok(())
    }

    /// A statement begins.
    ///
    /// # Errors
    /// A handler comes first, or the run is over.
    pub fn poll(&mut self, id: usize) -> Result<(), Break> {
        self.current = id;
        let line = self.line();
        self.machine.set_line(line);
        if !std::mem::take(&mut self.again) {
            self.machine.pass(1);
            self.left = self.left.saturating_sub(1);
            if self.left == 0 {
                self.machine.give_up();
            }
        }
        if !self.machine.needs_attention() {
            return Ok(());
        }
        let step = self.machine.look();
        let start = self.infos[id].start;
        self.interrupted(step, start, true).map(|_| ())
    }

    /// Takes a step of the machine apart; `back` is where a handler comes back to.
    fn interrupted(&mut self, step: Step, back: i32, between: bool) -> Result<i32, Break> {
        match step {
            Step::Done(value) => Ok(value),
            Step::Fault(fault) => Err(fault.into()),
            Step::Stop => Err(self.stop()),
            Step::Event(slot) => {
                self.push(Kind::Event, back, between)?;
                self.machine.enter_handler();
                self.jump = self.handlers.get(usize::from(slot)).copied();
                Err(Break::Jump)
            }
            // The statement under way is done anew after the handler, from its beginning.
            Step::Late(fault) => {
                let start = self.infos[self.current].start;
                self.jump = Some(self.raise(fault, [start; 2], true)?);
                Err(Break::Jump)
            }
        }
    }

    fn stop(&mut self) -> Break {
        self.stopped = true;
        Break::Over
    }

    /// An effect with its values.
    ///
    /// # Errors
    /// It failed, a handler comes first, or the run is over.
    pub fn effect(&mut self, id: usize, values: &[i32]) -> Result<i32, Break> {
        let template = self.templates[id];
        self.machine.set_line(template.line);
        let step = self.machine.begin(&template.fill(values));
        self.interrupted(step, template.resume, false)
    }

    /// A canned cycle with its values.
    ///
    /// # Errors
    /// A move failed, or the run is over.
    pub fn cycle(&mut self, id: usize, values: &[i32]) -> Result<(), Break> {
        self.machine.hold_events(true);
        let done = cycle::run(&mut self.machine, &self.cycles[id], values);
        self.machine.hold_events(false);
        match done {
            Ok(()) => Ok(()),
            Err(Broken::Fault(fault)) => Err(fault.into()),
            Err(Broken::Late(fault)) => self.interrupted(Step::Late(fault), 0, true).map(|_| ()),
            Err(Broken::Stop) => Err(self.stop()),
        }
    }

    /// Goes on with the wait of statement `statement` after a handler.
    ///
    /// # Errors
    /// As [`Runtime::effect`].
    pub fn go_on(&mut self, statement: usize, id: usize) -> Result<(), Break> {
        self.current = statement;
        let step = self.machine.resume();
        let resume = self.templates[id].resume;
        self.interrupted(step, resume, false).map(|_| ())
    }

    fn push(&mut self, kind: Kind, back: i32, between: bool) -> Result<(), Fault> {
        if self.frames.len() >= self.depth {
            return Err(Fault::Stack);
        }
        self.frames.push(Frame { kind, back, start: back, base: self.values.len(), between });
        Ok(())
    }

    /// Calls a SUB or FUNCTION (`sub`), or a GOSUB.
    ///
    /// # Errors
    /// F16.
    pub fn call(&mut self, sub: bool, back: i32) -> Result<(), Break> {
        let kind = if sub { Kind::Sub } else { Kind::Gosub };
        Ok(self.push(kind, back, false)?)
    }

    /// RETURN; with `whole`, the end of a SUB or FUNCTION, which drops its open GOSUBs.
    ///
    /// # Errors
    /// F16.
    pub fn leave(&mut self, whole: bool) -> Result<i32, Break> {
        loop {
            let Some(frame) = self.frames.last().copied() else { return Err(Fault::Stack.into()) };
            match frame.kind {
                Kind::Gosub if whole => {
                    self.frames.pop();
                }
                Kind::Gosub | Kind::Sub => {
                    self.frames.pop();
                    return Ok(frame.back);
                }
                Kind::Event => {
                    self.frames.pop();
                    self.machine.leave_handler(false);
                    self.again = frame.between;
                    return Ok(frame.back);
                }
                Kind::Error => return Err(Fault::Stack.into()),
            }
        }
    }

    /// RESUME NEXT, or with `again` RESUME.
    ///
    /// # Errors
    /// F16.
    pub fn resume(&mut self, again: bool) -> Result<i32, Break> {
        if !self.in_error_handler() {
            return Err(Fault::Stack.into());
        }
        while let Some(frame) = self.frames.pop() {
            if frame.kind == Kind::Error {
                self.values.truncate(frame.base);
                let open = self.frames.iter().any(|frame| frame.kind == Kind::Event);
                self.machine.leave_handler(open);
                self.again = frame.between;
                return Ok(if again { frame.start } else { frame.back });
            }
        }
        Err(Fault::Stack.into())
    }

    fn in_error_handler(&self) -> bool {
        self.frames.iter().any(|frame| frame.kind == Kind::Error)
    }

    /// GOTO: one in the error handler itself leaves everything.
    pub fn goto(&mut self) {
        if self.frames.last().is_some_and(|frame| frame.kind == Kind::Error) {
            self.frames.clear();
            self.values.clear();
            self.machine.leave_all();
        }
    }

    /// A fault: the block of the error handler, which comes back to `back`, by RESUME to `start`.
    fn raise(
        &mut self,
        fault: Fault,
        [back, start]: [i32; 2],
        between: bool,
    ) -> Result<i32, Break> {
        let line = self.line();
        self.machine.set_line(line);
        let fault = self.machine.ramp_down(fault);
        self.err = i32::from(fault.number());
        self.erl = i32::try_from(line).unwrap_or(i32::MAX);
        if self.machine.is_halted() {
            return Err(self.stop());
        }
        let base = self.frames.last().map_or(0, |frame| frame.base);
        let room = self.frames.len() < self.depth;
        match self.on_error {
            Some(handler) if fault.can_be_handled() && !self.in_error_handler() => {
                if !room {
                    self.ended = Some(Final::Fault(Fault::Stack, line));
                    return Err(Break::Over);
                }
                self.values.truncate(base);
                self.frames.push(Frame { kind: Kind::Error, back, start, base, between });
                self.machine.enter_handler();
                Ok(handler)
            }
            _ => {
                self.ended = Some(Final::Fault(fault, line));
                Err(Break::Over)
            }
        }
    }

    /// Keeps a break for [`Runtime::caught`].
    pub fn keep(&mut self, cause: Break) {
        if let Break::Fault(fault) = cause {
            self.fault = Some(fault);
        }
    }

    /// Something stopped the script: the block to go on with. A fault that no native function
    /// kept is an overflow of Rhai's own arithmetic.
    ///
    /// # Errors
    /// The run is over.
    pub fn caught(&mut self) -> Result<i32, Break> {
        if let Some(jump) = self.jump.take() {
            return Ok(jump);
        }
        let fault = self.fault.take().unwrap_or(Fault::Overflow);
        let places = self.infos.get(self.current).map_or([0; 2], |info| [info.resume, info.start]);
        self.raise(fault, places, false)
    }

    /// END.
    pub fn end(&mut self, line: u32) -> Break {
        self.machine.set_line(line);
        self.ended = Some(match self.machine.end() {
            Step::Stop => Final::Stopped(line),
            _ => Final::End(line),
        });
        Break::Over
    }

    /// RUN of the program whose name is that text.
    pub fn run_other(&mut self, line: u32, name: u32) -> Break {
        self.machine.set_line(line);
        let name = self.texts.get(name as usize).cloned().unwrap_or_default();
        if self.names.iter().all(String::is_empty) {
            self.onward = Some(name);
            return self.end(line);
        }
        let number = chain::find(&self.names, &name);
        let own = number.and_then(|number| self.names.get(number));
        match self.machine.run_other(own, number == Some(0)) {
            Step::Done(_) => {
                self.ended = number.map(Final::Run);
                Break::Over
            }
            Step::Fault(fault) => fault.into(),
            _ => self.stop(),
        }
    }

    /// How the run ended; a break without an end of its own is a fault of the current statement.
    pub fn ended(&mut self) -> Final {
        if self.stopped {
            return Final::Stopped(self.line());
        }
        if let Some(ended) = self.ended {
            return ended;
        }
        let fault = self.fault.take().unwrap_or(Fault::Overflow);
        match self.raise(fault, [0; 2], false) {
            _ if self.stopped => Final::Stopped(self.line()),
            Ok(_) | Err(_) => self.ended.unwrap_or(Final::Fault(fault, self.line())),
        }
    }

    /// Puts a value of an unfinished expression aside.
    pub fn put(&mut self, value: i32) {
        self.values.push(value);
    }

    /// Takes it back.
    pub fn take(&mut self) -> i32 {
        self.values.pop().unwrap_or(0)
    }

    /// ON IN, ON EVERY: where the handler of a slot begins.
    pub fn set_handler(&mut self, slot: i32, block: i32) {
        let place = usize::try_from(slot).ok().and_then(|slot| self.handlers.get_mut(slot));
        if let Some(place) = place {
            *place = block;
        }
    }

    /// ON ERROR: a block, or -1.
    pub fn set_on_error(&mut self, block: i32) {
        self.on_error = (block >= 0).then_some(block);
        self.machine.set_handled(self.on_error.is_some());
    }

    /// ERR and ERL.
    pub fn last_fault(&self) -> (i32, i32) {
        (self.err, self.erl)
    }

    /// A value of a table.
    ///
    /// # Errors
    /// F03.
    pub fn table(&self, table: usize, row: i32, column: i32) -> Result<i32, Break> {
        let (columns, values) = &self.tables[table];
        if !(0..*columns).contains(&column) || row < 0 {
            return Err(Fault::ArrayIndex.into());
        }
        let at = i64::from(row) * i64::from(*columns) + i64::from(column);
        let value = usize::try_from(at).ok().and_then(|at| values.get(at));
        value.copied().ok_or(Break::Fault(Fault::ArrayIndex))
    }
}
