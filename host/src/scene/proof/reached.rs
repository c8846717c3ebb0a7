//! Lines that no run reached.

use std::collections::BTreeSet;

use lang::hir::{Block, Program, StmtKind};
use lang::plain::Plain;

/// Lines of statements with an effect that are not among `reached`. Those after a label to which an ON ERROR leads come
/// first: what nobody has tried there is found out at the machine.
pub fn never(program: &Program, reached: &BTreeSet<u32>) -> Vec<u32> {
    let mut lines = Lines::default();
    for routine in program.routines.iter().filter(|routine| routine.reachable) {
        lines.of_error = false;
        lines.handlers = handlers(&routine.body);
        lines.block(&routine.body);
    }
    let own = |list: &BTreeSet<u32>| list.difference(reached).copied().collect::<Vec<_>>();
    let mut never = own(&lines.error);
    never.extend(own(&lines.other).into_iter().filter(|line| !lines.error.contains(line)));
    never
}

/// Labels of the error handlers of a routine.
fn handlers(block: &Block) -> BTreeSet<lang::hir::LabelId> {
    let mut labels = BTreeSet::new();
    for stmt in block {
        if let StmtKind::OnError(Some(label)) = stmt.kind {
            labels.insert(label);
        }
        for inner in stmt.kind.blocks() {
            labels.extend(handlers(inner));
        }
    }
    labels
}

#[derive(Default)]
struct Lines {
    handlers: BTreeSet<lang::hir::LabelId>,
    of_error: bool,
    error: BTreeSet<u32>,
    other: BTreeSet<u32>,
}

impl Lines {
    /// Blocks nest at most as deep as the parser lets them.
    fn block(&mut self, block: &Block) {
        for stmt in block {
            if let StmtKind::Label(label) = stmt.kind {
                self.of_error = self.handlers.contains(&label);
            }
            if has_effect(&stmt.kind) {
                let lines = if self.of_error { &mut self.error } else { &mut self.other };
                lines.insert(stmt.line);
            }
            for inner in stmt.kind.blocks() {
                self.block(inner);
            }
        }
    }
}

/// Whether the statement writes a line of the trace whenever it runs.
fn has_effect(kind: &StmtKind) -> bool {
    matches!(
        kind,
        StmtKind::MoveAxe { .. }
            | StmtKind::MoveSpeed { .. }
            | StmtKind::Home { .. }
            | StmtKind::Probe { .. }
            | StmtKind::WaitIn { .. }
            | StmtKind::WaitChar { .. }
            | StmtKind::Print(_)
            | StmtKind::Plain(Plain::SetOut | Plain::WaitStart, _)
    )
}
