//! What PRINT collects until its line is whole.

use std::fmt::Display;

/// See the module.
#[derive(Debug)]
pub struct Print {
    line: String,
    /// Texts of the program, by index.
    texts: Vec<String>,
}

impl Print {
    /// An empty line.
    pub fn new(texts: Vec<String>) -> Print {
        Print { line: String::new(), texts }
    }

    /// Adds the text with this index; nothing when there is none.
    pub fn text(&mut self, index: u16) {
        if let Some(text) = self.texts.get(usize::from(index)) {
            self.line.push_str(text);
        }
    }

    /// Adds whatever can be written.
    pub fn push(&mut self, what: impl Display) {
        self.line.push_str(&what.to_string());
    }

    /// The line as it is; the next begins.
    pub fn take(&mut self) -> String {
        std::mem::take(&mut self.line)
    }
}
