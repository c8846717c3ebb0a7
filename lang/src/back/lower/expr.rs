//! Expressions, conditions, assignments and calls.

use super::Lower;
use crate::back::ir::{Cond, Item, Label};
use crate::hir::{BinOp, Expr, ExprKind, Place, ReadKind, RoutineId, TableId, UnOp, VarId};
use crate::isa::{Look, Op};
use crate::kind::Kind;

const fn binary(op: BinOp) -> Op {
    match op {
        BinOp::Add => Op::Add,
        BinOp::Sub => Op::Sub,
        BinOp::Mul => Op::Mul,
        BinOp::Div => Op::Div,
        BinOp::Mod => Op::Mod,
        BinOp::And => Op::And,
        BinOp::Or => Op::Or,
        BinOp::Xor => Op::Xor,
        BinOp::Shl => Op::Shl,
        BinOp::Shr => Op::Shr,
        BinOp::Eq => Op::Eq,
        BinOp::Ne => Op::Ne,
        BinOp::Lt => Op::Lt,
        BinOp::Le => Op::Le,
        BinOp::Gt => Op::Gt,
        BinOp::Ge => Op::Ge,
        BinOp::Min => Op::Min,
        BinOp::Max => Op::Max,
        BinOp::Atan2 => Op::Atan2,
    }
}

/// The branch that a comparison becomes.
pub(super) const fn cond(op: BinOp) -> Option<Cond> {
    Cond::of(binary(op))
}

