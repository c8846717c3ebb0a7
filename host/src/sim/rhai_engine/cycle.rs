//! Canned cycles (lang/README.md, G-code): each becomes the moves that it stands for.

use lang::axis::Axis;
use lang::effect::{Coord, Dist, Effect, Frame, Read};
use lang::fault::Fault;
use lang::hir::{Cycle, CycleKind, Expr, Stmt};
use lang::kind::Kind;
use lang::plain::Plain;

use super::translate::Translator;
use crate::sim::controlled::Machine;
use crate::sim::machine::scaled;
use crate::sim::step::Step;

/// How far above the last depth the rapid of a G83 ends, um.
const PECK_CLEARANCE: i32 = 250;

/// A cycle without its values.
#[derive(Clone, Debug)]
pub struct Plan {
    line: u32,
    kind: Kinds,
    /// R: in steps, relative to Z before the cycle.
    r: (bool, bool),
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
        let mut values = vec![&cycle.z.value, &cycle.r.value];
        values.extend(&cycle.repeats);
        values.extend(cycle.xy.iter().flatten().map(|word| &word.value));
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
            r: (in_steps(&cycle.r.value), cycle.r.frame == Frame::Relative),
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
    /// A fault came by itself in a move.
    Late(Fault),
    /// The run is over.
    Stop,
}

impl From<Fault> for Broken {
    fn from(fault: Fault) -> Broken {
        Broken::Fault(fault)
    }
}

/// Places of Z and lengths along it, in one of its units.
#[derive(Clone, Copy)]
struct ZUnit {
    in_steps: bool,
    /// Steps and um.
    scale: (u16, u16),
}

impl ZUnit {
    fn coord(self, value: i32, frame: Frame) -> Coord {
        let value = if self.in_steps { Dist::Steps(value) } else { Dist::Um(value) };
        Coord { value, frame }
    }

    /// A distance that is in steps or in um.
    fn length(self, value: i32, steps: bool) -> Result<i32, Fault> {
        let (steps_of, um) = self.scale;
        match (self.in_steps, steps) {
            (true, false) => scaled(value, steps_of, um),
            (false, true) => scaled(value, um, steps_of),
            _ => Ok(value),
        }
    }
}

/// The moves of one cycle.
struct Tool<'m> {
    machine: &'m mut Machine,
}

impl Tool<'_> {
    fn act(&mut self, effect: &Effect) -> Result<i32, Broken> {
        match self.machine.begin(effect) {
            Step::Done(value) => Ok(value),
            Step::Fault(fault) => Err(Broken::Fault(fault)),
            Step::Late(fault) => Err(Broken::Late(fault)),
            Step::Event(_) | Step::Stop => Err(Broken::Stop),
        }
    }

    fn z(&mut self, rapid: bool, to: Coord, exact: bool) -> Result<(), Broken> {
        let to = [None, None, Some(to)];
        self.act(&Effect::Linear { rapid, to, exact }).map(|_| ())
    }

    fn rapid(&mut self, unit: ZUnit, value: i32) -> Result<(), Broken> {
        self.z(true, unit.coord(value, Frame::Work), false)
    }

    /// Z now.
    fn present(&mut self, unit: ZUnit) -> Result<i32, Broken> {
        let read = if unit.in_steps { Read::PosSteps(Axis::Z) } else { Read::Pos(Axis::Z) };
        self.act(&Effect::Read(read))
    }

    /// G83 from R, where Z is: `base` in the unit of the bottom. `depth` is positive.
    fn peck(
        &mut self,
        plan: &Plan,
        unit: ZUnit,
        base: i32,
        z: i32,
        depth: i32,
    ) -> Result<(), Broken> {
        // Depths count as the bottom does.
        let origin = if plan.z.1 { base } else { 0 };
        let mut reached = base - origin;
        loop {
            reached = reached.checked_sub(depth).ok_or(Fault::Overflow)?.max(z);
            let to = sum(reached, origin)?;
            self.z(false, unit.coord(to, Frame::Work), plan.exact)?;
            if reached <= z {
                return Ok(());
            }
            self.rapid(unit, base)?;
            self.rapid(unit, sum(to, unit.length(PECK_CLEARANCE, false)?)?)?;
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
    let mut tool = Tool { machine };
    let unit = |in_steps| ZUnit { in_steps, scale: plan.scale };
    let mut values = values.iter().copied();
    let mut next = || values.next().unwrap_or(0);
    let z = next();
    let mut first_level = next();
    let repeats = if plan.repeats { next() } else { 1 };
    let xy = plan.xy.map(|word| word.map(|word| (word, next())));
    let parameter = if plan.kind == Kinds::Drill { 0 } else { next() };
    let old_z = plan.old_z.then(&mut next);
    let z_unit = unit(plan.z.0);
    if plan.kind == Kinds::Peck && parameter <= 0 {
        return Err(Fault::ValueRange.into());
    }
    if plan.r.1 {
        first_level = sum(first_level, tool.present(unit(plan.r.0))?)?;
    }
    for _ in 0..repeats.max(0) {
        let (mut r, mut r_unit) = (first_level, unit(plan.r.0));
        let up = r.max(tool.present(r_unit)?);
        tool.rapid(r_unit, up)?;
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
        tool.rapid(r_unit, r)?;
        if old_z.is_some() && r_unit.in_steps {
            // Only at R its place is known in work um, to be compared with the old Z.
            r_unit = unit(false);
            r = tool.present(r_unit)?;
        }
        if plan.kind == Kinds::Peck {
            let same = z_unit.in_steps == r_unit.in_steps;
            let base = if same { r } else { tool.present(z_unit)? };
            let depth = z_unit.length(parameter, plan.depth_in_steps)?;
            tool.peck(plan, z_unit, base, z, depth)?;
        } else {
            let frame = if plan.z.1 { Frame::Relative } else { Frame::Work };
            tool.z(false, z_unit.coord(z, frame), plan.exact)?;
            if plan.kind == Kinds::Dwell {
                tool.act(&Effect::Plain(Plain::Wait, [parameter, 0]))?;
            }
        }
        let top = old_z.map_or(r, |old| old.max(r));
        tool.rapid(r_unit, top)?;
    }
    Ok(())
}
