//! Machine statements.

use super::Lower;
use crate::axis::{Axis, AxisSet};
use crate::back::ir::{Cond, Item};
use crate::effect::{Frame, Plane, Want};
use crate::hir::{ArcCenter, Expr, ExprKind, InWant, PrintPart, ProbeSensor, StmtKind, Word};
use crate::isa::{Op, SHORT_AXES, flags};
use crate::kind::Kind;
use crate::plain::Plain;
use crate::record::feature;
use crate::show::Decimals;
use crate::vm::effects::plane_axes;

/// Whether a value is in steps, steps/s or steps/s2.
pub(super) fn steps(expr: &Expr) -> bool {
    matches!(expr.kind, Kind::Steps | Kind::StepRate | Kind::StepAccel)
}

const fn bit(set: bool, flag: u8) -> u8 {
    if set { flag } else { 0 }
}

fn constant(expr: &Expr) -> Option<i32> {
    match expr.node {
        ExprKind::Const(value) => Some(value),
        _ => None,
    }
}

impl Lower<'_> {
    pub(super) fn flags(&mut self, op: Op, bytes: [u8; 3]) {
        self.push(Item::Flags(op, bytes));
    }

    pub(super) fn machine(&mut self, kind: &StmtKind) {
        match kind {
            StmtKind::Plain(statement, values) => self.plain_statement(*statement, values),
            StmtKind::Sync(own) => {
                for value in [&own.n, &own.value, &own.lead] {
                    self.expr(value);
                }
                let time = bit(own.lead.kind == Kind::Time, flags::LEAD_TIME);
                self.flags(Op::Sync, [own.kind.flag() | time, 0, 0]);
            }
            StmtKind::SetAout(n, value) => self.with(&[n, value], Op::SetAout),
            StmtKind::OnInput { slot, n, want, target } => {
                self.handler(*slot, *target);
                self.expr(n);
                let kind = if *want == Want::Fall { flags::ON_FALL } else { flags::ON_RISE };
                self.flags(Op::Event, [kind | slot & 3, 0, 0]);
            }
            StmtKind::OffInput(n) => {
                self.expr(n);
                self.flags(Op::Event, [flags::OFF_INPUT, 0, 0]);
            }
            StmtKind::OnEvery { slot, every, target } => {
                self.handler(*slot, *target);
                self.expr(every);
                self.flags(Op::Event, [flags::ON_EVERY | slot & 3, 0, 0]);
            }
            StmtKind::OffEvery => self.flags(Op::Event, [flags::OFF_EVERY, 0, 0]),
            StmtKind::MoveAxe { axis, target, relative, start, speed, accel, decel } => {
                let parts = [speed.as_deref(), accel.as_deref(), decel.as_deref()];
                self.move_axe(*axis, target, *relative, *start, parts);
            }
            StmtKind::MoveSpeed { axis, speed } => {
                self.features |= feature::START;
                self.expr(speed);
                let bits = *axis as u8 | bit(steps(speed), flags::STEPS);
                self.flags(Op::MoveSpeed, [bits, 0, 0]);
            }
            StmtKind::StopAxe(axis) => self.flags(Op::StopAxe, [*axis as u8, 0, 0]),
            StmtKind::WaitMove(axis) => self.flags(Op::WaitMove, [axis_or_all(*axis), 0, 0]),
            StmtKind::Home { axes, query } => self.home(axes, *query),
            StmtKind::Probe { axis, limit, speed, sensor, query } => {
                self.probe(*axis, limit, speed.as_deref(), sensor, *query);
            }
            StmtKind::SetPos { axis, value } => {
                self.expr(value);
                self.flags(Op::SetPos, [*axis as u8, 0, 0]);
            }
            StmtKind::Motors { on, axis } => {
                self.expr(on);
                self.flags(Op::Motors, [axis_or_all(*axis), 0, 0]);
            }
            StmtKind::WaitIn { n, want, timeout, query } => {
                self.wait_in(n, want, timeout.as_deref(), *query);
            }
            StmtKind::WaitChar { c, timeout, query } => {
                self.expr(c);
                let mut bits = bit(*query, flags::WAIT_QUERY);
                if let Some(timeout) = timeout {
                    self.expr(timeout);
                    bits |= flags::TIMEOUT;
                }
                self.flags(Op::WaitChar, [bits, 0, 0]);
            }
            StmtKind::Print(parts) => self.print(parts),
            StmtKind::SetFeed(feed) => {
                self.with(&[feed], if steps(feed) { Op::FeedSteps } else { Op::Feed });
            }
            StmtKind::SetSpindle(value) => {
                if self.program.profile.has_power() {
                    self.features |= feature::POWER;
                }
                self.with(&[value], Op::Spindle);
            }
            StmtKind::Linear { rapid, to, exact } => {
                let words = [to[0].as_ref(), to[1].as_ref(), to[2].as_ref()];
                self.linear(*rapid, words, *exact);
            }
            StmtKind::Arc { clockwise, plane, to, center, exact } => {
                let head = bit(*clockwise, flags::CLOCKWISE) | bit(*exact, flags::EXACT);
                self.arc(head, *plane, to, center);
            }
            StmtKind::Cycle(cycle) => self.cycle(cycle),
            // Everything else was lowered before.
            _ => {}
        }
    }

    fn plain_statement(&mut self, statement: Plain, values: &[Expr]) {
        if let (Plain::SetOut, [n, on]) = (statement, values)
            && let (Some(n @ 1..=8), Some(on @ 0..=1)) = (constant(n), constant(on))
        {
            let code = 2 * (n as u8 - 1) + on as u8;
            return self.push(Item::Short(Op::OutShort, code));
        }
        for value in values {
            self.expr(value);
        }
        self.plain(statement.op());
    }

    fn with(&mut self, arguments: &[&Expr], op: Op) {
        for argument in arguments {
            self.expr(argument);
        }
        self.plain(op);
    }

    fn move_axe(
        &mut self,
        axis: Axis,
        target: &Expr,
        relative: bool,
        start: bool,
        [speed, accel, decel]: [Option<&Expr>; 3],
    ) {
        if start {
            self.features |= feature::START;
        }
        self.expr(target);
        for part in [speed, accel, decel].into_iter().flatten() {
            self.expr(part);
        }
        let b = axis as u8
            | bit(steps(target), flags::STEPS)
            | bit(relative, flags::RELATIVE)
            | bit(start, flags::START)
            | bit(speed.is_some(), flags::SPEED)
            | bit(speed.is_some_and(steps), flags::SPEED_STEPS);
        let b2 = bit(accel.is_some(), flags::ACCEL)
            | bit(accel.is_some_and(steps), flags::ACCEL_STEPS)
            | bit(decel.is_some(), flags::DECEL)
            | bit(decel.is_some_and(steps), flags::DECEL_STEPS);
        if b2 != 0 {
            self.flags(Op::MoveRamp, [b, b2, 0]);
        } else if b & !(flags::AXIS | flags::RELATIVE) != 0 {
            self.flags(Op::Move, [b, 0, 0]);
        } else {
            let op = if relative { Op::MoveBy } else { Op::MoveTo };
            self.push(Item::Short(op, axis as u8));
        }
    }

    fn home(&mut self, axes: &[Axis], query: bool) {
        for (i, &axis) in axes.iter().enumerate() {
            if i + 1 < axes.len() {
                self.plain(Op::More);
            }
            if query {
                self.flags(Op::HomeQuery, [axis as u8, 0, 0]);
            } else {
                self.push(Item::Short(Op::Home, axis as u8));
            }
        }
    }

    fn probe(
        &mut self,
        axis: Axis,
        limit: &Word,
        speed: Option<&Expr>,
        sensor: &ProbeSensor,
        query: bool,
    ) {
        self.expr(&limit.value);
        if let Some(speed) = speed {
            self.expr(speed);
        }
        let sensor_bits = match sensor {
            ProbeSensor::Default => 0,
            ProbeSensor::Input(n, state) => {
                self.expr(n);
                self.expr(state);
                flags::SENSOR
            }
            ProbeSensor::Mask(and, xor) => {
                self.expr(and);
                self.expr(xor);
                flags::SENSOR | flags::MASK
            }
        };
        let b = axis as u8
            | bit(steps(&limit.value), flags::STEPS)
            | (limit.frame as u8) << flags::PROBE_FRAME
            | bit(query, flags::QUERY)
            | bit(speed.is_some(), flags::SPEED)
            | bit(speed.is_some_and(steps), flags::SPEED_STEPS);
        self.flags(Op::Probe, [b, sensor_bits, 0]);
    }

    fn wait_in(&mut self, n: &Expr, want: &InWant, timeout: Option<&Expr>, query: bool) {
        let mut bits = bit(query, flags::WAIT_QUERY);
        match constant(n) {
            Some(n @ 1..=4) => bits |= (n as u8 - 1) << flags::INPUT,
            _ => {
                self.expr(n);
                bits |= flags::INPUT_ON_STACK;
            }
        }
        match want {
            InWant::Edge(want) => bits |= *want as u8,
            InWant::Level(level) => match constant(level) {
                Some(level) => bits |= u8::from(level != 0),
                None => {
                    self.expr(level);
                    bits |= flags::LEVEL;
                }
            },
        }
        if let Some(timeout) = timeout {
            self.expr(timeout);
            bits |= flags::TIMEOUT;
        }
        self.flags(Op::WaitIn, [bits, 0, 0]);
    }

    fn print(&mut self, parts: &[PrintPart]) {
        // A FUNCTION may print: its value lies on the stack before the line begins. There is one
        // at most, the checker has seen to that.
        let early = |part: &&PrintPart| matches!(part, PrintPart::Value(e, _) if e.has_call());
        if let Some(PrintPart::Value(value, _)) = parts.iter().find(early) {
            self.expr(value);
        }
        // What stands between two values, units among it, is one text.
        let mut text = Vec::new();
        for part in parts {
            match part {
                PrintPart::Text(more) => text.extend(more.as_bytes()),
                PrintPart::Value(value, unit) => {
                    self.print_text(&mut text);
                    if !early(&part) {
                        self.expr(value);
                    }
                    match unit.decimals() {
                        Some(decimals) => self.print_decimals(decimals),
                        None => self.print_number(),
                    }
                    text.extend(unit.suffix().as_bytes());
                }
            }
        }
        self.print_text(&mut text);
        self.plain(Op::PrintEnd);
    }

    fn print_number(&mut self) {
        self.plain(Op::More);
        self.plain(Op::PrintNumber);
    }

    /// The top in decimals, as [`crate::show`] has it: a minus, the whole number, then digit by digit. Each is made
    /// of the value with its sign, so that the least number is none that overflows.
    fn print_decimals(&mut self, decimals: Decimals) {
        let positive = self.fresh();
        self.plain(Op::Dup);
        self.push(Item::Const(decimals.minus()));
        self.push(Item::Branch(Cond::Gt, positive));
        self.print_text(&mut b"-".to_vec());
        self.push(Item::Label(positive));
        let scales = decimals.over != 1;
        if scales {
            // value / over * times, then the rounded rest beside it.
            self.plain(Op::Dup);
            self.by(decimals.over, Op::Div);
            self.by(decimals.times, Op::Mul);
            self.plain(Op::Over);
            self.by(decimals.over, Op::Mod);
            self.by(2 * decimals.times, Op::Mul);
            self.by(decimals.over, Op::Div);
            self.plain(Op::Dup);
            self.by(2, Op::Mod);
            self.plain(Op::Add);
            self.by(2, Op::Div);
            self.plain(Op::Add);
        }
        let mut one = 10_i32.pow(decimals.digits.into());
        self.plain(Op::Dup);
        self.by(one, Op::Div);
        self.plain(Op::Abs);
        self.print_number();
        self.print_text(&mut b".".to_vec());
        while one > 1 {
            one /= 10;
            if one > 1 {
                self.plain(Op::Dup);
                self.by(one, Op::Div);
            }
            self.by(10, Op::Mod);
            self.plain(Op::Abs);
            self.print_number();
        }
        if scales {
            self.plain(Op::Drop);
        }
    }

    /// The top and a constant.
    fn by(&mut self, value: i32, op: Op) {
        self.push(Item::Const(value));
        self.plain(op);
    }

    /// A text of a PRINT, which is empty then. No handler comes behind it: it might print a line of its
    /// own.
    fn print_text(&mut self, text: &mut Vec<u8>) {
        for piece in text.chunks(super::MAX_TEXT) {
            let id = self.text(piece);
            self.plain(Op::More);
            self.push(Item::Text(id));
        }
        text.clear();
    }

    /// G0 and G1 in the shortest form that says it.
    pub(super) fn linear(&mut self, rapid: bool, words: [Option<&Word>; 3], exact: bool) {
        for word in words.into_iter().flatten() {
            self.expr(&word.value);
        }
        let words = words.map(|word| word.map(|word| (steps(&word.value), word.frame)));
        self.linear_on_stack(rapid, words, exact);
    }

    /// The same with the values on the stack; a word is whether it is in steps, and its frame.
    pub(super) fn linear_on_stack(
        &mut self,
        rapid: bool,
        words: [Option<(bool, Frame)>; 3],
        exact: bool,
    ) {
        self.features |= feature::INTERPOLATE;
        let axes = axes_of(|i| words[i].is_some());
        let mut common = words.iter().flatten();
        let first = common.next().copied().unwrap_or((false, Frame::Work));
        let same = common.all(|word| *word == first);
        let head = axes.0 | bit(rapid, flags::RAPID) | bit(exact, flags::EXACT);
        let short = SHORT_AXES.iter().position(|&short| short == axes);
        match short {
            Some(n) if same && !exact && first == (false, Frame::Work) => {
                self.push(Item::Short(if rapid { Op::Rapid } else { Op::Line }, n as u8));
            }
            _ if same => {
                let bits =
                    bit(first.0, flags::COMMON_STEPS) | (first.1 as u8) << flags::COMMON_FRAME;
                self.flags(Op::Linear, [head | bits, 0, 0]);
            }
            _ => {
                let (mut in_steps, mut frames) = (0, 0);
                for (i, word) in words.iter().enumerate() {
                    if let Some((steps, frame)) = word {
                        in_steps |= bit(*steps, 1 << (5 + i));
                        frames |= (*frame as u8) << (2 * i);
                    }
                }
                self.flags(Op::LinearMixed, [head | in_steps, frames, 0]);
            }
        }
    }

    fn arc(&mut self, head: u8, plane: Plane, to: &[Option<Word>; 3], center: &ArcCenter) {
        self.features |= feature::INTERPOLATE | feature::ARC;
        let (mut frames, mut in_steps) = (0, 0);
        let to = without_still([to[0].as_ref(), to[1].as_ref(), to[2].as_ref()]);
        let relative = to.iter().flatten().all(|word| word.frame == Frame::Relative);
        for (i, word) in to.iter().enumerate() {
            if let Some(word) = word {
                self.expr(&word.value);
                frames |= (word.frame as u8) << (2 * i);
                in_steps |= bit(steps(&word.value), 1 << i);
            }
        }
        let mut b = head | axes_of(|i| to[i].is_some()).0 | (plane as u8) << flags::PLANE;
        match center {
            ArcCenter::Radius(radius) => {
                self.expr(radius);
                in_steps |= bit(steps(radius), 1 << 3);
            }
            ArcCenter::Offsets(offsets) => {
                b |= flags::OFFSETS;
                for axis in plane_axes(plane) {
                    match &offsets[axis.index()] {
                        Some(offset) => {
                            self.expr(offset);
                            in_steps |= bit(steps(offset), 1 << (3 + axis.index()));
                        }
                        None => self.push(Item::Const(0)),
                    }
                }
            }
        }
        if frames == 0 && in_steps == 0 {
            self.flags(Op::Arc, [b, 0, 0]);
        } else if relative && in_steps == 0 {
            self.flags(Op::ArcBy, [b, 0, 0]);
        } else {
            self.flags(Op::ArcMixed, [b, frames, in_steps]);
        }
    }
}

/// Leaves out words that do not move: a relative 0 is as no word. One stays.
fn without_still(mut words: [Option<&Word>; 3]) -> [Option<&Word>; 3] {
    let still = |word: &Word| word.frame == Frame::Relative && constant(&word.value) == Some(0);
    for i in 0..words.len() {
        if words.iter().flatten().count() > 1 && words[i].is_some_and(still) {
            words[i] = None;
        }
    }
    words
}

fn axes_of(has: impl Fn(usize) -> bool) -> AxisSet {
    Axis::ALL.into_iter().filter(|axis| has(axis.index())).fold(AxisSet(0), AxisSet::with)
}

const fn axis_or_all(axis: Option<Axis>) -> u8 {
    match axis {
        Some(axis) => axis as u8,
        None => flags::ALL_AXES,
    }
}
