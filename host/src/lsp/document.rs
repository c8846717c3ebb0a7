//! One open document: its text, its tree, and places as the protocol counts them.

use lang::front::ast::Script;
use lang::front::codes::Severity;
use lang::front::diag::{Diag, Diags};
use lang::front::fmt;
use lang::front::parser::parse;
use lang::front::source::Source;
use lang::front::span::Span;
use lang::front::{ProfileChoice, compile};
use lang::profile::Profile;
use lsp_types::{
    Diagnostic, DiagnosticRelatedInformation, DiagnosticSeverity, Location, NumberOrString,
    Position, Range, TextEdit, Uri,
};

/// An open document.
pub struct Document {
    source: Source,
    script: Script,
    decoding: Diags,
}

impl Document {
    /// Reads a text; one that is no script, or too long for one, becomes empty with a diagnostic.
    pub fn new(name: &str, text: String) -> Document {
        let (source, decoding) = Source::decode(name, text.as_bytes());
        let mut diags = Diags::new();
        decoding.into_iter().for_each(|diag| diags.push(diag));
        let script = parse(source.text(), &mut Diags::new());
        Document { source, script, decoding: diags }
    }

    /// Its text with its lines.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// Its tree, as far as it could be read.
    pub fn script(&self) -> &Script {
        &self.script
    }

    /// What is wrong with it.
    pub fn diagnostics(&self, uri: &Uri, profile: Option<&Profile>) -> Vec<Diagnostic> {
        let choice = match profile {
            Some(profile) => ProfileChoice::Given(Box::new(profile.clone())),
            None => ProfileChoice::built_in(),
        };
        let mut diags = self.decoding.clone();
        diags.extend(compile(&self.source, choice).1);
        diags.into_sorted().iter().map(|diag| self.diagnostic(uri, diag)).collect()
    }

    fn diagnostic(&self, uri: &Uri, diag: &Diag) -> Diagnostic {
        let related = diag.labels.iter().map(|label| DiagnosticRelatedInformation {
            location: Location { uri: uri.clone(), range: self.range(label.span) },
            message: label.text.clone(),
        });
        let message = match &diag.hint {
            Some(hint) => format!("{}\n{hint}", diag.message),
            None => diag.message.clone(),
        };
        Diagnostic {
            range: self.range(diag.span),
            severity: Some(match diag.severity {
                Severity::Error => DiagnosticSeverity::ERROR,
                Severity::Warning => DiagnosticSeverity::WARNING,
            }),
            code: Some(NumberOrString::String(diag.code.id().to_owned())),
            source: Some("pasapas".to_owned()),
            message,
            related_information: Some(related.collect()),
            ..Diagnostic::default()
        }
    }

    /// The edit that formats it; none where nothing changes or where it does not parse.
    pub fn formatted(&self) -> Option<Vec<TextEdit>> {
        let text = self.source.text();
        let new_text = fmt::format(text).ok()?;
        if new_text == text {
            return Some(Vec::new());
        }
        let range = self.range(Span::new(0, text.len() as u32));
        Some(vec![TextEdit { range, new_text }])
    }

    /// A place as the protocol counts it: lines from 0, columns in UTF-16 units from 0.
    pub fn position(&self, offset: u32) -> Position {
        let line = self.source.line(offset);
        let start = self.source.line_start(line) as usize;
        let before = self.source.text().get(start..offset as usize).unwrap_or("");
        Position::new(line - 1, before.encode_utf16().count() as u32)
    }

    /// A range as the protocol counts it.
    pub fn range(&self, span: Span) -> Range {
        Range::new(self.position(span.start), self.position(span.end))
    }

    /// The offset of a place, at most the end of its line.
    pub fn offset(&self, position: Position) -> u32 {
        let line = position.line.saturating_add(1);
        let start = self.source.line_start(line);
        let mut units = 0;
        let mut bytes = 0;
        for c in self.source.line_text(line).chars() {
            if units >= position.character {
                break;
            }
            units += c.len_utf16() as u32;
            bytes += c.len_utf8() as u32;
        }
        start + bytes
    }

    /// The word round a place, with the offset where it begins.
    pub fn word(&self, position: Position) -> (u32, &str) {
        let text = self.source.text();
        let at = (self.offset(position) as usize).min(text.len());
        let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let start = text[..at].trim_end_matches(is_part).len();
        let end = text.len() - text[at..].trim_start_matches(is_part).len();
        (start as u32, &text[start..end])
    }
}
