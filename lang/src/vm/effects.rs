//! From an effect instruction and its arguments to an [`Effect`]: the one place where machine
//! statements leave the byte code.

use crate::axis::{Axis, AxisSet};
use crate::effect::{
    ActKind, Action, Center, Coord, Dist, Effect, Frame, Lead, Plane, Rate, Read, Sensor, Unit,
    Want,
};
use crate::isa::{Look, Op, SHORT_AXES, flags};
use crate::place::Target;
use crate::plain::{self, Plain};

/// Most arguments of an effect: an arc with three words and two offsets.
pub const MAX_ARGUMENTS: usize = 5;

/// Frames of an arc whose words are all relative.
pub const ALL_RELATIVE: u8 = 0b10_10_10;

/// Arguments in the order in which they were pushed.
struct Arguments([i32; MAX_ARGUMENTS], usize);

impl Arguments {
    fn next(&mut self) -> i32 {
        let value = self.0.get(self.1).copied().unwrap_or(0);
        self.1 += 1;
        value
    }

    fn next_if(&mut self, present: bool) -> Option<i32> {
        present.then(|| self.next())
    }

    fn dist(&mut self, steps: bool) -> Dist {
        if steps { Dist::Steps(self.next()) } else { Dist::Um(self.next()) }
    }

    fn rate(&mut self, present: bool, steps: bool) -> Option<Rate> {
        let value = self.next_if(present)?;
        Some(if steps { Rate::Steps(value) } else { Rate::Um(value) })
    }

    fn words(
        &mut self,
        axes: AxisSet,
        mut word: impl FnMut(usize) -> Option<(bool, Frame)>,
    ) -> Option<[Option<Coord>; 3]> {
        let mut to = [None; 3];
        for axis in Axis::ALL {
            if axes.contains(axis) {
                let (steps, frame) = word(axis.index())?;
                to[axis.index()] = Some(Coord { value: self.dist(steps), frame });
            }
        }
        Some(to)
    }
}

fn axis(bits: u8) -> Option<Axis> {
    Axis::from_index(usize::from(bits & flags::AXIS))
}

/// `Some(None)` is all axes.
fn axis_or_all(bits: u8) -> Option<Option<Axis>> {
    (bits <= flags::ALL_AXES).then(|| axis(bits))
}

fn frame(bits: u8) -> Option<Frame> {
    match bits & 3 {
        Target::WORK => Some(Frame::Work),
        Target::MACHINE => Some(Frame::Machine),
        Target::RELATIVE => Some(Frame::Relative),
        _ => None,
    }
}

fn frames(byte: u8, axis: usize) -> Option<Frame> {
    frame(byte >> (2 * axis))
}

fn plane(bits: u8) -> Option<Plane> {
    match bits >> flags::PLANE {
        0 => Some(Plane::Xy),
        1 => Some(Plane::Zx),
        2 => Some(Plane::Yz),
        _ => None,
    }
}

/// Axes of a plane in ascending order.
pub const fn plane_axes(plane: Plane) -> [Axis; 2] {
    match plane {
        Plane::Xy => [Axis::X, Axis::Y],
        Plane::Zx => [Axis::X, Axis::Z],
        Plane::Yz => [Axis::Y, Axis::Z],
    }
}

fn want(bits: u8) -> Want {
    match bits & 3 {
        0 => Want::Off,
        1 => Want::On,
        2 => Want::Fall,
        _ => Want::Rise,
    }
}

fn read(byte: u8) -> Option<Read> {
    const POS: u8 = Look::Pos as u8;
    const POS_STEPS: u8 = Look::PosSteps as u8;
    const PROBED: u8 = Look::Probed as u8;
    const PROBED_STEPS: u8 = Look::ProbedSteps as u8;
    const PROBE_OK: u8 = Look::ProbeOk as u8;
    const MOVING: u8 = Look::Moving as u8;
    const HOMED: u8 = Look::Homed as u8;
    const IN_PORT: u8 = Look::InPort as u8;
    const TIMER: u8 = Look::Timer as u8;
    const CHAR_IN: u8 = Look::CharIn as u8;
    if byte >> 2 == Look::Analog as u8 {
        return Some(Read::Analog((byte & flags::AXIS) + 1));
    }
    let axis = axis(byte)?;
    Some(match byte >> 2 {
        POS => Read::Pos(axis),
        POS_STEPS => Read::PosSteps(axis),
        PROBED => Read::Probed(axis),
        PROBED_STEPS => Read::ProbedSteps(axis),
        PROBE_OK => Read::ProbeOk(axis),
        MOVING => Read::Moving(axis),
        HOMED => Read::Homed(axis),
        IN_PORT => Read::InPort,
        TIMER => Read::Timer,
        CHAR_IN => Read::CharIn,
        _ => return None,
    })
}

