//! The script of a paste job: readable, and complete without a computer.

use std::fmt::Write;

use lang::profile::Profile;

use super::dots::Dot;
use super::needle::Needle;
use super::pads::Pad;
use crate::terminal::{input, output};
use crate::text::{comment, mm, plain};

/// How far the tip may be from where the file says, mm.
const TIP: f64 = 3.0;

/// Writes the script; the dots' places are the machine's. `from` names the file, for its head.
///
/// # Errors
/// A terminal is none of the machine; in words.
pub fn script(
    dots: &[Dot],
    pads: &[Pad],
    needle: &Needle,
    profile: &Profile,
    from: &str,
) -> Result<String, String> {
    let valve = output(profile, &needle.output)?;
    let suck = needle.suck.as_ref().map(|suck| output(profile, suck)).transpose()?;
    let probe = needle.probe.as_ref().map(|probe| input(profile, probe)).transpose()?;
    let mut lines = vec![
        format!(
            "' {} dots on {} pads, by pasapas paste of {}.",
            dots.len(),
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
        format!("OUTPUT valve = {valve}"),
    ];
    lines.extend(suck.map(|suck| format!("OUTPUT suck = {suck}")));
    lines.extend(probe.map(|probe| format!("INPUT touching = {probe}")));
    lines.extend(needle.touch.map(|touch| format!("CONST TOUCH = {}", mm(touch[2]))));
    let text = |text: &str| text.to_owned();
    lines.push(text("KEEP given, board_x AS LENGTH, board_y AS LENGTH, turn"));
    lines.push(text("DIM boards AT 3000 LABEL \"Boards\""));
    lines.push(text("DIM i, px AS LENGTH, py AS LENGTH, low AS LENGTH"));
    lines.push(text("' dot: X, Y"));
    lines.push(text("TABLE dot(2) = _"));
    for (n, dot) in dots.iter().enumerate() {
        let end = if n + 1 < dots.len() { "; _" } else { "" };
        let name = match pads[dot.pad].name.as_str() {
            "" => format!("line {}", pads[dot.pad].line),
            name => comment(name),
        };
        lines.push(format!("  {}, {}{end} ' {name}", mm(dot.at[0]), mm(dot.at[1])));
    }
    lines.push(text("SetOut valve, OFF"));
    lines.extend(suck.map(|_| text("SetOut suck, OFF")));
    lines.push(text("G0 Z[CLEAR]"));
    lines.push(text("low = BOARD + GAP"));
    if let (Some([x, y, z]), Some(_)) = (needle.touch, probe) {
        let limit = (z - TIP).max(Needle::lowest(profile));
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
    for line in [
        "IF given >= DOTS THEN given = 0",
        "FOR i = given TO DOTS - 1",
        "  px = dot(i, 0) + board_x - (dot(i, 1) / 100um) * turn / 10000 * 1um",
        "  py = dot(i, 1) + board_y + (dot(i, 0) / 100um) * turn / 10000 * 1um",
        "  G0 X[px] Y[py]",
        "  G0 Z[low]",
    ] {
        lines.push(text(line));
    }
    lines.push(format!("  Pulse valve, {}ms", needle.ms));
    for line in [
        "  back",
        "  given = given + 1",
        "  G0 Z[low + LIFT]",
        "NEXT",
        "G0 Z[CLEAR]",
        "boards = boards + 1",
        "G0 X0 Y0",
        "PRINT \"the board is done\"",
        "END",
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
