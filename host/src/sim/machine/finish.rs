//! The end of a run: requests for it, axes that still move, outputs, the last line of the trace.

use lang::axis::Axis;
use lang::fault::Fault;

use super::Machine;
use super::ending::Halt;
use crate::sim::record::StopReason;
use crate::sim::step::Step;
use crate::sim::trace::{Status, What};
use crate::sim::{End, SimError};

impl Machine {
    /// The engine has executed as many statements as it may.
    pub fn give_up(&mut self) {
        self.halt(Halt::Stopped(StopReason::Statements));
    }

    /// Whether the run is over whatever the program wants.
    pub fn is_halted(&self) -> bool {
        self.ending.halt.is_some()
    }

    /// The run is over.
    pub(super) fn halt(&mut self, why: Halt) {
        self.ending.halt = Some(why);
        self.events.attention = true;
    }

    /// Ends the run when its user wants that.
    pub(super) fn look_for_interruption(&mut self) {
        if !self.is_halted() && (self.ending.interrupted)() {
            self.halt(Halt::Stopped(StopReason::Interrupted));
        }
    }

    /// An emergency stop: every axis stands at once.
    pub(super) fn emergency_stop(&mut self) {
        self.cut_motion(&Axis::ALL, Fault::EmergencyStop);
    }

    /// Every axis stands at once, without a ramp, and those of `lost` know their reference no more.
    pub(super) fn cut_motion(&mut self, lost: &[Axis], fault: Fault) {
        self.ending.cut = self.pieces.line;
        self.motion.halt(self.clock.now());
        self.log_milestones();
        for axis in lost {
            self.axes.set_homed(*axis, false);
        }
        for axis in Axis::ALL {
            self.adopt(axis);
        }
        self.halt(Halt::Fault(fault));
    }

    /// A fault is about to be handled, or to end the run: the path comes to its end and every
    /// other axis ramps down. Gives the fault to report: an emergency stop on the way comes first.
    pub fn ramp_down(&mut self, fault: Fault) -> Fault {
        self.print.take();
        self.sync_path();
        for axis in Axis::ALL {
            self.motion.stop(axis, self.clock.now());
        }
        self.rest_all();
        for axis in Axis::ALL {
            self.adopt(axis);
        }
        self.clock.look_anew();
        match self.ending.halt {
            Some(Halt::Fault(fault)) => fault,
            _ => fault,
        }
    }

    /// END: STARTed moves come to their ends, MoveSpeed axes ramp down.
    pub fn end(&mut self) -> Step {
        self.sync_path();
        for axis in Axis::ALL {
            if self.axes.is_running(axis) {
                self.motion.stop(axis, self.clock.now());
            }
        }
        self.rest_all();
        if self.is_halted() { Step::Stop } else { Step::Done(0) }
    }

    /// Ends the run: `fault` is the program's, `None` its END or whatever stopped it. `line` is that of the
    /// statement under way; what cuts a path does so in the line of the block that plays.
    ///
    /// # Errors
    /// The world's script failed on the way.
    pub fn finish(&mut self, fault: Option<Fault>, line: u32) -> Result<End, SimError> {
        if let Some(error) = self.ending.world_error.take() {
            return Err(error.into());
        }
        let (status, fault) = match (self.ending.halt, fault) {
            (Some(Halt::Fault(fault)), _) | (None, Some(fault)) => (Status::Fault, Some(fault)),
            (Some(Halt::Stopped(reason)), _) => {
                self.ending.stopped = Some(reason);
                (Status::Stopped, None)
            }
            (None, None) => (Status::Done, None),
        };
        // What still moves after a stop ramps down before the outputs take their end states.
        if !self.motion.stands() {
            self.ending.halt = None;
            self.motion.pause(true, self.clock.now());
            while !self.motion.stands() {
                let Some(at) = self.motion.next_us() else { break };
                self.clock.reach(at);
                self.motion.advance(self.clock.now());
            }
            self.log_milestones();
        }
        let line = self.ending.cut.or(self.pieces.line).unwrap_or(line);
        self.motion.forget(self.clock.now());
        self.log_milestones();
        self.outputs.safe(status == Status::Fault);
        self.outputs_changed();
        let pos = self.steps();
        self.write(What::end(status, fault, line, pos));
        self.log.close(self.clock.now(), self.outputs.on());
        Ok(End { status, fault, line })
    }
}
