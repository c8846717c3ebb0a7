//! Programs of other systems become Pasapas scripts.
//!
//! [`import`] finds out what a file is, reads it with positions, and writes a script that a person
//! would go on editing. What cannot be kept is refused by line with its reason, or kept with a
//! warning where that is harmless; nothing is dropped in silence.

mod cde;
mod charlysoft;
mod codes;
mod detect;
mod diag;
mod excellon;
mod gcode;
mod isel;
mod line;
mod ncp;
pub mod pattern;
pub mod placement;
mod points;
mod script;
mod share;
mod text;
mod turn;

#[cfg(test)]
mod tests;

pub use codes::Code;
pub use detect::{Format, detect, is_importable};
pub use diag::{Diag, Severity};
pub use isel::card;
pub use turn::Turn;

use diag::Diags;
use lang::front::lexer::begins_gcode;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::profile::{Profile, Scale};
use script::Made;
use share::Wanted;
use text::Lines;

/// Largest file that is read: a raster of a million lines has about 20 MB.
pub const MAX_BYTES: usize = 64 << 20;

/// Longest script that is compiled here, to see that the compiler takes it: 15 000 lines or so.
const MAX_TRIED: usize = 256 << 10;

/// Longest script of which versions are compiled to see which is shorter.
const MAX_SIZED: usize = 128 << 10;

/// How a file is to be read.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The format; found by content without it.
    pub from: Option<Format>,
    /// Warnings are errors.
    pub strict: bool,
    /// The machine that the script is for; without it the format's usual one.
    pub profile: Option<Profile>,
    /// Scale of the source's steps, where the source does not tell it.
    pub scale: Option<Scale>,
    /// The S word that stands for full power; without it 100, 255 or 1000, by the largest seen.
    pub s_max: Option<u32>,
    /// Line by line: nothing is made of what repeats, so that each line of the script is one of the
    /// file and comes in its order.
    pub plain: bool,
    /// The frequencies of a JeDiV card; without them the profile's top.
    pub card: Option<CardRates>,
    /// A laser's M3 and M5 follow its S, for a board that knows its output on and off only.
    pub on_off: bool,
    /// Mirror and shift, of drill files and lists of points.
    pub turn: Turn,
}

/// The frequencies that a JeDiV card is set to (JeDiV interface file, section 9.1): they stand in no
/// file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CardRates {
    /// Machining, steps/s of the axis with the longest way.
    pub feed: u32,
    /// Travel, steps/s.
    pub travel: u32,
    /// Z, in the card's steps, from which on up a line travels; without it none does.
    pub threshold: Option<i64>,
}

/// A file that became a script.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The script. It names its profile.
    pub script: String,
    /// For each line of the script the line of the file that it came from, 0 where there is none.
    pub places: Vec<u32>,
    /// What the file was.
    pub format: Format,
    /// Name of the script's profile.
    pub profile: String,
    /// Warnings and notes, in the source's order.
    pub notes: Vec<Diag>,
}

/// Makes a script of a file; `name` is shown in its head only.
///
/// # Errors
/// The diagnostics, errors among them, in the source's order, when the file is no program of a
/// known system, holds what cannot be kept, or, with [`Options::strict`], gives a warning.
pub fn import(name: &str, bytes: &[u8], options: &Options) -> Result<Imported, Vec<Diag>> {
    let mut diags = Diags::new(options.strict);
    let lines = match Lines::decode(bytes, &mut diags) {
        Ok(lines) => lines,
        Err(diag) => return Err(vec![diag]),
    };
    let foreign = detect::foreign(lines.text()).filter(|_| options.from.is_none());
    if let Some(what) = foreign {
        return Err(vec![Diag::new(Code::UnknownFormat, 1, 1, format!("this is {what}"))]);
    }
    if options.from.is_none() && placement::is_placement(name, lines.text()) {
        let text = "this is a placement file: a list of parts, no program";
        let hint = "`pasapas place FILE --feeders F.toml` makes a script of it; with `--from points` import makes a \
            loop over its places";
        return Err(vec![Diag::new(Code::UnknownFormat, 1, 1, text).hint(hint)]);
    }
    let Some(format) = options.from.or_else(|| detect(name, lines.text())) else {
        let text = "this is no program of a system that is known here";
        let hint = format!("name it with `--from`: {}", Format::list());
        return Err(vec![Diag::new(Code::UnknownFormat, 1, 1, text).hint(hint)]);
    };
    if !options.turn.is_none() && !matches!(format, Format::Excellon | Format::Points) {
        let text = format!(
            "a file of {} is neither mirrored nor shifted: only drill files and lists of points are",
            format.name()
        );
        let hint = "set the work zero at the machine (SetPos, G92), or let the CAM tool mirror it";
        return Err(vec![Diag::new(Code::Unsupported, 1, 1, text).hint(hint)]);
    }
    let profile = match &options.profile {
        Some(profile) => profile.clone(),
        None => Profile::built_in(format.usual_profile())
            .map_err(|error| vec![Diag::new(Code::UnknownFormat, 1, 1, error.0)])?,
    };
    let made = match format {
        Format::Laser | Format::Gcode => gcode::expanded(&lines, &mut diags),
        Format::Ncp => Some((ncp::translated(&lines, &mut diags), Vec::new())),
        _ => None,
    };
    let (lines, params) = made.unwrap_or((lines, Vec::new()));
    let job = Job { name, lines: &lines, profile: &profile, options };
    let mut made = match format {
        Format::Isel => isel::import(&job, &mut diags),
        Format::Charlysoft => charlysoft::import(&job, &mut diags),
        Format::Cde => cde::import(&job, &mut diags),
        Format::Laser | Format::Gcode | Format::Ncp => {
            gcode::import(&job, format, &params, &mut diags)
        }
        Format::Points => points::import(&job, &mut diags),
        Format::Excellon => excellon::import(&job, &mut diags),
    };
    if made.text.len() > lang::front::source::MAX_SOURCE_BYTES {
        let text =
            format!("the script would have {} bytes; a script has at most 8 MB", made.text.len());
        diags.push(Diag::new(Code::TooLong, 1, 1, text).hint("cut the file in pieces"));
    }
    // Nobody edits the pixels of a picture.
    if !diags.has_errors()
        && format != Format::Laser
        && !options.plain
        && let Some((shorter, saved)) = shared(&made, &profile)
    {
        let text = format!("{saved} saved by SUBs for what repeats");
        diags.push(Diag::new(Code::Said, 1, 1, text).note());
        made = shorter;
    }
    if !diags.has_errors() {
        let shorter = (made.text.len() > MAX_TRIED).then(|| one_of_each(&made));
        let tried = shorter.as_ref().unwrap_or(&made);
        if tried.text.len() <= MAX_TRIED {
            try_out(tried, &profile, &mut diags);
        }
    }
    let refused = diags.has_errors();
    let notes = diags.into_sorted();
    if refused {
        return Err(notes);
    }
    Ok(Imported { script: made.text, places: made.places, format, profile: profile.name, notes })
}

