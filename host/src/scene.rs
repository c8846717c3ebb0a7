//! A cell around a simulated machine: finds and reads `NAME.cell.toml`, gives it the names and the frame of a profile,
//! and reports at the end of a run which expectations hold.
//!
//! A [`Scene`] belongs to a [`World`](crate::sim::world::World). An engine that runs that world on a board, emulated or
//! native, puts the cell into the plant around its pins (`live`), so that every engine sees the same cell.

pub mod heard;
#[cfg(feature = "desktop")]
pub mod junit;
pub mod live;
pub mod picture;
#[cfg(feature = "desktop")]
pub mod proof;
#[cfg(feature = "desktop")]
pub mod replay;
pub mod report;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use cell::check::strikes;
use cell::kernel::Frame;
use cell::problem::Problem;
use cell::scene::Eye;
use cell::{Names, Port};
use lang::axis::Axis;
use lang::hir::{Block, Program, StmtKind};
use lang::profile::{AxisProfile, Direction, InputRole, OutputRole, Profile};
use lang::vm::math;

pub use self::report::Report;
use crate::render::Note;

/// Where the head of a script that homes stands at power-up when the cell does not say: so far off each switch, mm.
const AWAY_MM: f64 = 20.0;

/// A cell file, read for a script's machine.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The cell.
    pub cell: Arc<cell::scene::Scene>,
    /// The file as it was named.
    pub file: String,
    /// Whether the script has a Home.
    pub homes: bool,
    /// What of it is otherwise in this run.
    pub deviations: Arc<Vec<cell::vary::Deviation>>,
}

impl PartialEq for Scene {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.cell, &other.cell) && self.deviations == other.deviations
    }
}

impl Eq for Scene {}

/// The cell that stands beside a script, if one does: `drill.cell.toml` beside `drill.bas`.
#[must_use]
pub fn beside(script: &str) -> Option<String> {
    let path = Path::new(script).with_extension("cell.toml");
    (script != "-" && path.is_file()).then(|| path.display().to_string())
}

/// Whether a name is one of a cell file.
#[must_use]
pub fn is_cell(name: &str) -> bool {
    name.ends_with(".cell.toml")
}

/// Reads a cell for a script, or for a machine alone. Warnings come with it.
///
/// # Errors
/// It cannot be read, or is wrong: every problem with its place.
pub fn read(
    file: &str,
    profile: &Profile,
    program: Option<&Program>,
) -> Result<(Scene, Vec<Note>), Vec<Note>> {
    let text = crate::input::read_text(file).map_err(|note| vec![*note])?;
    let known = Known { profile, program, axes: axes(profile) };
    let travel = |letter: char| {
        let axis = Axis::from_letter(letter)?;
        let own = profile.axis(axis)?;
        let [a, b] = [own.min_um, own.max_um].map(|um| f64::from(um) / 1000.0 * up(axis, own));
        Some((a.min(b), a.max(b)))
    };
    let beside = PathBuf::from(file);
    let files = |name: &str| read_named(&beside, name);
    let note = |problem: &Problem| {
        let (line, column) = problem.place(&text);
        let at = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        // Included files stand beside the cell.
        let own = problem.of.as_ref().map(|of| beside.with_file_name(&of.0).display().to_string());
        let note = Note::error(own.as_deref().unwrap_or(file), problem.code, problem.text.clone())
            .at((at(line), at(column)));
        let note = Note { span: problem.span.clone(), ..note };
        let note = if problem.error { note } else { note.warning() };
        match &problem.hint {
            Some(hint) => note.hint(hint.clone()),
            None => note,
        }
    };
    let notes = |problems: Vec<Problem>| problems.iter().map(note).collect::<Vec<Note>>();
    let (cell, problems) = cell::read(&text, &known, &travel, &files).map_err(notes)?;
    let homes = program
        .is_some_and(|program| program.routines.iter().any(|routine| has_home(&routine.body)));
    let scene =
        Scene { cell: Arc::new(cell), file: file.to_owned(), homes, deviations: Arc::default() };
    Ok((scene, notes(problems)))
}

/// A file that a cell names, beside it.
fn read_named(cell: &Path, name: &str) -> Result<String, String> {
    let path = cell.with_file_name(name);
    crate::input::read_text(&path.display().to_string()).map_err(|note| note.text)
}

