//! Which system a file is from, by its content; the name only settles what content leaves open.

use crate::ncp;

/// A format that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// charlyrobot and isel interface cards: `@0` commands and stored instructions.
    Isel,
    /// Source text of Charlysoft 30 and PAL-PC.
    Charlysoft,
    /// Command files of the JeDiV USB card.
    Cde,
    /// Laser G-code as LaserGRBL writes it.
    Laser,
    /// G-code of CAM tools and controllers.
    Gcode,
    /// Drill files of circuit board tools.
    Excellon,
    /// Programs of isel's controllers, `IMF_PBL`.
    Ncp,
    /// Lists of points: KiCad's positions, CSV, the holes of a Gerber drill file.
    Points,
}

impl Format {
    /// All of them.
    pub const ALL: [Format; 8] = [
        Format::Isel,
        Format::Charlysoft,
        Format::Cde,
        Format::Laser,
        Format::Gcode,
        Format::Excellon,
        Format::Ncp,
        Format::Points,
    ];

    /// The name that `--from` takes.
    pub const fn name(self) -> &'static str {
        match self {
            Format::Isel => "isel",
            Format::Charlysoft => "charlysoft",
            Format::Cde => "cde",
            Format::Laser => "laser",
            Format::Gcode => "gcode",
            Format::Excellon => "excellon",
            Format::Ncp => "ncp",
            Format::Points => "points",
        }
    }

    /// The format of that name, in any case; `charlyrobot`, `pal-pc`, `jediv`, `lasergrbl` and
    /// `drill` are other names, and `pos`, `positions` and `csv` those of lists of points.
    pub fn by_name(name: &str) -> Option<Format> {
        let name = name.to_ascii_lowercase();
        Some(match name.as_str() {
            "charlyrobot" | "memory" => Format::Isel,
            "pal-pc" | "palpc" | "pal" => Format::Charlysoft,
            "jediv" => Format::Cde,
            "lasergrbl" | "gco" => Format::Laser,
            "g-code" | "nc" | "ngc" => Format::Gcode,
            "drill" | "drl" => Format::Excellon,
            "imf" | "imf_pbl" => Format::Ncp,
            "pos" | "positions" | "csv" => Format::Points,
            _ => return Format::ALL.into_iter().find(|format| format.name() == name),
        })
    }

    /// All names, for a hint.
    pub fn list() -> String {
        Format::ALL.map(Format::name).join(", ")
    }

    /// The built-in profile of the machines that such files are for.
    pub const fn usual_profile(self) -> &'static str {
        match self {
            Format::Isel | Format::Charlysoft => "charly",
            Format::Laser => "laser",
            Format::Cde | Format::Gcode | Format::Excellon | Format::Ncp | Format::Points => "mill",
        }
    }
}

/// File name endings of formats that are not scripts.
const ENDINGS: [(&str, Format); 20] = [
    ("cde", Format::Cde),
    ("gco", Format::Laser),
    ("nc", Format::Gcode),
    ("gc", Format::Gcode),
    ("ngc", Format::Gcode),
    ("gcode", Format::Gcode),
    ("tap", Format::Gcode),
    ("cnc", Format::Gcode),
    ("drl", Format::Excellon),
    ("xln", Format::Excellon),
    ("exc", Format::Excellon),
    ("isel", Format::Isel),
    ("nci", Format::Isel),
    ("ncp", Format::Ncp),
    ("pos", Format::Points),
    ("mem", Format::Isel),
    ("pal", Format::Charlysoft),
    ("src", Format::Charlysoft),
    ("ch3", Format::Charlysoft),
    ("c30", Format::Charlysoft),
];

/// Lines that are looked at.
const LOOK: usize = 400;

fn ending(name: &str) -> Option<Format> {
    let (_, ending) = name.rsplit_once('.')?;
    ENDINGS.iter().find(|(known, _)| known.eq_ignore_ascii_case(ending)).map(|(_, format)| *format)
}

/// Whether a file is to be imported rather than read as a script: by its name's ending, else by
/// content that no script has.
pub fn is_importable(name: &str, bytes: &[u8]) -> bool {
    let script = name.rsplit_once('.').is_some_and(|(_, end)| end.eq_ignore_ascii_case("bas"));
    if script {
        return false;
    }
    if ending(name).is_some() {
        return true;
    }
    let head = &bytes[..bytes.len().min(64 << 10)];
    let head = String::from_utf8_lossy(head);
    if lines(&head).any(names_a_laser_tool) {
        return true;
    }
    let plain = [Format::Laser, Format::Gcode];
    by_content(&head).is_some_and(|format| !plain.contains(&format))
}

/// The format of a text.
pub fn detect(name: &str, text: &str) -> Option<Format> {
    match (by_content(text), ending(name)) {
        // Both are G-code; what the name says about the machine counts.
        (Some(Format::Gcode), Some(Format::Laser)) => Some(Format::Laser),
        (Some(format), _) => Some(format),
        (None, by_name) => by_name,
    }
}

/// The lines that are looked at, without those that are empty.
fn lines(text: &str) -> impl Iterator<Item = &str> {
    text.split(['\n', '\r']).map(str::trim).filter(|line| !line.is_empty()).take(LOOK)
}

/// Whether a line is the comment in which a laser's tool names itself. No script has it: comments
/// begin with `'` there.
fn names_a_laser_tool(line: &str) -> bool {
    let named = |comment: &str| {
        let comment = comment.to_ascii_lowercase();
        ["lasergrbl", "lightburn"].iter().any(|tool| comment.contains(tool))
    };
    line.starts_with([';', '(']) && named(line)
}

