//! The script of a placement: readable, and complete without a computer.

use std::collections::BTreeMap;
use std::fmt::Write;

use lang::profile::{AxisProfile, Profile};

use super::Placed;
use super::feeders::{Feeders, input, output};

/// Brings parts into the order in which they are placed: low ones first, and from each to the nearest.
pub fn order(mut parts: Vec<Placed>, feeders: &Feeders) -> Vec<Placed> {
    let height = |part: &Placed| (feeders.feeders[part.feeder].height * 1000.0).round() as i64;
    parts.sort_by_key(|part| (height(part), part.at));
    let mut out: Vec<Placed> = Vec::with_capacity(parts.len());
    let mut from = [0i64; 2];
    while !parts.is_empty() {
        let low = height(&parts[0]);
        let same = parts.iter().take_while(|part| height(part) == low).count();
        let way = |part: &Placed| {
            let [dx, dy] = [0, 1].map(|i| i128::from(part.at[i] - from[i]));
            dx * dx + dy * dy
        };
        let next = (0..same).min_by_key(|n| way(&parts[*n])).unwrap_or(0);
        let part = parts.remove(next);
        from = part.at;
        out.push(part);
    }
    out
}

fn mm(value: f64) -> String {
    um((value * 1000.0).round() as i64)
}

fn um(value: i64) -> String {
    let sign = if value < 0 { "-" } else { "" };
    let size = value.unsigned_abs();
    let text = format!("{sign}{}.{:03}", size / 1000, size % 1000);
    let text = text.trim_end_matches('0').trim_end_matches('.');
    format!("{text}mm")
}

/// A text for a comment or between quotes.
fn plain(text: &str) -> String {
    let keep = |c: char| if c == '"' || c.is_control() || !c.is_ascii() { '_' } else { c };
    text.chars().map(keep).collect()
}

