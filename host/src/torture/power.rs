//! Power cuts: at every flash operation of an upload, a KEEP write, a profile write and a logged
//! fault, at random instants of runs, and again while the board comes up. After each cut the
//! board answers in time and holds the old, the new or, where the old one was given up, no program.

mod wear;

use desk::board::NativeBoard;
use emulator::{Board, Config, Rng};
use lang::record::{BoardRecord, OutputStates, feature};
use lang::wire::{
    Control, FAULT, HOMED, KEEPS, LAST_END, MACHINE_POSITIONS, PROFILE_WINDOW, RUN_STATE, RunState,
    UPLOAD_CONTROL, UPLOAD_LENGTH, Upload, upload_window,
};

use super::generate::{Case, generate_for};
use super::programs::{Made, make, make_for, tape};
use super::stand::{BOOT_US, Fresh, Stand, identity, words};
use super::table::Table;
use super::{DESK, Row, Settings, Sink, Verdict};
use crate::board::{Build, F5529};

pub use wear::{Counted, wear};

/// Power-ups behind a cut: a bit that was caught in the middle reads otherwise each time.
const POWER_UPS: u32 = 3;
/// What is done to a run.
const AT_ANY: &str = "cut, any instant of a run";
/// Longest run here, in looks of 50 ms.
const LOOKS: u32 = 60;

/// Compiles a script of ours.
///
/// # Errors
/// It does not compile.
pub fn image(script: &str) -> Result<Vec<u8>, String> {
    let case = Case { script: script.to_owned(), world: String::new(), independent: false };
    make(case).map(|made| made.compiled.image).ok_or_else(|| format!("does not compile: {script}"))
}

fn config(seed: u64) -> Config {
    // Every other board has bits that waver behind a cut.
    Config { seed, unstable_bits: seed % 2 == 1, ..Config::default() }
}

/// How power fails in the middle of a flash operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// For so long that RAM holds noise when it comes back.
    Cut,
    /// So shortly that RAM keeps its content.
    Dip,
}

/// Flash operations of a write in which the short form lets power fail.
const SHORT_CUTS: u64 = 8;

/// Whether a board holds the old or the new.
type Check<B> = fn(&mut Stand<B>, &[u8], &[u8]) -> Result<(), String>;