/// The script with SUBs for what repeats, and what this saves; `None` when it saves nothing or
/// changes what a block means, which the compiler sees. Of a script that is too long to be compiled
/// again and again only lines that mean the same by themselves are shared.
fn shared(made: &Made, profile: &Profile) -> Option<(Made, String)> {
    if made.text.len() > MAX_SIZED {
        let shorter = share::share(made, Wanted::EqualModes)?;
        let saved = made.text.len().checked_sub(shorter.text.len()).filter(|saved| *saved > 0)?;
        return Some((shorter, format!("{saved} characters of the script")));
    }
    // Parameters cost more than they save where the path is short.
    let tries = [Wanted::Equal, Wanted::Shifted].into_iter().filter_map(|wanted| {
        let shorter = share::share(made, wanted)?;
        Some((size(profile, &shorter.text)?, shorter))
    });
    let (after, shorter) = tries.min_by_key(|(size, _)| *size)?;
    let before = size(profile, &made.text)?;
    (after < before).then(|| (shorter, format!("{} bytes", before - after)))
}

/// Bytes of code and tables that a script compiles to.
fn size(profile: &Profile, script: &str) -> Option<usize> {
    let source = Source::new("imported", script.to_owned());
    let (program, _) = compile(&source, ProfileChoice::Given(Box::new(profile.clone())));
    let compiled = lang::back::compile(&program?).ok()?;
    Some(compiled.code_bytes + compiled.table_bytes)
}

/// The script with one line of each form of G-code block: the words with the numbers of G and M, but
/// with no other number. What a machine lacks shows in these as in the whole script, which would take
/// seconds to compile.
///
/// Arcs are left out: whether one can be drawn depends on the line before it.
fn one_of_each(made: &Made) -> Made {
    let mut seen = std::collections::HashSet::new();
    let mut short = Made::default();
    for (line, place) in
        made.text.lines().zip(made.places.iter().copied().chain(std::iter::repeat(0)))
    {
        let code = line.trim_start();
        if begins_gcode(code) {
            let mut form = String::new();
            let mut keeps = false;
            for c in code.chars().take_while(|c| *c != '\'') {
                if c.is_ascii_alphabetic() {
                    keeps = matches!(c, 'G' | 'M');
                }
                if c.is_ascii_alphabetic() || keeps && !c.is_whitespace() {
                    form.push(c);
                }
            }
            if form.contains(['I', 'J', 'K', 'R']) || !seen.insert(form) {
                continue;
            }
        }
        short.text.push_str(line);
        short.text.push('\n');
        short.places.push(place);
    }
    short
}

/// Compiles the script: what the compiler does not take is wrong in the source.
fn try_out(made: &Made, profile: &Profile, diags: &mut Diags) {
    let source = Source::new("imported", made.text.clone());
    let (_, found) = compile(&source, ProfileChoice::Given(Box::new(profile.clone())));
    for diag in found.into_sorted().into_iter().filter(lang::front::diag::Diag::is_error) {
        let line = source.line(diag.span.start) as usize;
        let place = made.places.get(line - 1).copied().unwrap_or(1).max(1);
        let text =
            format!("{} (in the script: `{}`)", diag.message, source.line_text(line as u32).trim());
        let ours = Diag::new(Code::Unsupported, place, 1, text);
        diags.push(match diag.hint {
            Some(hint) => ours.hint(hint),
            None => ours,
        });
    }
}

/// What an importer works on.
struct Job<'a> {
    /// The file's name, for the script's head.
    name: &'a str,
    /// The decoded text.
    lines: &'a Lines,
    /// The script's machine.
    profile: &'a Profile,
    /// As asked for.
    options: &'a Options,
}
