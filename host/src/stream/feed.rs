//! A program's control flow, run on the host: what reaches the machine, in order.

use lang::back::{Compiled, MarkKind, Sidecar};
use lang::called;
use lang::effect::Effect;
use lang::fault::Fault;
use lang::image::Image;
use lang::isa::{self, Op};
use lang::record::feature;
use lang::vm::{Exit, NO_HANDLER, State, Vm, flag};
use lang::wire::Called;

use crate::client::stream::Call;

/// Instructions in one go, so that the link is looked after meanwhile.
pub const BUDGET: u16 = 20_000;

/// Why a job cannot be streamed, or would fail.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    /// Line of the source.
    pub line: u32,
    /// What stands in the way.
    pub text: String,
    /// What to do.
    pub hint: &'static str,
}

impl Refused {
    /// A refusal.
    pub fn new(line: u32, text: impl Into<String>, hint: &'static str) -> Refused {
        Refused { line, text: text.into(), hint }
    }
}

/// Refuses RUN.
pub(super) fn no_run(line: u32, name: &str) -> Refused {
    let text = format!(
        "RUN \"{name}\" cannot be streamed: a job that is fed is no program of the library"
    );
    Refused::new(line, text, "upload the program, or stream the other one behind this job")
}

/// What the program does next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// An effect, at this line.
    Effect(Effect, u32),
    /// ON ERROR: faults have a handler from here on, or none.
    Guard(bool, u32),
    /// A handler was left, or all of them.
    Left(bool, u32),
    /// It still computes.
    Thinks,
    /// It has ended.
    End,
    /// It failed by itself; [`Feed::fail`] goes on where it has a handler.
    Fault(Fault, u32),
}

/// A program that runs on the host.
#[derive(Clone, Debug)]
pub struct Feed<'a> {
    image: Image<'a>,
    sidecar: &'a Sidecar,
    state: State,
    pool: Vec<u8>,
    /// Addresses at which statements begin, of a program with handlers.
    starts: Vec<bool>,
}

/// Where a program stands, with its variables.
#[derive(Clone, Debug)]
pub struct Moment {
    state: State,
    pool: Vec<u8>,
}