/// The effect of an instruction.
///
/// `operands` are the bytes behind the code (missing ones count as 0), `arguments` its values in
/// the order in which they were pushed. `None`: the flags have no meaning; the verifier refuses
/// such an image.
pub fn decode(code: u8, operands: [u8; 3], arguments: [i32; MAX_ARGUMENTS]) -> Option<Effect> {
    let (op, n) = Op::decode(code)?;
    let [b, b2, b3] = operands;
    let mut args = Arguments(arguments, 0);
    if let Some(statement) = Plain::of(op) {
        let mut values = [0; plain::MOST];
        for value in values.iter_mut().take(statement.arguments().len()) {
            *value = args.next();
        }
        return Some(Effect::Plain(statement, values));
    }
    Some(match op {
        Op::OutShort => Effect::Plain(Plain::SetOut, [i32::from(n >> 1) + 1, (n & 1).into()]),
        Op::MoveTo | Op::MoveBy => move_axe(n, relative_if(op == Op::MoveBy), 0, args)?,
        Op::Move => move_axe(b, b, 0, args)?,
        Op::MoveRamp => move_axe(b, b, b2, args)?,
        Op::Rapid | Op::Line => Effect::Linear {
            rapid: op == Op::Rapid,
            to: args.words(*SHORT_AXES.get(usize::from(n))?, |_| Some((false, Frame::Work)))?,
            exact: false,
        },
        Op::Linear => Effect::Linear {
            rapid: b & flags::RAPID != 0,
            to: args.words(AxisSet(b & flags::AXES), |_| {
                Some((b & flags::COMMON_STEPS != 0, frame(b >> flags::COMMON_FRAME)?))
            })?,
            exact: b & flags::EXACT != 0,
        },
        Op::LinearMixed => Effect::Linear {
            rapid: b & flags::RAPID != 0,
            to: args.words(AxisSet(b & flags::AXES), |axis| {
                Some((b >> (5 + axis) & 1 != 0, frames(b2, axis)?))
            })?,
            exact: b & flags::EXACT != 0,
        },
        Op::Arc => arc(b, 0, 0, args)?,
        Op::ArcBy => arc(b, ALL_RELATIVE, 0, args)?,
        Op::ArcMixed => arc(b, b2, b3, args)?,
        Op::Sync => {
            let (n, value, lead) = (args.next(), args.next(), args.next());
            Effect::Sync(Action {
                n,
                act: ActKind::of(b).with(value),
                lead: if b & flags::LEAD_TIME != 0 { Lead::Time(lead) } else { Lead::Way(lead) },
            })
        }
        Op::SetAout => Effect::SetAout { n: args.next(), value: args.next() },
        Op::Feed => Effect::SetFeed(Rate::Um(args.next())),
        Op::FeedSteps => Effect::SetFeed(Rate::Steps(args.next())),
        Op::Spindle => Effect::SetSpindle(args.next()),
        Op::Home => Effect::Home { axis: axis(n)?, query: false },
        Op::HomeQuery => Effect::Home { axis: axis(b)?, query: true },
        Op::Probe => probe(b, b2, args)?,
        Op::SetPos => Effect::SetPos { axis: axis(b)?, value: args.next() },
        Op::MoveSpeed => {
            let speed = args.rate(true, b & flags::STEPS != 0)?;
            Effect::MoveSpeed { axis: axis(b)?, speed }
        }
        Op::StopAxe => Effect::StopAxe(axis(b)?),
        Op::WaitMove => Effect::WaitMove(axis_or_all(b)?),
        Op::Motors => Effect::Motors { on: args.next() != 0, axis: axis_or_all(b)? },
        Op::WaitIn => {
            let n = match args.next_if(b & flags::INPUT_ON_STACK != 0) {
                Some(n) => n,
                None => i32::from(b >> flags::INPUT) + 1,
            };
            let want = match args.next_if(b & flags::LEVEL != 0) {
                None => want(b),
                Some(0) => Want::Off,
                Some(_) => Want::On,
            };
            let timeout = args.next_if(b & flags::TIMEOUT != 0);
            Effect::WaitIn { n, want, timeout, query: b & flags::WAIT_QUERY != 0 }
        }
        Op::WaitChar => Effect::WaitChar {
            c: args.next(),
            timeout: args.next_if(b & flags::TIMEOUT != 0),
            query: b & flags::WAIT_QUERY != 0,
        },
        Op::PrintText => Effect::PrintText(u16::from(b)),
        Op::PrintTextFar => Effect::PrintText(u16::from_le_bytes([b, b2])),
        Op::Run => Effect::Run(u16::from_le_bytes([b, b2])),
        Op::PrintNumber => Effect::PrintValue(args.next(), Unit::None),
        Op::PrintEnd => Effect::PrintEnd,
        Op::Event => event(b, args)?,
        Op::SetPosZero => Effect::SetPos { axis: axis(n)?, value: 0 },
        Op::InShort => Effect::Read(Read::In(i32::from(n) + 1)),
        Op::TimedOut => Effect::Read(Read::TimedOut),
        Op::In => Effect::Read(Read::In(args.next())),
        Op::Out => Effect::Read(Read::Out(args.next())),
        Op::Read => Effect::Read(read(b)?),
        _ => return None,
    })
}

