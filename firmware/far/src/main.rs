//! Stands in the linker's place when an image for an MSP430X is linked: makes the functions of each
//! object file [`far`], then calls the linker with the arguments that it was given.
//!
//! `FAR_LD` is the linker, `FAR_NEAR` a file with the functions that stay below 64 KB, one a line.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use far::{Near, rewrite};

fn main() -> ExitCode {
    match link() {
        Ok(code) => code,
        Err(error) => {
            eprintln!("far: {error}");
            ExitCode::FAILURE
        }
    }
}

fn link() -> Result<ExitCode, String> {
    let linker = std::env::var_os("FAR_LD").ok_or("FAR_LD does not name the linker")?;
    let near = match std::env::var_os("FAR_NEAR") {
        Some(path) => Near::parse(&text(&PathBuf::from(path))?),
        None => Near::default(),
    };
    let arguments: Vec<OsString> = std::env::args_os().skip(1).collect();
    for path in arguments.iter().map(Path::new) {
        if path.extension().is_some_and(|kind| kind == "o") {
            let said = |error: String| format!("{}: {error}", path.display());
            let before = std::fs::read(path).map_err(|error| said(error.to_string()))?;
            let after = rewrite(&before, &near).map_err(said)?;
            std::fs::write(path, after).map_err(|error| said(error.to_string()))?;
        }
    }
    let status = Command::new(&linker).args(&arguments).status();
    let status = status.map_err(|error| format!("{}: {error}", linker.to_string_lossy()))?;
    Ok(if status.success() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn text(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}
