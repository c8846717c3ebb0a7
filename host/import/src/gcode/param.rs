//! Parameters and expressions of G-code files: `#1 = 5`, `#<safe> = 2`, `X[#1 / 2]`.
//!
//! A file without O-words runs from its first line to its last, so what a parameter holds in a line
//! is known: its value is written there. Files with O-words are refused by line elsewhere. Which words
//! are a parameter and nothing else is kept, for [`super::named`].

use std::collections::HashMap;

use super::named::Param;
use crate::codes::Code;
use crate::diag::{Diag, Diags};
use crate::text::Lines;

/// Brackets within one another.
const MAX_DEPTH: usize = 20;
/// Parameters of a file.
const MAX_PARAMETERS: usize = 1000;

/// The text with values in place of parameters and expressions, and what it says of its parameters;
/// nothing where it has none.
pub(crate) fn expanded(lines: &Lines, diags: &mut Diags) -> Option<(Lines, Vec<Param>)> {
    if !lines.text().contains(['#', '[']) {
        return None;
    }
    let mut known = Known::default();
    let mut out = String::with_capacity(lines.text().len());
    let mut at = 1;
    for (number, line) in lines.numbered(diags) {
        while at < number {
            out.push('\n');
            at += 1;
        }
        match replaced(number, line, &mut known) {
            Ok(line) => out.push_str(&line),
            // What cannot be read is told where the line's words are.
            Err(Wrong::Unreadable) => out.push_str(line),
            Err(Wrong::Value(text)) => {
                let diag = Diag::new(Code::Unreadable, number, 1, text);
                diags.push(diag.hint("let the CAM tool write numbers"));
            }
        }
    }
    let text = "parameters `#` and expressions in brackets: their values are written, but for plain \
                numbers, which keep a name";
    diags.push(Diag::new(Code::Changed, 1, 1, text).note());
    Some((Lines::of(out), known.params))
}

/// Why a line stays as it is.
enum Wrong {
    /// It has what is no number, `+ - * /` or bracket.
    Unreadable,
    /// There is no value, for this reason.
    Value(String),
}

/// The parameters, in the order in which they are set.
#[derive(Default)]
struct Known {
    /// What each holds, and its place in the list.
    values: HashMap<String, (f64, usize)>,
    params: Vec<Param>,
}

impl Known {
    /// A line sets a parameter.
    fn set(&mut self, key: String, value: f64, set: (u32, Option<String>)) {
        let next = self.params.len();
        let (held, index) = self.values.entry(key.clone()).or_insert((value, next));
        *held = value;
        if *index == next {
            self.params.push(Param { key, ..Param::default() });
        }
        self.params[*index].sets.push(set);
    }

    fn param(&mut self, key: &str) -> Option<&mut Param> {
        self.params.get_mut(self.values.get(key)?.1)
    }
}

/// A line with its values; what it assigns holds from the next one on (RS274/NGC 3.3.2.1).
fn replaced(line_number: u32, line: &str, known: &mut Known) -> Result<String, Wrong> {
    let mut out = String::with_capacity(line.len());
    let mut set = Vec::new();
    let (mut plain, mut mixed) = (Vec::new(), Vec::new());
    let mut i = Cursor { rest: line, known, read: Vec::new() };
    while let Some(c) = i.rest.chars().next() {
        match c {
            ';' => {
                out.push_str(i.rest);
                break;
            }
            '(' => {
                let end = i.rest.find(')').map_or(i.rest.len(), |at| at + 1);
                out.push_str(i.take(end));
            }
            '#' => {
                let whole = i.rest;
                let name = i.name()?;
                if !i.sign('=') {
                    return Err(Wrong::Unreadable);
                }
                let before = i.rest;
                let value = i.sum(0)?;
                mixed.append(&mut i.read);
                let number = before[..before.len() - i.rest.len()].trim().trim_start_matches('+');
                let digits = number.strip_prefix('-').unwrap_or(number);
                let is_plain = digits.chars().all(|c| c.is_ascii_digit() || c == '.');
                set.push((name, value, is_plain.then(|| number.to_owned())));
                let said = &whole[..whole.len() - i.rest.len()];
                out.push_str(&format!(" ({})", said.trim().replace(['(', ')'], " ")));
            }
            _ if c.is_ascii_alphabetic() => {
                out.push_str(i.take(1));
                let value = i.rest.trim_start();
                let unsigned = value.strip_prefix(['-', '+']).unwrap_or(value).trim_start();
                if unsigned.starts_with(['#', '[']) {
                    let minus = value.starts_with('-');
                    let is_plain = unsigned.starts_with('#');
                    let value = i.factor(0)?;
                    out.push_str(&written(value)?);
                    match is_plain.then(|| i.read.pop()).flatten() {
                        Some(name) => plain.push((name, c.to_ascii_uppercase(), minus)),
                        None => mixed.append(&mut i.read),
                    }
                }
            }
            _ => out.push_str(i.take(c.len_utf8())),
        }
    }
    for name in mixed {
        if let Some(param) = known.param(&name) {
            param.mixed = true;
        }
    }
    for (name, letter, minus) in plain {
        if let Some(param) = known.param(&name) {
            param.uses.push((line_number, letter, minus));
        }
    }
    for (name, value, number) in set {
        known.set(name, value, (line_number, number));
    }
    if known.values.len() > MAX_PARAMETERS {
        return Err(Wrong::Value(format!("more than {MAX_PARAMETERS} parameters")));
    }
    Ok(out)
}

