//! Trace mode: the board's events as lines of the trace (lang's `wire` module, Trace).

use lang::profile::Profile;
use lang::wire::{self, TRACE_LENGTH, TraceKind};

use super::print::LINE_END;
use super::status::long;
use super::{Client, ClientError};
use crate::board::teller;
use crate::link::Link;
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
}

/// After so many looks without an event the ring of printed text is emptied: a program that prints
/// a line longer than the ring waits for that.
const IDLE_LOOKS: u32 = 8;

impl<'a> Tracer<'a> {
    /// A reader for a run that is about to start. `line_of` gives the line of an address in the
    /// program's code.
    pub fn new(profile: Profile, line_of: LineOf<'a>) -> Tracer<'a> {
        Tracer { next: 1, profile, line_of, line: Vec::new(), idle: 0 }
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
        let slot = if self.next % 2 == 1 { wire::TRACE_ODD } else { wire::TRACE_EVEN };
        let words = client.holding(slot, TRACE_LENGTH)?;
        let [number, code, pc, low, high] = words[..] else { return Ok(None) };
        if number != self.next {
            self.idle += 1;
            if self.idle.is_multiple_of(IDLE_LOOKS) && self.line.last() != Some(&LINE_END) {
                self.line.extend(client.take_print_line()?);
            }
            return Ok(None);
        }
        self.idle = 0;
        let Some(kind) = TraceKind::from_number(code & 0xFF) else { return Ok(None) };
        let event = Event { kind, argument: (code >> 8) as u8, pc, value: long(low, high) };
        let what = self.decode(client, &event)?;
        self.next = self.next.wrapping_add(1);
        Ok(what)
    }

    fn decode<L: Link>(
        &mut self,
        client: &mut Client<L>,
        event: &Event,
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
        let mut commanded = [0; 3];
        if kind == TraceKind::End || placed.contains(&kind) {
            let words = client.holding(wire::COMMANDED, 6)?;
            commanded = [0, 2, 4].map(|at| long(words[at], words[at + 1]));
        }
        Ok(teller::event(&self.profile, line, kind, argument, value, commanded))
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
struct Event {
    kind: TraceKind,
    argument: u8,
    pc: u16,
    value: i32,
}