impl<'a> Feed<'a> {
    /// At the program's beginning.
    ///
    /// # Errors
    /// The image is damaged.
    pub fn new(compiled: &'a Compiled) -> Result<Feed<'a>, Refused> {
        let image = Image::new(&compiled.image)
            .map_err(|flaw| Refused::new(1, format!("the image is damaged: {flaw:?}"), ""))?;
        if let Some((pc, name)) = called::runs(&image).next() {
            let line = compiled.sidecar.at(pc).map_or(1, |mark| mark.line);
            return Err(no_run(line, &String::from_utf8_lossy(name)));
        }
        let mut starts = Vec::new();
        if image.header.has(feature::EVENTS | feature::LINES) {
            starts = vec![false; image.code.len()];
            for mark in &compiled.sidecar.marks {
                let begins = matches!(mark.kind, MarkKind::Statement | MarkKind::LoopEnd);
                if let Some(start) = starts.get_mut(mark.pc).filter(|_| begins) {
                    *start = true;
                }
            }
        }
        Ok(Feed {
            image,
            sidecar: &compiled.sidecar,
            state: State::new(&image.header),
            pool: vec![0; image.header.pool_bytes()],
            starts,
        })
    }

    fn vm(&mut self) -> Vm<'a, '_> {
        Vm::new(self.image, &mut self.state, &mut self.pool)
    }

    /// The line that it stands at.
    pub fn line(&self) -> u32 {
        self.sidecar.at(self.state.pc).map_or(1, |mark| mark.line)
    }

    /// The address in the code where it stands.
    pub fn pc(&self) -> usize {
        self.state.pc
    }

    /// Whether the program has handlers, of events or of errors.
    pub fn has_handlers(&self) -> bool {
        !self.starts.is_empty()
    }

    /// Whether it has handlers of events.
    pub fn has_events(&self) -> bool {
        self.image.header.has(feature::EVENTS)
    }

    /// Whether a statement begins here.
    pub fn is_between(&self) -> bool {
        self.starts.get(self.state.pc).copied().unwrap_or(false)
    }

    /// Whether the effect that came last does not end its statement.
    pub fn is_within(&self) -> bool {
        self.state.flags & flag::WITHIN != 0
    }

    /// Whether a handler is open, of an event or of an error.
    pub fn is_in_handler(&self) -> bool {
        self.state.flags & (flag::EVENT | flag::ERROR) != 0
    }

    /// Whether faults have a handler.
    pub fn is_guarded(&self) -> bool {
        self.state.handler != NO_HANDLER
    }

    /// Runs to the next effect; [`Feed::complete`] goes on behind it, without that the same effect
    /// comes again.
    pub fn step(&mut self) -> Step {
        if self.has_handlers() {
            return self.step_by_step();
        }
        let exit = self.vm().run(BUDGET);
        self.after(exit, false)
    }

    /// The same for a program whose handlers the board must know of. When it only computes, it
    /// stands between two statements, if it comes to that.
    fn step_by_step(&mut self) -> Step {
        for count in 0..2 * BUDGET {
            if count >= BUDGET && self.is_between() {
                break;
            }
            let code = self.image.code.get(self.state.pc).copied();
            let is = |op: Op| code == Some(op.code());
            let guards = is(Op::OnError) || is(Op::OnErrorStop);
            match self.vm().step() {
                None if guards => return Step::Guard(self.is_guarded(), self.line()),
                None => {}
                Some(exit) => return self.after(exit, is(Op::Leave)),
            }
        }
        Step::Thinks
    }

    fn after(&mut self, exit: Exit, all: bool) -> Step {
        match exit {
            Exit::Effect => match self.vm().effect() {
                Some(effect) => Step::Effect(effect, self.line()),
                None => Step::Fault(Fault::ImageRefused, self.line()),
            },
            Exit::HandlerEnd => Step::Left(all, self.line()),
            Exit::Budget | Exit::Course(_) => Step::Thinks,
            Exit::Fault(fault) => Step::Fault(fault, self.line()),
            Exit::End => Step::End,
        }
    }

    /// Goes on behind the effect, with its answer.
    pub fn complete(&mut self, answer: i32) {
        self.vm().complete(answer);
    }

    /// Goes on in the handler of a fault of the statement where it stands.
    ///
    /// # Errors
    /// The run ends with this fault: it has no handler.
    pub fn fail(&mut self, fault: Fault) -> Result<(), Fault> {
        self.vm().fault(fault)
    }

    /// Where it stands.
    pub fn moment(&self) -> Moment {
        Moment { state: self.state, pool: self.pool.clone() }
    }

    /// Goes back to where it stood.
    pub fn restore(&mut self, moment: &Moment) {
        self.state = moment.state;
        self.pool.clone_from(&moment.pool);
    }

    /// Begins the handler that the board calls. It stands where the board does: behind a statement, in
    /// one that waits, or at the one that failed; `resumed`: the wait is that of an event's handler
    /// that has been left, and it stands behind that.
    ///
    /// # Errors
    /// There is no such handler.
    pub fn enter(&mut self, call: Call, resumed: bool) -> Result<(), Fault> {
        match (call.fault, call.place) {
            (None, Called::Within) if !resumed => {
                self.complete(0);
                self.vm().interrupt(call.slot)
            }
            (None, _) => self.vm().interrupt(call.slot),
            (Some(fault), Called::Failed) => self.fail(fault),
            (Some(fault), place) => {
                // RESUME NEXT goes on with the wait.
                self.state.pc -= usize::from(resumed && place == Called::Within);
                self.vm().fault_between(fault)
            }
        }
    }

    /// Values and bytes of the effect's instruction, and the text that it prints.
    pub fn instruction(&self, effect: &Effect) -> (Vec<i32>, &'a [u8], Option<&'a [u8]>) {
        let pc = self.state.pc;
        let byte = |at: usize| self.image.code.get(at).copied().unwrap_or(0);
        let code = byte(pc);
        let Some(shape) = isa::shape(code) else { return (Vec::new(), &[], None) };
        let count = match isa::inline(code) {
            Some(_) => 0,
            None => shape.pops() + isa::arguments(code, byte(pc + 1), byte(pc + 2)),
        };
        let bottom =
            usize::from(self.image.header.cells) + usize::from(self.state.sp.saturating_sub(count));
        let value = |i: usize| {
            let bytes = self.pool.get(4 * (bottom + i)..).and_then(|rest| rest.first_chunk::<4>());
            bytes.map_or(0, |bytes| i32::from_le_bytes(*bytes))
        };
        let values = (0..usize::from(count)).map(value).collect();
        let text = match effect {
            Effect::PrintText(offset) => self.image.text(usize::from(*offset)),
            _ => None,
        };
        let length = 1 + shape.operands().len(self.image.header.wide());
        (values, self.image.code.get(pc..pc + length).unwrap_or_default(), text)
    }

    /// The KEEP values, in the order of their declaration.
    pub fn keeps(&self) -> Vec<i32> {
        let values = self.pool.chunks_exact(4).skip(self.image.header.keep_base.into());
        let count = self.image.header.keeps.into();
        values
            .take(count)
            .map(|cell| i32::from_le_bytes([cell[0], cell[1], cell[2], cell[3]]))
            .collect()
    }

    /// Gives the KEEPs values, of a run before this one.
    pub fn set_keeps(&mut self, values: &[i32]) {
        let cells = self.pool.chunks_exact_mut(4).skip(self.image.header.keep_base.into());
        let count = self.image.header.keeps.into();
        for (cell, value) in cells.take(count).zip(values) {
            cell.copy_from_slice(&value.to_le_bytes());
        }
    }

    /// The axes' part of the profile.
    pub fn image(&self) -> Image<'a> {
        self.image
    }
}
