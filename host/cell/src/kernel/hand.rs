//! The tools of the head. One acts at a time: its state is the cell's `tool`, those of the others wait.

use super::Cell;
use super::state::ToolState;
use crate::law::Steps;
use crate::region::{Region, meeting};
use crate::scene::{Block, Tool, V3};

impl Cell {
    /// Where the tip of the first tool is, mm. What hangs on a tool hangs so far from there.
    #[must_use]
    pub fn tip(&self, at: &Steps) -> V3 {
        self.tip_of(0, at)
    }

    /// Where the tip of the tool that acts is, mm.
    pub(super) fn here(&self, at: &Steps) -> V3 {
        self.tip_of(self.hand, at)
    }

    /// Where the tip of a tool is, mm; the head where there is none.
    pub(super) fn tip_of(&self, tool: usize, at: &Steps) -> V3 {
        let offset = self.offset(tool);
        std::array::from_fn(|axis| {
            self.frame.start[axis] + f64::from(at[axis]) / self.frame.scale[axis] + offset[axis]
        })
    }

    /// From the head to the tip of a tool, mm.
    pub(super) fn offset(&self, tool: usize) -> V3 {
        self.scene.tools.get(tool).map_or([0.0; 3], |own| own.tip)
    }

    /// The tool that acts.
    pub(super) fn own(&self) -> Option<&Tool> {
        self.scene.tools.get(self.hand)
    }

    /// Lets another tool act.
    pub(super) fn turn_to(&mut self, tool: usize) {
        if tool == self.hand || tool >= self.parked.len() {
            return;
        }
        std::mem::swap(&mut self.tool, &mut self.parked[self.hand]);
        std::mem::swap(&mut self.tool, &mut self.parked[tool]);
        self.hand = tool;
    }

    /// Lets each tool act; the one that acted before does so again then.
    pub(super) fn each_tool(&mut self, mut act: impl FnMut(&mut Cell)) {
        let before = self.hand;
        for tool in 0..self.parked.len() {
            self.turn_to(tool);
            act(self);
        }
        self.turn_to(before);
    }

    /// The states of all tools.
    pub(super) fn states(&self) -> impl Iterator<Item = &ToolState> {
        (0..self.parked.len()).map(|tool| self.state_of(tool))
    }

    /// The state of a tool.
    pub(super) fn state_of(&self, tool: usize) -> &ToolState {
        if tool == self.hand { &self.tool } else { &self.parked[tool] }
    }

    /// Head places, in steps, from which a block of the cell's frame is met by a block that hangs from the tip of a tool.
    pub(super) fn region(
        &self,
        tool: usize,
        standing: &Block,
        moving: &Block,
        shrink: f64,
    ) -> Region {
        let offset = self.offset(tool);
        let from_head = std::array::from_fn(|axis| self.frame.start[axis] + offset[axis]);
        meeting(standing, &moving.moved(from_head), shrink, self.frame.scale)
    }

    /// Head places at which the tip of the tool that acts lies in a block.
    pub(super) fn tip_in(&self, block: &Block) -> Region {
        self.region(self.hand, block, &Block { low: [0.0; 3], high: [0.0; 3] }, 0.0)
    }
}
