//! When things happen: each event of a generated program comes on the simulated machine when it comes on the emulated
//! board, but for a millisecond, or a thousandth of the time where that is more.

use std::sync::Mutex;

use super::generate::generate_still;
use super::programs::{Made, make_for, on_board_timed, on_host_timed, reference, tape};
use super::{Row, Settings, Sink, Verdict};
use crate::board::F5529;
use crate::sim::trace::{Event, What, to_text};

/// How far the machine's times may be from the board's, us, or a thousandth of the time where that is more.
pub const LATER_US: f64 = 1_000.0;
/// How late a wait may find at most what the world does at the same time for both, us: a filter's look.
const FOUND_US: f64 = 5_000.0;

/// Whether an event ends a wait for the world, which may have ended it at its own time.
fn is_of_the_world(what: &What) -> bool {
    match what {
        What::WaitIn { ok, .. } | What::WaitChar { ok, .. } => *ok,
        What::WaitStart { .. } => true,
        _ => false,
    }
}

/// The largest difference of two runs' times, in what is allowed of it: `later_us`, or a thousandth of the time where
/// that is more. Counted from the last reference run on, where a switch is met by a look that each of the two has at its
/// own time, and again from each wait that the world ends: it does so at its own times, which are those of the run on
/// both.
///
/// # Errors
/// The runs have not the same number of events, or some have no times.
pub fn apart(machine: &[Event], board: &[Event], later_us: f64) -> Result<(f64, String), String> {
    if machine.len() != board.len() {
        return Err(format!("{} events, {} on the board", machine.len(), board.len()));
    }
    let us = |event: &Event| event.us.map(|us| us as f64).ok_or("an event has no time");
    let homed = board.iter().rposition(|event| matches!(event.what, What::Home { .. }));
    let mut base = match homed {
        Some(n) => us(&machine[n])? - us(&board[n])?,
        None => 0.0,
    };
    let mut most = (0.0, String::new());
    for (machine, board) in machine.iter().zip(board).skip(homed.unwrap_or(0)) {
        let at = us(board)?;
        let off = us(machine)? - at;
        let allowed = later_us.max(at / 1000.0);
        if is_of_the_world(&board.what) && off.abs() <= FOUND_US.max(allowed) {
            base = off;
        }
        let off = off - base;
        if off.abs() / allowed > most.0 {
            most = (off.abs() / allowed, format!("{off:+} us at {at} us, {:?}", board.what));
        }
    }
    Ok(most)
}

/// A program on both: the share of [`apart`] that it takes, and where; `None` where the board cannot be held to it.
///
/// # Errors
/// A run fails, or the two have other events.
pub fn try_out(made: &Made) -> Result<Option<(f64, String)>, String> {
    if reference(F5529.part, made).is_none() {
        return Ok(None);
    }
    let machine = on_host_timed(made).map_err(|error| error.to_string())?;
    let board = on_board_timed(&F5529, made).map_err(|error| error.to_string())?;
    let (share, place) = apart(&machine, &board, LATER_US)
        .map_err(|error| format!("{error}\n{}board:\n{}", to_text(&machine), to_text(&board)))?;
    Ok(Some((share, place)))
}

/// Generated programs on the simulated machine and on the emulated MSP430F5529.
///
/// # Errors
/// The table cannot be written.
pub fn run(settings: &Settings, sink: Sink<'_>) -> Result<(), String> {
    if !settings.builds.iter().any(|build| build.part == F5529.part) {
        return Ok(());
    }
    let fault = "generated, vm and board";
    let mut row = Row::on(&F5529, "times", fault, settings);
    let most = Mutex::new((0.0, 0));
    row.run(settings, settings.count(12, 300, 1_800), |n| {
        let made = make_for(&F5529, generate_still(F5529.part, &tape(settings, fault, n)));
        let Some(made) = made else { return Verdict::Skipped };
        match try_out(&made) {
            Ok(None) => Verdict::Skipped,
            Ok(Some((share, place))) => {
                if let Ok(mut most) = most.lock()
                    && share > most.0
                {
                    *most = (share, n);
                }
                match share <= 1.0 {
                    true => Verdict::Survived,
                    false => Verdict::Lost(format!("{place}\n{}", made.case.script)),
                }
            }
            Err(text) => {
                Verdict::Lost(format!("{text}\n{}\n// {}", made.case.script, made.case.world))
            }
        }
    });
    let (share, n) = most.into_inner().unwrap_or_default();
    row.note = format!("at most {:.0} % of 1 ms or a thousandth, case {n}", share * 100.0);
    sink(row)
}