/// Blocks nest at most as deep as the parser lets them.
fn has_home(block: &Block) -> bool {
    block.iter().any(|stmt| {
        matches!(stmt.kind, StmtKind::Home { .. }) || stmt.kind.blocks().into_iter().any(has_home)
    })
}

/// 1 where larger positions of the axis are larger places of the cell's frame, else -1. Z of the frame points up, and
/// the reference switch of Z is at the top.
fn up(axis: Axis, own: &AxisProfile) -> f64 {
    if axis == Axis::Z && own.home.direction == Direction::Negative { -1.0 } else { 1.0 }
}

/// Letters of the axes that a machine has.
fn axes(profile: &Profile) -> String {
    profile.axes().map(|(axis, _)| axis.letter()).collect()
}

impl Scene {
    /// Whether each of these deviations strikes somebody in the cell, or an axis of the machine.
    ///
    /// # Errors
    /// The first that does not, with the remedy.
    pub fn strikes(
        &self,
        profile: &Profile,
        deviations: &[cell::vary::Deviation],
    ) -> Result<(), String> {
        let known = Known { profile, program: None, axes: axes(profile) };
        deviations.iter().try_for_each(|one| strikes::deviation(&self.cell, &known, one))
    }

    /// The same with deviations: numbers are changed in the cell, faults strike during the run.
    #[must_use]
    pub fn deviating(&self, deviations: Vec<cell::vary::Deviation>) -> Self {
        let cell = cell::vary::applied((*self.cell).clone(), &deviations);
        Self { cell: Arc::new(cell), deviations: Arc::new(deviations), ..self.clone() }
    }

    /// A file that an expectation names.
    fn file_named(&self, name: &str) -> Result<String, String> {
        read_named(Path::new(&self.file), name)
    }

    /// Where the reference switch of an axis closes by the cell, mm of its frame: a sensor of kind switch that drives no
    /// input, or the one with the role.
    fn switch_of(&self, axis: Axis, profile: &Profile) -> Option<f64> {
        let role = match axis {
            Axis::X => InputRole::ReferenceX,
            Axis::Y => InputRole::ReferenceY,
            Axis::Z => InputRole::ReferenceZ,
        };
        let own = profile.input_with(role).and_then(|input| u32::try_from(input.n).ok());
        self.cell.sensors.iter().find_map(|sensor| match sensor.eye {
            Eye::Switch(letter, place, _) if letter == axis.letter() => {
                (sensor.input.is_none() || sensor.input == own).then_some(place)
            }
            _ => None,
        })
    }

    /// The frame of the cell on a machine, and where each reference switch closes, steps from power-up. `placed` are
    /// switches that a world has put somewhere: they say where the head stands.
    #[must_use]
    pub fn frame(&self, profile: &Profile, placed: [Option<i32>; 3]) -> (Frame, [Option<i64>; 3]) {
        let mut frame = Frame { scale: [1.0; 3], start: [0.0; 3] };
        let mut switches = [None; 3];
        for (axis, own) in profile.axes() {
            let (i, up) = (axis.index(), up(axis, own));
            let per_mm = f64::from(own.scale.steps) * 1000.0 / f64::from(own.scale.um);
            let toward = i64::from(own.home.direction.sign());
            let opens = math::scale(own.home.position_um, own.scale.steps, own.scale.um);
            let opens = i64::from(opens.unwrap_or_default());
            // Where the head stands at power-up, machine steps.
            let given = self.cell.start.map(|start| (start[i] * up * per_mm).round() as i64);
            let start = match (placed[i], given) {
                (Some(place), _) => opens + toward - i64::from(place),
                (None, Some(start)) => start,
                // The switch closes that far off.
                (None, None) if self.homes => {
                    opens + toward - toward * (AWAY_MM * per_mm).round() as i64
                }
                (None, None) => 0,
            };
            frame.scale[i] = per_mm * up;
            frame.start[i] = start as f64 / per_mm * up;
            let stands = self.homes || given.is_some() || placed[i].is_some();
            // The switch opens at its machine position: it is closed from the next step on. One that the cell gives a
            // place closes there, wherever the profile believes it to be.
            let moved = self.switch_of(axis, profile).map(|mm| (mm * up * per_mm).round() as i64);
            switches[i] = stands.then_some(moved.unwrap_or(opens + toward) - start);
        }
        (frame, switches)
    }
}

