//! The front end over data files: `tests/data/STAGE/ok` must pass, `tests/data/STAGE/err` must
//! not; tokens, trees and rendered diagnostics are snapshots beside them.

use lang::front::diag::Diags;
use lang::front::lexer::lex;
use lang::front::parser::parse;
use lang::front::source::Source;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// The scripts of one folder under `tests/data`, sorted.
pub fn scripts(folder: &str) -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(folder);
    let entries = std::fs::read_dir(&root).unwrap();
    let mut files: Vec<_> = entries.map(|e| e.unwrap().path()).collect();
    files.retain(|f| f.extension().is_some_and(|e| e == "bas"));
    files.sort();
    assert!(!files.is_empty(), "no script in {}", root.display());
    files
}

/// Runs a stage over a folder and compares what it shows with the snapshots.
fn check(folder: &str, wrong: bool, stage: fn(&Source, &mut Diags) -> String) {
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.set_snapshot_path(format!("../data/{folder}"));
    settings.bind(|| {
        for file in scripts(folder) {
            let stem = file.file_stem().unwrap().to_str().unwrap().to_owned();
            let bytes = std::fs::read(&file).unwrap();
            let (source, decoding) = Source::decode(&format!("{stem}.bas"), &bytes);
            let mut diags = Diags::new();
            decoding.into_iter().for_each(|d| diags.push(d));
            let shown = stage(&source, &mut diags);
            assert_eq!(diags.has_errors(), wrong, "{stem}:\n{}", diags.render(&source));
            let shown = if wrong { diags.render(&source) } else { shown };
            insta::assert_snapshot!(stem, shown);
        }
    });
}

fn tokens(source: &Source, diags: &mut Diags) -> String {
    let mut out = String::new();
    for token in lex(source.text(), diags) {
        let _ = writeln!(out, "{} {:?} {:?}", token.line, token.tok, token.span.of(source.text()));
    }
    out
}

fn tree(source: &Source, diags: &mut Diags) -> String {
    format!("{:#?}", parse(source.text(), diags))
}

#[test]
fn good_tokens() {
    check("lex/ok", false, tokens);
}

#[test]
fn wrong_tokens() {
    check("lex/err", true, tokens);
}

#[test]
fn good_trees() {
    check("parse/ok", false, tree);
}

#[test]
fn wrong_statements() {
    check("parse/err", true, tree);
}
