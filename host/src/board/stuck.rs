//! Detects a run on the board that cannot go on by itself.

use lang::hir::{Block, Program, Stmt, StmtKind};
use lang::plain::Plain;

/// A board is asked what it waits for only after this long without a sign of life, us.
const QUIET_US: u64 = 500_000;

/// Notices when nothing moves and nothing is reported.
#[derive(Debug, Default)]
pub struct Watch {
    /// When something happened last, us.
    since_us: u64,
    /// When it was quiet for long last, us.
    told_us: u64,
    pulses: [u64; 3],
}

impl Watch {
    /// An event came.
    pub fn something_happened(&mut self, us: u64) {
        self.since_us = us;
    }

    /// When something happened last, us.
    pub fn since_us(&self) -> u64 {
        self.since_us
    }

    /// Whether neither event nor step came for a while; answers yes once in that while.
    pub fn is_quiet(&mut self, us: u64, pulses: [u64; 3]) -> bool {
        if pulses != self.pulses {
            self.pulses = pulses;
            self.since_us = us;
        }
        let quiet = us.saturating_sub(self.since_us.max(self.told_us)) >= QUIET_US;
        if quiet {
            self.told_us = us;
        }
        quiet
    }
}

/// Whether the program has an `ON EVERY`: time alone makes something happen then.
pub fn has_ticks(program: &Program) -> bool {
    any(program, &|stmt| matches!(stmt.kind, StmtKind::OnEvery { .. }))
}

/// Whether the statement of that line waits without a timeout for something outside.
pub fn waits_for_ever(program: &Program, line: u32) -> bool {
    let waits = |stmt: &Stmt| {
        stmt.line == line
            && matches!(
                stmt.kind,
                StmtKind::WaitIn { timeout: None, .. }
                    | StmtKind::WaitChar { timeout: None, .. }
                    | StmtKind::Plain(Plain::WaitStart, _)
            )
    };
    any(program, &waits) && !has_ticks(program)
}

fn any(program: &Program, test: &dyn Fn(&Stmt) -> bool) -> bool {
    program.routines.iter().any(|routine| in_block(&routine.body, test))
}

/// Blocks nest at most as deep as the parser lets them (`MAX_BLOCK_DEPTH`).
fn in_block(block: &Block, test: &dyn Fn(&Stmt) -> bool) -> bool {
    let inner = |stmt: &Stmt| match &stmt.kind {
        StmtKind::If { arms, otherwise, .. } => {
            arms.iter().any(|arm| in_block(&arm.body, test)) || in_block(otherwise, test)
        }
        StmtKind::Select { cases, otherwise, .. } => {
            cases.iter().any(|case| in_block(&case.body, test)) || in_block(otherwise, test)
        }
        StmtKind::For { body, .. }
        | StmtKind::While { body, .. }
        | StmtKind::Do { body, .. }
        | StmtKind::Repeat { body, .. } => in_block(body, test),
        _ => false,
    };
    block.iter().any(|stmt| test(stmt) || inner(stmt))
}
