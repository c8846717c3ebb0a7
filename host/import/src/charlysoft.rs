//! Source text of Charlysoft 30 and PAL-PC, which spell the same words differently. It ends in the
//! instructions of the interface card that those programs would have sent.
//!
//! Words: the charlyrobot binder, chapter 3, the columns "Avec Soft 30".

mod number;
mod port;
mod statement;

use super::Job;
use super::codes::Code;
use super::diag::{Diag, Diags};
use super::isel::emit;
use super::isel::instr::{Axes, Item, Op};
use super::line::column;
use super::script::Made;
use lang::axis::Axis;
use lang::profile::Scale;
use number::{Factor, whole_number};
use std::collections::HashMap;

/// Longest line after macros were put in.
const MAX_LINE: usize = 4096;
/// Statements of one program.
const MAX_ITEMS: usize = 100_000;
/// Loops and jumps among them; a card has memory for about 1500 instructions.
const MAX_JUMPS: usize = 2000;

/// Makes a script of a source text.
pub(crate) fn import(job: &Job<'_>, diags: &mut Diags) -> Made {
    let mut reader = Reader::new(job, diags);
    for (number, line) in job.lines.numbered(reader.diags) {
        reader.read_line(number, line);
        if reader.diags.hopeless() {
            break;
        }
    }
    let (items, scales) = reader.finish();
    if diags.has_errors() {
        return Made::default();
    }
    let source = emit::Source { what: "a Charlysoft 30 or PAL-PC source", scales, remarks: true };
    emit::script(job, &items, &source, diags)
}

/// Why a statement cannot be read.
struct Refused {
    code: Code,
    text: String,
    hint: &'static str,
}

impl Refused {
    fn new(code: Code, text: impl Into<String>, hint: &'static str) -> Refused {
        Refused { code, text: text.into(), hint }
    }
}

type Read<T> = Result<T, Refused>;

/// A jump to a label that stands further on.
struct Open {
    at: usize,
    label: String,
    line: u32,
}

struct Reader<'a, 'd> {
    job: &'a Job<'a>,
    diags: &'d mut Diags,
    axes: Axes,
    /// Motor steps of a turn and um of a turn, by axis.
    steps: [u32; 3],
    elev: [u32; 3],
    /// `#elev` or `#steps` stood in the source.
    scaled: bool,
    /// um of a unit, as a fraction.
    unit: Factor,
    macros: Vec<(String, String)>,
    /// In a `{ }` remark.
    remark: bool,
    /// A `#reference` had neither axes nor speeds: they stand in the next line.
    speeds_follow: bool,
    stored: Vec<Item>,
    direct: Vec<Item>,
    loops: Vec<(usize, u32)>,
    labels: HashMap<String, usize>,
    open: Vec<Open>,
    started: bool,
    stopped: bool,
    line: u32,
    col: u32,
    /// The whole line, for the item's remark.
    text: String,
}

impl<'a, 'd> Reader<'a, 'd> {
    fn new(job: &'a Job<'a>, diags: &'d mut Diags) -> Reader<'a, 'd> {
        let scale = |axis: Axis| {
            let given = job.options.scale.or_else(|| job.profile.axis(axis).map(|part| part.scale));
            given.unwrap_or(Scale { steps: 400, um: 4000 })
        };
        Reader {
            job,
            diags,
            axes: Axes::ALL,
            steps: Axis::ALL.map(|axis| scale(axis).steps.into()),
            elev: Axis::ALL.map(|axis| scale(axis).um.into()),
            scaled: false,
            unit: Factor { num: 1000, den: 1 },
            macros: Vec::new(),
            remark: false,
            speeds_follow: false,
            stored: Vec::new(),
            direct: Vec::new(),
            loops: Vec::new(),
            labels: HashMap::new(),
            open: Vec::new(),
            started: false,
            stopped: false,
            line: 1,
            col: 1,
            text: String::new(),
        }
    }

    fn read_line(&mut self, number: u32, line: &str) {
        self.line = number;
        self.col = 1;
        let code = self.without_remarks(line);
        let trimmed = code.trim();
        if trimmed.is_empty() || trimmed.starts_with('/') {
            return;
        }
        self.col = column(&code, code.trim_start());
        trimmed.clone_into(&mut self.text);
        let speeds = trimmed.starts_with(|c: char| c.is_ascii_digit());
        if core::mem::take(&mut self.speeds_follow) && speeds {
            self.warn(Code::LeftOut, "reference speeds are the profile's `fast_rate`");
            return;
        }
        let read = match trimmed.strip_prefix('#') {
            Some(rest) => self.directive(rest.trim()),
            None => self.expanded(trimmed).and_then(|text| self.statements(&text)),
        };
        if let Err(Refused { code, text, hint }) = read {
            let diag = Diag::new(code, self.line, self.col, text);
            self.diags.push(if hint.is_empty() { diag } else { diag.hint(hint) });
        }
    }

