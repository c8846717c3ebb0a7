//! The top of a cell file, and of those that it includes.

use super::{Builder, VERSION};
use crate::keys::OUTCOMES;
use crate::problem::Problem;
use crate::value::Entry;

impl Builder<'_> {
    /// The top of an included file: only its things are taken.
    pub(super) fn included(&mut self, entry: &Entry) {
        self.version(entry);
        for key in ["profile", "start", "table", "stop_on"] {
            if entry.has(key) {
                let text = format!("`{key}` of an included file has no effect");
                let problem = Problem::warning("C016", entry.span_of(key), text);
                self.problems.push(problem.hint("write it into the file that includes this one"));
            }
        }
    }

    fn version(&mut self, entry: &Entry) {
        if let Some(version) = entry.number("cell")
            && version != VERSION
        {
            let text = format!("this cell is of version {version}; this program reads {VERSION}");
            self.wrong("C013", entry.span_of("cell"), text);
        }
    }

    pub(super) fn top(&mut self, entry: &Entry) {
        self.version(entry);
        self.scene.name = entry.text("name");
        self.scene.profile = entry.text("profile");
        let start = entry.list("start");
        if start.len() >= 3 {
            self.scene.start =
                Some([start[0], start[1], start[2], start.get(3).copied().unwrap_or(0.0)]);
        }
        self.scene.table = entry.number("table");
        self.scene.stop_on = entry.texts("stop_on");
        for class in self.scene.stop_on.clone() {
            if !OUTCOMES.contains(&class.as_str()) {
                let text = format!("`stop_on`: \"{class}\" is none of {}", OUTCOMES.join(", "));
                self.wrong("C004", entry.span_of("stop_on"), text);
            }
        }
    }
}
