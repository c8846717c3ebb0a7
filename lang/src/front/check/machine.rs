//! Statements of the machine, other than G-code blocks.

use super::argument::{ACCEL, LEAD, PLACE, SPEED, TIME};
use super::expr::{number, value_of};
use super::{Checker, kinds, range};
use crate::axis::Axis;
use crate::effect::{ActKind, Frame, Unit};
use crate::fault::Fault;
use crate::front::ast::{self, AxisRef, Expr, InputState, Machine};
use crate::front::codes::Code;
use crate::front::span::Span;
use crate::hir::{self, InWant, ProbeSensor, StmtKind, Word};
use crate::kind::Kind;
use crate::plain::{Argument, Plain};

/// Synchronisation characters (lang/README.md, Outputs, inputs, characters).
const CHARACTERS: core::ops::RangeInclusive<i32> = 33..=125;

impl<'a> Checker<'a> {
    /// Lowers one statement; every argument is checked even where another was wrong.
    pub(super) fn machine(&mut self, machine: &'a Machine, span: Span) -> Option<Vec<StmtKind>> {
        let one = |kind| Some(vec![kind]);
        match machine {
            Machine::Plain(statement, list) => one(self.plain_statement(*statement, list)?),
            Machine::Sync { kind, list, lead } => {
                one(self.sync(*kind, list, lead.as_ref(), span)?)
            }
            Machine::SetAout(list) => {
                let (n, value) = self.set_aout(list)?;
                one(StmtKind::SetAout(n, value))
            }
            Machine::Move { start, relative, axis, target, speed, accel, decel } => {
                let word = if *relative { "MoveRel" } else { "MoveAxe" };
                let target_value = self.quantity(target, PLACE, word);
                let axis = self.axis(*axis);
                let speed = self.speed(speed.as_ref(), axis, word);
                let accel = self.ramp(accel.as_ref(), axis, word, false);
                let decel = self.ramp(decel.as_ref(), axis, word, true);
                let (axis, target_value) = (axis?, target_value?);
                let frame = if *relative { Frame::Relative } else { Frame::Work };
                self.note_target(axis, &target_value, frame, target.span);
                one(StmtKind::MoveAxe {
                    axis,
                    target: target_value,
                    relative: *relative,
                    start: *start,
                    speed: speed?.map(Box::new),
                    accel: accel?.map(Box::new),
                    decel: decel?.map(Box::new),
                })
            }
            Machine::WaitMove(None) => one(StmtKind::WaitMove(None)),
            Machine::WaitMove(Some(axis)) => one(StmtKind::WaitMove(Some(self.axis(*axis)?))),
            Machine::MoveSpeed(axis, speed) => {
                let value = self.quantity(speed, SPEED, "MoveSpeed");
                let axis = self.axis(*axis)?;
                let value = value?;
                self.check_speed(axis, &value, speed.span, true);
                one(StmtKind::MoveSpeed { axis, speed: value })
            }
            Machine::StopAxe(axis) => one(StmtKind::StopAxe(self.axis(*axis)?)),
            Machine::Home { quiet, axes } => one(self.home(*quiet, axes, span)?),
            Machine::Probe { quiet, axis, limit, speed, input, state } => {
                let input_number = input.as_ref().map(|input| self.port(input, false));
                let state =
                    state.as_ref().map(|state| self.condition(state, "the state of an input"));
                let sensor = match (input_number, state) {
                    (None, _) => Some(ProbeSensor::Default),
                    (Some(n), None) => {
                        n.map(|n| ProbeSensor::Input(n, number(1, Kind::Truth, span)))
                    }
                    (Some(n), Some(state)) => n.and_then(|n| Some(ProbeSensor::Input(n, state?))),
                };
                one(self.probe(*axis, limit, speed, sensor, *quiet)?)
            }
            Machine::ProbeMask { quiet, axis, limit, speed, and, xor } => {
                let and = self.plain(and, "the AND mask");
                let xor = self.plain(xor, "the XOR mask");
                let sensor = and.and_then(|and| Some(ProbeSensor::Mask(and, xor?)));
                one(self.probe(*axis, limit, speed, sensor, *quiet)?)
            }
            Machine::SetPos(axis, value) => {
                let value = self.quantity(value, &[Kind::Length], "SetPos");
                let axis = self.axis(*axis)?;
                self.note_offset(axis);
                one(StmtKind::SetPos { axis, value: value? })
            }
            Machine::Motors(on, axis) => {
                let on = self.condition(on, "the state of the drivers");
                let axis = match axis {
                    Some(axis) => Some(self.axis(*axis)?),
                    None => None,
                };
                one(StmtKind::Motors { on: on?, axis })
            }
            Machine::WaitIn { quiet, input, state, timeout } => {
                let n = self.port(input, false);
                let want = match state {
                    InputState::Edge(want) => Some(InWant::Edge(*want)),
                    InputState::Level(level) => self
                        .condition(level, "the state of an input")
                        .map(|level| InWant::Level(Box::new(level))),
                };
                let timeout = self.timeout(timeout.as_ref(), "the timeout of WaitIn");
                let timeout = timeout?.map(Box::new);
                let wait = StmtKind::WaitIn { n: n?, want: want?, timeout, query: *quiet };
                Some(self.with_timed_out(wait, *quiet, span))
            }
            Machine::WaitChar { quiet, code, timeout } => {
                let c = self.character(code, "WaitChar");
                let timeout = self.timeout(timeout.as_ref(), "the timeout of WaitChar");
                let timeout = timeout?.map(Box::new);
                let wait = StmtKind::WaitChar { c: c?, timeout, query: *quiet };
                Some(self.with_timed_out(wait, *quiet, span))
            }
            Machine::Print(parts) => {
                let mut list = Vec::with_capacity(parts.len());
                let mut wrong = false;
                for part in parts {
                    match part {
                        ast::PrintPart::Text(text) => {
                            list.push(hir::PrintPart::Text(text.text.clone()))
                        }
                        ast::PrintPart::Value(value, shown) => {
                            match self.print_value(value, *shown) {
                                Some(part) => list.push(part),
                                None => wrong = true,
                            }
                        }
                    }
                }
                (!wrong).then(|| self.print_in_order(list))
            }
            // Modal state only: it costs the device nothing.
            Machine::Plane(_) => Some(Vec::new()),
        }
    }