impl Lower<'_> {
    pub(super) fn expr(&mut self, expr: &Expr) {
        match &expr.node {
            ExprKind::Const(value) => self.push(Item::Const(*value)),
            ExprKind::Var(var) => self.push(Item::Load(*var)),
            ExprKind::Elem(var, index) => {
                self.expr(index);
                self.push(Item::LoadElem(*var));
            }
            ExprKind::Table { table, row, column } => self.table(*table, row, column),
            ExprKind::Unary(op, value) => {
                self.expr(value);
                self.unary(*op);
            }
            ExprKind::Binary(op, left, right) => {
                self.expr(left);
                self.expr(right);
                self.plain(binary(*op));
            }
            ExprKind::AndAlso(left, right) => self.short_circuit(Cond::Zero, left, right),
            ExprKind::OrElse(left, right) => self.short_circuit(Cond::Nonzero, left, right),
            ExprKind::Call(routine, arguments) => self.call(*routine, arguments),
            ExprKind::ToSteps(axis, value) => {
                self.expr(value);
                self.push(Item::Flags(Op::ToSteps, [*axis as u8, 0, 0]));
            }
            ExprKind::ToLength(axis, value) => {
                self.expr(value);
                self.push(Item::Flags(Op::ToLength, [*axis as u8, 0, 0]));
            }
            ExprKind::MulDiv(parts) => {
                parts.iter().for_each(|part| self.expr(part));
                self.plain(Op::MulDiv);
            }
            ExprKind::Read(read) => self.read(read),
            ExprKind::Err => self.plain(Op::Err),
            ExprKind::Erl => self.plain(Op::Erl),
        }
    }

    fn read(&mut self, read: &ReadKind) {
        let (look, axis) = match read {
            ReadKind::In(n) => {
                self.expr(n);
                return self.plain(Op::In);
            }
            ReadKind::Out(n) => {
                self.expr(n);
                return self.plain(Op::Out);
            }
            ReadKind::InPort => (Look::InPort, 0),
            ReadKind::Pos(axis) => (Look::Pos, *axis as u8),
            ReadKind::PosSteps(axis) => (Look::PosSteps, *axis as u8),
            ReadKind::Probed(axis) => (Look::Probed, *axis as u8),
            ReadKind::ProbedSteps(axis) => (Look::ProbedSteps, *axis as u8),
            ReadKind::ProbeOk(axis) => (Look::ProbeOk, *axis as u8),
            ReadKind::Moving(axis) => (Look::Moving, *axis as u8),
            ReadKind::Homed(axis) => (Look::Homed, *axis as u8),
            ReadKind::Timer => (Look::Timer, 0),
            ReadKind::TimedOut => return self.plain(Op::TimedOut),
            ReadKind::CharIn => (Look::CharIn, 0),
            ReadKind::Analog(n) => (Look::Analog, n - 1),
        };
        self.look(look, axis);
    }

    pub(super) fn look(&mut self, look: Look, axis: u8) {
        self.push(Item::Flags(Op::Read, [(look as u8) << 2 | axis, 0, 0]));
    }

    fn table(&mut self, id: TableId, row: &Expr, column: &Expr) {
        let table = self.program.table(id);
        let columns = table.columns.max(1);
        let rows = table.values.len() as u32 / columns;
        let inside = |expr: &Expr, count: u32| match expr.node {
            ExprKind::Const(value) => u32::try_from(value).ok().filter(|&value| value < count),
            _ => None,
        };
        match (inside(row, rows), inside(column, columns)) {
            (Some(row), Some(column)) => {
                let value = table.values.get((row * columns + column) as usize).copied();
                self.push(Item::Const(value.unwrap_or(0)));
            }
            (_, Some(column)) => {
                self.expr(row);
                self.push(Item::Table(id, Some(column)));
            }
            (known, _) => {
                // Row by row in one column: row * columns + column, each tested by itself.
                match known {
                    Some(row) => self.push(Item::Const((row * columns) as i32)),
                    None => {
                        self.expr(row);
                        if column.is_simple() {
                            self.check(rows);
                        } else {
                            // The column is evaluated before the row is tested: one that lies
                            // outside stays so, and the column cannot bring it in again.
                            self.push(Item::Const(-1));
                            self.plain(Op::Max);
                            self.push(Item::Const(rows as i32));
                            self.plain(Op::Min);
                        }
                        self.push(Item::Const(columns as i32));
                        self.plain(Op::Mul);
                    }
                }
                self.expr(column);
                self.check(columns);
                self.plain(Op::Add);
                self.push(Item::Table(id, None));
            }
        }
    }

    /// F03 unless the top lies from 0 to `count` - 1.
    fn check(&mut self, count: u32) {
        if let Ok(count) = u8::try_from(count) {
            return self.push(Item::Flags(Op::Check, [count, 0, 0]));
        }
        let sign_is = |lower: &mut Self, negative: i32| {
            lower.push(Item::Const(31));
            lower.plain(Op::Shr);
            lower.push(Item::Const(negative));
            lower.plain(Op::Add);
            lower.push(Item::Flags(Op::Check, [1, 0, 0]));
            lower.plain(Op::Drop);
        };
        self.plain(Op::Dup);
        sign_is(self, 0);
        self.plain(Op::Dup);
        self.push(Item::Const(count as i32));
        self.plain(Op::Sub);
        sign_is(self, 1);
    }

    /// On the top.
    pub(super) fn unary(&mut self, op: UnOp) {
        let mut with = |value: i32, op: Op| {
            self.push(Item::Const(value));
            self.plain(op);
        };
        match op {
            UnOp::BitNot => with(-1, Op::Xor),
            UnOp::LogNot => with(0, Op::Eq),
            UnOp::Sgn => {
                with(1, Op::Min);
                with(-1, Op::Max);
            }
            UnOp::Neg => self.plain(Op::Neg),
            UnOp::Abs => self.plain(Op::Abs),
            UnOp::Sqr => self.plain(Op::Sqr),
            UnOp::Sin => self.plain(Op::Sin),
            UnOp::Cos => self.plain(Op::Cos),
        }
    }

    /// What is 0 or 1 where `expr` is 0 or not.
    fn truth(&mut self, expr: &Expr) {
        self.expr(expr);
        if expr.kind != Kind::Truth {
            self.push(Item::Const(0));
            self.plain(Op::Ne);
        }
    }

    /// The left side is the value when it meets `decides`, else the right side is.
    fn short_circuit(&mut self, decides: Cond, left: &Expr, right: &Expr) {
        let end = self.fresh();
        match decides {
            Cond::Zero => self.expr(left),
            _ => self.truth(left),
        }
        self.plain(Op::Dup);
        self.push(Item::Branch(decides, end));
        self.plain(Op::Drop);
        self.truth(right);
        self.push(Item::Label(end));
    }

    /// Arguments onto the stack, from there into the parameters, then the call.
    pub(super) fn call(&mut self, id: RoutineId, arguments: &[Expr]) {
        let routine = self.program.routine(id);
        for argument in arguments {
            self.expr(argument);
        }
        for &parameter in routine.params.iter().rev() {
            self.push(Item::Store(parameter));
        }
        let op = if routine.result.is_some() { Op::Func } else { Op::Call };
        self.push(Item::Call(op, id));
    }

    pub(super) fn assign(&mut self, place: &Place, value: &Expr) {
        match place {
            Place::Var(var) => {
                self.expr(value);
                self.push(Item::Store(*var));
            }
            Place::Elem(var, index) => match self.constant_cell(*var, index) {
                Some(cell) => {
                    self.expr(value);
                    self.push(Item::StoreAt(*var, cell));
                }
                None => {
                    self.expr(index);
                    self.expr(value);
                    self.push(Item::StoreElem(*var));
                }
            },
        }
    }

    fn constant_cell(&self, var: VarId, index: &Expr) -> Option<u32> {
        match index.node {
            ExprKind::Const(index) => {
                u32::try_from(index).ok().filter(|&index| index < self.program.var(var).len)
            }
            _ => None,
        }
    }

    /// Goes to `target` if the condition's truth is `wanted`, else falls through.
    pub(super) fn branch(&mut self, condition: &Expr, wanted: bool, target: Label) {
        match &condition.node {
            ExprKind::Const(value) => {
                if (*value != 0) == wanted {
                    self.push(Item::Jump(target));
                }
            }
            ExprKind::Unary(UnOp::LogNot, inner) => self.branch(inner, !wanted, target),
            ExprKind::AndAlso(left, right) if wanted => {
                let skip = self.fresh();
                self.branch(left, false, skip);
                self.branch(right, true, target);
                self.push(Item::Label(skip));
            }
            ExprKind::OrElse(left, right) if !wanted => {
                let skip = self.fresh();
                self.branch(left, true, skip);
                self.branch(right, false, target);
                self.push(Item::Label(skip));
            }
            ExprKind::AndAlso(left, right) | ExprKind::OrElse(left, right) => {
                self.branch(left, wanted, target);
                self.branch(right, wanted, target);
            }
            ExprKind::Binary(op, left, right) if cond(*op).is_some() => {
                let cond = cond(*op).unwrap_or(Cond::Nonzero);
                self.expr(left);
                self.expr(right);
                self.push(Item::Branch(if wanted { cond } else { cond.inverse() }, target));
            }
            _ => {
                self.expr(condition);
                let cond = if wanted { Cond::Nonzero } else { Cond::Zero };
                self.push(Item::Branch(cond, target));
            }
        }
    }
}
