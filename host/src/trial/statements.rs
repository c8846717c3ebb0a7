//! Statements with an example each, for people who choose one from a list.

use lang::front::words::Kw;
use serde_json::{Value, json};

/// Group, statement, what it does where no word of the language says it, the declaration that the example
/// wants, the example.
type Row = (&'static str, Option<Kw>, &'static str, &'static str, &'static str);

const ROWS: [Row; 33] = [
    ("Moves", Some(Kw::Home), "", "", "Home"),
    ("Moves", Some(Kw::MoveAxe), "", "", "MoveAxe X, 20mm, 25mm/s"),
    ("Moves", Some(Kw::MoveRel), "", "", "MoveRel Z, -3mm, 5mm/s"),
    ("Moves", None, "G0: moves all named axes to a place, as fast as they can.", "", "G0 X20 Y10"),
    ("Moves", None, "G1: a straight line at a feed in mm a minute.", "", "G1 X40 Y10 F600"),
    (
        "Moves",
        None,
        "G2: an arc to the right; I and J lead to its middle.",
        "",
        "G2 X50 Y20 I0 J10 F600",
    ),
    ("Moves", Some(Kw::Start), "", "", "START MoveAxe X, 40mm\nMoveAxe Y, 20mm\nWaitMove"),
    ("Moves", Some(Kw::Probe), "", "", "Probe Z, -10mm, 2mm/s"),
    ("Moves", Some(Kw::SetPos), "", "", "SetPos Z, 0mm"),
    ("Inputs and outputs", Some(Kw::SetOut), "", "", "SetOut 1, ON"),
    ("Inputs and outputs", Some(Kw::Pulse), "", "", "Pulse 1, 200ms"),
    ("Inputs and outputs", Some(Kw::WaitIn), "", "", "WaitIn 3, ON, 5s"),
    ("Inputs and outputs", Some(Kw::WaitStart), "", "", "WaitStart"),
    ("Inputs and outputs", Some(Kw::Input), "", "", "INPUT part = 3"),
    ("Inputs and outputs", Some(Kw::Output), "", "", "OUTPUT valve = 3"),
    ("Time and text", Some(Kw::Wait), "", "", "Wait 500ms"),
    ("Time and text", Some(Kw::Print), "", "DIM i", "PRINT \"piece \"; i"),
    ("Values", Some(Kw::Const), "", "", "CONST PITCH = 2.54mm"),
    ("Values", Some(Kw::Dim), "", "", "DIM count"),
    ("Values", Some(Kw::Keep), "", "", "KEEP made"),
    ("Values", Some(Kw::Table), "", "", "TABLE places(2) = 10mm, 10mm; 30mm, 10mm"),
    ("Flow", Some(Kw::If), "", "", "IF IN(3) THEN\n  SetOut 1, ON\nELSE\n  SetOut 1, OFF\nEND IF"),
    ("Flow", Some(Kw::For), "", "DIM i", "FOR i = 1 TO 5\n  MoveRel X, 2mm\nNEXT"),
    ("Flow", Some(Kw::Repeat), "", "", "REPEAT 5\n  MoveRel X, 2mm\nEND REPEAT"),
    ("Flow", Some(Kw::While), "", "", "WHILE IN(3)\n  Wait 10ms\nWEND"),
    ("Flow", Some(Kw::Do), "", "", "DO\n  WaitStart\n  Pulse 1, 200ms\nLOOP"),
    (
        "Flow",
        Some(Kw::Select),
        "",
        "DIM i",
        "SELECT CASE i\nCASE 1\n  SetOut 1, ON\nCASE ELSE\n  SetOut 1, OFF\nEND SELECT",
    ),
    (
        "Flow",
        Some(Kw::Exit),
        "",
        "",
        "REPEAT 100\n  IF IN(3) THEN EXIT REPEAT\n  MoveRel X, 1mm\nEND REPEAT",
    ),
    ("Flow", Some(Kw::End), "", "", "END"),
    (
        "Parts of a script",
        Some(Kw::Sub),
        "",
        "",
        "SUB drill(depth AS LENGTH)\n  MoveRel Z, 0mm - depth, 2mm/s\n  MoveRel Z, depth\nEND SUB",
    ),
    (
        "Parts of a script",
        Some(Kw::Function),
        "",
        "",
        "FUNCTION half(n)\n  RETURN n / 2\nEND FUNCTION",
    ),
    (
        "Parts of a script",
        Some(Kw::On),
        "",
        "",
        "ON IN 4 RISE GOSUB jam\nSUB jam\n  PRINT \"jam\"\nEND SUB",
    ),
    ("Parts of a script", Some(Kw::Profile), "", "", "PROFILE \"mill\""),
];

/// All of them, as a page lists them.
pub fn listed() -> Vec<Value> {
    let rows = ROWS.iter().map(|(group, word, about, wants, example)| {
        let (name, about) = word.map_or_else(
            || about.split_once(": ").unwrap_or(("", about)),
            |word| (word.entry().text, word.entry().about),
        );
        json!({ "group": group, "name": name, "about": about, "wants": wants, "example": example })
    });
    rows.collect()
}

#[cfg(test)]
mod tests {
    use super::ROWS;
    use lang::front::ProfileChoice;

    #[test]
    fn every_example_compiles_by_itself() {
        for (.., wants, example) in ROWS {
            let text = format!("{wants}\n{example}\n");
            let text = text.trim_start();
            let found = crate::trial::load(text, ProfileChoice::built_in());
            assert!(found.is_ok(), "{text}: {:?}", found.err());
        }
    }

    #[test]
    fn every_one_says_what_it_does() {
        for row in super::listed() {
            assert!(["name", "about"].iter().all(|own| row[own] != ""), "{row}");
        }
    }
}
