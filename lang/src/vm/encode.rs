//! From an [`Effect`] to its instruction: the inverse of [`effects`](super::effects).
//!
//! A caller that runs a program without an image hands the machine its statements one by one in this form.

use super::effects::{MAX_ARGUMENTS, plane_axes};
use crate::axis::Axis;
use crate::effect::{Action, Center, Coord, Dist, Effect, Frame, Lead, Rate, Read, Sensor, Want};
use crate::isa::{Look, Op, flags};

/// An effect's instruction: its code with the bytes after it, and the values that it takes from the stack.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Encoded {
    code: [u8; 4],
    length: usize,
    values: [i32; MAX_ARGUMENTS],
    count: usize,
}

impl Encoded {
    /// An instruction with these bytes after its code.
    fn new(op: Op, operands: &[u8]) -> Encoded {
        let mut own = Encoded { length: 1 + operands.len(), ..Encoded::default() };
        own.code[0] = op.code();
        own.code[1..own.length].copy_from_slice(operands);
        own
    }

    /// The same with one more value, which is pushed last.
    fn with(mut self, value: i32) -> Encoded {
        if let Some(place) = self.values.get_mut(self.count) {
            *place = value;
            self.count += 1;
        }
        self
    }

    fn with_all(self, values: impl IntoIterator<Item = i32>) -> Encoded {
        values.into_iter().fold(self, Encoded::with)
    }

    /// The instruction's bytes.
    pub fn code(&self) -> &[u8] {
        &self.code[..self.length]
    }

    /// Its values in the order in which they are pushed.
    pub fn values(&self) -> &[i32] {
        &self.values[..self.count]
    }
}

fn number(axis: Axis) -> u8 {
    axis.index() as u8
}

fn dist(dist: Dist) -> (i32, bool) {
    match dist {
        Dist::Um(value) => (value, false),
        Dist::Steps(value) => (value, true),
    }
}

fn rate(rate: Rate) -> (i32, bool) {
    match rate {
        Rate::Um(value) => (value, false),
        Rate::Steps(value) => (value, true),
    }
}

/// Bits of a rate that there may be, and its value.
fn rated(own: Option<Rate>, present: u8, steps: u8) -> (u8, Option<i32>) {
    match own.map(rate) {
        None => (0, None),
        Some((value, false)) => (present, Some(value)),
        Some((value, true)) => (present | steps, Some(value)),
    }
}

/// Axes that have words, which of these are in steps, their frames with two bits each, and their values.
fn words(to: &[Option<Coord>; 3]) -> (u8, u8, u8, impl Iterator<Item = i32>) {
    let (mut axes, mut steps, mut frames) = (0, 0, 0);
    for (axis, word) in to.iter().enumerate() {
        let Some(word) = word else { continue };
        axes |= 1 << axis;
        steps |= u8::from(dist(word.value).1) << axis;
        frames |= (word.frame as u8) << (2 * axis);
    }
    (axes, steps, frames, to.iter().flatten().map(|word| dist(word.value).0))
}

