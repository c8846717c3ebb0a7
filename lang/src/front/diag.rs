//! Diagnostics as data, and their plain rendering.

use super::codes::{Code, Severity};
use super::source::Source;
use super::span::Span;
use core::fmt::Write;

/// Longest line of a diagnostic, bytes: names in it may be as long as the file.
const MAX_LINE: usize = 400;

/// Diagnostics shown in one run; what goes beyond is counted only.
pub const MAX_DIAGS: usize = 50;

/// Something that is wrong, or suspicious, at a place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diag {
    /// Which, of the table of diagnostics.
    pub code: Code,
    /// Error or warning.
    pub severity: Severity,
    /// The words that it is about.
    pub span: Span,
    /// What is wrong, in one line, without a full stop.
    pub message: String,
    /// Further places that belong to it.
    pub labels: Vec<Label>,
    /// What to write instead, in one line.
    pub hint: Option<String>,
    /// The same as a change of the text, where one change does it.
    pub fix: Option<Fix>,
}

/// A change of the text that takes a diagnostic away.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fix {
    /// What is replaced; empty where something is missing.
    pub span: Span,
    /// What comes there; empty where something is too much.
    pub text: String,
}

/// A further place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// Where.
    pub span: Span,
    /// What is there.
    pub text: String,
}

impl Diag {
    /// A diagnostic with the severity that the table gives its code.
    pub fn new(code: Code, span: Span, message: impl Into<String>) -> Self {
        Self {
            code,
            severity: code.severity(),
            span,
            message: message.into(),
            labels: Vec::new(),
            hint: None,
            fix: None,
        }
    }

    /// Adds the remedy.
    #[must_use]
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// Adds the remedy as a change of the text.
    #[must_use]
    pub fn fix(mut self, span: Span, text: impl Into<String>) -> Self {
        self.fix = Some(Fix { span, text: text.into() });
        self
    }

    /// Proposes another word in the place of the one that this is about.
    #[must_use]
    pub fn near(self, word: &str) -> Self {
        let span = self.span;
        self.hint(format!("did you mean `{word}`?")).fix(span, word)
    }

    /// Adds a further place.
    #[must_use]
    pub fn label(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.push(Label { span, text: text.into() });
        self
    }

    /// Whether it keeps the script from running.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }

    /// `FILE:LINE:COL: error[CODE]: text`, then one indented line for each label and the hint.
    pub fn render(&self, source: &Source) -> String {
        let (line, column) = source.place(self.span.start);
        let name = source.name();
        let severity = self.severity.word();
        let code = self.code.id();
        let mut out = format!("{name}:{line}:{column}: {severity}[{code}]: {}\n", self.message);
        for label in &self.labels {
            let (line, column) = source.place(label.span.start);
            let _ = writeln!(out, "  {name}:{line}:{column}: {}", label.text);
        }
        if let Some(hint) = &self.hint {
            let _ = writeln!(out, "  hint: {hint}");
        }
        out
    }
}

/// Cuts a text that is longer than a line may be.
fn shorten(text: &mut String) {
    if text.len() > MAX_LINE {
        let end = (0..=MAX_LINE).rev().find(|&at| text.is_char_boundary(at)).unwrap_or(0);
        text.truncate(end);
        text.push_str("...");
    }
}

/// Collects diagnostics: at most [`MAX_DIAGS`], none twice at one place.
#[derive(Clone, Debug, Default)]
pub struct Diags {
    list: Vec<Diag>,
    dropped: usize,
}

impl Diags {
    /// None yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds one, unless the list is full or has the same code at the same place, or has said of the
    /// same word that it is no name. An error takes the place of a warning in a full list.
    pub fn push(&mut self, mut diag: Diag) {
        let texts = diag.labels.iter_mut().map(|label| &mut label.text);
        [&mut diag.message].into_iter().chain(texts).chain(&mut diag.hint).for_each(shorten);
        let known = |d: &Diag| {
            let word = diag.code == Code::BadName && d.message == diag.message;
            d.code == diag.code && (d.span.start == diag.span.start || word)
        };
        if self.list.iter().any(known) {
            return;
        }
        if self.list.len() < MAX_DIAGS {
            self.list.push(diag);
            return;
        }
        self.dropped += 1;
        if diag.is_error()
            && let Some(warning) = self.list.iter_mut().rev().find(|d| !d.is_error())
        {
            *warning = diag;
        }
    }

    /// Adds all of another list.
    pub fn extend(&mut self, other: Self) {
        self.dropped += other.dropped;
        for diag in other.list {
            self.push(diag);
        }
    }

    /// Leaves out those of which `keep` says so.
    pub fn retain(&mut self, keep: impl FnMut(&Diag) -> bool) {
        self.list.retain(keep);
    }

    /// How many errors there were, those that were not kept included.
    pub fn errors(&self) -> usize {
        self.list.iter().filter(|d| d.is_error()).count() + self.dropped
    }

    /// Whether one of them is an error.
    pub fn has_errors(&self) -> bool {
        self.list.iter().any(Diag::is_error)
    }

    /// Whether so many were dropped that reading on helps nobody.
    pub fn hopeless(&self) -> bool {
        self.dropped > 20 * MAX_DIAGS
    }

    /// How many were not kept.
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// In text order.
    pub fn into_sorted(mut self) -> Vec<Diag> {
        self.list.sort_by_key(|d| (d.span.start, d.code.id()));
        self.list
    }

    /// All of them, rendered in text order, with a last line where some were dropped.
    pub fn render(&self, source: &Source) -> String {
        let mut out: String = self.clone().into_sorted().iter().map(|d| d.render(source)).collect();
        if self.dropped > 0 {
            let _ = writeln!(out, "{} further diagnostics are not shown", self.dropped);
        }
        out
    }
}
