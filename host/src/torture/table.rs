//! What the torture does to a board that lies on the table: the emulated one, or the firmware's machine on the desktop.

use desk::board::NativeBoard;
use emulator::{Board, Stop, WarningKind, Wiring};

use crate::board::hardware::Hardware;

/// A board whose power and line are in the hand.
pub trait Table: Hardware {
    /// What a copy is made of.
    type Kept: Send;

    /// Keeps it as it is.
    fn kept(self) -> Self::Kept;
    /// A copy of what was kept.
    fn copy_of(kept: &Self::Kept) -> Self;
    /// Runs so many microseconds, or until power fails.
    fn run_us(&mut self, us: u64) -> Stop;
    /// Runs to a tick, or until power fails.
    fn run_to(&mut self, tick: u64) -> Stop;
    /// Switches the supply off.
    fn power_cut(&mut self);
    /// Switches it on.
    fn power_up(&mut self);
    /// The supply comes back before RAM has lost its content.
    fn power_back(&mut self);
    /// The supply dips.
    fn brown_out(&mut self);
    /// The RST pin is pulled.
    fn pull_reset(&mut self);
    /// Lets power fail in operation `n` of the flash from now on, from 1; `seed` says how far that comes.
    fn fail_at(&mut self, n: u64, seed: u64);
    /// Operations of the flash so far.
    fn operations(&self) -> u64;
    /// Begins measurements anew.
    fn forget(&mut self);
    /// What broke a rule of the chip, but for a restart's watchdog key.
    fn warning(&self) -> Option<String>;
}

impl Table for Board {
    type Kept = Board;

    fn kept(self) -> Board {
        self
    }
    fn copy_of(kept: &Board) -> Board {
        kept.clone()
    }
    fn run_us(&mut self, us: u64) -> Stop {
        Board::run_us(self, us)
    }
    fn run_to(&mut self, tick: u64) -> Stop {
        Board::run_until(self, tick)
    }
    fn power_cut(&mut self) {
        Board::power_cut(self);
    }
    fn power_up(&mut self) {
        Board::power_up(self);
    }
    fn power_back(&mut self) {
        Board::power_back(self);
    }
    fn brown_out(&mut self) {
        Board::brown_out(self);
    }
    fn pull_reset(&mut self) {
        self.reset_pin();
    }
    fn fail_at(&mut self, n: u64, seed: u64) {
        self.cut_at_flash_operation(n, seed);
    }
    fn operations(&self) -> u64 {
        self.wear().operations
    }
    fn forget(&mut self) {
        self.clear_stats();
    }
    fn warning(&self) -> Option<String> {
        let own = Board::warnings(self).iter().find(|own| own.kind != WarningKind::Key);
        own.map(ToString::to_string)
    }
}

/// A board of the desktop is kept by its flash: its copies come up anew.
impl Table for NativeBoard {
    type Kept = (Wiring, Vec<u8>);

    fn kept(self) -> (Wiring, Vec<u8>) {
        let wiring = NativeBoard::plant(&self).wiring();
        (wiring, self.flash_contents())
    }
    fn copy_of((wiring, flash): &(Wiring, Vec<u8>)) -> NativeBoard {
        NativeBoard::with_flash(*wiring, flash)
    }
    fn run_us(&mut self, us: u64) -> Stop {
        let tick =
            NativeBoard::cycles(self) + us * (NativeBoard::ticks_per_second(self) / 1_000_000);
        self.run_to(tick)
    }
    fn run_to(&mut self, tick: u64) -> Stop {
        while NativeBoard::cycles(self) < tick {
            if !NativeBoard::powered(self) {
                return Stop::NoPower;
            }
            let limit = tick.div_ceil(self.unit());
            NativeBoard::run_until(self, limit);
            NativeBoard::plant_mut(self).take_output_changes();
            self.take_seen();
        }
        if NativeBoard::powered(self) { Stop::Time } else { Stop::NoPower }
    }
    fn power_cut(&mut self) {
        NativeBoard::power_cut(self);
    }
    fn power_up(&mut self) {
        NativeBoard::power_up(self);
    }
    // A reset clears RAM, whatever it holds.
    fn power_back(&mut self) {
        NativeBoard::power_up(self);
    }
    fn brown_out(&mut self) {
        self.power_cycle();
    }
    fn pull_reset(&mut self) {
        self.reset_pin();
    }
    fn fail_at(&mut self, n: u64, seed: u64) {
        self.cut_at_flash_operation(n, seed);
    }
    fn operations(&self) -> u64 {
        self.flash_operations()
    }
    fn forget(&mut self) {}
    fn warning(&self) -> Option<String> {
        None
    }
}
