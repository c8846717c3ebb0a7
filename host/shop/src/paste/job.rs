//! The script of a paste job: readable, and complete without a computer.

use std::fmt::Write;

use lang::profile::{AxisProfile, Profile};

use super::beads::Bead;
use super::dots::Dot;
use super::needle::Needle;
use super::pads::Pad;
use crate::terminal::{input, output};
use crate::text::{comment, mm, plain};

/// How far the tip may be from where the file says, mm.
const TIP: f64 = 3.0;

/// What is given, in its order; places are the machine's, mm.
#[derive(Clone, Copy, Debug)]
pub struct Given<'a> {
    /// Dots, given first.
    pub dots: &'a [Dot],
    /// Beads, given after them.
    pub beads: &'a [Bead],
    /// The pads of both.
    pub pads: &'a [Pad],
}

/// Writes the script. `from` names the file, for its head.
///
/// # Errors
/// A terminal is none of the machine; in words.
pub fn script(
    given: Given<'_>,
    needle: &Needle,
    profile: &Profile,
    from: &str,
) -> Result<String, String> {
    let Given { dots, beads, pads } = given;
    let valve = output(profile, &needle.output)?;
    let suck = needle.suck.as_ref().map(|suck| output(profile, suck)).transpose()?;
    let probe = needle.probe.as_ref().map(|probe| input(profile, probe)).transpose()?;
    // A height above something is added to its Z, or taken from it where Z counts downward.
    let up = if profile.z.as_ref().is_some_and(AxisProfile::counts_down) { '-' } else { '+' };
    let mut lines = vec![
        format!(
            "' {} on {} pads, by pasapas paste of {}.",
            counted(dots.len(), beads.len()),
            pads.len(),
            comment(from)
        ),
        "' It runs alone. Start begins the next board, or goes on after a stop.".to_owned(),
        "' board_x, board_y and turn (um a metre) correct where the board lies; they are kept."
            .to_owned(),
        format!("PROFILE \"{}\"", profile.name),
        format!("CONST CLEAR = {}", mm(needle.clearance)),
        format!("CONST BOARD = {}", mm(needle.board)),
        format!("CONST GAP = {} ' above the board: half the needle's diameter", mm(needle.gap())),
        format!("CONST LIFT = {}", mm(needle.lift)),
        format!("CONST DOTS = {}", dots.len()),
    ];
    if !beads.is_empty() {
        lines.push(format!("CONST BEADS = {}", beads.len()));
    }
    lines.push(format!("OUTPUT valve = {valve}"));
    lines.extend(suck.map(|suck| format!("OUTPUT suck = {suck}")));
    lines.extend(probe.map(|probe| format!("INPUT touching = {probe}")));
    lines.extend(needle.touch.map(|touch| format!("CONST TOUCH = {}", mm(touch[2]))));
    let text = |text: &str| text.to_owned();
    lines.push(text("KEEP given, board_x AS LENGTH, board_y AS LENGTH, turn"));
    lines.push(text("DIM boards AT 3000 LABEL \"Boards\""));
    lines.push(text("DIM i, px AS LENGTH, py AS LENGTH, low AS LENGTH"));
    let name = |pad: usize| match pads[pad].name.as_str() {
        "" => format!("line {}", pads[pad].line),
        name => comment(name),
    };
    let rows = dots.iter().map(|dot| (format!("{}, {}", mm(dot.at[0]), mm(dot.at[1])), dot.pad));
    table(&mut lines, "' dot: X, Y", "TABLE dot(2) = _", rows.map(|(row, pad)| (row, name(pad))));
    let row = |bead: &Bead| {
        let [[ax, ay], [bx, by]] = bead.ends.map(|end| end.map(mm));
        format!("{ax}, {ay}, {bx}, {by}, {}mm/s", plain(round(bead.speed)))
    };
    let rows = beads.iter().map(|bead| (row(bead), name(bead.pad)));
    table(&mut lines, "' bead: from X, Y to X, Y, at a speed", "TABLE bead(5) = _", rows);
    lines.push(text("SetOut valve, OFF"));
    lines.extend(suck.map(|_| text("SetOut suck, OFF")));
    lines.push(text("G0 Z[CLEAR]"));
    lines.push(format!("low = BOARD {up} GAP"));
    if let (Some([x, y, z]), Some(_)) = (needle.touch, probe) {
        let limit = Needle::below(profile, z, TIP);
        lines.push(text("' How long this needle is: low follows its tip."));
        lines.push(format!("G0 X{} Y{}", plain(x), plain(y)));
        lines.push(format!("Probe Z, {}, 2mm/s, touching, ON", mm(limit)));
        lines.push(text("low = low + PROBED(Z) - TOUCH"));
        lines.push(text("G0 Z[CLEAR]"));
    }
    if let Some([x, y]) = needle.purge {
        lines.push(text("' Until paste comes."));
        lines.push(format!("G0 X{} Y{}", plain(x), plain(y)));
        lines.push(text("G0 Z[low]"));
        lines.push(format!("Pulse valve, {}ms", needle.purge_ms));
        lines.push(text("back"));
        lines.push(text("G0 Z[CLEAR]"));
    }
    let all = if beads.is_empty() { "DOTS" } else { "DOTS + BEADS" };
    lines.push(format!("IF given >= {all} THEN given = 0"));
    if !dots.is_empty() {
        lines.push(text("FOR i = given TO DOTS - 1"));
        lines.push(text("  locate dot(i, 0), dot(i, 1)"));
        lines.push(text("  G0 X[px] Y[py]"));
        lines.push(text("  G0 Z[low]"));
        lines.push(format!("  Pulse valve, {}ms", needle.ms));
        lines.push(text("  back"));
        lines.push(text("  given = given + 1"));
        lines.push(format!("  G0 Z[low {up} LIFT]"));
        lines.push(text("NEXT"));
    }
    if let (Some(bead), false) = (&needle.bead, beads.is_empty()) {
        lines.push(text(
            "' The valve closes on the way; a bead that a stop cuts is not given again.",
        ));
        lines.push(text("FOR i = given - DOTS TO BEADS - 1"));
        lines.push(text("  locate bead(i, 0), bead(i, 1)"));
        lines.push(text("  G0 X[px] Y[py]"));
        lines.push(text("  locate bead(i, 2), bead(i, 3)"));
        lines.push(text("  given = given + 1"));
        lines.push(text("  G0 Z[low]"));
        lines.push(text("  SetOut valve, ON"));
        lines.extend((bead.opens_ms > 0).then(|| format!("  Wait {}ms", bead.opens_ms)));
        lines.push(text("  G1 X[px] Y[py] F[bead(i, 4)]"));
        lines.push(match bead.thread {
            0.0 => text("  SYNC SetOut valve, OFF"),
            thread => format!("  SYNC SetOut valve, OFF, {}", mm(thread)),
        });
        lines.push(text("  back"));
        lines.push(format!("  G0 Z[low {up} LIFT]"));
        lines.push(text("NEXT"));
    }
    for line in [
        "G0 Z[CLEAR]",
        "boards = boards + 1",
        "G0 X0 Y0",
        "PRINT \"the board is done\"",
        "END",
        "",
        "' Where a place of the board lies.",
        "SUB locate(x_ AS LENGTH, y_ AS LENGTH)",
        "  px = x_ + board_x - (y_ / 100um) * turn / 10000 * 1um",
        "  py = y_ + board_y + (x_ / 100um) * turn / 10000 * 1um",
        "END SUB",
        "",
        "' Lets the paste come to rest.",
        "SUB back",
    ] {
        lines.push(text(line));
    }
    match suck {
        Some(_) => lines.push(format!("  Pulse suck, {}ms", needle.suck_ms)),
        None => lines.push(format!("  Wait {}ms", needle.suck_ms)),
    }
    lines.push(text("END SUB"));
    let mut out = String::new();
    for line in lines {
        // A String takes all.
        let _ = writeln!(out, "{line}");
    }
    Ok(out)
}

/// A table of rows with their remarks; none without rows.
fn table(
    lines: &mut Vec<String>,
    about: &str,
    head: &str,
    rows: impl ExactSizeIterator<Item = (String, String)>,
) {
    let count = rows.len();
    if count == 0 {
        return;
    }
    lines.extend([about.to_owned(), head.to_owned()]);
    for (n, (row, name)) in rows.enumerate() {
        let end = if n + 1 < count { "; _" } else { "" };
        lines.push(format!("  {row}{end} ' {name}"));
    }
}

/// Thousandths.
fn round(value: f64) -> f64 {
    (value * 1000.0).round() / 1000.0
}

/// How many dots and beads, in words.
pub fn counted(dots: usize, beads: usize) -> String {
    let some =
        |count: usize, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    match (dots, beads) {
        (dots, 0) => some(dots, "dot"),
        (0, beads) => some(beads, "bead"),
        (dots, beads) => format!("{} and {}", some(dots, "dot"), some(beads, "bead")),
    }
}
