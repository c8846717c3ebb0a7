//! From holes, slots and routes to a script.

use std::collections::BTreeMap;

use super::{Cut, Kind, Place, Round, Segment, Step};
use crate::codes::Code;
use crate::diag::{Diag, Diags};
use crate::script::{Made, Script, mm};
use crate::{Job, size};

/// Numbers of a table on one line.
const NUMBERS_A_LINE: usize = 8;

/// What one tool does in a row, of one kind.
struct Run<'a> {
    tool: u32,
    kind: Kind,
    cuts: &'a [Step],
}

/// Cuts that follow one another with one tool and are of one kind.
fn runs(cuts: &[Step]) -> Vec<Run<'_>> {
    let alike = |a: &Step, b: &Step| a.tool == b.tool && a.cut.kind() == b.cut.kind();
    let chunks = cuts.chunk_by(alike);
    chunks.map(|cuts| Run { tool: cuts[0].tool, kind: cuts[0].cut.kind(), cuts }).collect()
}

/// Cuts that are written without a table, to see what it saves.
const MAX_COMPARED: usize = 500;

/// Writes the script: tables and loops for holes and slots, lines for routes; says what that saves.
pub(super) fn script(
    job: &Job<'_>,
    cuts: &[Step],
    sizes: &BTreeMap<u32, String>,
    diags: &mut Diags,
) -> Made {
    let text = "a drill file says nothing of depth and speed: they are the script's CONST lines";
    diags.push(Diag::new(Code::Said, 1, 1, text).note());
    if job.options.plain {
        return write(job, cuts, sizes, false);
    }
    let some = &cuts[..cuts.len().min(MAX_COMPARED)];
    let bytes = |tables: bool| size(job.profile, &write(job, some, sizes, tables).text);
    if let (Some(before), Some(after)) = (bytes(false), bytes(true))
        && after < before
    {
        let of = match some.len() < cuts.len() {
            true => format!(" for the first {MAX_COMPARED}"),
            false => String::new(),
        };
        let saved = before - after;
        let text =
            format!("{after} bytes instead of {before}{of}: {saved} saved by tables and loops");
        diags.push(Diag::new(Code::Said, 1, 1, text).note());
    }
    write(job, cuts, sizes, true)
}

/// The script, with tables or a line for each move.
fn write(job: &Job<'_>, cuts: &[Step], sizes: &BTreeMap<u32, String>, tables: bool) -> Made {
    let runs = runs(cuts);
    let mut script = Script::new(job.name, "a drill file", job.profile);
    if let Some(words) = job.options.turn.words() {
        script.remark(&format!("The file's places are {words}."));
    }
    script.remark("Set the work zero on the board's surface; these say how deep and how fast:");
    // Where Z counts downward, deeper is more.
    let down = -job.profile.z.as_ref().map_or(1, |z| i64::from(z.upward()));
    script.line(&format!("CONST DEPTH = {}, SAFE = {}", mm(2000 * down), mm(-2000 * down)));
    script.line("CONST PLUNGE = 120mm/min");
    if runs.iter().any(|run| run.kind != Kind::Holes) {
        script.line("CONST MILL = 120mm/min");
    }
    if tables && runs.iter().any(|run| run.kind != Kind::Routes) {
        script.line("DIM i");
    }
    for (index, run) in runs.iter().enumerate().filter(|_| tables) {
        table(&mut script, run, &name(&runs, index));
    }
    script.gap();
    script.line(if down < 0 { "G0 Z[SAFE]" } else { "MoveAxe Z, SAFE" });
    for (index, run) in runs.iter().enumerate() {
        let size = sizes.get(&run.tool).map_or(String::new(), |size| format!(", {size}"));
        let count = run.cuts.len();
        let what = match run.kind {
            Kind::Holes => "hole",
            Kind::Slots => "slot",
            Kind::Routes => "route",
        };
        let plural = if count == 1 { "" } else { "s" };
        script.remark(&format!("Tool {}{size}: {count} {what}{plural}", run.tool));
        // The first tool is in the spindle when Start is pressed.
        match index.checked_sub(1).map(|before| runs[before].tool) {
            None => script.line(&format!("T{}", run.tool)),
            Some(before) if before != run.tool => script.line(&format!("M6 T{}", run.tool)),
            Some(_) => {}
        }
        let other = |index: usize| runs.get(index).is_none_or(|other| other.tool != run.tool);
        if index.checked_sub(1).is_none_or(other) {
            script.line("M3");
        }
        match run.kind {
            Kind::Holes | Kind::Slots if !tables => routes(&mut script, run),
            Kind::Routes => routes(&mut script, run),
            kind => rows(&mut script, kind, &name(&runs, index)),
        }
        if other(index + 1) {
            script.line("M5");
        }
    }
    script.finish()
}

