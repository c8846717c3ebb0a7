//! The checker over data files: `tests/data/check/ok` must check, `tests/data/check/err` must not;
//! the checked program and the rendered diagnostics are snapshots beside them.

mod speed;
mod summary;

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

/// Checks every script of a folder and compares what comes out with its snapshot.
fn check(folder: &str, wrong: bool) {
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.set_snapshot_path(format!("../data/check/{folder}"));
    settings.bind(|| {
        for file in scripts(folder) {
            let stem = file.file_stem().unwrap().to_str().unwrap().to_owned();
            let text = std::fs::read_to_string(&file).unwrap();
            let source = Source::new(&format!("{stem}.bas"), text);
            let (program, diags) = compile(&source, ProfileChoice::built_in());
            let diagnostics = diags.render(&source);
            assert_eq!(diags.has_errors(), wrong, "{stem}:\n{diagnostics}");
            assert_eq!(program.is_none(), wrong, "{stem}");
            let program = program.map(|p| summary::summary(&p)).unwrap_or_default();
            insta::assert_snapshot!(stem, format!("{program}{diagnostics}"));
        }
    });
}

#[test]
fn good_scripts() {
    check("ok", false);
}

#[test]
fn wrong_scripts() {
    check("err", true);
}
