//! What was observed of a board, as lines of the trace.

use lang::axis::Axis;
use lang::fault::Fault;
use lang::profile::Profile;
use lang::wire::{End, Seen, TRACE_OK, TraceKind};

use super::observe::{Observed, Sight};
use crate::client::print::LINE_END;
use crate::sim::trace::{AxisLetter, MoveKind, PerAxis, Status, What};

/// Bytes kept of a printed line.
const LONGEST: usize = 4096;

/// Puts the trace together.
pub struct Teller<'a> {
    profile: &'a Profile,
    /// Line of an address in the program's code.
    line_of: &'a dyn Fn(u16) -> u32,
    /// What has come of the line that is being printed.
    printed: Vec<u8>,
}

impl<'a> Teller<'a> {
    /// For a run that is about to start.
    pub fn new(profile: &'a Profile, line_of: &'a dyn Fn(u16) -> u32) -> Teller<'a> {
        Teller { profile, line_of, printed: Vec::new() }
    }

    /// The line that this makes, if it makes one.
    pub fn tell(&mut self, observed: &Observed) -> Option<What> {
        let line = (self.line_of)(observed.pc);
        match observed.sight {
            Sight::Beside(Seen::Byte, LINE_END) => {
                let text = std::mem::take(&mut self.printed);
                Some(What::Print { line, text: String::from_utf8_lossy(&text).into_owned() })
            }
            Sight::Beside(Seen::Byte, byte) => {
                if self.printed.len() < LONGEST {
                    self.printed.push(byte);
                }
                None
            }
            Sight::Beside(Seen::Begun | Seen::Abandoned, _) => {
                self.printed.clear();
                None
            }
            Sight::Event { kind, argument, value, commanded } => {
                event(self.profile, line, kind, argument, value, commanded)
            }
        }
    }
}

/// The line that an event of the board makes; `None` for the one that only says that a line of text
/// waits, and for an axis that the machine lacks.
pub fn event(
    profile: &Profile,
    line: u32,
    kind: TraceKind,
    argument: u8,
    value: i32,
    commanded: [i32; 3],
) -> Option<What> {
    let ok = argument & TRACE_OK != 0;
    let number = i32::from(argument & !TRACE_OK);
    let axis = || Axis::from_index(usize::from(argument & !TRACE_OK)).map(AxisLetter);
    let places = Axis::ALL.map(|axis| profile.axis(axis).map(|_| commanded[axis.index()]));
    let to = PerAxis::new(places);
    let on = u8::from(value != 0);
    let movement = |kind| Some(What::Move { line, kind, to });
    match kind {
        TraceKind::None | TraceKind::Print => None,
        TraceKind::Home => axis().map(|axis| What::Home { line, axis, ok, pos: value }),
        TraceKind::Axe => movement(MoveKind::Axe),
        TraceKind::Rapid => movement(MoveKind::Rapid),
        TraceKind::Line => movement(MoveKind::Line),
        TraceKind::Arc => movement(MoveKind::Arc),
        TraceKind::Out => Some(What::Out { line, n: number, v: on }),
        TraceKind::Wait => Some(What::Wait { line, ms: value }),
        TraceKind::WaitIn => Some(What::WaitIn { line, n: number, v: on, ok }),
        TraceKind::Probe => axis().map(|axis| What::Probe { line, axis, ok, pos: value }),
        TraceKind::Send => Some(What::Send { line, c: value }),
        TraceKind::WaitChar => Some(What::WaitChar { line, c: value, ok }),
        TraceKind::WaitStart => Some(What::WaitStart { line }),
        TraceKind::Speed => axis().map(|axis| What::Speed { line, axis, v: value }),
        TraceKind::Stop => axis()
            .filter(|axis| profile.axis(axis.0).is_some())
            .map(|axis| What::Stop { line, axis }),
        TraceKind::End => {
            let status = match End::from_number(argument.into()) {
                Some(End::Fault) => Status::Fault,
                Some(End::Stopped) => Status::Stopped,
                _ => Status::Done,
            };
            let fault = u8::try_from(value).ok().and_then(Fault::from_number);
            let fault = fault.filter(|_| status == Status::Fault);
            Some(What::end(status, fault, line, to))
        }
    }
}
