//! What the repository says of itself: files that comments and documents name exist, `unsafe` stands
//! only where ARCHITECTURE.md says, no file of the sources is long, modules have one style, crates know none
//! that they must not.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().expect("the repository")
}

/// Every file below a folder, without what a build makes.
fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("readable") {
        let path = entry.expect("readable").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        if path.is_dir() {
            if !matches!(name.as_str(), "target" | ".git" | "node_modules") {
                files(&path, found);
            }
        } else {
            found.push(path);
        }
    }
}

/// The sources and documents, by their paths from the root.
fn texts() -> (BTreeSet<String>, Vec<(String, String)>) {
    let root = root();
    let mut found = Vec::new();
    files(&root, &mut found);
    let name = |path: &PathBuf| {
        path.strip_prefix(&root).expect("below").to_string_lossy().replace('\\', "/")
    };
    let names = found.iter().map(name).collect();
    let read = found.iter().filter(|path| {
        let kind = path.extension().and_then(|kind| kind.to_str());
        matches!(kind, Some("rs" | "s" | "md" | "toml" | "sh"))
    });
    let texts = read.filter_map(|path| Some((name(path), fs::read_to_string(path).ok()?)));
    let texts = texts.collect::<Vec<_>>();
    (names, texts)
}

/// Names of documents and sources in a line: all of it in a document, otherwise its comment.
fn cited<'a>(file: &str, line: &'a str) -> Vec<&'a str> {
    let said = if file.ends_with(".md") {
        line
    } else {
        let begins = ["//", "/*", "#"].iter().filter_map(|sign| line.find(sign)).min();
        begins.map_or("", |at| &line[at..])
    };
    let word = |c: char| !(c.is_ascii_alphanumeric() || "._-/".contains(c));
    let names = said.split(word).map(|name| name.trim_end_matches(['.', '/']));
    names
        .filter(|name| {
            let stem = [".md", ".rs", ".s"].iter().find_map(|end| name.strip_suffix(end));
            stem.is_some_and(|stem| stem.ends_with(|c: char| c.is_ascii_alphanumeric()))
        })
        .collect()
}

#[test]
fn files_that_comments_and_documents_name_exist() {
    let (names, texts) = texts();
    assert!(texts.len() > 400, "only {} files were read", texts.len());
    let exists = |cited: &str| {
        let cited = cited.trim_start_matches("./").trim_start_matches("../");
        names.iter().any(|name| name == cited || name.ends_with(&format!("/{cited}")))
    };
    let mut missing = Vec::new();
    let mut count = 0;
    for (file, text) in &texts {
        for (n, line) in text.lines().enumerate() {
            for name in cited(file, line) {
                count += 1;
                // `//docs.rs` is a site.
                if !name.starts_with("//") && !exists(name) {
                    missing.push(format!("{file}:{}: {name}", n + 1));
                }
            }
        }
    }
    assert!(count > 50, "only {count} names were found");
    assert!(missing.is_empty(), "no such file:\n{}", missing.join("\n"));
    let line = ["x /", "/ see nonesuch.md, and b.rs."].concat();
    assert_eq!(cited("a.rs", &line), ["nonesuch.md", "b.rs"]);
    assert!(!exists("nonesuch.md"));
}

#[test]
fn unsafe_stands_only_where_the_architecture_says() {
    let allowed = [
        "firmware/f5529/",
        "firmware/shared/",
        "firmware/g2553/",
        "firmware/src/motion/scaled.rs",
        "firmware/src/motion/math.rs",
        "firmware/src/machine/init.rs",
        "firmware/src/machine/motor.rs",
        "firmware/src/machine/controller/program.rs",
        "host/web/src/lib.rs",
    ];
    let (_, texts) = texts();
    let mut inside = 0;
    let mut outside = Vec::new();
    for (file, text) in texts.iter().filter(|(file, _)| file.ends_with(".rs")) {
        for (n, line) in text.lines().enumerate() {
            let code = line.split("//").next().unwrap_or_default();
            let mut words = code.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
            let text = code.contains('"') || code.contains('\'');
            if !words.any(|word| word == "unsafe") || text {
                continue;
            }
            if allowed.iter().any(|place| file.starts_with(place)) {
                inside += 1;
            } else {
                outside.push(format!("{file}:{}: {}", n + 1, line.trim()));
            }
        }
    }
    assert!(inside > 50, "only {inside} were found");
    // Told in the last of three rows of the code map, of all.
    let page =
        texts.iter().find(|(file, _)| file == "ARCHITECTURE.md").map(|(_, text)| text.as_str());
    let lines = page.unwrap_or_default().lines().collect::<Vec<_>>();
    let told = lines.windows(3).find(|rows| rows[2].contains("All `unsafe`")).map(<[&str]>::concat);
    for place in allowed {
        let name = place.trim_start_matches("firmware/src/motion/");
        let name = name.trim_start_matches("firmware/src/machine/").trim_end_matches('/');
        let told = told.as_ref().is_some_and(|told| told.contains(name));
        assert!(told, "ARCHITECTURE.md does not say that unsafe stands in {place}");
    }
    assert!(outside.is_empty(), "unsafe outside of {allowed:?}:\n{}", outside.join("\n"));
}

