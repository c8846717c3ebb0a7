//! The cell around a rig's machine.

use super::super::hardware::Hardware;
use super::{HostAction, HostDeed, Rig, Shared};

impl<B: Hardware> Rig<B> {
    /// Puts the scenario's cell around the pins; the reference switches stand where its frame has them.
    pub(super) fn build_cell(&mut self) {
        let (now, per_us) = (self.now(), self.ticks(1));
        let built = self.scene.build_cell(now, per_us, &mut self.board.plant_mut());
        if let Some((cell, placed)) = built {
            (self.cell, self.placed) = (Some(cell), placed);
        }
    }

    /// The cell's time begins with the run.
    pub(super) fn begin_cell(&mut self, tick: u64) {
        let Some(cell) = &self.cell else { return };
        let motors = [0, 1, 2].map(|axis| self.board.plant().motors[axis].position);
        cell.get().begin(tick, motors);
        self.board.plant_mut().ask_around(tick);
        self.look_at_cell();
    }

    /// What has become due in the cell, and what it asks of the host.
    pub(super) fn look_at_cell(&mut self) {
        let Some(cell) = self.cell.clone() else { return };
        let now = self.now();
        self.board.plant_mut().pass(now);
        let deeds = cell.get().take_deeds();
        for deed in deeds {
            match deed {
                HostDeed::EmergencyStop => self.host_actions.push(HostAction::EmergencyStop),
                HostDeed::Register(register, value) => {
                    self.host_actions.push(HostAction::Register(register, value));
                }
                HostDeed::Pause(pauses) => self.host_actions.push(HostAction::Pause(pauses)),
                HostDeed::Gone => self.scene.scenario.end_client(),
                HostDeed::Stall(axis, steps) => {
                    self.scene.stall(axis, steps, &mut self.board.plant_mut());
                }
            }
        }
        self.inputs.extend(cell.get().take_edges());
        let taken = cell.get().take_taken();
        self.scene.scenario.taken(&taken, self.us());
    }

    /// Where the motors stand, for a world that asks the cell about it.
    pub(super) fn stand_by_world(&self, us: u64) {
        if self.cell.is_some() {
            let motors = [0, 1, 2].map(|axis| self.board.plant().motors[axis].position);
            self.scene.scenario.stand(us, motors);
        }
    }

    /// What the world has done to the cell.
    pub(super) fn look_at_touch(&mut self) {
        if self.scene.scenario.take_touch() {
            let now = self.now();
            self.board.plant_mut().ask_around(now);
            self.look_at_cell();
        }
    }

    /// The cell around the machine, if there is one.
    pub fn cell(&self) -> Option<&Shared> {
        self.cell.as_ref()
    }

    /// The script prints a line: people of the cell may wait for it.
    pub fn cell_prints(&mut self, text: &str) {
        let Some(cell) = &self.cell else { return };
        let us = self.us();
        cell.get().cell_mut().prints(text, us);
        let now = self.now();
        self.board.plant_mut().ask_around(now);
    }

    /// The script waits for Start: people of the cell who wait for that press it. Gives whether one will.
    pub fn cell_waits_for_start(&mut self) -> bool {
        let Some(cell) = &self.cell else { return false };
        let us = self.us();
        let acts = cell.get().cell_mut().waits_for_start(us);
        let now = self.now();
        self.board.plant_mut().ask_around(now);
        acts
    }
}
