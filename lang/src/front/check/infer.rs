//! Kinds of variables, parameters and results that were declared without AS.
//!
//! The text is walked in its order: the first assignment, FOR, call or RETURN whose kind is known
//! decides; a name whose kind is still open takes its partner's in sums and comparisons. Open names
//! that meet are tied together. The walk is repeated until nothing changes, as a use may stand
//! before what decides; what is open then is a Number.

use std::collections::HashSet;

use super::names::Entity;
use super::{Checker, MAIN, kinds};
use crate::front::ast::{
    BinaryOp, Block, CaseTest, Expr, ExprKind, GValue, InputState, Machine, PrintPart, Stmt,
    StmtKind, UnaryOp,
};
use crate::front::words::Func;
use crate::hir::{RoutineId, VarId};
use crate::kind::Kind;

/// Walks at most; real scripts need two. A chain of names in reverse text order could ask for one
/// walk for each link.
const MAX_WALKS: usize = 12;

/// What is known of an expression's kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ty {
    Known(Kind),
    /// As this slot, which is open.
    Open(usize),
    /// Not to be told yet.
    Unknown,
}

/// A variable or the result of a FUNCTION.
#[derive(Clone, Copy, Debug)]
enum Slot {
    Known(Kind),
    Open,
    /// Tied to another slot.
    As(usize),
}

struct Inference<'c, 'a> {
    checker: &'c Checker<'a>,
    /// Variables, then the results of routines.
    slots: Vec<Slot>,
    scope: RoutineId,
    changed: bool,
    /// Variables that a SUB or FUNCTION writes.
    written: HashSet<VarId>,
}

impl<'a> Checker<'a> {
    /// Settles every open kind.
    pub(super) fn infer_all(&mut self) {
        let mut slots: Vec<Slot> = self.vars.iter().map(|v| Slot::Known(v.kind)).collect();
        for var in &self.open {
            slots[var.0 as usize] = Slot::Open;
        }
        let results = slots.len();
        for (i, info) in self.infos.iter().enumerate() {
            let open = i > 0 && self.script.routines[i - 1].result.is_none();
            slots.push(if open {
                Slot::Open
            } else {
                Slot::Known(info.result.unwrap_or(Kind::Number))
            });
        }
        let mut inference = Inference {
            checker: self,
            slots,
            scope: MAIN,
            changed: false,
            written: HashSet::new(),
        };
        for _ in 0..MAX_WALKS {
            inference.changed = false;
            inference.walk();
            if !inference.changed {
                break;
            }
        }
        let kinds: Vec<Kind> = (0..inference.slots.len()).map(|i| inference.settled(i)).collect();
        self.written_by_routines = inference.written;
        for (var, &kind) in self.vars.iter_mut().zip(&kinds) {
            var.kind = kind;
        }
        for (info, &kind) in self.infos.iter_mut().zip(&kinds[results..]) {
            if info.result.is_some() {
                info.result = Some(kind);
            }
        }
    }
}

