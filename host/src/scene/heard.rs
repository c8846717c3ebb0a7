//! Events of a run for the cell around its machine, and the expectations at the end.

use super::live::Shared;
use super::{Report, Scene, picture};
use crate::sim::End;
use crate::sim::trace::{Status, What};

/// See the module.
#[derive(Debug, Default)]
pub struct Heard {
    /// The lines of the script by their times, us.
    lines: Vec<(u64, u32)>,
    printed: Vec<String>,
}

impl Heard {
    /// An event of the trace at a time, us. Gives the text that it prints: people of the cell may wait for it.
    pub fn tell<'a>(&mut self, us: u64, what: &'a What) -> Option<&'a str> {
        let line = what.line();
        if self.lines.last().is_none_or(|(_, last)| *last != line) {
            self.lines.push((us, line));
        }
        let What::Print { text, .. } = what else { return None };
        self.printed.push(text.clone());
        Some(text)
    }

    /// What the cell gives, at the end of the run, us; with its picture if `draws`.
    pub fn judge(
        &mut self,
        scene: &Scene,
        cell: &Shared,
        us: u64,
        end: &End,
        draws: bool,
    ) -> Report {
        let how = match (end.status, end.fault) {
            (Status::Fault, Some(fault)) => fault.to_string(),
            (Status::Fault, None) => "fault".to_owned(),
            (Status::Stopped, _) => "stopped".to_owned(),
            (Status::Done, _) => "done".to_owned(),
        };
        let mut live = cell.get();
        let end = ::cell::judge::End {
            us,
            how,
            printed: std::mem::take(&mut self.printed),
            on: live.outputs_on(),
            seen: Vec::new(),
        };
        let lines = std::mem::take(&mut self.lines);
        let line_at = |us: u64| {
            let after = lines.partition_point(|(began, _)| *began <= us);
            after.checked_sub(1).and_then(|index| lines.get(index)).map_or(0, |(_, line)| *line)
        };
        let mut report = Report::of(scene, live.cell_mut(), end, &line_at);
        if draws {
            report.shapes = picture::shapes(live.cell(), us);
        }
        report
    }
}
