//! Trace mode: the board's events as lines of the trace (lang's `wire` module, Trace).

use std::collections::VecDeque;

use lang::profile::Profile;
use lang::wire::{self, TRACE_LENGTH, TRACE_QUEUE_LENGTH, TRACE_QUEUED, TraceKind};

use super::print::LINE_END;
use super::status::long;
use super::{Client, ClientError};
use crate::link::Link;
use crate::sim::told;
use crate::sim::trace::What;

/// Line of an address in a program's code.
pub type LineOf<'a> = Box<dyn Fn(u16) -> u32 + 'a>;

/// Reads a board's events one after the other.
pub struct Tracer<'a> {
    /// Number of the event that comes next.
    next: u16,
    profile: Profile,
    /// Line of an address in the code.
    line_of: LineOf<'a>,
    /// What has come of the line that the next print event ends.
    line: Vec<u8>,
    /// Looks that found no event since one did.
    idle: u32,
    /// Events of a board that queues them, which were received and not told yet.
    queue: Option<VecDeque<(Event, [i32; 3])>>,
}

/// Events of a queue that one request brings, which a board's frame of 136 bytes holds.
const AT_ONCE: u16 = 6;

impl<L: Link> Client<L> {
    /// Begins trace mode: with a queue if the board has one and the host halts no program. Tells whether there is one.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn begin_trace(&mut self, halts: bool) -> Result<bool, ClientError> {
        let queued = !halts && self.holding(wire::TRACE_ROOM, 1)?[0] >= AT_ONCE;
        self.write(wire::TRACE_MODE, if queued { TRACE_QUEUED } else { 1 })?;
        Ok(queued)
    }

    /// Takes up to `most` events from the board's queue, of which `next` is the first that was not received.
    fn take_events(
        &mut self,
        next: u16,
        most: u16,
    ) -> Result<VecDeque<(Event, [i32; 3])>, ClientError> {
        let words = self.holding(wire::TRACE_QUEUE, most * TRACE_QUEUE_LENGTH)?;
        let mut events = VecDeque::new();
        let mut number = next;
        for words in words.chunks_exact(usize::from(TRACE_QUEUE_LENGTH)) {
            let Some(kind) = TraceKind::from_number(words[1] & 0xFF).filter(|_| words[0] == number)
            else {
                break;
            };
            let value = long(words[3], words[4]);
            let event = Event { kind, argument: (words[1] >> 8) as u8, pc: words[2], value };
            events.push_back((event, [5, 7, 9].map(|at| long(words[at], words[at + 1]))));
            number = number.wrapping_add(1);
        }
        // Writing the same number again takes nothing more, so a lost reply does no harm.
        if !events.is_empty() {
            self.write(wire::TRACE_TAKEN, number.wrapping_sub(1))?;
        }
        Ok(events)
    }
}

/// After so many looks without an event the ring of printed text is emptied: a program that prints
/// a line longer than the ring waits for that.
const IDLE_LOOKS: u32 = 8;

impl<'a> Tracer<'a> {
    /// A reader for a run that is about to start. `line_of` gives the line of an address in the
    /// program's code.
    pub fn new(profile: Profile, line_of: LineOf<'a>) -> Tracer<'a> {
        Tracer { next: 1, profile, line_of, line: Vec::new(), idle: 0, queue: None }
    }

    /// The same for a board that queues its events, as [`Client::begin_trace`] tells.
    #[must_use]
    pub fn queued(mut self, queued: bool) -> Tracer<'a> {
        self.queue = queued.then(VecDeque::new);
        self
    }

    /// A reader for a run that goes on already, whose newest event has number `last`.
    pub fn behind(profile: Profile, line_of: LineOf<'a>, last: u16) -> Tracer<'a> {
        Tracer { next: last.wrapping_add(1), ..Tracer::new(profile, line_of) }
    }

    /// Behind RUN: the lines of the program that runs now. Without this all of its lines are 0.
    pub fn turn(&mut self, line_of: LineOf<'a>) {
        self.line_of = line_of;
    }

    /// Tells the board that its reader is still there, without taking another event: for a host that
    /// halts the program.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn hold<L: Link>(&self, client: &mut Client<L>) -> Result<(), ClientError> {
        let slot = if self.next.is_multiple_of(2) { wire::TRACE_ODD } else { wire::TRACE_EVEN };
        client.holding(slot, 1).map(|_| ())
    }

