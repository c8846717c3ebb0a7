//! Pieces of the path of a run, for plots: a block of the path is one, and what an axis does on its own up to where it
//! turns round or rests.

use std::collections::VecDeque;

use lang::axis::Axis;
use lang::effect::{Center, Dist, Effect};
use lang::profile::Profile;

use crate::sim::log::Log;
use crate::sim::record::{ArcShape, Segment, SegmentKind};
use crate::sim::trace::{MoveKind, What};
use desk::board::NativeBoard;

/// A block that was asked for and has not begun.
#[derive(Clone, Copy, Debug)]
struct Announced {
    line: u32,
    power: Option<i32>,
    /// Plane, direction and centre of an arc.
    arc: Option<(bool, lang::effect::Plane, Center)>,
}

/// An axis on its own that moves.
#[derive(Clone, Copy, Debug)]
struct Solo {
    number: Option<usize>,
    /// Where it was at the last look, and in which direction it went, if it has gone.
    at: i32,
    negative: Option<bool>,
}

/// See the module.
#[derive(Debug, Default)]
pub struct Pieces {
    announced: VecDeque<Announced>,
    /// Number in the record of the block that plays.
    path: Option<usize>,
    solo: [Option<Solo>; 3],
    /// Where each axis stood when it was last seen not to move on its own, steps.
    stood: [i32; 3],
    /// What an axis does that moves on its own, and whose doing it is.
    doing: Option<(SegmentKind, u32)>,
    /// Commanded places of the last block, steps.
    commanded: Option<[i32; 3]>,
}

fn positions(board: &NativeBoard) -> [i32; 3] {
    [0, 1, 2].map(|n| board.desk().counted(n))
}

impl Pieces {
    /// An effect is about to begin.
    pub fn announce(&mut self, effect: &Effect, line: u32, board: &NativeBoard, profile: &Profile) {
        let kind = match effect {
            Effect::Home { .. } => SegmentKind::Home,
            Effect::Probe { .. } => SegmentKind::Probe,
            Effect::MoveAxe { .. } => SegmentKind::Move(MoveKind::Axe),
            Effect::MoveSpeed { .. } => SegmentKind::Speed,
            Effect::Linear { rapid, .. } => {
                let power = light(board, profile).map(|power| if *rapid { 0 } else { power });
                self.announced.push_back(Announced { line, power, arc: None });
                return;
            }
            Effect::Arc { clockwise, plane, center, .. } => {
                let (power, arc) = (light(board, profile), Some((*clockwise, *plane, *center)));
                self.announced.push_back(Announced { line, power, arc });
                return;
            }
            _ => return,
        };
        self.doing = Some((kind, line));
    }

    /// The machine told this at a time, us.
    pub fn event(&mut self, us: u64, _pc: u16, what: &What, board: &NativeBoard, log: &mut Log) {
        let What::Move { line, kind, to } = what else { return };
        if *kind == MoveKind::Axe {
            return;
        }
        let from = self.commanded.unwrap_or_else(|| positions(board));
        let to = [0, 1, 2].map(|i: usize| to.get(Axis::ALL[i]).unwrap_or(from[i]));
        self.commanded = Some(to);
        // Those before it were of no length.
        let mut own = None;
        while let Some(next) = self.announced.pop_front() {
            own = Some(next);
            if next.line == *line {
                break;
            }
        }
        self.end_path(us, log);
        let arc = own.and_then(|own| own.arc);
        let segment = Segment {
            kind: SegmentKind::Move(*kind),
            line: *line,
            from,
            to,
            axes: [0, 1, 2].map(|i: usize| arc.is_some() || from[i] != to[i]),
            arc: arc.and_then(|arc| shape(board, from, to, arc)),
            start_us: us,
            end_us: us,
            peak_rate: 0.0,
            exit_speed: None,
            power: own.and_then(|own| own.power),
        };
        board.desk().forget_rate();
        self.path = log.begin_segment(segment);
    }

    /// How things stand at a time, us.
    pub fn look(&mut self, us: u64, board: &NativeBoard, log: &mut Log) {
        let motor = &board.controller().motor;
        let at = positions(board);
        if !motor.path_rests() {
            self.stood = at;
            if let Some(segment) = log.segment(self.path) {
                let rate = board.desk().top_rate();
                segment.peak_rate = segment.peak_rate.max(rate);
            }
            return;
        }
        if self.path.is_some() {
            self.end_path(us, log);
            self.path = None;
        }
        self.commanded = None;
        for n in 0..3 {
            self.look_at_axis(n, us, at, board, log);
        }
    }

