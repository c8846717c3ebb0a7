//! Points and patterns for the script: those that it has, and the edits that a page would make.
//!
//! Nothing here changes the text: the page puts it in as one step of undo.

use import::pattern::{self, Pattern, table};
use lang::profile::Profile;
use serde_json::{Value, json};

use super::desk::Desk;
use super::message::TableWish;

/// The tables of places of the script.
pub fn tables(desk: &Desk) -> Value {
    let found = table::find(desk.text());
    let list = found.iter().map(|own| {
        json!({ "name": own.name, "columns": own.columns, "rows": own.rows, "remark": own.remark })
    });
    Value::Array(list.collect())
}

/// Which piece of the script's text becomes which other one so that it has this table: `start` and
/// `end` in UTF-16 units, as pages count, `text`, and the number of the script's text.
///
/// # Errors
/// A name or a place is wrong, or another thing of the script has the name.
pub fn table(desk: &Desk, wish: &TableWish) -> Result<Value, String> {
    let TableWish { name, columns, remark, rows } = wish;
    let made = table::text(name, *columns, remark, rows)?;
    let script = desk.text();
    let known = table::find(script).into_iter().find(|own| own.name.eq_ignore_ascii_case(name));
    let (span, made) = match known {
        Some(own) => (own.span, made),
        None if table::words(script).contains(&name.to_lowercase()) => {
            return Err(format!("the script has another `{name}` already: take another name"));
        }
        None => {
            let at = table::place(script);
            let before =
                if script[..at].is_empty() || script[..at].ends_with('\n') { "" } else { "\n" };
            ([at, at], format!("{before}{made}\n"))
        }
    };
    let units = |at: usize| script[..at].encode_utf16().count();
    Ok(json!({
        "start": units(span[0]), "end": units(span[1]), "text": made, "number": desk.number(),
    }))
}

/// The places of a file.
///
/// # Errors
/// It is none of a known kind, or a line is wrong: the first few of what is.
pub fn points(name: &str, text: &str) -> Result<Value, String> {
    let list = pattern::read(name, text.as_bytes()).map_err(|diags| {
        let errors = diags.iter().filter(|diag| diag.severity == import::Severity::Error);
        let shown: Vec<String> = errors
            .take(3)
            .map(|diag| {
                let hint = diag.hint.as_ref().map_or(String::new(), |hint| format!("; {hint}"));
                format!("line {}: {}{hint}", diag.line, diag.text)
            })
            .collect();
        shown.join(". ")
    })?;
    serde_json::to_value(list).map_err(|error| error.to_string())
}

