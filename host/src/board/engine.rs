//! Engine `board`: a script on the emulated board, through the same client as on a real one.

use std::cell::RefCell;
use std::fmt;
use std::io::Write;
use std::rc::Rc;
use std::time::Duration;

use emulator::LoadError;
use firmware::motion::physics::Count;
use lang::back::{Compiled, Sidecar};
use lang::hir::Program;
use lang::profile::Wiring;
use lang::record::BoardRecord;

use super::Build;
use super::hardware::Hardware;
use super::health::Health;
use super::link::InProcess;
use super::rig::Rig;
use super::run::Run;
use crate::client::upload::UploadError;
use crate::client::{Client, ClientError, Patience};
use crate::link::Link;
use crate::sim::chain::Chain;
use crate::sim::scene::filters_us;
use crate::sim::trace::Event;
use crate::sim::world::{Registers, World, WorldError};
use crate::sim::{Options, Outcome};
use desk::board::NativeBoard;

/// A request that the board loses while it erases flash is asked again soon.
const RUN_PATIENCE: Patience = Patience { reply: Duration::from_millis(50), attempts: 20 };
/// From here on after power-up a board without a host does not wait for one that takes what is printed
/// (g2553/effects/print.s).
const ALONE: Duration = Duration::from_millis(600);

/// What is to run.
pub struct Job<'a> {
    /// The firmware that is to run it.
    pub build: &'a Build,
    /// The checked script, for its machine.
    pub program: &'a Program,
    /// Its image.
    pub image: &'a [u8],
    /// Line of an address in its code.
    pub line_of: &'a dyn Fn(u16) -> u32,
    /// What RUN calls it; nothing where that does not.
    pub name: &'a str,
    /// Programs that RUN begins.
    pub others: &'a [Other<'a>],
    /// Everything around the board.
    pub world: &'a World,
    /// Limits of the run.
    pub options: &'a Options,
}

/// A program of the board's library that RUN begins.
#[derive(Clone, Copy)]
pub struct Other<'a> {
    /// Its name.
    pub name: &'a str,
    /// The checked script.
    pub program: &'a Program,
    /// Its image.
    pub image: &'a [u8],
    /// Line of an address in its code.
    pub line_of: &'a dyn Fn(u16) -> u32,
}

impl<'a> Job<'a> {
    /// Every program of the board's library, by number from 1.
    pub(super) fn library(&self) -> Vec<Other<'a>> {
        let Job { name, program, image, line_of, others, .. } = *self;
        std::iter::once(Other { name, program, image, line_of })
            .chain(others.iter().copied())
            .collect()
    }
}

/// Where a run writes while it runs.
pub struct Sinks<'a> {
    /// Gets each line of the trace.
    pub trace: &'a mut dyn FnMut(&Event),
    /// Gets every edge at the pins as a Value Change Dump.
    pub vcd: Option<&'a mut dyn Write>,
    /// Hears the simulated time, us.
    pub progress: &'a mut dyn FnMut(u64),
}

/// A run on the board.
pub struct BoardRun {
    /// As of every engine.
    pub outcome: Outcome,
    /// What the emulator noticed: broken driver limits, accesses that the chip forbids.
    pub remarks: Vec<String>,
    /// How the board fared.
    pub health: Health,
    /// Moves and steps that were held to the profile's ramps and rates; what broke them is among the
    /// outcome's failures.
    pub judged: Count,
}

/// Why there is no run.
#[derive(Debug)]
pub enum BoardError {
    /// The shipped firmware is damaged.
    Firmware(LoadError),
    /// The world's script fails.
    World(WorldError),
    /// The board did not take the program.
    Upload(UploadError),
    /// The link to the board fails.
    Client(ClientError),
    /// The board did not do what it was told.
    Board(String),
    /// The VCD cannot be written.
    Vcd(std::io::Error),
}

impl fmt::Display for BoardError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BoardError::Firmware(error) => write!(f, "the firmware image is damaged: {error}"),
            BoardError::World(error) => error.fmt(f),
            BoardError::Upload(error) => error.fmt(f),
            BoardError::Client(error) => error.fmt(f),
            BoardError::Board(text) => f.write_str(text),
            BoardError::Vcd(error) => write!(f, "the VCD cannot be written: {error}"),
        }
    }
}