/// The instruction of an effect in its general form; `None` for what is no instruction of its own: the parts of PRINT
/// that are texts, RUN, and what only engines tell one another.
pub fn encode(effect: &Effect) -> Option<Encoded> {
    Some(match *effect {
        Effect::Plain(statement, values) => {
            let count = statement.arguments().len();
            Encoded::new(statement.op(), &[]).with_all(values.into_iter().take(count))
        }
        Effect::Sync(Action { n, act, lead }) => {
            let (kind, value) = act.parts();
            let (lead, time) = match lead {
                Lead::Way(um) => (um, 0),
                Lead::Time(ms) => (ms, flags::LEAD_TIME),
            };
            Encoded::new(Op::Sync, &[kind.flag() | time]).with_all([n, value, lead])
        }
        Effect::SetAout { n, value } => Encoded::new(Op::SetAout, &[]).with_all([n, value]),
        Effect::MoveAxe { axis, to, speed, accel, decel, wait } => {
            let (target, steps) = dist(to.value);
            let (speed_bits, speed) = rated(speed, flags::SPEED, flags::SPEED_STEPS);
            let (accel_bits, accel) = rated(accel, flags::ACCEL, flags::ACCEL_STEPS);
            let (decel_bits, decel) = rated(decel, flags::DECEL, flags::DECEL_STEPS);
            let mut bits = number(axis) | speed_bits;
            bits |= if steps { flags::STEPS } else { 0 };
            bits |= if to.frame == Frame::Relative { flags::RELATIVE } else { 0 };
            bits |= if wait { 0 } else { flags::START };
            let ramps = accel_bits | decel_bits;
            let own = match ramps {
                0 => Encoded::new(Op::Move, &[bits]),
                _ => Encoded::new(Op::MoveRamp, &[bits, ramps]),
            };
            own.with(target).with_all(speed).with_all(accel).with_all(decel)
        }
        Effect::MoveSpeed { axis, speed } => {
            let (value, steps) = rate(speed);
            let bits = number(axis) | if steps { flags::STEPS } else { 0 };
            Encoded::new(Op::MoveSpeed, &[bits]).with(value)
        }
        Effect::StopAxe(axis) => Encoded::new(Op::StopAxe, &[number(axis)]),
        Effect::WaitMove(axis) => {
            Encoded::new(Op::WaitMove, &[axis.map_or(flags::ALL_AXES, number)])
        }
        Effect::Linear { rapid, to, exact } => {
            let (axes, steps, frames, values) = words(&to);
            let mut bits = axes | steps << 5;
            bits |= if rapid { flags::RAPID } else { 0 };
            bits |= if exact { flags::EXACT } else { 0 };
            Encoded::new(Op::LinearMixed, &[bits, frames]).with_all(values)
        }
        Effect::Arc { clockwise, plane, to, center, exact } => {
            let (axes, mut steps, frames, values) = words(&to);
            let mut bits = axes | (plane as u8) << flags::PLANE;
            bits |= if clockwise { flags::CLOCKWISE } else { 0 };
            bits |= if exact { flags::EXACT } else { 0 };
            let mut centre = [None; 2];
            match center {
                Center::Offsets(offsets) => {
                    bits |= flags::OFFSETS;
                    for (place, axis) in centre.iter_mut().zip(plane_axes(plane)) {
                        let (value, in_steps) = dist(offsets[axis.index()]);
                        steps |= u8::from(in_steps) << (3 + axis.index());
                        *place = Some(value);
                    }
                }
                Center::Radius(radius) => {
                    let (value, in_steps) = dist(radius);
                    steps |= u8::from(in_steps) << 3;
                    centre[0] = Some(value);
                }
            }
            let own = Encoded::new(Op::ArcMixed, &[bits, frames, steps]).with_all(values);
            own.with_all(centre.into_iter().flatten())
        }
        Effect::SetFeed(Rate::Um(value)) => Encoded::new(Op::Feed, &[]).with(value),
        Effect::SetFeed(Rate::Steps(value)) => Encoded::new(Op::FeedSteps, &[]).with(value),
        Effect::SetSpindle(value) => Encoded::new(Op::Spindle, &[]).with(value),
        Effect::Home { axis, query: true } => Encoded::new(Op::HomeQuery, &[number(axis)]),
        Effect::Home { axis, query: false } => {
            let mut own = Encoded::new(Op::Home, &[]);
            own.code[0] += number(axis);
            own
        }
        Effect::Probe { axis, limit, speed, sensor, query } => {
            let (value, steps) = dist(limit.value);
            let (speed_bits, speed) = rated(speed, flags::SPEED, flags::SPEED_STEPS);
            let mut bits = number(axis) | (limit.frame as u8) << flags::PROBE_FRAME | speed_bits;
            bits |= if steps { flags::STEPS } else { 0 };
            bits |= if query { flags::QUERY } else { 0 };
            let (sensor_bits, pair) = match sensor {
                Sensor::Default => (0, None),
                Sensor::Input { n, on } => (flags::SENSOR, Some([n, on.into()])),
                Sensor::Mask { and, xor } => (flags::SENSOR | flags::MASK, Some([and, xor])),
            };
            let own = Encoded::new(Op::Probe, &[bits, sensor_bits]).with(value).with_all(speed);
            own.with_all(pair.into_iter().flatten())
        }
        Effect::SetPos { axis, value } => Encoded::new(Op::SetPos, &[number(axis)]).with(value),
        Effect::Motors { on, axis } => {
            let bits = axis.map_or(flags::ALL_AXES, number);
            Encoded::new(Op::Motors, &[bits]).with(on.into())
        }
        Effect::WaitIn { n, want, timeout, query } => {
            let mut bits = want as u8 | flags::INPUT_ON_STACK;
            bits |= if timeout.is_some() { flags::TIMEOUT } else { 0 };
            bits |= if query { flags::WAIT_QUERY } else { 0 };
            Encoded::new(Op::WaitIn, &[bits]).with(n).with_all(timeout)
        }
        Effect::WaitChar { c, timeout, query } => {
            let mut bits = if timeout.is_some() { flags::TIMEOUT } else { 0 };
            bits |= if query { flags::WAIT_QUERY } else { 0 };
            Encoded::new(Op::WaitChar, &[bits]).with(c).with_all(timeout)
        }
        Effect::PrintValue(value, _) => Encoded::new(Op::PrintNumber, &[]).with(value),
        Effect::PrintEnd => Encoded::new(Op::PrintEnd, &[]),
        Effect::OnInput { slot, n, want } => {
            let kind = if want == Want::Rise { flags::ON_RISE } else { flags::ON_FALL };
            Encoded::new(Op::Event, &[slot | kind]).with(n)
        }
        Effect::OnEvery { slot, ms } => Encoded::new(Op::Event, &[slot | flags::ON_EVERY]).with(ms),
        Effect::OffInput(n) => Encoded::new(Op::Event, &[flags::OFF_INPUT]).with(n),
        Effect::OffEvery => Encoded::new(Op::Event, &[flags::OFF_EVERY]),
        Effect::Read(read) => look(read),
        Effect::PrintText(_)
        | Effect::Run(_)
        | Effect::EnterHandler
        | Effect::LeaveHandler
        | Effect::Keep { .. } => return None,
    })
}

