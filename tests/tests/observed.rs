//! Engine `board` is equal to an unobserved board: its own pace, the world from the first statement
//! on, the ends of the other engines.

use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::hir::Program;
use pasapas::board::engine::{self, BoardError, BoardRun};
use pasapas::board::{BUILDS, Build, F5529, G2553};
use pasapas::sim::record::StopReason;
use pasapas::sim::trace::{Event, What, to_text};
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, run_traced};

/// Nothing here takes longer on any engine.
const OPTIONS: fn() -> Options = || Options { limit_us: 20_000_000, ..Options::default() };

fn program(script: &str) -> Program {
    let source = Source::new("observed.bas", script.to_owned());
    let (program, diags) = compile(&source, ProfileChoice::built_in());
    program.unwrap_or_else(|| panic!("{script}: {}", diags.render(&source)))
}

fn on_board(
    build: &Build,
    script: &str,
    world: &str,
) -> Result<(BoardRun, Vec<Event>), BoardError> {
    let program = program(script);
    let compiled = lang::back::compile(&program).expect("it fits");
    let world = World::parse("w.rhai", world).expect("a world");
    let (image, sidecar) = (&compiled.image, &compiled.sidecar);
    engine::run_traced(build, &program, image, sidecar, &world, &OPTIONS())
}

/// The same trace from every engine, `part`s as named; gives that of the board.
fn alike(builds: &[&Build], script: &str, world: &str) -> Vec<Vec<Event>> {
    let checked = program(script);
    let parsed = World::parse("w.rhai", world).expect("a world");
    let (_, wanted) = run_traced(&checked, Engine::Rhai, &parsed, &OPTIONS()).expect("rhai");
    let (_, vm) = run_traced(&checked, Engine::Vm, &parsed, &OPTIONS()).expect("vm");
    assert_eq!(to_text(&vm), to_text(&wanted), "vm\n{script}");
    let run = |build: &&Build| {
        let (_, events) =
            on_board(build, script, world).unwrap_or_else(|e| panic!("{script}: {e}"));
        assert_eq!(to_text(&events), to_text(&wanted), "{}\n{script}", build.part.name);
        events
    };
    builds.iter().map(run).collect()
}

const BOTH: [&Build; 2] = [&G2553, &F5529];

/// Before the board has its profile the pins of wiring `direct` carry the shift registers' clock and data.
#[test]
fn outputs_of_a_run_are_those_of_the_run() {
    let used = |build: &Build, script: &str| {
        let (run, _) = on_board(build, script, "").expect("a run");
        let used = run.outcome.summary.outputs.iter();
        used.map(|own| (own.n, own.switched_on)).collect::<Vec<_>>()
    };
    for build in BOTH {
        assert_eq!(used(build, "PROFILE \"thesis\"\nMoveAxe X, 1mm"), [], "{}", build.part.name);
        let script = "PROFILE \"thesis\"\nSetOut 2, ON\nWait 20ms\nSetOut 2, OFF\nWait 20ms";
        assert_eq!(used(build, script), [(2, 1)], "{}", build.part.name);
    }
}

/// What the operator gave before Start is there in the first statement, on every engine.
#[test]
fn variables_of_the_operator_have_their_values_from_the_first_statement_on() {
    let script = "DIM qty AT 3000, far AS LENGTH AT 3004\nPRINT qty; far";
    alike(&BOTH, script, "set_at(3000, 5);\nset_at(3004, -70000);");
    alike(&BOTH, script, "at(0, || { set_at(3000, 7); set_at(3004, 1); });");
}

