//! A cell file and those that it includes, one after the other as one text. Spans are bytes of that text, until a
//! problem is reported: it names its own file.

use std::sync::Arc;

use toml::de::{DeTable, DeValue};

use super::problem::Problem;

/// Reads files that a cell names, by their name as the cell writes it.
pub type Files<'a> = &'a dyn Fn(&str) -> Result<String, String>;

/// Files that a cell may be made of.
const MOST_FILES: usize = 64;

/// A file of the text.
struct Piece {
    /// Its name; of the first, which the caller knows, empty.
    file: String,
    /// Its bytes.
    from: usize,
    to: usize,
}

/// See the module.
pub struct Sources {
    /// All texts, each with a line end behind it.
    pub text: String,
    pieces: Vec<Piece>,
}

impl Sources {
    /// A cell file with what it includes, and what those include; each file once. Names are relative to the first.
    /// Files that cannot be read are told.
    pub fn gather(text: &str, files: Files<'_>, problems: &mut Vec<Problem>) -> Self {
        let mut own = Self { text: text.to_owned(), pieces: Vec::new() };
        own.pieces.push(Piece { file: String::new(), from: 0, to: text.len() });
        let mut index = 0;
        while index < own.pieces.len() {
            for (name, span) in own.included(index) {
                if own.pieces.iter().any(|piece| piece.file == name) {
                    continue;
                }
                if own.pieces.len() >= MOST_FILES {
                    let text = format!("`include` names more than {MOST_FILES} files");
                    problems.push(Problem::error("C015", span, text));
                    return own;
                }
                match files(&name) {
                    Ok(text) => {
                        own.text.push('\n');
                        let from = own.text.len();
                        own.text += &text;
                        own.pieces.push(Piece { file: name, from, to: own.text.len() });
                    }
                    Err(reason) => problems.push(
                        Problem::error("C015", span, format!("include \"{name}\": {reason}"))
                            .hint("names of files are relative to the cell file"),
                    ),
                }
            }
            index += 1;
        }
        own
    }

    /// What a piece includes, with the place where it says so.
    fn included(&self, index: usize) -> Vec<(String, std::ops::Range<usize>)> {
        let piece = &self.pieces[index];
        let (document, _) = DeTable::parse_recoverable(&self.text[piece.from..piece.to]);
        let document = document.get_ref();
        let Some(DeValue::Array(items)) = document.get("include").map(|value| value.get_ref())
        else {
            return Vec::new();
        };
        let names = items.iter().filter_map(|item| {
            let span = item.span();
            let name = item.get_ref().as_str()?.to_owned();
            Some((name, span.start + piece.from..span.end + piece.from))
        });
        names.collect()
    }

    /// The texts with the bytes at which they begin.
    pub fn texts(&self) -> impl Iterator<Item = (&str, usize)> {
        self.pieces.iter().map(|piece| (&self.text[piece.from..piece.to], piece.from))
    }

    /// Gives problems in included files the names and texts of those.
    pub fn name(&self, problems: &mut [Problem]) {
        for problem in problems {
            let at = problem.span.start;
            let own = self.pieces.iter().skip(1).find(|own| (own.from..=own.to).contains(&at));
            if let Some(piece) = own {
                let text = self.text[piece.from..piece.to].to_owned();
                problem.of = Some(Arc::new((piece.file.clone(), text)));
                problem.span = at - piece.from..problem.span.end.min(piece.to) - piece.from;
            }
        }
    }
}
