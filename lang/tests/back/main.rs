//! The back end and the VM: listings and runs of data files, hostile images.

mod courses;
mod hostile;
mod limits;
mod listing;
mod run;
mod table;

use lang::back::Compiled;
use lang::front::source::Source;
use lang::front::{self, ProfileChoice};
use lang::image::{self, Image};
use lang::verify::{Limits, verify};
use std::path::{Path, PathBuf};

/// The scripts of a folder of `tests/data`.
fn scripts(folder: &str) -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(folder);
    let entries = std::fs::read_dir(&root).unwrap();
    let mut files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "bas"));
    files.sort();
    assert!(!files.is_empty(), "no script in {}", root.display());
    files
}

/// Compiles a script that must compile; its image passes the check that the device makes.
fn compile(text: &str) -> Compiled {
    compile_for(text, ProfileChoice::built_in())
}

fn compile_for(text: &str, profile: ProfileChoice<'_>) -> Compiled {
    let source = Source::new("test.bas", text.to_owned());
    let (program, diags) = front::compile(&source, profile);
    let program = program.unwrap_or_else(|| panic!("{text}\n{}", diags.render(&source)));
    let compiled = lang::back::compile(&program).unwrap_or_else(|e| panic!("{text}\n{e:?}"));
    check(&compiled.image).unwrap_or_else(|flaw| panic!("{text}\n{flaw:?}"));
    compiled
}

/// The check of an image, as the device makes it.
fn check(bytes: &[u8]) -> Result<Image<'_>, image::Flaw> {
    let image = Image::new(bytes)?;
    if image::crc_in(bytes) != image::crc_of(bytes) {
        return Err(image::Flaw::Crc);
    }
    verify(&image, &Limits::host(image.header.features), &mut [0; 24])?;
    Ok(image)
}
