//! Interpolated moves: G0 to G3.

use firmware::motion::path::{Block, Feed};
use lang::axis::Axis;
use lang::effect::{Center, Coord, Dist, Plane, Rate};
use lang::fault::Fault;

use super::Machine;
use super::axes::Place;
use crate::sim::record::{ArcShape, Segment, SegmentKind};
use crate::sim::trace::{MoveKind, What};

/// How far a chord may leave its arc, um.
const CHORD_UM: f64 = 5.0;

impl Machine {
    /// Waits for the path's end.
    pub(super) fn sync_path(&mut self) {
        if self.motion.is_path_idle() {
            return;
        }
        self.next = 0;
        while self.halt.is_none() && !self.motion.is_path_idle() && self.tick(None) {}
    }

    /// The commanded places with the words applied, and within the travel.
    fn goal(&self, words: &[Option<Coord>; 3]) -> Result<[Place; 3], Fault> {
        let mut goal = Axis::ALL.map(|axis| self.axes.place(axis));
        for axis in Axis::ALL {
            if let Some(word) = words[axis.index()] {
                goal[axis.index()] = self.axes.resolve(axis, word, goal[axis.index()])?;
            }
        }
        for axis in Axis::ALL {
            if words[axis.index()].is_some() {
                self.axes.check_travel(axis, goal[axis.index()].um)?;
            }
        }
        Ok(goal)
    }

    /// A move that joins no path waits until all axes rest.
    fn before_path(&mut self, joins: bool) -> Result<(), Fault> {
        if joins && !self.motion.is_path_idle() {
            return Ok(());
        }
        self.sync_path();
        if Axis::ALL.into_iter().any(|axis| self.axes.is_running(axis)) {
            return Err(Fault::ValueRange);
        }
        self.next = 0;
        while self.halt.is_none() && !self.all_rest() && self.tick(None) {}
        Ok(())
    }

    fn programmed_feed(&self) -> Result<Feed, Fault> {
        match self.feed {
            Some(Rate::Um(um)) => Ok(Feed::Um(um.unsigned_abs())),
            Some(Rate::Steps(steps)) => Ok(Feed::Steps(steps.unsigned_abs())),
            None => match self.profile.default_feed_um_s {
                Some(um) => Ok(Feed::Um(um.unsigned_abs())),
                None => Err(Fault::SpeedRange),
            },
        }
    }

    /// G0 and G1.
    pub(super) fn linear(
        &mut self,
        rapid: bool,
        words: &[Option<Coord>; 3],
        exact: bool,
    ) -> Result<(), Fault> {
        self.before_path(!rapid)?;
        if self.halt.is_some() {
            return Ok(());
        }
        let goal = self.goal(words)?;
        let feed = if rapid { Feed::Rapid } else { self.programmed_feed()? };
        let kind = if rapid { MoveKind::Rapid } else { MoveKind::Line };
        let from = Axis::ALL.map(|axis| self.axes.steps(axis));
        let to = goal.map(|place| place.steps);
        self.command(&goal);
        if from == to {
            return Ok(());
        }
        let targets = self.targets();
        self.write(What::Move { line: self.line, kind, to: targets });
        let exact = exact || rapid;
        let mut legs = vec![to];
        let (up, down) = (self.z_leg(from, to, rapid), self.z_leg(to, from, rapid));
        if up {
            legs.insert(0, [from[0], from[1], to[2]]);
        } else if down {
            legs.insert(0, [to[0], to[1], from[2]]);
        }
        let mut at = from;
        for leg in legs {
            self.push_block(SegmentKind::Move(kind), at, leg, feed, exact, None);
            at = leg;
        }
        if exact {
            self.sync_path();
        }
        Ok(())
    }

    /// Whether a rapid lifts Z first on its way between the two (profile's `rapid_z_apart`).
    fn z_leg(&self, from: [i32; 3], to: [i32; 3], rapid: bool) -> bool {
        let Some(z) = self.profile.z.as_ref() else { return false };
        let up = i64::from(z.home.direction.sign());
        rapid
            && self.profile.rapid_z_apart
            && (from[0], from[1]) != (to[0], to[1])
            && (i64::from(to[2]) - i64::from(from[2])) * up > 0
    }

