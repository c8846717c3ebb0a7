//! Power of a board: on, off, or cut in the middle of a flash operation.

use emulator::Wiring;

use super::{NativeBoard, POWER_UP};
use crate::port::Uart;

impl NativeBoard {
    /// A power cut and its end: only flash is as it was.
    pub fn power_cycle(&mut self) {
        self.power_cut();
        self.power_up();
    }

    /// Power goes. Time goes on, nothing else does.
    pub fn power_cut(&mut self) {
        self.desk.switch(false);
        self.line = Uart::default();
    }

    /// Time goes on to `limit`, ticks, without power. A pass in which it failed has come to its end meanwhile.
    pub(super) fn lie(&mut self, limit: u64) {
        self.power_cut();
        self.desk.spend(limit - self.desk.ticks());
    }

    /// Power comes back: only flash is as it was.
    pub fn power_up(&mut self) {
        self.desk.switch(true);
        self.desk.forget_run();
        self.boot(POWER_UP);
    }

    /// Whether it has power.
    pub fn powered(&self) -> bool {
        self.desk.has_power()
    }

    /// Cuts power in the middle of operation `n` of the flash from now on, from 1: a word written or a segment erased.
    /// Which of its bits are changed then, `seed` says.
    pub fn cut_at_flash_operation(&mut self, n: u64, seed: u64) {
        self.desk.fail_at(n, seed);
    }

    /// Operations of the flash so far.
    pub fn flash_operations(&self) -> u64 {
        self.desk.operations()
    }

    /// A board whose flash holds what [`NativeBoard::flash_contents`] gave, powered up.
    pub fn with_flash(wiring: Wiring, contents: &[u8]) -> NativeBoard {
        let mut board = NativeBoard::new(wiring);
        board.desk.set_flash(contents);
        board.power_cycle();
        board
    }
}
