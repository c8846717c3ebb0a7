//! The approach of a board to the place at which a job goes on in its middle.

use lang::axis::Axis;
use lang::fault::Fault;
use lang::wire::{self, RunState};

use crate::client::status::long;
use crate::client::{Client, ClientError};
use crate::link::Link;
use crate::track::{Approach, Track};

/// A way, and how the board stands before it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Way {
    /// The moves.
    pub approach: Approach,
    /// Machine places of the axes now, steps.
    pub there: [i32; 3],
    /// Outputs that are on (bit n - 1).
    pub on: u16,
}

/// Why there is none.
#[derive(Debug)]
pub enum NoWay {
    /// The board does not answer.
    Link(ClientError),
    /// A fault is latched.
    Latched,
    /// The job has homed this axis before, and the board has not.
    NotHomed(Axis),
    /// No board can go there.
    Wrong(Fault),
}

impl From<ClientError> for NoWay {
    fn from(error: ClientError) -> NoWay {
        NoWay::Link(error)
    }
}

/// The way to where a job stands that `track` has followed; `lift`: Z goes up to this work position, um, not as high as
/// the job has ever sent it.
///
/// # Errors
/// See [`NoWay`].
pub fn find<L: Link>(
    board: &mut Client<L>,
    track: &Track,
    lift: Option<i32>,
) -> Result<Way, NoWay> {
    let standing = board.stream_standing()?;
    if standing.state == Some(RunState::Fault) {
        return Err(NoWay::Latched);
    }
    if let Some(axis) = track.homed().find(|axis| standing.homed >> axis.index() & 1 == 0) {
        return Err(NoWay::NotHomed(axis));
    }
    let words = board.input(wire::WORK_POSITIONS, 6)?;
    let work = [0, 2, 4].map(|at: usize| long(words[at], words[at + 1]));
    let offsets = [0, 1, 2].map(|i: usize| standing.steps[i].wrapping_sub(work[i]));
    let on = board.coils(wire::COILS, 16)?;
    let on = on.iter().enumerate().fold(0, |on, (n, lit)| on | u16::from(*lit) << n);
    let approach = track.approach(standing.steps, offsets, lift).map_err(NoWay::Wrong)?;
    Ok(Way { approach, there: standing.steps, on })
}

/// What an approach does, in words: machine positions, a leg after the other.
pub fn told(approach: &Approach) -> String {
    let legs = approach.legs.iter().map(|leg| {
        let words = Axis::ALL.into_iter().filter_map(|axis| {
            let um = leg[axis.index()]?.um;
            Some(format!("{} to {} mm", axis.letter(), f64::from(um) / 1000.0))
        });
        words.collect::<Vec<_>>().join(", ")
    });
    legs.collect::<Vec<_>>().join("; then ")
}
