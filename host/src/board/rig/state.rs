//! State of a rig's board and machine.

use lang::axis::Axis;

use super::super::hardware::Hardware;
use super::{HostAction, Rig};

impl<B: Hardware> Rig<B> {
    /// The machine around the pins.
    pub fn plant(&self) -> impl std::ops::Deref<Target = emulator::Plant> + '_ {
        self.board.plant()
    }

    /// What the emulator noticed that the real part forbids.
    pub fn warnings(&self) -> Vec<String> {
        self.board.warnings()
    }

    /// What only the host can do for the scenario, since the last call.
    pub fn take_host_actions(&mut self) -> Vec<HostAction> {
        std::mem::take(&mut self.host_actions)
    }

    /// Edges of outputs since the last call.
    pub fn take_output_edges(&mut self) -> Vec<(u64, i32, bool)> {
        std::mem::take(&mut self.outputs)
    }

    /// Edges of inputs that the scenario made since the last call.
    pub fn take_input_edges(&mut self) -> Vec<(u64, i32, bool)> {
        std::mem::take(&mut self.inputs)
    }

    /// Where the motors are, in steps from power-up.
    pub fn motors(&self) -> [i64; 3] {
        Axis::ALL.map(|axis| self.board.plant().motors[axis.index()].position)
    }

    /// Rising STEP edges of each axis since power-up.
    pub fn pulses(&self) -> [u64; 3] {
        Axis::ALL.map(|axis| self.board.plant().motors[axis.index()].pulses)
    }

    /// Steps that stalls took from each axis.
    pub fn lost(&self) -> [i64; 3] {
        self.scene.lost
    }

    /// Machine position less motor position of each axis.
    pub fn offset(&self) -> [i64; 3] {
        self.scene.offset
    }

    /// The axis was homed: it rests at this machine position.
    pub fn homed(&mut self, axis: Axis, position: i32) {
        self.scene.homed(axis, position, &mut self.board.plant_mut());
    }

    /// The expectations of the world that do not hold, with the outputs as they are.
    pub fn failures(&self, pos: &crate::sim::trace::PerAxis) -> Vec<String> {
        let plant = self.board.plant();
        let output = |n: i32| self.scene.is_on(n, u8::try_from(n).is_ok_and(|n| plant.output(n)));
        self.scene.scenario.failures(&output, pos)
    }

    /// Sets the host's end of the line to whatever rate and parity the chip's UART has, as a
    /// connection without a rate of its own needs.
    pub fn follow_uart(&mut self) {
        let format = self.board.uart_format();
        self.board.set_uart_format(format);
    }
}
