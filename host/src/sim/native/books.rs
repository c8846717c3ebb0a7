//! Events of the machine as trace and record.

use lang::axis::Axis;
use lang::wire::{TRACE_OK, TraceKind};

use super::{LONGEST, Native, Noticed, Seen, Sight, told};
use crate::sim::trace::What;

/// Ends a line of PRINT.
const LINE_END: u8 = b'\n';

impl Native {
    /// Takes what has happened since the last call.
    pub(super) fn collect(&mut self) {
        for noticed in self.board.take_seen() {
            self.notice(noticed);
        }
        if self.board.plant().output_has_changed() {
            self.take_outputs();
        }
        let us = self.now_us();
        let motors = self.board.plant().motors.each_ref().map(|motor| motor.position);
        for ([least, greatest], at) in self.reached.iter_mut().zip(motors) {
            *least = at.min(*least);
            *greatest = at.max(*greatest);
        }
        if self.options.record {
            self.pieces.look(us, &self.board, &mut self.log);
        }
    }

    fn notice(&mut self, noticed: Noticed) {
        let us = self.us_at(noticed.tick);
        // Where the engine asks for the end, the machine may not know of the statements since the last effect.
        let asked =
            self.stopping.filter(|_| matches!(noticed.sight, Sight::Event(TraceKind::End, ..)));
        let line = asked.unwrap_or_else(|| self.board.desk().line_at(noticed.pc));
        match noticed.sight {
            Sight::Beside(Seen::Byte, LINE_END) => {
                let text = String::from_utf8_lossy(&self.printed).into_owned();
                self.printed.clear();
                let what = What::Print { line, text };
                self.tell_cell(us, &what);
                self.log.write(us, what);
            }
            Sight::Beside(Seen::Byte, byte) => {
                if self.printed.len() < LONGEST {
                    self.printed.push(byte);
                }
            }
            Sight::Beside(..) => self.printed.clear(),
            Sight::Event(kind, argument, value, commanded) => {
                if kind == TraceKind::Home
                    && let Some(axis) = Axis::from_index(usize::from(argument & !TRACE_OK))
                {
                    self.scene.homed(axis, value, &mut self.board.plant_mut());
                }
                let what = told::event(&self.profile, line, kind, argument, value, commanded);
                let Some(what) = what else { return };
                self.pieces.event(us, noticed.pc, &what, &self.board, &mut self.log);
                self.take_end(us, &what);
                self.tell_cell(us, &what);
                self.log.write(us, what);
            }
        }
        self.alive_us = us;
    }

    /// Outputs that have changed.
    pub(super) fn take_outputs(&mut self) {
        let unit = self.board.unit();
        let changes = self.board.plant_mut().take_output_changes();
        for change in changes {
            let n = i32::from(change.output);
            let on = self.scene.is_on(n, change.on);
            let us = self.us_at(change.cycle / unit);
            self.log.output(us, n, on);
            self.scene.scenario.output_changed(n, on, us);
        }
    }

    /// Inputs as the machine sees them, after polarity and filter.
    pub(super) fn look_at_inputs(&mut self) {
        let controller = self.board.controller();
        let now = u32::from(controller.io.inputs.levels()) | u32::from(controller.io.probe) << 16;
        let changed = now ^ std::mem::replace(&mut self.inputs, now);
        if changed == 0 {
            return;
        }
        let us = self.now_us();
        self.alive_us = us;
        for n in (0..17).filter(|n| changed >> n & 1 != 0) {
            self.log.input(us, n + 1, now >> n & 1 != 0);
        }
    }
}
