//! One open document: its text, the front end's result, and positions as the protocol counts
//! them.

use std::cell::OnceCell;

use lang::back::{self, VarPlace};
use lang::front::diag::{Diag, Diags};
use lang::front::index::Index;
use lang::front::lexer::lex;
use lang::front::source::Source;
use lang::front::span::Span;
use lang::front::token::Token;
use lang::front::{Analysis, ProfileChoice, analyse};
use lang::profile::Profile;
use lsp_types::{Position, Range, Uri};

use super::path;
use crate::input;

/// Bytes of the longest text that is read, and of its longest line. Of longer ones names, colours and values would take
/// seconds and gigabytes at each key.
const LONGEST: usize = 1 << 20;
const LONGEST_LINE: usize = 20_000;
/// Places and names that an answer holds at most.
pub const MOST: usize = 5_000;

/// An open document.
pub struct Document {
    uri: Uri,
    source: Source,
    analysis: Analysis,
    index: Index,
    diags: Vec<Diag>,
    imported: Option<Vec<import::Diag>>,
    unread: Option<String>,
    places: OnceCell<Vec<VarPlace>>,
}

impl Document {
    /// Reads a text, for this machine or for that of its PROFILE line. One that is no script, or too
    /// long for one, becomes empty with a diagnostic; a program of another system is not read as
    /// BASIC, its diagnostics are those of its import.
    pub fn new(uri: &Uri, text: String, profile: Option<&Profile>) -> Document {
        let path = path::of(uri);
        let name = path.rsplit('/').next().unwrap_or(&path);
        if let Some(why) = too_large(&text, name) {
            let mut document = Document::foreign(uri, name, text, Vec::new(), profile);
            document.unread = Some(why);
            return document;
        }
        if import::is_importable(name, text.as_bytes()) {
            let options = import::Options { profile: profile.cloned(), ..Default::default() };
            let imported = match import::import(name, text.as_bytes(), &options) {
                Ok(imported) => imported.notes,
                Err(diags) => diags,
            };
            return Document::foreign(uri, name, text, imported, profile);
        }
        let (source, decoding) = Source::decode(name, text.as_bytes());
        Document::read(uri, source, decoding, profile)
    }

    /// A text that is not read as BASIC.
    fn foreign(
        uri: &Uri,
        name: &str,
        text: String,
        imported: Vec<import::Diag>,
        profile: Option<&Profile>,
    ) -> Document {
        let empty = Source::new(name, String::new());
        let mut document = Document::read(uri, empty, Vec::new(), profile);
        document.source = Source::new(name, text);
        document.diags.clear();
        document.imported = Some(imported);
        document
    }

    fn read(uri: &Uri, source: Source, decoding: Vec<Diag>, profile: Option<&Profile>) -> Document {
        let path = path::of(uri);
        let find = |name: &str| input::profile_beside(name, &path).map(|(profile, _)| profile);
        let choice = match profile {
            Some(profile) => ProfileChoice::Given(Box::new(profile.clone())),
            None => ProfileChoice::Script(&find),
        };
        let mut analysis = analyse(&source, choice);
        let mut diags = Diags::new();
        decoding.into_iter().for_each(|diag| diags.push(diag));
        diags.extend(std::mem::take(&mut analysis.diags));
        let index = Index::new(&analysis.script);
        Document {
            uri: uri.clone(),
            source,
            analysis,
            index,
            diags: diags.into_sorted(),
            imported: None,
            unread: None,
            places: OnceCell::new(),
        }
    }

    /// Its name to the editor.
    pub const fn uri(&self) -> &Uri {
        &self.uri
    }

    /// Its text with its lines.
    pub const fn source(&self) -> &Source {
        &self.source
    }

    /// What the front end found.
    pub const fn analysis(&self) -> &Analysis {
        &self.analysis
    }

    /// Its names.
    pub const fn index(&self) -> &Index {
        &self.index
    }

    /// What is wrong with it as a script, in text order.
    pub fn diags(&self) -> &[Diag] {
        &self.diags
    }

    /// Why it is not read at all: it is too large.
    pub fn unread(&self) -> Option<&str> {
        self.unread.as_deref()
    }

    /// What the import says, where it is the program of another system; nothing where it is not read.
    pub fn imported(&self) -> Option<&[import::Diag]> {
        self.imported.as_deref()
    }

    /// Its tokens, comments included; none where it is no script.
    pub fn tokens(&self) -> Vec<Token> {
        if self.imported.is_some() {
            return Vec::new();
        }
        lex(self.source.text(), &mut Diags::new())
    }

    /// Where its variables live on a board; empty while it has errors or does not fit.
    pub fn places(&self) -> &[VarPlace] {
        self.places.get_or_init(|| {
            let compiled = self.analysis.program.as_ref().and_then(|p| back::compile(p).ok());
            compiled.map(|compiled| compiled.vars).unwrap_or_default()
        })
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

    /// The word round an offset, with the offset where it begins.
    pub fn word(&self, offset: u32) -> (u32, &str) {
        let text = self.source.text();
        let at = (offset as usize).min(text.len());
        let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let start = text[..at].trim_end_matches(is_part).len();
        let end = text.len() - text[at..].trim_start_matches(is_part).len();
        (start as u32, &text[start..end])
    }

    /// The text of the line before an offset.
    pub fn before(&self, offset: u32) -> &str {
        let start = self.source.line_start(self.source.line(offset));
        self.source.text().get(start as usize..offset as usize).unwrap_or("")
    }

    /// The line of a declaration, without blanks round it.
    pub fn line_of(&self, offset: u32) -> &str {
        self.source.line_text(self.source.line(offset)).trim()
    }
}

/// Why a text is too large for help while it is written.
fn too_large(text: &str, name: &str) -> Option<String> {
    let what = if text.len() > LONGEST {
        format!("the file has {:.1} MB", text.len() as f64 / 1e6)
    } else {
        let longest = text.lines().map(str::len).max().filter(|length| *length > LONGEST_LINE)?;
        format!("a line has {longest} characters")
    };
    Some(format!(
        "{what}: the editor's help is for files up to {} MB with lines up to {LONGEST_LINE} characters; `pasapas check \
         {name}` says what is wrong with it",
        LONGEST >> 20
    ))
}