/// What is written when the power fails.
pub struct Write<B: Table = Board> {
    /// Names of its two faults: [`Failure::Cut`], [`Failure::Dip`].
    names: [&'static str; 2],
    /// A board before the write.
    before: [Fresh<B>; 2],
    /// Writes; its end is of no interest.
    write: fn(&mut Stand<B>, &[u8]),
    /// What it writes.
    new: Vec<u8>,
    /// Whether what the board holds is the old or the new.
    check: Check<B>,
    old: Vec<u8>,
}

/// Makes a board; the number says how its bits behave.
type New<'a, B> = &'a dyn Fn(u64) -> Result<Stand<B>, String>;

fn boards<B: Table>(
    new: New<'_, B>,
    prepare: impl Fn(&mut Stand<B>) -> Result<(), String>,
) -> Result<[Fresh<B>; 2], String> {
    let board = |seed| {
        let mut stand = new(seed)?;
        prepare(&mut stand).map(|()| Fresh::new(stand))
    };
    Ok([board(0)?, board(1)?])
}

fn taken<B: Table>(stand: &mut Stand<B>, image: &[u8], keep: bool) -> Result<(), String> {
    stand.upload(image, keep).map_err(|answer| format!("the upload was answered by {answer:?}"))
}

/// Runs the stored program to its end or to the failure of power.
fn run_through<B: Table>(stand: &mut Stand<B>) {
    stand.control(Control::Start);
    for _ in 0..LOOKS {
        stand.board.run_us(50_000);
        let rests = [Some(RunState::Ready as u16), Some(RunState::Fault as u16)];
        if !stand.board.powered() || rests.contains(&stand.state()) {
            return;
        }
    }
}

fn replace<B: Table>(stand: &mut Stand<B>, image: &[u8]) {
    stand.expects(image.len());
    stand.write(UPLOAD_LENGTH, &[image.len() as u16]);
    stand.write(UPLOAD_CONTROL, &[Upload::Replace as u16]);
    for (n, words) in words(image).chunks(21).enumerate() {
        stand.write(upload_window(image.len()) + 21 * n as u16, words);
    }
    stand.write(UPLOAD_CONTROL, &[Upload::Commit as u16]);
}

fn write_record<B: Table>(stand: &mut Stand<B>, record: &[u8]) {
    for (n, part) in words(record).chunks(16).enumerate() {
        stand.write(PROFILE_WINDOW + 16 * n as u16, part);
    }
}

fn stored<B: Table>(stand: &mut Stand<B>) -> Result<(u16, u16), String> {
    stand.stored().ok_or_else(|| "no answer about the program".to_owned())
}

fn old_or_new<B: Table>(stand: &mut Stand<B>, old: &[u8], new: &[u8]) -> Result<(), String> {
    let found = stored(stand)?;
    match found == identity(old) || found == identity(new) {
        true => Ok(()),
        false => Err(format!("neither the old program nor the new one: {found:04X?}")),
    }
}

fn old_or_new_or_none<B: Table>(
    stand: &mut Stand<B>,
    old: &[u8],
    new: &[u8],
) -> Result<(), String> {
    if stored(stand)? == (0, 0) && stand.state() == Some(RunState::Empty as u16) {
        return Ok(());
    }
    old_or_new(stand, old, new)
}

/// The two KEEP values of [`COUNTER`] were written one after the other: each is old or new.
fn kept<B: Table>(stand: &mut Stand<B>, old: &[u8], _new: &[u8]) -> Result<(), String> {
    for n in 0..2 {
        let value = stand.read_long(KEEPS + 2 * n).ok_or("no answer about a KEEP value")?;
        if value != 70_001 && value != 140_002 {
            return Err(format!("KEEP value {n} is {value}"));
        }
    }
    old_or_new(stand, old, old)
}

fn profile<B: Table>(stand: &mut Stand<B>, old: &[u8], new: &[u8]) -> Result<(), String> {
    let mut found = Vec::new();
    for register in 0..BoardRecord::SIZE as u16 / 2 {
        let word = stand.read(PROFILE_WINDOW + register).ok_or("no answer about the profile")?;
        found.extend(word.to_le_bytes());
    }
    if found == old || found == new { Ok(()) } else { Err(format!("profile {found:02X?}")) }
}

fn logged<B: Table>(stand: &mut Stand<B>, old: &[u8], _new: &[u8]) -> Result<(), String> {
    let fault = stand.read(FAULT).ok_or("no answer about the fault")?;
    if ![1, 2].contains(&fault) {
        return Err(format!("fault {fault}, which never came"));
    }
    old_or_new(stand, old, old)
}

const COUNTER: &str = "KEEP a, b\na = a + 70001\nb = b + 70001";
/// F02, then F01 each time.
const FAULTS: &str = "KEEP n\nDIM a\nn = n + 1\nIF n > 1 THEN a = 2147483647 + n\na = n / a";
/// F02 each time; without KEEP.
const DIVISION: &str = "DIM a\na = 1 / a";

/// Every write that power can fail in.
///
/// # Errors
/// The shipped firmware is damaged, or does not take what it should.
pub fn writes(build: &Build) -> Result<Vec<Write>, String> {
    writes_on(build, &|seed| Stand::new(build, &config(seed)))
}

/// The same on the firmware's machine on the desktop.
///
/// # Errors
/// It does not take what it should.
pub fn writes_on_desk() -> Result<Vec<Write<NativeBoard>>, String> {
    writes_on(&F5529, &|_| Ok(Stand::native()))
}

fn writes_on<B: Table>(build: &Build, board: New<'_, B>) -> Result<Vec<Write<B>>, String> {
    let has_keep = build.part.features & feature::KEEP != 0;
    let old = image("PRINT \"old\"\nSetOut 1, ON\nWait 5ms")?;
    let new = image("PRINT \"new\"\nSetOut 2, ON")?;
    let line = |n: u32| format!("G0 X{}.{} Y{}.3\n", n * 7 % 250, n % 10, n * 11 % 180);
    // More than half of the room.
    let lines = build.part.room_for(false) as u32 / 10;
    let large = image(&(0..lines).map(line).collect::<String>())?;
    let faults = image(if has_keep { FAULTS } else { DIVISION })?;
    let record = |sequence| BoardRecord { sequence, ..BoardRecord::DEFAULT }.sealed().to_bytes();
    let marked =
        BoardRecord { sequence: 2, end: OutputStates { keep: 1, on: 2 }, ..BoardRecord::DEFAULT };
    let mut writes = vec![
        Write {
            names: ["cut, upload beside", "brown-out, upload beside"],
            before: boards(board, |stand| taken(stand, &old, false))?,
            write: |stand, image| drop(stand.upload(image, false)),
            new,
            check: old_or_new,
            old: old.clone(),
        },
        Write {
            names: ["cut, upload in place", "brown-out, upload in place"],
            before: boards(board, |stand| taken(stand, &large, false))?,
            write: replace,
            new: old,
            check: old_or_new_or_none,
            old: large,
        },
        Write {
            names: ["cut, profile", "brown-out, profile"],
            before: boards(board, |stand| {
                write_record(stand, &record(1));
                stand.control(Control::Restart);
                stand.board.run_us(BOOT_US);
                Ok(())
            })?,
            write: write_record,
            new: marked.sealed().to_bytes().to_vec(),
            check: profile,
            old: record(1).to_vec(),
        },
        Write {
            names: ["cut, fault log", "brown-out, fault log"],
            before: boards(board, |stand| {
                taken(stand, &faults, has_keep)?;
                run_through(stand);
                stand.control(Control::Acknowledge);
                Ok(())
            })?,
            write: |stand, _| run_through(stand),
            new: Vec::new(),
            check: logged,
            old: faults,
        },
    ];
    if has_keep {
        writes.push(keep_writes(board)?);
    }
    Ok(writes)
}

fn keep_writes<B: Table>(board: New<'_, B>) -> Result<Write<B>, String> {
    let counter = image(COUNTER)?;
    Ok(Write {
        names: ["cut, KEEP", "brown-out, KEEP"],
        before: boards(board, |stand| {
            taken(stand, &counter, true)?;
            run_through(stand);
            Ok(())
        })?,
        write: |stand, _| run_through(stand),
        new: Vec::new(),
        check: kept,
        old: counter,
    })
}

impl<B: Table> Write<B> {
    /// Flash operations of the write.
    pub fn operations(&self) -> u64 {
        let mut stand = self.before[0].copy();
        let before = stand.board.operations();
        (self.write)(&mut stand, &self.new);
        (stand.board.operations() - before).max(1)
    }

