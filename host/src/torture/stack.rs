//! The machine stack: how deep it has ever been, by the board's own watermark and by the emulator's
//! record of the stack pointer, under generated programs, hands and requests.

use std::sync::atomic::{AtomicU16, Ordering};

use emulator::{Config, Rng};
use lang::part::G2553;
use lang::wire::{Control, STACK_FREE};

use super::generate::{Case, generate_for};
use super::line::any_request;
use super::people::{People, Roles};
use super::programs::{Made, make_for, tape};
use super::stand::{Fresh, Stand};
use super::{Row, Settings, Sink, Verdict};
use crate::board::Build;
use crate::board::health::{stack_left, stack_used};
use crate::board::size::budget;

/// Bytes that must stay unused at the deepest point: what interrupts that nothing here lets come together may take, on
/// the chip with RAM for that.
fn margin(build: &Build) -> u16 {
    if build.part.chip.family == G2553.chip.family { 24 } else { 512 }
}

/// The watermark counts what was written: a frame that was opened and not written to, or a value
/// that is the paint by chance, may hide so many bytes.
const UNSEEN: u16 = 8;

/// Runs a program with hands and requests; the bytes of stack that were used, and those that never
/// were.
///
/// # Errors
/// The margin is too small, or the board's watermark is not what the emulator saw.
pub fn try_out(build: &Build, stand: Stand, made: &Made, mut rng: Rng) -> Result<[u16; 2], String> {
    let seed = rng.bits();
    let mut people = People::new(stand, made, Rng::new(seed), Roles::Default)?;
    people.play()?;
    let stand = people.stand();
    for _ in 0..20 {
        stand.exchange(&any_request(&mut rng));
    }
    stand.control(Control::Stop);
    stand.board.run_us(200_000);
    let told = stand.read(STACK_FREE).ok_or("no answer about the stack")?;
    let truly = stack_left(&stand.board).ok_or("the image does not say where its stack ends")?;
    if told < truly || told - truly > UNSEEN {
        return Err(format!("{told} bytes by the watermark, {truly} by the stack pointer"));
    }
    let used = stack_used(build, &stand.board).ok_or("nothing was ever on the stack")?;
    let most = budget(build)?.stack;
    if used > most {
        return Err(format!("{used} bytes of stack were used, {most} in firmware/budget.toml"));
    }
    let margin = margin(build);
    match truly >= margin {
        true => Ok([used, truly]),
        false => Err(format!("{truly} bytes of stack were left, not {margin}")),
    }
}

/// The worst depth of the stack.
///
/// # Errors
/// The shipped firmware is damaged, or the table cannot be written.
pub fn run(settings: &Settings, sink: Sink<'_>) -> Result<(), String> {
    settings.builds.iter().try_for_each(|build| on_boards(build, settings, sink))
}

fn on_boards(build: &Build, settings: &Settings, sink: Sink<'_>) -> Result<(), String> {
    let fault = "depth under all of it";
    let mut row = Row::on(build, "stack", fault, settings);
    let fresh = Fresh::new(Stand::new(build, &Config::default())?);
    let (most, least) = (AtomicU16::new(0), AtomicU16::new(u16::MAX));
    row.run(settings, settings.count(8, 300, 3_000), |n| {
        let case = generate_for(build.part, &tape(settings, fault, n));
        let Some(made) = make_for(build, Case { world: String::new(), ..case }) else {
            return Verdict::Skipped;
        };
        match try_out(build, fresh.copy(), &made, settings.rng(fault, n)) {
            Ok([used, left]) => {
                most.fetch_max(used, Ordering::Relaxed);
                least.fetch_min(left, Ordering::Relaxed);
                Verdict::Survived
            }
            Err(text) => Verdict::Lost(text),
        }
    });
    let (most, least) = (most.into_inner(), least.into_inner());
    row.note = format!("{most} bytes used, {least} never, {} must be", margin(build));
    sink(row)
}
