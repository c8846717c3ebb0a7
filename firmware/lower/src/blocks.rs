//! Code as blocks: what ends alike is one, what jumps to an end is that end, what is jumped to falls through.
//!
//! Each rule of [`SHORTER`] makes the code shorter or leaves it; they are tried until none does.

mod ends;
mod far;
mod flow;

use std::collections::{BTreeMap, BTreeSet};

use crate::ops::{Line, Op, TAIL};

/// How far a jump is trusted to reach: 127 bytes less what padding may add.
const REACH: usize = 110;

/// Jumps that may go by steps: more of them are steps of steps.
const STEPS: usize = 20;

/// A rule: the lines anew, when it finds its place.
type Rule = fn(&Blocks) -> Option<Vec<Line>>;

/// All of them.
const SHORTER: [Rule; 7] =
    [ends::merge, ends::sink, ends::elsewhere, ends::over, flow::hoist, flow::ahead, flow::follow];

/// Lines and what is known of them.
pub struct Blocks {
    lines: Vec<Line>,
    /// Functions of the file.
    here: BTreeSet<String>,
    /// Those that instructions enter, and where the micro-code of each begins.
    entries: BTreeMap<String, String>,
    /// What is made so far: names of labels.
    file: String,
}

/// The shortest code that the rules find, in whichever order they are tried.
#[must_use]
pub fn shorten(lines: Vec<Line>, file: &str) -> Vec<Line> {
    let here = lines.iter().filter_map(|line| match line {
        Line::Label(name, true) => Some(name.clone()),
        _ => None,
    });
    let here = here.collect();
    let mut blocks = Blocks { here, entries: BTreeMap::new(), file: file.to_owned(), lines };
    blocks.enter();
    blocks.jump();
    blocks.clean();
    let orders = (0..SHORTER.len()).filter_map(|first| {
        let mut rules = SHORTER;
        rules.rotate_left(first);
        blocks.shorter(&rules)
    });
    let shortest = orders.min_by_key(Blocks::bytes);
    shortest.unwrap_or(blocks).lines
}

