//! A program's control flow, run on the host: what reaches the machine, in order.

use std::collections::VecDeque;

use lang::back::{Compiled, Sidecar};
use lang::effect::Effect;
use lang::fault::Fault;
use lang::image::Image;
use lang::isa;
use lang::record::feature;
use lang::vm::{Exit, State, Vm};

use super::piece::{Piece, Writer, answers};
use super::place::Track;

/// Instructions in one go, so that the link is looked after meanwhile.
const BUDGET: u16 = 20_000;
/// Instructions that the check before the first move executes at most.
const CHECK: u64 = 50_000_000;

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

/// What the program does next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// An effect, at this line.
    Effect(Effect, u32),
    /// It still computes.
    Thinks,
    /// It has ended.
    End,
    /// It failed by itself.
    Fault(Fault, u32),
}

/// A program that runs on the host.
#[derive(Clone, Debug)]
pub struct Feed<'a> {
    image: Image<'a>,
    sidecar: &'a Sidecar,
    state: State,
    pool: Vec<u8>,
}

impl<'a> Feed<'a> {
    /// At the program's beginning.
    ///
    /// # Errors
    /// The program does what only a stored one can.
    pub fn new(compiled: &'a Compiled) -> Result<Feed<'a>, Refused> {
        let image = Image::new(&compiled.image)
            .map_err(|flaw| Refused::new(1, format!("the image is damaged: {flaw:?}"), ""))?;
        let line = |op: isa::Op| {
            let mut pc = 0;
            while let Some(&code) = image.code.get(pc) {
                if op.code() == code {
                    return compiled.sidecar.at(pc).map_or(1, |mark| mark.line);
                }
                let Some(shape) = isa::shape(code) else { return 1 };
                pc += 1 + shape.operands().len(image.header.wide());
            }
            1
        };
        for (bit, op, what, hint) in [
            (
                feature::EVENTS,
                isa::Op::Event,
                "ON IN and ON EVERY are served within 2 ms, which a job fed over the link cannot",
                "test IN(n) or TIMER() between the statements, or shorten the job so that the \
                 board can store it: repeated places into a TABLE, repeated statements into a SUB",
            ),
            (
                feature::LINES,
                isa::Op::OnError,
                "ON ERROR would jump back into statements that the board has already forgotten",
                "use the forms that go on by themselves (Probe?, Home?, WaitIn?, WaitChar?), or \
                 shorten the job so that the board can store it: repeated places into a TABLE, \
                 repeated statements into a SUB",
            ),
        ] {
            if image.header.has(bit) {
                return Err(Refused::new(line(op), what, hint));
            }
        }
        let state = State::new(&image.header);
        Ok(Feed {
            image,
            sidecar: &compiled.sidecar,
            state,
            pool: vec![0; image.header.pool_bytes()],
        })
    }

    fn vm(&mut self) -> Vm<'a, '_> {
        Vm::new(self.image, &mut self.state, &mut self.pool)
    }

    fn line(&self) -> u32 {
        self.sidecar.at(self.state.pc).map_or(1, |mark| mark.line)
    }

    /// Runs to the next effect; [`Feed::complete`] goes on behind it, without that the same effect
    /// comes again.
    pub fn step(&mut self) -> Step {
        let exit = self.vm().run(BUDGET);
        match exit {
            Exit::Effect => match self.vm().effect() {
                Some(effect) => Step::Effect(effect, self.line()),
                None => Step::Fault(Fault::ImageRefused, self.line()),
            },
            Exit::Budget | Exit::HandlerEnd => Step::Thinks,
            Exit::Fault(fault) => Step::Fault(fault, self.line()),
            Exit::End => Step::End,
        }
    }

    /// Goes on behind the effect, with its answer.
    pub fn complete(&mut self, answer: i32) {
        self.vm().complete(answer);
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

/// What the check before the first move found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Checked {
    /// Statements of the machine.
    pub count: u64,
    /// The line from which on the job hangs on what the machine answers, so that only a run shows
    /// what comes.
    pub open: Option<u32>,
}

/// Runs the whole job on the host, up to the first question to the machine.
///
/// # Errors
/// It would fail.
pub fn check(mut feed: Feed<'_>, mut track: Track) -> Result<Checked, Refused> {
    let mut checked = Checked::default();
    let mut left = CHECK;
    loop {
        match feed.step() {
            Step::Effect(effect, line) => {
                if Track::is_open(&effect) {
                    checked.open = Some(line);
                    return Ok(checked);
                }
                track.follow(&effect).map_err(|fault| fails(fault, line))?;
                checked.count += 1;
                feed.complete(0);
                left = left.saturating_sub(1);
            }
            Step::Thinks => left = left.saturating_sub(BUDGET.into()),
            Step::End => return Ok(checked),
            Step::Fault(fault, line) => return Err(fails(fault, line)),
        }
        if left == 0 {
            checked.open = Some(feed.line());
            return Ok(checked);
        }
    }
}

fn fails(fault: Fault, line: u32) -> Refused {
    let text = format!("the job would stop here with {fault}: {}", fault.text());
    Refused::new(line, text, fault.remedy())
}

/// Makes pieces of a job.
pub struct Job<'a> {
    feed: Feed<'a>,
    writer: Writer,
    /// The program waits for an answer.
    waits: bool,
    /// How much of the text that is being printed is in pieces.
    printed: usize,
    /// How it ended, once it has.
    over: Option<Option<(Fault, u32)>>,
    /// The KEEP values with which statements were written, each with the count of statements
    /// before the first of them.
    keeps: VecDeque<(u64, Vec<i32>)>,
    /// It prints.
    pub prints: bool,
}

impl<'a> Job<'a> {
    /// A job for a board whose pieces hold `room` bytes of code and data.
    pub fn new(feed: Feed<'a>, room: usize) -> Job<'a> {
        let image = feed.image();
        let writer = Writer::new(&image.header, image.machine, room);
        let keeps = VecDeque::from([(0, feed.keeps())]);
        Job { feed, writer, waits: false, printed: 0, over: None, keeps, prints: false }
    }

    /// Skips to the first statement at or behind `line`: what comes before leaves its state only.
    /// `steps` is where the board's axes stand.
    ///
    /// # Errors
    /// There is no such line, or what comes before it hangs on what the machine answers.
    pub fn skip(&mut self, line: u32, track: &mut Track, steps: [i32; 3]) -> Result<(), Refused> {
        let mut left = CHECK;
        loop {
            match self.feed.step() {
                Step::Effect(_, at) if at >= line => break,
                Step::Effect(effect, at) => {
                    if Track::is_open(&effect) {
                        let text = "what this does hangs on the machine, so the state behind it \
                                    is not known without running it";
                        return Err(Refused::new(at, text, "begin at an earlier line"));
                    }
                    track.follow(&effect).map_err(|fault| fails(fault, at))?;
                    self.feed.complete(0);
                    left = left.saturating_sub(1);
                }
                Step::Thinks => left = left.saturating_sub(BUDGET.into()),
                Step::Fault(fault, at) => return Err(fails(fault, at)),
                Step::End => {
                    let text = "the job is over before it comes to this line";
                    return Err(Refused::new(line, text, "name a line with a statement"));
                }
            }
            if left == 0 {
                let text = "the job does not come to this line";
                return Err(Refused::new(line, text, "name a line with a statement"));
            }
        }
        // What was executed before has been counted then.
        let (_, keeps) = self.keeps.front().cloned().unwrap_or_default();
        self.feed.set_keeps(&keeps);
        for (values, code) in track.restore(steps).map_err(|fault| fails(fault, line))? {
            self.writer.put(line, &values, &code, None);
        }
        Ok(())
    }

    /// The axes' part of the profile.
    pub fn machine(&self) -> &[u8] {
        self.writer.machine()
    }

    /// Goes on with the answer that the last piece asked for.
    pub fn answer(&mut self, value: i32) {
        self.feed.complete(value);
        self.waits = false;
    }

    /// Whether the program has ended, and the fault that it ended itself with.
    pub fn over(&self) -> Option<Option<(Fault, u32)>> {
        self.over
    }

    /// The next piece; `None` while the program computes, waits for an answer, or is over.
    pub fn piece(&mut self) -> Option<Piece> {
        loop {
            if self.waits || self.over.is_some() {
                return None;
            }
            match self.feed.step() {
                Step::Effect(effect, line) => {
                    let (values, code, text) = self.feed.instruction(&effect);
                    // A text may be longer than a piece: its parts follow one another.
                    let rest = text.map(|text| text.get(self.printed..).unwrap_or_default());
                    let room = self.writer.text_room();
                    let part = rest.map(|rest| &rest[..rest.len().min(room)]);
                    let fits = part.is_none_or(|part| !part.is_empty() || text == Some(&[]));
                    if !fits || !self.writer.put(line, &values, code, part) {
                        if self.writer.is_empty() {
                            // Not even alone: no board has so little room.
                            self.over = Some(Some((Fault::ImageRefused, line)));
                            return None;
                        }
                        return Some(self.writer.finish(false));
                    }
                    if let (Some(part), Some(rest)) = (part, rest)
                        && part.len() < rest.len()
                    {
                        self.printed += part.len();
                        continue;
                    }
                    self.printed = 0;
                    self.note_keeps();
                    self.prints |= effect == Effect::PrintEnd;
                    if answers(&effect) {
                        self.waits = true;
                        return Some(self.writer.finish(true));
                    }
                    self.feed.complete(0);
                }
                Step::Thinks => return None,
                Step::End => {
                    self.over = Some(None);
                    return (!self.writer.is_empty()).then(|| self.writer.finish(false));
                }
                Step::Fault(fault, line) => {
                    self.over = Some(Some((fault, line)));
                    return (!self.writer.is_empty()).then(|| self.writer.finish(false));
                }
            }
        }
    }

    /// Notes the KEEP values of the statement that was written last, where they are others.
    fn note_keeps(&mut self) {
        let now = self.feed.keeps();
        if self.keeps.back().is_none_or(|(_, before)| *before != now) {
            self.keeps.push_back((self.writer.count() - 1, now));
        }
    }

    /// The KEEP values after a job of which `count` statements were begun; with `None` those of its
    /// end. The counts of later calls are not lower.
    pub fn keeps(&mut self, count: Option<u64>) -> Vec<i32> {
        let Some(count) = count else { return self.feed.keeps() };
        while self.keeps.get(1).is_some_and(|(from, _)| *from <= count) {
            self.keeps.pop_front();
        }
        self.keeps.front().map(|(_, values)| values.clone()).unwrap_or_default()
    }

    /// Statements of the machine written so far.
    pub fn count(&self) -> u64 {
        self.writer.count()
    }
}
