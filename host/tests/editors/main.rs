//! What is shipped for editors: the grammar, the extension and its package, the lines of the page
//! `host/editors.md`.
//!
//! `UPDATE_EDITORS=1 cargo test -p pasapas --test editors` rewrites what is made from the tables.

mod grammar;
mod helix;
mod neovim;
mod package;

use std::path::{Path, PathBuf};
use std::process::Command;

/// A file of the host's folder.
fn host(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// A file of the host's folder as text.
fn text(path: &str) -> String {
    std::fs::read_to_string(host(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The first block of that language on the page for editors.
fn block(language: &str) -> String {
    let page = text("editors.md");
    let behind = page.split_once(&format!("```{language}\n")).expect("a block").1;
    behind.split_once("```").expect("its end").0.to_owned()
}

/// Whether a program is there; tests that want it say so where it is not.
fn there(program: &str) -> bool {
    let found = Command::new(program).arg("--version").output().is_ok();
    if !found {
        eprintln!("{program} does not run here: it is left out");
    }
    found
}