    /// A value of a PRINT. One in decimals that is known is a text.
    fn print_value(
        &mut self,
        value: &'a Expr,
        shown: Option<ast::ShownIn>,
    ) -> Option<hir::PrintPart> {
        let checked = self.expr(value)?;
        let Some(ast::ShownIn { unit, span }) = shown else {
            let unit = checked.kind.unit();
            return Some(hir::PrintPart::Value(checked, unit));
        };
        if checked.kind != unit.kind() {
            let found = kinds::a(checked.kind);
            let message = format!("{found} has no `{}`", unit.suffix());
            let fitting = Unit::ALL.into_iter().filter(|unit| unit.kind() == checked.kind);
            let fitting: Vec<String> =
                fitting.map(|unit| format!("IN {}", unit.suffix())).collect();
            let hint = match (checked.kind, unit.kind()) {
                (Kind::Number | Kind::Truth, _) => {
                    format!("multiply by a quantity first: `n * 1{} IN {0}`", unit.suffix())
                }
                (Kind::Steps, Kind::Length) => "convert it first: `LENGTH(X, n)`".to_owned(),
                (Kind::Length, Kind::Steps) => "convert it first: `STEPS(X, n)`".to_owned(),
                _ => format!("write {}", fitting.join(" or ")),
            };
            self.error(Code::ArgumentKind, span, message, hint);
            return None;
        }
        match value_of(&checked) {
            Some(value) if unit.decimals().is_some() => {
                Some(hir::PrintPart::Text(unit.show(value).to_string()))
            }
            _ => Some(hir::PrintPart::Value(checked, unit)),
        }
    }

    /// A wait, and TIMEDOUT in the variable that holds it where a WAIT UNTIL sets it too.
    fn with_timed_out(&mut self, wait: StmtKind, quiet: bool, span: Span) -> Vec<StmtKind> {
        match self.timed_out() {
            Some(var) if quiet => {
                let node = hir::ExprKind::Read(hir::ReadKind::TimedOut);
                let read = hir::Expr { kind: Kind::Truth, span: range(span), node };
                vec![wait, StmtKind::Assign(hir::Place::Var(var), read)]
            }
            _ => vec![wait],
        }
    }

    /// A plain statement: all of its arguments are looked at before any is refused for its value.
    fn plain_statement(&mut self, statement: Plain, list: &'a [Expr]) -> Option<StmtKind> {
        let word = statement.word().text();
        let mut values = Vec::with_capacity(list.len());
        for (argument, expr) in statement.arguments().iter().zip(list) {
            values.push(match argument {
                Argument::Output => self.port(expr, true),
                Argument::State => self.condition(expr, "the state of an output"),
                Argument::Time => self.quantity(expr, TIME, word),
                Argument::Number => self.plain(expr, word),
                Argument::Character => self.character(expr, word),
            });
        }
        let values = values.into_iter().collect::<Option<Vec<_>>>()?;
        for ((argument, expr), value) in statement.arguments().iter().zip(list).zip(&values) {
            match argument {
                Argument::Output if !self.settable(value, expr.span) => return None,
                Argument::Time => self.check_time(value, expr.span, 0),
                _ => {}
            }
        }
        Some(StmtKind::Plain(statement, values))
    }

