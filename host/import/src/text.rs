//! From bytes to lines.

use lang::front::source::utf16;

use super::MAX_BYTES;
use super::codes::Code;
use super::diag::{Diag, Diags};

/// Longest line of a program; no controller of these systems takes more than 256 characters.
const MAX_LINE: usize = 4096;

/// Bytes that are kept of a longer comment.
const SHOWN: usize = 200;

/// Whether the whole line is one comment, of G-code or of a drill file.
fn is_comment(line: &str) -> bool {
    let line = line.trim();
    line.starts_with(';')
        || line.starts_with('(') && line.find(')').is_none_or(|at| at + 1 == line.len())
}

/// A decoded text.
#[derive(Debug)]
pub(crate) struct Lines {
    text: String,
}

/// Letters of code page 850 from 0x80 on.
const DOS: &str = "ÇüéâäàåçêëèïîìÄÅÉæÆôöòûùÿÖÜø£Ø×ƒáíóúñÑªº";

/// Whether a text is DOS's rather than Latin-1: its letters stand where Latin-1 has signs.
fn is_dos(bytes: &[u8]) -> bool {
    let count = |test: fn(u8) -> bool| bytes.iter().filter(|b| test(**b)).count();
    count(|b| matches!(b, 0x80..=0xA7)) > count(|b| b >= 0xC0 && b != 0xF8)
}

/// A byte of DOS text that is not ASCII.
fn dos_letter(byte: u8) -> char {
    match byte {
        0xF8 => '°',
        _ => DOS.chars().nth(usize::from(byte.wrapping_sub(0x80))).unwrap_or(char::from(byte)),
    }
}

impl Lines {
    /// Decodes a file: UTF-8, otherwise Latin-1 or code page 850 with a note, as Windows and DOS
    /// wrote it.
    pub fn decode(bytes: &[u8], diags: &mut Diags) -> Result<Lines, Diag> {
        if bytes.len() > MAX_BYTES {
            let text = format!("the file has {} bytes; at most {MAX_BYTES} are read", bytes.len());
            return Err(Diag::new(Code::TooLarge, 1, 1, text).hint("cut the file in pieces"));
        }
        if utf16(bytes).is_some() {
            let text = "the file is UTF-16 text";
            return Err(Diag::new(Code::NotText, 1, 1, text).hint("save it as UTF-8"));
        }
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        // The end-of-file sign of CP/M and DOS, and the zeros that fill a sector behind it.
        let filled = bytes.iter().rposition(|b| !matches!(b, 0 | 0x1A)).map_or(0, |at| at + 1);
        let bytes = &bytes[..filled];
        if let Some(at) = bytes.iter().position(|&b| b == 0) {
            let line = 1 + bytes[..at].iter().filter(|&&b| b == b'\n').count();
            let text = format!("the file is not text: byte {at} is 0");
            let diag = Diag::new(Code::NotText, u32::try_from(line).unwrap_or(u32::MAX), 1, text);
            return Err(diag.hint("programs of these systems are text files"));
        }
        let text = match core::str::from_utf8(bytes) {
            Ok(text) => text.to_owned(),
            Err(error) => {
                let before = &bytes[..error.valid_up_to()];
                let line = 1 + before.iter().filter(|&&b| b == b'\n').count();
                let line = u32::try_from(line).unwrap_or(u32::MAX);
                let dos = is_dos(bytes);
                let page = if dos { "DOS text, code page 850" } else { "Latin-1" };
                let text = format!("characters here are not UTF-8; they were read as {page}");
                diags.push(Diag::new(Code::Encoding, line, 1, text).note());
                let mut text = String::with_capacity(bytes.len() + bytes.len() / 8);
                for chunk in bytes.utf8_chunks() {
                    text.push_str(chunk.valid());
                    text.extend(chunk.invalid().iter().map(|&b| match dos {
                        true => dos_letter(b),
                        false => char::from(b),
                    }));
                }
                text
            }
        };
        Ok(Lines { text })
    }

    /// A text that was made of another.
    pub fn of(text: String) -> Lines {
        Lines { text }
    }

    /// The whole text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The lines with their numbers. They end in CR LF, LF CR, LF or CR alone. One that is too long
    /// to be a line of a program comes out empty, with an error.
    pub fn numbered<'a>(&'a self, diags: &mut Diags) -> Vec<(u32, &'a str)> {
        let mut out = Vec::new();
        let mut rest = self.text.as_str();
        let mut number = 1;
        while !rest.is_empty() {
            let end = rest.find(['\n', '\r']).unwrap_or(rest.len());
            let (line, tail) = rest.split_at(end);
            if line.len() > MAX_LINE && is_comment(line) {
                let end = (0..=SHOWN).rev().find(|end| line.is_char_boundary(*end)).unwrap_or(0);
                let text = format!("a comment of {} characters is cut off", line.len());
                diags.push(Diag::new(Code::LeftOut, number, 1, text).note());
                out.push((number, &line[..end]));
            } else if line.len() > MAX_LINE {
                let text = format!("a line of {} characters", line.len());
                let diag = Diag::new(Code::Unreadable, number, 1, text);
                diags.push(diag.hint(format!("lines have at most {MAX_LINE}")));
                if diags.hopeless() {
                    break;
                }
            } else if !line.is_empty() {
                out.push((number, line));
            }
            let sign = tail.as_bytes();
            let skip = match (sign.first(), sign.get(1)) {
                (Some(b'\r'), Some(b'\n')) | (Some(b'\n'), Some(b'\r')) => 2,
                (Some(_), _) => 1,
                (None, _) => 0,
            };
            rest = tail.get(skip..).unwrap_or_default();
            number += 1;
        }
        out
    }
}
