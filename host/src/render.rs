//! Diagnostics for people and for tools: `FILE:LINE:COL: error[CODE]: text` with the source line, or
//! one JSON line each.
//!
//! On a terminal the source is drawn with all places of the diagnostic. In a pipe the line follows
//! with a caret under the place. Each further line begins with two blanks there, so that a tool that
//! reads lines finds the first one as it always was.

use std::io::IsTerminal;
use std::ops::Range;

use ariadne::{CharSet, Color, Config, Label, Report, ReportKind, Source as Excerpt};
use lang::front::codes::Severity as LangSeverity;
use lang::front::diag::Diag;
use lang::front::source::Source;
use lang::front::span::Span;
use serde::Serialize;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// It cannot run.
    Error,
    /// It can run.
    Warning,
    /// It runs, and this is worth knowing.
    Note,
}

impl Severity {
    const fn word(self) -> &'static str {
        match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        }
    }
}

/// A diagnostic with its place resolved.
#[derive(Clone, Debug, Serialize)]
pub struct Note {
    /// The file, as it was named.
    pub file: String,
    /// Line and column, from 1.
    #[serde(skip)]
    pub place: (u32, u32),
    /// How bad.
    pub severity: Severity,
    /// A capital letter and three digits.
    pub code: &'static str,
    /// What is wrong.
    pub text: String,
    /// What to write instead.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hint: Option<String>,
    /// Further places.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub labels: Vec<Further>,
    /// Bytes of the source that it is about.
    #[serde(skip)]
    pub span: Range<usize>,
}

/// Characters of a source line that are shown in a pipe.
const WIDEST: usize = 120;

/// A further place of a diagnostic.
#[derive(Clone, Debug, Serialize)]
pub struct Further {
    /// Line, from 1.
    pub line: u32,
    /// Column, from 1.
    pub col: u32,
    /// What is there.
    pub text: String,
    /// Bytes of the source.
    #[serde(skip)]
    pub span: Range<usize>,
}

impl Note {
    /// An error of a file as a whole: at its first character.
    pub fn error(file: &str, code: &'static str, text: String) -> Note {
        Note {
            file: file.to_owned(),
            place: (1, 1),
            severity: Severity::Error,
            code,
            text,
            hint: None,
            labels: Vec::new(),
            span: 0..0,
        }
    }

    /// An error of a stretch of a source.
    pub fn in_source(
        source: &Source,
        span: Range<usize>,
        code: &'static str,
        text: String,
    ) -> Note {
        let place = source.place(u32::try_from(span.start).unwrap_or(u32::MAX));
        Note { span, ..Note::error(source.name(), code, text).at(place) }
    }

    /// The same at a line and a column, from 1.
    #[must_use]
    pub fn at(mut self, place: (u32, u32)) -> Note {
        self.place = place;
        self
    }

    /// The same as a warning.
    #[must_use]
    pub fn warning(mut self) -> Note {
        self.severity = Severity::Warning;
        self
    }

    /// The same as a remark.
    #[must_use]
    pub fn note(mut self) -> Note {
        self.severity = Severity::Note;
        self
    }

    /// The same with a remedy.
    #[must_use]
    pub fn hint(mut self, hint: impl Into<String>) -> Note {
        self.hint = Some(hint.into());
        self
    }

    /// A diagnostic of the language.
    pub fn of(diag: &Diag, source: &Source) -> Note {
        let range = |span: Span| span.start as usize..span.end as usize;
        let further = diag.labels.iter().map(|label| {
            let (line, col) = source.place(label.span.start);
            Further { line, col, text: label.text.clone(), span: range(label.span) }
        });
        Note {
            severity: match diag.severity {
                LangSeverity::Error => Severity::Error,
                LangSeverity::Warning => Severity::Warning,
            },
            hint: diag.hint.clone(),
            labels: further.collect(),
            ..Note::in_source(source, range(diag.span), diag.code.id(), diag.message.clone())
        }
    }

    /// `FILE:LINE:COL: error[CODE]: text`
    pub fn line(&self) -> String {
        let (line, col) = self.place;
        let Note { file, severity, code, text, .. } = self;
        format!("{file}:{line}:{col}: {}[{code}]: {text}", severity.word())
    }

    /// The line, then an indented one for each further place and for the hint.
    pub fn plain(&self) -> String {
        self.with("")
    }

