//! `--part`: which chip's firmware.

use std::ops::Range;

use clap::Args;
use lang::back::Compiled;
use lang::hir::{Limits, Program, Stmt, StmtKind, Storage, Var};
use lang::image::Image;
use lang::part::{Lack, PARTS, Part, SHORT_PULSE_US, Signals};
use lang::record::feature;

use super::arcs;
use super::console::Console;
use super::script::Script;
use crate::board::{BUILDS, Build, DEFAULT, F5529};
use crate::course::{self, Obstacle};
use crate::failure::Failure;
use crate::render::Note;

/// The option of the commands that have to do with a board's chip.
#[derive(Clone, Copy, Debug, Args)]
pub struct Choice {
    #[arg(
        long,
        value_name = "NAME",
        value_parser = named,
        help = listed("The board's firmware:", ". Without it `build` and `check` take the first of them that runs the program, other commands the last")
    )]
    pub part: Option<&'static Build>,
}

/// Names of the parts, each with what it is, between what stands before and behind them in a help.
pub fn listed(before: &str, behind: &str) -> String {
    let mut names: Vec<String> =
        PARTS.iter().map(|part| format!("{} ({})", part.name, part.about)).collect();
    let last = names.pop().unwrap_or_default();
    format!("{before} {} or {last}{behind}", names.join(", "))
}

/// What the build with everything was called while no chip for it was sold.
const BEFORE_F5529: &str = "virtual";

/// The build that `--part` names.
pub fn named(name: &str) -> Result<&'static Build, String> {
    let name = if name == BEFORE_F5529 { F5529.part.name } else { name };
    Build::named(name).ok_or_else(|| {
        let names: Vec<&str> = BUILDS.iter().map(|build| build.part.name).collect();
        format!("the parts are {}", names.join(", "))
    })
}

impl Choice {
    /// The part asked for, or the one of a board that nobody chose.
    pub fn or_default(self) -> &'static Build {
        self.part.unwrap_or(DEFAULT)
    }

    /// The chip that is simulated: the part asked for, or the one that has all of the language. The script becomes what
    /// runs there, as in [`Choice::fit`].
    ///
    /// # Errors
    /// The part asked for lacks something that the program wants; that was written.
    pub fn to_simulate(self, script: &mut Script, console: &Console) -> Result<Part, Failure> {
        let Some(build) = self.part.filter(|build| !build.part.look_ahead) else {
            return Ok(self.or_default().part);
        };
        // What is too large for any board is simulated as it is.
        match lang::back::compile(&script.program) {
            Ok(compiled) => Ok(self.runs_on(script, compiled, console)?.1.part),
            Err(_) => Ok(build.part),
        }
    }

    /// The program as it runs on the part asked for, where arcs that this one lacks are chords; or
    /// as it is, for the smallest part that runs it.
    ///
    /// # Errors
    /// The part asked for lacks something that the program wants; that was written.
    pub fn fit(
        self,
        script: &mut Script,
        compiled: Compiled,
        console: &Console,
    ) -> Result<(Compiled, &'static Build), Failure> {
        if self.part.is_none() {
            tell_room(script, &compiled, console)?;
        }
        self.runs_on(script, compiled, console)
    }

    /// The same without a word of parts that nobody asked for.
    fn runs_on(
        self,
        script: &mut Script,
        mut compiled: Compiled,
        console: &Console,
    ) -> Result<(Compiled, &'static Build), Failure> {
        let signals = Signals::from(&script.program.profile);
        let Some(build) = self.part else {
            let build = smallest(&compiled, signals).unwrap_or(DEFAULT);
            return Ok((with_slow_points(script, compiled, &build.part, console)?, build));
        };
        let part = &build.part;
        let who = format!("`{}` for the {}", part.name, part.chip.name);
        let with_arcs = arcs::are_missing(&compiled, part.features).then(|| compiled.clone());
        let mut fits = true;
        if let Some(with_arcs) = &with_arcs {
            match arcs::without(script, with_arcs, &who, console) {
                Ok(lines) => compiled = lines,
                Err(Failure::Input) => fits = false,
                Err(failure) => return Err(failure),
            }
        }
        let Ok(image) = Image::new(&compiled.image) else { return Ok((compiled, build)) };
        for lack in part.all_lacks(&image, signals) {
            fits = false;
            if lack == Lack::Feature(feature::ARC) {
                // Told with the reason.
                continue;
            }
            let text = format!("{who} lacks what this program wants: {lack}");
            let (line, span) = first_place(&script.program, &compiled, lack);
            // Of a program that is too long with its chords other parts run the one with arcs.
            let other = with_arcs.as_ref().and_then(|compiled| smallest(compiled, signals));
            let remedy = match (lack, other) {
                (Lack::Flash { .. }, Some(other)) => format!(
                    "`--part {}` draws arcs itself; a larger corner_um in the profile makes fewer lines \
                     of them; or {IN_PIECES}",
                    other.part.name
                ),
                _ => remedy(lack),
            };
            let note = Note::in_source(&script.source, span, "B008", text).hint(remedy);
            let note = match line {
                Some(line) => note.at((script.line_of_file(line), 1)),
                None => note.at((1, 1)),
            };
            match script.is_foreign() {
                true => console.note(&note)?,
                false => console.note_in(&note, &script.source)?,
            }
        }
        if !fits {
            return Err(Failure::Input);
        }
        unlimited(script, part, console)?;
        Ok((with_slow_points(script, compiled, part, console)?, build))
    }
}

