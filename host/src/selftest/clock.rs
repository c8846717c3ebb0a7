//! The board's millisecond against the link's clock, and what the last reset was.

use std::time::Duration;

use lang::wire::{self, Control};

use super::{Bench, Trouble};
use crate::client::status::long;
use crate::link::Link;

/// Shows the program's milliseconds in its first cell.
const TICKER: &str = "DIM t AS TIME AT 3000\nDO\n  t = TIMER()\nLOOP\n";
/// How far a crystal's clock may be off, in millionths: a resonator's 0.5 %, and a computer's own clock.
const CRYSTAL: f64 = 5_500.0;
/// The calibrated DCO of the G2553 from 0 to 85 degrees (SLAS735), REFO of the F5529 (SLAS590).
const CALIBRATED: f64 = 30_000.0;
const REFO: f64 = 35_000.0;
/// How much slower than from its crystal the firmware runs the F5529 from REFO.
const SLOWER: f64 = 1e6 - 737.0 * 32_768.0 / 25.0;
/// Bits of the reset's cause (`wire`, RESET_CAUSE).
const NO_CRYSTAL: u16 = 1 << 5;
/// Power on, RST pin, NMI. The software resets by the watchdog, whose bit tells so on the G2553.
const OTHERS: u16 = 0b1_1100;

impl<L: Link> Bench<'_, L> {
    /// Behind a reset by the software: what its cause was, and whether the crystal runs.
    pub(super) fn after_reset(&mut self) -> Result<(), Trouble> {
        let cause = self.board.identity()?.reset_cause;
        let good = cause & OTHERS == 0;
        let found =
            if good { "none of them".to_owned() } else { format!("bits {:05b}", cause & OTHERS) };
        self.row("cause of a reset by software", "neither power nor RST nor NMI", found, good);
        if self.has_crystal() {
            let runs = cause & NO_CRYSTAL == 0;
            self.row("crystal", "runs", if runs { "runs" } else { "does not run" }, runs);
        }
        Ok(())
    }

    pub(super) fn clock(&mut self) -> Result<(), Trouble> {
        let no_crystal = self.board.identity()?.reset_cause & NO_CRYSTAL != 0;
        let (slower, most) = match (self.has_crystal(), no_crystal) {
            (true, false) => (0.0, CRYSTAL),
            (true, true) => (SLOWER, REFO),
            (false, _) => (0.0, CALIBRATED),
        };
        self.program(TICKER)?;
        self.board.control(Control::Start)?;
        self.board.link().pause(Duration::from_millis(200));
        let (first, shown_first) = self.tick()?;
        self.board.link().pause(self.plan.listen);
        let (last, shown_last) = self.tick()?;
        self.board.control(Control::Stop)?;
        self.at_rest()?;
        let passed = (last - first).as_secs_f64() * 1000.0;
        let off = (f64::from(shown_last.wrapping_sub(shown_first)) / passed - 1.0) * 1e6;
        let expected = match slower {
            0.0 => format!("off by at most {:.2} %", most / 1e4),
            _ => format!("{:.2} % slow, give or take {:.2} %", slower / 1e4, most / 1e4),
        };
        let good = (off + slower).abs() <= most;
        self.row("millisecond", expected, format!("{:+.3} %", off / 1e4), good);
        Ok(())
    }

    /// The program's millisecond, and the instant of it: that of the quickest of some exchanges.
    fn tick(&mut self) -> Result<(Duration, i32), Trouble> {
        let mut best: Option<(Duration, Duration, i32)> = None;
        for _ in 0..8 {
            let asked = self.board.link().now();
            let words = self.board.holding(wire::CELLS, 2)?;
            let took = self.board.link().now() - asked;
            if best.is_none_or(|(least, ..)| took < least) {
                best = Some((took, asked + took / 2, long(words[0], words[1])));
            }
        }
        let (_, at, shown) = best.ok_or_else(|| Trouble::Words("no exchange".to_owned()))?;
        Ok((at, shown))
    }

    /// Waits until no program runs.
    pub(super) fn at_rest(&mut self) -> Result<(), Trouble> {
        use wire::RunState;
        let states = [RunState::Ready, RunState::Empty, RunState::Fault];
        match self.board.wait_for(&states)? {
            Ok(_) => Ok(()),
            Err(state) => Err(Trouble::Words(format!("the program does not end: {state:?}"))),
        }
    }
}
