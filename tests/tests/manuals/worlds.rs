//! host/worlds.md

use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::hir::Program;
use pasapas::board::{DEFAULT, engine};
use pasapas::scene::{self, Scene};
use pasapas::sim::trace::{Event, Status, What};
use pasapas::sim::world::{FUNCTIONS, World};
use pasapas::sim::{Engine, Options, Outcome, run_traced};

const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../host/worlds.md");

/// Only the engines without a link of their own have it, as the table says.
const SIMULATED: &str = "at_value(";

fn page() -> String {
    std::fs::read_to_string(PAGE).expect("the page")
}

#[test]
fn the_table_is_that_of_the_functions() {
    let mut table = String::from("\n| function | does |\n|---|---|\n");
    for (call, meaning) in FUNCTIONS {
        table += &format!("| `{}` | {meaning} |\n", call.replace('|', "\\|"));
    }
    table += "\n";
    let (begin, end) =
        ("<!-- functions: made by the test `manuals` -->\n", "<!-- end of functions -->\n");
    let page = page();
    let (before, rest) = page.split_once(begin).expect("its begin");
    let (shown, after) = rest.split_once(end).expect("its end");
    if std::env::var_os("UPDATE_README").is_some() {
        std::fs::write(PAGE, [before, begin, &table, end, after].concat()).expect("written");
        return;
    }
    assert_eq!(shown, table, "run UPDATE_README=1 cargo test -p tests --test manuals");
}

struct Example<'a> {
    script: &'a str,
    /// The cell that the world is beside, if one is.
    cell: Option<&'a str>,
    world: &'a str,
    said: &'a str,
}

/// The text of the next block of this language, and what is behind it.
fn block<'a>(text: &'a str, language: &str) -> Option<(&'a str, &'a str)> {
    let (_, rest) = text.split_once(&format!("```{language}\n"))?;
    rest.split_once("```\n")
}

fn examples(mut page: &str) -> Vec<Example<'_>> {
    let mut examples = Vec::new();
    while let Some((script, rest)) = block(page, "basic") {
        let (cell, rest) = match (rest.find("```toml\n"), rest.find("```rhai\n")) {
            (Some(cell), Some(world)) if cell < world => {
                let (cell, rest) = block(rest, "toml").expect("a cell");
                (Some(cell), rest)
            }
            _ => (None, rest),
        };
        let (world, rest) = block(rest, "rhai").expect("a world behind each script");
        let (said, rest) = block(rest, "text").expect("what it prints behind each world");
        examples.push(Example { script, cell, world, said });
        page = rest;
    }
    examples
}

/// What a run printed and how it ended, as the page tells it.
fn said(outcome: &Outcome, events: &[Event]) -> String {
    let mut text = String::new();
    for event in events {
        if let What::Print { text: line, .. } = &event.what {
            text += &format!("{line}\n");
        }
    }
    let end = match (outcome.end.status, outcome.end.fault) {
        (Status::Done, _) => "done".to_owned(),
        (Status::Stopped, _) => "stopped".to_owned(),
        (Status::Fault, fault) => fault.expect("its number").to_string(),
    };
    assert_eq!(outcome.failures, Vec::<String>::new());
    format!("{text}ends: {end}\n")
}

fn scene_of(cell: &str, program: &Program) -> Scene {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("job.cell.toml");
    std::fs::write(&file, cell).expect("it is written");
    let read = scene::read(&file.display().to_string(), &program.profile, Some(program));
    read.unwrap_or_else(|notes| panic!("{notes:?}")).0
}

#[test]
fn the_examples_do_what_the_page_says_on_every_engine() {
    let page = page();
    let examples = examples(&page);
    for (call, _) in FUNCTIONS {
        let name = format!("{}(", call.split('(').next().unwrap_or_default());
        let shown = examples.iter().any(|example| example.world.contains(&name));
        assert!(shown, "no example has {call}");
    }
    for Example { script, cell, world, said: expected } in examples {
        let source = Source::new("worlds.md", script.to_owned());
        let (program, diags) = compile(&source, ProfileChoice::built_in());
        let program = program.unwrap_or_else(|| panic!("{script}\n{}", diags.render(&source)));
        let on_board = !world.contains(SIMULATED);
        let world = World::parse("worlds.md", world).unwrap_or_else(|error| panic!("{error}"));
        let world = world.with_scene(cell.map(|cell| scene_of(cell, &program)));
        let options = Options::default();
        for engine in [Engine::Rhai, Engine::Vm] {
            let (outcome, events) = run_traced(&program, engine, &world, &options)
                .unwrap_or_else(|error| panic!("{script}\n{error}"));
            assert_eq!(said(&outcome, &events), expected, "{engine:?}:\n{script}");
        }
        if !on_board {
            continue;
        }
        let compiled = lang::back::compile(&program).expect("it fits");
        let (image, sidecar) = (&compiled.image, &compiled.sidecar);
        let run = engine::run_traced(DEFAULT, &program, image, sidecar, &world, &options);
        let (run, events) = run.unwrap_or_else(|error| panic!("{script}\n{error}"));
        assert_eq!(said(&run.outcome, &events), expected, "board:\n{script}");
    }
}