/// A value as a word has it, to six decimals.
fn written(value: f64) -> Result<String, Wrong> {
    if value.abs() >= 1e9 {
        return Err(Wrong::Value("the value of a parameter is out of range".to_owned()));
    }
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    Ok(if text == "-0" { "0".to_owned() } else { text.to_owned() })
}

struct Cursor<'a, 'v> {
    rest: &'a str,
    known: &'v Known,
    /// Parameters whose values were asked for.
    read: Vec<String>,
}

impl<'a> Cursor<'a, '_> {
    fn take(&mut self, bytes: usize) -> &'a str {
        let (taken, rest) = self.rest.split_at(bytes);
        self.rest = rest;
        taken
    }

    /// Whether this sign comes next; then it is taken.
    fn sign(&mut self, sign: char) -> bool {
        let rest = self.rest.trim_start().strip_prefix(sign);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    /// `#5` or `#<name>`, as one key for each.
    fn name(&mut self) -> Result<String, Wrong> {
        let rest = self.rest.strip_prefix('#').ok_or(Wrong::Unreadable)?;
        let end = match rest.strip_prefix('<') {
            Some(name) => name.find('>').map(|at| at + 2),
            None => Some(rest.bytes().take_while(u8::is_ascii_digit).count()).filter(|n| *n > 0),
        };
        let (name, rest) = rest.split_at(end.ok_or(Wrong::Unreadable)?);
        self.rest = rest;
        let name = name.trim_start_matches('0').to_ascii_lowercase();
        Ok(name.replace(' ', ""))
    }

    fn sum(&mut self, depth: usize) -> Result<f64, Wrong> {
        let mut value = self.product(depth)?;
        loop {
            if self.sign('+') {
                value += self.product(depth)?;
            } else if self.sign('-') {
                value -= self.product(depth)?;
            } else {
                return Ok(value);
            }
        }
    }

    fn product(&mut self, depth: usize) -> Result<f64, Wrong> {
        let mut value = self.factor(depth)?;
        loop {
            // `**` is a power.
            if self.rest.trim_start().starts_with("**") {
                return Err(Wrong::Unreadable);
            } else if self.sign('*') {
                value *= self.factor(depth)?;
            } else if self.sign('/') {
                let divisor = self.factor(depth)?;
                if divisor == 0.0 {
                    return Err(Wrong::Value("a division by 0".to_owned()));
                }
                value /= divisor;
            } else {
                return Ok(value);
            }
        }
    }

    fn factor(&mut self, depth: usize) -> Result<f64, Wrong> {
        if depth > MAX_DEPTH {
            return Err(Wrong::Value("brackets are nested too deeply".to_owned()));
        }
        if self.sign('-') {
            return Ok(-self.factor(depth + 1)?);
        }
        if self.sign('+') {
            return self.factor(depth + 1);
        }
        if self.sign('[') {
            let value = self.sum(depth + 1)?;
            return if self.sign(']') { Ok(value) } else { Err(Wrong::Unreadable) };
        }
        self.rest = self.rest.trim_start();
        if self.rest.starts_with('#') {
            let name = self.name()?;
            let value = self.known.values.get(&name).map(|(value, _)| *value);
            self.read.push(name.clone());
            return value.ok_or_else(|| Wrong::Value(format!("nothing has set `#{name}` before")));
        }
        let digits = self.rest.bytes().take_while(|b| b.is_ascii_digit() || *b == b'.').count();
        let number = self.take(digits);
        number.parse().map_err(|_| Wrong::Unreadable)
    }
}
