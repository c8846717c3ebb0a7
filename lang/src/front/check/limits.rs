//! What the profile's machine can do: axes, inputs and outputs, speeds, travel.

use super::expr::{remedy, value_of};
use super::names::Entity;
use super::{Checker, fold};
use crate::axis::Axis;
use crate::effect::Frame;
use crate::fault::Fault;
use crate::front::ast::{AxisRef, Expr, ExprKind};
use crate::front::codes::Code;
use crate::front::span::Span;
use crate::hir;
use crate::kind::Kind;
use crate::part::{SYNC_LEAD_MS, SYNC_MS, SYNC_WAY};
use crate::profile::OutputRole;

/// A constant target, kept until it is known which axes the script homes.
#[derive(Debug)]
struct Target {
    axis: Axis,
    value: i32,
    kind: Kind,
    /// Counts from the machine's zero, not from the work's.
    machine: bool,
    span: Span,
}

/// What the whole script does to the axes.
#[derive(Debug, Default)]
pub(super) struct Limits {
    homed: [bool; 3],
    offset: [bool; 3],
    targets: Vec<Target>,
    feeds: Vec<Feed>,
    paths: Paths,
}

/// A constant F, kept until it is known which axes the paths move.
#[derive(Debug)]
struct Feed {
    value: i32,
    kind: Kind,
    span: Span,
}

/// Which sets of axes the script's paths move: a set is a mask with X in bit 0, a field has a bit for each of the
/// eight sets.
#[derive(Clone, Copy, Debug, Default)]
struct Paths {
    lines: u8,
    arcs: u8,
}

/// Constant targets and feeds that are remembered: a drilled board has thousands, the list of diagnostics 50.
const MAX_KEPT: usize = 100_000;

/// How the hint begins for a name that is no input or output.
pub const WHICH_PORT: &str = "say which it is";

impl<'a> Checker<'a> {
    /// An axis that the machine has.
    pub(super) fn axis(&mut self, axis: AxisRef) -> Option<Axis> {
        self.has_axis(axis.axis, axis.span).then_some(axis.axis)
    }

    pub(super) fn has_axis(&mut self, axis: Axis, span: Span) -> bool {
        if self.profile.axis(axis).is_some() {
            return true;
        }
        let axes: Vec<String> = self.profile.axes().map(|(a, _)| a.letter().to_string()).collect();
        let message = format!("the machine `{}` has no axis {}", self.profile.name, axis.letter());
        let hint =
            format!("it has {}; another profile is chosen by PROFILE or --profile", axes.join(" "));
        self.error(Code::NoAxis, span, message, hint);
        false
    }

    /// A number of an input or output, which the wiring must have.
    pub(super) fn port(&mut self, expr: &'a Expr, output: bool) -> Option<hir::Expr> {
        let what = if output { "an output's number" } else { "an input's number" };
        if let ExprKind::Name(name) = &expr.kind {
            let word = if output { "OUTPUT" } else { "INPUT" };
            let symbol =
                self.resolve_as(name, |name| format!("{WHICH_PORT}: `{word} {name} = 1`"))?;
            if let Entity::Analog(is_output, _) = symbol.entity {
                let (own, hint) = match is_output {
                    true => ("an analog output", "it is set by `SetAout name, value`"),
                    false => (
                        "an analog input",
                        "its voltage is `AIN(name)`; a [[threshold]] of the profile makes an input of it",
                    ),
                };
                let message = format!("`{}` is {own}, not {what}", symbol.text);
                self.error(Code::WrongUse, expr.span, message, hint);
                return None;
            }
        }
        let n = self.plain(expr, what)?;
        match value_of(&n) {
            Some(value) => self.check_port(output, value, expr.span).then_some(n),
            None => Some(n),
        }
    }

    /// The number of an analog input, which the profile must have: 1 to 4.
    pub(super) fn analog(&mut self, expr: &'a Expr) -> Option<u8> {
        if let ExprKind::Name(name) = &expr.kind {
            let symbol = self.resolve_as(name, |name| format!("name it: `ANALOG {name} = 1`"))?;
            if let Entity::Analog(true, _) = symbol.entity {
                let message =
                    format!("AIN takes an analog input, and `{}` is an analog output", symbol.text);
                let hint = "an output is not read: keep its value in a variable";
                self.error(Code::WrongUse, expr.span, message, hint);
                return None;
            }
            if let Entity::Port(output, _) = symbol.entity {
                let what = if output { "an output" } else { "an input" };
                let message = format!("AIN takes an analog input, and `{}` is {what}", symbol.text);
                let read = if output { "OUT" } else { "IN" };
                let hint = format!("its state is `{read}({})`", symbol.text);
                self.error(Code::WrongUse, expr.span, message, hint);
                return None;
            }
        }
        let n = self.plain(expr, "an analog input's number")?;
        let Some(n) = value_of(&n) else {
            let message = "the number of an analog input is only known at run time";
            let hint = "write its number or its name; several are told apart by SELECT CASE";
            self.error(Code::NotConstant, expr.span, message, hint);
            return None;
        };
        self.check_analog(n, expr.span).then(|| u8::try_from(n).ok()).flatten()
    }

