//! The book: its pages can be filled, its links lead somewhere, its scripts run alike on both engines, and the
//! tool takes the commands that it shows.

use std::path::{Path, PathBuf};
use std::process::Command;

use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use pasapas::sim::trace::{Status, to_text};
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, run_traced};

/// Files of a folder of the book with this ending.
fn files(folder: &str, ending: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("book/src").join(folder);
    let entries = std::fs::read_dir(folder).expect("the folder").flatten();
    let found = entries.map(|entry| entry.path());
    found.filter(|path| path.extension().is_some_and(|own| own == ending)).collect()
}

#[test]
fn every_page_can_be_filled_and_every_link_leads_somewhere() {
    let said = Command::new("python3")
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("book/preprocess.py"))
        .arg("--check")
        .env("PASAPAS", env!("CARGO_BIN_EXE_pasapas"))
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .expect("python3");
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    assert!(String::from_utf8_lossy(&said.stdout).contains(" pages, "));
}

#[test]
fn its_scripts_run_alike_on_both_engines() {
    let scripts = files("scripts", "bas");
    assert!(scripts.len() >= 3);
    for path in scripts {
        let text = std::fs::read_to_string(&path).expect("a text");
        let source = Source::new("book", text);
        let (program, diags) = compile(&source, ProfileChoice::built_in());
        // The one that shows how mistakes are told.
        if path.ends_with("wrong.bas") {
            assert!(program.is_none());
            continue;
        }
        let program = program.unwrap_or_else(|| panic!("{}", diags.render(&source)));
        let options = Options { times: false, ..Options::default() };
        let traces = [Engine::Rhai, Engine::Vm].map(|engine| {
            let (outcome, events) =
                run_traced(&program, engine, &World::empty(), &options).expect("it runs");
            assert_eq!(outcome.end.status, Status::Done, "{engine:?}: {}", path.display());
            to_text(&events)
        });
        assert_eq!(traces[0], traces[1], "{}", path.display());
    }
}

#[test]
fn the_tool_takes_every_command_that_it_shows() {
    let mut count = 0;
    for page in files("", "md") {
        let text = std::fs::read_to_string(&page).expect("a text");
        let shown = text.split("```sh\n").skip(1).filter_map(|part| part.split("```").next());
        for line in shown.flat_map(str::lines) {
            let line = line.split('#').next().unwrap_or_default().trim();
            if !line.starts_with("pasapas ") || line.ends_with("--version") {
                continue;
            }
            let taken = pasapas::cmd::command_line().try_get_matches_from(line.split_whitespace());
            assert!(taken.is_ok(), "{}: {line}\n{}", page.display(), taken.unwrap_err());
            count += 1;
        }
    }
    assert!(count > 20, "only {count} commands");
}
