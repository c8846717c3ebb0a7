//! host/cell.md

use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use pasapas::board::DEFAULT;
use pasapas::board::engine::run_native_traced;
use pasapas::scene;
use pasapas::scene::proof::Class;
use pasapas::scene::report::NEVER;
use pasapas::sim::Options;
use pasapas::sim::world::World;

const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../host/cell.md");

fn page() -> String {
    std::fs::read_to_string(PAGE).expect("the page")
}

#[test]
fn the_tables_are_those_of_the_keys() {
    let table = format!("\n{}\n", cell::keys::manual().trim());
    let table = table + "\n";
    let (begin, end) = ("<!-- keys: made by the test `manuals` -->\n", "<!-- end of keys -->\n");
    let page = page();
    let (before, rest) = page.split_once(begin).expect("its begin");
    let (shown, after) = rest.split_once(end).expect("its end");
    if std::env::var_os("UPDATE_README").is_some() {
        std::fs::write(PAGE, [before, begin, &table, end, after].concat()).expect("written");
        return;
    }
    assert_eq!(shown, table, "run UPDATE_README=1 cargo test -p tests --test manuals");
}

/// The text of the next block of this language, and what follows it.
fn block<'a>(text: &'a str, language: &str) -> (&'a str, &'a str) {
    let (_, rest) = text.split_once(&format!("```{language}\n")).expect("a block");
    rest.split_once("```\n").expect("its end")
}

#[test]
fn the_example_does_what_the_page_says() {
    let page = page();
    let (script, rest) = block(&page, "basic");
    let (cell_text, rest) = block(rest, "toml");
    let (said, _) = block(rest, "text");
    let source = Source::new("cell.md", script.to_owned());
    let (program, diags) = compile(&source, ProfileChoice::built_in());
    let program = program.unwrap_or_else(|| panic!("{}", diags.render(&source)));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("job.cell.toml");
    std::fs::write(&file, cell_text).unwrap();
    let read = scene::read(&file.display().to_string(), &program.profile, Some(&program));
    let (scene, notes) = read.unwrap();
    assert!(notes.is_empty(), "{notes:?}");
    let compiled = lang::back::compile(&program).unwrap();
    let world = World::unattended().with_scene(Some(scene));
    let run = run_native_traced(DEFAULT, &program, &compiled, &world, &Options::default()).unwrap();
    let table = run.0.outcome.cell.unwrap().table();
    assert!(table.starts_with(said), "{table}");
}

/// Whatever has a word in the code has it on the page.
#[test]
fn every_word_is_explained() {
    let page = page();
    for class in Class::ALL {
        assert!(page.contains(&format!("| `{}` |", class.word())), "{}", class.word());
    }
    assert!(page.contains(&format!("Never modelled: {NEVER}.")));
    // What the page says that strikes nobody yet is told.
    let text = "cell = 1\nvary = [{ fault = \"power\", chance = 1 }]\n";
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("job.cell.toml");
    std::fs::write(&file, text).unwrap();
    let mill = lang::profile::Profile::built_in("mill").unwrap();
    let (_, notes) = scene::read(&file.display().to_string(), &mill, None).unwrap();
    assert!(notes.iter().any(|note| note.code == "C016"), "{notes:?}");
}