    /// The line without what stands in braces, and without the remark in parentheses that a
    /// printed listing has behind a statement's end.
    fn without_remarks(&mut self, line: &str) -> String {
        let mut out = String::with_capacity(line.len());
        for c in line.chars() {
            match c {
                '{' => self.remark = true,
                '}' if self.remark => self.remark = false,
                _ if !self.remark => out.push(c),
                _ => {}
            }
        }
        for end in [";", "."] {
            let tail = out.rfind(end).map(|at| (at, out[at + 1..].trim_start().starts_with('(')));
            if let Some((at, true)) = tail {
                out.truncate(at + 1);
            }
        }
        out
    }

    fn expanded(&self, text: &str) -> Read<String> {
        let mut text = text.to_owned();
        for (name, value) in &self.macros {
            text = replace_word(&text, name, value);
            if text.len() > MAX_LINE {
                return Err(Refused::new(
                    Code::TooLong,
                    "this line grows too long by its definitions",
                    "",
                ));
            }
        }
        Ok(text)
    }

    fn warn(&mut self, code: Code, text: impl Into<String>) {
        self.diags.once(Diag::new(code, self.line, self.col, text).warning());
    }

    fn note(&mut self, text: impl Into<String>) {
        self.diags.once(Diag::new(Code::Said, self.line, self.col, text).note());
    }

    /// A line that begins with `#`: for the translator, not for the card.
    fn directive(&mut self, rest: &str) -> Read<()> {
        let rest = rest.trim_end_matches(';').trim();
        let lower = rest.to_lowercase();
        let word_end = lower.find(|c: char| !c.is_alphabetic() && c != '_').unwrap_or(lower.len());
        // `#defineR 0(21)` and `#elev4,4,4` stand in the binder without a blank.
        let word = ["redefine", "define"]
            .into_iter()
            .find(|w| lower.starts_with(w))
            .unwrap_or(&lower[..word_end]);
        let values = rest.get(word.len()..).unwrap_or("").trim();
        match word {
            "axis" | "axes" => {
                self.axes = letters(values)?;
                Ok(())
            }
            "elev" => {
                for (axis, um) in self.per_axis(values, 1000, 65_535)? {
                    self.elev[axis.index()] = um;
                }
                self.scaled = true;
                Ok(())
            }
            "steps" => {
                for (axis, steps) in self.per_axis(values, 1, 65_535)? {
                    self.steps[axis.index()] = steps;
                }
                self.scaled = true;
                Ok(())
            }
            "units" => {
                self.unit = number::unit(values)?;
                Ok(())
            }
            "define" | "redefine" => self.define(values),
            "input" => {
                self.stored.clear();
                self.labels.clear();
                self.loops.clear();
                self.open.clear();
                self.started = false;
                self.stopped = false;
                Ok(())
            }
            "start" => self.start(),
            "null" | "zero" => {
                let axes = letters(values)?;
                self.push_direct(Op::Zero(axes))
            }
            "ref_speed" | "limit" => {
                self.warn(Code::LeftOut, format!("`#{word}` is the profile's matter: reference speeds are `fast_rate`, travels `min_um` and `max_um`"));
                Ok(())
            }
            "reference" | "référence" | "ref"
                if values.starts_with(|c: char| c.is_ascii_digit()) =>
            {
                self.warn(Code::LeftOut, "reference speeds are the profile's `fast_rate`");
                Ok(())
            }
            "reference" | "référence" | "ref" if values.is_empty() => {
                self.speeds_follow = true;
                Ok(())
            }
            "reference" | "référence" | "ref" => {
                let axes = letters(values)?;
                self.push_direct(Op::Home(axes))
            }
            _ => Err(Refused::new(
                Code::Unsupported,
                format!("`#{word}` is not known"),
                "known are #axis #elev #steps #units #ref_speed #define #reference #null #input #start",
            )),
        }
    }

    fn per_axis(&self, values: &str, factor: u32, top: u32) -> Read<Vec<(Axis, u32)>> {
        let wrong = || {
            Refused::new(
                Code::WrongCount,
                format!("`{values}` is no value for each axis"),
                "write as many values as `#axis` names",
            )
        };
        let list: Vec<&str> = values.split(',').map(str::trim).collect();
        let axes: Vec<Axis> = self.axes.list().collect();
        if list.len() != axes.len() && list.len() != 1 {
            return Err(wrong());
        }
        let each = axes.into_iter().enumerate().map(|(i, axis)| {
            let text = list.get(i).or(list.first()).ok_or_else(wrong)?;
            let value = whole_number(text, Factor { num: factor, den: 1 }).ok_or_else(wrong)?;
            let value =
                u32::try_from(value).ok().filter(|v| (1..=top).contains(v)).ok_or_else(|| {
                    Refused::new(Code::OutOfRange, format!("`{text}` is out of range"), "")
                })?;
            Ok((axis, value))
        });
        each.collect()
    }

    fn define(&mut self, values: &str) -> Read<()> {
        let end = values.find(char::is_whitespace).unwrap_or(values.len());
        let (name, value) = values.split_at(end);
        if name.is_empty() || value.trim().is_empty() || self.macros.len() >= 1000 {
            return Err(Refused::new(
                Code::Unreadable,
                "a definition without its text",
                "write `#define name text;`",
            ));
        }
        let value = self.expanded(value.trim())?;
        self.macros.retain(|(known, _)| known != name);
        self.macros.push((name.to_owned(), value));
        Ok(())
    }