/// The table's name; numbered where there are several of its kind.
fn name(runs: &[Run<'_>], index: usize) -> String {
    let kind = runs[index].kind;
    let word = if kind == Kind::Slots { "slots" } else { "holes" };
    match runs.iter().filter(|run| run.kind == kind).count() {
        1 => word.to_owned(),
        _ => format!("{word}_{}", index + 1),
    }
}

fn table(script: &mut Script, run: &Run<'_>, name: &str) {
    let columns = match run.kind {
        Kind::Holes => 2,
        Kind::Slots => 4,
        Kind::Routes => return,
    };
    let cell = |step: &Step| {
        let numbers = match &step.cut {
            Cut::Hole(at) | Cut::Route(at, _) => vec![at],
            Cut::Slot(from, to) => vec![from, to],
        };
        numbers.into_iter().flatten().map(|um| mm(*um)).collect::<Vec<_>>().join(", ")
    };
    let lines: Vec<String> = run
        .cuts
        .chunks(NUMBERS_A_LINE / columns)
        .map(|chunk| chunk.iter().map(cell).collect::<Vec<_>>().join("; "))
        .collect();
    let text = format!("TABLE {name}({columns}) = {}", lines.join("; _\n  "));
    text.lines().for_each(|line| script.line(line));
}

/// The loop over a table.
fn rows(script: &mut Script, kind: Kind, name: &str) {
    script.open(&format!("FOR i = 0 TO COUNT({name}) - 1"));
    let place = |first: usize| format!("X[{name}(i, {first})] Y[{name}(i, {})]", first + 1);
    script.line(&format!("G0 {}", place(0)));
    script.line("G1 Z[DEPTH] F[PLUNGE]");
    if kind == Kind::Slots {
        script.line(&format!("G1 {} F[MILL]", place(2)));
    }
    script.line("G0 Z[SAFE]");
    script.close("NEXT");
}

fn routes(script: &mut Script, run: &Run<'_>) {
    for Step { line, cut, .. } in run.cuts {
        script.set_place(*line);
        let one;
        let (from, list) = match cut {
            Cut::Hole(at) => (at, &[][..]),
            Cut::Slot(from, to) => {
                one = [Segment { to: *to, arc: None }];
                (from, &one[..])
            }
            Cut::Route(from, list) => (from, &list[..]),
        };
        script.line(&format!("G0 {}", words(['X', 'Y'], *from)));
        script.line("G1 Z[DEPTH] F[PLUNGE]");
        let mut feed = " F[MILL]";
        for Segment { to, arc } in list {
            let end = words(['X', 'Y'], *to);
            let line = match arc {
                None => format!("G1 {end}"),
                Some(arc) => {
                    let turn = if arc.clockwise { "G2" } else { "G3" };
                    let round = match arc.round {
                        Round::Radius(um) => format!("R{}", plain(um)),
                        Round::Center(center) => words(['I', 'J'], center),
                    };
                    format!("{turn} {end} {round}")
                }
            };
            script.line(&format!("{line}{}", core::mem::take(&mut feed)));
        }
        script.line("G0 Z[SAFE]");
    }
}

fn words(letters: [char; 2], place: Place) -> String {
    format!("{}{} {}{}", letters[0], plain(place[0]), letters[1], plain(place[1]))
}

/// A length as a G-code word has it, in mm.
fn plain(um: i64) -> String {
    mm(um).trim_end_matches("mm").to_owned()
}
