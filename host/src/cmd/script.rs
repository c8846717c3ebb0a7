//! From a file's name to a checked script.

use std::cell::Cell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

use lang::axis::Axis;
use lang::back::{self, Compiled, Excess, Resource};
use lang::front::diag::Diag;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::hir::Program;
use lang::image::{FORMAT, Image, crc_in, crc_of};
use lang::part::F5529;
use lang::profile::AxisProfile;
use lang::record::feature;

use super::console::{Console, Options};
use super::level::levelled;
use crate::failure::Failure;
use crate::input;
use crate::output;
use crate::render::Note;

/// A script that can run.
#[derive(Clone)]
pub struct Script {
    /// Its text.
    pub source: Source,
    /// What the checker made of it.
    pub program: Program,
    /// The file that its PROFILE line named.
    profile_file: Option<PathBuf>,
    /// Of a program of another system: for each line of the text the line of its file, 0 where
    /// there is none.
    places: Vec<u32>,
}

impl Script {
    /// Refuses outputs that would destroy the script at `file`, its machine or one of the `more`
    /// inputs.
    ///
    /// # Errors
    /// See [`output::keep_inputs`].
    pub fn keep_inputs<P: AsRef<Path>>(
        &self,
        file: &str,
        options: &Options,
        more: Option<&str>,
        outputs: &[(&str, Option<P>)],
    ) -> Result<(), Failure> {
        let named = [Some(file), options.profile.as_deref(), more].map(|name| name.map(Path::new));
        let [file, profile, more] = named;
        output::keep_inputs(outputs, &[file, profile, more, self.profile_file.as_deref()])
    }

    /// The line of the file that the text's line came from: the same but for other systems' files.
    pub fn line_of_file(&self, line: u32) -> u32 {
        line_of_file(&self.places, line)
    }

    /// Whether it was made of another system's program, whose text it is not.
    pub fn is_foreign(&self) -> bool {
        !self.places.is_empty()
    }

    /// The first line of the text that came from the file's line or from one behind it.
    pub fn line_of_text(&self, line: u32) -> u32 {
        if self.places.is_empty() {
            return line;
        }
        let found = self.places.iter().position(|place| *place >= line);
        found.map_or(u32::MAX, |index| index as u32 + 1)
    }
}

/// See [`Script::line_of_file`].
fn line_of_file(places: &[u32], line: u32) -> u32 {
    if places.is_empty() {
        return line;
    }
    let before = places.iter().take(line as usize).rev();
    before.copied().find(|place| *place > 0).unwrap_or(1)
}

/// Reads and checks a script, or the program of another system, which becomes one; every
/// diagnostic is written.
///
/// # Errors
/// It cannot be read or has errors.
pub fn load(file: &str, options: &Options, console: &Console) -> Result<Script, Failure> {
    let bytes = input::read_bytes(file, import::MAX_BYTES).map_err(|note| console.refuse(&note))?;
    read(file, &bytes, options, console, false)
}

/// The same with the lines of another system's program in their order: nothing is made of what
/// repeats, so that a line tells where a run stands.
///
/// # Errors
/// See [`load`].
pub fn load_plain(file: &str, options: &Options, console: &Console) -> Result<Script, Failure> {
    let bytes = input::read_bytes(file, import::MAX_BYTES).map_err(|note| console.refuse(&note))?;
    read(file, &bytes, options, console, true)
}

/// The same of a job of G-code, laid onto the surface that a file of heights describes.
///
/// # Errors
/// See [`load`]; or the job cannot be laid onto it.
pub fn load_levelled(
    file: &str,
    heights: &str,
    options: &Options,
    console: &Console,
) -> Result<Script, Failure> {
    let bytes = input::read_bytes(file, import::MAX_BYTES).map_err(|note| console.refuse(&note))?;
    let text = String::from_utf8_lossy(&bytes);
    let (corrected, _) = levelled(heights, file, &text, None, console)?;
    let mut script = read(file, corrected.text.as_bytes(), options, console, true)?;
    // What is told of it are lines of the job.
    let place = |line: &u32| match line.checked_sub(1) {
        Some(n) => corrected.places.get(n as usize).copied().unwrap_or(0),
        None => 0,
    };
    script.places = match script.places.is_empty() {
        true => corrected.places,
        false => script.places.iter().map(place).collect(),
    };
    Ok(script)
}

