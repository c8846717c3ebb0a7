//! Looking things up: what an id names, what belongs to one statement of the source, and what
//! stands in it.

use super::{Block, Program, Routine, RoutineId, Stmt, StmtKind, Table, TableId, Var, VarId};

impl Program {
    /// What the script or else the profile calls an input or output.
    pub fn port_name(&self, output: bool, n: i32) -> Option<&str> {
        let own = self.ports.iter().find(|port| port.output == output && port.n == n);
        own.map(|port| port.name.as_str()).or_else(|| {
            if output {
                self.profile.outputs.iter().find(|port| port.n == n)?.name.as_deref()
            } else {
                self.profile.inputs.iter().find(|port| port.n == n)?.name.as_deref()
            }
        })
    }

    /// The variable `id`.
    pub fn var(&self, id: VarId) -> &Var {
        &self.vars[id.0 as usize]
    }

    /// The table `id`.
    pub fn table(&self, id: TableId) -> &Table {
        &self.tables[id.0 as usize]
    }

    /// The routine `id`.
    pub fn routine(&self, id: RoutineId) -> &Routine {
        &self.routines[id.0 as usize]
    }
}

impl Table {
    /// The column of that name, in any case.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|own| own.eq_ignore_ascii_case(name))
    }
}

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

    /// The same to change what stands in them.
    pub fn blocks_mut(&mut self) -> Vec<&mut Block> {
        match self {
            StmtKind::If { arms, otherwise, .. } => {
                arms.iter_mut().map(|arm| &mut arm.body).chain([otherwise]).collect()
            }
            StmtKind::Select { cases, otherwise, .. } => {
                cases.iter_mut().map(|case| &mut case.body).chain([otherwise]).collect()
            }
            StmtKind::For { body, .. }
            | StmtKind::While { body, .. }
            | StmtKind::Do { body, .. }
            | StmtKind::Repeat { body, .. } => vec![body],
            _ => Vec::new(),
        }
    }
}