/// The number in the value that a line of assembly gives a symbol by `.set`; places a number away from here are none.
fn typed_number(line: &str) -> Option<&str> {
    let (name, value) = line.trim().strip_prefix(".set ")?.split_once(',')?;
    let value = value.split("/*").next()?.trim();
    // Names of a macro's arguments, and a counter of one.
    if name.contains('\\') || value.starts_with('.') {
        return None;
    }
    let words = value.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
    words.into_iter().find(|word| word.starts_with(|c: char| c.is_ascii_digit()))
}

#[test]
fn numbers_of_the_assembly_are_made_of_rust() {
    assert_eq!(typed_number("    .set MASK, 10 /* of a slot */"), Some("10"));
    assert_eq!(typed_number("    .set SPEED, COMMAND+2*6"), Some("2"));
    assert_eq!(typed_number("    .set SPARE, V2"), None);
    let (_, texts) = texts();
    let mut wrong = Vec::new();
    let mut aliases = 0;
    for (file, text) in texts.iter().filter(|(file, _)| file.ends_with(".s")) {
        for (n, line) in text.lines().enumerate() {
            aliases += usize::from(line.trim().starts_with(".set "));
            if typed_number(line).is_some() {
                wrong.push(format!("{file}:{}: {}", n + 1, line.trim()));
            }
        }
    }
    assert!(aliases > 5, "only {aliases} symbols were found");
    assert!(wrong.is_empty(), "`constants!` is where symbols get numbers:\n{}", wrong.join("\n"));
}

/// Longest source file, lines.
const LONGEST: usize = 500;

#[test]
fn no_source_file_is_long() {
    let (_, texts) = texts();
    let mut wrong = Vec::new();
    let sources = texts.iter().filter(|(file, _)| file.ends_with(".rs") || file.ends_with(".s"));
    for (file, text) in sources {
        let lines = text.lines().count();
        if lines > LONGEST {
            wrong.push(format!("{file} has {lines} lines"));
        }
    }
    assert!(wrong.is_empty(), "at most {LONGEST} lines a file:\n{}", wrong.join("\n"));
}

#[test]
fn a_modules_file_stands_beside_its_folder() {
    let (names, _) = texts();
    // Beside the tests of a crate it would be one of them.
    let shared = [
        "firmware/tests/rig/mod.rs",
        "firmware/tests/slot/mod.rs",
        "host/cell/tests/machine/mod.rs",
        "host/tests/common/mod.rs",
        "tests/tests/engine/mod.rs",
    ];
    assert!(shared.iter().all(|file| names.contains(*file)));
    let inside = |name: &&String| name.ends_with("/mod.rs") && !shared.contains(&name.as_str());
    let wrong: Vec<&String> = names.iter().filter(inside).collect();
    assert!(wrong.is_empty(), "a/b.rs, not a/b/mod.rs: {wrong:?}");
}

/// Which of our crates a crate may build on: nothing up, and nothing across.
const BOUNDARIES: [(&str, &[&str]); 12] = [
    ("lang", &[]),
    ("firmware", &["lang", "micro"]),
    ("firmware/far", &[]),
    ("firmware/micro", &[]),
    ("firmware/lower", &["micro"]),
    ("host/cell", &[]),
    ("host/emulator", &[]),
    ("host/desk", &["lang", "firmware", "emulator"]),
    ("host/import", &["lang"]),
    ("host/shop", &["lang", "cell"]),
    ("host", &["lang", "firmware", "cell", "desk", "emulator", "import", "shop"]),
    ("host/web", &["lang", "import", "pasapas"]),
];

/// The crates of `ours` that a manifest names, but for what its tests want.
fn builds_on(manifest: &toml::Table, ours: &BTreeSet<String>) -> BTreeSet<String> {
    let targets = manifest.get("target").and_then(|target| target.as_table());
    let targets = targets.into_iter().flat_map(|targets| targets.values());
    let tables = targets.filter_map(|target| target.as_table()).chain([manifest]);
    let mut found = BTreeSet::new();
    for table in tables {
        for kind in ["dependencies", "build-dependencies"] {
            let named = table.get(kind).and_then(|named| named.as_table());
            found.extend(named.into_iter().flat_map(|named| named.keys().cloned()));
        }
    }
    found.retain(|name| ours.contains(name));
    found
}

