//! Settings that Grbl keeps without power, in a file: G54 to G59, G28, G30, `$10`, `$13`.

use std::io::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::modal::{Offsets, Point};

/// Lengths in mm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Kept {
    /// G54 to G59.
    pub wcs: [Point; 6],
    /// G28's place.
    pub g28: Point,
    /// G30's place.
    pub g30: Point,
    /// `$10`
    pub report: u8,
    /// `$13`
    pub inches: bool,
}

impl Default for Kept {
    fn default() -> Kept {
        Kept { wcs: [[0.0; 3]; 6], g28: [0.0; 3], g30: [0.0; 3], report: 1, inches: false }
    }
}

impl Kept {
    /// Takes over what is kept of offsets; whether that is another.
    pub fn note(&mut self, offsets: &Offsets) -> bool {
        let new = (offsets.wcs, offsets.g28, offsets.g30);
        let other = new != (self.wcs, self.g28, self.g30);
        (self.wcs, self.g28, self.g30) = new;
        other
    }

    /// The offsets after power-up.
    pub fn offsets(&self) -> Offsets {
        Offsets { wcs: self.wcs, g28: self.g28, g30: self.g30, ..Offsets::default() }
    }

    /// Reads the file; what is not there yet is as when new.
    ///
    /// # Errors
    /// It cannot be read or is none; in words.
    pub fn read(path: &Path) -> Result<Kept, String> {
        let words = |error: &dyn std::fmt::Display| {
            format!("{}: {error}; remove it to begin with offsets of 0", path.display())
        };
        match std::fs::read_to_string(path) {
            Ok(text) => {
                let kept: Kept = serde_json::from_str(&text).map_err(|error| words(&error))?;
                let places = kept.wcs.iter().chain([&kept.g28, &kept.g30]).flatten();
                if places.into_iter().any(|value| value.is_nan() || value.abs() > 1e6) {
                    return Err(words(&"an offset is out of range"));
                }
                Ok(kept)
            }
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Kept::default()),
            Err(error) => Err(words(&error)),
        }
    }
}

/// The file, written whole each time.
pub struct KeepFile {
    path: Option<PathBuf>,
}

impl KeepFile {
    /// At a path, or nowhere.
    pub fn new(path: Option<PathBuf>) -> KeepFile {
        KeepFile { path }
    }

    /// Writes it beside the old one, then puts it in its place: a cut power leaves one of the two.
    ///
    /// # Errors
    /// It cannot be written; in words.
    pub fn write(&self, kept: &Kept) -> Result<(), String> {
        let Some(path) = &self.path else { return Ok(()) };
        let words =
            |error: std::io::Error| format!("{} cannot be written: {error}", path.display());
        let text = serde_json::to_string_pretty(kept).map_err(|error| error.to_string())?;
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let folder = folder.unwrap_or(Path::new("."));
        let mut file = tempfile::NamedTempFile::new_in(folder).map_err(words)?;
        file.write_all(text.as_bytes()).map_err(words)?;
        file.as_file().sync_all().map_err(words)?;
        file.persist(path).map_err(|error| words(error.error))?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{KeepFile, Kept};

    #[test]
    fn offsets_survive_and_a_damaged_file_is_told() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("offsets.json");
        let mut kept = Kept::read(&path).expect("none yet");
        let mut offsets = kept.offsets();
        offsets.wcs[2] = [1.0, -2.0, 3.5];
        assert!(kept.note(&offsets) && !kept.note(&offsets));
        KeepFile::new(Some(path.clone())).write(&kept).expect("written");
        assert_eq!(Kept::read(&path), Ok(kept));
        std::fs::write(&path, "{\"wcs\": 3}").expect("written");
        assert!(Kept::read(&path).expect_err("damaged").contains("remove it"));
    }
}