/// What a profile and a script call by a name.
struct Known<'a> {
    profile: &'a Profile,
    program: Option<&'a Program>,
    axes: String,
}

impl Known<'_> {
    fn ports(&self, output: bool) -> Vec<(String, u32)> {
        let own = self.program.into_iter().flat_map(|program| &program.ports);
        let own = own.filter(|port| port.output == output).map(|port| (port.name.clone(), port.n));
        let mut all: Vec<(String, i32)> = own.collect();
        let role = |text: serde_json::Value| text.as_str().map(str::to_owned);
        let mut add = |name: Option<String>, n: i32| all.extend(name.map(|name| (name, n)));
        if output {
            for port in &self.profile.outputs {
                add(port.name.clone(), port.n);
                add(
                    port.role.and_then(|own: OutputRole| role(serde_json::to_value(own).ok()?)),
                    port.n,
                );
            }
        } else {
            for port in &self.profile.inputs {
                add(port.name.clone(), port.n);
                add(
                    port.role.and_then(|own: InputRole| role(serde_json::to_value(own).ok()?)),
                    port.n,
                );
            }
            add(
                (self.profile.probe_input() != 0).then(|| "probe".to_owned()),
                self.profile.probe_input(),
            );
        }
        let number = |(name, n)| u32::try_from(n).ok().map(|n| (name, n));
        all.into_iter().filter_map(number).collect()
    }

    /// Analog inputs by the names of the profile and of the script.
    fn analogs(&self) -> Vec<(String, u32)> {
        let own = self.program.into_iter().flat_map(|program| &program.analogs);
        let own = own.map(|(name, n)| (Some(name.clone()), *n));
        let all = own.chain(self.profile.analogs.iter().map(|own| (own.name.clone(), own.n)));
        all.filter_map(|(name, n)| Some((name?, u32::try_from(n).ok()?))).collect()
    }

    fn find(&self, output: bool, name: &str) -> Option<u32> {
        let ports = self.ports(output);
        ports.into_iter().find(|(own, _)| own.eq_ignore_ascii_case(name)).map(|(_, n)| n)
    }
}

impl Names for Known<'_> {
    fn input(&self, name: &str) -> Option<u32> {
        self.find(false, name)
    }
    fn output(&self, name: &str) -> Option<u32> {
        self.find(true, name)
    }
    fn analog(&self, name: &str) -> Option<u32> {
        let all = self.analogs();
        all.into_iter().find(|(own, _)| own.eq_ignore_ascii_case(name)).map(|(_, n)| n)
    }
    // No part has counters yet.
    fn counter(&self, _: &str) -> Option<u32> {
        None
    }
    fn known(&self, port: Port) -> Vec<String> {
        let mut names: Vec<String> = match port {
            Port::Input => self.ports(false),
            Port::Output => self.ports(true),
            Port::Analog => self.analogs(),
            Port::Counter => Vec::new(),
        }
        .into_iter()
        .map(|(name, _)| name)
        .collect();
        names.sort();
        names.dedup();
        names
    }
    fn with_role(&self, port: Port, role: &str) -> Option<u32> {
        let own = match port {
            Port::Output => {
                let role = OutputRole::ALL.into_iter().find(|own| own.name() == role)?;
                self.profile.output_with(role)?.n
            }
            Port::Input if role == "probe" => {
                Some(self.profile.probe_input()).filter(|n| *n != 0)?
            }
            Port::Input => {
                let role = InputRole::ALL.into_iter().find(|own| own.name() == role)?;
                self.profile.input_with(role)?.n
            }
            Port::Analog | Port::Counter => return None,
        };
        u32::try_from(own).ok()
    }
    fn profile(&self) -> &str {
        &self.profile.name
    }
    fn has_analog(&self) -> bool {
        // Engines without an emulator simulate the part that has them.
        true
    }
    fn has(&self, port: Port, n: u32) -> bool {
        match port {
            Port::Input | Port::Output => true,
            Port::Analog => self.profile.analogs.iter().any(|own| u32::try_from(own.n) == Ok(n)),
            Port::Counter => false,
        }
    }
    fn axes(&self) -> &str {
        &self.axes
    }
}
