//! The text of a script: decoding from bytes, lines and columns.

use super::codes::Code;
use super::diag::Diag;
use super::span::Span;

/// Longest script that the tools read. Ten thousand lines have about half a megabyte.
pub const MAX_SOURCE_BYTES: usize = 8 << 20;

/// Pairs of bytes that [`utf16`] looks at where there is no mark.
const LOOKED_AT: usize = 512;

/// Whether a file is UTF-16 text, and then whether its low bytes come first. Without a mark it is where no pair of bytes of the
/// beginning is 0 and nine in ten have their zero in the same half, as Latin letters, digits and signs have.
pub fn utf16(bytes: &[u8]) -> Option<bool> {
    match bytes {
        [0xFF, 0xFE, ..] => return Some(true),
        [0xFE, 0xFF, ..] => return Some(false),
        _ => {}
    }
    let pairs = || bytes.chunks_exact(2).take(LOOKED_AT);
    let (all, low_first) = (pairs().count(), pairs().filter(|pair| pair[1] == 0).count());
    let high_first = pairs().filter(|pair| pair[0] == 0).count();
    let most = |count: usize, other: usize| count > 1 && other == 0 && count * 10 >= all * 9;
    match () {
        () if most(low_first, high_first) => Some(true),
        () if most(high_first, low_first) => Some(false),
        () => None,
    }
}

/// A script's text with its name and its lines.
#[derive(Clone, Debug)]
pub struct Source {
    name: String,
    text: String,
    line_starts: Vec<u32>,
}

impl Source {
    /// Decodes a file. UTF-8 is the rule, a byte order mark is skipped; bytes that are
    /// none are read as Latin-1 with a warning, as scripts from old editors are. Files that hold no text or too
    /// much of it become empty, with an error.
    pub fn decode(name: &str, bytes: &[u8]) -> (Self, Vec<Diag>) {
        if bytes.len() > MAX_SOURCE_BYTES {
            let diag = Diag::new(
                Code::FileTooLarge,
                Span::default(),
                format!(
                    "the file has {} bytes; a script has at most {MAX_SOURCE_BYTES}",
                    bytes.len()
                ),
            )
            .hint("`pasapas stream` runs long jobs; `pasapas import` turns them into scripts");
            return (Self::new(name, String::new()), vec![diag]);
        }
        if utf16(bytes).is_some() {
            let diag = Diag::new(Code::NotText, Span::default(), "the file is UTF-16 text")
                .hint("save it as UTF-8");
            return (Self::new(name, String::new()), vec![diag]);
        }
        if bytes.starts_with(b"\x7FELF") {
            let text = "this is an ELF file, as firmware is: no script, and no program of a board";
            let diag = Diag::new(Code::NotText, Span::default(), text).hint(
                "`pasapas flash` brings firmware onto a board; `pasapas disasm` and `pasapas upload` read scripts and \
                 what `pasapas build -o` wrote",
            );
            return (Self::new(name, String::new()), vec![diag]);
        }
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        // Editors of DOS end a file with Ctrl-Z.
        let bytes = bytes.strip_suffix(b"\x1A").unwrap_or(bytes);
        if let Some(at) = bytes.iter().position(|&b| b == 0) {
            let diag = Diag::new(
                Code::NotText,
                Span::default(),
                format!("the file is not text: byte {at} is 0"),
            )
            .hint("is it an image? `pasapas disasm` and `pasapas upload` read those");
            return (Self::new(name, String::new()), vec![diag]);
        }
        match core::str::from_utf8(bytes) {
            Ok(text) => (Self::new(name, text.to_owned()), Vec::new()),
            Err(error) => {
                let mut text = String::with_capacity(bytes.len() + bytes.len() / 8);
                for chunk in bytes.utf8_chunks() {
                    text.push_str(chunk.valid());
                    text.extend(chunk.invalid().iter().map(|&b| char::from(b)));
                }
                let at = error.valid_up_to() as u32;
                let first = text.get(at as usize..).and_then(|t| t.chars().next());
                let source = Self::new(name, text);
                let diag = Diag::new(
                    Code::Latin1,
                    Span::new(at, at + first.map_or(0, char::len_utf8) as u32),
                    "the file is not UTF-8; it was read as Latin-1",
                )
                .hint("save it as UTF-8");
                (source, vec![diag])
            }
        }
    }

    /// A text that is at hand, at most [`MAX_SOURCE_BYTES`] long.
    pub fn new(name: &str, text: String) -> Self {
        let mut line_starts = vec![0];
        let bytes = text.as_bytes();
        for (i, &b) in bytes.iter().enumerate() {
            // CR alone ends a line too: old Macintosh editors wrote it.
            if b == b'\n' || (b == b'\r' && bytes.get(i + 1) != Some(&b'\n')) {
                line_starts.push(i as u32 + 1);
            }
        }
        Self { name: name.to_owned(), text, line_starts }
    }

    /// The file's name, as diagnostics show it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The decoded text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Line of an offset, from 1.
    pub fn line(&self, offset: u32) -> u32 {
        self.line_starts.partition_point(|&s| s <= offset) as u32
    }

    /// Line and column (in characters) of an offset, both from 1.
    pub fn place(&self, offset: u32) -> (u32, u32) {
        let line = self.line(offset);
        let start = self.line_starts[line as usize - 1] as usize;
        let end = (offset as usize).min(self.text.len());
        let column = self.text.get(start..end).map_or(0, |s| s.chars().count());
        (line, column as u32 + 1)
    }

    /// The offset at which a line, from 1, begins; behind the last line the text's end.
    pub fn line_start(&self, line: u32) -> u32 {
        let index = (line as usize).saturating_sub(1);
        self.line_starts.get(index).copied().unwrap_or(self.text.len() as u32)
    }

    /// The text of a line, from 1, without its end.
    pub fn line_text(&self, line: u32) -> &str {
        let range =
            self.line_start(line) as usize..self.line_start(line.saturating_add(1)) as usize;
        self.text.get(range).unwrap_or("").trim_end_matches(['\n', '\r'])
    }
}