impl std::error::Error for BoardError {}

impl From<ClientError> for BoardError {
    fn from(error: ClientError) -> BoardError {
        BoardError::Client(error)
    }
}

impl From<WorldError> for BoardError {
    fn from(error: WorldError) -> BoardError {
        BoardError::World(error)
    }
}

impl From<UploadError> for BoardError {
    fn from(error: UploadError) -> BoardError {
        BoardError::Upload(error)
    }
}

/// Starts a board, brings it profile and program, presses Start and follows the run to its end.
///
/// # Errors
/// See [`BoardError`]. A fault of the script is no error: it is the outcome's end.
pub fn run<'a>(job: &'a Job<'_>, sinks: Sinks<'a>) -> Result<BoardRun, BoardError> {
    let firmware = job.build.image().map_err(BoardError::Firmware)?;
    let registers = Registers::on_board(job.program);
    run_on(Rig::new(job.build, &firmware, &job.program.profile, job.world, &registers)?, job, sinks)
}

/// The same on the firmware's machine, without an emulator: the MSP430F5529, whatever the job's build is.
///
/// # Errors
/// Those of [`run`].
pub fn run_native<'a>(job: &'a Job<'_>, sinks: Sinks<'a>) -> Result<BoardRun, BoardError> {
    let profile = &job.program.profile;
    let board = NativeBoard::new(match profile.wiring {
        Wiring::Direct => emulator::Wiring::Direct,
        Wiring::Chain => emulator::Wiring::Chain,
    });
    let registers = Registers::on_board(job.program);
    run_on(Rig::around(board, profile, job.world, &registers)?, job, sinks)
}

fn run_on<'a, B: Hardware>(
    rig: Rig<B>,
    job: &'a Job<'_>,
    sinks: Sinks<'a>,
) -> Result<BoardRun, BoardError> {
    let rig = Rc::new(RefCell::new(rig));
    let mut client = Client::new(InProcess::new(Rc::clone(&rig)), 1);
    client.find()?;
    prepare(&mut client, &rig, job)?;
    let mut run = Run::new(job, sinks, Rc::clone(&rig), client)?;
    let ran = run.start().and_then(|()| run.follow()).and_then(|end| run.finish(end));
    // A world that fails during an exchange fails the exchange.
    match (ran, rig.borrow().failure()) {
        (Err(_), Some(error)) => Err(BoardError::World(error.clone())),
        (ran, _) => ran,
    }
}

/// Runs a program of which nothing but the trace is wanted on the way; `sidecar` tells the lines of
/// `image`.
///
/// # Errors
/// Those of [`run`].
pub fn run_traced(
    build: &Build,
    program: &Program,
    image: &[u8],
    sidecar: &Sidecar,
    world: &World,
    options: &Options,
) -> Result<(BoardRun, Vec<Event>), BoardError> {
    let line_of = |pc: u16| sidecar.at(usize::from(pc)).map_or(0, |mark| mark.line);
    let job =
        Job { build, program, image, line_of: &line_of, name: "", others: &[], world, options };
    trace_of(&job)
}

/// Runs the first program of a chain, and those that RUN begins; `compiled` are theirs.
///
/// # Errors
/// Those of [`run`].
pub fn run_chain_traced(
    build: &Build,
    chain: &Chain<'_>,
    compiled: &[Compiled],
    world: &World,
    options: &Options,
) -> Result<(BoardRun, Vec<Event>), BoardError> {
    let lines: Vec<_> = compiled
        .iter()
        .map(|own| |pc: u16| own.sidecar.at(usize::from(pc)).map_or(0, |mark| mark.line))
        .collect();
    let programs = chain.programs().iter().zip(chain.names()).zip(compiled).zip(&lines);
    let library: Vec<Other<'_>> = programs
        .map(|(((&program, name), own), line_of)| Other {
            name,
            program,
            image: &own.image,
            line_of,
        })
        .collect();
    let Some((&Other { name, program, image, line_of }, others)) = library.split_first() else {
        return Err(BoardError::Board("a chain without a program".to_owned()));
    };
    trace_of(&Job { build, program, image, line_of, name, others, world, options })
}