    fn command(&mut self, goal: &[Place; 3]) {
        for axis in Axis::ALL {
            if self.axes.is_present(axis) {
                self.axes.command(axis, goal[axis.index()]);
            }
        }
    }

    /// Gives the path a block as soon as it takes one; `shape` is that of a whole arc, at its
    /// first chord.
    fn push_block(
        &mut self,
        kind: SegmentKind,
        from: [i32; 3],
        to: [i32; 3],
        feed: Feed,
        exact: bool,
        shape: Option<Option<Segment>>,
    ) {
        self.next = 0;
        while self.halt.is_none() && !self.motion.has_room() && self.tick(None) {}
        if self.halt.is_some() || from == to {
            return;
        }
        let steps = [0, 1, 2].map(|index: usize| to[index].wrapping_sub(from[index]));
        let piece = shape.unwrap_or(Some(Segment {
            kind,
            line: self.line,
            from,
            to,
            axes: steps.map(|steps| steps != 0),
            arc: None,
            start_us: self.now,
            end_us: self.now,
            peak_rate: 0.0,
        }));
        self.pieces.blocks.push_back(piece);
        self.motion.push(&Block { steps, feed, exact }, self.now);
        self.log_milestones();
        self.next = 0;
    }

    /// G2 and G3.
    pub(super) fn arc(
        &mut self,
        clockwise: bool,
        plane: Plane,
        words: &[Option<Coord>; 3],
        center: &Center,
        exact: bool,
    ) -> Result<(), Fault> {
        self.before_path(true)?;
        if self.halt.is_some() {
            return Ok(());
        }
        let goal = self.goal(words)?;
        let feed = self.programmed_feed()?;
        let start = Axis::ALL.map(|axis| self.axes.place(axis));
        let arc = self.geometry(clockwise, plane, &start, &goal, center)?;
        self.check_arc(&arc)?;
        self.command(&goal);
        let targets = self.targets();
        self.write(What::Move { line: self.line, kind: MoveKind::Arc, to: targets });
        let chords = arc.chords();
        let whole = Segment {
            kind: SegmentKind::Move(MoveKind::Arc),
            line: self.line,
            from: start.map(|place| place.steps),
            to: goal.map(|place| place.steps),
            axes: [true; 3],
            arc: Some(arc.shape),
            start_us: self.now,
            end_us: self.now,
            peak_rate: 0.0,
        };
        let mut at = whole.from;
        let mut first = Some(whole);
        for chord in 1..=chords {
            let to = if chord == chords {
                whole.to
            } else {
                let um = arc.at(f64::from(chord) / f64::from(chords));
                let mut to = at;
                for axis in Axis::ALL {
                    to[axis.index()] = self.axes.to_steps(axis, um[axis.index()].round() as i32)?;
                }
                to
            };
            if to != at {
                let stop = exact && chord == chords;
                self.push_block(whole.kind, at, to, feed, stop, Some(first.take()));
            }
            at = to;
        }
        if exact {
            self.sync_path();
        }
        Ok(())
    }

