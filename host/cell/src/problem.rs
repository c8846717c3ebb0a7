//! What is wrong with a cell file: codes C001 to C016, each with its place.

use std::ops::Range;
use std::sync::Arc;

/// Something wrong or doubtful in a cell file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Bytes of the file that it is about.
    pub span: Range<usize>,
    /// `C001` to `C016`.
    pub code: &'static str,
    /// Whether the cell cannot be used.
    pub error: bool,
    /// What is wrong, in a line.
    pub text: String,
    /// What to write instead, in a line.
    pub hint: Option<String>,
    /// Name and text of the file that it is about, when that is an included one.
    pub of: Option<Arc<(String, String)>>,
}

impl Problem {
    /// An error.
    pub fn error(code: &'static str, span: Range<usize>, text: impl Into<String>) -> Self {
        Self { span, code, error: true, text: text.into(), hint: None, of: None }
    }

    /// A warning: the cell can be used.
    pub fn warning(code: &'static str, span: Range<usize>, text: impl Into<String>) -> Self {
        Self { error: false, ..Self::error(code, span, text) }
    }

    /// Adds the remedy.
    #[must_use]
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// Line and column of its begin in the file that it is about, `text` where that is the cell's own; both from 1, columns
    /// count characters.
    #[must_use]
    pub fn place(&self, text: &str) -> (usize, usize) {
        let text = self.of.as_ref().map_or(text, |of| &of.1);
        let mut start = self.span.start.min(text.len());
        while !text.is_char_boundary(start) {
            start -= 1;
        }
        let before = &text[..start];
        let line_begins = before.rfind('\n').map_or(0, |at| at + 1);
        (before.matches('\n').count() + 1, before[line_begins..].chars().count() + 1)
    }

    /// `FILE:LINE:COL: error[CODE]: text`, and the remedy in a line of its own.
    #[must_use]
    pub fn render(&self, file: &str, text: &str) -> String {
        let (line, column) = self.place(text);
        let file = self.of.as_ref().map_or(file, |of| &of.0);
        let severity = if self.error { "error" } else { "warning" };
        let mut out = format!("{file}:{line}:{column}: {severity}[{}]: {}\n", self.code, self.text);
        if let Some(hint) = &self.hint {
            out += &format!("  hint: {hint}\n");
        }
        out
    }
}

/// The known word that is nearest to `word`, if one is near enough to be meant.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    known
        .into_iter()
        .map(|other| {
            (strsim::damerau_levenshtein(&word.to_lowercase(), &other.to_lowercase()), other)
        })
        .filter(|&(distance, other)| distance <= 1 + other.len().min(word.len()) / 4)
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, other)| other)
}

/// What a TOML file's reader did not like, and the remedy: for a key or a word that is not known, the nearest one that
/// could stand there.
#[must_use]
pub fn of_toml(error: &toml::de::Error) -> (String, String) {
    let words = error.message().lines().next().unwrap_or_default().trim();
    // The word that is wrong, then those that are known there.
    let quoted: Vec<&str> = words.split('`').skip(1).step_by(2).collect();
    let near = |what: &str, word: &str, known: &[&str]| match nearest(word, known.iter().copied()) {
        Some(near) => format!("`{near}` is the nearest {what}"),
        None => format!("known {what}s are {}", known.join(", ")),
    };
    match quoted.split_first() {
        Some((word, known)) if words.starts_with("unknown field") => {
            (format!("there is no key `{word}` here"), near("key", word, known))
        }
        Some((word, known)) if words.starts_with("unknown variant") => {
            (format!("`{word}` is no word that stands here"), near("word", word, known))
        }
        Some((key, _)) if words.starts_with("missing field") => {
            (format!("the key `{key}` is missing"), "add it".to_owned())
        }
        _ => {
            let form =
                "a line is `key = value`: numbers as they are, texts in quotes, lists in brackets";
            (words.to_owned(), form.to_owned())
        }
    }
}
