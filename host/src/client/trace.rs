//! Trace mode: the board's events as lines of the trace (lang's `wire` module, Trace).

use lang::axis::Axis;
use lang::fault::Fault;
use lang::profile::Profile;
use lang::wire::{self, End, TRACE_LENGTH, TRACE_OK, TraceKind};

use super::print::LINE_END;
use super::status::long;
use super::{Client, ClientError};
use crate::link::Link;
use crate::sim::trace::{AxisLetter, MoveKind, PerAxis, Status, What};

/// Reads a board's events one after the other.
pub struct Tracer<'a> {
    /// Number of the event that comes next.
    next: u16,
    profile: &'a Profile,
    /// Line of an address in the code.
    line_of: &'a dyn Fn(u16) -> u32,
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
    pub fn new(profile: &'a Profile, line_of: &'a dyn Fn(u16) -> u32) -> Tracer<'a> {
        Tracer { next: 1, profile, line_of, line: Vec::new(), idle: 0 }
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
        let Event { argument, value, .. } = *event;
        let ok = argument & TRACE_OK != 0;
        let number = i32::from(argument & !TRACE_OK);
        let axis = || Axis::from_index(usize::from(argument & !TRACE_OK)).map(AxisLetter);
        Ok(match event.kind {
            TraceKind::None => None,
            TraceKind::Home => axis().map(|axis| What::Home { line, axis, ok, pos: value }),
            TraceKind::Axe => Some(self.movement(client, line, MoveKind::Axe)?),
            TraceKind::Rapid => Some(self.movement(client, line, MoveKind::Rapid)?),
            TraceKind::Line => Some(self.movement(client, line, MoveKind::Line)?),
            TraceKind::Arc => Some(self.movement(client, line, MoveKind::Arc)?),
            TraceKind::Out => Some(What::Out { line, n: number, v: (value != 0).into() }),
            TraceKind::Wait => Some(What::Wait { line, ms: value }),
            TraceKind::WaitIn => Some(What::WaitIn { line, n: number, v: (value != 0).into(), ok }),
            TraceKind::Probe => axis().map(|axis| What::Probe { line, axis, ok, pos: value }),
            TraceKind::Print => Some(What::Print { line, text: self.printed_line(client)? }),
            TraceKind::Send => Some(What::Send { line, c: value }),
            TraceKind::WaitChar => Some(What::WaitChar { line, c: value, ok }),
            TraceKind::WaitStart => Some(What::WaitStart { line }),
            TraceKind::Speed => axis().map(|axis| What::Speed { line, axis, v: value }),
            TraceKind::Stop => axis()
                .filter(|axis| self.profile.axis(axis.0).is_some())
                .map(|axis| What::Stop { line, axis }),
            TraceKind::End => {
                let status = match End::from_number(argument.into()) {
                    Some(End::Fault) => Status::Fault,
                    Some(End::Stopped) => Status::Stopped,
                    _ => Status::Done,
                };
                let fault = u8::try_from(value).ok().and_then(Fault::from_number);
                let fault = fault.filter(|_| status == Status::Fault);
                Some(What::end(status, fault, line, self.commanded(client)?))
            }
        })
    }

    fn movement<L: Link>(
        &self,
        client: &mut Client<L>,
        line: u32,
        kind: MoveKind,
    ) -> Result<What, ClientError> {
        Ok(What::Move { line, kind, to: self.commanded(client)? })
    }

    /// Commanded positions of the axes that the machine has.
    fn commanded<L: Link>(&self, client: &mut Client<L>) -> Result<PerAxis, ClientError> {
        let words = client.holding(wire::COMMANDED, 6)?;
        Ok(PerAxis::new(Axis::ALL.map(|axis| {
            let at = 2 * axis.index();
            self.profile.axis(axis).map(|_| long(words[at], words[at + 1]))
        })))
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