fn read(
    file: &str,
    bytes: &[u8],
    options: &Options,
    console: &Console,
    plain: bool,
) -> Result<Script, Failure> {
    let given = options.profile(console)?;
    let mut places = Vec::new();
    let mut foreign = None;
    let (source, mut diags) = if import::is_importable(file, bytes) {
        let options =
            import::Options { profile: given.clone(), plain, ..import::Options::default() };
        let imported = super::import::read(file, bytes, &options, console)?;
        places = imported.places;
        foreign = Some(Source::new(file, String::from_utf8_lossy(bytes).into_owned()));
        (Source::new(file, imported.script), Vec::new())
    } else {
        Source::decode(file, bytes)
    };
    let profile_file = Cell::new(None);
    let find = |name: &str| {
        let (profile, path) = input::profile_beside(name, file)?;
        profile_file.set(path);
        Ok(profile)
    };
    let choice = match given {
        Some(profile) => ProfileChoice::Given(Box::new(profile)),
        None => ProfileChoice::Script(&find),
    };
    let mut program = None;
    let mut dropped = 0;
    if !diags.iter().any(|diag| diag.is_error()) {
        let (checked, found) = compile(&source, choice);
        dropped = found.dropped();
        diags.extend(found.into_sorted());
        program = checked;
    }
    for diag in &collapsed(diags) {
        let Some(shown) = &foreign else {
            console.diag(diag, &source)?;
            continue;
        };
        // The file's line, with what it became: the script is nowhere to be looked at.
        let note = Note::of(diag, &source);
        let line = note.place.0;
        let text = format!("{} (in the script: `{}`)", note.text, source.line_text(line).trim());
        let place = (line_of_file(&places, line), 1);
        let start = shown.line_start(place.0) as usize;
        let span = start..start + shown.line_text(place.0).trim_end().len();
        console.note_in(&Note { text, place, labels: Vec::new(), span, ..note }, shown)?;
    }
    if dropped > 0 && !console.json() {
        console.complain(&format!("{file}: {dropped} further diagnostics are not shown"));
    }
    match program {
        Some(program) => {
            let profile_file = profile_file.take();
            Ok(Script { source, program, profile_file, places })
        }
        None => Err(Failure::Input),
    }
}

/// Warnings that say the same of several places become one, at the first of them, with their
/// number: a feed above the axes' top stands in every other line of some files.
fn collapsed(diags: Vec<Diag>) -> Vec<Diag> {
    let mut counts: HashMap<(&str, String), usize> = HashMap::new();
    for diag in diags.iter().filter(|diag| !diag.is_error()) {
        *counts.entry((diag.code.id(), diag.message.clone())).or_default() += 1;
    }
    let mut kept = Vec::with_capacity(diags.len());
    for mut diag in diags {
        if !diag.is_error() {
            match counts.remove(&(diag.code.id(), diag.message.clone())) {
                Some(1) => {}
                Some(count) => {
                    diag.message += &format!(
                        " (and {} more {})",
                        count - 1,
                        if count == 2 { "place" } else { "places" }
                    );
                }
                None => continue,
            }
        }
        kept.push(diag);
    }
    kept
}

/// Compiles a checked script; code of any size.
///
/// # Errors
/// It wants more cells, KEEP values, stack or calls than the device has; that was written.
pub fn compile_any(script: &Script, console: &Console) -> Result<Compiled, Failure> {
    back::compile(&script.program).map_err(|excesses| {
        for excess in excesses {
            if let Err(failure) = console.note_in(&excess_note(&excess, script), &script.source) {
                return failure;
            }
        }
        Failure::Input
    })
}

/// Compiles a checked script that must fit into the device's flash.
///
/// # Errors
/// As [`compile_any`], or the code is too long; that was written.
pub fn compile_for_device(script: &Script, console: &Console) -> Result<Compiled, Failure> {
    let compiled = compile_any(script, console)?;
    must_fit(script, &compiled, console)?;
    must_keep_up(script, &compiled, console)?;
    Ok(compiled)
}