    fn geometry(
        &self,
        clockwise: bool,
        plane: Plane,
        start: &[Place; 3],
        goal: &[Place; 3],
        center: &Center,
    ) -> Result<Arc, Fault> {
        let axes = match plane {
            Plane::Xy => [Axis::X, Axis::Y, Axis::Z],
            Plane::Zx => [Axis::Z, Axis::X, Axis::Y],
            Plane::Yz => [Axis::Y, Axis::Z, Axis::X],
        };
        let [a, b, c] = axes.map(Axis::index);
        let um = |dist: Dist, axis: Axis| match dist {
            Dist::Um(um) => Ok(um),
            Dist::Steps(steps) => self.axes.length(axis, steps),
        };
        let p = [a, b].map(|i| f64::from(start[i].um));
        let q = [a, b].map(|i| f64::from(goal[i].um));
        let middle = match center {
            Center::Offsets(offsets) => [
                p[0] + f64::from(um(offsets[a], axes[0])?),
                p[1] + f64::from(um(offsets[b], axes[1])?),
            ],
            Center::Radius(radius) => {
                let radius = f64::from(um(*radius, axes[0])?);
                let chord = [q[0] - p[0], q[1] - p[1]];
                let length = chord[0].hypot(chord[1]);
                let height2 = radius * radius - length * length / 4.0;
                // Half the tolerance of an end that misses its circle.
                if length == 0.0 || height2 < -5.0 * radius.abs() {
                    return Err(Fault::Arc);
                }
                let side = if clockwise == (radius > 0.0) { 1.0 } else { -1.0 };
                let height = height2.max(0.0).sqrt() / length * side;
                [
                    f64::midpoint(p[0], q[0]) + chord[1] * height,
                    f64::midpoint(p[1], q[1]) - chord[0] * height,
                ]
            }
        };
        let radii = [
            (p[0] - middle[0]).hypot(p[1] - middle[1]),
            (q[0] - middle[0]).hypot(q[1] - middle[1]),
        ];
        let miss = (radii[0] - radii[1]).abs();
        if radii[0] < 0.5 || (miss > 5.0 && miss > radii[0] * 0.001) {
            return Err(Fault::Arc);
        }
        let from = (p[1] - middle[1]).atan2(p[0] - middle[0]);
        let to = (q[1] - middle[1]).atan2(q[0] - middle[0]);
        let turn = std::f64::consts::TAU;
        let mut sweep = to - from;
        if p == q {
            sweep = 0.0;
        }
        if clockwise && sweep >= 0.0 {
            sweep -= turn;
        } else if !clockwise && sweep <= 0.0 {
            sweep += turn;
        }
        let mut place = [0.0; 3];
        place[a] = middle[0];
        place[b] = middle[1];
        place[c] = f64::from(start[c].um);
        let shape = ArcShape { center: place, plane: [axes[0], axes[1]], start: from, sweep };
        Ok(Arc { shape, radii, rise: f64::from(goal[c].um) - f64::from(start[c].um), helix: c })
    }

    /// Soft limits at the end and at every extreme.
    fn check_arc(&self, arc: &Arc) -> Result<(), Fault> {
        let quarter = std::f64::consts::FRAC_PI_2;
        let (from, to) = if arc.shape.sweep < 0.0 {
            (arc.shape.start + arc.shape.sweep, arc.shape.start)
        } else {
            (arc.shape.start, arc.shape.start + arc.shape.sweep)
        };
        let mut angle = (from / quarter).ceil() * quarter;
        while angle < to {
            let t = (angle - arc.shape.start) / arc.shape.sweep;
            let at = arc.at(t);
            for axis in arc.shape.plane {
                self.axes.check_travel(axis, at[axis.index()].round() as i32)?;
            }
            angle += quarter;
        }
        Ok(())
    }
}

/// An arc in um.
struct Arc {
    shape: ArcShape,
    /// At the start and at the end.
    radii: [f64; 2],
    rise: f64,
    helix: usize,
}

impl Arc {
    /// The place at a fraction of the way.
    fn at(&self, t: f64) -> [f64; 3] {
        let angle = self.shape.start + self.shape.sweep * t;
        let radius = self.radii[0] + (self.radii[1] - self.radii[0]) * t;
        let mut at = self.shape.center;
        at[self.shape.plane[0].index()] += radius * angle.cos();
        at[self.shape.plane[1].index()] += radius * angle.sin();
        at[self.helix] += self.rise * t;
        at
    }

    /// Chords that stay within the tolerance.
    fn chords(&self) -> u32 {
        let radius = self.radii[0].max(CHORD_UM);
        let step = 2.0 * (1.0 - CHORD_UM / radius).clamp(-1.0, 1.0).acos();
        (self.shape.sweep.abs() / step.max(0.001)).ceil().clamp(4.0, 10_000.0) as u32
    }
}