fn look(read: Read) -> Encoded {
    let of = |look: Look, axis: u8| Encoded::new(Op::Read, &[(look as u8) << 2 | axis]);
    match read {
        Read::In(n) => Encoded::new(Op::In, &[]).with(n),
        Read::Out(n) => Encoded::new(Op::Out, &[]).with(n),
        Read::TimedOut => Encoded::new(Op::TimedOut, &[]),
        Read::InPort => of(Look::InPort, 0),
        Read::Timer => of(Look::Timer, 0),
        Read::CharIn => of(Look::CharIn, 0),
        Read::Analog(n) => of(Look::Analog, n.wrapping_sub(1) & flags::AXIS),
        Read::Pos(axis) => of(Look::Pos, number(axis)),
        Read::PosSteps(axis) => of(Look::PosSteps, number(axis)),
        Read::Probed(axis) => of(Look::Probed, number(axis)),
        Read::ProbedSteps(axis) => of(Look::ProbedSteps, number(axis)),
        Read::ProbeOk(axis) => of(Look::ProbeOk, number(axis)),
        Read::Moving(axis) => of(Look::Moving, number(axis)),
        Read::Homed(axis) => of(Look::Homed, number(axis)),
    }
}

#[cfg(test)]
mod tests {
    use super::encode;
    use crate::isa;
    use crate::vm::effects::{MAX_ARGUMENTS, decode};

    /// Every effect instruction, with every byte of flags that means something, comes back as it was.
    #[test]
    fn an_effect_is_decoded_as_it_was_encoded() {
        let arguments: [i32; MAX_ARGUMENTS] = [7, -4_000_000, 1, 90_001, 0];
        let mut count = 0;
        for code in isa::EFFECTS..=u8::MAX {
            for (b, b2, b3) in (0..=255).flat_map(|b| {
                let seconds = [0, 1, 2, 3, 5, 7, 9, 15, 0b10_01_00, 0b10_10_10];
                seconds.into_iter().flat_map(move |b2| [0, 9, 0x2A, 0x3F].map(|b3| (b, b2, b3)))
            }) {
                let Some(effect) = decode(code, [b, b2, b3], arguments) else { continue };
                let Some(own) = encode(&effect) else { continue };
                let mut operands = [0; 3];
                let bytes = &own.code()[1..];
                operands[..bytes.len()].copy_from_slice(bytes);
                let mut values = [0; MAX_ARGUMENTS];
                values[..own.values().len()].copy_from_slice(own.values());
                let again = decode(own.code()[0], operands, values);
                assert_eq!(again, Some(effect), "{code:02X} {b:02X} {b2:02X} {b3:02X}");
                let pops = isa::shape(own.code()[0]).unwrap().pops();
                let more = isa::arguments(own.code()[0], operands[0], operands[1]);
                assert_eq!(usize::from(pops + more), own.values().len(), "{effect:?}");
                count += 1;
            }
        }
        assert!(count > 10_000, "{count}");
    }
}
