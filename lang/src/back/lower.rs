//! From statements to instructions.

mod control;
mod cycle;
mod expr;
mod machine;

use std::collections::HashMap;

use crate::back::ir::{Handler, Item, Label, RoutineCode, SourceMark, TextId, Unit};
use crate::back::opt;
use crate::back::report::MarkKind;
use crate::hir::{
    Block, GosubTarget, LabelId, LoopKind, Program, Routine, RoutineId, Span, Stmt, StmtKind, VarId,
};
use crate::isa::Op;
use crate::record::feature;

/// Longest text of one instruction; a longer one becomes several.
const MAX_TEXT: usize = 255;

/// An enclosing loop.
struct Loop {
    kind: LoopKind,
    /// CONTINUE
    next: Label,
    /// EXIT
    exit: Label,
}

/// Whether a block holds RESUME NEXT.
fn resumes(block: &Block) -> bool {
    block.iter().any(|stmt| match &stmt.kind {
        StmtKind::ResumeNext => true,
        kind => kind.blocks().into_iter().any(resumes),
    })
}

struct Lower<'p> {
    program: &'p Program,
    items: Vec<Item>,
    labels: u32,
    /// Labels of the source, once they were met.
    named: HashMap<LabelId, Label>,
    texts: Vec<Vec<u8>>,
    text_ids: HashMap<Vec<u8>, TextId>,
    events: Vec<Handler>,
    features: u16,
    loops: Vec<Loop>,
    routine: RoutineId,
    /// The statement at hand.
    line: u32,
    span: Span,
    /// Where RESUME NEXT goes on from each part of the statement at hand.
    behind: Option<Label>,
    /// Some statement of the program may fail and be gone on with.
    resumes: bool,
}

/// Lowers every routine that is reached.
pub fn lower(program: &Program) -> Unit {
    let mut lower = Lower {
        program,
        items: Vec::new(),
        labels: 0,
        named: HashMap::new(),
        texts: Vec::new(),
        text_ids: HashMap::new(),
        events: Vec::new(),
        features: 0,
        loops: Vec::new(),
        routine: RoutineId(0),
        line: 1,
        span: 0..0,
        behind: None,
        resumes: program.routines.iter().any(|routine| resumes(&routine.body)),
    };
    if program.vars.iter().any(|var| matches!(var.storage, crate::hir::Storage::Keep(_))) {
        lower.features |= feature::KEEP;
    }
    let mut routines = Vec::new();
    for (i, routine) in program.routines.iter().enumerate() {
        if i == 0 || routine.reachable {
            let id = RoutineId(i as u32);
            routines.push(RoutineCode { id, items: lower.routine(id, routine) });
        }
    }
    for routine in &mut routines {
        lower.without_unneeded(&mut routine.items);
    }
    Unit {
        routines,
        texts: lower.texts,
        events: lower.events,
        features: lower.features,
        labels: lower.labels,
    }
}