const fn relative_if(relative: bool) -> u8 {
    if relative { flags::RELATIVE } else { 0 }
}

fn move_axe(axis_bits: u8, b: u8, b2: u8, mut args: Arguments) -> Option<Effect> {
    let relative = b & flags::RELATIVE != 0;
    let frame = if relative { Frame::Relative } else { Frame::Work };
    let to = Coord { value: args.dist(b & flags::STEPS != 0), frame };
    Some(Effect::MoveAxe {
        axis: axis(axis_bits)?,
        to,
        speed: args.rate(b & flags::SPEED != 0, b & flags::SPEED_STEPS != 0),
        accel: args.rate(b2 & flags::ACCEL != 0, b2 & flags::ACCEL_STEPS != 0),
        decel: args.rate(b2 & flags::DECEL != 0, b2 & flags::DECEL_STEPS != 0),
        wait: b & flags::START == 0,
    })
}

fn arc(b: u8, b2: u8, b3: u8, mut args: Arguments) -> Option<Effect> {
    let plane = plane(b)?;
    let to = args
        .words(AxisSet(b & flags::AXES), |axis| Some((b3 >> axis & 1 != 0, frames(b2, axis)?)))?;
    let center = if b & flags::OFFSETS != 0 {
        let mut offsets = [Dist::Um(0); 3];
        for axis in plane_axes(plane) {
            offsets[axis.index()] = args.dist(b3 >> (3 + axis.index()) & 1 != 0);
        }
        Center::Offsets(offsets)
    } else {
        Center::Radius(args.dist(b3 >> 3 & 1 != 0))
    };
    let clockwise = b & flags::CLOCKWISE != 0;
    Some(Effect::Arc { clockwise, plane, to, center, exact: b & flags::EXACT != 0 })
}

fn probe(b: u8, b2: u8, mut args: Arguments) -> Option<Effect> {
    let limit =
        Coord { value: args.dist(b & flags::STEPS != 0), frame: frame(b >> flags::PROBE_FRAME)? };
    let speed = args.rate(b & flags::SPEED != 0, b & flags::SPEED_STEPS != 0);
    const INPUT: u8 = flags::SENSOR;
    const MASK: u8 = flags::SENSOR | flags::MASK;
    let sensor = match b2 {
        0 => Sensor::Default,
        INPUT => Sensor::Input { n: args.next(), on: args.next() != 0 },
        MASK => Sensor::Mask { and: args.next(), xor: args.next() },
        _ => return None,
    };
    Some(Effect::Probe { axis: axis(b)?, limit, speed, sensor, query: b & flags::QUERY != 0 })
}

fn event(b: u8, mut args: Arguments) -> Option<Effect> {
    let slot = b & 3;
    Some(match b & !3 {
        flags::ON_RISE => Effect::OnInput { slot, n: args.next(), want: Want::Rise },
        flags::ON_FALL => Effect::OnInput { slot, n: args.next(), want: Want::Fall },
        flags::ON_EVERY => Effect::OnEvery { slot, ms: args.next() },
        flags::OFF_INPUT => Effect::OffInput(args.next()),
        flags::OFF_EVERY => Effect::OffEvery,
        _ => return None,
    })
}
