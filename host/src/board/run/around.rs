//! The cell around a run's machine: what it hears, and what is judged of it.

use super::super::hardware::Hardware;
use super::Run;
use crate::scene::Report;
use crate::sim::End;
use crate::sim::trace::{Status, What};

impl<B: Hardware> Run<'_, '_, B> {
    /// An event of the trace, for the cell: the line that the script is in, and what it prints.
    pub(super) fn tell_cell(&mut self, us: u64, what: &What) {
        if self.rig.borrow().cell().is_none() {
            return;
        }
        let line = what.line();
        if self.lines.last().is_none_or(|(_, last)| *last != line) {
            self.lines.push((us, line));
        }
        if let What::Print { text, .. } = what {
            self.printed.push(text.clone());
            self.rig.borrow_mut().cell_prints(text);
        }
    }

    /// What the cell gives, at the end of the run.
    pub(super) fn judge_cell(&mut self, us: u64, end: &End) -> Option<Report> {
        let scene = self.job.world.scene()?;
        let cell = self.rig.borrow().cell().cloned()?;
        let how = match (end.status, end.fault) {
            (Status::Fault, Some(fault)) => fault.to_string(),
            (Status::Fault, None) => "fault".to_owned(),
            (Status::Stopped, _) => "stopped".to_owned(),
            (Status::Done, _) => "done".to_owned(),
        };
        let mut live = cell.get();
        let end = cell::judge::End {
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
        Some(Report::of(scene, live.cell_mut(), end, &line_at))
    }
}