fn by_content(text: &str) -> Option<Format> {
    let lines = || lines(text);
    if ncp::is_one(lines()) {
        return Some(Format::Ncp);
    }
    if is_positions(text) {
        return Some(Format::Points);
    }
    if lines().any(is_card_line) {
        return Some(Format::Isel);
    }
    if lines().any(|line| line.starts_with("RAZ_CPT;") || line.starts_with("Move;")) {
        return Some(Format::Cde);
    }
    if lines().any(is_drill_line) {
        return Some(Format::Excellon);
    }
    if lines().any(is_charlysoft) {
        return Some(Format::Charlysoft);
    }
    let coded = lines().filter(|line| looks_like_gcode(line)).count();
    if coded == 0 || 2 * coded < lines().filter(|line| !line.starts_with([';', '(', '%'])).count() {
        return None;
    }
    let code = || lines().map(|line| line.split([';', '(']).next().unwrap_or(""));
    let z = code().any(|code| code.contains(['Z', 'z']));
    let moves = code().any(|code| code.contains(['X', 'Y', 'x', 'y']));
    let power = moves && code().any(|code| code.contains('S') && code.contains(['X', 'Y', 'M']));
    let title = lines().any(names_a_laser_tool);
    Some(if title || (power && !z) { Format::Laser } else { Format::Gcode })
}

/// Whether a text is KiCad's list of positions with blanks between the columns.
pub(crate) fn is_columns(text: &str) -> bool {
    let head = |line: &str| line.starts_with("# Ref") && line.contains("PosX");
    text.lines().take(LOOK).any(head)
}

/// Whether a text is KiCad's list of positions, in columns or as CSV.
fn is_positions(text: &str) -> bool {
    let head = |line: &str| line.starts_with("Ref,") && line.contains(",PosX,PosY");
    is_columns(text) || text.lines().take(LOOK).any(head)
}

/// Words that only drill files have, and tools with their sizes, `T1C0.8`.
fn is_drill_line(line: &str) -> bool {
    const WORDS: [&str; 8] =
        ["M48", "METRIC", "INCH", "FMAT,2", ";FILE_FORMAT=", ";FORMAT={", "; FORMAT={", "ICI,"];
    let size = || {
        let (tool, size) = line.strip_prefix('T')?.split_once('C')?;
        let numbers = |text: &str| text.bytes().all(|b| b.is_ascii_digit());
        (!tool.is_empty() && numbers(tool) && size.starts_with(|c: char| ".0123456789".contains(c)))
            .then_some(())
    };
    let listed = line.starts_with(";T") && line.contains(" Holesize ");
    listed || WORDS.iter().any(|word| line.starts_with(word)) || size().is_some()
}

/// What a file of no known system is by its first words, and where its path comes from.
pub(crate) fn foreign(text: &str) -> Option<&'static str> {
    let lines = || lines(text);
    let begins =
        |words: &[&str]| lines().any(|line| words.iter().any(|word| line.starts_with(word)));
    if begins(&["%FS", "%MO", "%ADD"]) {
        return Some(
            "a Gerber file: `pasapas paste FILE --needle N.toml` makes dots of a paste layer, pcb2gcode and FlatCAM \
             make G-code of the others; the holes of a drill file are read with `--from points`",
        );
    }
    if begins(&["<svg", "<?xml", "%PDF"]) {
        return Some("a drawing: a CAM tool makes G-code of it");
    }
    if begins(&["SECTION"]) && begins(&["EOF", "ENTITIES", "HEADER"]) {
        return Some("a DXF drawing: a CAM tool makes G-code of it");
    }
    if lines().take(3).any(|line| line.starts_with("IN;") || line.starts_with("PU")) {
        return Some("a plotter's HPGL: a CAM tool makes G-code of it");
    }
    None
}

/// `@07`, `@0i`, or a print of one of them in a BASIC listing.
fn is_card_line(line: &str) -> bool {
    let quoted =
        ["\"@", "»@", "«@"].iter().find_map(|quoted| Some(line.find(quoted)? + quoted.len() - 1));
    let line = quoted.map_or(line, |at| &line[at..]);
    let mut chars = line.chars();
    chars.next() == Some('@')
        && chars.next().is_some_and(|c| c.is_ascii_digit())
        && chars.next().is_none_or(|c| c.is_ascii_alphanumeric() || " \"»«?".contains(c))
}

fn is_charlysoft(line: &str) -> bool {
    const WORDS: [&str; 10] = [
        "axis",
        "elev",
        "steps",
        "units",
        "ref_speed",
        "reference",
        "define",
        "input",
        "start",
        "redefine",
    ];
    if let Some(rest) = line.strip_prefix('#') {
        let rest = rest.trim_start().to_ascii_lowercase();
        return WORDS.iter().any(|word| rest.starts_with(word));
    }
    let lower = line.to_ascii_lowercase();
    ["moveabs ", "moverel ", "moveto "].iter().any(|word| lower.starts_with(word))
        && line.contains('(')
}

/// Begins with a word of G-code: a letter with its number.
fn looks_like_gcode(line: &str) -> bool {
    let line = line.strip_prefix('/').unwrap_or(line);
    let mut chars = line.chars().filter(|c| *c != ' ');
    matches!(chars.next(), Some(c) if "GMXYZNFSTIJgmxyznfst".contains(c))
        && chars.next().is_some_and(|c| c.is_ascii_digit() || "+-.".contains(c))
}
