//! The walk over the syntax tree that binds names.

use std::collections::HashMap;
use std::rc::Rc;

use super::{Index, Mention, Sort, Symbol};
use crate::front::ast::{
    Block, CaseTest, Expr, ExprKind, GValue, InputState, Machine, Name, PrintPart, Script, Stmt,
    StmtKind, Variable,
};
use crate::front::span::Span;

/// What a name in the text is looked up among.
#[derive(Clone, Copy)]
enum Among {
    /// Variables, constants, tables, SUBs and the like.
    Names,
    /// Labels of the routine.
    Labels,
    /// SUBs, then labels of the routine.
    SubsThenLabels,
    /// SUBs, then labels of the main program.
    SubsThenMainLabels,
    /// Labels of the main program.
    MainLabels,
}

struct Walk {
    index: Index,
    /// 0 in the main program, n + 1 in routine n.
    scope: usize,
    /// Names of columns, by the keys of their TABLEs.
    columns: HashMap<Rc<str>, Vec<Rc<str>>>,
}

pub(super) fn index(script: &Script) -> Index {
    let scopes = script.routines.len() + 1;
    let index = Index {
        names: vec![HashMap::new(); scopes],
        labels: vec![HashMap::new(); scopes],
        lines: script.routines.iter().map(|r| (r.line, r.end_line.max(r.line))).collect(),
        ..Index::default()
    };
    let mut walk = Walk { index, scope: 0, columns: HashMap::new() };
    for routine in &script.routines {
        let sort = if routine.is_function { Sort::Function } else { Sort::Sub };
        walk.declare(&routine.name, sort, routine.span);
    }
    // All declarations first: the main program's names are known in every routine.
    walk.declare_block(&script.body);
    for (n, routine) in script.routines.iter().enumerate() {
        walk.scope = n + 1;
        for param in &routine.params {
            walk.declare(&param.name, Sort::Parameter, routine.span);
        }
        walk.declare_block(&routine.body);
    }
    walk.scope = 0;
    walk.block(&script.body);
    for (n, routine) in script.routines.iter().enumerate() {
        walk.scope = n + 1;
        walk.block(&routine.body);
    }
    walk.index.mentions.sort_by_key(|m| (m.span.start, m.span.end));
    walk.index.mentions.dedup_by_key(|m| m.span);
    walk.index
}

impl Walk {
    fn declare(&mut self, name: &Name, sort: Sort, span: Span) {
        if name.is_hidden() {
            return;
        }
        let index = &mut self.index;
        let local_to = self.scope.checked_sub(1);
        let names = match sort {
            Sort::Label => &mut index.labels[self.scope],
            _ => &mut index.names[self.scope],
        };
        // The first one stands; the checker reports the second.
        let symbol = *names.entry(name.key.clone()).or_insert(index.symbols.len());
        if symbol == index.symbols.len() {
            index.symbols.push(Symbol { name: name.clone(), sort, span, local_to });
        }
        index.mentions.push(Mention { span: name.span, symbol, writes: true });
    }

    fn mention(&mut self, name: &Name, among: Among, writes: bool) {
        if name.is_hidden() {
            return;
        }
        let index = &self.index;
        let own = self.scope;
        let named = |scope: usize| index.names[scope].get(&name.key);
        let label = |scope: usize| index.labels[scope].get(&name.key);
        let sub = || {
            let routine =
                |&&n: &&usize| matches!(index.symbols[n].sort, Sort::Sub | Sort::Function);
            named(0).filter(routine)
        };
        let found = match among {
            Among::Names => named(own).or_else(|| named(0)),
            Among::Labels => label(own),
            Among::MainLabels => label(0),
            Among::SubsThenLabels => sub().or_else(|| label(own)),
            Among::SubsThenMainLabels => sub().or_else(|| label(0)),
        };
        if let Some(&symbol) = found {
            self.index.mentions.push(Mention { span: name.span, symbol, writes });
        } else {
            self.index.free.insert(name.key.clone());
        }
    }

    fn declare_block(&mut self, block: &Block) {
        for stmt in block {
            self.declare_stmt(stmt);
            stmt.blocks().for_each(|inner| self.declare_block(inner));
        }
    }

    /// Declares what a statement declares, its own expressions first.
    fn declare_stmt(&mut self, stmt: &Stmt) {
        let mut each = |list: &[(Name, Expr)], sort| {
            for (name, value) in list {
                self.expr(value);
                self.declare(name, sort, stmt.span);
            }
        };
        match &stmt.kind {
            StmtKind::Label(name) => self.declare(name, Sort::Label, stmt.span),
            StmtKind::Const(list) | StmtKind::Analog(list) => each(list, Sort::Const),
            StmtKind::Port { output: false, ports } => each(ports, Sort::Input),
            StmtKind::Port { output: true, ports } => each(ports, Sort::Output),
            StmtKind::Dim(list) | StmtKind::Keep(list) => {
                for Variable { name, size, at, .. } in list {
                    size.iter().chain(at).for_each(|e| self.expr(e));
                    let sort = if size.is_some() { Sort::Array } else { Sort::Variable };
                    self.declare(name, sort, stmt.span);
                }
            }
            StmtKind::Table { name, width, columns, rows } => {
                self.columns.insert(name.key.clone(), columns.clone());
                width
                    .as_deref()
                    .into_iter()
                    .chain(rows.iter().flatten())
                    .for_each(|e| self.expr(e));
                self.declare(name, Sort::Table, stmt.span);
            }
            _ => {}
        }
    }

    fn block(&mut self, block: &Block) {
        for stmt in block {
            self.stmt(stmt);
            stmt.blocks().for_each(|inner| self.block(inner));
        }
    }

