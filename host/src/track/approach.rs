//! The way of a board to where a job goes on in its middle.

use lang::axis::Axis;
use lang::effect::Frame;
use lang::fault::Fault;
use lang::isa::{Op, flags};
use lang::place::Place;

use super::{Instruction, Track};

/// How a board comes to where a job goes on in its middle: lifted, then across, then down.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Approach {
    /// Machine places of the axes that each rapid move goes to.
    pub legs: Vec<[Option<Place>; 3]>,
    /// Where the last one ends, steps.
    pub steps: [i32; 3],
}

impl Approach {
    /// The moves.
    pub fn instructions(&self) -> impl Iterator<Item = Instruction> + '_ {
        self.legs.iter().map(|leg| {
            let axes = (0..3).filter(|i| leg[*i].is_some()).fold(0, |axes, i| axes | 1 << i);
            let frame = (Frame::Machine as u8) << flags::COMMON_FRAME;
            let values = leg.iter().flatten().map(|place| place.um).collect();
            (values, vec![Op::Linear.code(), axes | flags::RAPID | frame])
        })
    }
}

impl Track {
    /// How a board comes from `there` to where the job stands: Z up as high as the job has ever sent it, or to the work
    /// position `lift` (um), and never down first; then the other axes, then Z. Axes that the job never sent anywhere
    /// stay. Where the job has set a work zero, the board's own tells where that is: `offsets` are its machine
    /// positions less its work positions. Both in steps.
    ///
    /// # Errors
    /// F01.
    pub fn approach(
        &self,
        there: [i32; 3],
        offsets: [i32; 3],
        lift: Option<i32>,
    ) -> Result<Approach, Fault> {
        let sum = |a: i32, b: i32| a.checked_add(b).ok_or(Fault::Overflow);
        let place = |axis: Axis, um: i32| -> Result<Place, Fault> {
            Ok(Place { um, steps: self.axes.to_steps(axis, um)? })
        };
        let mut goals = [Place::default(); 3];
        // What the job's machine positions are less than the board's.
        let mut shifts = [0; 3];
        for axis in Axis::ALL {
            let i = axis.index();
            if self.zeroed[i] {
                let own = self.zero(axis)?;
                let board = self.axes.length(axis, offsets[i])?;
                shifts[i] = board.checked_sub(own).ok_or(Fault::Overflow)?;
            }
            goals[i] = if self.touched[i] {
                place(axis, sum(self.axes.place(axis).um, shifts[i])?)?
            } else {
                Place { um: self.axes.length(axis, there[i])?, steps: there[i] }
            };
        }
        let z = Axis::Z.index();
        let lifts = self.axes.is_present(Axis::Z) && (self.touched[z] || lift.is_some());
        let mut legs = Vec::new();
        let mut add = |leg: [Option<Place>; 3]| {
            if leg.iter().any(Option::is_some) {
                legs.push(leg);
            }
        };
        let goes = |i: usize| Some(goals[i]).filter(|goal| goal.steps != there[i]);
        let across = [goes(0), goes(1), None];
        if lifts {
            let here = self.axes.length(Axis::Z, there[z])?;
            let wanted = match lift {
                Some(lift) => sum(sum(lift, self.zero(Axis::Z)?)?, shifts[z])?,
                None => sum(self.top.unwrap_or(here), shifts[z])?,
            };
            let up = place(Axis::Z, self.higher(self.higher(wanted, here), goals[z].um))?;
            if across.iter().any(Option::is_some) {
                add([None, None, Some(up).filter(|up| up.steps != there[z])]);
                add(across);
                add([None, None, Some(goals[z]).filter(|goal| goal.steps != up.steps)]);
            } else {
                add([None, None, goes(z)]);
            }
        } else {
            add(across);
        }
        Ok(Approach { legs, steps: goals.map(|goal| goal.steps) })
    }
}
