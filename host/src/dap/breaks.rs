//! Breakpoints: conditions, hit counts and log points of a line that is about to run.

use std::collections::HashMap;

use super::eval::eval;
use super::names::Names;
use super::snapshot::{Break, Snapshot};

/// The editor's breakpoints, and how often each was hit.
#[derive(Debug, Default)]
pub struct Breaks {
    list: Vec<Break>,
    hits: HashMap<u32, u64>,
}

impl Breaks {
    /// Others from now on; those that stay keep their count.
    pub fn set(&mut self, list: Vec<Break>) {
        self.list = list;
    }

    /// A run begins.
    pub fn forget_hits(&mut self) {
        self.hits.clear();
    }

    /// Whether there are none.
    pub const fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The breakpoint of one of these lines.
    pub fn at(&self, lines: &[u32]) -> Option<usize> {
        self.list.iter().position(|wanted| lines.contains(&wanted.line))
    }

    /// Whether the run halts at breakpoint `n`, of which line `line` begins. One that only says
    /// something says it: the protocol's category, and the text.
    pub fn hit(
        &mut self,
        n: usize,
        line: u32,
        names: &Names,
        shown: &Snapshot,
        say: &mut dyn FnMut(&'static str, String),
    ) -> bool {
        let Some(wanted) = self.list.get(n) else { return false };
        if let Some(condition) = &wanted.condition {
            match eval(condition, line, names, shown) {
                Ok((_, 0)) => return false,
                Ok(_) => {}
                // What cannot be read halts: else nobody would notice.
                Err(words) => say("stderr", format!("the condition `{condition}`: {words}\n")),
            }
        }
        let hits = self.hits.entry(wanted.line).or_default();
        *hits += 1;
        if wanted.hits.is_some_and(|from| *hits < from) {
            return false;
        }
        let Some(log) = &wanted.log else { return true };
        say("console", filled(log, line, names, shown) + "\n");
        false
    }
}

/// A log point's text with its `{expressions}` evaluated.
fn filled(text: &str, line: u32, names: &Names, at: &Snapshot) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, behind)) = rest.split_once('{') {
        let Some((inside, after)) = behind.split_once('}') else { break };
        out.push_str(before);
        match eval(inside, line, names, at) {
            Ok((kind, value)) => out.push_str(&format!("{value}{}", kind.unit().suffix())),
            Err(words) => out.push_str(&format!("{{{words}}}")),
        }
        rest = after;
    }
    out + rest
}
