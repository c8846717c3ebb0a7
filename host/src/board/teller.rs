//! Formats what was observed of a board as lines of the trace.

use lang::axis::Axis;
use lang::profile::{Profile, Scale};
use lang::vm::math;
use lang::wire::{Seen, TraceKind};

use super::engine::Other;
use super::observe::{Observed, Sight};
use crate::client::print::LINE_END;
use crate::sim::told::event;
use crate::sim::trace::What;

/// Bytes kept of a printed line.
const LONGEST: usize = 4096;

/// Puts the trace together.
pub struct Teller<'a> {
    profile: &'a Profile,
    /// The programs of the board, by number from 1.
    programs: Vec<Other<'a>>,
    /// Place of the one that runs.
    runs: usize,
    /// What has come of the line that is being printed.
    printed: Vec<u8>,
    /// Commanded machine positions, steps, as of the newest event.
    commanded: [i32; 3],
}

impl<'a> Teller<'a> {
    /// For a run that is about to start.
    pub fn new(profile: &'a Profile, programs: Vec<Other<'a>>) -> Teller<'a> {
        Teller { profile, programs, runs: 0, printed: Vec::new(), commanded: [0; 3] }
    }

    /// The program that runs, and its place among those of the board.
    pub fn runs(&self) -> (usize, Option<&Other<'a>>) {
        (self.runs, self.programs.get(self.runs))
    }

    /// Its line at an address in its code.
    pub fn line_of(&self, pc: u16) -> u32 {
        self.programs.get(self.runs).map_or(0, |own| (own.line_of)(pc))
    }

    /// Machine positions in steps; of one that fits into no number, which no line is taken to, 0.
    fn steps(&self, um: [i32; 3]) -> [i32; 3] {
        Axis::ALL.map(|axis| {
            let scale = self.profile.axis(axis).map_or(Scale { steps: 1, um: 1 }, |own| own.scale);
            math::scale(um[axis.index()], scale.steps, scale.um).unwrap_or_default()
        })
    }

    /// The line that this makes, if it makes one.
    pub fn tell(&mut self, observed: &Observed) -> Option<What> {
        let line = self.line_of(observed.pc);
        match observed.sight {
            Sight::Beside(Seen::Byte, LINE_END) => {
                let text = std::mem::take(&mut self.printed);
                Some(What::Print { line, text: String::from_utf8_lossy(&text).into_owned() })
            }
            Sight::Beside(Seen::Byte, byte) => {
                if self.printed.len() < LONGEST {
                    self.printed.push(byte);
                }
                None
            }
            Sight::Joined(um) => {
                let steps = self.steps(um);
                // A line without a step makes no event.
                let goes = steps != std::mem::replace(&mut self.commanded, steps);
                goes.then(|| event(self.profile, line, TraceKind::Line, 0, 0, steps)).flatten()
            }
            Sight::Beside(Seen::Begun | Seen::Abandoned, _) => {
                self.printed.clear();
                None
            }
            Sight::Event { kind: TraceKind::Run, argument, .. } => {
                self.runs = usize::from(argument).wrapping_sub(1);
                let program = self.programs.get(self.runs).map(|own| own.name.to_owned());
                Some(What::Run { line, program: program.unwrap_or_default() })
            }
            Sight::Event { kind, argument, value, commanded } => {
                self.commanded = commanded;
                event(self.profile, line, kind, argument, value, commanded)
            }
        }
    }
}