    /// Whether the profile has this analog input.
    pub(super) fn check_analog(&mut self, n: i32, span: Span) -> bool {
        let analogs = &self.profile.analogs;
        if analogs.iter().any(|analog| analog.n == n) {
            return true;
        }
        let message = format!("the machine `{}` has no analog input {n}", self.profile.name);
        let hint = match &analogs[..] {
            [] => "write `[[analog]]` with `n = 1` into its profile; the F5529 has four".to_owned(),
            some => {
                let numbers: Vec<String> = some.iter().map(|analog| analog.n.to_string()).collect();
                format!("its analog inputs are {}", numbers.join(", "))
            }
        };
        self.error(Code::NoPort, span, message, hint);
        false
    }

    pub(super) fn check_port(&mut self, output: bool, n: i32, span: Span) -> bool {
        let profile = self.profile;
        let last = profile.wiring.outputs();
        let (what, known, numbers) = match output {
            true => ("output", (1..=last).contains(&n), format!("1 to {last}")),
            false => ("input", profile.has_input(n), profile.input_numbers()),
        };
        if known {
            return true;
        }
        let message = format!("the machine `{}` has no {what} {n}", self.profile.name);
        self.error(Code::NoPort, span, message, format!("its {what}s are {numbers}"));
        false
    }

    /// An output that a script may set.
    pub(super) fn settable(&mut self, n: &hir::Expr, span: Span) -> bool {
        let Some(n) = value_of(n) else { return true };
        let role = self.profile.outputs.iter().find(|o| o.n == n).and_then(|o| o.role);
        let (what, hint) = match role {
            Some(OutputRole::Lamp) => ("is the status lamp", "use a free output"),
            Some(OutputRole::Enable) => {
                ("enables the drivers", "write `Motors ON` or `Motors OFF`")
            }
            _ => return true,
        };
        self.error(Code::ReservedOutput, span, format!("output {n} {what}"), hint);
        false
    }

    /// Warns of a statement that always ends in a fault.
    pub(super) fn run_time_fault(&mut self, fault: Fault, span: Span, what: &str) {
        self.ends_here(fault, span, what, remedy(fault));
    }

    /// The same with a remedy of its own.
    pub(super) fn ends_here(
        &mut self,
        fault: Fault,
        span: Span,
        what: &str,
        hint: impl Into<String>,
    ) {
        let message = format!("{what}: the run ends here with {fault}");
        self.error(Code::AlwaysFaults, span, message, hint);
    }

    /// A Time that is constant must not be below `least` ms.
    pub(super) fn check_time(&mut self, time: &hir::Expr, span: Span, least: i32) {
        if value_of(time).is_some_and(|ms| ms < least) {
            let hint = format!("the shortest is {least}ms");
            self.ends_here(Fault::ValueRange, span, "this time is too short", hint);
        }
    }

    /// The lead of SYNC, as far as it is known.
    pub(super) fn check_lead(&mut self, lead: &hir::Expr, span: Span) {
        let Some(value) = value_of(lead) else { return };
        if lead.kind != Kind::Time {
            if value.unsigned_abs() > SYNC_WAY.unsigned_abs() {
                let hint = format!("the longest is {}mm", SYNC_WAY / 1000);
                self.ends_here(Fault::ValueRange, span, "this lead or lag is too long", hint);
            }
        } else if value > SYNC_LEAD_MS {
            let hint = format!("the longest is {SYNC_LEAD_MS}ms; a Length, `5mm`, may be longer");
            self.ends_here(Fault::ValueRange, span, "this lead is too long", hint);
        } else if value < -SYNC_MS {
            let hint = format!("the longest lag is {SYNC_MS}ms");
            self.ends_here(Fault::ValueRange, span, "this lag is too long", hint);
        }
    }

    /// The pulse of SYNC, as far as it is known.
    pub(super) fn check_pulse(&mut self, time: &hir::Expr, span: Span) {
        if value_of(time).is_some_and(|ms| !(1..=SYNC_MS).contains(&ms)) {
            let hint = format!("a pulse on the way takes 1ms to {SYNC_MS}ms");
            self.ends_here(Fault::ValueRange, span, "this pulse is too short or too long", hint);
        }
    }

