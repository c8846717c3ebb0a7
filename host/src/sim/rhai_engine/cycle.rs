//! Canned cycles (language.md, G-code lines): each becomes the moves that it stands for.

use lang::axis::Axis;
use lang::effect::{Coord, Dist, Effect, Frame, Read};
use lang::fault::Fault;
use lang::hir::{Cycle, CycleKind, Expr, Stmt};
use lang::kind::Kind;

use super::translate::Translator;
use crate::sim::machine::{Machine, Step, scaled};

/// How far above the last depth the rapid of a G83 ends, um.
const PECK_CLEARANCE: i32 = 250;

/// A cycle without its values.
#[derive(Clone, Debug)]
pub struct Plan {
    line: u32,
    kind: Kinds,
    /// R, and every Z with it, is in steps.
    in_steps: bool,
    r_relative: bool,
    /// Bottom: in steps, relative to R.
    z: (bool, bool),
    /// X and Y words: in steps, frame.
    xy: [Option<(bool, Frame)>; 2],
    /// Peck depth in steps.
    depth_in_steps: bool,
    repeats: bool,
    exact: bool,
    old_z: bool,
    /// Steps and um of the Z axis.
    scale: (u16, u16),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kinds {
    Drill,
    Dwell,
    Peck,
}

fn in_steps(expr: &Expr) -> bool {
    expr.kind == Kind::Steps
}

impl Translator<'_> {
    /// G81, G82, G83.
    pub(super) fn cycle(&mut self, stmt: &Stmt, cycle: &Cycle) {
        if let (Some(old_z), true) = (cycle.old_z, cycle.takes_z) {
            let look = self.look_at(Read::Pos(Axis::Z));
            self.out.line(format!("v{} = {look};", old_z.0));
        }
        let mut values = vec![&cycle.r.value];
        values.extend(&cycle.repeats);
        values.extend(cycle.xy.iter().flatten().map(|word| &word.value));
        values.push(&cycle.z.value);
        let (kind, depth_in_steps) = match &cycle.kind {
            CycleKind::Drill => (Kinds::Drill, false),
            CycleKind::Dwell(time) => {
                values.push(time);
                (Kinds::Dwell, false)
            }
            CycleKind::Peck(depth) => {
                values.push(depth);
                (Kinds::Peck, in_steps(depth))
            }
        };
        let mut values = self.values(&values);
        if let Some(old_z) = cycle.old_z {
            values.push(format!("v{}", old_z.0));
        }
        let scale = self.program.profile.z.as_ref().map_or((1, 1), |z| (z.scale.steps, z.scale.um));
        let plan = Plan {
            line: stmt.line,
            kind,
            in_steps: in_steps(&cycle.r.value),
            r_relative: cycle.r.frame == Frame::Relative,
            z: (in_steps(&cycle.z.value), cycle.z.frame == Frame::Relative),
            xy: cycle
                .xy
                .each_ref()
                .map(|word| word.as_ref().map(|word| (in_steps(&word.value), word.frame))),
            depth_in_steps,
            repeats: cycle.repeats.is_some(),
            exact: cycle.exact,
            old_z: cycle.old_z.is_some(),
            scale,
        };
        self.cycles.push(plan);
        self.out.flush();
        let number = self.cycles.len() - 1;
        self.out.line(format!("cy({number}, [{}]);", values.join(", ")));
    }
}

/// How a cycle did not come to its end.
pub enum Broken {
    /// A move failed.
    Fault(Fault),
    /// The run is over.
    Stop,
}

impl From<Fault> for Broken {
    fn from(fault: Fault) -> Broken {
        Broken::Fault(fault)
    }
}

/// The moves of one cycle.
struct Tool<'m> {
    machine: &'m mut Machine,
    in_steps: bool,
    scale: (u16, u16),
}