    /// SYNC: the statement as it stands alone, and the lead.
    fn sync(
        &mut self,
        kind: ActKind,
        list: &'a [Expr],
        lead: Option<&'a Expr>,
        span: Span,
    ) -> Option<StmtKind> {
        let action = match kind {
            ActKind::Set => self.two(Plain::SetOut, list),
            ActKind::Pulse => self.two(Plain::Pulse, list),
            ActKind::Analog => self.set_aout(list),
        };
        let lead = match lead {
            None => number(0, Kind::Length, span),
            Some(lead) => {
                let value = self.quantity(lead, LEAD, "the lead of SYNC")?;
                self.check_lead(&value, lead.span);
                value
            }
        };
        let (n, value) = action?;
        if kind == ActKind::Pulse {
            self.check_pulse(&value, list.get(1).map_or(span, |time| time.span));
        }
        Some(StmtKind::Sync(Box::new(hir::Sync { n, value, kind, lead })))
    }

    /// The two arguments of a statement.
    fn two(&mut self, statement: Plain, list: &'a [Expr]) -> Option<(hir::Expr, hir::Expr)> {
        let StmtKind::Plain(_, values) = self.plain_statement(statement, list)? else {
            return None;
        };
        let [n, value]: [hir::Expr; 2] = values.try_into().ok()?;
        Some((n, value))
    }

    fn home(&mut self, query: bool, axes: &'a [AxisRef], span: Span) -> Option<StmtKind> {
        let mut order: Vec<Axis> = Vec::new();
        for axis in axes {
            let known = self.axis(*axis)?;
            if order.contains(&known) {
                let message = format!("{} is homed twice here", axis.axis.letter());
                self.error(Code::DeclaredTwice, axis.span, message, "name each axis once");
            }
            order.push(known);
        }
        if axes.is_empty() {
            order = self.profile.home_order.iter().map(|&name| name.into()).collect();
        }
        if order.is_empty() {
            let message = format!("the profile `{}` has no order of homing", self.profile.name);
            self.error(Code::NoAxis, span, message, "name the axes: `Home Z, X`");
            return None;
        }
        order.iter().for_each(|&axis| self.note_homed(axis));
        Some(StmtKind::Home { axes: order, query })
    }

    fn probe(
        &mut self,
        axis: AxisRef,
        limit: &'a Expr,
        speed: &'a Expr,
        sensor: Option<ProbeSensor>,
        query: bool,
    ) -> Option<StmtKind> {
        let value = self.quantity(limit, PLACE, "the limit of Probe");
        let rate = self.quantity(speed, SPEED, "the speed of Probe");
        let axis = self.axis(axis)?;
        let (value, rate, sensor) = (value?, rate?, sensor?);
        self.check_speed(axis, &rate, speed.span, false);
        let input = match &sensor {
            ProbeSensor::Input(n, _) => value_of(n),
            // A mask reads the shift registers.
            ProbeSensor::Mask(..) => Some(1),
            ProbeSensor::Default => None,
        };
        self.check_probe(axis, &rate, input, speed.span);
        self.note_target(axis, &value, Frame::Work, limit.span);
        let limit = Box::new(Word { value, frame: Frame::Work });
        let (speed, sensor) = (Some(Box::new(rate)), Box::new(sensor));
        Some(StmtKind::Probe { axis, limit, speed, sensor, query })
    }

    /// An optional speed; the outer None after an error.
    fn speed(
        &mut self,
        speed: Option<&'a Expr>,
        axis: Option<Axis>,
        what: &str,
    ) -> Option<Option<hir::Expr>> {
        let Some(speed) = speed else { return Some(None) };
        let value = self.quantity(speed, SPEED, &format!("the speed of {what}"))?;
        self.check_speed(axis?, &value, speed.span, false);
        Some(Some(value))
    }

    fn ramp(
        &mut self,
        ramp: Option<&'a Expr>,
        axis: Option<Axis>,
        what: &str,
        down: bool,
    ) -> Option<Option<hir::Expr>> {
        let Some(ramp) = ramp else { return Some(None) };
        let value = self.quantity(ramp, ACCEL, &format!("the acceleration of {what}"))?;
        self.check_accel(axis?, &value, ramp.span, down);
        Some(Some(value))
    }

    fn timeout(&mut self, timeout: Option<&'a Expr>, what: &str) -> Option<Option<hir::Expr>> {
        let Some(timeout) = timeout else { return Some(None) };
        let value = self.quantity(timeout, TIME, what)?;
        self.check_time(&value, timeout.span, 0);
        Some(Some(value))
    }

    fn character(&mut self, code: &'a Expr, what: &str) -> Option<hir::Expr> {
        let value = self.expr(code)?;
        if !kinds::is_plain(value.kind) {
            self.wrong_kind(what, &[Kind::Number], code, value.kind);
            return None;
        }
        if value_of(&value).is_some_and(|c| !CHARACTERS.contains(&c)) {
            let hint = "characters are given by their numbers: A is 65, 0 is 48";
            self.ends_here(Fault::ValueRange, code.span, "a character outside 33 to 125", hint);
        }
        Some(value)
    }
}