    /// The next event, if it has happened.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn poll<L: Link>(&mut self, client: &mut Client<L>) -> Result<Option<What>, ClientError> {
        let found = match &mut self.queue {
            Some(queue) => {
                if queue.is_empty() {
                    // A look at an empty queue shall not take longer than it must.
                    let most = if self.idle == 0 { AT_ONCE } else { 1 };
                    *queue = client.take_events(self.next, most)?;
                }
                queue.pop_front().map(|(event, commanded)| (event, Some(commanded)))
            }
            None => self.slot(client)?.map(|event| (event, None)),
        };
        let Some((event, commanded)) = found else {
            self.idle += 1;
            if self.idle.is_multiple_of(IDLE_LOOKS) && self.line.last() != Some(&LINE_END) {
                self.line.extend(client.take_print_line()?);
            }
            return Ok(None);
        };
        self.idle = 0;
        let what = self.decode(client, &event, commanded)?;
        self.next = self.next.wrapping_add(1);
        Ok(what)
    }

    /// The next event in its slot, if it has happened.
    fn slot<L: Link>(&self, client: &mut Client<L>) -> Result<Option<Event>, ClientError> {
        let slot = if self.next % 2 == 1 { wire::TRACE_ODD } else { wire::TRACE_EVEN };
        let words = client.holding(slot, TRACE_LENGTH)?;
        let [number, code, pc, low, high] = words[..] else { return Ok(None) };
        let kind = TraceKind::from_number(code & 0xFF).filter(|_| number == self.next);
        let argument = (code >> 8) as u8;
        Ok(kind.map(|kind| Event { kind, argument, pc, value: long(low, high) }))
    }

    /// What an event says; where the axes were told to go then is asked for if it is not known.
    fn decode<L: Link>(
        &mut self,
        client: &mut Client<L>,
        event: &Event,
        commanded: Option<[i32; 3]>,
    ) -> Result<Option<What>, ClientError> {
        let line = (self.line_of)(event.pc);
        let Event { kind, argument, value, .. } = *event;
        if kind == TraceKind::Print {
            return Ok(Some(What::Print { line, text: self.printed_line(client)? }));
        }
        if kind == TraceKind::Run {
            // What follows stands in code that this reader does not know.
            self.line_of = Box::new(|_| 0);
            return Ok(Some(What::Run { line, program: client.program_name(argument)? }));
        }
        let placed = [TraceKind::Axe, TraceKind::Rapid, TraceKind::Line, TraceKind::Arc];
        let commanded = match commanded {
            Some(commanded) => commanded,
            None if kind == TraceKind::End || placed.contains(&kind) => {
                let words = client.holding(wire::COMMANDED, 6)?;
                [0, 2, 4].map(|at| long(words[at], words[at + 1]))
            }
            None => [0; 3],
        };
        let what = told::event(&self.profile, line, kind, argument, value, commanded);
        what.map(|what| client.explain_end(what)).transpose()
    }

    /// Takes bytes of print up to the line's end. A board that never ends a line is given up after
    /// more than any line has.
    fn printed_line<L: Link>(&mut self, client: &mut Client<L>) -> Result<String, ClientError> {
        const LONGEST: usize = 4096;
        let mut line = std::mem::take(&mut self.line);
        let mut silent = 0;
        while line.last() != Some(&LINE_END) && line.len() < LONGEST && silent < 1000 {
            let bytes = client.take_print_line()?;
            silent = if bytes.is_empty() { silent + 1 } else { 0 };
            line.extend(bytes);
        }
        line.pop_if(|byte| *byte == LINE_END);
        Ok(String::from_utf8_lossy(&line).into_owned())
    }
}

/// What a slot holds.
#[derive(Debug)]
struct Event {
    kind: TraceKind,
    argument: u8,
    pc: u16,
    value: i32,
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use lang::profile::Profile;
    use lang::wire::Control;

    use super::{Client, Tracer};
    use crate::bench::stand::{Stand, image_for};
    use crate::board::F5529;
    use crate::link::Link;
    use crate::sim::trace::What;

    /// Bursts of events with rests between them, in which the host catches up.
    const SCRIPT: &str = "REPEAT 12\n  SetOut 3, ON\n  PRINT \"hole\"\n  SetOut 4, ON\n  \
        SetOut 3, OFF\n  SetOut 4, OFF\n  Wait 60ms\nEND REPEAT\n";

    /// The events of a run and how long it took.
    fn run<L: Link>(
        client: &mut Client<L>,
        profile: &Profile,
        halts: bool,
    ) -> (Vec<What>, Duration) {
        let queued = client.begin_trace(halts).expect("trace mode");
        assert_eq!(queued, !halts, "an F5529 has a queue");
        let mut tracer = Tracer::new(profile.clone(), Box::new(u32::from)).queued(queued);
        client.control(Control::Start).expect("it starts");
        let begun = client.link().now();
        let mut events = Vec::new();
        while !matches!(events.last(), Some(What::End { .. })) {
            events.extend(tracer.poll(client).expect("an answer"));
        }
        (events, client.link().now() - begun)
    }

    #[test]
    fn a_queue_of_events_tells_the_same_and_halts_nothing() {
        let profile = Profile::built_in("mill").expect("built in");
        let (_, image) = image_for(&profile, SCRIPT).expect("sound");
        let mut stand = Stand::on(&F5529, &profile).expect("the shipped image");
        stand.upload(&image).expect("it is taken");
        let (one_by_one, slow) = run(stand.client(), &profile, true);
        let (queued, fast) = run(stand.client(), &profile, false);
        assert_eq!(format!("{queued:?}"), format!("{one_by_one:?}"));
        assert_eq!(queued.len(), 12 * 6 + 1);
        let own = Duration::from_millis(12 * 60);
        assert!(slow > own + Duration::from_millis(12 * 5 * 8), "one by one: {slow:?}");
        assert!(fast < own + Duration::from_millis(60), "queued: {fast:?}");
    }
}
