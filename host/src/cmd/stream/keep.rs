//! KEEP values of a streamed job, in a file with the job's name: the board's own belong to its stored program.

use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use lang::hir::{Program, Storage};

use crate::output;

/// At most one write in this time, as on the board.
const REST: Duration = Duration::from_secs(1);

/// See the module.
#[derive(Debug)]
pub(super) struct KeepFile {
    /// None where the job has no KEEP, or no place for a file.
    path: Option<PathBuf>,
    names: Vec<String>,
    values: Vec<i32>,
    /// Not written yet.
    changed: bool,
    written: Option<Instant>,
}

impl KeepFile {
    /// Reads the values of the run before: `FILE.keep`, a line `name = value` for each KEEP. With
    /// other KEEPs than the program's, or another order, all begin at 0.
    pub(super) fn open(file: &str, program: &Program) -> KeepFile {
        let mut names: Vec<(u8, String)> = program
            .vars
            .iter()
            .filter_map(|var| match var.storage {
                Storage::Keep(index) => Some((index, var)),
                _ => None,
            })
            .flat_map(|(first, var)| {
                (0..var.len as u8).map(move |n| match var.array {
                    true => (first + n, format!("{}({n})", var.name)),
                    false => (first, var.name.clone()),
                })
            })
            .collect();
        names.sort();
        let names: Vec<String> = names.into_iter().map(|(_, name)| name).collect();
        let mut keeps = KeepFile {
            path: None,
            values: vec![0; names.len()],
            names,
            changed: false,
            written: None,
        };
        if keeps.names.is_empty() || file == "-" {
            return keeps;
        }
        let path = PathBuf::from(format!("{file}.keep"));
        if let Some(values) = fs::read_to_string(&path).ok().and_then(|text| keeps.read(&text)) {
            keeps.values = values;
        }
        keeps.path = Some(path);
        keeps
    }

    fn read(&self, text: &str) -> Option<Vec<i32>> {
        let mut lines = text.lines();
        let values: Option<Vec<i32>> = self
            .names
            .iter()
            .map(|name| {
                let (known, value) = lines.next()?.split_once('=')?;
                (known.trim() == name).then(|| value.trim().parse().ok())?
            })
            .collect();
        values.filter(|_| lines.next().is_none())
    }

    /// Where the values are, for the user; `None` where the job has no KEEP.
    pub(super) fn told(&self) -> Option<String> {
        match &self.path {
            _ if self.names.is_empty() => None,
            None => Some(
                "KEEP begins at 0 and is lost: a job from standard input has no file".to_owned(),
            ),
            Some(path) => Some(format!(
                "KEEP values of a streamed job are in {}, not on the board",
                path.display()
            )),
        }
    }

    /// The values that a run begins with.
    pub(super) fn values(&self) -> &[i32] {
        &self.values
    }

    /// Notes the values; they are written at most once a second.
    pub(super) fn note(&mut self, values: &[i32]) {
        if self.values != values {
            self.values = values.to_vec();
            self.changed = true;
        }
        if self.written.is_none_or(|at| at.elapsed() >= REST) {
            self.write();
        }
    }

    /// Writes what has changed, whole or not at all.
    pub(super) fn write(&mut self) {
        let Some(path) = self.path.as_ref().filter(|_| self.changed) else { return };
        let lines = self.names.iter().zip(&self.values);
        let text: String = lines.map(|(name, value)| format!("{name} = {value}\n")).collect();
        // A folder that cannot be written to is told at the end, by the values that are missing.
        if output::replace(path, text.as_bytes()).is_ok() {
            self.changed = false;
        }
        self.written = Some(Instant::now());
    }

    /// The file that could not be written, at the end.
    pub(super) fn lost(&self) -> Option<&PathBuf> {
        self.path.as_ref().filter(|_| self.changed)
    }
}

#[cfg(test)]
mod tests {
    use super::KeepFile;
    use lang::front::source::Source;
    use lang::front::{ProfileChoice, compile};

    #[test]
    fn values_outlive_the_run_for_the_same_keeps_in_the_same_order() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("job.bas").display().to_string();
        let open = |text: &str| {
            let source = Source::new("job.bas", text.to_owned());
            let (program, _) = compile(&source, ProfileChoice::built_in());
            KeepFile::open(&file, &program.expect("a program"))
        };
        let text = "KEEP parts\nKEEP bad\nparts = parts + 1\nbad = 0\n";
        let mut keeps = open(text);
        assert_eq!(keeps.values(), [0, 0]);
        keeps.note(&[5, -2]);
        keeps.note(&[6, -2]);
        keeps.write();
        assert_eq!(keeps.lost(), None);
        assert_eq!(open(text).values(), [6, -2]);
        assert_eq!(open("KEEP bad\nKEEP parts\nparts = 1\nbad = 0\n").values(), [0, 0]);
        assert_eq!(open("KEEP parts\nparts = 1\n").values(), [0]);
        let name = format!("{file}.keep");
        assert_eq!(std::fs::read_to_string(&name).expect("a file"), "parts = 6\nbad = -2\n");
        std::fs::write(&name, "parts = 9999999999\nbad = 1\n").expect("written");
        assert_eq!(open(text).values(), [0, 0]);
    }
}
