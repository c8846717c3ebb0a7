//! Proof by variation.

use cell::vary::Deviation;
use pasapas::scene::proof::{self, Case, Class, Plan, Proof};
use pasapas::sim::Options;
use pasapas::sim::world::World;

use super::{
    DEFAULT, Engine, cell as cell_of, folder, program, read, run_native_traced, run_traced,
};

const ALL: Plan =
    Plan { runs: 6, seed: 5, jobs: 2, shard: (0, 1), within: None, until_fails: false };

/// A proof of the example that is wrong on purpose.
fn hasty(plan: Plan) -> Proof {
    with_hasty(|case| proof::prove(case, &plan, &|| false, &|_| {}).unwrap())
}

fn with_hasty<T>(with: impl FnOnce(&Case<'_>) -> T) -> T {
    let text = std::fs::read_to_string(folder().join("cells/hasty.bas")).unwrap();
    with_script(&text, with)
}

/// Another script in the cell of that example.
fn with_script<T>(text: &str, with: impl FnOnce(&Case<'_>) -> T) -> T {
    let program = program(text);
    let compiled = lang::back::compile(&program).unwrap();
    let scene = read(&folder().join("cells/hasty.cell.toml"), &program);
    let (world, options) =
        (World::unattended(), Options { record: false, judged: false, ..Options::default() });
    let case = Case {
        program: &program,
        compiled: &compiled,
        world: &world,
        scene: &scene,
        options: &options,
    };
    with(&case)
}

fn counts(proof: &Proof) -> Vec<(Class, u64)> {
    proof.tallies.iter().map(|tally| (tally.class, tally.runs)).collect()
}

/// A stop that was to come after the script's own fault hides nothing; one that came ends the run.
#[test]
fn a_fault_of_the_script_is_no_stop() {
    let pressed = |at_us| {
        [Deviation {
            what: "stop".to_owned(),
            of: String::new(),
            by: Vec::new(),
            at_us: Some(at_us),
        }]
    };
    let class = |text: &str, at_us| {
        with_script(text, |case| case.run(&pressed(at_us)).expect("it runs").class)
    };
    assert_eq!(
        class("OUTPUT pump = 3\nDIM n\nWait 100ms\nPRINT 5 / n\n", 300_000_000),
        Class::Fault
    );
    assert_eq!(class("OUTPUT pump = 3\nWait 10s\n", 1_000_000), Class::Handled);
}

/// What a fault does at time 0 waits for the program to run: a pause used to hold the start for ever, and a stop kept the
/// program from its start.
#[test]
fn a_fault_at_time_0_comes_after_the_start() {
    let class = |text: &str| {
        let fault = Deviation::parse(text).unwrap();
        with_script("OUTPUT pump = 3\nWait 100ms\n", |case| {
            case.run(&[fault]).expect("the program starts").class
        })
    };
    for text in ["stop at 0s", "estop at 0s", "stop"] {
        assert_eq!(class(text), Class::Handled, "{text}");
    }
    // A pause ends, and the run is judged as without it: this script places nothing.
    for text in ["pause at 0s", "pause 10ms at 0s"] {
        assert_eq!(class(text), Class::Wrong, "{text}");
    }
}

/// Who interrupts before the program has started is obeyed.
#[test]
fn an_interrupt_before_the_start_is_obeyed() {
    with_script("OUTPUT pump = 3\nWait 100ms\n", |case| {
        let options = Options { interrupted: || true, ..*case.options };
        let error = Case { options: &options, ..*case }.run(&[]).unwrap_err().to_string();
        assert!(error.contains("interrupted before the program started"), "{error}");
    });
}

/// The example that is wrong on purpose is found, and the words name the pressure that is too slow.
#[test]
fn what_is_wrong_is_found_and_named() {
    let proof = hasty(ALL);
    assert!(!proof.holds());
    let wrong = proof.tallies.iter().find(|tally| tally.class == Class::Wrong).unwrap();
    let shrunk = wrong.shrunk.as_ref().unwrap();
    assert_eq!(shrunk.deviations.len(), 1, "{:?}", shrunk.deviations);
    assert_eq!(shrunk.deviations[0].what, "nozzle.build_ms");
    // 10 ms, and the time that the axis takes to leave the part, reach 20 of 60 kPa with a constant below some 180 ms.
    let limit = 90.0 + shrunk.deviations[0].by[0];
    assert!((140.0..220.0).contains(&limit), "{limit}");
    let table = proof.table("hasty.bas", &|line| line, &|_| Some(90.0));
    for words in [
        "that is nozzle.build_ms above 1",
        "the cell says 90",
        "again: pasapas sim hasty.bas --deviate \"nozzle.build_ms ",
    ] {
        assert!(table.contains(words), "{words}: {table}");
    }
    // No run came to the handler of errors.
    assert_eq!(proof.unreached, [23, 24], "{table}");
    let json = proof.json(&|line| line);
    assert!(json.iter().any(|line| line.starts_with(r#"{"outcome":"wrong","runs":"#)), "{json:?}");
    // The seed repeats it alone.
    let again = hasty(Plan { runs: 1, seed: wrong.seed, ..ALL });
    assert_eq!(counts(&again), [(Class::Wrong, 1)]);
}

#[test]
fn the_answer_does_not_depend_on_the_threads_and_parts_join_to_the_whole() {
    let few = Plan { runs: 4, seed: 6, ..ALL };
    let whole = hasty(few);
    let lines = |proof: &Proof| {
        let mut lines = proof.json(&|line| line);
        lines.pop(); // its time
        lines
    };
    let alone = hasty(Plan { jobs: 1, ..few });
    assert_eq!(lines(&alone), lines(&whole));
    let parts = [0, 1].map(|own| hasty(Plan { shard: (own, 2), ..few }));
    for class in Class::ALL {
        let of = |proof: &Proof| {
            counts(proof).iter().find(|(own, _)| *own == class).map_or(0, |(_, runs)| *runs)
        };
        assert_eq!(parts.iter().map(of).sum::<u64>(), of(&whole), "{class:?}");
    }
    assert_eq!(parts.map(|proof| proof.runs), [2, 2]);
}

#[test]
fn it_ends_at_the_first_failure_or_when_it_is_asked_to() {
    let first = hasty(Plan { runs: 9, seed: 7, until_fails: true, ..ALL });
    // Seed 8 is the first that fails.
    assert_eq!((first.runs, first.tallies.last().unwrap().seed), (2, 8));
    let none = with_hasty(|case| proof::prove(case, &ALL, &|| true, &|_| {}).unwrap());
    assert_eq!((none.runs, none.holds()), (0, false));
}

/// What a fault took away and the script could not know stays excused; what it could, not.
#[test]
fn faults_are_told_from_tolerances() {
    let class = |texts: &[&str]| {
        let list: Vec<Deviation> =
            texts.iter().map(|text| Deviation::parse(text).unwrap()).collect();
        with_hasty(|case| case.run(&list).unwrap().class)
    };
    assert_eq!(class(&[]), Class::Passed);
    assert_eq!(class(&["missing tray.2"]), Class::Handled);
    assert_eq!(class(&["nozzle.build_ms 200"]), Class::Wrong);
    // It sticks while the next one is to be taken, and hangs on the nozzle at the end.
    assert_eq!(class(&["stuck tray.3 90000ms"]), Class::Unsafe);
    assert_eq!(class(&["lost tray.1 700ms"]), Class::Wrong);
    assert_eq!(class(&["stall X 300st at 5.3s"]), Class::Wrong);
    assert_eq!(class(&["estop at 3s"]), Class::Handled);
}

/// A client that has ended writes no AT variable any more, of the cell's people or of a world, on any engine.
#[test]
fn who_is_gone_writes_nothing() {
    let script = "DIM go AT 3000, left AS TIME\nleft = 3s\nWHILE go = 0 AND left > 0s\n  Wait 100ms\n  \
                  left = left - 100ms\nWEND\nPRINT go\n";
    let program = program(script);
    let compiled = lang::back::compile(&program).unwrap();
    let panel = "person = [{ does = \"at\", at_s = 1, register = 3000, value = 7 }]\n";
    let hosts = [
        (panel, World::unattended()),
        ("", World::parse("w.rhai", "at(1000, || set_at(3000, 7));").unwrap()),
    ];
    for (people, world) in hosts {
        for (at, printed) in [("2s", "7"), ("0.5s", "0")] {
            let scene = cell_of(&format!("cell = 1\n{people}"), &program);
            let gone = Deviation::parse(&format!("gone at {at}")).unwrap();
            let world = world.clone().with_scene(Some(scene.deviating(vec![gone])));
            let options = Options::default();
            let on_machine =
                run_native_traced(DEFAULT, &program, &compiled, &world, &options).unwrap().0;
            let vm = run_traced(&program, Engine::Vm, &world, &options).unwrap().0;
            let rhai = run_traced(&program, Engine::Rhai, &world, &options).unwrap().0;
            for outcome in [on_machine.outcome, vm, rhai] {
                let report = outcome.cell.expect("a cell");
                assert_eq!(report.end.printed, [printed], "{people} gone at {at}");
            }
        }
    }
}
