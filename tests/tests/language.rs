//! The language reference, sentence by sentence: scripts in `data/language` say in their comments
//! what they print and how they end, and every host engine must agree.
//!
//! `'> text` is the next line that PRINT writes, `'@ line 100 0 -50` the next move with the steps of
//! its axes (where a script names any), `'= done 7` or `'= fault F05 7` the end with its line,
//! `'~ code` a line of the scenario, `'---` begins the next script of the file.

use std::path::{Path, PathBuf};

use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use pasapas::sim::trace::{Event, MoveKind, PerAxis, Status, What, to_text};
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, run_traced};

const ENGINES: [Engine; 2] = [Engine::Rhai, Engine::Vm];

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

#[test]
fn every_engine_does_what_the_reference_says() {
    let mut wrong = Vec::new();
    let mut count = 0;
    for file in scripts() {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        let text = std::fs::read_to_string(&file).unwrap();
        for (part, script) in text.split("'---\n").enumerate() {
            count += 1;
            // In the order of the text, as the marks stand behind the statements.
            let expected: Vec<String> = script
                .lines()
                .filter_map(|line| line.trim_start().strip_prefix('\''))
                .filter(|line| ["> ", "@ ", "= "].iter().any(|mark| line.starts_with(mark)))
                .map(str::to_owned)
                .collect();
            let moves = expected.iter().any(|line| line.starts_with('@'));
            let source = Source::new(&name, script.to_owned());
            let (program, diags) = compile(&source, ProfileChoice::built_in());
            let Some(program) = program else {
                wrong.push(format!("{name} {part}:\n{}", diags.render(&source)));
                continue;
            };
            let scenario: String = marked(script, "'~ ").map(|line| format!("{line}\n")).collect();
            let world = World::parse(&name, &scenario).unwrap();
            let mut traces = Vec::new();
            for engine in ENGINES {
                let options = Options { limit_us: 3_600_000_000, ..Options::default() };
                match run_traced(&program, engine, &world, &options) {
                    Ok((outcome, events)) => {
                        let mut got = shown(&events, moves);
                        got.extend(outcome.failures);
                        traces.push(to_text(&events));
                        if got != expected {
                            let (got, expected) = (got.join("\n"), expected.join("\n"));
                            wrong.push(format!(
                                "{name} {part} on {engine:?}\n{script}--- got\n{got}\n--- expected\n{expected}\n"
                            ));
                        }
                    }
                    Err(error) => {
                        wrong.push(format!("{name} {part} on {engine:?}: {error}\n{script}"))
                    }
                }
            }
            if traces.windows(2).any(|pair| pair[0] != pair[1]) {
                wrong.push(format!("{name} {part}: {}", traces.join("\n--- the other\n")));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n=====\n"));
    assert!(count > 50);
}