impl Tool<'_> {
    fn act(&mut self, effect: &Effect) -> Result<i32, Broken> {
        match self.machine.begin(effect) {
            Step::Done(value) => Ok(value),
            Step::Fault(fault) | Step::Late(fault) => Err(Broken::Fault(fault)),
            Step::Event(_) | Step::Stop => Err(Broken::Stop),
        }
    }

    /// A Z move in the unit of R.
    fn z(&mut self, rapid: bool, value: i32, exact: bool) -> Result<(), Broken> {
        let value = if self.in_steps { Dist::Steps(value) } else { Dist::Um(value) };
        let to = [None, None, Some(Coord { value, frame: Frame::Work })];
        self.act(&Effect::Linear { rapid, to, exact }).map(|_| ())
    }

    /// Z now, in the unit of R.
    fn present(&mut self) -> Result<i32, Broken> {
        let read = if self.in_steps { Read::PosSteps(Axis::Z) } else { Read::Pos(Axis::Z) };
        self.act(&Effect::Read(read))
    }

    fn in_unit(&self, value: i32, steps: bool) -> Result<i32, Fault> {
        let (steps_of, um) = self.scale;
        match (self.in_steps, steps) {
            (true, false) => scaled(value, steps_of, um),
            (false, true) => scaled(value, um, steps_of),
            _ => Ok(value),
        }
    }
}

fn sum(a: i32, b: i32) -> Result<i32, Fault> {
    a.checked_add(b).ok_or(Fault::Overflow)
}

/// Runs a cycle with its values in the order of the translation.
///
/// # Errors
/// A move failed, or the run is over.
pub fn run(machine: &mut Machine, plan: &Plan, values: &[i32]) -> Result<(), Broken> {
    machine.set_line(plan.line);
    let mut tool = Tool { machine, in_steps: plan.in_steps, scale: plan.scale };
    let mut values = values.iter().copied();
    let mut next = || values.next().unwrap_or(0);
    let mut r = next();
    let repeats = if plan.repeats { next() } else { 1 };
    let xy = plan.xy.map(|word| word.map(|word| (word, next())));
    let z = next();
    let parameter = if plan.kind == Kinds::Drill { 0 } else { next() };
    let old_z = plan.old_z.then(&mut next);
    if plan.r_relative {
        r = sum(r, tool.present()?)?;
    }
    for _ in 0..repeats.max(0) {
        let up = r.max(tool.present()?);
        tool.z(true, up, false)?;
        if xy.iter().any(Option::is_some) {
            let word = |word: Option<((bool, Frame), i32)>| {
                word.map(|((steps, frame), value)| Coord {
                    value: if steps { Dist::Steps(value) } else { Dist::Um(value) },
                    frame,
                })
            };
            let to = [word(xy[0]), word(xy[1]), None];
            tool.act(&Effect::Linear { rapid: true, to, exact: false })?;
        }
        tool.z(true, r, false)?;
        let (z_steps, z_relative) = plan.z;
        if plan.kind == Kinds::Peck {
            let bottom = tool.in_unit(z, z_steps)?;
            let depth = tool.in_unit(parameter, plan.depth_in_steps)?;
            let base = if z_relative { r } else { 0 };
            let mut reached = if z_relative { 0 } else { r };
            loop {
                reached = reached.checked_sub(depth).ok_or(Fault::Overflow)?.max(bottom);
                tool.z(false, sum(reached, base)?, plan.exact)?;
                if reached <= bottom {
                    break;
                }
                tool.z(true, r, false)?;
                let clear = tool.in_unit(PECK_CLEARANCE, false)?;
                tool.z(true, sum(sum(reached, base)?, clear)?, false)?;
            }
        } else {
            let value = if z_steps { Dist::Steps(z) } else { Dist::Um(z) };
            let frame = if z_relative { Frame::Relative } else { Frame::Work };
            let to = [None, None, Some(Coord { value, frame })];
            tool.act(&Effect::Linear { rapid: false, to, exact: plan.exact })?;
            if plan.kind == Kinds::Dwell {
                tool.act(&Effect::Wait(parameter))?;
            }
        }
        match old_z {
            Some(old) if plan.in_steps => {
                tool.z(true, r, false)?;
                let here = tool.act(&Effect::Read(Read::Pos(Axis::Z)))?;
                let to = Coord { value: Dist::Um(old.max(here)), frame: Frame::Work };
                tool.act(&Effect::Linear {
                    rapid: true,
                    to: [None, None, Some(to)],
                    exact: false,
                })?;
            }
            Some(old) => tool.z(true, r.max(old), false)?,
            None => tool.z(true, r, false)?,
        }
    }
    Ok(())
}