/// Names the part that has room for a program's variables, where smaller ones have too little: nobody asked for a
/// part, and nothing else tells which one to buy.
fn tell_room(script: &Script, compiled: &Compiled, console: &Console) -> Result<(), Failure> {
    let signals = Signals::from(&script.program.profile);
    let Ok(image) = Image::new(&compiled.image) else { return Ok(()) };
    let of_memory = |part: &Part| {
        part.all_lacks(&image, signals).find(|lack| matches!(lack, Lack::Memory { .. }))
    };
    let Some((small, lack)) = PARTS.iter().find_map(|part| Some((part, of_memory(part)?))) else {
        return Ok(());
    };
    let Some(large) = smallest(compiled, signals).map(|build| build.part) else { return Ok(()) };
    let text = format!(
        "this program runs on `{}` ({}): `{}` has too little room, {lack}",
        large.name, large.chip.name, small.name
    );
    let place = script.program.vars.iter().max_by_key(|var| var.len).map(|var| var.span.clone());
    let note = Note::in_source(&script.source, place.unwrap_or_default(), "B014", text).note();
    console.note_in(&note.hint(remedy(lack)), &script.source)
}

/// The program with slow points where the part takes them; says why there are none of a program whose lines could
/// run through their corners.
///
/// # Errors
/// Standard output is full or gone.
pub fn with_slow_points(
    script: &Script,
    plain: Compiled,
    part: &Part,
    console: &Console,
) -> Result<Compiled, Failure> {
    if let Some(obstacle) = course::obstacle(&script.program, &plain, part) {
        let text = format!(
            "`{}` for the {} rests at the end of each G1: how fast it may go there is computed before the run, \
             and {obstacle}",
            part.name, part.chip.name
        );
        let line = match obstacle {
            Obstacle::Asks(line) | Obstacle::Differs(line) => script.line_of_file(line),
            _ => 1,
        };
        let note = Note::error(script.source.name(), "B013", text).note().at((line, 1));
        console.note(&note.hint("`--part f5529` looks ahead by itself"))?;
    }
    Ok(course::put_into(plain, &script.program, part))
}

/// Says of a part that does not know limits of AT variables which ones it lets pass.
///
/// # Errors
/// Standard output is full or gone.
pub fn unlimited(script: &Script, part: &Part, console: &Console) -> Result<(), Failure> {
    let limited = |var: &&Var| var.panel.limits != Limits::default();
    let Some(var) = script.program.vars.iter().find(limited).filter(|_| !part.at_limits) else {
        return Ok(());
    };
    let text = format!(
        "`{}` for the {} takes any value for MIN and MAX of `{}`: the panel must refuse them",
        part.name, part.chip.name, var.name
    );
    let note = Note::in_source(&script.source, var.span.clone(), "B012", text).note();
    console.note_in(
        &note.hint("`--part f5529` answers a value outside with exception 3"),
        &script.source,
    )
}

