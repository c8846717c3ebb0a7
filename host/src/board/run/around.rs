//! The cell around a run's machine: the events that it gets, and the expectations on it.

use super::super::hardware::Hardware;
use super::Run;
use crate::scene::Report;
use crate::sim::End;
use crate::sim::trace::What;

impl<B: Hardware> Run<'_, '_, B> {
    /// An event of the trace, for the cell: the line that the script is in, and what it prints.
    pub(super) fn tell_cell(&mut self, us: u64, what: &What) {
        if self.rig.borrow().cell().is_none() {
            return;
        }
        if let Some(text) = self.heard.tell(us, what) {
            self.rig.borrow_mut().cell_prints(text);
        }
    }

    /// What the cell gives, at the end of the run.
    pub(super) fn judge_cell(&mut self, us: u64, end: &End) -> Option<Report> {
        let scene = self.job.world.scene()?;
        let cell = self.rig.borrow().cell().cloned()?;
        Some(self.heard.judge(scene, &cell, us, end, self.job.options.record))
    }
}
