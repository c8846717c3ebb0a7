//! Reading what the user names: files of bounded size, scripts, profiles.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use lang::profile::{Profile, ProfileError};

use crate::render::Note;

/// Longest profile, scenario or image that is read.
const MAX_BYTES: usize = 16 << 20;

/// Codes of what is wrong with an input before it is a script.
pub mod code {
    /// A file cannot be read.
    pub const UNREADABLE: &str = "I001";
    /// A file is too large.
    pub const TOO_LARGE: &str = "I002";
    /// A profile is wrong.
    pub const PROFILE: &str = "I003";
    /// An engine does not take the program.
    pub const ENGINE: &str = "I004";
    /// A program image is wrong.
    pub const IMAGE: &str = "I005";
    /// A gateway's file is wrong.
    pub const GATEWAY: &str = "I006";
}

/// Reads a file of at most `limit` bytes, `-` being standard input. One byte more than that is read
/// at most, so a device that never ends does no harm.
///
/// # Errors
/// The note says why it cannot be read.
pub fn read_bytes(name: &str, limit: usize) -> Result<Vec<u8>, Box<Note>> {
    let mut bytes = Vec::new();
    let result = if name == "-" {
        io::stdin().lock().take(limit as u64 + 1).read_to_end(&mut bytes)
    } else {
        File::open(name).and_then(|file| file.take(limit as u64 + 1).read_to_end(&mut bytes))
    };
    match result {
        Ok(count) if count > limit => {
            let text = format!("the file has more than {limit} bytes");
            let hint = "is it the right file? a long job is split, or run by `pasapas stream`";
            Err(Note::error(name, code::TOO_LARGE, text).hint(hint).into())
        }
        Ok(_) => Ok(bytes),
        Err(error) => {
            let text = format!("the file cannot be read: {error}");
            Err(Note::error(name, code::UNREADABLE, text).into())
        }
    }
}

/// Reads a UTF-8 text.
///
/// # Errors
/// The note says why it cannot be read, or where it is no UTF-8.
pub fn read_text(name: &str) -> Result<String, Box<Note>> {
    let bytes = read_bytes(name, MAX_BYTES)?;
    String::from_utf8(bytes).map_err(|error| {
        let good = error.utf8_error().valid_up_to();
        let text = String::from_utf8_lossy(&error.as_bytes()[..good]).into_owned();
        Note::error(name, code::UNREADABLE, "the file is not UTF-8 text".to_owned())
            .at(place(&text, text.len()))
            .into()
    })
}

/// The profile that `--profile` names: a TOML file when it looks like a path, else a built-in one.
///
/// # Errors
/// The note says what is wrong, and where in the file.
pub fn profile(name: &str) -> Result<Profile, Box<Note>> {
    if !is_path(name) {
        return Profile::built_in(name).map_err(|ProfileError(text)| {
            Note::error("--profile", code::PROFILE, format!("{text}; a file's name ends in .toml"))
                .into()
        });
    }
    let text = read_text(name)?;
    Profile::parse(&text).map_err(|error| wrong_profile(name, &text, &error).into())
}

/// The profile of a PROFILE line: a built-in one, or NAME.toml beside the script, whose path comes
/// with it then.
///
/// # Errors
/// There is none of that name, or the file is wrong.
pub fn profile_beside(
    name: &str,
    script: &str,
) -> Result<(Profile, Option<PathBuf>), ProfileError> {
    let built_in = Profile::built_in(name).map(|profile| (profile, None));
    let plain = name.chars().all(|c| c.is_alphanumeric() || c == '_' || c == '-');
    if built_in.is_ok() || !plain {
        return built_in;
    }
    let beside = Path::new(script).with_file_name(format!("{name}.toml"));
    if !beside.is_file() {
        return built_in;
    }
    let path = beside.display().to_string();
    let text = read_text(&path).map_err(|note| ProfileError(note.line()))?;
    let profile =
        Profile::parse(&text).map_err(|error| ProfileError(format!("{path}: {error}")))?;
    Ok((profile, Some(beside)))
}

/// Whether a profile's name is one of a file.
fn is_path(name: &str) -> bool {
    name.ends_with(".toml") || name.contains(['/', '\\']) || Path::new(name).is_file()
}

/// Finds the place of what [`Profile::parse`] did not like.
fn wrong_profile(name: &str, text: &str, error: &ProfileError) -> Note {
    match toml::from_str::<Profile>(text) {
        Err(error) => {
            let at = error.span().map_or(0, |span| span.start);
            let (words, hint) = ::cell::problem::of_toml(&error);
            Note::error(name, code::PROFILE, words).at(place(text, at)).hint(hint)
        }
        Ok(_) => Note::error(name, code::PROFILE, error.0.clone())
            .at(place(text, offset_of_field(text, &error.0))),
    }
}

/// Where the field stands that an error text begins with, such as `x.top_rate is 0; ...`; 0 if it
/// cannot be found.
fn offset_of_field(text: &str, error: &str) -> usize {
    let path = error.split_whitespace().next().unwrap_or_default();
    let (section, field) = match path.split_once('.') {
        Some((section @ ("x" | "y" | "z"), field)) => (format!("[{section}]"), field),
        Some(("link", field)) => ("[link]".to_owned(), field),
        _ => (String::new(), path),
    };
    let from = text.find(&section).unwrap_or(0);
    let last = field.rsplit('.').next().unwrap_or(field);
    text[from..].find(last).map_or(from, |at| from + at)
}

/// Line and column of a byte offset, both from 1.
pub fn place(text: &str, offset: usize) -> (u32, u32) {
    let before = text.get(..offset).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
    (line as u32, column as u32)
}

#[cfg(test)]
mod tests {
    use super::{place, profile, read_bytes};
    use std::io::Write;

    fn file(text: &str) -> (tempfile::TempDir, String) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("p.toml");
        std::fs::File::create(&path)
            .and_then(|mut file| file.write_all(text.as_bytes()))
            .expect("a file");
        let name = path.display().to_string();
        (folder, name)
    }

    #[test]
    fn an_endless_device_is_refused_after_its_limit() {
        let note = read_bytes("/dev/zero", 1000).unwrap_err();
        assert!(note.text.contains("more than 1000 bytes"), "{}", note.text);
    }

    #[test]
    fn a_wrong_profile_is_shown_where_it_is_wrong() {
        let mill = lang::profile::BUILT_IN[0].1;
        let (_folder, name) = file(&mill.replacen("top_rate = 8000", "top_rate = 800000", 1));
        let note = profile(&name).unwrap_err();
        let line = mill.lines().position(|line| line.starts_with("top_rate")).expect("a line");
        assert_eq!((note.place.0 as usize, note.place.1), (line + 1, 1));
        let (_folder, name) = file(&mill.replacen("wiring = \"chain\"", "wiring = \"chian\"", 1));
        let note = profile(&name).unwrap_err();
        assert_eq!(note.place, (4, 10));
    }

    #[test]
    fn places_count_from_one_in_characters() {
        assert_eq!(place("aé\nbc", 0), (1, 1));
        assert_eq!(place("aé\nbc", 3), (1, 3));
        assert_eq!(place("aé\nbc", 5), (2, 2));
    }
}
