//! Effects as templates: what a statement does, with its expressions in order of evaluation.

use lang::effect::{Action, Center, Coord, Dist, Effect, Frame, Lead, Rate, Read, Sensor, Want};
use lang::hir::{ArcCenter, Expr, InWant, ProbeSensor, ReadKind, StmtKind, Word};
use lang::kind::Kind;
use lang::plain;

/// An effect with zeros, and the expressions that replace them.
pub type Shaped<'p> = (Effect, Vec<&'p Expr>);

fn dist(expr: &Expr) -> Dist {
    if expr.kind == Kind::Steps { Dist::Steps(0) } else { Dist::Um(0) }
}

fn rate(expr: &Expr) -> Rate {
    if matches!(expr.kind, Kind::StepRate | Kind::StepAccel) { Rate::Steps(0) } else { Rate::Um(0) }
}

fn word(word: &Word) -> Coord {
    Coord { value: dist(&word.value), frame: word.frame }
}

fn words<'p>(to: &'p [Option<Word>; 3], values: &mut Vec<&'p Expr>) -> [Option<Coord>; 3] {
    values.extend(to.iter().flatten().map(|word| &word.value));
    to.each_ref().map(|to| to.as_ref().map(word))
}

/// The effect of a machine statement; `None` for one that is none or has several.
pub fn shape(kind: &StmtKind) -> Option<Shaped<'_>> {
    let mut values = Vec::new();
    let optional = |expr: &Option<Box<Expr>>| expr.as_deref().map(rate);
    let effect = match kind {
        StmtKind::Plain(statement, list) => {
            values.extend(list);
            Effect::Plain(*statement, [0; plain::MOST])
        }
        StmtKind::Sync(own) => {
            values.extend([&own.n, &own.value, &own.lead]);
            Effect::Sync(Action {
                n: 0,
                act: own.kind.with(0),
                lead: if own.lead.kind == Kind::Time { Lead::Time(0) } else { Lead::Way(0) },
            })
        }
        StmtKind::SetAout(n, value) => {
            values.extend([n, value]);
            Effect::SetAout { n: 0, value: 0 }
        }
        StmtKind::MoveAxe { axis, target, relative, start, speed, accel, decel } => {
            let rates = [optional(speed), optional(accel), optional(decel)];
            values.push(target);
            values.extend([speed, accel, decel].into_iter().filter_map(Option::as_deref));
            let frame = if *relative { Frame::Relative } else { Frame::Work };
            Effect::MoveAxe {
                axis: *axis,
                to: Coord { value: dist(target), frame },
                speed: rates[0],
                accel: rates[1],
                decel: rates[2],
                wait: !start,
            }
        }
        StmtKind::MoveSpeed { axis, speed } => {
            values.push(speed);
            Effect::MoveSpeed { axis: *axis, speed: rate(speed) }
        }
        StmtKind::StopAxe(axis) => Effect::StopAxe(*axis),
        StmtKind::WaitMove(axis) => Effect::WaitMove(*axis),
        StmtKind::Probe { axis, limit, speed, sensor, query } => {
            values.push(&limit.value);
            values.extend(speed.as_deref());
            let sensor = match &**sensor {
                ProbeSensor::Default => Sensor::Default,
                ProbeSensor::Input(n, on) => {
                    values.extend([n, on]);
                    Sensor::Input { n: 0, on: false }
                }
                ProbeSensor::Mask(and, xor) => {
                    values.extend([and, xor]);
                    Sensor::Mask { and: 0, xor: 0 }
                }
            };
            let speed = optional(speed);
            Effect::Probe { axis: *axis, limit: word(limit), speed, sensor, query: *query }
        }
        StmtKind::SetPos { axis, value } => {
            values.push(value);
            Effect::SetPos { axis: *axis, value: 0 }
        }
        StmtKind::Motors { on, axis } => {
            values.push(on);
            Effect::Motors { on: false, axis: *axis }
        }
        StmtKind::WaitIn { n, want, timeout, query } => {
            values.push(n);
            let want = match want {
                InWant::Level(level) => {
                    values.push(level);
                    Want::On
                }
                InWant::Edge(want) => *want,
            };
            values.extend(timeout.as_deref());
            Effect::WaitIn { n: 0, want, timeout: timeout.as_ref().map(|_| 0), query: *query }
        }
        StmtKind::WaitChar { c, timeout, query } => {
            values.push(c);
            values.extend(timeout.as_deref());
            Effect::WaitChar { c: 0, timeout: timeout.as_ref().map(|_| 0), query: *query }
        }
        StmtKind::SetFeed(feed) => {
            values.push(feed);
            Effect::SetFeed(rate(feed))
        }
        StmtKind::SetSpindle(speed) => {
            values.push(speed);
            Effect::SetSpindle(0)
        }
        StmtKind::Linear { rapid, to, exact } => {
            Effect::Linear { rapid: *rapid, to: words(to, &mut values), exact: *exact }
        }
        StmtKind::Arc { clockwise, plane, to, center, exact } => {
            let to = words(to, &mut values);
            let center = match center {
                ArcCenter::Offsets(offsets) => {
                    values.extend(offsets.iter().flatten());
                    let offset = |offset: &Option<Expr>| offset.as_ref().map_or(Dist::Um(0), dist);
                    Center::Offsets(offsets.each_ref().map(offset))
                }
                ArcCenter::Radius(radius) => {
                    values.push(radius);
                    Center::Radius(dist(radius))
                }
            };
            Effect::Arc { clockwise: *clockwise, plane: *plane, to, center, exact: *exact }
        }
        StmtKind::OnInput { slot, n, want, .. } => {
            values.push(n);
            Effect::OnInput { slot: *slot, n: 0, want: *want }
        }
        StmtKind::OffInput(n) => {
            values.push(n);
            Effect::OffInput(0)
        }
        StmtKind::OnEvery { slot, every, .. } => {
            values.push(every);
            Effect::OnEvery { slot: *slot, ms: 0 }
        }
        StmtKind::OffEvery => Effect::OffEvery,
        _ => return None,
    };
    Some((effect, values))
}