    /// A constant speed of an axis; `signed` for MoveSpeed.
    pub(super) fn check_speed(&mut self, axis: Axis, speed: &hir::Expr, span: Span, signed: bool) {
        let Some(value) = value_of(speed) else { return };
        if value == 0 || (value < 0 && !signed) {
            let what = if value == 0 { "a speed of 0" } else { "a negative speed" };
            self.run_time_fault(Fault::SpeedRange, span, what);
            return;
        }
        let Some(part) = self.profile.axis(axis) else { return };
        let Some(top) = in_unit_of(speed.kind, part.scale, part.top_rate) else { return };
        self.warn_above(value, top, speed.kind, axis, "speed", "top", span);
    }

    /// A constant acceleration of an axis.
    pub(super) fn check_accel(&mut self, axis: Axis, accel: &hir::Expr, span: Span, down: bool) {
        let Some(value) = value_of(accel) else { return };
        if value <= 0 {
            self.run_time_fault(Fault::SpeedRange, span, "an acceleration that is not positive");
            return;
        }
        let Some(part) = self.profile.axis(axis) else { return };
        let ramp = if down { part.decel.unwrap_or(part.accel) } else { part.accel };
        let Some(top) = in_unit_of(accel.kind, part.scale, ramp) else { return };
        self.warn_above(value, top, accel.kind, axis, "acceleration", "ramp", span);
    }

    #[expect(clippy::too_many_arguments, reason = "the parts of one sentence")]
    fn warn_above(
        &mut self,
        value: i32,
        top: i64,
        kind: Kind,
        axis: Axis,
        what: &str,
        limit: &str,
        span: Span,
    ) {
        if i64::from(value.unsigned_abs()) <= top {
            return;
        }
        let unit = kind.unit().suffix();
        let message = format!("this {what} is above the {limit} of {}, {top}{unit}", axis.letter());
        self.error(
            Code::AboveTop,
            span,
            message,
            format!("the axis runs at its {limit}; leave it out to say so"),
        );
    }

    /// A constant feed along a path.
    pub(super) fn check_feed(&mut self, feed: &hir::Expr, span: Span) {
        let Some(value) = value_of(feed) else { return };
        if value <= 0 {
            self.run_time_fault(Fault::SpeedRange, span, "a feed that is not positive");
            return;
        }
        if self.limits.feeds.len() < MAX_KEPT {
            self.limits.feeds.push(Feed { value, kind: feed.kind, span });
        }
    }

    /// A path with feed moves these axes: in a line, or in an arc whose plane they span.
    pub(super) fn note_path(&mut self, axes: impl IntoIterator<Item = Axis>, arc: bool) {
        let set = axes.into_iter().fold(0, |set, axis| set | 1 << axis.index());
        let paths = &mut self.limits.paths;
        *(if arc { &mut paths.arcs } else { &mut paths.lines }) |= 1 << set;
    }

    /// Warns of feeds that no path of the script reaches, whatever its direction. Which F holds for which path is not
    /// followed through jumps and SUBs: the fastest of all paths counts.
    pub(super) fn check_feeds(&mut self) {
        for feed in core::mem::take(&mut self.limits.feeds) {
            let Some((top, what)) = self.fastest_path(feed.kind) else { continue };
            if i64::from(feed.value) <= top {
                continue;
            }
            let unit = feed.kind.unit().suffix();
            let message = format!("this feed is above {what}, {top}{unit}");
            let hint = format!(
                "the path runs as fast as its axes can; a feed of {top}{unit} or less is kept"
            );
            self.error(Code::AboveTop, feed.span, message, hint);
        }
    }

    /// What the fastest path of the script reaches in the unit of `kind`, rounded up, and in words what that is. In a
    /// line all its axes may be at their tops at once; in an arc each axis of the plane has the whole speed somewhere.
    fn fastest_path(&self, kind: Kind) -> Option<(i64, String)> {
        let Paths { lines, arcs } = self.limits.paths;
        let mut fastest: Option<(i64, String)> = None;
        for (sets, arc) in [(lines, false), (arcs, true)] {
            for set in (1..8u8).filter(|set| sets & 1 << set != 0) {
                let axes = Axis::ALL.into_iter().filter(|axis| set & 1 << axis.index() != 0);
                let tops = axes.clone().map(|axis| {
                    let part = self.profile.axis(axis)?;
                    in_unit_of(kind, part.scale, part.top_rate)
                });
                let tops = tops.collect::<Option<Vec<_>>>()?;
                let top = if arc { tops.iter().copied().min()? } else { length_of(&tops) };
                let letters = axes.map(|axis| axis.letter().to_string()).collect::<Vec<_>>();
                let what = match (&letters[..], arc) {
                    ([one], _) => format!("the top of {one}"),
                    (all, true) => format!("what an arc of {} reaches", all.join(" and ")),
                    (all, false) => format!("what {} reach together", all.join(" and ")),
                };
                if fastest.as_ref().is_none_or(|(before, _)| top > *before) {
                    fastest = Some((top, what));
                }
            }
        }
        fastest
    }

