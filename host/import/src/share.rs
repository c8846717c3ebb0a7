//! Statements that stand in several places become one SUB: word for word, or the same path begun
//! elsewhere, which the SUB then takes as parameters.

mod alike;
mod modes;

use core::hash::{Hash, Hasher};
use std::collections::BTreeMap;
use std::collections::hash_map::DefaultHasher;

use super::script::{Made, mm};
use alike::Alike;
use lang::front::literal::Decimal;
use modes::Modes;

/// Lines from which on a repeated group is worth a SUB.
const MIN_LINES: usize = 4;
/// SUBs of one script.
const MAX_SUBS: usize = 12;
/// First words of lines that cannot move into a SUB: declarations, jumps, ends.
const FIXED: [&str; 20] = [
    "DIM", "CONST", "TABLE", "PROFILE", "SUB", "FUNCTION", "ON", "GOTO", "GOSUB", "RETURN",
    "RESUME", "EXIT", "CONTINUE", "END", "M2", "M30", "KEEP", "INPUT", "OUTPUT", "CALL",
];
/// First words that open a block, and those that close one.
const OPENS: [&str; 5] = ["FOR", "WHILE", "DO", "REPEAT", "SELECT"];
const CLOSES: [&str; 4] = ["NEXT", "WEND", "LOOP", "END"];
/// Words after which a coordinate is no place in work coordinates and mm.
const FOREIGN: [&str; 5] = ["G91", "G92", "G28", "G53", "G20"];

/// A line as it is compared.
struct Line<'a> {
    /// Without its indentation.
    text: &'a str,
    indent: usize,
    /// The whole text.
    exact: u64,
    /// The text without the numbers of X and Y.
    shape: u64,
    /// The text with X and Y counted from where they were before; 0 when that is not known.
    moved: u64,
    /// X and Y as they stand in the line, um.
    place: [Option<i64>; 2],
    /// It may stand in a SUB.
    usable: bool,
    /// Blocks that it opens, less those that it closes.
    opens: i32,
    /// The G-code modes before it.
    modes: u64,
}

/// What may be looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wanted {
    /// Lines that are equal.
    Equal,
    /// The same, where the same modes hold before them: no block's meaning can change.
    EqualModes,
    /// Also paths that begin elsewhere.
    Shifted,
}

/// Places that one SUB serves.
struct Group {
    starts: Vec<usize>,
    len: usize,
    /// The path begins elsewhere: X and Y of each start less those of the first, um.
    offsets: Option<Vec<[i64; 2]>>,
}

/// Makes SUBs of what repeats in a script; `None` when nothing repeats.
pub(crate) fn share(made: &Made, wanted: Wanted) -> Option<Made> {
    let lines = read(&made.text, wanted == Wanted::Shifted);
    let mut used = vec![false; lines.len()];
    let mut groups = Vec::new();
    let absolute = wanted == Wanted::Shifted
        && !lines.iter().any(|line| {
            let foreign = |word| FOREIGN.contains(&word);
            line.text.contains('[') || line.text.split_whitespace().any(foreign)
        });
    for shifted in [false, true] {
        if shifted && !absolute {
            break;
        }
        let alike = Alike::new(&lines, &used, shifted, wanted == Wanted::EqualModes);
        while groups.len() < MAX_SUBS {
            let Some(group) = alike.find(&lines, &used) else { break };
            for start in &group.starts {
                used[*start..start + group.len].fill(true);
            }
            groups.push(group);
        }
    }
    (!groups.is_empty()).then(|| write(made, &lines, &groups))
}

fn hash(value: impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    // 0 stands for what matches nothing.
    hasher.finish().max(1)
}

/// The lines, with their shapes only where those are looked at.
fn read(text: &str, shapes: bool) -> Vec<Line<'_>> {
    let mut at = [None; 2];
    let mut continued = false;
    let mut modes = Modes::default();
    text.lines()
        .map(|whole| {
            let text = whole.trim_start();
            let first = text.split([' ', ':']).next().unwrap_or("");
            let label = text.split(' ').next().is_some_and(|word| word.ends_with(':'));
            let goes_on = text.ends_with(" _");
            let fixed = FIXED.contains(&first) && !CLOSES.contains(&first) || text == "END";
            let usable = !continued && !goes_on && !label && !fixed && !text.is_empty();
            continued = goes_on;
            let before = hash(&modes);
            modes.follow(text, label);
            let opens = i32::from(OPENS.contains(&first) || opens_if(text))
                - i32::from(CLOSES.contains(&first));
            let (shape, place) = if shapes { apart(text) } else { Default::default() };
            let mut moved = hash(&shape);
            for (i, place) in place.iter().enumerate() {
                let Some(place) = place else { continue };
                let before = at[i].replace(*place);
                moved = match before {
                    Some(before) if moved != 0 => hash((moved, i, place - before)),
                    _ => 0,
                };
            }
            Line {
                text,
                indent: whole.len() - text.len(),
                exact: hash(text),
                shape: hash(&shape),
                moved,
                place,
                usable,
                opens,
                modes: before,
            }
        })
        .collect()
}