/// Which offsets of an arc are given: absent ones take no value.
pub fn given(kind: &StmtKind) -> [bool; 3] {
    match kind {
        StmtKind::Arc { center: ArcCenter::Offsets(offsets), .. } => {
            offsets.each_ref().map(Option::is_some)
        }
        _ => [true; 3],
    }
}

/// Whether WaitIn's level comes as a value.
pub fn has_level(kind: &StmtKind) -> bool {
    matches!(kind, StmtKind::WaitIn { want: InWant::Level(_), .. })
}

/// A look at the machine and its argument.
pub fn look(kind: &ReadKind) -> (Read, Option<&Expr>) {
    match kind {
        ReadKind::In(n) => (Read::In(0), Some(n)),
        ReadKind::InPort => (Read::InPort, None),
        ReadKind::Out(n) => (Read::Out(0), Some(n)),
        ReadKind::Pos(axis) => (Read::Pos(*axis), None),
        ReadKind::PosSteps(axis) => (Read::PosSteps(*axis), None),
        ReadKind::Probed(axis) => (Read::Probed(*axis), None),
        ReadKind::ProbedSteps(axis) => (Read::ProbedSteps(*axis), None),
        ReadKind::ProbeOk(axis) => (Read::ProbeOk(*axis), None),
        ReadKind::Moving(axis) => (Read::Moving(*axis), None),
        ReadKind::Homed(axis) => (Read::Homed(*axis), None),
        ReadKind::Timer => (Read::Timer, None),
        ReadKind::TimedOut => (Read::TimedOut, None),
        ReadKind::CharIn => (Read::CharIn, None),
        ReadKind::Analog(n) => (Read::Analog(*n), None),
    }
}

/// A statement's effect, waiting for its values.
#[derive(Clone, Copy, Debug)]
pub struct Template {
    /// With zeros.
    pub effect: Effect,
    /// Line of the statement.
    pub line: u32,
    /// See [`given`].
    pub given: [bool; 3],
    /// See [`has_level`].
    pub level: bool,
    /// Block that goes on with the wait after a handler.
    pub resume: i32,
}

impl Template {
    /// The effect with `values` in the order of [`shape`].
    pub fn fill(&self, values: &[i32]) -> Effect {
        let mut values = values.iter().copied();
        let mut next = || values.next().unwrap_or(0);
        let mut effect = self.effect;
        match &mut effect {
            Effect::Plain(statement, list) => {
                let given = list.iter_mut().take(statement.arguments().len());
                given.for_each(|value| *value = next());
            }
            Effect::Sync(own) => {
                own.n = next();
                own.act = own.act.parts().0.with(next());
                let (Lead::Way(value) | Lead::Time(value)) = &mut own.lead;
                *value = next();
            }
            Effect::SetAout { n, value } => {
                *n = next();
                *value = next();
            }
            Effect::MoveAxe { to, speed, accel, decel, .. } => {
                set_dist(&mut to.value, next());
                [speed, accel, decel].into_iter().flatten().for_each(|r| set_rate(r, next()));
            }
            Effect::MoveSpeed { speed, .. } | Effect::SetFeed(speed) => set_rate(speed, next()),
            Effect::Linear { to, .. } => {
                to.iter_mut().flatten().for_each(|word| set_dist(&mut word.value, next()));
            }
            Effect::Arc { to, center, .. } => {
                to.iter_mut().flatten().for_each(|word| set_dist(&mut word.value, next()));
                match center {
                    Center::Offsets(offsets) => {
                        for (offset, given) in offsets.iter_mut().zip(self.given) {
                            if given {
                                set_dist(offset, next());
                            }
                        }
                    }
                    Center::Radius(radius) => set_dist(radius, next()),
                }
            }
            Effect::Probe { limit, speed, sensor, .. } => {
                set_dist(&mut limit.value, next());
                if let Some(speed) = speed {
                    set_rate(speed, next());
                }
                match sensor {
                    Sensor::Default => {}
                    Sensor::Input { n, on } => {
                        *n = next();
                        *on = next() != 0;
                    }
                    Sensor::Mask { and, xor } => {
                        *and = next();
                        *xor = next();
                    }
                }
            }
            Effect::WaitIn { n, want, timeout, .. } => {
                *n = next();
                if self.level {
                    *want = if next() != 0 { Want::On } else { Want::Off };
                }
                timeout.iter_mut().for_each(|timeout| *timeout = next());
            }
            Effect::WaitChar { c, timeout, .. } => {
                *c = next();
                timeout.iter_mut().for_each(|timeout| *timeout = next());
            }
            Effect::Motors { on, .. } => *on = next() != 0,
            Effect::SetPos { value, .. }
            | Effect::SetSpindle(value)
            | Effect::PrintValue(value, _)
            | Effect::OffInput(value)
            | Effect::OnInput { n: value, .. }
            | Effect::OnEvery { ms: value, .. }
            | Effect::Read(Read::In(value) | Read::Out(value)) => *value = next(),
            _ => {}
        }
        effect
    }
}

fn set_dist(dist: &mut Dist, to: i32) {
    let (Dist::Um(value) | Dist::Steps(value)) = dist;
    *value = to;
}

fn set_rate(rate: &mut Rate, to: i32) {
    let (Rate::Um(value) | Rate::Steps(value)) = rate;
    *value = to;
}
