//! Watches: expressions of the language, evaluated in a halted run.

use lang::front::ast::{BinaryOp, Expr, ExprKind, Machine, PrintPart, StmtKind, UnaryOp};
use lang::front::diag::Diags;
use lang::front::parser::parse;
use lang::front::words::Func;
use lang::isa::Op;
use lang::kind::Kind;
use lang::trig;
use lang::vm::math;

use super::names::{Binding, Names};
use super::snapshot::Snapshot;

/// A value with its kind.
pub type Value = (Kind, i32);

/// Evaluates an expression as it would be in a line.
///
/// # Errors
/// It cannot be read, names something unknown, or faults; in words.
pub fn eval(text: &str, line: u32, names: &Names, at: &Snapshot) -> Result<Value, String> {
    let mut diags = Diags::new();
    let script = parse(&format!("PRINT {}\n", text.trim()), &mut diags);
    if let Some(diag) = diags.into_sorted().first() {
        return Err(diag.message.clone());
    }
    let only = match &script.body[..] {
        [stmt] => match &stmt.kind {
            StmtKind::Machine(machine) => match &**machine {
                Machine::Print(parts) => match &parts[..] {
                    [PrintPart::Value(expr, None)] => Some(expr),
                    _ => None,
                },
                _ => None,
            },
            _ => None,
        },
        _ => None,
    };
    let expr = only.ok_or_else(|| "this is no expression".to_owned())?;
    Scope { line, names, at }.expr(expr)
}

/// The element of an array that a watch names: its cell and kind; of a plain variable its own.
///
/// # Errors
/// There is no such variable; in words.
pub fn place(text: &str, line: u32, names: &Names, at: &Snapshot) -> Result<(usize, Kind), String> {
    let (name, index) = match text.trim().strip_suffix(')').and_then(|t| t.split_once('(')) {
        Some((name, index)) => (name.trim(), Some(index)),
        None => (text.trim(), None),
    };
    match names.look(line, name) {
        Some(&Binding::Cells { cell, len, kind, .. }) => {
            let index = match index {
                Some(index) => eval(index, line, names, at)?.1,
                None => 0,
            };
            let inside = usize::try_from(index).ok().filter(|index| *index < len);
            let index = inside.ok_or_else(|| format!("the index goes from 0 to {}", len - 1))?;
            Ok((cell + index, kind))
        }
        Some(_) => Err(format!("`{name}` cannot be set")),
        None => Err(format!("nothing is called `{name}` here")),
    }
}

struct Scope<'a> {
    line: u32,
    names: &'a Names,
    at: &'a Snapshot,
}