    fn item(&self, op: Op) -> Item {
        Item { op, line: self.line, col: self.col, text: self.text.clone() }
    }

    fn push(&mut self, op: Op) -> Read<()> {
        if self.stored.len() >= MAX_ITEMS {
            return Err(Refused::new(
                Code::TooLong,
                format!("more than {MAX_ITEMS} statements"),
                "",
            ));
        }
        let item = self.item(op);
        self.stored.push(item);
        Ok(())
    }

    fn push_direct(&mut self, op: Op) -> Read<()> {
        let item = self.item(op);
        self.direct.push(item);
        Ok(())
    }

    /// The stored program runs here.
    fn start(&mut self) -> Read<()> {
        self.close();
        self.started = true;
        let base = self.direct.len();
        if base + self.stored.len() > MAX_ITEMS {
            return Err(Refused::new(
                Code::TooLong,
                format!("more than {MAX_ITEMS} statements"),
                "",
            ));
        }
        self.direct.extend(self.stored.iter().map(|item| {
            let mut item = item.clone();
            item.op.shift(base);
            item
        }));
        Ok(())
    }

    /// What a program's end must have: its loops closed, its labels known.
    fn close(&mut self) {
        for (_, line) in core::mem::take(&mut self.loops) {
            let diag = Diag::new(Code::BadJump, line, 1, "this `repeat` has no `until`");
            self.diags.push(diag.hint("write `until 7;` behind what is repeated"));
        }
        for open in core::mem::take(&mut self.open) {
            match self.labels.get(&open.label) {
                Some(to) => self.stored[open.at].op.aim(open.at, *to),
                None => {
                    let text = format!("the label `{}` does not exist", open.label);
                    self.diags.push(Diag::new(Code::BadJump, open.line, 1, text));
                }
            }
        }
        let len = self.stored.len();
        let jumps = self.stored.iter().filter(|item| item.op.target().is_some());
        if jumps.clone().count() > MAX_JUMPS {
            self.diags.push(Diag::new(
                Code::TooLong,
                self.line,
                1,
                format!("more than {MAX_JUMPS} jumps and loops"),
            ));
        }
        if let Some(item) = jumps.clone().find(|item| item.op.target().is_some_and(|to| to > len)) {
            self.diags.push(Diag::new(
                Code::BadJump,
                item.line,
                item.col,
                "this jump leads behind the program's end",
            ));
        }
    }

    fn finish(mut self) -> (Vec<Item>, [Option<Scale>; 3]) {
        if !self.started && !self.stored.is_empty() {
            if !self.stopped {
                let diag =
                    Diag::new(Code::NoProgram, self.line, 1, "the program does not end in `stop.`");
                self.diags.push(diag.warning().hint("the file may be cut"));
            }
            // The card's Start button runs it.
            let _ = self.start();
        }
        if self.direct.is_empty() && !self.diags.has_errors() {
            self.diags.push(Diag::new(Code::NoProgram, 1, 1, "no statement is executed"));
        }
        if !self.scaled && self.job.options.scale.is_none() {
            self.line = 1;
            self.note(
                "neither `#elev` nor `#steps`: the profile's scale is taken for the source's",
            );
        }
        let scale = |axis: Axis| {
            let steps = u16::try_from(self.steps[axis.index()]).ok()?;
            let um = u16::try_from(self.elev[axis.index()]).ok()?;
            Some(Scale { steps, um })
        };
        let scales = Axis::ALL.map(scale);
        (self.direct, scales)
    }
}

/// Axis letters in any order: `xyz`, `XY`.
fn letters(text: &str) -> Read<Axes> {
    let mut mask = 0;
    for c in text.chars().filter(|c| !c.is_whitespace() && *c != ',') {
        match Axis::from_letter(c) {
            Some(axis) => mask |= 1 << (axis as u8),
            None => {
                return Err(Refused::new(
                    Code::WrongAxis,
                    format!("`{c}` is no axis"),
                    "the axes are X, Y and Z",
                ));
            }
        }
    }
    if mask == 0 {
        return Err(Refused::new(Code::WrongAxis, "no axis is named", "write the axes: `xyz`"));
    }
    Ok(Axes(mask))
}

/// Puts `value` wherever `name` stands as a word; signs, such as `()`, count wherever they stand.
fn replace_word(text: &str, name: &str, value: &str) -> String {
    let wordy = |c: char| c.is_alphanumeric() || c == '_';
    let named = name.chars().all(wordy);
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find(name) {
        let (before, found) = rest.split_at(at);
        let after = &found[name.len()..];
        let apart = !before
            .chars()
            .next_back()
            .or(out.chars().next_back().filter(|_| before.is_empty()))
            .is_some_and(wordy)
            && !after.chars().next().is_some_and(wordy);
        out.push_str(before);
        out.push_str(if named && !apart { name } else { value });
        rest = after;
        if out.len() > MAX_LINE {
            break;
        }
    }
    out.push_str(rest);
    out
}
