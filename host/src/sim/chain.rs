//! Programs that begin one another by RUN.

use std::ops::Range;

use lang::called;
use lang::hir::{Block, Program, StmtKind};

/// Statements that a RUN counts as: the engines make the next program ready, which takes a desktop longer than a
/// statement does, and programs may run each other for ever.
pub(super) const RUN_STATEMENTS: u64 = 2_000;

/// The first is the one that Start begins.
#[derive(Clone, Debug)]
pub struct Chain<'p> {
    programs: Vec<&'p Program>,
    /// What they are called, nothing where no RUN finds it.
    names: Vec<String>,
}

impl<'p> Chain<'p> {
    /// A program of which nobody knows what stands beside it: RUN is its end ([`Outcome::onward`](super::Outcome)).
    pub fn alone(program: &'p Program) -> Chain<'p> {
        Chain::of([(String::new(), program)])
    }

    /// Programs with their names; the first of several with one name is the one that RUN finds.
    pub fn of(programs: impl IntoIterator<Item = (String, &'p Program)>) -> Chain<'p> {
        let (names, programs) = programs.into_iter().unzip();
        Chain { programs, names }
    }

    /// Every program.
    pub fn programs(&self) -> &[&'p Program] {
        &self.programs
    }

    /// Whether nobody knows what stands beside the program.
    pub fn is_alone(&self) -> bool {
        self.names.iter().all(String::is_empty)
    }

    /// Their names.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The number of the program of this name.
    pub fn find(&self, name: &str) -> Option<usize> {
        find(&self.names, name)
    }
}

/// The place in a list of the name that means the same.
pub fn find(names: &[String], name: &str) -> Option<usize> {
    names.iter().position(|own| !own.is_empty() && called::same(own, name))
}

/// A RUN of a program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Call {
    /// The name that it calls.
    pub name: String,
    /// Its line.
    pub line: u32,
    /// Its text.
    pub span: Range<usize>,
}

/// Each RUN of a program, in its order.
pub fn calls(program: &Program) -> Vec<Call> {
    let mut calls = Vec::new();
    program.routines.iter().for_each(|routine| collect(&routine.body, &mut calls));
    calls
}

/// Blocks nest at most as deep as the parser lets them.
fn collect(block: &Block, calls: &mut Vec<Call>) {
    for stmt in block {
        if let StmtKind::Run(name) = &stmt.kind {
            calls.push(Call { name: name.clone(), line: stmt.line, span: stmt.span.clone() });
        }
        stmt.kind.blocks().into_iter().for_each(|inner| collect(inner, calls));
    }
}