impl<'a> Inference<'_, 'a> {
    /// One walk in text order: routines stand between the statements of the main program.
    fn walk(&mut self) {
        let script = self.checker.script;
        let mut routines = (1..).map(RoutineId).zip(&script.routines).peekable();
        for stmt in &script.body {
            while let Some((id, routine)) =
                routines.next_if(|(_, r)| r.span.start < stmt.span.start)
            {
                self.scope = id;
                self.block(&routine.body);
            }
            self.scope = MAIN;
            self.stmt(stmt);
        }
        for (id, routine) in routines {
            self.scope = id;
            self.block(&routine.body);
        }
    }

    /// The slot that speaks for this one; halves the path to it, so that chains stay short.
    fn root(&mut self, mut slot: usize) -> usize {
        while let Slot::As(next) = self.slots[slot] {
            if let Slot::As(beyond) = self.slots[next] {
                self.slots[slot] = Slot::As(beyond);
            }
            slot = next;
        }
        slot
    }

    fn settled(&mut self, slot: usize) -> Kind {
        let root = self.root(slot);
        match self.slots[root] {
            Slot::Known(kind) => kind,
            _ => Kind::Number,
        }
    }

    fn slot(&mut self, slot: usize) -> Ty {
        let root = self.root(slot);
        match self.slots[root] {
            Slot::Known(kind) => Ty::Known(kind),
            _ => Ty::Open(root),
        }
    }

    fn result_slot(&self, id: RoutineId) -> usize {
        self.checker.vars.len() + id.0 as usize
    }

    /// Gives an open `target` the kind of `source`, or ties two open ones.
    fn bind(&mut self, target: Ty, source: Ty) {
        // Either may have been tied to something since it was looked at.
        let Ty::Open(slot) = target else { return };
        let Ty::Open(slot) = self.slot(slot) else { return };
        let source = match source {
            Ty::Open(other) => self.slot(other),
            other => other,
        };
        match source {
            Ty::Known(kind) => self.slots[slot] = Slot::Known(kind),
            Ty::Open(other) if other != slot => self.slots[slot] = Slot::As(other),
            _ => return,
        }
        self.changed = true;
    }

    /// Two sides of a sum or comparison: an open one takes the other's kind.
    fn partners(&mut self, left: Ty, right: Ty) -> Ty {
        match (left, right) {
            (Ty::Open(_), _) => self.bind(left, right),
            (_, Ty::Open(_)) => self.bind(right, left),
            _ => {}
        }
        match (left, right) {
            (Ty::Known(kind), _) | (_, Ty::Known(kind)) => Ty::Known(kind),
            (Ty::Open(slot), _) | (_, Ty::Open(slot)) => self.slot(slot),
            _ => Ty::Unknown,
        }
    }

    /// A variable that the statement at hand writes.
    fn written(&mut self, key: &str) -> Option<VarId> {
        let var = self.var(self.scope, key)?;
        if self.scope != MAIN {
            self.written.insert(var);
        }
        Some(var)
    }

    fn var(&self, scope: RoutineId, key: &str) -> Option<VarId> {
        match self.checker.names.look(scope, key) {
            Some(Entity::Var(var)) => Some(var),
            _ => None,
        }
    }

    fn block(&mut self, block: &'a Block) {
        for stmt in block {
            self.stmt(stmt);
        }
    }

    fn stmt(&mut self, stmt: &'a Stmt) {
        match &stmt.kind {
            StmtKind::Assign { target, index, bit, value } => {
                self.exprs(index);
                let ty = self.expr(value);
                let ty = if bit.is_some() { Ty::Known(Kind::Number) } else { ty };
                if let Some(var) = self.written(&target.key) {
                    let slot = self.slot(var.0 as usize);
                    self.bind(slot, ty);
                }
            }
            StmtKind::Call { name, args } => {
                self.call(&name.key, args);
            }
            StmtKind::For { var, from, to, step, .. } => {
                let tys = [self.expr(from), self.expr(to)];
                let step = step.as_ref().map_or(Ty::Unknown, |step| self.expr(step));
                if let Some(var) = self.written(&var.key) {
                    for ty in tys.into_iter().chain([step]) {
                        let slot = self.slot(var.0 as usize);
                        self.bind(slot, ty);
                        self.bind(ty, slot);
                    }
                }
            }
            StmtKind::Select { value, cases, .. } => {
                let value = self.expr(value);
                for test in cases.iter().flat_map(|case| &case.tests) {
                    match test {
                        CaseTest::Value(e) | CaseTest::Is(_, e) => {
                            let ty = self.expr(e);
                            self.partners(value, ty);
                        }
                        CaseTest::Range(low, high) => {
                            for e in [low, high] {
                                let ty = self.expr(e);
                                self.partners(value, ty);
                            }
                        }
                    }
                }
            }
            StmtKind::Return(Some(value)) => {
                let ty = self.expr(value);
                let slot = self.slot(self.result_slot(self.scope));
                self.bind(slot, ty);
            }
            StmtKind::If { arms, .. } => {
                for arm in arms {
                    self.expr(&arm.cond);
                    self.block(&arm.body);
                }
            }
            StmtKind::While { cond, .. } => {
                self.expr(cond);
            }
            StmtKind::Do { before, body, after, .. } => {
                if let Some(test) = before {
                    self.expr(&test.cond);
                }
                self.block(body);
                if let Some(test) = after {
                    self.expr(&test.cond);
                }
            }
            StmtKind::Repeat { count, .. } => {
                self.expr(count);
            }
            StmtKind::OnIn { input, .. } => {
                self.expr(input);
            }
            StmtKind::OnEvery(Some((time, _))) => {
                self.expr(time);
            }
            StmtKind::Machine(machine) => self.machine(machine),
            StmtKind::Gcode(words) => {
                for word in words {
                    if let GValue::Expr(e) = &word.value {
                        self.expr(e);
                    }
                }
            }
            _ => {}
        }
        match &stmt.kind {
            // Walked above, between their conditions.
            StmtKind::Do { .. } => {}
            StmtKind::If { otherwise, .. } => otherwise.iter().for_each(|b| self.block(b)),
            _ => {
                for inner in stmt.blocks() {
                    self.block(inner);
                }
            }
        }
    }

    fn machine(&mut self, machine: &'a Machine) {
        match machine {
            Machine::Move { target, speed, accel, decel, .. } => {
                self.expr(target);
                for e in [speed, accel, decel].into_iter().flatten() {
                    self.expr(e);
                }
            }
            Machine::Probe { limit, speed, input, state, .. } => {
                self.expr(limit);
                self.expr(speed);
                for e in [input, state].into_iter().flatten() {
                    self.expr(e);
                }
            }
            Machine::ProbeMask { limit, speed, and, xor, .. } => {
                for e in [limit, speed, and, xor] {
                    self.expr(e);
                }
            }
            Machine::Sync { list, lead, .. } => list.iter().chain(lead).for_each(|e| {
                self.expr(e);
            }),
            Machine::Plain(_, list) | Machine::SetAout(list) => list.iter().for_each(|e| {
                self.expr(e);
            }),
            Machine::MoveSpeed(_, e) | Machine::SetPos(_, e) | Machine::Motors(e, _) => {
                self.expr(e);
            }
            Machine::WaitIn { input, state, timeout, .. } => {
                self.expr(input);
                if let InputState::Level(e) = state {
                    self.expr(e);
                }
                if let Some(e) = timeout {
                    self.expr(e);
                }
            }
            Machine::WaitChar { code, timeout, .. } => {
                self.expr(code);
                if let Some(e) = timeout {
                    self.expr(e);
                }
            }
            Machine::Print(parts) => {
                for part in parts {
                    if let PrintPart::Value(e, _) = part {
                        self.expr(e);
                    }
                }
            }
            _ => {}
        }
    }

    fn exprs(&mut self, list: &'a [Expr]) {
        for e in list {
            self.expr(e);
        }
    }

    /// A call of a SUB or FUNCTION: the first one decides the kinds of the parameters.
    fn call(&mut self, key: &str, args: &'a [Expr]) -> Ty {
        let Some(Entity::Routine(id)) = self.checker.names.look(self.scope, key) else {
            self.exprs(args);
            return Ty::Unknown;
        };
        for (i, arg) in args.iter().enumerate() {
            let ty = self.expr(arg);
            if let Some(param) = self.checker.infos[id.0 as usize].params.get(i) {
                let slot = self.slot(param.0 as usize);
                self.bind(slot, ty);
            }
        }
        self.slot(self.result_slot(id))
    }

    fn expr(&mut self, expr: &'a Expr) -> Ty {
        match &expr.kind {
            ExprKind::Literal { kind, .. } => Ty::Known(*kind),
            ExprKind::Axis(_) => Ty::Unknown,
            ExprKind::Name(name) => match self.checker.names.look(self.scope, &name.key) {
                Some(Entity::Const(kind, _)) => Ty::Known(kind),
                Some(Entity::Port(..) | Entity::Analog(..)) => Ty::Known(Kind::Number),
                Some(Entity::Var(var)) => self.slot(var.0 as usize),
                Some(Entity::Routine(id)) => self.slot(self.result_slot(id)),
                Some(Entity::Table(_)) | None => Ty::Unknown,
            },
            ExprKind::Apply(name, args) => match self.checker.names.look(self.scope, &name.key) {
                Some(Entity::Routine(_)) => self.call(&name.key, args),
                entity => {
                    if let (None, Some(func)) = (entity, Func::soft(&name.key)) {
                        return self.builtin(func, args);
                    }
                    self.exprs(args);
                    if let Some(id) = self.checker.edge(name) {
                        return self.slot(self.result_slot(id));
                    }
                    match entity {
                        Some(Entity::Var(var)) => self.slot(var.0 as usize),
                        Some(Entity::Table(id)) => {
                            let table = &self.checker.tables[id.0 as usize];
                            let index = args.get(1);
                            let named = index.and_then(|e| self.checker.named_column(id, e));
                            let column = match index.map(|e| &e.kind) {
                                Some(ExprKind::Literal { value, .. }) => *value as usize,
                                _ => named.unwrap_or(0),
                            };
                            table.kinds.get(column).map_or(Ty::Unknown, |&k| Ty::Known(k))
                        }
                        _ => Ty::Unknown,
                    }
                }
            },
            ExprKind::Builtin(func, args) => self.builtin(*func, args),
            ExprKind::Unary(UnaryOp::Neg, inner) => match self.expr(inner) {
                Ty::Known(Kind::Truth) => Ty::Known(Kind::Number),
                ty => ty,
            },
            ExprKind::Unary(UnaryOp::Not, inner) => self.expr(inner),
            ExprKind::Unary(UnaryOp::Bit(_), inner) => {
                let ty = self.expr(inner);
                self.bind(ty, Ty::Known(Kind::Number));
                Ty::Known(Kind::Truth)
            }
            ExprKind::Binary(op, left, right) => {
                let left = self.expr(left);
                let right = self.expr(right);
                self.binary(*op, left, right)
            }
        }
    }

    fn builtin(&mut self, func: Func, args: &'a [Expr]) -> Ty {
        let tys: Vec<Ty> = args.iter().map(|arg| self.expr(arg)).collect();
        match func {
            Func::Abs => tys.first().copied().unwrap_or(Ty::Unknown),
            Func::Scale => match tys[..] {
                [v, a, b, c, d] => {
                    let from = self.partners(a, b);
                    self.partners(v, from);
                    self.partners(c, d)
                }
                _ => Ty::Unknown,
            },
            Func::Sin | Func::Cos => {
                tys.iter().for_each(|&ty| self.bind(ty, Ty::Known(Kind::Angle)));
                Ty::Known(Kind::Number)
            }
            Func::Atan2 => {
                if let [y, x] = tys[..] {
                    self.partners(y, x);
                }
                Ty::Known(Kind::Angle)
            }
            Func::Min | Func::Max => match tys[..] {
                [a, b] => self.partners(a, b),
                _ => Ty::Unknown,
            },
            _ => Ty::Known(kinds::func_kind(func)),
        }
    }

    fn binary(&mut self, op: BinaryOp, left: Ty, right: Ty) -> Ty {
        match op {
            BinaryOp::AndAlso | BinaryOp::OrElse => Ty::Known(Kind::Truth),
            _ if op.is_comparison() => {
                self.partners(left, right);
                Ty::Known(Kind::Truth)
            }
            BinaryOp::Shl | BinaryOp::Shr => Ty::Known(Kind::Number),
            BinaryOp::Mul | BinaryOp::Div | BinaryOp::Mod => match (left, right) {
                (Ty::Known(l), Ty::Known(r)) => {
                    kinds::binary(op, l, r).map_or(Ty::Unknown, Ty::Known)
                }
                // A quantity times something open: that can only be a Number.
                (Ty::Known(kind), _) if op == BinaryOp::Mul && !kinds::is_plain(kind) => left,
                (_, Ty::Known(kind)) if kinds::is_plain(kind) => left,
                (_, Ty::Known(_)) if op == BinaryOp::Mul => right,
                (Ty::Known(kind), _) if op == BinaryOp::Mul && kinds::is_plain(kind) => right,
                _ => Ty::Unknown,
            },
            _ => match self.partners(as_operand(op, left), as_operand(op, right)) {
                Ty::Known(l) => match (left, right) {
                    (Ty::Known(a), Ty::Known(b)) => {
                        kinds::binary(op, a, b).map_or(Ty::Unknown, Ty::Known)
                    }
                    _ => kinds::binary(op, l, l).map_or(Ty::Unknown, Ty::Known),
                },
                ty => ty,
            },
        }
    }
}

/// A Truth in a sum is a Number.
fn as_operand(op: BinaryOp, ty: Ty) -> Ty {
    match ty {
        Ty::Known(Kind::Truth) if matches!(op, BinaryOp::Add | BinaryOp::Sub) => {
            Ty::Known(Kind::Number)
        }
        ty => ty,
    }
}