/// Refuses a program whose axes move on their own faster than the chip makes steps of all of them.
fn must_keep_up(script: &Script, compiled: &Compiled, console: &Console) -> Result<(), Failure> {
    let starts = |image: Image<'_>| u16::from(image.header.features) & feature::START != 0;
    if !Image::new(&compiled.image).is_ok_and(starts) {
        return Ok(());
    }
    let profile = &script.program.profile;
    let possible = F5529.top_rate(profile.pulse_us, true);
    let rate = |(axis, own): (Axis, &AxisProfile)| (own.top_rate.unsigned_abs(), axis);
    let Some((rate, axis)) = profile.axes().map(rate).max().filter(|(rate, _)| *rate > possible)
    else {
        return Ok(());
    };
    let text = format!(
        "{}'s top rate is {rate} steps/s; of axes that move on their own the chip makes {possible} \
         steps/s each, with pulses of {} us",
        axis.letter(),
        profile.pulse_us
    );
    let note = Note::error(script.source.name(), "B009", text)
        .hint("lower top_rate in the profile, or move the axes with G0 and G1");
    Err(console.refuse(&note))
}

/// Refuses a program that is longer than the device's flash.
///
/// # Errors
/// It is; that was written.
pub fn must_fit(script: &Script, compiled: &Compiled, console: &Console) -> Result<(), Failure> {
    let room = room_for(compiled.keeps > 0);
    if compiled.image.len() <= room {
        return Ok(());
    }
    let text = format!(
        "the program has {} bytes ({} of code, {} of tables and texts); the device holds {room}{}",
        compiled.image.len(),
        compiled.code_bytes,
        compiled.table_bytes,
        if compiled.keeps > 0 { " beside KEEP values" } else { "" }
    );
    let note = Note::error(script.source.name(), "B006", text)
        .hint("put repeated places into a TABLE, or run it with `pasapas stream`");
    Err(console.refuse(&note))
}

/// Bytes of an image that the device holds, as the language promises them.
pub fn room_for(keeps: bool) -> usize {
    F5529.room_for(keeps)
}

fn excess_note(excess: &Excess, script: &Script) -> Note {
    let Excess { resource, used, available, span } = excess;
    let (code, what, hint) = match resource {
        Resource::Cells => (
            "B001",
            "cells for variables",
            "arrays that never change can be a TABLE; locals of SUBs share cells",
        ),
        Resource::Stack => {
            ("B002", "values open at once in expressions", "put a part into a variable first")
        }
        Resource::Calls => ("B003", "calls open at once", "call fewer SUBs from within SUBs"),
        Resource::Keeps => ("B004", "KEEP values", "put several small values into one"),
        Resource::Rows => ("B005", "rows in a TABLE", "split the TABLE"),
        Resource::Texts => ("B007", "bytes of text in PRINT", "print fewer or shorter texts"),
    };
    let text = format!("the script needs {used} {what}; the device has {available}");
    Note::in_source(&script.source, span.clone(), code, text).hint(hint)
}

/// An image, and what made it if that was a script.
pub struct Code {
    /// The image.
    pub image: Vec<u8>,
    /// The script's compilation.
    pub compiled: Option<Compiled>,
    /// The script.
    pub script: Option<Script>,
}

/// Reads an image, or reads and compiles a script.
///
/// # Errors
/// It cannot be read, the script is wrong, or the image is damaged.
pub fn load_code(file: &str, options: &Options, console: &Console) -> Result<Code, Failure> {
    let bytes = input::read_bytes(file, import::MAX_BYTES).map_err(|note| console.refuse(&note))?;
    // No script begins with this byte: it is a control character.
    if bytes.first() != Some(&FORMAT) {
        let script = load(file, options, console)?;
        let compiled = compile_any(&script, console)?;
        let image = compiled.image.clone();
        return Ok(Code { image, compiled: Some(compiled), script: Some(script) });
    }
    let refuse = |text: String| Err(console.refuse(&Note::error(file, input::code::IMAGE, text)));
    match Image::new(&bytes) {
        Err(flaw) => refuse(format!("the file is no program image of this version: {flaw:?}")),
        Ok(image) => {
            let length = image.header.len;
            let bytes = bytes.get(..length).unwrap_or(&bytes).to_vec();
            if crc_in(&bytes) != crc_of(&bytes) {
                return refuse("the image is damaged: its CRC is wrong".to_owned());
            }
            Ok(Code { image: bytes, compiled: None, script: None })
        }
    }
}
