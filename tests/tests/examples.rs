//! Every example runs in its scenario with the trace that lies beside it, on every engine.

use std::path::{Path, PathBuf};

use lang::axis::Axis;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::hir::Program;
use lang::image::Image;
use lang::record::feature;
use pasapas::board::engine::run_native_traced;
use pasapas::board::{Build, DEFAULT, engine};
use pasapas::sim::trace::{Event, What, to_text};
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, run_traced};
use pasapas::torture::times::{LATER_US, apart};

struct Example {
    name: String,
    program: Program,
    world: World,
    trace: String,
}

fn read(file: &Path) -> String {
    std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

/// A trace without the places at which outputs acted on the way: these hang on the instant, to a millisecond's way.
fn settled(events: &[Event]) -> String {
    let mut events = events.to_vec();
    for event in &mut events {
        if let What::Out { pos, .. } | What::Aout { pos, .. } = &mut event.what {
            *pos = None;
        }
    }
    to_text(&events)
}

fn examples() -> Vec<Example> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let entries = std::fs::read_dir(folder).unwrap();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "bas"));
    files.sort();
    let example = |file: PathBuf| {
        let name = file.file_stem().unwrap().to_string_lossy().into_owned();
        let source = Source::new(&name, read(&file));
        let (program, diags) = compile(&source, ProfileChoice::built_in());
        let program = program.unwrap_or_else(|| panic!("{}", diags.render(&source)));
        let world = World::parse(&name, &read(&file.with_extension("rhai"))).unwrap();
        let trace = pasapas::sim::trace::read(read(&file.with_extension("trace")).as_bytes());
        Example { name, program, world, trace: settled(&trace.unwrap()) }
    };
    files.into_iter().map(example).collect()
}

#[test]
fn examples_run_as_their_traces_say() {
    let examples = examples();
    assert!(examples.len() >= 16);
    for Example { name, program, world, trace } in &examples {
        for engine in [Engine::Rhai, Engine::Vm] {
            let (outcome, events) =
                run_traced(program, engine, world, &Options::default()).unwrap();
            let which = format!("{name} on {engine:?}");
            assert_eq!(outcome.failures, Vec::<String>::new(), "{which}");
            assert_eq!(settled(&events), *trace, "{which}");
        }
    }
}

/// The firmware's own machine on the desktop's chip does what every trace says, at many times the pace of an emulator.
#[test]
fn examples_run_on_the_machine_without_an_emulator() {
    for Example { name, program, world, trace } in &examples() {
        let compiled = lang::back::compile(program).unwrap();
        let run = run_native_traced(DEFAULT, program, &compiled, world, &Options::default());
        let (run, events) = run.unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(settled(&events), *trace, "{name}");
        assert_eq!(run.outcome.failures, Vec::<String>::new(), "{name}");
    }
}

/// Longest example that the emulated board runs here, us: each simulated second takes a tenth of
/// a second and more.
const LONGEST_US: u64 = 16_000_000;

/// All but the laser's, the vacuum sensor's and those with actions on the way run on the LaunchPad with the small chip: those with handlers with the image that
/// has them, those with arcs as chords.
#[test]
fn examples_run_on_the_small_chip() {
    let examples = examples();
    let mut drawn = Vec::new();
    for Example { name, program, world, trace } in &examples {
        let compile = |program: &Program| lang::back::compile(program).unwrap();
        let compiled = compile(program);
        let wants = u16::from(Image::new(&compiled.image).unwrap().header.features);
        if !program.profile.analogs.is_empty() {
            assert_eq!(name, "vacuum_pick");
            continue;
        }
        if Image::new(&compiled.image).unwrap().extra().next().is_some() {
            assert_eq!(name, "glue_path");
            continue;
        }
        if wants & feature::POWER != 0 {
            assert_eq!(name, "laser");
            continue;
        }
        let (program, compiled) = match wants & feature::ARC {
            0 => (program.clone(), compiled),
            _ => {
                let (program, _) = pasapas::chords::drawn(program).unwrap();
                let compiled = compile(&program);
                drawn.push(name.as_str());
                (program, compiled)
            }
        };
        let image = Image::new(&compiled.image).unwrap();
        let runs = |part: &&Build| part.part.lacks(&image, 3).is_none();
        let builds = ["g2553", "g2553-handlers"].map(|name| Build::named(name).unwrap());
        let build = builds.into_iter().find(runs);
        let build = build.unwrap_or_else(|| panic!("{name} runs on neither of the two"));
        let options = Options { part: build.part, ..Options::default() };
        let (outcome, events) = run_traced(&program, Engine::Rhai, world, &options).unwrap();
        assert_eq!(outcome.failures, Vec::<String>::new(), "{name}");
        let (_, on_vm) = run_traced(&program, Engine::Vm, world, &options).unwrap();
        let own = to_text(&events);
        assert_eq!(own, to_text(&on_vm), "{name}");
        assert_eq!(own.lines().last(), trace.lines().last(), "{name}");
        let has_arcs = drawn.last() == Some(&name.as_str());
        assert!(has_arcs || own == *trace, "{name}");
        // Emulated time is dear: of the others the large part runs the short ones below.
        if has_arcs {
            let (image, sidecar) = (&compiled.image, &compiled.sidecar);
            let run = engine::run_traced(build, &program, image, sidecar, world, &options);
            let (run, events) = run.unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!(run.outcome.failures, Vec::<String>::new(), "{name}");
            assert_eq!(to_text(&events), own, "{name} on the board");
        }
    }
    assert_eq!(drawn, ["drawing", "pocket", "thesis"]);
}

