//! Replaces arcs of a program by chords for a part or a board without arcs.

use std::collections::BTreeMap;

use lang::back::Compiled;
use lang::image::Image;
use lang::part::Part;
use lang::record::feature;

use super::console::Console;
use super::part::with_slow_points;
use super::script::{self, Code, Script};
use crate::chords::{self, Refused};
use crate::failure::Failure;
use crate::render::Note;

/// Whether a program has arcs that firmware with these [`feature`] bits does not draw.
pub fn are_missing(compiled: &Compiled, features: u16) -> bool {
    let wants = Image::new(&compiled.image).map_or(0, |image| u16::from(image.header.features));
    wants & !features & feature::ARC != 0
}

/// The program with chords instead of its arcs, and what they cost, which is told. Afterwards
/// the script is that program, too.
///
/// # Errors
/// Some arc cannot become chords before the run; each was written with the reason.
pub fn without(
    script: &mut Script,
    before: &Compiled,
    who: &str,
    console: &Console,
) -> Result<Compiled, Failure> {
    let (program, cost) = match chords::drawn(&script.program) {
        Ok(drawn) => drawn,
        Err(refused) => return Err(refuse(script, &refused, who, console)),
    };
    script.program = program;
    let compiled = script::compile_any(script, console)?;
    let chords::Cost { arcs, chords, tolerance_um, line } = cost;
    let bytes = compiled.image.len() as i64 - before.image.len() as i64;
    let s = if arcs == 1 { "" } else { "s" };
    let text = format!(
        "{who} draws no arcs: {arcs} arc{s} became {chords} lines, at most {tolerance_um:.0}um off, for \
         {bytes} more bytes",
    );
    let note = Note::error(script.source.name(), "B011", text)
        .note()
        .at((script.line_of_file(line), 1))
        .hint("a larger corner_um in the profile makes fewer; `--part f5529` draws arcs");
    console.note(&note)?;
    Ok(compiled)
}

/// Says of each reason where it stands first, and at how many places more.
fn refuse(script: &Script, refused: &[Refused], who: &str, console: &Console) -> Failure {
    let mut places: BTreeMap<String, (usize, &Refused)> = BTreeMap::new();
    for own in refused {
        places.entry(own.why.to_string()).or_insert((0, own)).0 += 1;
    }
    let mut reasons: Vec<_> = places.into_iter().collect();
    reasons.sort_by_key(|(_, (_, own))| own.line);
    for (why, (count, own)) in reasons {
        let more = match count {
            1 => String::new(),
            2 => " (and 1 more place)".to_owned(),
            _ => format!(" (and {} more places)", count - 1),
        };
        let text = format!(
            "{who} lacks what this program wants: arcs (G2, G3), and this one cannot become lines: \
             {why}{more}"
        );
        let note = Note::in_source(&script.source, own.span.clone(), "B008", text)
            .hint(format!("{}; or `--part f5529` has arcs", own.why.remedy()))
            .at((script.line_of_file(own.line), 1));
        let written = match script.is_foreign() {
            true => console.note(&note),
            false => console.note_in(&note, &script.source),
        };
        if let Err(failure) = written {
            return failure;
        }
    }
    Failure::Input
}

impl Code {
    /// The same for a board's part: with chords where that lacks arcs, and with slow points where it takes them; `None`
    /// where it runs as it is. An image stays what it is.
    ///
    /// # Errors
    /// As [`without`].
    pub fn for_board(&self, part: &Part, console: &Console) -> Result<Option<Code>, Failure> {
        let (Some(script), Some(before)) = (&self.script, &self.compiled) else {
            return Ok(None);
        };
        let mut script = script.clone();
        let mut compiled = before.clone();
        if are_missing(before, part.features) {
            compiled = without(&mut script, before, "this board", console)?;
        }
        let compiled = with_slow_points(&script, compiled, part, console)?;
        if compiled.image == before.image {
            return Ok(None);
        }
        let image = compiled.image.clone();
        Ok(Some(Code { image, compiled: Some(compiled), script: Some(script) }))
    }
}
