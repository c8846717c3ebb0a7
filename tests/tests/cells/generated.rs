//! Scenes and scripts by the hundred: what happens in a cell does not depend on the engine.
//!
//! CI takes few; `CELL_SCENES=1000 cargo test -p tests --test cells generated` takes a thousand.

use pasapas::scene::{self, Report};
use pasapas::sim::trace::to_text;
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, run_traced};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestCaseError, TestRunner};

use super::{board, native, program, report, words};

/// A scene with its script: what stands where, how fast it is, and how the script goes about it.
#[derive(Clone, Debug)]
struct Made {
    script: String,
    cell: String,
}

/// What happened, without lengths: what is taken on the way hangs a step higher where a statement takes longer.
fn bare(report: &Report) -> Vec<String> {
    let own = |word: String| {
        let end = [",\"mm\":", ",\"pos\":"].iter().filter_map(|key| word.find(key)).min();
        word[..end.unwrap_or(word.len())].to_owned()
    };
    words(report).into_iter().map(own).collect()
}

fn made() -> impl Strategy<Value = Made> {
    let tray = (15..40i32, 20..60i32, 10..16i32, 1..4usize, 1..5usize);
    let nozzle = (
        prop::sample::select(vec![15, 60, 300]),
        prop::sample::select(vec![80, 700]),
        0..3i32,
        prop::sample::select(vec![5, 20, 60]),
    );
    let ways =
        (90..150i32, 30..90i32, 0..20i32, 10..21i32, prop::sample::select(vec![400, 1500, 4000]));
    let around = (70..85i32, 5..60i32, 1..8i32, 60..90i32, any::<bool>());
    (tray, nozzle, ways, around).prop_map(|(tray, nozzle, ways, around)| {
        let (x, y, pitch, count, empty) = tray;
        let (build, wait, press, speed) = nozzle;
        let (to_x, to_y, lift, down, rate) = ways;
        let (wall, high, wide, eye, inverted) = around;
        let last = count - 1;
        let pick = 22 + press;
        let script = format!(
            "OUTPUT pump = 3\nINPUT held = 3, eye = 5\nDIM n, seen, got\nHome\nFOR n = 0 TO {last}\n\
             G0 X[{x}mm + n * {pitch}mm] Y{y}\nMoveAxe Z, -{pick}mm, {speed}mm/s\nSetOut pump, ON\n\
             WaitIn? held, ON, {wait}ms\nIF TIMEDOUT THEN\nPRINT \"no part \"; n\nELSE\ngot = got + 1\nEND IF\n\
             MoveAxe Z, -{lift}mm\nG1 X{eye} F{rate}\nWait 20ms\nIF IN(eye) THEN seen = seen + 1\nG1 X{to_x} Y{to_y} F{rate}\n\
             MoveAxe Z, -{down}mm, 40mm/s\nSetOut pump, OFF\nWait 250ms\nMoveAxe Z, 0mm\nNEXT\nPRINT got; \" \"; seen\n"
        );
        let gone = if empty <= count { format!(", empty = [{empty}]") } else { String::new() };
        let invert = if inverted { ", invert = true" } else { "" };
        let cell = format!(
            "cell = 1\ntable = -60\n\
             tool = [{{ name = \"nozzle\", kind = \"vacuum\", output = \"pump\", input = \"held\", build_ms = {build}, reach = 1.5, press = 3, body = [{{ at = [0, 0, 4], size = [6, 6, 40] }}] }}]\n\
             part = [{{ name = \"chip\", size = [8, 8, 4] }}]\n\
             feeder = [{{ name = \"tray\", part = \"chip\", at = [{x}, {y}, -26], pitch = [{pitch}, 0], count = [{count}, 1]{gone} }}]\n\
             fixture = [{{ name = \"wall\", at = [{wall}, 50, -60], size = [{wide}, 140, {high}] }}]\n\
             place = [{{ name = \"box\", at = [{to_x}, {to_y}, -30], size = [20, 20, 10], room = 0 }}]\n\
             sensor = [{{ name = \"light\", kind = \"beam\", from = [{eye}, 0, -2], to = [{eye}, 120, -2], input = \"eye\", sees = [\"held\"], on_ms = 2{invert} }}]\n\
             expect = [{{ what = \"in_place\", place = \"box\", of = \"tray\" }}, {{ what = \"no_collision\" }}]\n"
        );
        Made { script, cell }
    })
}

#[test]
fn generated_scenes_are_the_same_on_every_engine() {
    let cases = std::env::var("CELL_SCENES").ok().and_then(|text| text.parse().ok()).unwrap_or(12);
    let boards = std::cell::Cell::new(0);
    let mut runner =
        TestRunner::new(Config { cases, failure_persistence: None, ..Config::default() });
    let same = |made: Made| {
        let program = program(&made.script);
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("job.cell.toml");
        std::fs::write(&file, &made.cell).unwrap();
        let read = scene::read(&file.display().to_string(), &program.profile, Some(&program));
        // Where the wall stands in a part, the cell is refused.
        let Ok((scene, _)) = read else { return Err(TestCaseError::reject("refused")) };
        let world = World::unattended().with_scene(Some(scene));
        let (run, events) = native(&program, &world);
        let (machine, trace) = (report(run), to_text(&events));
        for engine in [Engine::Vm, Engine::Rhai] {
            let options = Options::default();
            let (outcome, events) = run_traced(&program, engine, &world, &options).unwrap();
            let own = outcome.cell.expect("the run had a cell");
            prop_assert_eq!(to_text(&events), trace.clone(), "{:?}\n{}", engine, made.script);
            prop_assert_eq!(
                bare(&own),
                bare(&machine),
                "{:?}\n{}\n{}",
                engine,
                made.script,
                made.cell
            );
        }
        // The emulated board takes a hundred times as long.
        if boards.get() < cases / 50 + 1 {
            boards.set(boards.get() + 1);
            let (run, events) = board(&program, &world);
            prop_assert_eq!(to_text(&events), trace, "board\n{}", made.script);
            prop_assert_eq!(
                bare(&report(run)),
                bare(&machine),
                "board\n{}\n{}",
                made.script,
                made.cell
            );
        }
        Ok(())
    };
    runner.run(&made(), same).unwrap_or_else(|error| panic!("{error}"));
}