/// The smallest part that runs a program as it is, with these signals.
fn smallest(compiled: &Compiled, signals: Signals) -> Option<&'static Build> {
    let image = Image::new(&compiled.image).ok()?;
    BUILDS.into_iter().find(|build| build.part.lacks(&image, signals).is_none())
}

/// What runs a program that no part's flash holds.
const IN_PIECES: &str = "`pasapas stream` runs jobs of any length, piece by piece";

/// Where a program first wants this; without a line where it is all of the program.
fn first_place(program: &Program, compiled: &Compiled, lack: Lack) -> (Option<u32>, Range<usize>) {
    let Lack::Feature(feature) = lack else { return (None, 0..0) };
    let image = Image::new(&compiled.image).ok();
    let extra = image.and_then(|image| image.extra().find(|(_, wanted)| *wanted == feature));
    if let Some((pc, _)) = extra {
        let mark = compiled.sidecar.marks.iter().rfind(|mark| mark.pc <= pc);
        return mark.map_or((None, 0..0), |mark| (Some(mark.line), mark.span.clone()));
    }
    if feature == feature::KEEP {
        let kept = program.vars.iter().find(|var| matches!(var.storage, Storage::Keep(_)));
        return kept.map_or((None, 0..0), |var| (None, var.span.clone()));
    }
    let mut first = None;
    for routine in &program.routines {
        find(&routine.body, feature, &mut first);
    }
    match first {
        Some(stmt) => (Some(stmt.line), stmt.span.clone()),
        None => (None, 0..0),
    }
}

/// The first statement of the source, by its line, that wants a feature.
fn find<'a>(block: &'a [Stmt], feature: u16, first: &mut Option<&'a Stmt>) {
    for stmt in block {
        if wants(&stmt.kind) & feature != 0 && first.is_none_or(|first| stmt.line < first.line) {
            *first = Some(stmt);
        }
        for inner in stmt.kind.blocks() {
            find(inner, feature, first);
        }
    }
}

/// Features that a statement itself wants, as the back end has it.
const fn wants(kind: &StmtKind) -> u16 {
    match kind {
        StmtKind::OnError(Some(_)) => feature::LINES,
        StmtKind::OnInput { .. } | StmtKind::OnEvery { .. } => feature::EVENTS,
        StmtKind::MoveAxe { start: true, .. } | StmtKind::MoveSpeed { .. } => feature::START,
        StmtKind::SetSpindle(_) => feature::POWER,
        StmtKind::Run(_) => feature::LIBRARY,
        StmtKind::Linear { .. } | StmtKind::Cycle(_) => feature::INTERPOLATE,
        StmtKind::Arc { .. } => feature::INTERPOLATE | feature::ARC,
        _ => 0,
    }
}

/// What to do about it: a part that has it, or the command that does without.
fn remedy(lack: Lack) -> String {
    let has = |part: &&Part| match lack {
        Lack::Feature(feature) => !part.lacks_feature(feature),
        Lack::Memory { used, .. } => part.pool.iter().all(|pool| used <= *pool),
        Lack::Rate { wanted, .. } => wanted <= part.top_rate(SHORT_PULSE_US, false),
        Lack::Flash { used, keeps, .. } => used <= part.room_for(keeps),
        Lack::StepLow | Lack::Setup { .. } => part.shapes_steps,
    };
    let without = match lack {
        Lack::Flash { .. } => IN_PIECES,
        Lack::Rate { .. } => "lower top_rate in the profile",
        Lack::Memory { .. } => "fewer variables, calls within calls and ON lines need less",
        Lack::StepLow => "wire the drivers so that STEP is active high",
        Lack::Setup { .. } => "lower start_rate or corner_um in the profile",
        Lack::Feature(feature::POWER) => "without S the laser is on or off by M3 and M5",
        Lack::Feature(_) => "write the program without it",
    };
    match PARTS.iter().find(has) {
        Some(part) => format!("`--part {}` has it; or {without}", part.name),
        None => without.to_owned(),
    }
}
