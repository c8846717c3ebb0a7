//! The cell around the machine: what it does to the pins and asks of a host, what it hears, what it gives.

use lang::isa::first;
use lang::wire::Control;

use super::Native;
use crate::scene::Report;
use crate::scene::heard::Heard;
use crate::scene::live::{HostDeed, Shared};
use crate::sim::End;
use crate::sim::record::StopReason;
use crate::sim::trace::What;

/// People of a cell who wait for a program that waits for Start press it after so long without a sign of life, us: as
/// around a board.
const START_US: u64 = 500_000;

/// A cell, and what it has heard of the run.
pub struct Around {
    cell: Shared,
    /// Calls of the cell at the last look.
    calls: u32,
    heard: Heard,
}

impl Native {
    /// Puts the world's cell around the pins.
    pub(super) fn build_cell(&mut self) {
        let (now, per_us) = (self.board.cycles(), self.board.ticks_per_second() / 1_000_000);
        let built = self.scene.build_cell(now, per_us, &mut self.board.plant_mut());
        self.around = built.map(|(cell, _)| Around { cell, calls: 0, heard: Heard::default() });
    }

    /// The cell's time begins with the run.
    pub(super) fn begin_cell(&mut self) {
        let Some(around) = &self.around else { return };
        let now = self.board.cycles();
        let mut plant = self.board.plant_mut();
        let motors = plant.motors.each_ref().map(|motor| motor.position);
        around.cell.get().begin(now, motors);
        plant.ask_around(now);
        drop(plant);
        self.look_at_cell();
    }

    /// What the cell asks of the host.
    pub(super) fn look_at_cell(&mut self) {
        let Some(around) = &mut self.around else { return };
        // Nothing comes of a cell that was not called since.
        let calls = self.board.plant().calls_around();
        if std::mem::replace(&mut around.calls, calls) == calls {
            return;
        }
        let (deeds, edges, taken, ends) = {
            let mut cell = around.cell.get();
            (cell.take_deeds(), cell.take_edges(), cell.take_taken(), cell.must_end())
        };
        if ends {
            self.halt(StopReason::Collision);
        }
        self.scene.scenario.taken(&taken, self.now_us());
        if !deeds.is_empty() || !edges.is_empty() {
            self.board.disturb();
            self.alive_us = self.now_us();
        }
        for deed in deeds {
            let controller = self.board.controller_mut();
            match deed {
                HostDeed::EmergencyStop => controller.control(Control::EmergencyStop),
                HostDeed::Pause(true) => controller.control(Control::Pause),
                HostDeed::Pause(false) => controller.control(Control::Resume),
                // A register that the program lacks takes nothing, as on a board.
                HostDeed::Register(register, value) => {
                    self.scene.scenario.write_register(register, value);
                }
                HostDeed::Gone => self.scene.scenario.end_client(),
                HostDeed::Stall(axis, steps) => {
                    self.scene.stall(axis, steps, &mut self.board.plant_mut());
                }
            }
        }
    }

    /// Where the motors stand, for a world that asks the cell about it.
    pub(super) fn stand_by_world(&self, us: u64) {
        if self.around.is_some() {
            let motors = self.board.plant().motors.each_ref().map(|motor| motor.position);
            self.scene.scenario.stand(us, motors);
        }
    }

    /// What the world has done to the cell.
    pub(super) fn look_at_touch(&mut self) {
        if self.scene.scenario.take_touch() {
            let now = self.board.cycles();
            self.board.plant_mut().ask_around(now);
            self.board.disturb();
            self.look_at_cell();
        }
    }

    /// When the cell acts next by itself, ticks of the step timer.
    pub(super) fn cell_is_due(&self) -> Option<u64> {
        self.around.as_ref()?;
        self.board.plant().due().map(|due| due.div_ceil(self.board.unit()))
    }

    /// An event of the trace, for the cell.
    pub(super) fn tell_cell(&mut self, us: u64, what: &What) {
        let Some(Around { cell, heard, .. }) = &mut self.around else { return };
        let Some(text) = heard.tell(us, what) else { return };
        cell.get().cell_mut().prints(text, us);
        let now = self.board.cycles();
        self.board.plant_mut().ask_around(now);
    }

    /// Whether the script waits for Start, and people of the cell who wait for that press it.
    pub(super) fn cell_presses_start(&mut self, us: u64) -> bool {
        let waits = self.board.controller().program.effect.code == first::WaitStart;
        let Some(around) = self.around.as_ref().filter(|_| waits) else { return false };
        let acts = around.cell.get().cell_mut().waits_for_start(us);
        let now = self.board.cycles();
        self.board.plant_mut().ask_around(now);
        acts
    }

    /// For so long nothing has happened where nothing can happen any more, us.
    pub(super) fn patience_us(&self) -> u64 {
        if self.around.is_some() { START_US } else { super::ending::QUIET_US }
    }

    /// What the cell gives, at the end of the run.
    pub fn report(&mut self, end: &End) -> Option<Report> {
        let (us, draws) = (self.end_us(), self.options.record);
        let Around { cell, heard, .. } = self.around.as_mut()?;
        Some(heard.judge(self.scene.scenario.scene()?, cell, us, end, draws))
    }
}