    fn look_at_axis(
        &mut self,
        n: usize,
        us: u64,
        at: [i32; 3],
        board: &NativeBoard,
        log: &mut Log,
    ) {
        let moves = board.controller().motor.moves(n as u8);
        let Some(solo) = &mut self.solo[n] else {
            if let (true, Some((kind, line))) = (moves, self.doing) {
                let mut from = at;
                from[n] = self.stood[n];
                self.solo[n] = Some(begin(n, kind, line, us, from, log));
            } else {
                self.stood[n] = at[n];
            }
            return;
        };
        let way = at[n].wrapping_sub(solo.at);
        let turned = way != 0 && solo.negative.is_some_and(|negative| (way < 0) != negative);
        if way != 0 {
            solo.negative = Some(way < 0);
        }
        if let Some(segment) = log.segment(solo.number) {
            if !turned {
                segment.to[n] = at[n];
            }
            let rate = f64::from(board.controller().motor.velocity(n as u8)).abs();
            segment.peak_rate = segment.peak_rate.max(rate);
            segment.end_us = us;
        }
        solo.at = at[n];
        if !moves {
            self.solo[n] = None;
            self.stood[n] = at[n];
        } else if turned {
            let (kind, line) = self.doing.unwrap_or((SegmentKind::Speed, 1));
            self.solo[n] = Some(begin(n, kind, line, us, at, log));
            if let Some(solo) = &mut self.solo[n] {
                solo.negative = Some(way < 0);
            }
        }
    }

    fn end_path(&mut self, us: u64, log: &mut Log) {
        if let Some(segment) = log.segment(self.path) {
            segment.end_us = us;
        }
    }

    /// The run is over: what still counts as under way has ended where the axes are.
    pub fn close(&mut self, us: u64, board: &NativeBoard, log: &mut Log) {
        self.end_path(us, log);
        let at = positions(board);
        if let Some(segment) = log.segment(self.path.take())
            && segment.arc.is_none()
        {
            segment.to = at;
        }
        for (n, (solo, at)) in self.solo.iter_mut().zip(at).enumerate() {
            if let Some(solo) = solo.take()
                && let Some(segment) = log.segment(solo.number)
            {
                (segment.to[n], segment.end_us) = (at, us);
            }
        }
    }
}

fn begin(n: usize, kind: SegmentKind, line: u32, us: u64, at: [i32; 3], log: &mut Log) -> Solo {
    let mut axes = [false; 3];
    axes[n] = true;
    let number = log.begin_segment(Segment {
        kind,
        line,
        from: at,
        to: at,
        axes,
        arc: None,
        start_us: us,
        end_us: us,
        peak_rate: 0.0,
        exit_speed: None,
        power: None,
    });
    Solo { number, at: at[n], negative: None }
}

/// Power of the laser in what moves next, if the machine has one.
fn light(board: &NativeBoard, profile: &Profile) -> Option<i32> {
    let laser = profile.laser()?;
    let controller = board.controller();
    let on = controller.io.outputs >> (laser - 1) & 1 != 0;
    Some(if on { controller.motor.power.into() } else { 0 })
}

/// The arc between two places, steps, as plots show it.
fn shape(
    board: &NativeBoard,
    from: [i32; 3],
    to: [i32; 3],
    (clockwise, plane, center): (bool, lang::effect::Plane, Center),
) -> Option<ArcShape> {
    let motor = &board.controller().motor;
    let um = |place: [i32; 3]| {
        [0, 1, 2].map(|n: usize| motor.convert(n as u8, place[n], false).unwrap_or_default())
    };
    let (from_um, to_um, axes) = (um(from), um(to), plane.axes());
    let ends = firmware::motion::Ends {
        first: axes[0].index() as u8,
        clockwise,
        from_um,
        to_um,
        start: from,
        end: to,
    };
    let length = |dist: Dist, axis: Axis| match dist {
        Dist::Um(um) => um,
        Dist::Steps(steps) => motor.convert(axis.index() as u8, steps, false).unwrap_or_default(),
    };
    let arc = match center {
        Center::Offsets(offsets) => {
            ends.around(axes.map(|axis| length(offsets[axis.index()], axis)))
        }
        Center::Radius(radius) => ends.with_radius(length(radius, axes[0])),
    };
    let arc = arc.ok()?;
    let [a, b, c] = arc.axes();
    let mut middle = [0.0; 3];
    middle[a] = f64::from(arc.center[0]);
    middle[b] = f64::from(arc.center[1]);
    middle[c] = f64::from(from_um[c]);
    let start = f64::from(arc.from[1]).atan2(f64::from(arc.from[0]));
    let sweep = f64::from(arc.sweep) / 4_294_967_296.0 * std::f64::consts::TAU;
    Some(ArcShape {
        center: middle,
        plane: [Axis::ALL[a], Axis::ALL[b]],
        start,
        sweep: if arc.clockwise { -sweep } else { sweep },
    })
}