/// Runs a program on the firmware's machine, without an emulator: see [`run_native`].
///
/// # Errors
/// Those of [`run`].
pub fn run_native_traced(
    build: &Build,
    program: &Program,
    compiled: &Compiled,
    world: &World,
    options: &Options,
) -> Result<(BoardRun, Vec<Event>), BoardError> {
    let line_of = |pc: u16| compiled.sidecar.at(usize::from(pc)).map_or(0, |mark| mark.line);
    let image = &compiled.image;
    let job =
        Job { build, program, image, line_of: &line_of, name: "", others: &[], world, options };
    traced(&job, run_native)
}

fn trace_of(job: &Job<'_>) -> Result<(BoardRun, Vec<Event>), BoardError> {
    traced(job, run)
}

fn traced(
    job: &Job<'_>,
    run: for<'a> fn(&'a Job<'_>, Sinks<'a>) -> Result<BoardRun, BoardError>,
) -> Result<(BoardRun, Vec<Event>), BoardError> {
    let mut trace = Vec::new();
    let sinks = Sinks {
        trace: &mut |event: &Event| trace.push(event.clone()),
        vcd: None,
        progress: &mut |_| {},
    };
    let run = run(job, sinks)?;
    Ok((run, trace))
}

/// Profile, program, and a world that has been there for a while.
fn prepare<B: Hardware>(
    client: &mut Client<InProcess<B>>,
    rig: &RefCell<Rig<B>>,
    job: &Job<'_>,
) -> Result<(), BoardError> {
    let held = client.board_record()?;
    let wanted = BoardRecord::of(&job.program.profile, held.sequence.wrapping_add(1));
    let mut reset = Duration::ZERO;
    if !crate::client::identity::differences(&held, &wanted).is_empty() {
        client.set_board_record(&wanted)?;
        client.restart()?;
        reset = client.link().now();
        // The chip restarts by a wrong watchdog key, which the emulator would mention.
        rig.borrow_mut().board().clear_warnings();
        rig.borrow_mut().follow_uart();
        client.set_address(wanted.address);
        client.find()?;
    }
    if job.name.is_empty() {
        client.upload(job.image, false, &mut |_| {})?;
    } else {
        for (number, own) in (1..).zip(job.library()) {
            client.upload_as(own.image, Some((number, own.name)), false, &mut |_| {})?;
        }
    }
    client.set_patience(RUN_PATIENCE);
    rig.borrow_mut().set_the_scene()?;
    if lang::image::Image::new(job.image).is_ok_and(|image| job.build.part.keeps_at(&image.header))
    {
        let written = rig.borrow_mut().take_registers();
        for (register, value) in written {
            client.write_all(register, &halves(value))?;
        }
    }
    let now = client.link().now();
    let filters = Duration::from_micros(filters_us(&job.program.profile));
    client.link().pause((reset + ALONE).saturating_sub(now).max(filters));
    if !rig.borrow_mut().observe() {
        return Err(BoardError::Board("the firmware image has no symbols to watch".to_owned()));
    }
    Ok(())
}

/// Both halves of an AT variable.
pub(super) fn halves(value: i32) -> [u16; 2] {
    [value as u16, (value >> 16) as u16]
}

#[cfg(test)]
mod tests {
    use lang::back::{Courses, compile_with, disasm};
    use lang::fault::{Fault, LATE_LINE};
    use lang::image::Image;
    use lang::image::course::{Entry, record};
    use lang::wire::Control;

    use super::*;
    use crate::board::{DEFAULT, G2553};
    use crate::helm::Round;
    use crate::link::Link;
    use crate::sim::trace::What;
    use crate::torture::generate::Case;
    use crate::torture::programs::{Made, make};

    fn made(script: String) -> Made {
        make(Case { script, world: String::new(), independent: false }).expect("it compiles")
    }

