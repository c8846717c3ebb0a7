//! Every example runs in its scenario with the trace that lies beside it, on every host engine.

use std::path::{Path, PathBuf};

use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use pasapas::sim::trace::to_text;
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, run_traced};

fn scripts() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let entries = std::fs::read_dir(folder).unwrap();
    let mut files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "bas"));
    files.sort();
    files
}

fn read(file: &Path) -> String {
    std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

#[test]
fn examples_run_as_their_traces_say() {
    let files = scripts();
    assert!(files.len() >= 16);
    for file in files {
        let name = file.file_stem().unwrap().to_string_lossy().into_owned();
        let source = Source::new(&name, read(&file));
        let (program, diags) = compile(&source, ProfileChoice::built_in());
        let program = program.unwrap_or_else(|| panic!("{}", diags.render(&source)));
        let world = World::parse(&name, &read(&file.with_extension("rhai"))).unwrap();
        let expected = read(&file.with_extension("trace"));
        for engine in [Engine::Rhai, Engine::Vm] {
            let options = Options { times: false, ..Options::default() };
            let (outcome, events) = run_traced(&program, engine, &world, &options).unwrap();
            assert_eq!(outcome.failures, Vec::<String>::new(), "{name} on {engine:?}");
            assert_eq!(to_text(&events), expected, "{name} on {engine:?}");
        }
    }
}
