//! The checker over data files: `tests/data/check/ok` must check, `tests/data/check/err` must not;
//! the checked program and the rendered diagnostics are snapshots beside them.

mod speed;
mod summary;

use lang::front::diag::Diags;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use std::path::{Path, PathBuf};

fn scripts(folder: &str) -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/check").join(folder);
    let entries = std::fs::read_dir(&root).unwrap();
    let mut files: Vec<_> = entries.map(|e| e.unwrap().path()).collect();
    files.retain(|f| f.extension().is_some_and(|e| e == "bas"));
    files.sort();
    assert!(!files.is_empty(), "no script in {}", root.display());
    files
}

/// What parts the scripts of one file.
const PART: &str = "' ---\n";

/// Checks every script of a folder and compares what comes out with its snapshot; gives their
/// number.
fn check(folder: &str, wrong: bool) -> usize {
    let mut count = 0;
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.set_snapshot_path(format!("../data/check/{folder}"));
    settings.bind(|| {
        for file in scripts(folder) {
            let stem = file.file_stem().unwrap().to_str().unwrap().to_owned();
            let text = std::fs::read_to_string(&file).unwrap();
            let mut shown = String::new();
            for part in text.split(PART) {
                count += 1;
                let source = Source::new(&format!("{stem}.bas"), part.to_owned());
                let (program, diags) = compile(&source, ProfileChoice::built_in());
                let diagnostics = diags.render(&source);
                assert_eq!(diags.has_errors(), wrong, "{part}:\n{diagnostics}");
                assert_eq!(program.is_none(), wrong, "{part}");
                if wrong {
                    shown.push_str(
                        &part.lines().map(|line| format!("| {line}\n")).collect::<String>(),
                    );
                    every_error_has_a_remedy(diags);
                }
                shown.extend(program.map(|p| summary::summary(&p)));
                shown.push_str(&diagnostics);
                shown.push('\n');
            }
            insta::assert_snapshot!(stem, shown);
        }
    });
    count
}

fn every_error_has_a_remedy(diags: Diags) {
    for diag in diags.into_sorted() {
        assert!(diag.hint.is_some(), "no remedy: {diag:?}");
    }
}

#[test]
fn good_scripts() {
    check("ok", false);
}

/// The examples are what people start from: nothing to be warned of.
#[test]
fn examples_check_clean() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let file = entry.unwrap().path();
        if file.extension().is_none_or(|e| e != "bas") {
            continue;
        }
        let source =
            Source::new(&file.display().to_string(), std::fs::read_to_string(&file).unwrap());
        let (program, diags) = compile(&source, ProfileChoice::built_in());
        assert!(program.is_some() && diags.errors() == 0, "{}", diags.render(&source));
        assert_eq!(diags.render(&source), "");
        count += 1;
    }
    assert!(count >= 16);
}

/// Warnings that would be wrong.
#[test]
fn nothing_is_said_about_these() {
    for text in [
        // Only the diagonal reaches the feed; no path uses it.
        "G1 X1 F6000\nG1 X1 Y1\n",
        "F99000\n",
        "G91 G1 X1 Y1 F[11314st/s]\n",
        // Off again; off later; an end that may come later, while one still writes.
        "IF IN(5) THEN SetOut 4, ON : SetOut 4, OFF : END\nWait 1s\n",
        "SetOut 4, ON\nWait 1s\nEND\n",
        "SetOut 4, ON\n",
    ] {
        let source = Source::new("a.bas", text.to_owned());
        let (_, diags) = compile(&source, ProfileChoice::built_in());
        assert_eq!(diags.render(&source), "", "{text}");
    }
}

/// An output that the profile leaves on at the end.
#[test]
fn what_the_end_keeps_is_no_slip() {
    use lang::profile::{Profile, SafeState};
    let told = |end| {
        let mut profile = Profile::built_in("mill").expect("built in");
        for output in profile.outputs.iter_mut().filter(|output| output.n == 1) {
            output.end = end;
        }
        let source = Source::new("a.bas", "SetOut 1, ON\nEND\n".to_owned());
        compile(&source, ProfileChoice::Given(Box::new(profile))).1.render(&source)
    };
    assert!(told(SafeState::Off).contains("M009"), "{}", told(SafeState::Off));
    assert_eq!(told(SafeState::Keep), "");
    assert_eq!(told(SafeState::On), "");
}

#[test]
fn wrong_scripts() {
    assert!(check("err", true) >= 60);
}
