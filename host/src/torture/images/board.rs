//! Damaged images through the upload of the emulated board: refused without a trace, or run
//! without an error of stack or program counter.

use std::sync::atomic::{AtomicU64, Ordering};

use emulator::{Config, Rng, WarningKind};
use firmware::verify::model::{Limits, verify};
use firmware::verify::{Bytes, sound};
use lang::fault::Fault;
use lang::image::Image;
use lang::wire::{Control, FAULT, PROGRAM_COUNTER, RUN_COUNT, Refusal, RunState};

use super::super::stand::{Answer, Fresh, Stand};
use super::super::{Row, Settings, Sink, Verdict};
use super::{corpus, damaged, judge};
use crate::board::Build;

/// The run is looked at so often, and so long apart, us.
const LOOKS: u64 = 6;
const LOOK_US: u64 = 15_000;
/// Longest time that a stop may take, in looks.
const STOP_LOOKS: u64 = 400;

struct Flat<'a>(&'a [u8]);

impl Bytes for Flat<'_> {
    fn byte(&self, offset: u16) -> u8 {
        self.0.get(usize::from(offset)).copied().unwrap_or(0xFF)
    }
}

/// What the device is to do with an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// Take it: the device's rules and the host's allow it.
    Take,
    /// Refuse it.
    Refuse,
    /// Either: the device takes flags on trust that the host's verifier knows.
    Either,
}

/// What a device is to do with an image.
pub fn wanted(build: &Build, image: &[u8]) -> Wanted {
    let flat = Flat(image);
    let part = &build.part;
    if sound(&flat, part.room_for(false) as u16)
        .is_none_or(|length| usize::from(length) != image.len())
        || verify(&flat, &Limits::of(part)).is_err()
    {
        return Wanted::Refuse;
    }
    match judge::is_accepted(image) {
        true => Wanted::Take,
        false => Wanted::Either,
    }
}

/// What the chip forbids and no image may bring about.
fn broken_rule(stand: &Stand) -> Option<String> {
    let bad = |kind| {
        matches!(
            kind,
            WarningKind::Unmapped
                | WarningKind::Unaligned
                | WarningKind::FetchFault
                | WarningKind::IllegalInstruction
                | WarningKind::RegisterWidth
                | WarningKind::FlashLocked
                | WarningKind::Key
                | WarningKind::Stack
        )
    };
    let found = stand.board.warnings().iter().find(|warning| bad(warning.kind));
    found.map(|warning| format!("the emulator warns: {warning}"))
}

fn pulses(stand: &Stand) -> u64 {
    stand.board.plant().motors.iter().map(|motor| motor.pulses).sum()
}

/// Brings an image to the board; `true` when it was accepted and has run.
///
/// # Errors
/// What did not hold.
pub fn try_out(
    build: &Build,
    stand: &mut Stand,
    image: &[u8],
    rng: &mut Rng,
) -> Result<bool, String> {
    let before = (pulses(stand), stand.board.plant().outputs());
    let uploaded = stand.upload(image, false);
    let after = (pulses(stand), stand.board.plant().outputs());
    if before != after {
        return Err(format!("steps and outputs before a start: {before:?}, then {after:?}"));
    }
    match (uploaded, wanted(build, image)) {
        (Ok(()), Wanted::Take | Wanted::Either) => {}
        (Ok(()), Wanted::Refuse) => return Err("accepted, but it is not sound".to_owned()),
        (Err(Answer::Exception(_)), Wanted::Refuse | Wanted::Either) => {
            broken_rule(stand).map_or(Ok(()), Err)?;
            return if stand.answers() { Ok(false) } else { Err("no answer".to_owned()) };
        }
        (Err(answer), Wanted::Take) => {
            let refusal = stand.refusal().and_then(Refusal::from_number);
            return Err(format!("refused with {answer:?}, {refusal:?}, but it is sound"));
        }
        (Err(answer), _) => return Err(format!("not refused, but answered {answer:?}")),
    }
    follow(stand, image, rng)?;
    broken_rule(stand).map_or(Ok(true), Err)
}

/// Runs the stored program for a while under hands that play with the inputs.
fn follow(stand: &mut Stand, image: &[u8], rng: &mut Rng) -> Result<(), String> {
    let code = Image::new(image).map_or(0, |image| image.code.len());
    let runs = stand.read(RUN_COUNT).ok_or("no answer before the start")?;
    match stand.control(Control::Start) {
        Answer::Reply(_) => {}
        answer => return Err(format!("start was answered by {answer:?}")),
    }
    for _ in 0..LOOKS {
        stand.board.plant_mut().set_input(1 + rng.below(8) as u8, rng.below(2) == 0);
        stand.board.run_us(LOOK_US);
        let pc = stand.read(PROGRAM_COUNTER).ok_or("no answer in the run")?;
        if usize::from(pc) >= code {
            return Err(format!("pc {pc} of {code}"));
        }
    }
    stand.control(Control::Stop);
    let resting = [RunState::Ready as u16, RunState::Fault as u16];
    let mut looks = 0;
    while !resting.contains(&stand.state().ok_or("no answer after the stop")?) {
        stand.board.run_us(LOOK_US);
        looks += 1;
        if looks > STOP_LOOKS {
            return Err("it does not stop".to_owned());
        }
    }
    if stand.read(RUN_COUNT) != Some(runs.wrapping_add(1)) {
        return Err("the board was reset".to_owned());
    }
    let fault = stand.read(FAULT).ok_or("no answer at the end")?;
    if [Fault::ImageRefused, Fault::Watchdog].iter().any(|bad| u16::from(bad.number()) == fault) {
        return Err(format!("the run ended with F{fault:02}"));
    }
    if stand.state() == Some(RunState::Fault as u16) {
        stand.control(Control::Acknowledge);
    }
    Ok(())
}

/// Damaged images on the emulated board.
///
/// # Errors
/// The shipped firmware is damaged, or the table cannot be written.
pub fn run(build: &Build, settings: &Settings, sink: Sink<'_>) -> Result<(), String> {
    let corpus = corpus(build, settings)?;
    let fault = "damaged, board";
    let mut row = Row::on(build, "images", fault, settings);
    let accepted = AtomicU64::new(0);
    let fresh = Fresh::new(Stand::new(build, &Config::default())?);
    row.run(settings, settings.count(30, 400, 2_000), |n| {
        let mut rng = settings.rng(fault, n);
        let image = damaged(&mut rng, &corpus);
        let mut stand = fresh.copy();
        match try_out(build, &mut stand, &image, &mut rng) {
            Ok(ran) => {
                accepted.fetch_add(u64::from(ran), Ordering::Relaxed);
                Verdict::Survived
            }
            Err(text) => Verdict::Lost(format!("{text}: {image:02X?}")),
        }
    });
    row.note = format!("{} accepted and run", accepted.into_inner());
    sink(row)
}