    /// The names of one statement; its blocks and its declarations apart.
    fn stmt(&mut self, stmt: &Stmt) {
        match &stmt.kind {
            StmtKind::Assign { target, index, value, .. } => {
                self.mention(target, Among::Names, true);
                index.iter().chain([value]).for_each(|e| self.expr(e));
            }
            StmtKind::Call { name, args } => {
                self.mention(name, Among::Names, false);
                args.iter().for_each(|e| self.expr(e));
            }
            StmtKind::If { arms, .. } => arms.iter().for_each(|arm| self.expr(&arm.cond)),
            StmtKind::Select { value, cases, .. } => {
                self.expr(value);
                for test in cases.iter().flat_map(|case| &case.tests) {
                    match test {
                        CaseTest::Value(e) | CaseTest::Is(_, e) => self.expr(e),
                        CaseTest::Range(low, high) => {
                            self.expr(low);
                            self.expr(high);
                        }
                    }
                }
            }
            StmtKind::For { var, from, to, step, next, .. } => {
                self.mention(var, Among::Names, true);
                [from, to].into_iter().chain(step).for_each(|e| self.expr(e));
                if let Some(next) = next {
                    self.mention(next, Among::Names, false);
                }
            }
            StmtKind::While { cond: e, .. } | StmtKind::Repeat { count: e, .. } => self.expr(e),
            StmtKind::Do { before, after, .. } => {
                before.iter().chain(after).for_each(|test| self.expr(&test.cond));
            }
            StmtKind::Goto(name) => self.mention(name, Among::Labels, false),
            StmtKind::Gosub(name) => self.mention(name, Among::SubsThenLabels, false),
            StmtKind::OnError(name) => {
                name.iter().for_each(|name| self.mention(name, Among::MainLabels, false));
            }
            StmtKind::OnIn { input, handler } => {
                self.expr(input);
                if let Some((_, name)) = handler {
                    self.mention(name, Among::SubsThenMainLabels, false);
                }
            }
            StmtKind::OnEvery(Some((time, name))) => {
                self.expr(time);
                self.mention(name, Among::SubsThenMainLabels, false);
            }
            StmtKind::Return(value) => value.iter().for_each(|e| self.expr(e)),
            StmtKind::Machine(machine) => self.machine(machine),
            StmtKind::Gcode(words) => {
                for word in words {
                    if let GValue::Expr(value) = &word.value {
                        self.expr(value);
                    }
                }
            }
            StmtKind::Label(_)
            | StmtKind::Const(_)
            | StmtKind::Port { .. }
            | StmtKind::Analog(_)
            | StmtKind::Dim(_)
            | StmtKind::Keep(_)
            | StmtKind::Table { .. }
            | StmtKind::Exit(_)
            | StmtKind::Continue(_)
            | StmtKind::End
            | StmtKind::Run(_)
            | StmtKind::ResumeNext
            | StmtKind::Resume
            | StmtKind::OnEvery(None) => {}
        }
    }

    fn machine(&mut self, machine: &Machine) {
        let mut all = |list: &[&Expr]| list.iter().for_each(|e| self.expr(e));
        match machine {
            Machine::Move { target, speed, accel, decel, .. } => {
                all(&[target]);
                [speed, accel, decel].into_iter().flatten().for_each(|e| self.expr(e));
            }
            Machine::MoveSpeed(_, e) | Machine::SetPos(_, e) | Machine::Motors(e, _) => all(&[e]),
            Machine::Probe { limit, speed, input, state, .. } => {
                all(&[limit, speed]);
                input.iter().chain(state).for_each(|e| self.expr(e));
            }
            Machine::ProbeMask { limit, speed, and, xor, .. } => all(&[limit, speed, and, xor]),
            Machine::Plain(_, list) => list.iter().for_each(|e| self.expr(e)),
            Machine::SetAout(list) => list.iter().for_each(|e| self.expr(e)),
            Machine::Sync { list, lead, .. } => {
                list.iter().chain(lead).for_each(|e| self.expr(e));
            }
            Machine::WaitIn { input, state, timeout, .. } => {
                all(&[input]);
                if let InputState::Level(level) = state {
                    self.expr(level);
                }
                timeout.iter().for_each(|e| self.expr(e));
            }
            Machine::WaitChar { code, timeout, .. } => {
                all(&[code]);
                timeout.iter().for_each(|e| self.expr(e));
            }
            Machine::Print(parts) => {
                for part in parts {
                    if let PrintPart::Value(value, _) = part {
                        self.expr(value);
                    }
                }
            }
            Machine::WaitMove(_)
            | Machine::StopAxe(_)
            | Machine::Home { .. }
            | Machine::Plane(_) => {}
        }
    }

    fn expr(&mut self, expr: &Expr) {
        match &expr.kind {
            ExprKind::Literal { .. } | ExprKind::Axis(_) => {}
            ExprKind::Name(name) => self.mention(name, Among::Names, false),
            ExprKind::Apply(name, args) => {
                self.mention(name, Among::Names, false);
                // What names a column is no other thing of that name.
                let columns = self.columns.get(&name.key);
                let column = match args.get(1).map(|e| &e.kind) {
                    Some(ExprKind::Name(own)) => columns.is_some_and(|all| all.contains(&own.key)),
                    _ => false,
                };
                for (n, e) in args.iter().enumerate() {
                    if n != 1 || !column {
                        self.expr(e);
                    }
                }
            }
            ExprKind::Builtin(_, args) => args.iter().for_each(|e| self.expr(e)),
            ExprKind::Unary(_, inner) => self.expr(inner),
            ExprKind::Binary(_, left, right) => {
                self.expr(left);
                self.expr(right);
            }
        }
    }
}
