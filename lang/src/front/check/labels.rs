//! Labels: where they stand, and from where they may be reached.

use std::collections::HashMap;

use super::{Checker, MAIN, range};
use crate::front::ast::{Block, Name, StmtKind};
use crate::front::codes::Code;
use crate::front::diag::Diag;
use crate::front::span::Span;
use crate::front::words::nearest;
use crate::hir::{self, LabelId, RoutineId};

/// A block, numbered over the whole script.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct BlockId(u32);

#[derive(Debug)]
struct Label<'a> {
    name: &'a Name,
    routine: RoutineId,
    block: BlockId,
    used: bool,
}

/// All labels and the tree of blocks.
#[derive(Debug, Default)]
pub(super) struct Labels<'a> {
    list: Vec<Label<'a>>,
    by_name: Vec<HashMap<&'a str, LabelId>>,
    /// The block around each block; that of a routine's body is itself.
    parents: Vec<BlockId>,
    /// The block of each statement list, by the address-free key of its first statement's place.
    blocks: HashMap<(u32, u32), BlockId>,
}

/// A key for a block: the place of its first statement and how many there are.
fn key(block: &Block) -> Option<(u32, u32)> {
    block.first().map(|stmt| (stmt.span.start, stmt.span.end))
}

impl<'a> Labels<'a> {
    pub fn new(routines: usize) -> Labels<'a> {
        Labels { by_name: vec![HashMap::new(); routines], ..Labels::default() }
    }

    /// Whether a jump from `from` reaches `to` by leaving blocks only.
    fn leaves(&self, mut from: BlockId, to: BlockId) -> bool {
        loop {
            if from == to {
                return true;
            }
            let parent = self.parents[from.0 as usize];
            if parent == from {
                return false;
            }
            from = parent;
        }
    }

    /// The block that a statement list is.
    pub fn block(&self, block: &Block) -> BlockId {
        key(block).and_then(|key| self.blocks.get(&key)).copied().unwrap_or_default()
    }

    pub fn id(&self, routine: RoutineId, key: &str) -> Option<LabelId> {
        self.by_name.get(routine.0 as usize)?.get(key).copied()
    }

    /// Number of labels.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Name and place of a label.
    pub fn name(&self, id: LabelId) -> &'a Name {
        self.list[id.0 as usize].name
    }

    pub fn unused(&self) -> Vec<(Span, &'a str)> {
        let unused = self.list.iter().filter(|label| !label.used);
        unused.map(|label| (label.name.span, &*label.name.text)).collect()
    }

    pub fn to_hir(&self) -> Vec<hir::Label> {
        let label = |label: &Label<'a>| hir::Label {
            name: label.name.text.to_string(),
            routine: label.routine,
            span: range(label.name.span),
        };
        self.list.iter().map(label).collect()
    }
}

impl<'a> Checker<'a> {
    /// Finds every label and numbers the blocks.
    pub(super) fn find_labels(&mut self) {
        for (id, body) in self.bodies() {
            self.scope = id;
            self.number_block(body, None);
        }
        self.scope = MAIN;
    }

    fn number_block(&mut self, block: &'a Block, parent: Option<BlockId>) {
        let id = BlockId(self.labels.parents.len() as u32);
        self.labels.parents.push(parent.unwrap_or(id));
        if let Some(key) = key(block) {
            self.labels.blocks.insert(key, id);
        }
        for stmt in block {
            if let StmtKind::Label(name) = &stmt.kind {
                self.add_label(name, id);
            }
            for inner in stmt.blocks() {
                self.number_block(inner, Some(id));
            }
        }
    }

    fn add_label(&mut self, name: &'a Name, block: BlockId) {
        let routine = self.scope;
        let id = LabelId(self.labels.list.len() as u32);
        if let Some(&first) = self.labels.by_name[routine.0 as usize].get(&*name.key) {
            let first = self.labels.name(first).span;
            let message = format!("the label `{}` stands twice", name.text);
            let diag = Diag::new(Code::DeclaredTwice, name.span, message)
                .label(first, "first here")
                .hint("give one of them another name");
            self.diags.push(diag);
            return;
        }
        self.labels.by_name[routine.0 as usize].insert(&name.key, id);
        self.labels.list.push(Label { name, routine, block, used: false });
    }

    /// The label that a jump in the present routine goes to, which must not enter a block.
    pub(super) fn jump(&mut self, name: &'a Name, from: BlockId) -> Option<LabelId> {
        let id = self.label(self.scope, name)?;
        let label = &self.labels.list[id.0 as usize];
        if !self.labels.leaves(from, label.block) {
            let diag = Diag::new(
                Code::JumpIntoBlock,
                name.span,
                format!("`{}` stands inside a block that this jump would enter", name.text),
            )
            .label(label.name.span, "the label")
            .hint("move the label out of the block, or make the block a SUB");
            self.diags.push(diag);
            return None;
        }
        Some(id)
    }

    /// A label of a routine that stands outside all blocks: where handlers begin.
    pub(super) fn handler_label(&mut self, name: &'a Name) -> Option<LabelId> {
        let id = self.label(MAIN, name)?;
        let label = &self.labels.list[id.0 as usize];
        if self.labels.parents[label.block.0 as usize] != label.block {
            let diag = Diag::new(
                Code::JumpIntoBlock,
                name.span,
                format!("a handler can not begin inside a block, as `{}` does", name.text),
            )
            .label(label.name.span, "the label")
            .hint("move the label out of the block");
            self.diags.push(diag);
            return None;
        }
        Some(id)
    }

    fn label(&mut self, routine: RoutineId, name: &'a Name) -> Option<LabelId> {
        if let Some(id) = self.labels.id(routine, &name.key) {
            self.labels.list[id.0 as usize].used = true;
            return Some(id);
        }
        let here = self.labels.by_name.get(routine.0 as usize);
        let mut known: Vec<&str> =
            here.into_iter().flatten().map(|(_, &id)| &*self.labels.name(id).text).collect();
        known.sort_unstable();
        let elsewhere = self.labels.list.iter().find(|label| label.name.key == name.key);
        let message =
            format!("there is no label `{}` in {}", name.text, self.routine_name(routine));
        let diag = Diag::new(Code::UnknownLabel, name.span, message);
        let diag = match (nearest(&name.text, known), elsewhere) {
            (Some(near), _) => diag.near(near),
            (None, Some(label)) => diag.hint(format!(
                "there is one in {}, but labels belong to their SUB",
                self.routine_name(label.routine)
            )),
            (None, None) => diag.hint(format!("write `{}:` at the start of a line", name.text)),
        };
        self.diags.push(diag);
        None
    }
}
