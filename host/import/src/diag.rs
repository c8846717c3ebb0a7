//! Diagnostics of a source file: a place, what is wrong, what to do.

use super::codes::Code;

/// Diagnostics kept of one kind; what goes beyond is counted.
const MAX_KEPT: usize = 50;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// It cannot be imported.
    Error,
    /// It was imported otherwise than it stands there; an error with `--strict`.
    Warning,
    /// Worth knowing.
    Note,
}

impl Severity {
    /// As it is shown.
    pub const fn word(self) -> &'static str {
        match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        }
    }
}

/// A diagnostic at a line and column, both from 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diag {
    /// Which, of the table.
    pub code: Code,
    /// How bad.
    pub severity: Severity,
    /// Line of the source.
    pub line: u32,
    /// Column, in characters.
    pub col: u32,
    /// What is wrong, in one line, without a full stop.
    pub text: String,
    /// What to do, in one line.
    pub hint: Option<String>,
}

impl Diag {
    /// An error.
    pub fn new(code: Code, line: u32, col: u32, text: impl Into<String>) -> Diag {
        Diag { code, severity: Severity::Error, line, col, text: text.into(), hint: None }
    }

    /// The same as a warning.
    #[must_use]
    pub fn warning(mut self) -> Diag {
        self.severity = Severity::Warning;
        self
    }

    /// The same as a note.
    #[must_use]
    pub fn note(mut self) -> Diag {
        self.severity = Severity::Note;
        self
    }

    /// The same with a remedy.
    #[must_use]
    pub fn hint(mut self, hint: impl Into<String>) -> Diag {
        self.hint = Some(hint.into());
        self
    }

    /// `FILE:LINE:COL: error[CODE]: text`, and an indented line for the hint.
    pub fn render(&self, file: &str) -> String {
        let Diag { code, severity, line, col, text, hint } = self;
        let mut out = format!("{file}:{line}:{col}: {}[{}]: {text}\n", severity.word(), code.id());
        if let Some(hint) = hint {
            out += &format!("  hint: {hint}\n");
        }
        out
    }
}

/// Collects diagnostics; of each severity the first [`MAX_KEPT`].
#[derive(Debug)]
pub(crate) struct Diags {
    strict: bool,
    list: Vec<Diag>,
    counts: [usize; 3],
    last: u32,
}

impl Diags {
    /// None yet; `strict` makes errors of warnings.
    pub fn new(strict: bool) -> Diags {
        Diags { strict, list: Vec::new(), counts: [0; 3], last: 1 }
    }

    /// Adds one.
    pub fn push(&mut self, mut diag: Diag) {
        if self.strict && diag.severity == Severity::Warning {
            diag.severity = Severity::Error;
        }
        let count = &mut self.counts[diag.severity as usize];
        *count += 1;
        self.last = self.last.max(diag.line);
        if *count <= MAX_KEPT {
            self.list.push(diag);
        }
    }

    /// Adds one unless one with the same code and text is there: what repeats on every line is
    /// said once.
    pub fn once(&mut self, diag: Diag) {
        if !self.list.iter().any(|d| d.code == diag.code && d.text == diag.text) {
            self.push(diag);
        }
    }

    /// Whether one of them is an error.
    pub fn has_errors(&self) -> bool {
        self.counts[Severity::Error as usize] > 0
    }

    /// Whether so much is wrong that reading on helps nobody.
    pub fn hopeless(&self) -> bool {
        self.counts[Severity::Error as usize] > MAX_KEPT
    }

    /// In the source's order; a last one tells how many were not kept.
    pub fn into_sorted(mut self) -> Vec<Diag> {
        self.list.sort_by_key(|d| (d.line, d.col, d.code));
        let lost: usize = self.counts.iter().map(|count| count.saturating_sub(MAX_KEPT)).sum();
        if lost > 0 {
            let text = format!("{lost} further diagnostics are not shown");
            self.list.push(Diag::new(Code::Said, self.last, 1, text).note());
        }
        self.list
    }
}
