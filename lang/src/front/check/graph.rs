//! The control flow of the whole script, as far as calls and G-code state need it: statements that
//! touch neither have no node.

mod traits;

pub(super) use self::traits::moves;
use self::traits::{arguments, is_true, may_fault};
use super::names::Entity;
use super::{Checker, MAIN, gcode};
use crate::effect::Plane;
use crate::front::ast::{
    self, BinaryOp, Block, CaseTest, Enclosing, Expr, ExprKind, GValue, Machine, Name, Stmt,
    StmtKind,
};
use crate::front::span::Span;
use crate::hir::{LabelId, LoopKind, RoutineId};

/// Index of a node.
pub(super) type NodeId = u32;
const NONE: NodeId = u32::MAX;

/// What a GOSUB or an event goes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Target {
    Label(LabelId),
    Routine(RoutineId),
}

/// What happens at a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Op {
    Nop,
    /// A G-code block, by its number.
    Gcode(u32),
    /// PLANE
    Plane(Plane, Span),
    /// Motion outside G-code.
    Moves,
    Call(RoutineId, Span),
    Gosub(Target, Span),
    /// FOR, REPEAT, SELECT: needs cells of its own.
    Uses(&'static str, Span),
    /// A GOTO; its only successor is the label.
    Goto,
    /// RETURN without a value.
    Return,
    /// The routine ends.
    Leave,
    /// The run or the handler ends.
    Stop,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub op: Op,
    next: [NodeId; 2],
}

impl Node {
    pub fn next(&self) -> impl Iterator<Item = NodeId> + use<> {
        self.next.into_iter().filter(|&n| n != NONE)
    }
}

/// The graph of a script.
#[derive(Debug, Default)]
pub(super) struct Graph {
    pub nodes: Vec<Node>,
    /// Where each routine begins.
    pub entries: Vec<NodeId>,
    /// Where each label stands.
    pub labels: Vec<NodeId>,
    /// Targets of ON IN and ON EVERY, and the statements.
    pub events: Vec<(Target, Span)>,
    /// Targets of ON ERROR.
    pub errors: Vec<(LabelId, Span)>,
}

/// Builds the graph; takes the G-code blocks apart on the way.
pub(super) fn build(checker: &mut Checker<'_>) -> Graph {
    let mut graph = Graph::default();
    for _ in 0..checker.labels.len() {
        graph.add(Op::Nop);
    }
    graph.labels = (0..checker.labels.len() as u32).collect();
    let resumes = checker.bodies().any(|(_, body)| has_resume(body));
    for (id, body) in checker.bodies() {
        checker.scope = id;
        let entry = graph.add(Op::Nop);
        graph.entries.push(entry);
        let mut builder =
            Builder { checker, graph: &mut graph, cur: Some(entry), loops: Vec::new(), resumes };
        builder.block(body);
        builder.emit(Op::Leave);
    }
    checker.scope = MAIN;
    graph
}

fn has_resume(block: &Block) -> bool {
    block.iter().any(|stmt| stmt.kind == StmtKind::ResumeNext || stmt.blocks().any(has_resume))
}

impl Graph {
    fn add(&mut self, op: Op) -> NodeId {
        self.nodes.push(Node { op, next: [NONE; 2] });
        self.nodes.len() as NodeId - 1
    }

    fn link(&mut self, from: NodeId, to: NodeId) {
        let next = &mut self.nodes[from as usize].next;
        if let Some(free) = next.iter_mut().find(|n| **n == NONE) {
            *free = to;
        }
    }

    /// Where a target begins.
    pub fn entry(&self, target: Target) -> NodeId {
        match target {
            Target::Label(label) => self.labels[label.0 as usize],
            Target::Routine(id) => self.entries[id.0 as usize],
        }
    }
}

struct Loop {
    kind: LoopKind,
    again: NodeId,
    exit: NodeId,
}

struct Builder<'c, 'a> {
    checker: &'c mut Checker<'a>,
    graph: &'c mut Graph,
    /// The node that control comes from; None where nothing does.
    cur: Option<NodeId>,
    loops: Vec<Loop>,
    /// RESUME NEXT may go on behind a block whose head failed.
    resumes: bool,
}

