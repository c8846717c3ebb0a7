//! Power: cut at every flash operation of an upload, a KEEP write, a profile write and a logged
//! fault, at random instants of runs, and again while the board comes up. Behind each cut the
//! board answers in time and holds the old, the new or, where the old one was given up, no program.

use emulator::{Config, Rng};
use firmware::keep::{self, Kept};
use firmware::store::{Flash, SEGMENT};
use lang::part;
use lang::record::{BoardRecord, OutputStates, feature};
use lang::wire::{
    Control, FAULT, HOMED, KEEPS, LAST_END, MACHINE_POSITIONS, PROFILE_WINDOW, RUN_STATE, RunState,
    UPLOAD_CONTROL, UPLOAD_LENGTH, Upload, upload_window,
};

use super::generate::{Case, generate_for};
use super::programs::{Made, make, make_for, tape};
use super::stand::{BOOT_US, Fresh, Stand, identity, words};
use super::{Row, Settings, Sink, Verdict};
use crate::board::Build;

/// Power-ups behind a cut: a bit that was caught in the middle reads otherwise each time.
const POWER_UPS: u32 = 3;
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
type Check = fn(&mut Stand, &[u8], &[u8]) -> Result<(), String>;

/// What is written when the power fails.
pub struct Write {
    /// Names of its two faults: [`Failure::Cut`], [`Failure::Dip`].
    names: [&'static str; 2],
    /// A board before the write.
    before: [Fresh; 2],
    /// Writes; its end is of no interest.
    write: fn(&mut Stand, &[u8]),
    /// What it writes.
    new: Vec<u8>,
    /// Whether what the board holds is the old or the new.
    check: Check,
    old: Vec<u8>,
}

fn boards(
    build: &Build,
    prepare: impl Fn(&mut Stand) -> Result<(), String>,
) -> Result<[Fresh; 2], String> {
    let board = |seed| {
        let mut stand = Stand::new(build, &config(seed))?;
        prepare(&mut stand).map(|()| Fresh::new(stand))
    };
    Ok([board(0)?, board(1)?])
}

fn taken(stand: &mut Stand, image: &[u8], keep: bool) -> Result<(), String> {
    stand.upload(image, keep).map_err(|answer| format!("the upload was answered by {answer:?}"))
}

/// Runs the stored program to its end or to the failure of power.
fn run_through(stand: &mut Stand) {
    stand.control(Control::Start);
    for _ in 0..LOOKS {
        stand.board.run_us(50_000);
        let rests = [Some(RunState::Ready as u16), Some(RunState::Fault as u16)];
        if !stand.board.powered() || rests.contains(&stand.state()) {
            return;
        }
    }
}

fn replace(stand: &mut Stand, image: &[u8]) {
    stand.expects(image.len());
    stand.write(UPLOAD_LENGTH, &[image.len() as u16]);
    stand.write(UPLOAD_CONTROL, &[Upload::Replace as u16]);
    for (n, words) in words(image).chunks(21).enumerate() {
        stand.write(upload_window(image.len()) + 21 * n as u16, words);
    }
    stand.write(UPLOAD_CONTROL, &[Upload::Commit as u16]);
}

fn write_record(stand: &mut Stand, record: &[u8]) {
    for (n, part) in words(record).chunks(16).enumerate() {
        stand.write(PROFILE_WINDOW + 16 * n as u16, part);
    }
}

fn stored(stand: &mut Stand) -> Result<(u16, u16), String> {
    stand.stored().ok_or_else(|| "no answer about the program".to_owned())
}

fn old_or_new(stand: &mut Stand, old: &[u8], new: &[u8]) -> Result<(), String> {
    let found = stored(stand)?;
    match found == identity(old) || found == identity(new) {
        true => Ok(()),
        false => Err(format!("neither the old program nor the new one: {found:04X?}")),
    }
}

fn old_or_new_or_none(stand: &mut Stand, old: &[u8], new: &[u8]) -> Result<(), String> {
    if stored(stand)? == (0, 0) && stand.state() == Some(RunState::Empty as u16) {
        return Ok(());
    }
    old_or_new(stand, old, new)
}

/// The two KEEP values of [`COUNTER`] were written one after the other: each is old or new.
fn kept(stand: &mut Stand, old: &[u8], _new: &[u8]) -> Result<(), String> {
    for n in 0..2 {
        let value = stand.read_long(KEEPS + 2 * n).ok_or("no answer about a KEEP value")?;
        if value != 70_001 && value != 140_002 {
            return Err(format!("KEEP value {n} is {value}"));
        }
    }
    old_or_new(stand, old, old)
}

fn profile(stand: &mut Stand, old: &[u8], new: &[u8]) -> Result<(), String> {
    let mut found = Vec::new();
    for register in 0..BoardRecord::SIZE as u16 / 2 {
        let word = stand.read(PROFILE_WINDOW + register).ok_or("no answer about the profile")?;
        found.extend(word.to_le_bytes());
    }
    if found == old || found == new { Ok(()) } else { Err(format!("profile {found:02X?}")) }
}

fn logged(stand: &mut Stand, old: &[u8], _new: &[u8]) -> Result<(), String> {
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
            before: boards(build, |stand| taken(stand, &old, false))?,
            write: |stand, image| drop(stand.upload(image, false)),
            new,
            check: old_or_new,
            old: old.clone(),
        },
        Write {
            names: ["cut, upload in place", "brown-out, upload in place"],
            before: boards(build, |stand| taken(stand, &large, false))?,
            write: replace,
            new: old,
            check: old_or_new_or_none,
            old: large,
        },
        Write {
            names: ["cut, profile", "brown-out, profile"],
            before: boards(build, |stand| {
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
            before: boards(build, |stand| {
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
        writes.push(keep_writes(build)?);
    }
    Ok(writes)
}

fn keep_writes(build: &Build) -> Result<Write, String> {
    let counter = image(COUNTER)?;
    Ok(Write {
        names: ["cut, KEEP", "brown-out, KEEP"],
        before: boards(build, |stand| {
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

impl Write {
    /// Flash operations of the write.
    pub fn operations(&self) -> u64 {
        let mut stand = self.before[0].copy();
        let before = stand.board.wear().operations;
        (self.write)(&mut stand, &self.new);
        (stand.board.wear().operations - before).max(1)
    }

    /// Lets power fail in flash operation `n` of the write; `None` when it has not so many. `spoil`
    /// may do to the board without power what a failure must not.
    pub fn fail(
        &self,
        failure: Failure,
        n: u64,
        seed: u64,
        spoil: &dyn Fn(&mut Stand),
    ) -> Option<Verdict> {
        let mut stand = self.before[(seed % 2) as usize].copy();
        stand.board.cut_at_flash_operation(n, seed);
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
fn nothing_goes_on(stand: &mut Stand, image: &[u8]) -> Result<(), String> {
    if !stand.power_cycle() {
        return Err("the board does not answer".to_owned());
    }
    let pulses = |stand: &Stand| stand.board.plant().motors.each_ref().map(|motor| motor.pulses);
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

fn random_cuts(build: &Build, settings: &Settings, sink: Sink<'_>) -> Result<(), String> {
    let fault = "cut, any instant of a run";
    let mut row = Row::on(build, "power", fault, settings);
    let fresh = Fresh::new(Stand::new(build, &config(1))?);
    row.run(settings, settings.count(10, 300, 3_000), |n| {
        let case = generate_for(build.part, &tape(settings, fault, n));
        let Some(made) = make_for(build, case) else { return Verdict::Skipped };
        random_cut(fresh.copy(), &made, &mut settings.rng(fault, n), &|_| {})
    });
    sink(row)
}

/// Cuts power at some instant of a run; `spoil` as with [`Write::fail`].
pub fn random_cut(
    mut stand: Stand,
    made: &Made,
    rng: &mut Rng,
    spoil: &dyn Fn(&mut Stand),
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

/// Segments of the program area of the fake flash.
const SEGMENTS: usize = part::F5529.segments as usize;

/// A flash memory that counts.
#[derive(Clone)]
pub struct Counted {
    words: Vec<u16>,
    erases: [u64; SEGMENTS],
    /// Operations until power fails; that one leaves some of its bits undone.
    left: u64,
    noise: u16,
}

impl Counted {
    fn new() -> Counted {
        let words = SEGMENTS * usize::from(SEGMENT) / 2;
        let erases = [0; SEGMENTS];
        Counted { words: vec![0xFFFF; words], erases, left: u64::MAX, noise: 0 }
    }
}

impl Counted {
    /// The word that a record ends with is lost, as by a flash that does not hold what was written.
    pub fn forget(&mut self) {
        if let Some(last) = self.words.iter_mut().rev().find(|word| **word != 0xFFFF) {
            *last = 0xFFFF;
        }
    }

    /// One segment is erased more often than the other.
    pub fn wear_out(&mut self) {
        self.erases[SEGMENTS - 1] += 1;
    }
}

impl Flash for Counted {
    const SEGMENTS: u8 = SEGMENTS as u8;

    fn read(&self, offset: u16) -> u16 {
        self.words[usize::from(offset) / 2]
    }
    fn write(&mut self, offset: u16, word: u16) {
        let undone = if self.left == 1 { self.noise } else { 0 };
        if self.left > 0 {
            self.words[usize::from(offset) / 2] &= word | undone;
        }
        self.left = self.left.saturating_sub(1);
    }
    fn erase(&mut self, offset: u16) {
        let segment = usize::from(offset / SEGMENT);
        let done = if self.left == 1 { self.noise } else { 0xFFFF };
        if self.left > 0 {
            let words = usize::from(SEGMENT) / 2;
            self.words[segment * words..][..words].iter_mut().for_each(|word| *word |= done);
            self.erases[segment] += 1;
        }
        self.left = self.left.saturating_sub(1);
    }
    fn image(&self, _offset: u16) -> Option<u16> {
        None
    }
    fn length(&self, _offset: u16) -> u16 {
        0
    }
}

/// KEEP writes, one in eight of them cut if `cuts`: each value is the old or the new one, and where
/// nothing is cut the two segments are erased alike. `spoil` may do to the flash what KEEP must not.
pub fn wear(settings: &Settings, cuts: bool, spoil: &dyn Fn(&mut Counted)) -> Row {
    let fault = if cuts { "KEEP writes, one in 8 cut" } else { "wear by KEEP writes" };
    let mut row = Row::new("power", fault, settings);
    let mut rng = settings.rng(fault, 0);
    let mut flash = Counted::new();
    let kept = Kept { count: 8, mark: 1 };
    let mut values = [0; 8];
    for n in 0..settings.count(20_000, 100_000, 1_000_000) {
        let (index, value) = (rng.below(8) as usize, rng.bits() as i32);
        let cut = cuts && rng.below(8) == 0;
        flash.left = if cut { 1 + rng.below(40) } else { u64::MAX };
        flash.noise = rng.bits() as u16;
        let mut wanted = values;
        wanted[index] = value;
        keep::save(&mut flash, kept.mark, &wanted);
        spoil(&mut flash);
        flash.left = u64::MAX;
        let found: [i32; 8] = std::array::from_fn(|of| keep::read(&flash, kept, of as u16));
        let held = found == wanted || cut && found == values;
        values = found;
        row.count(
            n,
            match held {
                true => Verdict::Survived,
                false => Verdict::Lost(format!("{found:X?}, not {wanted:X?}")),
            },
        );
    }
    let [.., a, b] = flash.erases;
    let others: u64 = flash.erases[..SEGMENTS - 2].iter().sum();
    if others > 0 || !cuts && a.abs_diff(b) > 1 {
        row.count(u64::MAX, Verdict::Lost(format!("erases by segment {:?}", flash.erases)));
    }
    row.note = format!("{a} and {b} erases of the two segments");
    row
}

/// Failures of power.
///
/// # Errors
/// The shipped firmware is damaged, or the table cannot be written.
pub fn run(settings: &Settings, sink: Sink<'_>) -> Result<(), String> {
    settings.builds.iter().try_for_each(|build| on_boards(build, settings, sink))?;
    sink(wear(settings, false, &|_| {}))?;
    sink(wear(settings, true, &|_| {}))
}

fn on_boards(build: &Build, settings: &Settings, sink: Sink<'_>) -> Result<(), String> {
    for write in writes(build)? {
        let most = write.operations();
        for (name, failure) in write.names.into_iter().zip([Failure::Cut, Failure::Dip]) {
            let mut row = Row::on(build, "power", name, settings);
            // Each operation once for every seed; in short some of them, evenly.
            let cases = settings.count(SHORT_CUTS.min(most), 4 * most, 40 * most);
            row.run(settings, cases, |n| {
                let stride = (most / cases).max(1);
                let (operation, seed) = (n * stride % most + 1, settings.seed + n / most);
                write.fail(failure, operation, seed, &|_| {}).unwrap_or(Verdict::Skipped)
            });
            row.note = format!("{most} flash operations");
            sink(row)?;
        }
    }
    random_cuts(build, settings, sink)
}
