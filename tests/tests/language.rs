//! The language reference, sentence by sentence: scripts in `data/language` say in their comments
//! what they print and how they end, and every host engine must agree.
//!
//! `'> text` is the next line that PRINT writes, `'@ line 100 0 -50` the next move with the steps of
//! its axes (where a script names any), `'= done 7` or `'= fault F05 7` the end with its line,
//! `'~ code` a line of the scenario, `'host` keeps a script that hangs on an
//! instant off the board, `'---` begins the next script of the file.

use std::path::{Path, PathBuf};

use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::hir::Program;
use pasapas::board::{DEFAULT, engine};
use pasapas::sim::trace::{Event, MoveKind, PerAxis, Status, What, to_text};
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, run_traced};

const ENGINES: [Engine; 2] = [Engine::Rhai, Engine::Vm];

/// Longest run that the emulated board repeats here, us.
const LONGEST_US: u64 = 1_500_000;

fn scripts() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/language");
    let entries = std::fs::read_dir(folder).unwrap();
    let mut files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// The rest of each line that begins with `mark`.
fn marked<'s>(script: &'s str, mark: &'s str) -> impl Iterator<Item = &'s str> {
    script.lines().filter_map(move |line| line.trim_start().strip_prefix(mark))
}

/// A move in the form of the comments.
fn movement(kind: &MoveKind, to: &PerAxis) -> String {
    let places: Vec<String> = to.values().into_iter().flatten().map(|p| p.to_string()).collect();
    format!("@ {} {}", format!("{kind:?}").to_lowercase(), places.join(" "))
}

/// What a trace says, in the form of the comments.
fn shown(events: &[Event], moves: bool) -> Vec<String> {
    let one = |event: &Event| match &event.what {
        What::Move { kind, to, .. } => moves.then(|| movement(kind, to)),
        What::Print { text, .. } => Some(format!("> {text}")),
        What::End { status: Status::Fault, fault, line, .. } => {
            let fault = fault.as_deref().unwrap_or("without a number");
            Some(format!("= fault {fault} {line}"))
        }
        What::End { status, line, .. } => {
            Some(format!("= {} {line}", format!("{status:?}").to_lowercase()))
        }
        _ => None,
    };
    events.iter().filter_map(one).collect()
}

/// A script with what it says of itself.
struct Script {
    name: String,
    text: String,
    program: Program,
    world: World,
    expected: Vec<String>,
    /// It names its moves.
    moves: bool,
}

fn script(name: String, text: &str) -> Result<Script, String> {
    // In the order of the text, as the marks stand behind the statements.
    let expected: Vec<String> = text
        .lines()
        .filter_map(|line| line.trim_start().strip_prefix('\''))
        .filter(|line| ["> ", "@ ", "= "].iter().any(|mark| line.starts_with(mark)))
        .map(str::to_owned)
        .collect();
    let moves = expected.iter().any(|line| line.starts_with('@'));
    let source = Source::new(&name, text.to_owned());
    let (program, diags) = compile(&source, ProfileChoice::built_in());
    let program = program.ok_or_else(|| format!("{name}:\n{}", diags.render(&source)))?;
    let scenario: String = marked(text, "'~ ").map(|line| format!("{line}\n")).collect();
    let world = World::parse(&name, &scenario).map_err(|error| error.to_string())?;
    Ok(Script { name, text: text.to_owned(), program, world, expected, moves })
}

fn all() -> Vec<Script> {
    let mut list = Vec::new();
    for file in scripts() {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        let text = std::fs::read_to_string(&file).unwrap();
        for (part, text) in text.split("'---\n").enumerate() {
            list.push(script(format!("{name} {part}"), text).unwrap_or_else(|e| panic!("{e}")));
        }
    }
    assert!(list.len() > 50);
    list
}

impl Script {
    fn compare(
        &self,
        engine: &str,
        events: &[Event],
        failures: &[String],
        wrong: &mut Vec<String>,
    ) {
        let mut got = shown(events, self.moves);
        got.extend(failures.iter().cloned());
        if got != self.expected {
            let (got, expected) = (got.join("\n"), self.expected.join("\n"));
            wrong.push(format!(
                "{} on {engine}\n{}--- got\n{got}\n--- expected\n{expected}\n",
                self.name, self.text
            ));
        }
    }
}

#[test]
fn every_engine_does_what_the_reference_says() {
    let options = Options { limit_us: 3_600_000_000, ..Options::default() };
    let mut wrong = Vec::new();
    for script in all() {
        let mut traces = Vec::new();
        for engine in ENGINES {
            match run_traced(&script.program, engine, &script.world, &options) {
                Ok((outcome, events)) => {
                    let engine = format!("{engine:?}");
                    script.compare(&engine, &events, &outcome.failures, &mut wrong);
                    traces.push(to_text(&events));
                }
                Err(error) => wrong.push(format!("{} on {engine:?}: {error}", script.name)),
            }
        }
        if traces.windows(2).any(|pair| pair[0] != pair[1]) {
            wrong.push(format!("{}: {}", script.name, traces.join("\n--- the other\n")));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n=====\n"));
}

#[test]
fn the_board_does_what_the_reference_says_in_short_runs() {
    let options = Options { limit_us: 3_600_000_000, ..Options::default() };
    let mut wrong = Vec::new();
    let mut count = 0;
    for script in all() {
        let Script { name, program, world, .. } = &script;
        let (_, events) = run_traced(program, Engine::Vm, world, &options).unwrap();
        let long = events.last().and_then(|event| event.us).is_none_or(|us| us > LONGEST_US);
        if long || script.text.contains("'host\n") {
            continue;
        }
        let compiled = lang::back::compile(program).unwrap();
        let (image, sidecar) = (&compiled.image, &compiled.sidecar);
        let run = engine::run_traced(DEFAULT, program, image, sidecar, world, &options);
        let (run, told) = run.unwrap_or_else(|error| panic!("{name}: {error}"));
        script.compare("the board", &told, &run.outcome.failures, &mut wrong);
        let bare = |events: &[Event]| {
            let events: Vec<Event> =
                events.iter().map(|e| Event { us: None, ..e.clone() }).collect();
            to_text(&events)
        };
        if bare(&events) != bare(&told) {
            wrong.push(format!("{name}: {}--- the board\n{}", bare(&events), bare(&told)));
        }
        count += 1;
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n=====\n"));
    assert!(count > 50);
}
