//! Files of the script's folder: what may be opened and written, and programs of other systems that become
//! scripts.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::input;

/// Longest script that a page may send, bytes. Jobs that are larger than a board's memory are longer; up to
/// [`LARGEST`] pages show, simulate and stream them as they are.
pub const LONGEST: usize = 512 << 10;
/// Longest script that is opened, bytes.
pub const LARGEST: usize = 4 << 20;

/// The text of a file, and the script's file that it belongs to: a program of another system becomes a
/// new script beside it, whose name is free.
pub(super) fn opened(file: &Path) -> Result<(String, Option<PathBuf>), String> {
    let name = file.display().to_string();
    let bytes = input::read_bytes(&name, import::MAX_BYTES).map_err(|note| note.line())?;
    let foreign = import::is_importable(&name, &bytes);
    let own = if foreign { free(file) } else { file.to_owned() };
    Ok((text_of(&name, &bytes)?, Some(own)))
}

/// The script that a file holds or becomes.
pub(super) fn text_of(name: &str, bytes: &[u8]) -> Result<String, String> {
    let text = if import::is_importable(name, bytes) {
        let made = import::import(name, bytes, &import::Options::default());
        made.map(|made| made.script).map_err(|diags| {
            let errors = diags.iter().filter(|diag| diag.severity == import::Severity::Error);
            let told: Vec<String> =
                errors.take(3).map(|diag| format!("line {}: {}", diag.line, diag.text)).collect();
            format!("{name}: {}", told.join("; "))
        })?
    } else {
        decoded(name, bytes)?
    };
    if text.len() > LARGEST {
        return Err(format!(
            "{name} makes a script of {} bytes, the workbench takes {LARGEST}: `pasapas sim {name}` \
             shows it, `pasapas stream {name}` runs it",
            text.len()
        ));
    }
    Ok(text)
}

/// A script's name in the folder of a file that nothing has yet.
pub(super) fn free(file: &Path) -> PathBuf {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let plain = |c: char| if c.is_alphanumeric() || matches!(c, '_' | '-') { c } else { '_' };
    let stem: String = stem.chars().take(80).map(plain).collect();
    let names = (1..).map(|n| match n {
        1 => format!("{stem}.bas"),
        n => format!("{stem}_{n}.bas"),
    });
    let mut files = names.map(|name| file.with_file_name(name));
    files.find(|file| !file.exists()).unwrap_or_else(|| file.to_owned())
}

/// Whether this names a script that does not exist yet.
pub(super) fn is_new_script(name: &str) -> bool {
    let path = Path::new(name);
    let own = path.file_name().map(|own| own.to_string_lossy().into_owned());
    own.is_some_and(|own| is_script(&own)) && !path.exists() && folder(Some(path)).is_dir()
}

pub(super) fn read(file: &Path) -> Result<String, String> {
    let name = file.display().to_string();
    let bytes = input::read_bytes(&name, LARGEST).map_err(|note| note.line())?;
    decoded(&name, &bytes)
}

fn decoded(name: &str, bytes: &[u8]) -> Result<String, String> {
    let (source, wrong) = lang::front::source::Source::decode(name, bytes);
    match wrong.first() {
        Some(diag) if diag.is_error() => Err(format!("{name}: {}", diag.message)),
        _ => Ok(source.text().to_owned()),
    }
}

/// Replaces a file in one step, with the rights that it had; where it is a link, the file that it leads
/// to. What is written meanwhile has a name that nothing else has.
pub(super) fn write(file: &Path, text: &str) -> io::Result<()> {
    let file = fs::canonicalize(file).unwrap_or_else(|_| file.to_owned());
    let mut beside = beside_of(&file)?;
    beside.write_all(text.as_bytes())?;
    if let Ok(about) = fs::metadata(&file) {
        fs::set_permissions(beside.path(), about.permissions())?;
    }
    beside.persist(&file).map(drop).map_err(|error| error.error)
}

/// Writes a file that must not be there yet.
pub(super) fn write_new(file: &Path, text: &str) -> io::Result<()> {
    let mut beside = beside_of(file)?;
    beside.write_all(text.as_bytes())?;
    beside.persist_noclobber(file).map(drop).map_err(|error| error.error)
}

/// A file without a lasting name in the folder of another one, with the rights of any new file.
fn beside_of(file: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".pasapas-");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder(Some(file)))
}

pub(super) fn folder(file: Option<&Path>) -> PathBuf {
    match file.and_then(Path::parent) {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

fn is_script(name: &str) -> bool {
    is_plain(name) && Path::new(name).extension().is_some_and(|end| end.eq_ignore_ascii_case("bas"))
}

/// What a page may open: scripts, and what its ending says is a program of another system.
pub(super) fn is_listed(name: &str) -> bool {
    is_script(name) || is_plain(name) && import::is_importable(name, &[])
}

fn is_plain(name: &str) -> bool {
    let plain = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.' | ' ');
    name.len() <= 100 && !name.starts_with('.') && name.chars().all(plain)
}

/// A file of the folder that may be opened.
pub(super) fn listed(file: Option<&Path>, name: &str) -> Result<PathBuf, String> {
    if !is_listed(name) {
        return Err(format!("`{name}` is neither a script nor a program of another system"));
    }
    Ok(folder(file).join(name))
}

/// A script in the folder of this one, and nowhere else.
pub(super) fn beside(file: Option<&Path>, name: &str) -> Result<PathBuf, String> {
    if !is_script(name) {
        return Err(format!(
            "`{name}` is no name of a script: letters, digits and `.bas` at the end"
        ));
    }
    Ok(folder(file).join(name))
}