/// Whether an IF has its statements on lines of their own.
fn opens_if(text: &str) -> bool {
    let code = text.split(" '").next().unwrap_or(text).trim_end();
    code.starts_with("IF ") && code.ends_with(" THEN")
}

/// A line without the numbers behind X and Y, and these in um.
fn apart(text: &str) -> (String, [Option<i64>; 2]) {
    let mut shape = String::with_capacity(text.len());
    let mut places = [None; 2];
    let block = text.starts_with(['G', 'X', 'Y', 'F', 'S']);
    let (code, remark) = text.split_once(" '").unwrap_or((text, ""));
    for word in code.split_inclusive(' ') {
        let trimmed = word.trim_end();
        let index = match trimmed.chars().next() {
            Some('X') => 0,
            Some('Y') => 1,
            _ => {
                shape.push_str(word);
                continue;
            }
        };
        let number = Decimal::parse(&trimmed[1..]).and_then(|value| value.scaled(1000, 1));
        match number.filter(|_| block && places[index].is_none()) {
            Some((um, _)) => {
                places[index] = Some(um);
                shape.push_str(&trimmed[..1]);
                shape.push_str("# ");
            }
            None => shape.push_str(word),
        }
    }
    shape.push_str(remark);
    (shape, places)
}

fn write(made: &Made, lines: &[Line<'_>], groups: &[Group]) -> Made {
    let word = if made.text.contains("part_") { "shared_" } else { "part_" };
    let mut out = Made::default();
    let mut put = |indent: usize, text: &str, place: u32| {
        out.text.push_str(&" ".repeat(indent));
        out.text.push_str(text);
        out.text.push('\n');
        out.places.push(place);
    };
    let place = |i: usize| made.places.get(i).copied().unwrap_or(0);
    let calls = groups.iter().enumerate().flat_map(|(n, group)| {
        group.starts.iter().enumerate().map(move |(turn, start)| (*start, (n, group, turn)))
    });
    let calls: BTreeMap<usize, _> = calls.collect();
    let mut at = 0;
    while at < lines.len() {
        let Some(&(n, group, turn)) = calls.get(&at) else {
            put(lines[at].indent, lines[at].text, place(at));
            at += 1;
            continue;
        };
        let axes = shifting(group);
        let offset = group.offsets.as_ref().map_or([0; 2], |offsets| offsets[turn]);
        let list: Vec<String> =
            (0..2).filter(|axis| axes[*axis]).map(|axis| mm(offset[axis])).collect();
        let text = format!("{word}{} {}", n + 1, list.join(", "));
        put(lines[at].indent, text.trim_end(), place(at));
        at += group.len;
    }
    for (n, group) in groups.iter().enumerate() {
        let from = group.starts[0];
        let axes = shifting(group);
        let list: Vec<&str> = (0..2)
            .filter(|axis| axes[*axis])
            .map(|axis| ["dx AS LENGTH", "dy AS LENGTH"][axis])
            .collect();
        let source = place(from);
        put(0, "", 0);
        let others: Vec<String> =
            group.starts[1..].iter().take(8).map(|start| place(*start).to_string()).collect();
        let more = if group.starts.len() > 9 { " and more" } else { "" };
        put(0, &format!("' Lines {source}, {}{more} of the source.", others.join(", ")), source);
        let parameters =
            if list.is_empty() { String::new() } else { format!("({})", list.join(", ")) };
        put(0, &format!("SUB {word}{}{parameters}", n + 1), source);
        for (i, line) in lines[from..from + group.len].iter().enumerate() {
            let indent = 2 + line.indent - lines[from].indent;
            put(indent, &shifted(line, axes), place(from + i));
        }
        put(0, "END SUB", source);
    }
    out
}

/// The axes in which the places of a group differ.
fn shifting(group: &Group) -> [bool; 2] {
    let differs = |axis: usize| {
        group.offsets.as_ref().is_some_and(|list| list.iter().any(|offset| offset[axis] != 0))
    };
    [differs(0), differs(1)]
}

/// A line with `dx` and `dy` in its X and Y words.
fn shifted(line: &Line<'_>, axes: [bool; 2]) -> String {
    if axes == [false; 2] {
        return line.text.to_owned();
    }
    let (code, remark) = line.text.split_once(" '").unwrap_or((line.text, ""));
    let mut places = line.place;
    let words = code.split(' ').map(|word| {
        let axis = match word.chars().next() {
            Some('X') => 0,
            Some('Y') => 1,
            _ => return word.to_owned(),
        };
        match places[axis].take().filter(|_| axes[axis]) {
            Some(um) if um < 0 => {
                format!("{}[d{} - {}]", ["X", "Y"][axis], ["x", "y"][axis], mm(-um))
            }
            Some(um) => format!("{}[d{} + {}]", ["X", "Y"][axis], ["x", "y"][axis], mm(um)),
            None => word.to_owned(),
        }
    });
    let code = words.collect::<Vec<_>>().join(" ");
    if remark.is_empty() { code } else { format!("{code} '{remark}") }
}

#[cfg(test)]
mod tests {
    use super::{Wanted, share};
    use crate::script::Made;

    fn shared(text: &str) -> Option<String> {
        let places = (1..=text.lines().count() as u32).collect();
        share(&Made { text: text.to_owned(), places }, Wanted::Shifted).map(|made| {
            assert_eq!(made.text.lines().count(), made.places.len());
            made.text
        })
    }

    #[test]
    fn equal_lines_become_one_sub() {
        let group = "G1 X1 Y1\nG1 X2\nFOR i = 1 TO 2\n  Wait 1s\nNEXT\nG1 Y3\n";
        let text = format!("F60\n{group}M3\n{group}M5\n");
        let expected = format!(
            "F60\npart_1\nM3\npart_1\nM5\n\n' Lines 2, 9 of the source.\nSUB part_1\n  {}\nEND SUB\n",
            group.trim_end().replace('\n', "\n  ")
        );
        assert_eq!(shared(&text), Some(expected));
        assert_eq!(shared("G1 X1\nG1 X2\nG1 X3\nM3\nG1 X1\nG1 X2\nG1 X3\n"), None, "too short");
        let torn = "Wait 1s\nFOR i = 1 TO 2\nWait 2s\nWait 3s\nNEXT\nWait 1s\nFOR i = 1 TO 2\nWait 2s\nWait 3s\nWait 4s\nNEXT\n";
        assert_eq!(shared(torn), None, "a block is never cut");
        assert_eq!(shared("a:\nGOTO a\nM3\nM5\na:\nGOTO a\nM3\nM5\n"), None, "jumps stay");
    }

    /// The second group is reached in G0, where its lines without a G word would be rapid moves.
    #[test]
    fn only_the_same_modes_are_shared_unseen() {
        let group = "X1 Y1\nX2\nY3\nX0 Y0\n";
        let text = format!("F60\nG1 X0\n{group}G0 Z1\n{group}G1 Z0\n{group}M5\n");
        let places = (1..=text.lines().count() as u32).collect();
        let made = share(&Made { text, places }, Wanted::EqualModes).expect("a SUB");
        let wanted =
            format!("F60\nG1 X0\npart_1\nG0 Z1\n{group}G1 Z0\npart_1\nM5\n\n' Lines 3, 13");
        assert!(made.text.starts_with(&wanted), "{}", made.text);
    }

    #[test]
    fn the_same_path_elsewhere_takes_parameters() {
        let text = "G0 X0 Y0\nG0 X1 Y1\nG1 Z-1\nG1 X3\nG1 Y2.5\nG0 Z1\n\
                    G0 X11 Y1\nG1 Z-1\nG1 X13\nG1 Y2.5\nG0 Z1\n";
        let made = shared(text).expect("a SUB");
        assert!(made.starts_with("G0 X0 Y0\npart_1 0mm\npart_1 10mm\n"), "{made}");
        assert!(made.contains("SUB part_1(dx AS LENGTH)\n  G0 X[dx + 1mm] Y1\n"), "{made}");
        assert!(made.contains("\n  G1 X[dx + 3mm]\n  G1 Y2.5\n"), "{made}");
        assert_eq!(shared(&format!("G91\n{text}")), None, "relative words move by themselves");
    }
}
