//! The programs of the language reference run to their end, with one trace on both host engines.

use lang::front::fmt::format;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use pasapas::sim::trace::{Status, to_text};
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, run_traced};

const REFERENCE: &str = include_str!("../../lang/README.md");

/// Worlds of the programs that would not end without one: a line of the program, its world, and what it prints.
const WORLDS: [(&str, &str, &str); 1] = [
    // The endless feed: stopped by input 3 in its second hour.
    ("LOOP UNTIL IN(3)\n", "at(61 * 60 * 1000, || set_in(3, true));", "an hour more"),
];

#[test]
fn programs_of_the_reference_run_alike_on_both_engines() {
    let programs = REFERENCE.split("```basic\n").skip(1);
    let programs: Vec<&str> = programs.filter_map(|p| p.split("```").next()).collect();
    assert!(programs.len() >= 8, "{} programs", programs.len());
    let options = Options { times: false, ..Options::default() };
    let mut with_world = 0;
    for text in programs {
        let world = WORLDS.iter().find(|(line, ..)| text.contains(line));
        let prints = world.map(|(.., prints)| *prints);
        let world = world.map_or_else(World::unattended, |(_, world, _)| {
            with_world += 1;
            World::parse("README.md", world).expect("a world")
        });
        let source = Source::new("README.md", text.to_owned());
        let (program, diags) = compile(&source, ProfileChoice::built_in());
        let program = program.unwrap_or_else(|| panic!("{text}\n{}", diags.render(&source)));
        let traces = [Engine::Rhai, Engine::Vm].map(|engine| {
            let run = run_traced(&program, engine, &world, &options);
            let (outcome, events) = run.unwrap_or_else(|error| panic!("{text}\n{error}"));
            assert_eq!(outcome.end.status, Status::Done, "{engine:?}:\n{text}");
            let events = to_text(&events);
            let printed = prints.is_none_or(|prints| events.matches(prints).count() == 1);
            assert!(printed, "{prints:?} is not printed once:\n{text}");
            (events, outcome.vars)
        });
        assert_eq!(traces[0], traces[1], "{text}");
    }
    assert_eq!(with_world, WORLDS.len(), "a world whose program is gone");
}

#[test]
fn examples_are_in_the_formatters_style() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let mut scripts = 0;
    for entry in std::fs::read_dir(folder).expect("the examples") {
        let path = entry.expect("an entry").path();
        if path.extension().is_some_and(|extension| extension == "bas") {
            let text = std::fs::read_to_string(&path).expect("a text");
            let formatted = format(&text).unwrap_or_else(|_| panic!("{} is wrong", path.display()));
            assert!(formatted == text, "`pasapas fmt {}` would change it", path.display());
            scripts += 1;
        }
    }
    assert!(scripts >= 16);
}