impl Lower<'_> {
    fn routine(&mut self, id: RoutineId, routine: &Routine) -> Vec<Item> {
        self.routine = id;
        self.span = routine.span.clone();
        self.line = routine.body.first().map_or(1, |stmt| stmt.line);
        if id.0 != 0 {
            self.mark(MarkKind::Glue, None);
            for &local in &routine.locals {
                self.clear(local);
            }
        }
        self.block(&routine.body);
        match (id.0, &routine.result) {
            (0, _) => {
                // A run that falls off the end ends in the last line.
                self.line = self.program.last_line;
                self.mark(MarkKind::Glue, None);
                self.plain(Op::End);
            }
            (_, None) => {
                self.mark(MarkKind::Glue, None);
                self.plain(Op::ExitSub);
            }
            (_, Some(_)) => {
                self.mark(MarkKind::Glue, None);
                self.push(Item::Const(0));
                self.plain(Op::Give);
            }
        }
        core::mem::take(&mut self.items)
    }

    /// Drops what only programs with ON lines or ON ERROR need, now that it is known whether this
    /// is one, and zeros that are overwritten at once.
    fn without_unneeded(&self, items: &mut Vec<Item>) {
        let events = self.features & feature::EVENTS != 0;
        let errors = self.features & feature::LINES != 0;
        items.retain(|item| match item {
            Item::Plain(Op::More) => events,
            Item::Plain(Op::Leave) => errors,
            _ => true,
        });
        if errors {
            // RESUME NEXT may skip the statement that writes first.
            return;
        }
        let clears = |pair: &[Item]| match pair {
            [Item::Const(0), Item::Store(var)] => Some(*var),
            _ => None,
        };
        let prologue = items.get(1..).unwrap_or_default();
        let count = 2 * prologue.chunks_exact(2).take_while(|pair| clears(pair).is_some()).count();
        let (prologue, body) = prologue.split_at(count);
        let kept: Vec<Item> = prologue
            .chunks_exact(2)
            .filter(|pair| clears(pair).is_some_and(|var| !opt::written_first(body, var)))
            .flatten()
            .cloned()
            .collect();
        if self.program.routines.len() > 1 && count > 0 {
            items.splice(1..=count, kept);
        }
    }

    /// A local is 0 at each call.
    fn clear(&mut self, local: VarId) {
        let var = self.program.var(local);
        for i in 0..var.len {
            self.push(Item::Const(0));
            self.push(if var.array { Item::StoreAt(local, i) } else { Item::Store(local) });
        }
    }

    fn push(&mut self, item: Item) {
        self.items.push(item);
    }

    fn plain(&mut self, op: Op) {
        self.push(Item::Plain(op));
    }

    fn fresh(&mut self) -> Label {
        self.labels += 1;
        Label(self.labels - 1)
    }

    fn named(&mut self, id: LabelId) -> Label {
        if let Some(&label) = self.named.get(&id) {
            return label;
        }
        let label = self.fresh();
        self.named.insert(id, label);
        label
    }

    /// What follows belongs to the statement at hand.
    fn mark(&mut self, kind: MarkKind, resume: Option<Label>) {
        self.mark_line(self.line, kind, resume);
    }

    fn mark_line(&mut self, line: u32, kind: MarkKind, resume: Option<Label>) {
        let span = self.span.clone();
        let resume = self.behind.or(resume);
        self.push(Item::Mark(SourceMark { line, span, kind, resume }));
    }

    fn text(&mut self, bytes: &[u8]) -> TextId {
        if let Some(&id) = self.text_ids.get(bytes) {
            return id;
        }
        let id = TextId(self.texts.len() as u32);
        self.texts.push(bytes.to_vec());
        self.text_ids.insert(bytes.to_vec(), id);
        id
    }

    fn block(&mut self, block: &Block) {
        let outer = self.behind.take();
        for parts in block.chunk_by(Stmt::continues) {
            if parts.len() > 1 && self.resumes {
                self.behind = Some(self.fresh());
            }
            for part in parts {
                self.stmt(part);
            }
            if let Some(label) = self.behind.take() {
                self.push(Item::Label(label));
            }
        }
        self.behind = outer;
    }

    fn stmt(&mut self, stmt: &Stmt) {
        self.line = stmt.line;
        self.span = stmt.span.clone();
        if let StmtKind::Label(id) = &stmt.kind {
            let label = self.named(*id);
            self.push(Item::Label(label));
            return;
        }
        if self.control(stmt) {
            return;
        }
        self.mark(MarkKind::Statement, None);
        match &stmt.kind {
            StmtKind::Assign(place, value) => self.assign(place, value),
            StmtKind::Goto(label) => {
                let label = self.named(*label);
                if self.routine.0 == 0 {
                    // Dropped again where no error handler can reach it.
                    self.plain(Op::Leave);
                }
                self.push(Item::Jump(label));
            }
            StmtKind::Gosub(GosubTarget::Label(label)) => {
                let label = self.named(*label);
                self.push(Item::Gosub(label));
            }
            StmtKind::Gosub(GosubTarget::Sub(sub)) => self.push(Item::Call(Op::Call, *sub)),
            StmtKind::Return => self.plain(Op::Return),
            StmtKind::ReturnValue(value) => {
                self.expr(value);
                self.plain(Op::Give);
            }
            StmtKind::ExitRoutine => match self.program.routine(self.routine).result {
                None => self.plain(Op::ExitSub),
                Some(_) => {
                    self.push(Item::Const(0));
                    self.plain(Op::Give);
                }
            },
            StmtKind::Call(routine, arguments) => {
                self.call(*routine, arguments);
                if self.program.routine(*routine).result.is_some() {
                    self.plain(Op::Drop);
                }
            }
            StmtKind::End => self.plain(Op::End),
            StmtKind::Run(name) => {
                let id = self.text(name.as_bytes());
                self.push(Item::Run(id));
            }
            StmtKind::OnError(Some(label)) => {
                self.features |= feature::LINES;
                let label = self.named(*label);
                self.push(Item::OnError(label));
            }
            StmtKind::OnError(None) => self.plain(Op::OnErrorStop),
            StmtKind::ResumeNext => self.plain(Op::ResumeNext),
            StmtKind::Resume => self.plain(Op::Resume),
            _ => self.machine(&stmt.kind),
        }
    }

    fn handler(&mut self, slot: u8, target: GosubTarget) {
        self.features |= feature::EVENTS;
        let handler = match target {
            GosubTarget::Label(label) => Handler::Label(self.named(label)),
            GosubTarget::Sub(sub) => Handler::Routine(sub),
        };
        let slot = usize::from(slot);
        if self.events.len() <= slot {
            self.events.resize(slot + 1, handler);
        }
        self.events[slot] = handler;
    }
}
