//! Programs of other systems: each file of examples/import becomes a script that compiles at once
//! and does, on every host engine, what the trace beside it says. Those traces were checked by hand
//! against the sources' own step counts.

use std::path::{Path, PathBuf};

use import::{Imported, import};
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::profile::Profile;
use pasapas::sim::trace::{Event, to_text};
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, run_traced};

/// Files that are for another machine than their format's usual one.
const PROFILES: [(&str, &str); 1] = [("letter.nc", "thesis")];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/import")
}

fn read(file: &Path) -> String {
    std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

fn script(file: &Path) -> String {
    let name = file.file_name().unwrap().to_string_lossy().into_owned();
    let profile = PROFILES.iter().find(|(known, _)| *known == name);
    let profile = profile.map(|(_, profile)| Profile::built_in(profile).unwrap());
    let options = import::Options { profile, ..import::Options::default() };
    match import(&name, read(file).as_bytes(), &options) {
        Ok(Imported { script, .. }) => script,
        Err(diags) => panic!("{}", diags.iter().map(|diag| diag.render(&name)).collect::<String>()),
    }
}

fn run(script: &str, world: &World, engine: Engine) -> Vec<Event> {
    let source = Source::new("imported", script.to_owned());
    let (program, diags) = compile(&source, ProfileChoice::built_in());
    let program = program.unwrap_or_else(|| panic!("{script}\n{}", diags.render(&source)));
    let options = Options { times: false, ..Options::default() };
    let (outcome, events) = run_traced(&program, engine, world, &options).unwrap();
    assert_eq!(outcome.failures, Vec::<String>::new());
    events
}

#[test]
fn imported_files_do_what_their_traces_say() {
    let mut files: Vec<_> =
        std::fs::read_dir(folder()).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| {
        !file.extension().is_some_and(|extension| extension == "trace" || extension == "rhai")
    });
    files.sort();
    assert!(files.len() >= 10);
    for file in files {
        let script = script(&file);
        let world = file.with_extension("rhai");
        let world = match world.is_file() {
            true => World::parse("world", &read(&world)).unwrap(),
            false => World::empty(),
        };
        let expected = read(&file.with_extension("trace"));
        for engine in [Engine::Rhai, Engine::Vm] {
            let trace = to_text(&run(&script, &world, engine));
            assert_eq!(trace, expected, "{} on {engine:?}\n{script}", file.display());
        }
    }
}

/// A trace without its line numbers, which are another script's.
fn effects(events: &[Event]) -> Vec<String> {
    let text = to_text(events);
    let plain = |line: &str| {
        let (before, rest) = line.split_once("\"line\":")?;
        Some(format!("{before}{}", rest.split_once(',')?.1))
    };
    text.lines().map(|line| plain(line).unwrap_or_else(|| line.to_owned())).collect()
}

#[test]
fn the_manuals_socket_is_the_script_of_it() {
    let ours = read(&folder().join("../dil14.bas"));
    let ours = effects(&run(&ours, &World::empty(), Engine::Vm));
    assert!(ours.len() > 40, "{ours:#?}");
    for listing in ["dil14.isel", "dil14_listing.lst"] {
        let imported = script(&folder().join(listing));
        assert_eq!(effects(&run(&imported, &World::empty(), Engine::Vm)), ours, "{listing}");
    }
}