    /// The same with the source line and carets under the place, behind the first line.
    pub fn quoted(&self, source: &Source) -> String {
        let (line, _) = self.place;
        let text = source.line_text(line).trim_end();
        let start = source.line_start(line) as usize;
        let before = text.get(..self.span.start.saturating_sub(start).min(text.len()));
        let (Some(before), false) = (before, text.trim().is_empty()) else { return self.plain() };
        let inside = text.get(before.len()..).unwrap_or_default();
        let length = self.span.end.saturating_sub(self.span.start).min(inside.len());
        let count = inside.char_indices().take_while(|(at, _)| *at < length).count().max(1);
        let (column, all) = (before.chars().count(), text.chars().count());
        // Of a long line what stands around the place.
        let first = if all > WIDEST { column.saturating_sub(WIDEST / 3) } else { 0 };
        let cut = |at: usize| if at > 0 { "..." } else { "" };
        let shown: String = text
            .chars()
            .skip(first)
            .take(WIDEST)
            .map(|c| if c.is_control() { ' ' } else { c })
            .collect();
        let number = line.to_string();
        let gap = " ".repeat(number.len());
        let indent = " ".repeat(column - first + cut(first).len());
        let carets = "^".repeat(count.min(first + WIDEST - column));
        let rest = cut(all.saturating_sub(first + WIDEST));
        self.with(&format!(
            "  {number} | {}{shown}{rest}\n  {gap} | {indent}{carets}\n",
            cut(first)
        ))
    }

    fn with(&self, excerpt: &str) -> String {
        let mut out = self.line();
        out.push('\n');
        out += excerpt;
        for further in &self.labels {
            let Further { line, col, text, .. } = further;
            out += &format!("  {}:{line}:{col}: {text}\n", self.file);
        }
        if let Some(hint) = &self.hint {
            out += &format!("  hint: {hint}\n");
        }
        out
    }

    /// One JSON object, without a line end.
    pub fn json(&self) -> String {
        #[derive(Serialize)]
        struct Line<'a> {
            line: u32,
            col: u32,
            #[serde(flatten)]
            note: &'a Note,
        }
        let (line, col) = self.place;
        serde_json::to_string(&Line { line, col, note: self }).unwrap_or_default()
    }
}

/// Whether somebody reads standard error, who wants to see the source.
pub fn stderr_is_rich() -> bool {
    std::io::stderr().is_terminal()
}

/// The first line of [`Note::plain`], then the source with the places marked.
pub fn excerpt(note: &Note, source: &Source) -> String {
    drawn(note, source, std::env::var_os("NO_COLOR").is_none())
}

fn drawn(note: &Note, source: &Source, colours: bool) -> String {
    let length = source.text().len();
    let range = |span: &Range<usize>| {
        let start = span.start.min(length);
        // A point gets one character's width, or nothing would be underlined.
        start..span.end.clamp(start, length).max((start + 1).min(length))
    };
    let (kind, color) = match note.severity {
        Severity::Error => (ReportKind::Error, Color::Red),
        Severity::Warning => (ReportKind::Warning, Color::Yellow),
        Severity::Note => (ReportKind::Advice, Color::Blue),
    };
    let file = source.name();
    let span = range(&note.span);
    let config = Config::default()
        .with_index_type(ariadne::IndexType::Byte)
        .with_char_set(CharSet::Unicode)
        .with_color(colours);
    let mut report = Report::build(kind, (file, span.clone()))
        .with_config(config)
        .with_label(Label::new((file, span)).with_color(color).with_message(&note.text));
    for further in &note.labels {
        let label = Label::new((file, range(&further.span))).with_color(Color::Cyan);
        report = report.with_label(label.with_message(&further.text));
    }
    if let Some(hint) = &note.hint {
        report = report.with_help(hint);
    }
    let mut drawn = Vec::new();
    let written = report.finish().write((file, Excerpt::from(source.text())), &mut drawn);
    let drawn = String::from_utf8_lossy(&drawn);
    match (written, drawn.split_once('\n')) {
        // The report's own head line says less than ours.
        (Ok(()), Some((_head, body))) => format!("{}\n{body}", note.line()),
        _ => note.plain(),
    }
}

#[cfg(test)]
mod tests {
    use super::{Note, excerpt};
    use lang::front::codes::Code;
    use lang::front::diag::Diag;
    use lang::front::source::Source;
    use lang::front::span::Span;

