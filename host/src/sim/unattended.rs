//! What an unattended run ([`World::unattended`]) assumed, as notes for the user.

use lang::axis::Axis;
use lang::hir::{Block, Program, StmtKind};
use lang::profile::AxisProfile;

use super::chain::Chain;
use super::world::World;
use super::{Engine, Options, SimError, run_chain};

/// Statements after which the look ahead for [`switches`] gives up.
const LOOK_AHEAD: u64 = 5_000_000;

/// See the module.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Unattended {
    /// Lines whose wait for Start was ended by a press that nobody made.
    pub released: Vec<u32>,
    /// The least and the greatest place that each axis reached, steps from power-up.
    pub reached: [[i32; 2]; 3],
    /// Where the switch of each axis stands that was homed, steps from power-up.
    pub switches: [Option<i32>; 3],
}

impl Unattended {
    /// A line for each thing that a user should know; `line_of` makes the line in the user's file
    /// of one in the script.
    pub fn notes(&self, program: &Program, line_of: impl Fn(u32) -> u32) -> Vec<String> {
        let mut notes = Vec::new();
        if let Some(first) = self.released.first() {
            let more = match self.released.len() - 1 {
                0 => String::new(),
                n => format!(" and {n} more"),
            };
            notes.push(format!(
                "the wait for Start in line {}{more} went on by itself after 1 s: a world may say \
                 when Start is pressed",
                line_of(*first)
            ));
        }
        for (axis, own) in program.profile.axes() {
            // What MoveSpeed drives is a belt or a turntable, which has no end.
            let endless = program.routines.iter().any(|routine| runs_on(&routine.body, axis));
            if self.switches[axis.index()].is_none() && !endless {
                notes.extend(self.travel_note(axis, own, &program.profile.name));
            }
        }
        notes
    }

    /// Where an axis that was never homed must begin so that the job lies inside the travel, when
    /// it does not as it is.
    fn travel_note(&self, axis: Axis, own: &AxisProfile, machine: &str) -> Option<String> {
        let um = |steps: i32| {
            i64::from(steps) * i64::from(own.scale.um) / i64::from(own.scale.steps).max(1)
        };
        let [least, greatest] = self.reached[axis.index()].map(um);
        let [first, last] = [own.min_um, own.max_um].map(i64::from);
        if first <= least && greatest <= last {
            return None;
        }
        let letter = axis.letter();
        let mm = |um: i64| format!("{:.3}", um as f64 / 1000.0);
        let reach = format!("{letter} goes from {} to {} mm", mm(least), mm(greatest));
        if greatest - least > last - first {
            let span = mm(last - first);
            return Some(format!(
                "{reach}: `{machine}` has a travel of {span} mm, it does not fit; make it smaller, or name a machine \
                 with that travel by PROFILE or --profile"
            ));
        }
        let zero = if least < first { first - least } else { last - greatest };
        Some(format!(
            "{reach}: the work zero is taken to lie at {letter} {} of `{machine}`, whose travel is \
             {} to {} mm",
            mm(zero),
            mm(first),
            mm(last)
        ))
    }
}

/// Where the reference switches of the axes stand that the programs home, found by running it; for
/// an engine whose switches must be up when the run begins.
///
/// # Errors
/// Those of [`run_chain`].
pub fn switches(chain: &Chain<'_>, options: &Options) -> Result<[Option<i32>; 3], SimError> {
    let mut routines = chain.programs().iter().flat_map(|program| &program.routines);
    if !routines.any(|routine| homes(&routine.body)) {
        return Ok([None; 3]);
    }
    let options =
        Options { record: false, statements: LOOK_AHEAD.min(options.statements), ..*options };
    let outcome = run_chain(chain, Engine::Rhai, &World::unattended(), &options, Box::new(|_| {}))?;
    Ok(outcome.unattended.switches)
}

/// Whether a MoveSpeed drives the axis.
fn runs_on(block: &Block, axis: Axis) -> bool {
    block.iter().any(|stmt| {
        matches!(&stmt.kind, StmtKind::MoveSpeed { axis: own, .. } if *own == axis)
            || stmt.kind.blocks().into_iter().any(|block| runs_on(block, axis))
    })
}

/// Blocks nest at most as deep as the parser lets them.
fn homes(block: &Block) -> bool {
    block.iter().any(|stmt| {
        matches!(stmt.kind, StmtKind::Home { .. }) || stmt.kind.blocks().into_iter().any(homes)
    })
}
