//! What belongs to one statement of the source, and what stands in it.

use super::{Block, Stmt, StmtKind};

impl Stmt {
    /// Whether `next`, which stands behind it, is a part of the same statement of the source.
    pub fn continues(&self, next: &Stmt) -> bool {
        !self.span.is_empty() && self.span == next.span && !matches!(self.kind, StmtKind::Label(_))
    }
}

impl StmtKind {
    /// The blocks that stand in it.
    pub fn blocks(&self) -> Vec<&Block> {
        match self {
            StmtKind::If { arms, otherwise, .. } => {
                arms.iter().map(|arm| &arm.body).chain([otherwise]).collect()
            }
            StmtKind::Select { cases, otherwise, .. } => {
                cases.iter().map(|case| &case.body).chain([otherwise]).collect()
            }
            StmtKind::For { body, .. }
            | StmtKind::While { body, .. }
            | StmtKind::Do { body, .. }
            | StmtKind::Repeat { body, .. } => vec![body],
            _ => Vec::new(),
        }
    }
}