    fn sample() -> (Diag, Source) {
        let source = Source::new("a.bas", "DIM n\nWait 5\n".to_owned());
        let diag = Diag::new(Code::Expected, Span::new(11, 12), "`Wait 5` needs a time")
            .hint("write `5ms` or `5s`")
            .label(Span::new(4, 5), "declared here");
        (diag, source)
    }

    #[test]
    fn the_plain_form_is_the_contract() {
        let (diag, source) = sample();
        assert_eq!(
            Note::of(&diag, &source).plain(),
            "a.bas:2:6: error[P002]: `Wait 5` needs a time\n  \
             a.bas:1:5: declared here\n  hint: write `5ms` or `5s`\n"
        );
    }

    /// The first line is the contract; the others begin with a blank.
    #[test]
    fn in_a_pipe_the_source_line_and_a_caret_follow() {
        let (diag, source) = sample();
        assert_eq!(
            Note::of(&diag, &source).quoted(&source),
            "a.bas:2:6: error[P002]: `Wait 5` needs a time\n  \
             2 | Wait 5\n    |      ^\n  \
             a.bas:1:5: declared here\n  hint: write `5ms` or `5s`\n"
        );
    }

    #[test]
    fn carets_stand_under_their_place_in_any_line() {
        let line = |text: &str, from: &str| {
            let source = Source::new("a.bas", format!("\n{text}\r\nEND\n"));
            let at = source.text().find(from).expect("the place");
            let span = Span::new(at as u32, (at + from.len()) as u32);
            let shown = Note::of(&Diag::new(Code::Expected, span, "no"), &source).quoted(&source);
            let lines: Vec<&str> = shown.lines().collect();
            assert_eq!(lines.len(), 3, "{shown}");
            let caret = lines[2].find('^').expect("a caret");
            let carets = lines[2].matches('^').count();
            assert_eq!(caret + carets, lines[2].len(), "{shown}");
            lines[1].chars().skip(caret).take(carets).collect::<String>()
        };
        assert_eq!(line("Wait 500", "500"), "500");
        assert_eq!(line("\tWait\t5", "5"), "5");
        assert_eq!(line("PRINT \"\u{e9}t\u{e9}\" 12", "12"), "12");
        let long = format!("{} wrong {}", "a".repeat(3000), "b".repeat(3000));
        assert_eq!(line(&long, "wrong"), "wrong");
        // Nothing is drawn of an empty line, nor beyond the end of the file.
        let source = Source::new("a.bas", "\n".to_owned());
        let note = Note::of(&Diag::new(Code::Expected, Span::point(1), "no"), &source);
        assert_eq!(note.quoted(&source), note.plain());
    }

    #[test]
    fn the_json_form_is_one_line() {
        let (diag, source) = sample();
        assert_eq!(
            Note::of(&diag, &source).json(),
            r#"{"line":2,"col":6,"file":"a.bas","severity":"error","code":"P002","text":"`Wait 5` needs a time","hint":"write `5ms` or `5s`","labels":[{"line":1,"col":5,"text":"declared here"}]}"#
        );
    }

    #[test]
    fn the_excerpt_begins_with_the_contract_and_shows_the_source() {
        let (diag, source) = sample();
        let text = excerpt(&Note::of(&diag, &source), &source);
        assert!(text.starts_with("a.bas:2:6: error[P002]: `Wait 5` needs a time\n"), "{text}");
        assert!(text.contains("Wait 5") && text.contains("declared here"), "{text}");
    }

    #[test]
    fn without_colours_the_source_is_shown_all_the_same() {
        let (diag, source) = sample();
        let text = super::drawn(&Note::of(&diag, &source), &source, false);
        assert!(!text.contains('\u{1b}'), "{text}");
        assert!(text.contains("2 \u{2502} Wait 5"), "{text}");
        assert!(text.contains("write `5ms` or `5s`"), "{text}");
    }

    #[test]
    fn a_place_at_the_end_of_an_empty_file_can_be_shown() {
        let source = Source::new("a.bas", String::new());
        let diag = Diag::new(Code::Expected, Span::point(0), "nothing");
        assert!(
            excerpt(&Note::of(&diag, &source), &source)
                .starts_with("a.bas:1:1: error[P002]: nothing")
        );
    }
}