/// A pattern as a script, or as a piece of one.
///
/// # Errors
/// See [`pattern::write`].
pub fn pattern(wish: &Pattern, profile: &Profile, into: Option<&str>) -> Result<Value, String> {
    let made = pattern::write(wish, profile, into)?;
    serde_json::to_value(made).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use import::pattern::{Act, Down, Pattern, Point, Shape, Work, table::Row};
    use lang::front::ProfileChoice;
    use lang::profile::Profile;

    use super::super::desk::Desk;
    use super::super::message::TableWish;
    use crate::sim::trace::What;
    use crate::sim::world::World;
    use crate::sim::{self, Engine};
    use crate::trial;

    /// Where a script goes down, mm of the machine times 1000.
    fn visited(text: &str) -> Vec<[i64; 2]> {
        let loaded = trial::load(text, ProfileChoice::built_in())
            .unwrap_or_else(|words| panic!("{words}\n{text}"));
        let (outcome, events) = sim::run_traced(
            &loaded.program,
            Engine::Vm,
            &World::unattended(),
            &sim::Options::default(),
        )
        .unwrap_or_else(|error| panic!("{error:?}\n{text}"));
        assert!(outcome.end.fault.is_none(), "{:?}\n{text}", outcome.end);
        let mut places = Vec::new();
        let mut at = [0; 2];
        for event in events {
            match event.what {
                // 10 um are a step of this machine.
                What::Move { to, .. } => {
                    at = [to.x.unwrap_or(0), to.y.unwrap_or(0)].map(|steps| i64::from(steps) * 10);
                }
                What::Wait { .. } => places.push(at),
                _ => {}
            }
        }
        places
    }

    #[test]
    fn scripts_of_patterns_meet_their_points_in_the_simulator() {
        let mill = Profile::built_in("mill").expect("built in");
        let point = |x, y| Point { at: [x, y], ..Point::default() };
        for shape in [
            Shape::Grid { count: [4, 3], pitch: [2540, 10_000], zigzag: false },
            Shape::Grid { count: [4, 3], pitch: [2540, 10_000], zigzag: true },
            Shape::Line { count: 7, way: [50_000, 1000] },
            Shape::Line { count: 1, way: [0, 0] },
            Shape::Circle { count: 5, diameter: 60_000, first_mdeg: 18_000 },
            Shape::Sockets { count: 2, apart: 20_000, pins: 7, pitch: 2540, rows: 7620 },
            Shape::Points(vec![point(1000, 2000), point(-3000, 500)]),
        ] {
            let down = Down { surface: -10_000, depth: 1000, clear: 1000, feed: 5000 };
            let work = Work { down: Some(down), spindle: false, act: Act::Wait { ms: 10 } };
            let (origin, name) = ([50_000, 50_000], "dots".to_owned());
            let pattern = Pattern { shape, origin, frame: None, work, name };
            let made = super::pattern(&pattern, &mill, None).expect("a script");
            let text = made["text"].as_str().expect("a text");
            let met = visited(text);
            let wanted = pattern.shape.points().expect("points");
            assert_eq!(met.len(), wanted.len(), "{text}");
            for (met, wanted) in met.iter().zip(&wanted) {
                let off = [0, 1].map(|i| (met[i] - wanted.at[i] - origin[i]).abs());
                // Half a step, and what the loop's division cuts off.
                assert!(off.iter().all(|um| *um <= 6), "{met:?} {wanted:?}\n{text}");
            }
            assert_eq!(made["count"], wanted.len());
            // The same as a piece of a script.
            let before = "PROFILE \"mill\"\nTABLE dots(2) = 1mm, 2mm\nHome\nG91 G0 X0\n";
            let piece = super::pattern(&pattern, &mill, Some(before)).expect("a piece");
            let piece = piece["text"].as_str().expect("a text");
            assert_eq!(visited(&format!("{before}{piece}")), met, "{piece}");
        }
    }

    #[test]
    fn a_table_is_replaced_or_put_behind_the_declarations() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("a.bas");
        let text = "' \u{1F600}\nTABLE spots(2) = 1mm, 2mm ' a\nHome\n";
        std::fs::write(&file, text).expect("a file");
        let desk = Desk::open(Some(&file.display().to_string()), None, |_| {}).expect("it opens");
        let rows = vec![Row { name: "b".to_owned(), at: vec![3000, 4000] }];
        let wish = |name: &str| TableWish {
            name: name.to_owned(),
            columns: 2,
            remark: String::new(),
            rows: rows.clone(),
        };
        let made = super::table(&desk, &wish("Spots")).expect("a table");
        // The face has two units of UTF-16 and four bytes.
        assert_eq!((made["start"].as_u64(), made["end"].as_u64()), (Some(5), Some(34)));
        assert_eq!(made["text"], "TABLE Spots(2) = 3mm, 4mm ' b");
        let made = super::table(&desk, &wish("pads")).expect("a table");
        assert_eq!((made["start"].as_u64(), made["end"].as_u64()), (Some(35), Some(35)));
        assert_eq!(made["text"], "TABLE pads(2) = 3mm, 4mm ' b\n");
        assert!(super::table(&desk, &wish("Home")).is_err(), "a word of the language");
        let tables = super::tables(&desk);
        assert_eq!(tables[0]["rows"][0]["at"], serde_json::json!([1000, 2000]));
    }
}