    /// Lets power fail in flash operation `n` of the write; `None` when it has not so many. `spoil`
    /// may do to the board without power what a failure must not.
    pub fn fail(
        &self,
        failure: Failure,
        n: u64,
        seed: u64,
        spoil: &dyn Fn(&mut Stand<B>),
    ) -> Option<Verdict> {
        let mut stand = self.before[(seed % 2) as usize].copy();
        stand.board.fail_at(n, seed);
        (self.write)(&mut stand, &self.new);
        if stand.board.powered() {
            return None;
        }
        spoil(&mut stand);
        let text = |text: String| Some(Verdict::Lost(format!("operation {n}: {text}")));
        let mut held = None;
        for up in 0..POWER_UPS {
            let answers = if up == 0 && failure == Failure::Dip {
                stand.board.power_back();
                stand.board.run_us(BOOT_US);
                stand.answers()
            } else {
                stand.power_cycle()
            };
            if !answers {
                return text("the board does not answer".to_owned());
            }
            if let Err(error) = (self.check)(&mut stand, &self.old, &self.new) {
                return text(error);
            }
            let now = stand.stored();
            if held.is_some_and(|held| held != now) {
                return text(format!("{held:04X?} at one power-up, {now:04X?} at the next"));
            }
            held = Some(now);
            // And again while it comes up.
            stand.board.power_cut();
            stand.board.power_up();
            stand.board.run_us(seed * 977 % 40_000);
            stand.board.brown_out();
            stand.board.run_us(BOOT_US);
        }
        Some(Verdict::Survived)
    }
}

/// What a failure of power in the middle of a run leaves: nothing runs, moves or is known.
///
/// # Errors
/// What did not hold.
fn nothing_goes_on<B: Table>(stand: &mut Stand<B>, image: &[u8]) -> Result<(), String> {
    if !stand.power_cycle() {
        return Err("the board does not answer".to_owned());
    }
    let pulses = |stand: &Stand<B>| stand.board.plant().motors.each_ref().map(|motor| motor.pulses);
    let before = pulses(stand);
    stand.board.run_us(30_000);
    if pulses(stand) != before || stand.board.plant().outputs() != 0 {
        return Err("steps or outputs though nobody pressed Start".to_owned());
    }
    for (register, wanted) in [(HOMED, 0), (LAST_END, 0), (RUN_STATE, RunState::Ready as u16)] {
        let found = stand.read(register);
        if found != Some(wanted) {
            return Err(format!("register {register} is {found:?}, not {wanted}"));
        }
    }
    if stand.read_long(MACHINE_POSITIONS) != Some(0) {
        return Err("a position is known".to_owned());
    }
    old_or_new(stand, image, image)
}

fn random_cuts<B: Table>(
    mut row: Row,
    build: &Build,
    fresh: &Fresh<B>,
    settings: &Settings,
    count: u64,
) -> Row {
    row.run(settings, count, |n| {
        let case = generate_for(build.part, &tape(settings, AT_ANY, n));
        let Some(made) = make_for(build, case) else { return Verdict::Skipped };
        random_cut(fresh.copy(), &made, &mut settings.rng(AT_ANY, n), &|_| {})
    });
    row
}

/// Cuts power at some instant of a run; `spoil` as with [`Write::fail`].
pub fn random_cut<B: Table>(
    mut stand: Stand<B>,
    made: &Made,
    rng: &mut Rng,
    spoil: &dyn Fn(&mut Stand<B>),
) -> Verdict {
    let image = &made.compiled.image;
    let keep = image.get(16).is_some_and(|counts| counts & 15 != 0);
    if let Err(answer) = stand.upload(image, keep) {
        return Verdict::Lost(format!("the upload was answered by {answer:?}"));
    }
    stand.control(Control::Start);
    stand.board.run_us(rng.below(400_000));
    stand.board.power_cut();
    spoil(&mut stand);
    nothing_goes_on(&mut stand, image).map_or_else(
        |text| Verdict::Lost(format!("{text}\n{}", made.case.script)),
        |()| Verdict::Survived,
    )
}

/// Failures of power, on the emulated boards and on the firmware's machine on the desktop.
///
/// # Errors
/// The shipped firmware is damaged, or the table cannot be written.
pub fn run(settings: &Settings, sink: Sink<'_>) -> Result<(), String> {
    for build in settings.builds {
        let failures = [Failure::Cut, Failure::Dip];
        cut(writes(build)?, &failures, build.part.name, [SHORT_CUTS, 4, 40], settings, sink)?;
        let fresh = Fresh::new(Stand::new(build, &config(1))?);
        let row = Row::on(build, "power", AT_ANY, settings);
        sink(random_cuts(row, build, &fresh, settings, settings.count(10, 300, 3_000)))?;
    }
    if settings.has_desk() {
        let failures = [Failure::Cut];
        cut(writes_on_desk()?, &failures, DESK, [2 * SHORT_CUTS, 40, 4_000], settings, sink)?;
        let row = Row::of(DESK, "power", AT_ANY, settings);
        let fresh = Fresh::new(Stand::native());
        sink(random_cuts(row, &F5529, &fresh, settings, settings.count(40, 3_000, 300_000)))?;
    }
    sink(wear(settings, false, &|_| {}))?;
    sink(wear(settings, true, &|_| {}))
}

/// Lets power fail in the operations of each write: in the short form in some of them, else in each so many times.
fn cut<B: Table>(
    writes: Vec<Write<B>>,
    failures: &[Failure],
    part: &'static str,
    [short, usual, long]: [u64; 3],
    settings: &Settings,
    sink: Sink<'_>,
) -> Result<(), String> {
    for write in writes {
        let most = write.operations();
        for (&failure, name) in failures.iter().zip(write.names) {
            let mut row = Row::of(part, "power", name, settings);
            let cases = settings.count(short.min(most), usual * most, long * most);
            row.run(settings, cases, |n| {
                // In short evenly over the write.
                let stride = (most / cases).max(1);
                let (operation, seed) = (n * stride % most + 1, settings.seed + n / most);
                write.fail(failure, operation, seed, &|_| {}).unwrap_or(Verdict::Skipped)
            });
            row.note = format!("{most} flash operations");
            sink(row)?;
        }
    }
    Ok(())
}