#[test]
fn a_crate_builds_on_none_that_it_must_not_know() {
    let (_, texts) = texts();
    let read = |folder: &str| -> toml::Table {
        let path = format!("{folder}/Cargo.toml");
        let text = texts.iter().find(|(name, _)| *name == path).map(|(_, text)| text.as_str());
        text.unwrap_or_else(|| panic!("no {path}")).parse().expect("a manifest")
    };
    let name = |manifest: &toml::Table| manifest["package"]["name"].as_str().unwrap().to_owned();
    let crates = BOUNDARIES.map(|(folder, allowed)| (read(folder), allowed));
    let ours = crates.iter().map(|(manifest, _)| name(manifest)).collect::<BTreeSet<_>>();
    for (manifest, allowed) in &crates {
        let found = builds_on(manifest, &ours);
        let allowed = allowed.iter().map(|&name| name.to_owned()).collect::<BTreeSet<_>>();
        assert!(found.is_subset(&allowed), "{} builds on {found:?}", name(manifest));
    }
    let wrong = "[target.'cfg(unix)'.dependencies]\nlang = \"1\"\nsyn = \"2\"".parse().unwrap();
    assert_eq!(builds_on(&wrong, &ours), BTreeSet::from(["lang".to_owned()]));
}

/// Names that a file gives the assembler as constants: `.set NAME, ` and rows of `constants!`.
fn set(file: &str, text: &str) -> Vec<String> {
    let named = |name: &str| name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    let mut inside = false;
    let mut names = Vec::new();
    for line in text.lines() {
        inside = (inside || line.starts_with("constants! {")) && line != "}";
        let name = if file.ends_with(".s") {
            line.trim_start().strip_prefix(".set ").and_then(|row| Some(row.split_once(',')?.0))
        } else if inside {
            line.split_once(" = ").map(|(name, _)| name.trim())
        } else {
            None
        };
        names.extend(name.filter(|name| named(name)).map(str::to_owned));
    }
    names
}

#[test]
fn a_constant_of_the_assembler_is_set_in_one_place() {
    let (_, texts) = texts();
    let mut places = std::collections::BTreeMap::<String, Vec<&str>>::new();
    for (file, text) in texts.iter().filter(|(file, _)| file.starts_with("firmware/g2553/")) {
        for name in set(file, text) {
            places.entry(name).or_default().push(file);
        }
    }
    assert!(places.len() > 300, "only {} were found", places.len());
    places.retain(|_, files| files.len() > 1);
    assert!(places.is_empty(), "set twice: {places:?}");
    assert_eq!(set("a.s", "    .set P1IN, 0x20\n"), ["P1IN"]);
    assert_eq!(set("a.rs", "constants! {\n    P1IN = 0x20;\n}\n    NO = 1;\n"), ["P1IN"]);
}

/// Words that comments and manuals have given up; CONTRIBUTING.md says what to write instead.
const OLD_WORDS: [&str; 9] =
    ["asker", "askers", "feel", "feels", "left away", "likewise", "mend", "mends", "mended"];
/// The same for the heads of modules, where an actor must have a name.
const OLD_IN_HEADS: [&str; 4] = ["somebody", "nobody", "whoever", "told"];

/// What a line says to a reader: all of a document's, otherwise its comment; neither has the code in it.
fn said(file: &str, line: &str) -> String {
    let said = match (file.ends_with(".md"), line.find("//"), line.find("/*")) {
        (true, ..) => line,
        (false, None, None) => "",
        (false, one, other) => &line[one.into_iter().chain(other).min().unwrap_or_default()..],
    };
    let prose = said.split('`').step_by(2).collect::<Vec<_>>().join(" ").to_lowercase();
    let words = prose.split(|c: char| !c.is_alphanumeric() && c != '_' && c != '.');
    let words = words.map(|word| word.trim_matches('.')).filter(|word| !word.is_empty());
    format!(" {} ", words.collect::<Vec<_>>().join(" "))
}

#[test]
fn comments_and_manuals_use_the_words_of_the_list() {
    let (_, texts) = texts();
    let page = texts.iter().find(|(file, _)| file == "CONTRIBUTING.md").map(|(_, text)| text);
    let page = page.expect("the list of words");
    for word in ["asker", "feel", "left away", "likewise", "mend"] {
        assert!(page.contains(&format!("**{word}**")), "CONTRIBUTING.md does not list `{word}`");
    }
    let mut wrong = Vec::new();
    let read = |file: &str| {
        [".rs", ".s", ".md"].iter().any(|end| file.ends_with(end)) && file != "CONTRIBUTING.md"
    };
    for (file, text) in texts.iter().filter(|(file, _)| read(file)) {
        for (n, line) in text.lines().enumerate() {
            let said = said(file, line);
            let head = line.starts_with("//!");
            let old = OLD_WORDS.iter().chain(OLD_IN_HEADS.iter().filter(|_| head));
            for word in old.filter(|word| said.contains(&format!(" {word} "))) {
                wrong.push(format!("{file}:{}: {word}", n + 1));
            }
        }
    }
    assert!(wrong.is_empty(), "CONTRIBUTING.md has a better word:\n{}", wrong.join("\n"));
    let line = ["let told = 1; /", "/ What it feels, `mend` apart."].concat();
    assert_eq!(said("a.rs", &line), " what it feels apart ");
}