impl Scope<'_> {
    fn expr(&self, expr: &Expr) -> Result<Value, String> {
        let fault = |fault: lang::fault::Fault| format!("{fault} {}", fault.text());
        match &expr.kind {
            ExprKind::Literal { kind, value } => Ok((*kind, *value)),
            ExprKind::Axis(_) => Err("an axis has no value".to_owned()),
            ExprKind::Name(name) => self.named(&name.text, &[]),
            ExprKind::Apply(name, args) => {
                if let (Some(func), None) =
                    (Func::soft(&name.key), self.names.look(self.line, &name.text))
                {
                    return match args.len() == func.args().len() {
                        true => self.builtin(func, args),
                        false => Err(format!("its form is `{}`", func.usage())),
                    };
                }
                let args = args.iter().map(|arg| Ok(self.expr(arg)?.1));
                self.named(&name.text, &args.collect::<Result<Vec<_>, String>>()?)
            }
            ExprKind::Builtin(func, args) => self.builtin(*func, args),
            ExprKind::Unary(op, inner) => {
                let (kind, value) = self.expr(inner)?;
                match op {
                    UnaryOp::Neg => Ok((kind, math::unary(Op::Neg, value).map_err(fault)?)),
                    UnaryOp::Not if kind == Kind::Truth => Ok((kind, i32::from(value == 0))),
                    UnaryOp::Not => Ok((kind, !value)),
                    UnaryOp::Bit(bit) => Ok((Kind::Truth, value >> bit & 1)),
                }
            }
            ExprKind::Binary(op, left, right) => {
                let (kind, left) = self.expr(left)?;
                match op {
                    BinaryOp::AndAlso if left == 0 => return Ok((Kind::Truth, 0)),
                    BinaryOp::OrElse if left != 0 => return Ok((Kind::Truth, 1)),
                    BinaryOp::AndAlso | BinaryOp::OrElse => {
                        return Ok((Kind::Truth, i32::from(self.expr(right)?.1 != 0)));
                    }
                    _ => {}
                }
                let (other, right) = self.expr(right)?;
                let value = math::binary(instruction(*op), left, right).map_err(fault)?;
                let plain = |kind: Kind| matches!(kind, Kind::Number | Kind::Truth);
                let kind = match op {
                    op if op.is_comparison() => Kind::Truth,
                    BinaryOp::Div if kind == other => Kind::Number,
                    _ if plain(kind) && !plain(other) => other,
                    _ => kind,
                };
                Ok((kind, value))
            }
        }
    }

    fn named(&self, name: &str, args: &[i32]) -> Result<Value, String> {
        let at = |len: usize, index: i32| {
            let inside = usize::try_from(index).ok().filter(|index| *index < len);
            inside.ok_or_else(|| format!("the index {index} is outside of `{name}`"))
        };
        match (self.names.look(self.line, name), args) {
            (Some(Binding::Cells { cell, array: false, kind, .. }), []) => {
                Ok((*kind, self.at.cell(*cell)))
            }
            (Some(Binding::Cells { cell, len, array: true, kind }), [index]) => {
                Ok((*kind, self.at.cell(cell + at(*len, *index)?)))
            }
            (Some(Binding::Const(kind, value)), []) => Ok((*kind, *value)),
            (Some(Binding::Port(_, n)), []) => Ok((Kind::Number, *n)),
            (Some(Binding::Table(kinds, values)), [row, rest @ ..]) if rest.len() < 2 => {
                let column = at(kinds.len(), rest.first().copied().unwrap_or(0))?;
                let row = at(values.len() / kinds.len(), *row)?;
                Ok((kinds[column], values[row * kinds.len() + column]))
            }
            (Some(Binding::Gone), _) => Err(format!("`{name}` was not kept: nothing reads it")),
            (Some(_), _) => Err(format!("`{name}` has no value in this form")),
            (None, []) => Err(format!("nothing is called `{name}` here")),
            (None, _) => Err("a watch calls no FUNCTION".to_owned()),
        }
    }

    fn builtin(&self, func: Func, args: &[Expr]) -> Result<Value, String> {
        let fault = |fault: lang::fault::Fault| format!("{fault} {}", fault.text());
        let view = &self.at.view;
        let value = |n: usize| args.get(n).map_or(Err(String::new()), |arg| self.expr(arg));
        let axis = || {
            let Some(ExprKind::Axis(axis)) = args.first().map(|arg| &arg.kind) else {
                return Err("an axis is missing".to_owned());
            };
            let found = view.axes.iter().find(|view| view.axis == axis.axis);
            found.ok_or_else(|| "the machine has no such axis".to_owned())
        };
        let port = |list: &[(i32, bool)]| {
            let n = value(0)?.1;
            let found = list.iter().find(|(own, _)| *own == n);
            found
                .map(|(_, on)| (Kind::Truth, i32::from(*on)))
                .ok_or_else(|| format!("there is no {n}"))
        };
        match func {
            Func::Sin => Ok((Kind::Number, trig::sin(value(0)?.1, trig::wide))),
            Func::Cos => Ok((Kind::Number, trig::cos(value(0)?.1, trig::wide))),
            Func::Atan2 => Ok((Kind::Angle, trig::atan2(value(0)?.1, value(1)?.1, trig::wide))),
            Func::Scale => {
                let gap = |from: usize, to: usize| {
                    math::binary(Op::Sub, value(to)?.1, value(from)?.1).map_err(fault)
                };
                let (kind, low) = value(3)?;
                let part =
                    trig::mul_div(gap(1, 0)?, gap(3, 4)?, gap(1, 2)?, trig::wide).map_err(fault)?;
                Ok((kind, math::binary(Op::Add, part, low).map_err(fault)?))
            }
            Func::Abs => {
                value(0).and_then(|(k, v)| Ok((k, math::unary(Op::Abs, v).map_err(fault)?)))
            }
            Func::Sgn => value(0).map(|(_, v)| (Kind::Number, v.signum())),
            Func::Sqr => {
                value(0).and_then(|(k, v)| Ok((k, math::unary(Op::Sqr, v).map_err(fault)?)))
            }
            Func::Min => Ok((value(0)?.0, value(0)?.1.min(value(1)?.1))),
            Func::Max => Ok((value(0)?.0, value(0)?.1.max(value(1)?.1))),
            Func::In => port(&view.inputs),
            Func::Out => port(&view.outputs),
            Func::InPort => {
                let on = view.inputs.iter().filter(|(n, on)| *on && (1..=31).contains(n));
                Ok((Kind::Number, on.fold(0, |bits, (n, _)| bits | 1 << (n - 1))))
            }
            Func::Pos => axis().map(|axis| (Kind::Length, axis.um)),
            Func::PosSt => axis().map(|axis| (Kind::Steps, axis.steps)),
            Func::Moving => axis().map(|axis| (Kind::Truth, axis.moving.into())),
            Func::Homed => axis().map(|axis| (Kind::Truth, axis.homed.into())),
            Func::Timer => view.timer.map(|ms| (Kind::Time, ms)).ok_or_else(|| {
                "a board does not show TIMER(): write `t = TIMER()` in the script and watch `t`"
                    .to_owned()
            }),
            Func::Ain => {
                Err("AIN() is not shown here: write `v = AIN(n)` in the script and watch `v`"
                    .to_owned())
            }
            Func::Count => match args.first().map(|arg| &arg.kind) {
                Some(ExprKind::Name(name)) => match self.names.look(self.line, &name.text) {
                    Some(Binding::Table(kinds, values)) => {
                        Ok((Kind::Number, (values.len() / kinds.len()) as i32))
                    }
                    _ => Err(format!("`{}` is no TABLE", name.text)),
                },
                _ => Err("COUNT takes a TABLE".to_owned()),
            },
            Func::Steps | Func::Length => {
                let own = self.names.profile.axis(axis()?.axis);
                let scale = own.ok_or("the machine has no such axis")?.scale;
                let (kind, times, over) = match func {
                    Func::Steps => (Kind::Steps, scale.steps, scale.um),
                    _ => (Kind::Length, scale.um, scale.steps),
                };
                Ok((kind, math::scale(value(1)?.1, times, over).map_err(fault)?))
            }
            _ => Err(format!("{} is not known while the run is halted", func.text())),
        }
    }
}

/// The instruction of an operator.
const fn instruction(op: BinaryOp) -> Op {
    match op {
        BinaryOp::Or | BinaryOp::OrElse => Op::Or,
        BinaryOp::Xor => Op::Xor,
        BinaryOp::And | BinaryOp::AndAlso => Op::And,
        BinaryOp::Eq => Op::Eq,
        BinaryOp::Ne => Op::Ne,
        BinaryOp::Lt => Op::Lt,
        BinaryOp::Le => Op::Le,
        BinaryOp::Gt => Op::Gt,
        BinaryOp::Ge => Op::Ge,
        BinaryOp::Shl => Op::Shl,
        BinaryOp::Shr => Op::Shr,
        BinaryOp::Add => Op::Add,
        BinaryOp::Sub => Op::Sub,
        BinaryOp::Mul => Op::Mul,
        BinaryOp::Div => Op::Div,
        BinaryOp::Mod => Op::Mod,
    }
}