#[test]
fn a_loop_takes_the_time_that_it_takes_unobserved() {
    let script = "DIM i\nFOR i = 1 TO 300\nSetOut 3, ON\nWait 5ms\nSetOut 3, OFF\nWait 5ms\nNEXT";
    for events in alike(&BOTH, script, "") {
        let us = events.last().and_then(|event| event.us).expect("times");
        assert!((2_990_000..3_010_000).contains(&us), "{us} us");
    }
    // Six hundred effects without a wait between them: nothing of it is the observer's.
    let script = "DIM i\nFOR i = 1 TO 300\nSetOut 3, ON\nSetOut 3, OFF\nNEXT";
    for events in alike(&BOTH, script, "") {
        let us = events.last().and_then(|event| event.us).expect("times");
        assert!(us < 60_000, "{us} us");
    }
}

#[test]
fn the_world_sees_the_first_statements_and_what_it_set_is_there() {
    alike(&BOTH, "SetOut 1, ON\nWaitIn 1, ON, 1s", "after_out(1, true, 80, || set_in(1, true));");
    alike(&BOTH, "IF IN(1) THEN PRINT \"on\" ELSE PRINT \"off\"", "set_in(1, true);");
    alike(&BOTH, "IF IN(1) THEN PRINT \"on\" ELSE PRINT \"off\"", "at(0, || set_in(1, true));");
    let late = "after_out(4, true, 0, || set_in(2, true));";
    alike(&BOTH, "Wait 100ms\nSetOut 4, ON\nPRINT IN(2)", late);
    // A line longer than the ring of the G2553, and one whose statement fails.
    alike(&BOTH, "PRINT \"more than the ring of sixteen bytes \"; 1234567890\nPRINT 2", "");
    let fails = "DIM none\nON ERROR GOTO away\nPRINT \"lost \"; 1 / none\nPRINT \"here\"\nEND\n\
                 away:\nRESUME NEXT";
    alike(&[&F5529], fails, "");
    // A stop takes effect where a segment of 8 ms ends: not at a time within 2 ms of such an end, which
    // the board's planning decides.
    alike(&[&F5529], "MoveSpeed X, 10mm/s\nWait 99ms\nStopAll", "");
}

#[test]
fn one_character_is_one_character() {
    let script = "WaitChar? 65, 3s\nPRINT TIMEDOUT\nWaitChar? 65, 1s\nPRINT TIMEDOUT";
    alike(&BOTH, script, "at(1000, || { send_char(65); send_char(65); send_char(65); });");
    alike(&BOTH, script, "at(1000, || send_char(65)); at(1100, || send_char(65));");
}

#[test]
fn the_outputs_of_a_port_change_together() {
    for build in BOTH {
        let (run, _) = on_board(build, "SetPort 255\nWait 50ms\nSetPort 0\nWait 20ms", "").unwrap();
        let edges = &run.outcome.record.outputs;
        assert_eq!(edges.len(), 16, "{edges:?}");
        for edge in edges {
            assert_eq!(edge.us, edges[if edge.on { 0 } else { 8 }].us, "{edges:?}");
        }
        assert_eq!(run.outcome.summary.outputs.len(), 8);
    }
}

#[test]
fn a_summary_lists_outputs_without_a_record() {
    let program = program("SetOut 2, ON\nWait 50ms\nSetOut 2, OFF\nWait 10ms");
    let compiled = lang::back::compile(&program).unwrap();
    let options = Options { record: false, ..OPTIONS() };
    let (image, sidecar) = (&compiled.image, &compiled.sidecar);
    let run = engine::run_traced(&G2553, &program, image, sidecar, &World::empty(), &options);
    let (run, _) = run.unwrap();
    let [used] = run.outcome.summary.outputs[..] else { panic!("one output") };
    assert_eq!((used.n, used.switched_on), (2, 1));
    assert!((48_000..52_000).contains(&used.on_us), "{used:?}");
    assert!(run.outcome.record.outputs.is_empty());
}