/// Writes the script. `from` names the files, for its head.
///
/// # Errors
/// A terminal is none of the machine; in words.
pub fn script(
    parts: &[Placed],
    feeders: &Feeders,
    profile: &Profile,
    from: &str,
) -> Result<String, String> {
    // Only feeders that something comes from, and those that stand in for them.
    let mut used: BTreeMap<usize, usize> = BTreeMap::new();
    for part in parts {
        used.entry(part.feeder).or_default();
    }
    let rows: Vec<usize> = used.keys().copied().collect();
    for (row, feeder) in rows.iter().enumerate() {
        used.insert(*feeder, row);
    }
    let vacuum = output(profile, &feeders.vacuum)?;
    let sensor = feeders.sensor.as_ref().map(|sensor| input(profile, sensor)).transpose()?;
    let mut text = String::new();
    // A String takes all.
    let mut line = |words: &str| {
        let _ = writeln!(text, "{words}");
    };
    line(&format!(
        "' {} parts from {} feeders, by pasapas place of {}.",
        parts.len(),
        rows.len(),
        plain(from)
    ));
    line("' It runs alone. Start begins the next board, or goes on after a stop.");
    line("' board_x, board_y and turn (um a metre) correct where the board lies; they are kept.");
    line(&format!("PROFILE \"{}\"", profile.name));
    line(&format!("CONST CLEAR = {}", mm(feeders.clearance)));
    line(&format!("CONST BOARD = {}", mm(feeders.board)));
    line(&format!("CONST PARTS = {}", parts.len()));
    line(&format!("OUTPUT vacuum = {vacuum}"));
    if let Some(sensor) = sensor {
        line(&format!("INPUT held = {sensor}"));
    }
    line("KEEP placed, board_x AS LENGTH, board_y AS LENGTH, turn");
    line("DIM boards AT 3000 LABEL \"Boards\"");
    line(&format!("DIM i, f, n, tries, good AS TRUTH, used({})", rows.len()));
    line("DIM px AS LENGTH, py AS LENGTH");
    line("' feeder: X, Y, step X, step Y, in a row, row step X, row step Y, top, height, count");
    line("TABLE feeder(10) = _");
    for (n, feeder) in rows.iter().enumerate() {
        let own = &feeders.feeders[*feeder];
        let (first, step, columns, row) = own.grid();
        let lengths = |list: &[f64]| list.iter().map(|v| mm(*v)).collect::<Vec<_>>().join(", ");
        let end = if n + 1 < rows.len() { "; _" } else { "" };
        line(&format!(
            "  {}, {}, {columns}, {}, {}, {}, {}{end} ' {}",
            lengths(&first),
            lengths(&step),
            lengths(&row),
            mm(own.top),
            mm(own.height),
            own.places().unwrap_or(0),
            plain(&own.name)
        ));
    }
    line("' part: feeder, X, Y");
    line("TABLE part(3) = _");
    for (n, part) in parts.iter().enumerate() {
        let end = if n + 1 < parts.len() { "; _" } else { "" };
        let feeder = used[&part.feeder];
        let [x, y] = part.at.map(um);
        let (name, what) = (plain(&part.name), plain(&part.what));
        line(&format!("  {feeder}, {x}, {y}{end} ' {name} {what}"));
    }
    line("SetOut vacuum, OFF");
    line("G0 Z[CLEAR]");
    line("IF placed >= PARTS THEN placed = 0");
    line("' What the feeders have given follows from what is placed.");
    line("FOR i = 0 TO placed - 1");
    line("  f = part(i, 0)");
    line("  used(f) = used(f) + 1");
    line("  IF feeder(f, 9) > 0 AND used(f) >= feeder(f, 9) THEN used(f) = 0");
    line("NEXT");
    line("FOR i = placed TO PARTS - 1");
    line("  f = part(i, 0)");
    line("  pick");
    line("  place");
    line("  placed = placed + 1");
    line("NEXT");
    line("boards = boards + 1");
    line("G0 X0 Y0");
    line("PRINT \"the board is done\"");
    line("END");
    line("");
    line("' Takes a part of feeder f, or asks for help.");
    line("SUB pick");
    line("  tries = 0");
    line("  good = FALSE");
    line("  WHILE NOT good");
    line("    IF feeder(f, 9) > 0 AND used(f) >= feeder(f, 9) THEN");
    line("      empty");
    line("      used(f) = 0");
    line("    END IF");
    line("    n = used(f)");
    line(
        "    px = feeder(f, 0) + (n MOD feeder(f, 4)) * feeder(f, 2) + (n / feeder(f, 4)) * feeder(f, 5)",
    );
    line(
        "    py = feeder(f, 1) + (n MOD feeder(f, 4)) * feeder(f, 3) + (n / feeder(f, 4)) * feeder(f, 6)",
    );
    line("    advance");
    line("    G0 X[px] Y[py]");
    line("    G0 Z[feeder(f, 7)]");
    line("    SetOut vacuum, ON");
    if sensor.is_some() {
        line(&format!("    WaitIn? held, ON, {}ms", feeders.pick_ms.max(1)));
        line("    G0 Z[CLEAR]");
        line("    good = IN(held)");
    } else {
        line(&format!("    Wait {}ms", feeders.pick_ms));
        line("    G0 Z[CLEAR]");
        line("    good = TRUE");
    }
    line("    used(f) = used(f) + 1");
    if sensor.is_some() {
        line("    IF NOT good THEN");
        line("      let_go");
        line("      tries = tries + 1");
        line(&format!("      IF tries >= {} THEN", feeders.tries));
        line("        empty");
        line("        tries = 0");
        line("      END IF");
        line("    END IF");
    }
    line("  WEND");
    line("END SUB");
    line("");
    line("SUB place");
    line("  px = part(i, 1)");
    line("  py = part(i, 2)");
    line("  px = px + board_x - (part(i, 2) / 100um) * turn / 10000 * 1um");
    line("  py = py + board_y + (part(i, 1) / 100um) * turn / 10000 * 1um");
    line("  G0 X[px] Y[py]");
    if sensor.is_some() {
        line("  WHILE NOT IN(held)");
        line("    PRINT \"the part was lost on the way\"");
        line("    SetOut vacuum, OFF");
        line("    pick");
        line("    px = part(i, 1) + board_x - (part(i, 2) / 100um) * turn / 10000 * 1um");
        line("    py = part(i, 2) + board_y + (part(i, 1) / 100um) * turn / 10000 * 1um");
        line("    G0 X[px] Y[py]");
        line("  WEND");
    }
    // Where Z counts downward, what is higher is less.
    let up = if profile.z.as_ref().is_some_and(AxisProfile::counts_down) { '-' } else { '+' };
    line(&format!("  G0 Z[BOARD {up} feeder(f, 8)]"));
    line("  SetOut vacuum, OFF");
    line(&format!("  Wait {}ms", feeders.drop_ms));
    line("  G0 Z[CLEAR]");
    line("END SUB");
    line("");
    line("' Lets go of what may hang on the nozzle.");
    line("SUB let_go");
    if let Some([x, y]) = feeders.discard {
        line(&format!("  G0 X{} Y{}", mm(x).trim_end_matches("mm"), mm(y).trim_end_matches("mm")));
    }
    line("  SetOut vacuum, OFF");
    line(&format!("  Wait {}ms", feeders.drop_ms));
    line("END SUB");
    line("");
    line("SUB advance");
    let pulses: Vec<(usize, i32, u32)> = rows
        .iter()
        .enumerate()
        .filter_map(|(n, feeder)| {
            let advance = feeders.feeders[*feeder].advance.as_ref()?;
            let n_output = output(profile, advance.output.as_ref()?).ok()?;
            Some((n, n_output, advance.pulse_ms?))
        })
        .collect();
    for (n, output, ms) in pulses {
        line(&format!("  IF f = {n} THEN Pulse {output}, {ms}ms"));
    }
    line("END SUB");
    line("");
    line("' Waits until the operator has seen to feeder f.");
    line("SUB empty");
    line("  SELECT CASE f");
    for (n, feeder) in rows.iter().enumerate() {
        line(&format!("  CASE {n}"));
        let name = plain(&feeders.feeders[*feeder].name);
        line(&format!("    PRINT \"feeder {name} gives no part: see to it, then Start\""));
    }
    line("  END SELECT");
    line("  WaitStart");
    line("  used(f) = 0");
    line("END SUB");
    Ok(text)
}
