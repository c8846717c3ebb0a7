//! Diagnostics, and their remedies as quick fixes.

use lang::front::codes::{Code, Severity};
use lang::front::diag::{Diag, Fix};
use lsp_types::{
    CodeAction, CodeActionKind, CodeActionOrCommand, Diagnostic, DiagnosticRelatedInformation,
    DiagnosticSeverity, Location, NumberOrString, Position, Range, TextEdit, WorkspaceEdit,
};

use super::document::Document;

/// What is wrong with a document.
pub fn all(document: &Document) -> Vec<Diagnostic> {
    if let Some(why) = document.unread() {
        let (place, severity) = (Range::default(), DiagnosticSeverity::INFORMATION);
        return vec![told(place, severity, Code::FileTooLarge.id(), why, None)];
    }
    match document.imported() {
        Some(notes) => notes.iter().map(|note| of_import(document, note)).collect(),
        None => document.diags().iter().map(|diag| one(document, diag)).collect(),
    }
}

fn one(document: &Document, diag: &Diag) -> Diagnostic {
    let related = diag.labels.iter().map(|label| DiagnosticRelatedInformation {
        location: Location { uri: document.uri().clone(), range: document.range(label.span) },
        message: label.text.clone(),
    });
    let severity = match diag.severity {
        Severity::Error => DiagnosticSeverity::ERROR,
        Severity::Warning => DiagnosticSeverity::WARNING,
    };
    let related_information = Some(related.collect());
    let range = document.range(diag.span);
    let told = told(range, severity, diag.code.id(), &diag.message, diag.hint.as_deref());
    Diagnostic { related_information, ..told }
}

fn of_import(document: &Document, note: &import::Diag) -> Diagnostic {
    let line = note.line.saturating_sub(1);
    let text = document.source().line_text(note.line);
    let units = |text: &str| text.encode_utf16().count() as u32;
    let before: String = text.chars().take(note.col.saturating_sub(1) as usize).collect();
    let range = Range::new(Position::new(line, units(&before)), Position::new(line, units(text)));
    let severity = match note.severity {
        import::Severity::Error => DiagnosticSeverity::ERROR,
        import::Severity::Warning => DiagnosticSeverity::WARNING,
        import::Severity::Note => DiagnosticSeverity::INFORMATION,
    };
    told(range, severity, note.code.id(), &note.text, note.hint.as_deref())
}

fn told(
    range: Range,
    severity: DiagnosticSeverity,
    code: &str,
    text: &str,
    hint: Option<&str>,
) -> Diagnostic {
    Diagnostic {
        range,
        severity: Some(severity),
        code: Some(NumberOrString::String(code.to_owned())),
        source: Some("pasapas".to_owned()),
        message: hint.map_or_else(|| text.to_owned(), |hint| format!("{text}\n{hint}")),
        ..Diagnostic::default()
    }
}

/// The remedies of what is wrong in a range.
pub fn fixes(document: &Document, range: Range) -> Vec<CodeActionOrCommand> {
    let touches = |diag: &&Diag| {
        let own = document.range(diag.span);
        own.start <= range.end && range.start <= own.end
    };
    let action = |diag: &Diag| {
        let fix = diag.fix.as_ref()?;
        let edit = TextEdit { range: document.range(fix.span), new_text: fix.text.clone() };
        Some(CodeActionOrCommand::CodeAction(CodeAction {
            title: title(document, fix),
            kind: Some(CodeActionKind::QUICKFIX),
            diagnostics: Some(vec![one(document, diag)]),
            edit: Some(edits(document, vec![edit])),
            is_preferred: Some(true),
            ..CodeAction::default()
        }))
    };
    document.diags().iter().filter(touches).filter_map(action).collect()
}

fn title(document: &Document, fix: &Fix) -> String {
    let old = fix.span.of(document.source().text()).trim();
    let new = fix.text.trim();
    match (old.is_empty(), new.is_empty()) {
        (_, true) if old.is_empty() => "Delete the blanks".to_owned(),
        (_, true) => format!("Delete `{old}`"),
        (true, _) => format!("Insert `{new}`"),
        _ => format!("Write `{new}`"),
    }
}

/// Changes of one document.
pub fn edits(document: &Document, edits: Vec<TextEdit>) -> WorkspaceEdit {
    WorkspaceEdit {
        changes: Some([(document.uri().clone(), edits)].into()),
        ..WorkspaceEdit::default()
    }
}
