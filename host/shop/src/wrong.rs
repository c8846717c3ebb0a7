//! What is wrong with a file: a place, words, a remedy.

use cell::problem;

/// A diagnostic of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wrong {
    /// Line and column, both from 1.
    pub at: (u32, u32),
    /// What is wrong, in one line, without a full stop.
    pub text: String,
    /// What to do.
    pub hint: String,
    /// The file is taken all the same.
    pub warning: bool,
}

impl Wrong {
    /// An error at the beginning of a line.
    pub fn new(line: u32, text: impl Into<String>, hint: impl Into<String>) -> Wrong {
        Wrong { at: (line, 1), text: text.into(), hint: hint.into(), warning: false }
    }

    /// An error of a whole file.
    pub fn whole(text: impl Into<String>, hint: impl Into<String>) -> Wrong {
        Wrong::new(1, text, hint)
    }

    /// The same as a warning.
    #[must_use]
    pub fn warning(mut self) -> Wrong {
        self.warning = true;
        self
    }
}

/// Line and column of a byte of a text, both from 1.
pub(crate) fn place(text: &str, offset: usize) -> (u32, u32) {
    let before = text.get(..offset).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
    (u32::try_from(line).unwrap_or(u32::MAX), u32::try_from(column).unwrap_or(u32::MAX))
}

/// What a TOML file's reader did not like, with its remedy.
pub fn of_toml(text: &str, error: &toml::de::Error) -> Wrong {
    let at = place(text, error.span().unwrap_or(0..0).start);
    let (text, hint) = problem::of_toml(error);
    Wrong { at, text, hint, warning: false }
}
