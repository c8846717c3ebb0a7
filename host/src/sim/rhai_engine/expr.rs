//! Expressions as Rhai.
//!
//! An expression without calls of FUNCTIONs is one Rhai expression. One with calls is taken apart
//! at each call, since the called body is a matter of blocks: what was evaluated before waits on
//! a stack, so that the order of evaluation stays left to right.

use lang::effect::Effect;
use lang::hir::{BinOp, Expr, ExprKind, RoutineId, UnOp};

use super::effects::{Template, look};
use super::translate::Translator;

/// A number as Rhai reads it.
pub fn number(value: i32) -> String {
    match value {
        i32::MIN => "(-2147483647 - 1)".to_owned(),
        0.. => value.to_string(),
        _ => format!("({value})"),
    }
}

fn unary(op: UnOp, x: &str) -> String {
    let name = match op {
        UnOp::Neg => "neg",
        UnOp::BitNot => "bnot",
        UnOp::LogNot => return format!("(if {x} == 0 {{ 1 }} else {{ 0 }})"),
        UnOp::Abs => "mag",
        UnOp::Sgn => "sgn",
        UnOp::Sqr => "sqr",
        UnOp::Sin => "sine",
        UnOp::Cos => "cosine",
    };
    format!("{name}({x})")
}

pub(super) fn comparison(op: BinOp) -> Option<&'static str> {
    Some(match op {
        BinOp::Eq => "==",
        BinOp::Ne => "!=",
        BinOp::Lt => "<",
        BinOp::Le => "<=",
        BinOp::Gt => ">",
        BinOp::Ge => ">=",
        _ => return None,
    })
}

fn binary(op: BinOp, a: &str, b: &str) -> String {
    let infix = match op {
        BinOp::Add => "+",
        BinOp::Sub => "-",
        BinOp::Mul => "*",
        BinOp::And => "&",
        BinOp::Or => "|",
        BinOp::Xor => "^",
        BinOp::Div => return format!("div({a}, {b})"),
        BinOp::Mod => return format!("rem({a}, {b})"),
        BinOp::Shl => return format!("shl({a}, {b})"),
        BinOp::Shr => return format!("shr({a}, {b})"),
        BinOp::Min => return format!("least({a}, {b})"),
        BinOp::Max => return format!("most({a}, {b})"),
        BinOp::Atan2 => return format!("angle({a}, {b})"),
        _ => {
            let sign = comparison(op).unwrap_or("==");
            return format!("(if {a} {sign} {b} {{ 1 }} else {{ 0 }})");
        }
    };
    format!("({a} {infix} {b})")
}