    /// Runs an image; `over` is done to the board where its run has ended. What it gives, the text that its trace ends with,
    /// and what a status and a round of looks
    /// say then, and a status after another emergency stop by the link.
    fn run_with(
        build: &Build,
        made: &Made,
        image: &[u8],
        over: impl Fn(&mut emulator::Board),
    ) -> (BoardRun, String, [Option<&'static str>; 3]) {
        let (world, options) = (World::unattended(), Options::default());
        let job = Job {
            build,
            program: &made.program,
            image,
            line_of: &|_| 1,
            name: "",
            others: &[],
            world: &world,
            options: &options,
        };
        let firmware = build.image().expect("the shipped image");
        let registers = Registers::on_board(job.program);
        let rig = Rig::new(build, &firmware, &made.program.profile, &world, &registers);
        let rig = Rc::new(RefCell::new(rig.expect("a board")));
        let mut client = Client::new(InProcess::new(Rc::clone(&rig)), 1);
        client.find().expect("it answers");
        prepare(&mut client, &rig, &job).expect("it is brought");
        let sinks = Sinks { trace: &mut |_| {}, vcd: None, progress: &mut |_| {} };
        let mut run = Run::new(&job, sinks, Rc::clone(&rig), client).expect("a run");
        run.start().expect("it begins");
        let end = run.follow().expect("it ends");
        let traced = match &end {
            What::End { text, .. } => text.clone().unwrap_or_default(),
            _ => String::new(),
        };
        over(rig.borrow_mut().board());
        let ran = run.finish(end).expect("it rests");
        let link: Box<dyn Link> = Box::new(InProcess::new(Rc::clone(&rig)));
        let mut client = Client::new(link, 1);
        client.find().expect("it answers");
        let said = client.status().expect("a status").text;
        let mut round = Round::new();
        let picture = (0..100).find_map(|_| round.look(&mut client).expect("a look"));
        let seen = picture.and_then(|picture| picture.status).and_then(|status| status.text);
        client.control(Control::Acknowledge).expect("taken");
        client.control(Control::Start).expect("taken");
        client.control(Control::EmergencyStop).expect("taken");
        (ran, traced, [said, seen, client.status().expect("a status").text])
    }

    #[test]
    fn late_steps_of_a_run_are_in_its_health() {
        let made = made("MoveAxe X, 1mm\n".to_owned());
        for late in [0, 2] {
            let (ran, _, [.., stopped]) = run_with(DEFAULT, &made, &made.compiled.image, |board| {
                let step = board.symbol("PASAPAS_STEP").expect("a name");
                board.poke16(step + 18, late);
            });
            assert_eq!(ran.health.late_events, late);
            assert_eq!(stopped, Some(Fault::EmergencyStop.text()));
        }
    }

    /// Lines that end at a speed for which the chip has no time to plan the next one: no host makes such slow points.
    #[test]
    fn a_line_that_comes_too_late_is_said_to_and_an_emergency_stop_is_none() {
        let mut made = made(format!("F3000\nG91\n{}", "G1 X0.05 Y0.03 Z-0.02\n".repeat(100)));
        let insns = disasm::instructions(&Image::new(&made.compiled.image).expect("an image"));
        let first = insns.iter().find(|insn| insn.text.starts_with("line")).expect("a line").pc;
        let fast = Entry { lines: 100, holds: true, bound: 0x9FFF, joins: 0 };
        let courses =
            Courses { pool: G2553.part.course_pool, records: vec![(first, record(&[fast]))] };
        made.compiled = compile_with(&made.program, &courses).expect("it fits");
        let (ran, traced, said) = run_with(&G2553, &made, &made.compiled.image, |_| {});
        assert_eq!(ran.outcome.end.fault, Some(Fault::EmergencyStop));
        assert!(ran.outcome.late_line);
        assert_eq!(traced, LATE_LINE[0]);
        // `status`, then what gateway, brokers and OPC UA show, then the stop by the link.
        let late = Some(LATE_LINE[0]);
        assert_eq!(said, [late, late, Some(Fault::EmergencyStop.text())]);
    }
}