impl<'a> Builder<'_, 'a> {
    fn emit(&mut self, op: Op) -> NodeId {
        let node = self.graph.add(op);
        self.flow_to(node);
        self.cur = Some(node);
        node
    }

    /// Control goes to `node`; nothing comes behind until [`Builder::at`].
    fn flow_to(&mut self, node: NodeId) {
        if let Some(cur) = self.cur.take() {
            self.graph.link(cur, node);
        }
    }

    fn at(&mut self, node: NodeId) {
        self.cur = Some(node);
    }

    fn end(&mut self, op: Op) {
        self.emit(op);
        self.cur = None;
    }

    fn block(&mut self, block: &'a Block) {
        for stmt in block {
            self.stmt(stmt);
        }
    }

    fn stmt(&mut self, stmt: &'a Stmt) {
        match &stmt.kind {
            StmtKind::Label(name) => {
                if let Some(id) = self.checker.labels.id(self.checker.scope, &name.key) {
                    let node = self.graph.labels[id.0 as usize];
                    self.flow_to(node);
                    self.at(node);
                }
            }
            StmtKind::Assign { index, value, .. } => {
                self.calls(index);
                self.expr(value);
            }
            StmtKind::Call { name, args } => {
                self.calls(args);
                self.call(name);
            }
            StmtKind::If { arms, otherwise, .. } => self.if_stmt(arms, otherwise.as_ref()),
            StmtKind::Select { value, cases, otherwise } => {
                self.emit(Op::Uses("SELECT", stmt.span));
                self.expr(value);
                self.select(value, cases, otherwise.as_ref());
            }
            StmtKind::For { from, to, step, body, .. } => {
                self.emit(Op::Uses("FOR", stmt.span));
                self.expr(from);
                self.expr(to);
                step.iter().for_each(|step| self.expr(step));
                let step = step.as_ref().map_or(Some(1), |step| self.constant(step));
                let sure = match (self.constant(from), self.constant(to), step) {
                    (Some(from), Some(to), Some(step)) => {
                        (step > 0 && from <= to) || (step < 0 && from >= to)
                    }
                    _ => false,
                };
                self.counted(LoopKind::For, body, sure);
            }
            StmtKind::Repeat { count, body, .. } => {
                self.emit(Op::Uses("REPEAT", stmt.span));
                self.expr(count);
                let sure = self.constant(count).is_some_and(|count| count > 0);
                self.counted(LoopKind::Repeat, body, sure);
            }
            StmtKind::While { cond, body, .. } => {
                self.do_loop(LoopKind::While, Some(cond).filter(|c| !is_true(c)), body, None);
            }
            StmtKind::Do { before, body, after, .. } => {
                let cond = |test: &'a Option<Box<ast::Test>>| test.as_ref().map(|t| &t.cond);
                self.do_loop(LoopKind::Do, cond(before), body, cond(after));
            }
            StmtKind::Exit(Enclosing::Sub | Enclosing::Function) => self.end(Op::Leave),
            StmtKind::Exit(what) => self.leave_loop(*what, |open| open.exit),
            StmtKind::Continue(what) => self.leave_loop(*what, |open| open.again),
            StmtKind::Goto(name) => {
                self.emit(Op::Goto);
                if let Some(id) = self.checker.labels.id(self.checker.scope, &name.key) {
                    let node = self.graph.labels[id.0 as usize];
                    self.flow_to(node);
                }
                self.cur = None;
            }
            StmtKind::Gosub(name) => {
                if let Some(target) = self.target(name, self.checker.scope) {
                    self.emit(Op::Gosub(target, name.span));
                }
            }
            StmtKind::Return(None) => self.end(Op::Return),
            StmtKind::Return(Some(value)) => {
                self.expr(value);
                self.end(Op::Leave);
            }
            StmtKind::Dim(list) if list.iter().any(|variable| variable.name.is_hidden()) => {
                self.emit(Op::Uses("a WAIT UNTIL with a time", stmt.span));
            }
            StmtKind::End | StmtKind::ResumeNext | StmtKind::Resume => self.end(Op::Stop),
            StmtKind::OnError(Some(name)) => {
                if let Some(id) = self.checker.labels.id(MAIN, &name.key) {
                    self.graph.errors.push((id, name.span));
                }
            }
            StmtKind::OnIn { input, handler } => {
                self.expr(input);
                if let Some((_, name)) = handler {
                    self.event(name);
                }
            }
            StmtKind::OnEvery(Some((time, name))) => {
                self.expr(time);
                self.event(name);
            }
            StmtKind::Machine(machine) => self.machine(machine, stmt.span),
            StmtKind::Gcode(words) => {
                let list: Vec<&Expr> = words
                    .iter()
                    .filter_map(|word| match &word.value {
                        GValue::Expr(e) => Some(e),
                        GValue::Number(_) => None,
                    })
                    .collect();
                self.several(&list, "a block with FUNCTIONs", stmt.span);
                let (block, ends) = gcode::add_block(self.checker, words, stmt);
                self.emit(Op::Gcode(block));
                if ends {
                    self.end(Op::Stop);
                }
            }
            _ => {}
        }
    }

    fn event(&mut self, name: &'a Name) {
        if let Some(target) = self.target(name, MAIN) {
            self.graph.events.push((target, name.span));
        }
    }

    fn target(&self, name: &Name, routine: RoutineId) -> Option<Target> {
        match self.checker.names.look(MAIN, &name.key) {
            Some(Entity::Routine(id)) => Some(Target::Routine(id)),
            _ => self.checker.labels.id(routine, &name.key).map(Target::Label),
        }
    }

    fn leave_loop(&mut self, what: Enclosing, to: fn(&Loop) -> NodeId) {
        let kind = match what {
            Enclosing::For => LoopKind::For,
            Enclosing::While => LoopKind::While,
            Enclosing::Do => LoopKind::Do,
            _ => LoopKind::Repeat,
        };
        if let Some(open) = self.loops.iter().rev().find(|open| open.kind == kind) {
            let node = to(open);
            self.flow_to(node);
        }
        self.cur = None;
    }

    /// An extra way from here to `node`, where a fault in `e` may be followed by RESUME NEXT.
    fn may_skip(&mut self, e: &Expr, node: NodeId) {
        if self.resumes && may_fault(e) {
            let here = self.emit(Op::Nop);
            self.graph.link(here, node);
        }
    }

    fn if_stmt(&mut self, arms: &'a [ast::Arm], otherwise: Option<&'a Block>) {
        let join = self.graph.add(Op::Nop);
        for arm in arms {
            self.may_skip(&arm.cond, join);
            self.expr(&arm.cond);
            let test = self.emit(Op::Nop);
            self.block(&arm.body);
            self.flow_to(join);
            self.at(test);
        }
        if let Some(block) = otherwise {
            self.block(block);
        }
        self.flow_to(join);
        self.at(join);
    }

    fn select(&mut self, value: &Expr, cases: &'a [ast::Case], otherwise: Option<&'a Block>) {
        let join = self.graph.add(Op::Nop);
        self.may_skip(value, join);
        for case in cases {
            for test in &case.tests {
                match test {
                    CaseTest::Value(e) | CaseTest::Is(_, e) => {
                        self.may_skip(e, join);
                        self.expr(e);
                    }
                    CaseTest::Range(low, high) => {
                        self.may_skip(low, join);
                        self.may_skip(high, join);
                        self.expr(low);
                        self.expr(high);
                    }
                }
            }
            let test = self.emit(Op::Nop);
            self.block(&case.body);
            self.flow_to(join);
            self.at(test);
        }
        if let Some(block) = otherwise {
            self.block(block);
        }
        self.flow_to(join);
        self.at(join);
    }

    /// The value of an expression that is known beforehand.
    fn constant(&mut self, e: &'a Expr) -> Option<i32> {
        self.checker.quiet_constant(e)
    }

    /// FOR and REPEAT; `sure` where the first pass is certain.
    fn counted(&mut self, kind: LoopKind, body: &'a Block, sure: bool) {
        let head = self.emit(Op::Nop);
        let again = if sure { self.graph.add(Op::Nop) } else { head };
        let exit = self.graph.add(Op::Nop);
        self.graph.link(again, exit);
        self.loops.push(Loop { kind, again, exit });
        self.block(body);
        self.flow_to(again);
        self.loops.pop();
        if sure {
            self.graph.link(again, head);
        }
        self.at(exit);
    }

    /// WHILE and DO; a test that is None never ends the loop.
    fn do_loop(
        &mut self,
        kind: LoopKind,
        before: Option<&'a Expr>,
        body: &'a Block,
        after: Option<&'a Expr>,
    ) {
        let head = self.emit(Op::Nop);
        let exit = self.graph.add(Op::Nop);
        let again = self.graph.add(Op::Nop);
        if let Some(cond) = before {
            self.expr(cond);
            let test = self.emit(Op::Nop);
            self.graph.link(test, exit);
        }
        self.loops.push(Loop { kind, again, exit });
        self.block(body);
        self.loops.pop();
        self.flow_to(again);
        self.at(again);
        if let Some(cond) = after {
            self.expr(cond);
            let test = self.emit(Op::Nop);
            self.graph.link(test, exit);
        }
        self.flow_to(head);
        self.at(exit);
    }

    fn machine(&mut self, machine: &'a Machine, span: Span) {
        let list = arguments(machine);
        if matches!(machine, Machine::Print(_)) {
            self.several(&list, "a PRINT with FUNCTIONs", span);
        } else {
            list.into_iter().for_each(|e| self.expr(e));
        }
        if let Machine::Plane(plane) = machine {
            self.emit(Op::Plane(*plane, span));
        } else if moves(machine) {
            self.emit(Op::Moves);
        }
    }

    /// Values of a statement that is several effects: where FUNCTIONs are called, all but one may
    /// wait in cells ([`super::order`]).
    fn several(&mut self, list: &[&'a Expr], what: &'static str, span: Span) {
        let nodes = self.graph.nodes.len();
        list.iter().for_each(|e| self.expr(e));
        let calls = self.graph.nodes[nodes..].iter().any(|node| matches!(node.op, Op::Call(..)));
        let values = list.iter().filter(|e| !matches!(e.kind, ExprKind::Literal { .. }));
        if calls && values.count() > 1 {
            self.emit(Op::Uses(what, span));
        }
    }

    fn calls(&mut self, list: &'a [Expr]) {
        for e in list {
            self.expr(e);
        }
    }

    fn call(&mut self, name: &Name) {
        let called = match self.checker.names.look(self.checker.scope, &name.key) {
            Some(Entity::Routine(id)) => Some(id),
            Some(Entity::Var(var)) => self.checker.reader(var),
            _ => self.checker.edge(name),
        };
        if let Some(id) = called {
            self.emit(Op::Call(id, name.span));
        }
    }

    /// Nodes for the FUNCTIONs that an expression calls, in the order of evaluation.
    fn expr(&mut self, e: &'a Expr) {
        match &e.kind {
            ExprKind::Literal { .. } | ExprKind::Axis(_) => {}
            ExprKind::Name(name) => self.call(name),
            ExprKind::Apply(name, args) => {
                self.calls(args);
                self.call(name);
            }
            ExprKind::Builtin(_, args) => self.calls(args),
            ExprKind::Unary(_, inner) => self.expr(inner),
            ExprKind::Binary(op @ (BinaryOp::AndAlso | BinaryOp::OrElse), left, right) => {
                debug_assert!(!op.is_comparison());
                self.expr(left);
                let test = self.emit(Op::Nop);
                self.expr(right);
                let join = self.emit(Op::Nop);
                if self.graph.nodes[test as usize].next[0] != join {
                    self.graph.link(test, join);
                }
            }
            ExprKind::Binary(_, left, right) => {
                self.expr(left);
                self.expr(right);
            }
        }
    }
}