impl Translator<'_> {
    /// The value as a Rhai expression, valid until the next call or assignment.
    pub fn value(&mut self, expr: &Expr) -> String {
        match &expr.node {
            ExprKind::Const(value) => number(*value),
            ExprKind::Var(var) => format!("v{}", var.0),
            ExprKind::Err => "er()".to_owned(),
            ExprKind::Erl => "el()".to_owned(),
            ExprKind::Elem(var, index) => format!("ld(v{}, {})", var.0, self.value(index)),
            ExprKind::Table { table, row, column } => {
                let at = self.values(&[row, column]);
                format!("tb({}, {}, {})", table.0, at[0], at[1])
            }
            ExprKind::Unary(op, x) => unary(*op, &self.value(x)),
            ExprKind::Binary(op, a, b) => {
                let both = self.values(&[a, b]);
                binary(*op, &both[0], &both[1])
            }
            ExprKind::AndAlso(..) | ExprKind::OrElse(..) => {
                let condition = self.condition(expr);
                format!("(if {condition} {{ 1 }} else {{ 0 }})")
            }
            ExprKind::Call(routine, arguments) => {
                self.call(*routine, arguments);
                "rv".to_owned()
            }
            ExprKind::MulDiv(parts) => {
                let values = self.values(&parts.each_ref());
                format!("muldiv({})", values.join(", "))
            }
            ExprKind::ToSteps(axis, x) => format!("ts({}, {})", axis.index(), self.value(x)),
            ExprKind::ToLength(axis, x) => format!("tl({}, {})", axis.index(), self.value(x)),
            ExprKind::Read(kind) => {
                let (read, argument) = look(kind);
                let argument = argument.map(|argument| self.value(argument));
                self.out.flush();
                let id = self.template(Template {
                    effect: Effect::Read(read),
                    line: self.out.script_line(),
                    given: [true; 3],
                    level: false,
                    resume: 0,
                });
                match argument {
                    Some(argument) => format!("g1({id}, {argument})"),
                    None => format!("g0({id})"),
                }
            }
        }
    }

    /// Values of several expressions in their order, all valid at once.
    pub fn values(&mut self, exprs: &[&Expr]) -> Vec<String> {
        let last_call = exprs.iter().rposition(|expr| expr.has_call()).unwrap_or(0);
        let mut values = Vec::new();
        let mut waiting = Vec::new();
        for (index, expr) in exprs.iter().enumerate() {
            let mut value = self.value(expr);
            if index < last_call && !matches!(expr.node, ExprKind::Const(_)) {
                self.out.line(format!("pu({value});"));
                waiting.push(index);
                value.clear();
            } else if index == last_call && !waiting.is_empty() {
                let temp = self.out.temp();
                self.out.line(format!("{temp} = {value};"));
                value = temp;
            }
            values.push(value);
            if index == last_call {
                for index in waiting.drain(..).rev() {
                    let temp = self.out.temp();
                    self.out.line(format!("{temp} = po();"));
                    values[index] = temp;
                }
            }
        }
        values
    }

    /// The expression as a Rhai condition.
    pub fn condition(&mut self, expr: &Expr) -> String {
        match &expr.node {
            ExprKind::Binary(op, a, b) if comparison(*op).is_some() => {
                let both = self.values(&[a, b]);
                format!("{} {} {}", both[0], comparison(*op).unwrap_or("=="), both[1])
            }
            ExprKind::Unary(UnOp::LogNot, x) if !x.has_call() => {
                let inner = self.condition(x);
                format!("({inner}) == false")
            }
            ExprKind::AndAlso(a, b) | ExprKind::OrElse(a, b) => {
                let and = matches!(expr.node, ExprKind::AndAlso(..));
                let left = self.condition(a);
                if !b.has_call() {
                    let right = self.condition(b);
                    return format!("({left}) {} ({right})", if and { "&&" } else { "||" });
                }
                // The right side has blocks of its own: its outcome comes over the stack.
                let id = self.out.id();
                let [go, skip, join] = [self.out.block(), self.out.block(), self.out.block()];
                let (yes, no) = if and { (go, skip) } else { (skip, go) };
                self.out.branch(&left, yes, no);
                self.out.open(go);
                let right = self.condition(b);
                self.out.line(format!("pu(if {right} {{ 1 }} else {{ 0 }});"));
                self.out.jump(join);
                self.out.open(skip);
                self.out.line(format!("pu({});", i32::from(!and)));
                self.out.open(join);
                self.out.belongs_to(id);
                let temp = self.out.temp();
                self.out.line(format!("{temp} = po();"));
                format!("{temp} != 0")
            }
            _ => format!("{} != 0", self.value(expr)),
        }
    }

    /// Calls a SUB or FUNCTION; its result is in `rv`.
    pub fn call(&mut self, routine: RoutineId, arguments: &[Expr]) {
        let arguments: Vec<&Expr> = arguments.iter().collect();
        let values = self.values(&arguments);
        let parameters = self.program.routine(routine).params.clone();
        for (parameter, value) in parameters.iter().zip(values) {
            self.out.line(format!("v{} = {value};", parameter.0));
        }
        let id = self.out.id();
        let back = self.out.block();
        let entry = self.entry(routine);
        self.out.close(format!("pc = cl({back}, {entry});"));
        self.out.open(back);
        self.out.belongs_to(id);
    }
}