    /// A constant S on a machine with a laser or a PWM.
    pub(super) fn check_power(&mut self, power: &hir::Expr, span: Span) {
        let (has, full) = (self.profile.has_power(), self.profile.full_power());
        let Some(value) = value_of(power).filter(|_| has) else { return };
        if !(0..=full).contains(&value) {
            let hint = format!("full power is S{full}, S0 is dark");
            self.ends_here(Fault::ValueRange, span, "a power that the machine does not have", hint);
        }
    }

    /// A probe speed that a shift register can not follow (lang/README.md, Probing).
    pub(super) fn check_probe(
        &mut self,
        axis: Axis,
        speed: &hir::Expr,
        input: Option<i32>,
        span: Span,
    ) {
        const EXACT: i64 = 1000;
        let wiring = self.profile.wiring;
        let input = input.unwrap_or_else(|| self.profile.probe_input());
        // On the chain only the probe pin itself is no shift register's.
        if wiring == crate::profile::Wiring::Direct || input == wiring.probe() {
            return;
        }
        let (Some(value), Some(part)) = (value_of(speed), self.profile.axis(axis)) else { return };
        let rate = match speed.kind {
            Kind::Speed => fold::to_steps(part.scale, value).map_or(i64::MAX, i64::from),
            _ => i64::from(value),
        };
        if rate > EXACT {
            let message =
                format!("input {input} is read each ms: at {rate}st/s the contact is caught late");
            let hint = format!("probe at {EXACT}st/s at most, or use the probe input");
            self.error(Code::ProbeTooFast, span, message, hint);
        }
    }

    /// Remembers a constant absolute target.
    pub(super) fn note_target(&mut self, axis: Axis, target: &hir::Expr, frame: Frame, span: Span) {
        let machine = match frame {
            Frame::Relative => return,
            Frame::Machine => true,
            // Steps are machine positions.
            Frame::Work => target.kind == Kind::Steps,
        };
        if let Some(value) = value_of(target)
            && self.limits.targets.len() < MAX_KEPT
        {
            self.limits.targets.push(Target { axis, value, kind: target.kind, machine, span });
        }
    }

    pub(super) fn note_homed(&mut self, axis: Axis) {
        self.limits.homed[axis.index()] = true;
    }

    pub(super) fn note_offset(&mut self, axis: Axis) {
        self.limits.offset[axis.index()] = true;
    }

    /// Warns of targets outside the travel, of axes that the script homes and whose work zero is
    /// the machine's.
    pub(super) fn check_targets(&mut self) {
        for target in core::mem::take(&mut self.limits.targets) {
            let axis = target.axis;
            let Some(part) = self.profile.axis(axis) else { continue };
            let um = match target.kind {
                _ if !target.machine && self.limits.offset[axis.index()] => continue,
                Kind::Steps => fold::to_length(part.scale, target.value).unwrap_or(i32::MAX),
                _ => target.value,
            };
            if !self.limits.homed[axis.index()] || (part.min_um..=part.max_um).contains(&um) {
                continue;
            }
            let message = format!(
                "{} to {} lies outside its travel of {} to {}",
                axis.letter(),
                mm(um),
                mm(part.min_um),
                mm(part.max_um)
            );
            self.error(
                Code::OutsideTravel,
                target.span,
                message,
                "once the axis is homed this is F05",
            );
        }
    }
}

/// um as `12.54mm`.
fn mm(um: i32) -> String {
    let sign = if um < 0 { "-" } else { "" };
    let text = format!("{}.{:03}", um.unsigned_abs() / 1000, um.unsigned_abs() % 1000);
    format!("{sign}{}mm", text.trim_end_matches('0').trim_end_matches('.'))
}

/// The length of a vector with these parts, rounded up.
fn length_of(parts: &[i64]) -> i64 {
    let square = parts.iter().map(|&part| i128::from(part) * i128::from(part)).sum::<i128>();
    let root = square.isqrt();
    i64::try_from(root + i128::from(root * root < square)).unwrap_or(i64::MAX)
}

/// A profile's rate in steps in the unit of `kind`; um are rounded up, so that the top itself is
/// not above the top.
fn in_unit_of(kind: Kind, scale: crate::profile::Scale, rate: i32) -> Option<i64> {
    match kind {
        Kind::Speed | Kind::Accel => {
            let product = i64::from(rate) * i64::from(scale.um);
            Some(
                product.div_euclid(i64::from(scale.steps.max(1)))
                    + i64::from(product % i64::from(scale.steps.max(1)) != 0),
            )
        }
        Kind::StepRate | Kind::StepAccel => Some(i64::from(rate)),
        _ => None,
    }
}
