//! Checks a run that only moves: every motor stays between the positions of the trace.

use lang::axis::Axis;

use crate::sim::trace::{MoveKind, Status, What};

/// Where motors may be.
#[derive(Default)]
pub struct Within {
    /// The least and the greatest place of each axis, steps as in the trace; nothing once an axis went where the trace
    /// alone does not tell: to a switch, along an arc, at a speed.
    reach: Option<[[i64; 2]; 3]>,
    /// A place outside, unless what is told next is that an axis has gone to a switch: that is told when it is there.
    seen: Option<String>,
    /// The first place outside.
    strayed: Option<String>,
}

impl Within {
    /// A run begins with the axes here.
    pub fn begin(&mut self, at: [i64; 3]) {
        self.reach = Some(at.map(|at| [at, at]));
    }

    /// What the trace tells next.
    pub fn tell(&mut self, what: &What) {
        let seen = self.seen.take();
        let sought = match what {
            What::Home { .. } | What::Probe { .. } => true,
            // Also one that was not found.
            What::End { status, .. } => *status != Status::Done,
            _ => false,
        };
        if !sought && self.strayed.is_none() {
            self.strayed = seen;
        }
        match what {
            What::Move { kind: MoveKind::Arc, .. }
            | What::Home { .. }
            | What::Probe { .. }
            | What::Speed { .. }
            | What::Run { .. } => self.reach = None,
            What::Move { to, .. } => {
                for (axis, [least, most]) in
                    Axis::ALL.into_iter().zip(self.reach.iter_mut().flatten())
                {
                    let to = to.get(axis).map_or(*least, i64::from);
                    (*least, *most) = (to.min(*least), to.max(*most));
                }
            }
            _ => {}
        }
    }

    /// The motors are seen here; of one that lost steps nothing is known.
    pub fn look(&mut self, at: [i64; 3], lost: [i64; 3]) {
        let Some(reach) = self.reach else { return };
        for (axis, ([least, most], at)) in Axis::ALL.into_iter().zip(reach.into_iter().zip(at)) {
            if lost[axis.index()] == 0 && !(least..=most).contains(&at) && self.seen.is_none() {
                let letter = axis.letter();
                self.seen = Some(format!(
                    "{letter} was at {at}, but all that the trace had told lies from {least} to {most}"
                ));
            }
        }
    }

    /// What was wrong.
    pub fn strayed(&mut self) -> Option<String> {
        self.strayed.take()
    }
}

#[cfg(test)]
mod tests {
    use super::{MoveKind, Status, What, Within};
    use crate::sim::trace::{AxisLetter, PerAxis};
    use lang::axis::Axis;

    fn end(status: Status) -> What {
        What::end(status, None, 9, PerAxis::new([Some(0); 3]))
    }

    fn line(x: i32, y: i32) -> What {
        What::Move { line: 1, kind: MoveKind::Line, to: PerAxis::new([Some(x), Some(y), None]) }
    }

    #[test]
    fn a_motor_that_turns_the_wrong_way_is_found_though_it_comes_back() {
        let mut within = Within::default();
        within.begin([0, 0, 7]);
        within.tell(&line(0, 100));
        within.look([0, 60, 7], [0; 3]);
        within.tell(&line(30, 200));
        within.look([29, 199, 7], [0; 3]);
        assert_eq!(within.strayed(), None);
        within.look([-1, 120, 7], [1, 0, 0]);
        assert_eq!(within.strayed(), None, "it had lost steps");
        within.look([-1, 120, 7], [0; 3]);
        within.look([0, 0, 7], [0; 3]);
        within.tell(&end(Status::Done));
        let told = within.strayed().expect("X was not between 0 and 30");
        assert_eq!(told, "X was at -1, but all that the trace had told lies from 0 to 30");
    }

    #[test]
    fn where_the_trace_does_not_tell_the_way_nothing_is_held() {
        let mut within = Within::default();
        within.begin([0; 3]);
        within.tell(&What::Speed { line: 1, axis: AxisLetter(Axis::X), v: 9 });
        within.look([5000, 0, 0], [0; 3]);
        within.tell(&end(Status::Done));
        assert_eq!(within.strayed(), None);
        within.begin([0; 3]);
        within.look([-5, 0, 0], [0; 3]);
        let axis = AxisLetter(Axis::X);
        within.tell(&What::Home { line: 1, axis, ok: true, pos: 0 });
        within.tell(&end(Status::Done));
        assert_eq!(within.strayed(), None, "it was on the way to its switch");
        within.begin([0; 3]);
        within.look([-5, 0, 0], [0; 3]);
        within.tell(&end(Status::Fault));
        assert_eq!(within.strayed(), None, "it has found none");
    }
}
