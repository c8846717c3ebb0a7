//! Makes pieces of a job, and goes back in it when the board calls for a handler.

use std::collections::VecDeque;

use lang::effect::Effect;
use lang::fault::Fault;
use lang::isa::Op;
use lang::wire::Called;

use super::check::{CHECK, fails};
use super::feed::{BUDGET, Feed, Moment, Refused, Step};
use super::piece::{Piece, Writer, answers, failing};
use crate::client::stream::Call;
use crate::track::{Instruction, Track};

/// What stands at a place of a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// An effect; the moment is that before it is complete.
    Effect,
    /// A fault of the program's own.
    Fault,
    /// A handler was left; the moment is that behind it.
    Left,
    /// Something else; the moment is that behind it.
    Other,
}

/// A place that the board may call from.
#[derive(Debug)]
struct Mark {
    id: u64,
    /// Statements of the machine before it.
    count: u64,
    kind: Kind,
    moment: Moment,
}

/// How a job has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Over {
    /// With its last statement.
    Done,
    /// With a fault of its own that the board finds, too.
    Fails,
    /// With a fault at this line that no board finds.
    Broken(Fault, u32),
}

/// What follows a program that has ended, in a job that comes bit by bit.
pub enum More<'a> {
    /// Another program: the machine goes on as if it were the same.
    Feed(Feed<'a>),
    /// Nothing yet.
    Wait,
    /// Nothing.
    Over,
}

/// Asked for what follows, again and again while the answer is to wait.
pub type Source<'a> = Box<dyn FnMut() -> More<'a> + 'a>;

/// Where a job is to go on in its middle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Goal {
    /// At the first statement at or after a line, or where the job comes there the `pass`-th time.
    Line {
        /// From 1.
        line: u32,
        /// From 1.
        pass: u32,
    },
    /// At a statement of the machine.
    Effect {
        /// How many the job executes before it.
        number: u64,
        /// Its line.
        line: u32,
    },
}

/// Makes pieces of a job.
pub struct Job<'a> {
    feed: Feed<'a>,
    source: Option<Source<'a>>,
    writer: Writer,
    /// What did not fit into the last piece.
    held: Option<Step>,
    /// The program waits for an answer.
    waits: bool,
    /// It computes, and stands between two statements.
    thinks: bool,
    /// What was written last does not end its statement: the board serves no event behind it.
    within: bool,
    /// How much of the text that is being printed is in pieces.
    printed: usize,
    over: Option<Over>,
    /// Places of a program with handlers, those that the board has left behind excepted.
    marks: VecDeque<Mark>,
    /// The KEEP values with which statements were written, each with the count of statements
    /// before the first of them.
    keeps: VecDeque<(u64, Vec<i32>)>,
    /// What comes before the program's first statement, with its line.
    lead: VecDeque<Instruction>,
    lead_line: u32,
    /// It prints.
    pub prints: bool,
}

