//! Formats events of the machine as lines of the trace.

use lang::axis::Axis;
use lang::fault::Fault;
use lang::profile::Profile;
use lang::wire::{End, TRACE_OK, TRACE_SHARE, TraceKind};

use super::trace::{AxisLetter, MoveKind, PerAxis, Status, What};

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
        // Who knows the programs' names tells it.
        TraceKind::None | TraceKind::Print | TraceKind::Run => None,
        TraceKind::Home => axis().map(|axis| What::Home { line, axis, ok, pos: value }),
        TraceKind::Axe => movement(MoveKind::Axe),
        TraceKind::Rapid => movement(MoveKind::Rapid),
        TraceKind::Line => movement(MoveKind::Line),
        TraceKind::Arc => movement(MoveKind::Arc),
        TraceKind::Out => {
            Some(What::Out { line, n: number, v: on, sync: ok, pos: ok.then_some(to) })
        }
        TraceKind::Aout => {
            let is_share = argument & TRACE_SHARE != 0;
            let (mv, share) = if is_share { (None, Some(value)) } else { (Some(value), None) };
            let n = number & !i32::from(TRACE_SHARE);
            Some(What::Aout { line, n, mv, share, sync: ok, pos: ok.then_some(to) })
        }
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
