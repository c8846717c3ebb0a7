//! Values, conditions and calls.

use quote::ToTokens;
use syn::{BinOp, Expr as Rust, UnOp};

use super::{Reader, failure, item, no, path, size};
use crate::Refused;
use crate::leaf::{Kind, Leaf, Type};
use crate::tree::{Call, Cond, Expr, Number, Pair, Place, Size, Var};

/// A value and its type, unless it is a number's.
type Value = (Expr, Option<Type>);

impl Reader<'_> {
    pub(super) fn place(&self, leaf: &Leaf, axis: Option<Var>) -> Place {
        match &leaf.kind {
            Kind::Record(field, short) => Place {
                symbol: field.clone(),
                size: if *short { Size::Word } else { Size::Long },
                axis,
                record: Some((*short, leaf.record.clone())),
                load: None,
            },
            Kind::Place(symbol, load) => Place {
                symbol: symbol.clone(),
                size: size(leaf.gives),
                // Bytes have no place by axis.
                axis: axis.filter(|_| leaf.gives != Type::Byte),
                record: None,
                load: load.clone(),
            },
            _ => Place { symbol: String::new(), size: Size::Byte, axis, record: None, load: None },
        }
    }

    /// The axis and the value that a leaf's call gives it.
    pub(super) fn arguments(
        &mut self,
        call: &syn::ExprMethodCall,
    ) -> Result<(Option<Var>, Option<Expr>), Refused> {
        let arguments = call.args.iter().collect::<Vec<_>>();
        let takes = self.leaves[&call.method.to_string()].takes.clone();
        self.bound(&takes, &arguments, call, "").map(|(axis, value, _)| (axis, value))
    }

    /// The axis, the value, and the code with its numbers.
    fn bound(
        &mut self,
        takes: &[(String, Type)],
        arguments: &[&Rust],
        place: &impl ToTokens,
        code: &str,
    ) -> Result<(Option<Var>, Option<Expr>, String), Refused> {
        let mut code = code.to_owned();
        let (mut axis, mut value) = (None, None);
        let text = place.to_token_stream();
        if takes.len() != arguments.len() {
            return no(&text, "as many arguments as parameters");
        }
        for ((name, kind), argument) in takes.iter().zip(arguments) {
            let marker = format!("{{{name}}}");
            if code.contains(&marker) {
                let number = match item(argument, "TraceKind") {
                    Some(symbol) => symbol,
                    None => self.number(argument)?.text,
                };
                code = code.replace(&marker, &number);
            } else if *kind == Type::Axis {
                match path(argument).and_then(|name| self.names.get(&name)) {
                    Some(&var) if self.vars[var] == Type::Axis => axis = Some(var),
                    _ => return no(argument, "an axis"),
                }
            } else if value.is_none() {
                let given = self.value(argument)?.0;
                value = Some(match given {
                    Expr::Number(_) if *kind == Type::Long => Expr::Wide(Box::new(given)),
                    given => given,
                });
            } else {
                return no(argument, "one value besides an axis");
            }
        }
        Ok((axis, value, code))
    }

    /// A call of a leaf or a rule.
    pub(super) fn call(&mut self, expr: &Rust) -> Result<Call, Refused> {
        match expr {
            Rust::MethodCall(call) if path(&call.receiver).as_deref() == Some("m") => {
                let Some(leaf) = self.leaves.get(&call.method.to_string()).cloned() else {
                    return no(call, "a leaf");
                };
                let Kind::Code(code, or) = &leaf.kind else { return no(call, "a leaf of code") };
                let arguments = call.args.iter().collect::<Vec<_>>();
                let (axis, value, code) = self.bound(&leaf.takes, &arguments, call, code)?;
                let split = |code: &str| {
                    let ops = code.split(';').map(|op| op.trim().to_owned());
                    ops.filter(|op| !op.is_empty()).collect::<Vec<_>>()
                };
                Ok(Call {
                    code: split(&code),
                    or: or.as_deref().map(split),
                    rule: None,
                    axis,
                    value: value.map(Box::new),
                    gives: leaf.gives,
                    holds: leaf.holds,
                    changes: leaf.changes,
                    zero: leaf.zero,
                    sure: leaf.sure,
                    record: leaf.record,
                    sets_record: leaf.sets_record,
                    when: leaf.when,
                    ends: leaf.ends,
                })
            }
            Rust::Call(call) => {
                let Rust::Path(of) = &*call.func else { return no(call, "a rule") };
                let names = of.path.segments.iter().map(|segment| segment.ident.to_string());
                let names = names.collect::<Vec<_>>();
                let name = match &names[..] {
                    [name] => format!("{}::{name}", self.module),
                    names => names.join("::"),
                };
                let Some(rule) = self.rules.get(&name).cloned() else {
                    return no(call, "a leaf or a rule");
                };
                let arguments = call.args.iter().skip(1).collect::<Vec<_>>();
                let (axis, value, _) = self.bound(&rule.takes, &arguments, call, "")?;
                Ok(Call {
                    code: Vec::new(),
                    or: None,
                    rule: Some(rule.label),
                    axis,
                    value: value.map(Box::new),
                    gives: rule.gives,
                    holds: rule.holds,
                    changes: rule.changes,
                    zero: rule.zero,
                    sure: false,
                    record: rule.said.get("of").cloned(),
                    sets_record: None,
                    when: None,
                    ends: None,
                })
            }
            expr => no(expr, "a call of a leaf or a rule"),
        }
    }

    fn pair(&mut self, op: Pair, a: &Rust, b: &Rust) -> Result<Value, Refused> {
        let (a, kind) = self.value(a)?;
        let (b, other) = self.value(b)?;
        Ok((Expr::Pair(op, Box::new(a), Box::new(b)), kind.or(other)))
    }

    /// A value and its type.
    pub(super) fn value(&mut self, expr: &Rust) -> Result<Value, Refused> {
        if let Ok(number) = self.number(expr) {
            return Ok((Expr::Number(number), None));
        }
        match expr {
            Rust::Paren(inner) => self.value(&inner.expr),
            Rust::Path(path) if path.to_token_stream().to_string() == "Scaled :: ZERO" => {
                Ok((Expr::Number(Number::of(0)), Some(Type::Long)))
            }
            Rust::Path(path) if path.to_token_stream().to_string() == "Scaled :: MAX" => {
                Ok((Expr::Most, Some(Type::Long)))
            }
            Rust::Path(_) => match path(expr).and_then(|name| self.names.get(&name)) {
                Some(&var) => Ok((Expr::Var(var), Some(self.vars[var]))),
                None => no(expr, "a variable, a number"),
            },
            Rust::Binary(pair) => {
                let op = match &pair.op {
                    BinOp::BitAnd(_) => Pair::And,
                    BinOp::Shr(_) => Pair::Half,
                    BinOp::Add(_) => Pair::Add,
                    BinOp::Shl(_) if self.number(&pair.right)?.value == Some(8) => {
                        let (value, _) = self.value(&pair.left)?;
                        return Ok((Expr::High(Box::new(value)), Some(Type::Word)));
                    }
                    _ => return no(pair, "& and >> with a number, << 8, wrapping_add"),
                };
                self.pair(op, &pair.left, &pair.right)
            }
            Rust::Cast(cast) => match cast.ty.to_token_stream().to_string().as_str() {
                "u8" => Ok((Expr::Low(Box::new(self.value(&cast.expr)?.0)), Some(Type::Byte))),
                // The same bits.
                "u32" | "i32" => self.value(&cast.expr),
                _ => no(cast, "as u8, as i32, as u32"),
            },
            Rust::Try(tried) => self.tried(&tried.expr),
            Rust::If(branch) => {
                let cond = self.cond(&branch.cond)?;
                let (then, kind) = self.value(tail(&branch.then_branch)?)?;
                let Some((_, other)) = &branch.else_branch else { return no(branch, "an else") };
                let (other, also) = match &**other {
                    Rust::Block(block) => self.value(tail(&block.block)?)?,
                    other => self.value(other)?,
                };
                Ok((Expr::If(Box::new(cond), Box::new(then), Box::new(other)), kind.or(also)))
            }
            Rust::MethodCall(call) => self.method(call, expr),
            Rust::Call(call) => {
                let name = call.func.to_token_stream().to_string().replace(' ', "");
                let wide = match name.as_str() {
                    "u16::from" => Type::Word,
                    "i32::from" | "u32::from" => Type::Long,
                    "Scaled::new" => {
                        let Some(n) = call.args.first() else { return no(call, "a number") };
                        let n = match self.value(n)?.0 {
                            n @ Expr::Number(_) => Expr::Wide(Box::new(n)),
                            n => n,
                        };
                        return Ok((Expr::Of("new", Box::new(n)), Some(Type::Long)));
                    }
                    "Axis::new" => {
                        let Some(n) = call.args.first() else { return no(call, "a number") };
                        return Ok((self.value(n)?.0, Some(Type::Axis)));
                    }
                    _ => {
                        let call = self.call(expr)?;
                        let kind = call.gives;
                        return Ok((Expr::Call(call), Some(kind)));
                    }
                };
                let Some(value) = call.args.first() else { return no(call, "a value") };
                // A bit that is 1 is a number, too.
                if let Rust::MethodCall(leaf) = value
                    && let Some(Kind::Any(byte, mask, Some(1))) =
                        self.leaves.get(&leaf.method.to_string()).map(|leaf| leaf.kind.clone())
                {
                    let byte = Place {
                        symbol: byte,
                        size: Size::Byte,
                        axis: None,
                        record: None,
                        load: None,
                    };
                    let mask = Expr::Number(Number { text: mask, value: Some(1), wide: false });
                    let bit = Expr::Pair(Pair::And, Box::new(Expr::Place(byte)), Box::new(mask));
                    return Ok((Expr::Wide(Box::new(bit)), Some(wide)));
                }
                let (value, kind) = self.value(value)?;
                if kind == Some(Type::Bool) {
                    return no(call, "`u16::from` of a byte, a number or a bit that is 1");
                }
                Ok((Expr::Wide(Box::new(value)), Some(wide)))
            }
            expr => no(expr, "a value"),
        }
    }

    fn method(&mut self, call: &syn::ExprMethodCall, expr: &Rust) -> Result<Value, Refused> {
        let name = call.method.to_string();
        if path(&call.receiver).as_deref() == Some("m") {
            let Some(leaf) = self.leaves.get(&name).cloned() else { return no(call, "a leaf") };
            if matches!(leaf.kind, Kind::Place(..) | Kind::Record(..)) {
                let (axis, _) = self.arguments(call)?;
                return Ok((Expr::Place(self.place(&leaf, axis)), Some(leaf.gives)));
            }
            let call = self.call(expr)?;
            let kind = call.gives;
            return Ok((Expr::Call(call), Some(kind)));
        }
        let argument = call.args.first();
        let of = |name, value: Value| (Expr::Of(name, Box::new(value.0)), value.1);
        match (name.as_str(), argument) {
            ("bit", None) => match self.value(&call.receiver)? {
                (Expr::Var(var), Some(Type::Axis)) => Ok((Expr::Bit(var), Some(Type::Byte))),
                _ => no(&call.receiver, "an axis"),
            },
            ("wrapping_add" | "checked_add", Some(b)) => self.pair(Pair::Add, &call.receiver, b),
            ("wrapping_sub" | "checked_sub", Some(b)) => self.pair(Pair::Sub, &call.receiver, b),
            ("times", Some(b)) => self.pair(Pair::Times, &call.receiver, b),
            ("over", Some(b)) => self.pair(Pair::Over, &call.receiver, b),
            ("plus", Some(b)) => self.pair(Pair::Plus, &call.receiver, b),
            ("minus", Some(b)) => self.pair(Pair::Minus, &call.receiver, b),
            ("least", Some(b)) => self.pair(Pair::Least, &call.receiver, b),
            ("most", Some(b)) => self.pair(Pair::Most, &call.receiver, b),
            ("shifted", Some(by)) => {
                let Some(by) = power(by) else { return no(by, "a power of two, written out") };
                let value = self.value(&call.receiver)?.0;
                Ok((Expr::Shifted(Box::new(value), by), Some(Type::Long)))
            }
            // What an integer is less another one, of numbers that hold an exponent.
            ("gap", Some(b)) => {
                let (value, _) = self.pair(Pair::Sub, &call.receiver, b)?;
                Ok((value, Some(Type::Long)))
            }
            ("floor", None) => Ok(of("floor", self.value(&call.receiver)?)),
            ("root", None) => Ok(of("root", self.value(&call.receiver)?)),
            ("wrapping_neg", None) => Ok(of("negate", self.value(&call.receiver)?)),
            ("wrapping_abs", None) => Ok(of("abs", self.value(&call.receiver)?)),
            ("max", Some(b)) if self.number(b).is_ok_and(|b| b.value == Some(0)) => {
                Ok(of("not_negative", self.value(&call.receiver)?))
            }
            ("max", Some(b)) => self.pair(Pair::Most, &call.receiver, b),
            ("unwrap_or", Some(b)) if self.number(b)?.value == Some(0) => {
                let value = self.value(&call.receiver)?.0;
                Ok((Expr::OrZero(Box::new(value)), Some(Type::Long)))
            }
            _ => no(
                call,
                "wrapping_add, wrapping_sub, wrapping_neg, wrapping_abs, max, unwrap_or(0), bit, plus, minus, times, over, \
                 least, most, gap, shifted, root, floor",
            ),
        }
    }

    /// `x.ok_or(Fault::..)?`, `f(..)?`.
    fn tried(&mut self, expr: &Rust) -> Result<Value, Refused> {
        if let Rust::MethodCall(call) = expr
            && call.method == "ok_or"
        {
            let Some(fault) = call.args.first().and_then(failure) else {
                return no(call, "Fault::.., Exception::..");
            };
            let value = self.value(&call.receiver)?.0;
            return Ok((Expr::OrFault(Box::new(value), fault), Some(Type::Long)));
        }
        let call = self.call(expr)?;
        let kind = match call.gives {
            Type::ByteOrFault => Type::Byte,
            Type::LongOrFault => Type::Long,
            _ => {
                return no(expr, "`ok_or(Fault::..)?`, or a leaf that gives u8 or i32, or a fault");
            }
        };
        Ok((Expr::Call(call), Some(kind)))
    }

    /// What is so or not.
    pub(super) fn cond(&mut self, expr: &Rust) -> Result<Cond, Refused> {
        match expr {
            Rust::Paren(inner) => self.cond(&inner.expr),
            Rust::Unary(not) if matches!(not.op, UnOp::Not(_)) => {
                Ok(Cond::Not(Box::new(self.cond(&not.expr)?)))
            }
            Rust::Path(_) => match path(expr).and_then(|name| self.names.get(&name)) {
                Some(&var) if self.vars[var] == Type::Bool => Ok(Cond::First),
                _ => no(expr, "`first`"),
            },
            Rust::Lit(literal) => match &literal.lit {
                syn::Lit::Bool(so) if so.value => Ok(Cond::Not(Box::new(Cond::Never))),
                syn::Lit::Bool(_) => Ok(Cond::Never),
                _ => no(literal, "true, false"),
            },
            Rust::Binary(pair) => self.compared(pair),
            Rust::MethodCall(call) if path(&call.receiver).as_deref() == Some("m") => {
                let Some(leaf) = self.leaves.get(&call.method.to_string()).cloned() else {
                    return no(call, "a leaf that is true or not");
                };
                let cond = match leaf.kind {
                    Kind::Any(byte, mask, bit) => Cond::Any(byte, mask, bit),
                    Kind::Is(byte, value) => Cond::Is(byte, value),
                    Kind::Never => Cond::Never,
                    Kind::Bit(byte, None) => match self.arguments(call)? {
                        (Some(axis), None) => Cond::In(byte, axis),
                        _ => return no(call, "an axis"),
                    },
                    Kind::Code(..) if leaf.gives == Type::Bool => Cond::Call(self.call(expr)?),
                    _ => return no(call, "a leaf that is true or not"),
                };
                Ok(match leaf.when {
                    Some(symbol) => Cond::When(symbol, Box::new(cond)),
                    None => cond,
                })
            }
            Rust::Call(_) => {
                let call = self.call(expr)?;
                if call.gives != Type::Bool {
                    return no(expr, "a rule that is true or not");
                }
                Ok(Cond::Call(call))
            }
            Rust::Macro(matches) if matches.mac.path.is_ident("matches") => {
                let args = |input: syn::parse::ParseStream<'_>| {
                    let byte = input.parse::<Rust>()?;
                    input.parse::<syn::Token![,]>()?;
                    Ok((byte, input.parse::<syn::ExprRange>()?))
                };
                let (byte, range) = matches.mac.parse_body_with(args)?;
                let (Some(first), Some(last), syn::RangeLimits::Closed(_)) =
                    (&range.start, &range.end, &range.limits)
                else {
                    return no(&range, "FIRST..=LAST");
                };
                let (first, last) = (self.number(first)?, self.number(last)?);
                Ok(Cond::Within(self.value(&byte)?.0, first, last))
            }
            expr => no(expr, "a leaf, a rule, a comparison, `matches!`, !, &&, ||"),
        }
    }

    fn compared(&mut self, pair: &syn::ExprBinary) -> Result<Cond, Refused> {
        let not = |cond| match cond {
            Cond::Not(inner) => *inner,
            cond => Cond::Not(Box::new(cond)),
        };
        match &pair.op {
            BinOp::And(_) | BinOp::Or(_) => {
                let (a, b) = (self.cond(&pair.left)?, self.cond(&pair.right)?);
                Ok(if matches!(pair.op, BinOp::And(_)) {
                    Cond::And(Box::new(a), Box::new(b))
                } else {
                    Cond::Or(Box::new(a), Box::new(b))
                })
            }
            BinOp::Eq(_) | BinOp::Ne(_) => {
                let (a, b) = (self.value(&pair.left)?.0, self.value(&pair.right)?.0);
                let zero = matches!(&b, Expr::Number(zero) if zero.value == Some(0));
                let same = match a {
                    Expr::Pair(Pair::And, value, mask) if zero => match *mask {
                        Expr::Number(mask) => not(Cond::Bits(*value, mask)),
                        _ => return no(pair, "bits of a number"),
                    },
                    a => Cond::Same(a, b),
                };
                Ok(if matches!(pair.op, BinOp::Eq(_)) { same } else { not(same) })
            }
            BinOp::Lt(_) => Ok(Cond::Below(self.value(&pair.left)?.0, self.value(&pair.right)?.0)),
            BinOp::Ge(_) => {
                Ok(not(Cond::Below(self.value(&pair.left)?.0, self.value(&pair.right)?.0)))
            }
            _ => no(pair, "==, !=, <, >=, &&, ||"),
        }
    }
}

/// A number from -64 to 63.
fn power(expr: &Rust) -> Option<i8> {
    let (sign, expr) = match expr {
        Rust::Unary(negative) if matches!(negative.op, UnOp::Neg(_)) => (-1, &*negative.expr),
        expr => (1, expr),
    };
    let Rust::Lit(syn::ExprLit { lit: syn::Lit::Int(number), .. }) = expr else { return None };
    number.base10_parse::<i8>().ok().map(|n| sign * n).filter(|n| (-64..64).contains(n))
}

fn tail(block: &syn::Block) -> Result<&Rust, Refused> {
    match &block.stmts[..] {
        [syn::Stmt::Expr(expr, None)] => Ok(expr),
        _ => no(block, "one expression"),
    }
}
