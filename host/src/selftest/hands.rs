//! Steps that need a person at the board: Start, Stop, RST.

use std::time::Duration;

use lang::wire::{Control, RunState};

use super::{Ask, Bench, Trouble};
use crate::link::Link;

/// A program that goes on for ever.
const LOOP: &str = "DO\n  Wait 20ms\nLOOP\n";
/// How long a person has.
const PATIENCE: Duration = Duration::from_secs(30);
/// Bit of the reset's cause: the RST pin.
const RST: u16 = 1 << 3;

impl<L: Link> Bench<'_, L> {
    pub(super) fn hands(&mut self) -> Result<(), Trouble> {
        if !self.plan.hands {
            self.left_out("Start, Stop, RST", "--hands says that somebody presses them");
            return Ok(());
        }
        self.program(LOOP)?;
        (self.ask)(Ask::Press("press Start"));
        let running = |bench: &mut Self| bench.is(RunState::Running);
        self.pressed("Start", "the program runs", running)?;
        (self.ask)(Ask::Press("press Stop"));
        let paused = |bench: &mut Self| bench.is(RunState::Paused);
        self.pressed("Stop", "it pauses", paused)?;
        self.board.control(Control::Stop)?;
        self.at_rest()?;
        (self.ask)(Ask::Press("press the reset button (RST)"));
        // While it comes up it does not answer.
        let reset = |bench: &mut Self| {
            Ok(bench.board.identity().is_ok_and(|identity| identity.reset_cause & RST != 0))
        };
        self.pressed("RST", "cause: RST pin", reset)
    }

    fn is(&mut self, wanted: RunState) -> Result<bool, Trouble> {
        Ok(self.board.run_state()?.0 == Some(wanted))
    }

    fn pressed(
        &mut self,
        check: &str,
        expected: &str,
        mut seen: impl FnMut(&mut Self) -> Result<bool, Trouble>,
    ) -> Result<(), Trouble> {
        let begun = self.board.link().now();
        let mut done = false;
        while !done && self.board.link().now() < begun + PATIENCE {
            self.board.link().pause(Duration::from_millis(50));
            done = seen(self)?;
        }
        let found = if done { expected } else { "nothing within 30 s" };
        self.row(check, expected, found, done);
        Ok(())
    }
}