/// How far the times of the machine that has its program by upload may be from the board's, us, or a thousandth of the
/// time where that is more.
const UPLOADED_US: f64 = 5_000.0;

/// Events of the machine without an emulator come when the board's do: see [`apart`].
fn same_times(name: &str, machine: &[Event], board: &[Event], later_us: f64) {
    let (share, place) =
        apart(machine, board, later_us).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert!(share <= 1.0, "{name}: {place}");
}

/// Of a longer example so much is compared, us.
const BEGINNING_US: u64 = 6_000_000;

/// Events of a beginning; how a run is cut takes its time.
fn beginning(mut events: Vec<Event>) -> Vec<Event> {
    events.retain(|event| event.us.is_some_and(|us| us < BEGINNING_US - 100_000));
    events
}

#[test]
fn long_examples_begin_when_the_boards_do() {
    let options = Options { limit_us: BEGINNING_US, ..Options::default() };
    let mut count = 0;
    for Example { name, program, world, .. } in &examples() {
        let (whole, events) =
            run_traced(program, Engine::Rhai, world, &Options::default()).unwrap();
        if whole.summary.us <= LONGEST_US {
            continue;
        }
        let compiled = lang::back::compile(program).unwrap();
        let (image, sidecar) = (&compiled.image, &compiled.sidecar);
        let board = engine::run_traced(DEFAULT, program, image, sidecar, world, &options);
        let (_, board) = board.unwrap_or_else(|error| panic!("{name}: {error}"));
        let (_, on_vm) = run_traced(program, Engine::Vm, world, &options).unwrap();
        let board = beginning(board);
        for (engine, own) in [("rhai", events), ("vm", on_vm)] {
            same_times(&format!("{name} on {engine}"), &beginning(own), &board, LATER_US);
        }
        count += 1;
    }
    assert!(count >= 8);
}

#[test]
fn short_examples_run_on_the_board() {
    let mut count = 0;
    for Example { name, program, world, trace } in &examples() {
        let options = Options::default();
        let (_, events) = run_traced(program, Engine::Rhai, world, &options).unwrap();
        if events.last().and_then(|event| event.us).is_none_or(|us| us > LONGEST_US) {
            continue;
        }
        let compiled = lang::back::compile(program).unwrap();
        let (image, sidecar) = (&compiled.image, &compiled.sidecar);
        let run = engine::run_traced(DEFAULT, program, image, sidecar, world, &options);
        let (run, events) = run.unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(run.outcome.failures, Vec::<String>::new(), "{name}");
        assert_eq!(settled(&events), *trace, "{name}");
        let machine = run_native_traced(DEFAULT, program, &compiled, world, &options);
        let (_, without) = machine.unwrap_or_else(|error| panic!("{name}: {error}"));
        same_times(name, &without, &events, UPLOADED_US);
        for engine in [Engine::Rhai, Engine::Vm] {
            let (_, driven) = run_traced(program, engine, world, &options).unwrap();
            same_times(&format!("{name} on {engine:?}"), &driven, &events, LATER_US);
        }
        let options = Options { part: DEFAULT.part, ..options };
        let (simulated, _) = run_traced(program, Engine::Vm, world, &options).unwrap();
        let [there, here] = [run.outcome.summary.us, simulated.summary.us].map(|us| us as f64);
        assert!((there / here - 1.0).abs() < 0.01, "{name}: {there} us on the board, vm {here}");
        // Where homing sets a position no axis has moved. Between two looks a rate is a few steps
        // off; no machine does twice its top rate.
        let tops = Axis::ALL.map(|axis| program.profile.axis(axis).map_or(0, |own| own.top_rate));
        let top = f64::from(tops.into_iter().max().unwrap_or(0));
        let most = run.outcome.record.path.iter().map(|own| own.peak_rate).fold(0.0, f64::max);
        assert!(most < 2.0 * top, "{name}: drawn with {most} steps/s");
        count += 1;
    }
    assert!(count >= 6);
}

/// The picture of a run: what an axis does on its own begins where it stood and ends where it goes to.
#[test]
fn pieces_of_a_run_are_joined() {
    let text = "MoveAxe X, 5mm\nWait 5ms\nMoveAxe X, 10.01mm\nMoveAxe Z, -2.5mm\nG1 X3 F900\nMoveAxe X, 4mm\n";
    let source = Source::new("pieces.bas", text.to_owned());
    let (program, _) = compile(&source, ProfileChoice::built_in());
    let program = program.expect("a program");
    for engine in [Engine::Rhai, Engine::Vm] {
        let (outcome, _) =
            run_traced(&program, engine, &World::unattended(), &Options::default()).unwrap();
        let ends: Vec<_> = outcome.record.path.iter().map(|own| (own.from, own.to)).collect();
        let places =
            [[0; 3], [500, 0, 0], [1001, 0, 0], [1001, 0, -250], [300, 0, -250], [400, 0, -250]];
        let wanted: Vec<_> = places.windows(2).map(|pair| (pair[0], pair[1])).collect();
        assert_eq!(ends, wanted, "{engine:?}");
    }
}