#[test]
fn runs_that_somebody_or_nothing_ends_say_so_alike() {
    // Equal effects of two engines lie less than 10 ms and 2 % apart.
    let cases = [
        ("MoveAxe X, 100mm", "at(300, || press_stop());", StopReason::Idle, 300_000),
        ("MoveAxe X, 100mm", "hold_stop(300, 3000);", StopReason::Button, 2_300_000),
        ("Wait 100ms\nSetOut 2, ON\nWaitIn 3, ON", "", StopReason::Idle, 88_000),
        ("DO\nLOOP", "", StopReason::Limit, 20_000_000),
    ];
    for build in BOTH {
        for (script, world, reason, least) in cases {
            let (run, events) = on_board(build, script, world).unwrap();
            let summary = &run.outcome.summary;
            assert_eq!(summary.stopped, Some(reason), "{script}");
            assert!((least..least + 400_000).contains(&summary.us), "{script}: {}", summary.us);
            assert!(matches!(events.last().unwrap().what, What::End { .. }));
            assert!(run.remarks.is_empty(), "{:?}", run.remarks);
        }
    }
}

#[test]
fn positions_are_told_alike() {
    // Scales on which 0.333 mm is no whole number of steps.
    let script = "DIM n\nDO\nMoveRel X, 0.333mm\nn = n + 1\nLOOP UNTIL POS(X) > 0.998mm OR n = 5\n\
                  PRINT n; \" \"; POS(X); \" \"; POSST(X)\nSetPos X, 0mm\nPRINT POS(X)\n\
                  G91 G81 X1 Z-0.333 R0.017 F300\nG80\nPRINT POS(Z); \" \"; POSST(Z)";
    alike(&BOTH, script, "switch_at(\"Z\", 100000); switch_at(\"X\", -100000);");
}

/// What an image keeps of joined lines is looked at in images that have them alone: elsewhere other bytes lie there.
#[test]
fn a_probe_behind_a_line_tells_of_no_line() {
    let probes = "HOME\nG1 Z-2 F1200\nProbe? Z, -4mm, 4mm/s\nG1 X1\nProbe? X, 2mm, 4mm/s\nPulse 1, 5ms\nG0 X0\nHOME X\n";
    for events in alike(&BUILDS, probes, "") {
        let moves = events.iter().filter(|event| matches!(event.what, What::Move { .. })).count();
        assert_eq!(moves, 3);
    }
}

#[test]
fn a_start_value_is_evaluated_before_limit_and_step() {
    let script = "DIM i, q, n\nTABLE t = 1, 2\nn = 5\nFOR i = 1 / q TO t(n)\nNEXT";
    for events in alike(&BOTH, script, "") {
        let What::End { fault, .. } = &events.last().unwrap().what else { panic!("an end") };
        assert_eq!(fault.as_deref(), Some("F02"));
    }
    alike(
        &BOTH,
        "DIM i\nWait 100ms\nFOR i = CHARIN() TO CHARIN()\nNEXT\nPRINT i",
        "at(50, || send_char(65));",
    );
    alike(
        &BOTH,
        "DIM i, n\nn = 4\nFOR i = n TO n + 2\nPRINT i\nNEXT\nFOR i = i TO i + 1\nPRINT i\nNEXT",
        "",
    );
}

#[test]
fn the_largest_board_takes_as_deep_an_expression_as_an_image_can_say() {
    let deep = |n: usize| {
        let (open, close) = ("a - (".repeat(n), ")".repeat(n));
        format!("DIM a, b(250)\nb(1) = 7\na = {open}b(1){close}\nPRINT a")
    };
    alike(&[&F5529], &deep(13), "");
    let error =
        run_traced(&program(&deep(20)), Engine::Vm, &World::empty(), &OPTIONS()).unwrap_err();
    assert!(error.to_string().contains("Stack") && error.to_string().contains("rhai"), "{error}");
}

#[test]
fn a_callback_that_fails_is_the_worlds_mistake() {
    for world in ["at(5, || { loop { } });", "at(5, || set_in(40, true));"] {
        match on_board(&G2553, "MoveAxe X, 10mm", world) {
            Err(BoardError::World(error)) => assert_eq!(error.code, "S002"),
            Err(error) => panic!("{error}"),
            Ok(_) => panic!("it runs"),
        }
    }
}