impl Blocks {
    /// Shorter by these rules, the first one that finds a place first; unless jumps do not reach their places then.
    fn shorter(&self, rules: &[Rule]) -> Option<Blocks> {
        let mut blocks = self.with(self.lines.clone());
        'again: loop {
            for rule in rules {
                if let Some(lines) = rule(&blocks) {
                    let mut other = blocks.with(lines);
                    other.clean();
                    if other.bytes() < blocks.bytes() {
                        blocks = other;
                        continue 'again;
                    }
                }
            }
            break;
        }
        far::order(&mut blocks);
        for _ in 0..STEPS {
            match far::step(&blocks) {
                Some(lines) => blocks.lines = lines,
                None => return Some(blocks),
            }
        }
        None
    }

    /// Other lines of the same file.
    fn with(&self, lines: Vec<Line>) -> Blocks {
        let (here, entries) = (self.here.clone(), self.entries.clone());
        Blocks { lines, here, entries, file: self.file.clone() }
    }

    /// The micro-code of what instructions enter begins behind the call of the machine: there it has a label.
    fn enter(&mut self) {
        let mut at = 0;
        while at + 1 < self.lines.len() {
            if let (Line::Label(name, true), Line::Check(_)) =
                (&self.lines[at], &self.lines[at + 1])
            {
                let label = format!(".L{}_{name}", self.file);
                self.entries.insert(name.clone(), label.clone());
                self.lines.insert(at + 2, Line::Label(label, false));
            }
            at += 1;
        }
    }

    /// Bytes of an operation.
    fn size(&self, op: &Op) -> usize {
        op.size(&|name| self.here.contains(name))
    }

    fn bytes(&self) -> usize {
        self.places().last().copied().unwrap_or(0)
    }

    /// The offset of each line, and of the end.
    fn places(&self) -> Vec<usize> {
        let mut at = 0;
        let mut places = vec![0];
        for line in &self.lines {
            if let Line::Op(op) = line {
                at += self.size(op);
            }
            places.push(at);
        }
        places
    }

    /// A label that no other has.
    fn label(&self) -> String {
        let taken = |n: &usize| {
            let name = format!(".L{}_m{n}", self.file);
            self.lines.iter().any(|line| matches!(line, Line::Label(label, _) if *label == name))
        };
        let n = (0..).find(|n| !taken(n)).unwrap_or_default();
        format!(".L{}_m{n}", self.file)
    }

    fn op(&self, at: usize) -> Option<&Op> {
        match self.lines.get(at) {
            Some(Line::Op(op)) => Some(op),
            _ => None,
        }
    }

    /// The lines of operations.
    fn ops(&self) -> Vec<usize> {
        (0..self.lines.len()).filter(|at| self.op(*at).is_some()).collect()
    }

    /// The labels directly in front of a line.
    fn labels_of(&self, at: usize) -> Vec<&str> {
        let before = self.lines[..at].iter().rev();
        let labels = before.map_while(|line| match line {
            Line::Label(name, _) => Some(name.as_str()),
            _ => None,
        });
        labels.collect()
    }

    /// The operation that a label stands in front of.
    fn target(&self, label: &str) -> Option<usize> {
        let at = self
            .lines
            .iter()
            .position(|line| matches!(line, Line::Label(name, _) if name == label))?;
        let on = (at..self.lines.len()).find(|at| !matches!(self.lines[*at], Line::Label(..)))?;
        self.op(on).map(|_| on)
    }

    /// The labels that something jumps to, and functions.
    fn used(&self) -> BTreeSet<&str> {
        let mut used = self.here.iter().map(String::as_str).collect::<BTreeSet<_>>();
        for line in &self.lines {
            if let Line::Op(op) = line {
                used.extend(op.to.as_deref());
            }
        }
        used
    }

    /// Where an operation goes: a jump's label, or the function of a last call.
    fn goes_to<'a>(&self, op: &'a Op) -> Option<&'a str> {
        match op.name.as_str() {
            _ if op.when.is_some() => None,
            TAIL => op.operands.get(1).map(String::as_str),
            "GOTO" => op.to.as_deref(),
            _ => None,
        }
    }

    /// The last call of a function of the file is a jump to it, behind the call of the machine.
    fn jump(&mut self) {
        for line in &mut self.lines {
            if let Line::Op(op) = line
                && let Some(label) = op.to.as_ref().and_then(|to| self.entries.get(to))
            {
                op.to = Some(label.clone());
            }
            if let Line::Op(op) = line
                && op.name == TAIL
                && let [_, name] = &op.operands[..]
                && self.here.contains(name)
            {
                let label = self.entries.get(name).unwrap_or(name);
                *op = Op { when: op.when.clone(), ..Op::read("GOTO").to(label) };
            }
        }
    }

    /// What can be done at any time: no jump to a jump, no dead code, no jump to what follows.
    fn clean(&mut self) {
        loop {
            let before = self.lines.clone();
            self.thread();
            self.bury();
            self.fall();
            while self.invert() {}
            if self.lines == before {
                return;
            }
        }
    }

    /// Jumps go to the end of their way; a jump to an end is that end.
    fn thread(&mut self) {
        for at in 0..self.lines.len() {
            let Some(op) = self.op(at) else { continue };
            let Some(mut label) = op.to.clone() else { continue };
            for _ in 0..self.lines.len() {
                let next = self.target(&label).and_then(|target| self.op(target));
                match next.filter(|next| next.name == "GOTO" && next.when.is_none()) {
                    Some(next) => label = next.to.clone().unwrap_or(label),
                    None => break,
                }
            }
            let end = self.target(&label).and_then(|target| self.op(target));
            let end = end.filter(|end| op.name == "GOTO" && end.returns()).cloned();
            if let Line::Op(op) = &mut self.lines[at] {
                match end {
                    Some(end) => *op = Op { when: op.when.clone(), ..end },
                    None => op.to = Some(label),
                }
            }
        }
    }

    /// What no way comes to goes, and labels that nothing names.
    fn bury(&mut self) {
        let used = self.used().into_iter().map(str::to_owned).collect::<BTreeSet<_>>();
        let (mut dead, mut list) = (false, false);
        self.lines.retain(|line| match line {
            Line::Label(name, _) => {
                let keep = used.contains(name);
                dead &= !keep;
                list &= !keep;
                keep
            }
            Line::Op(op) if op.is_place() => list,
            Line::Check(check) if check.trim() == "PLACES_END" => list,
            Line::Check(_) => !dead,
            Line::Op(op) => {
                let keep = !dead;
                list = keep && op.first() == "micro_switch";
                dead |= op.is_end();
                keep
            }
        });
    }

    /// A jump to what follows goes.
    fn fall(&mut self) {
        let mut at = 0;
        while at < self.lines.len() {
            let next = self.op(at).and_then(|op| self.goes_to(op)).is_some_and(|label| {
                let behind = self.lines[at + 1..].iter();
                let mut labels = behind.take_while(|line| matches!(line, Line::Label(..)));
                labels.any(|line| matches!(line, Line::Label(name, _) if name == label))
            });
            if next {
                self.lines.remove(at);
            } else {
                at += 1;
            }
        }
    }

    /// Whether a label stands at a line and may be come to by a jump that is not taken, which leaves no flags.
    fn may_fall(&self, label: &str, at: usize) -> bool {
        let mut labels = self.lines[at..].iter().take_while(|line| matches!(line, Line::Label(..)));
        let next = self.target(label).and_then(|target| self.op(target));
        labels.any(|line| matches!(line, Line::Label(name, _) if name == label))
            && next.is_none_or(|next| !next.looks_at_flag())
    }

    /// A jump over a jump, or over an end that there is elsewhere, is one jump.
    fn invert(&mut self) -> bool {
        let places = self.places();
        for at in 0..self.lines.len().saturating_sub(2) {
            // Labels between them are what others jump to this end by.
            let labels = self.lines[at + 1..].iter().map_while(|line| match line {
                Line::Label(name, false) => Some(name.clone()),
                _ => None,
            });
            let labels = labels.collect::<Vec<_>>();
            let last = at + 1 + labels.len();
            let (Some(over), Some(end)) = (self.op(at), self.op(last)) else { continue };
            let (Some(inverse), Some(past)) = (crate::ops::inverse(&over.name), &over.to) else {
                continue;
            };
            if over.when.is_some() || end.when.is_some() || !self.may_fall(past, last + 1) {
                continue;
            }
            let mut turned = Op { name: inverse.to_owned(), ..over.clone() };
            if end.name == "GOTO" && labels.is_empty() {
                turned.to.clone_from(&end.to);
                self.lines[at] = Line::Op(turned);
                self.lines.remove(last);
                return true;
            }
            if !end.returns() {
                continue;
            }
            let jumps = self.ops().into_iter().filter(|n| {
                let to = self.op(*n).and_then(|op| op.to.as_ref());
                *n == at || to.is_some_and(|to| labels.contains(to))
            });
            let jumps = jumps.collect::<Vec<_>>();
            let near =
                |n: &usize| jumps.iter().all(|jump| places[*jump].abs_diff(places[*n]) < REACH);
            let others = self.ops().into_iter();
            let others = others.filter(|n| *n != last && self.op(*n) == Some(end) && near(n));
            if let Some(other) = others.min_by_key(|other| places[*other].abs_diff(places[at])) {
                let label = self.label();
                turned.to = Some(label.clone());
                self.lines[at] = Line::Op(turned);
                let there = labels.into_iter().chain([label]).map(|name| Line::Label(name, false));
                let there = there.collect::<Vec<_>>();
                let moved = there.len();
                self.lines.splice(other..other, there);
                let from = if other > at { at + 1 } else { at + 1 + moved };
                self.lines.drain(from..from + moved);
                return true;
            }
        }
        false
    }
}