impl<'a> Job<'a> {
    /// A job for a board whose pieces hold `room` bytes of code and data.
    pub fn new(feed: Feed<'a>, room: usize) -> Job<'a> {
        let writer = Writer::new(&feed.image(), room);
        let keeps = VecDeque::from([(0, feed.keeps())]);
        Job {
            feed,
            source: None,
            writer,
            held: None,
            waits: false,
            thinks: false,
            within: false,
            printed: 0,
            over: None,
            marks: VecDeque::new(),
            keeps,
            lead: VecDeque::new(),
            lead_line: 1,
            prints: false,
        }
    }

    /// Skips to where the job is to go on: what comes before leaves its state only, as if no event came
    /// meanwhile. [`Job::lead`] brings the board there.
    ///
    /// # Errors
    /// There is no such line or pass, or what comes before it hangs on what the machine answers.
    pub fn skip(&mut self, goal: Goal, track: &mut Track) -> Result<(), Refused> {
        let (line, pass) = match goal {
            Goal::Line { line, pass } => (line, pass),
            Goal::Effect { line, .. } => (line, 1),
        };
        let mut effects = 0;
        let mut left = CHECK;
        // Line and address of the first effect there, and how often the job came to it.
        let mut there = (0, 0);
        let mut passes = 0;
        loop {
            match self.feed.step() {
                Step::Effect(effect, at) => {
                    let here = (at, self.feed.pc());
                    if let Goal::Effect { number, .. } = goal {
                        if effects == number {
                            break;
                        }
                        effects += 1;
                    } else if passes == 0 && at >= line || passes > 0 && here == there {
                        there = here;
                        passes += 1;
                        if passes == pass {
                            break;
                        }
                    }
                    if Track::is_open(&effect) {
                        let text = "what this does hangs on the machine, so the state behind it \
                                    is not known without running it";
                        return Err(Refused::new(at, text, "begin at an earlier line"));
                    }
                    match track.follow(&effect) {
                        Ok(()) => self.feed.complete(0),
                        Err(fault) => self.feed.fail(fault).map_err(|fault| fails(fault, at))?,
                    }
                }
                Step::Guard(..) | Step::Left(..) => {}
                Step::Thinks => left = left.saturating_sub(BUDGET.into()),
                Step::Fault(fault, at) => {
                    self.feed.fail(fault).map_err(|fault| fails(fault, at))?;
                }
                Step::End if passes > 0 => {
                    let text = format!("the job comes to this line {passes} times only");
                    return Err(Refused::new(there.0, text, "name an earlier pass"));
                }
                Step::End => {
                    let text = "the job is over before it comes to this line";
                    return Err(Refused::new(line, text, "name a line with a statement"));
                }
            }
            left = left.saturating_sub(1);
            if left == 0 {
                let text = "the job does not come to this line";
                return Err(Refused::new(line, text, "name a line with a statement"));
            }
        }
        if self.feed.is_in_handler() {
            let text = "this line belongs to an error's handler, which runs for that error only";
            return Err(Refused::new(line, text, "begin at a line outside of it"));
        }
        // What was executed before has been counted then.
        let (_, keeps) = self.keeps.front().cloned().unwrap_or_default();
        self.feed.set_keeps(&keeps);
        self.lead_line = line;
        Ok(())
    }

    /// The board does this before the program's first statement.
    pub fn lead(&mut self, list: impl IntoIterator<Item = Instruction>) {
        self.lead.extend(list);
    }

    /// Writes what comes first, a piece's worth; `false` when more of it is left.
    fn write_lead(&mut self) -> bool {
        let leads = !self.lead.is_empty();
        while let Some((values, code)) = self.lead.front() {
            // An event comes behind all of it at the earliest.
            self.within = self.feed.has_handlers();
            if !self.writer.put(self.lead_line, (values, code), None, self.within) {
                return false;
            }
            self.lead.pop_front();
        }
        if leads && self.feed.is_guarded() {
            return self.writer.put_control(self.lead_line, &guard(true));
        }
        true
    }

    /// More programs follow when this one has ended: without handlers and KEEP values, for the same
    /// machine.
    pub fn follow_with(&mut self, source: Source<'a>) {
        self.source = Some(source);
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

    /// How the program has ended, once it has.
    pub fn over(&self) -> Option<Over> {
        self.over
    }

    /// Whether all that came so far is written, and its source has nothing more for now.
    pub fn awaits_more(&self) -> bool {
        self.source.is_some() && self.over.is_none() && self.held == Some(Step::End)
    }

    /// Whether the board may call for handlers of events.
    pub fn has_events(&self) -> bool {
        self.feed.has_events()
    }

    /// The next piece; `None` while the program computes, waits for an answer, or is over.
    pub fn piece(&mut self) -> Option<Piece> {
        if self.over.is_some() {
            return self.last();
        }
        if self.waits {
            return None;
        }
        self.thinks = false;
        if !self.write_lead() {
            return Some(self.writer.finish(false));
        }
        loop {
            let step = self.held.take().unwrap_or_else(|| self.feed.step());
            let written = match step {
                Step::Effect(effect, line) => match self.effect(&effect, line) {
                    Some(asks) if asks => {
                        self.waits = true;
                        return Some(self.writer.finish(true));
                    }
                    written => written.is_some(),
                },
                Step::Guard(on, line) => self.control(line, &guard(on), Kind::Other),
                Step::Left(all, line) => {
                    let op = if all { Op::Leave } else { Op::ResumeNext };
                    self.control(line, &[op.code()], Kind::Left)
                }
                Step::Thinks => return self.think(),
                Step::End => match self.source.as_mut().map_or(More::Over, |source| source()) {
                    More::Feed(feed) => {
                        self.writer.admit(&feed.image());
                        self.feed = feed;
                        continue;
                    }
                    More::Wait => {
                        self.held = Some(Step::End);
                        return self.last();
                    }
                    More::Over => {
                        self.over = Some(Over::Done);
                        return self.last();
                    }
                },
                Step::Fault(fault, line) => match failing(fault) {
                    Some(code) if self.control(line, &code, Kind::Fault) => {
                        self.over = Some(Over::Fails);
                        return self.last();
                    }
                    Some(_) => false,
                    None => {
                        self.over = Some(Over::Broken(fault, line));
                        return self.last();
                    }
                },
            };
            if !written {
                if self.writer.is_empty() {
                    // Not even alone: no board has so little room.
                    self.over = Some(Over::Broken(Fault::ImageRefused, self.feed.line()));
                    return self.last();
                }
                self.held = Some(step);
                return Some(self.writer.finish(false));
            }
        }
    }

    /// Writes an effect, or as much of its text as the piece holds; `None` when it is full, otherwise
    /// whether it asks.
    fn effect(&mut self, effect: &Effect, line: u32) -> Option<bool> {
        let (values, code, text) = self.feed.instruction(effect);
        let asks = answers(effect);
        loop {
            // A text may be longer than a piece: its parts follow one another.
            let rest = text.map(|text| text.get(self.printed..).unwrap_or_default());
            let part = rest.map(|rest| &rest[..rest.len().min(self.writer.text_room())]);
            if part.is_some_and(|part| part.is_empty() && text != Some(&[])) {
                return None;
            }
            let parted = part.map(<[u8]>::len) < rest.map(<[u8]>::len);
            // An event is served behind a whole statement only, and a value is part of one.
            let within = self.feed.is_within() || parted || asks;
            let more = within && self.feed.has_handlers();
            self.mark(Kind::Effect);
            if !self.writer.put(line, (&values, code), part, more) {
                self.unmark();
                return None;
            }
            self.within = more;
            if !parted {
                break;
            }
            self.printed += part.map_or(0, <[u8]>::len);
        }
        self.printed = 0;
        self.note_keeps();
        self.prints |= *effect == Effect::PrintEnd;
        if !asks {
            self.feed.complete(0);
        }
        Some(asks)
    }

    /// Writes what is no statement of the machine; `false` when the piece is full.
    fn control(&mut self, line: u32, code: &[u8], kind: Kind) -> bool {
        self.mark(kind);
        let written = self.writer.put_control(line, code);
        if written {
            self.within = false;
        } else {
            self.unmark();
        }
        written
    }

    /// What was written goes out while the program computes; with nothing written the board learns
    /// that a statement is over.
    fn think(&mut self) -> Option<Piece> {
        self.thinks = self.feed.is_between();
        if self.writer.is_empty() {
            if !(self.within && self.thinks) {
                return None;
            }
            self.mark(Kind::Other);
            self.writer.place(self.feed.line());
            self.within = false;
        }
        Some(self.writer.finish(false))
    }

    /// What is left when the program has ended.
    fn last(&mut self) -> Option<Piece> {
        let left = !self.writer.is_empty() || self.writer.answers();
        left.then(|| self.writer.finish(false))
    }

    /// Remembers where the program stands for the place that is written next.
    fn mark(&mut self, kind: Kind) {
        if self.feed.has_handlers() {
            let (id, count) = (self.writer.next_id(), self.writer.count());
            self.marks.push_back(Mark { id, count, kind, moment: self.feed.moment() });
        }
    }

    fn unmark(&mut self) {
        if self.feed.has_handlers() {
            self.marks.pop_back();
        }
    }

    /// The board has left the places before this one behind.
    pub fn pass(&mut self, id: u64) {
        while self.marks.front().is_some_and(|mark| mark.id < id) {
            self.marks.pop_front();
        }
    }

    /// The board calls for a handler at the place `id`: the job goes on there, with a piece of this
    /// number.
    pub fn rewind(&mut self, id: u64, call: Call, number: u16) {
        // It was idle and the program computes since: that need not be done again.
        let newest = self.writer.next_id() == id + 1 && self.writer.is_empty();
        let as_is = call.place == Called::Idle && self.thinks && newest;
        let Ok(at) = self.marks.binary_search_by_key(&id, |mark| mark.id) else {
            self.over = Some(Over::Broken(Fault::ImageRefused, self.feed.line()));
            self.writer.rewind(number, self.writer.count());
            return;
        };
        self.marks.truncate(at + 1);
        let mark = &self.marks[at];
        let mut count = mark.count;
        if !as_is {
            self.feed.restore(&mark.moment);
        }
        if mark.kind == Kind::Effect {
            let again = call.place == Called::Within && call.fault.is_some();
            count += u64::from(!again);
            let behind = matches!(call.place, Called::Behind | Called::Idle);
            if behind && !as_is {
                self.feed.complete(0);
            }
        }
        let resumed = mark.kind == Kind::Left;
        self.writer.rewind(number, count);
        self.held = None;
        self.waits = false;
        self.thinks = false;
        self.within = false;
        self.printed = 0;
        self.over = None;
        while self.keeps.len() > 1 && self.keeps.back().is_some_and(|(from, _)| *from >= count) {
            self.keeps.pop_back();
        }
        let line = self.feed.line();
        if let Err(fault) = self.feed.enter(call, resumed) {
            self.over = Some(Over::Broken(fault, line));
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

    /// Where the program stands, for its variables.
    pub fn feed(&self) -> &Feed<'a> {
        &self.feed
    }
}

/// ON ERROR for the board, to which only matters whether there is a handler.
fn guard(on: bool) -> Vec<u8> {
    if on { vec![Op::OnError.code(), 0, 0] } else { vec![Op::OnErrorStop.code()] }
}
