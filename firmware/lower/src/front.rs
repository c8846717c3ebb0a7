//! Functions of the subset from Rust.

use std::collections::BTreeMap;

use quote::ToTokens;
use syn::{BinOp, Block, Expr, File, Item, ItemFn, Lit, Pat, ReturnType, Stmt as RustStmt};

use crate::Refused;
use crate::leaf::{Leaf, Leaves, micro};

/// A number: what the assembler is told, and its value where it is written out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Number {
    /// A number or a constant's name.
    pub text: String,
    /// Its value, unless it is a name.
    pub value: Option<u16>,
}

/// What is true or not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Cond {
    /// A leaf.
    Leaf(String),
    /// A function of the file.
    Call(String),
    /// A byte that is a value.
    Is(String, Number),
    /// A byte from a value to another one.
    Within(String, Number, Number),
}

/// What a word may be made of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Value {
    /// A number.
    Number(Number),
    /// A byte.
    Byte(String),
    /// The bit of an axis: of a leaf's, or of the loop's.
    Bit(Option<String>),
}

/// A statement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stmt {
    /// `word |= value`, or `<< 8`.
    Or(Value, bool),
    /// `if`, with `else`.
    If(Cond, Vec<Stmt>, Vec<Stmt>),
    /// `for axis in Axis::DOWN`.
    Axes(Vec<Stmt>),
}

/// What a function does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Body {
    /// It is a condition.
    Cond(Cond),
    /// A number if a condition holds, else 0.
    Either(Cond, Number),
    /// What a leaf says: a byte, a word, a number, a bit that is 1.
    Leaf(String),
    /// A word less another one, modulo 65536.
    Less(String, String),
    /// A word from its first value, in the high byte or not.
    Word(Value, bool, Vec<Stmt>),
}

/// A function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Function {
    /// Its name.
    pub name: String,
    /// What it does.
    pub body: Body,
}

/// What is read along the way.
struct Reader<'a> {
    leaves: &'a Leaves,
    /// Names of constants in the assembler.
    constants: BTreeMap<String, String>,
    functions: Vec<String>,
    /// The variable that is made, and that of the loop.
    word: String,
    axis: String,
}

fn no<T>(place: &(impl syn::spanned::Spanned + ToTokens), wanted: &str) -> Result<T, Refused> {
    let text = place.to_token_stream().to_string();
    Err(Refused::at(place, format!("`{text}` is not of the subset: {wanted}")))
}

/// The functions of a file.
///
/// # Errors
/// Something is not of the subset.
pub fn read(file: &File, leaves: &Leaves) -> Result<Vec<Function>, Refused> {
    let mut reader = Reader {
        leaves,
        constants: BTreeMap::new(),
        functions: Vec::new(),
        word: String::new(),
        axis: String::new(),
    };
    for item in &file.items {
        match item {
            Item::Const(constant) => {
                let Some(tokens) = micro(&constant.attrs) else {
                    return no(
                        constant,
                        "a constant says its name in the assembler, `micro(\"NAME\")`",
                    );
                };
                let name = syn::parse2::<syn::LitStr>(tokens?)?.value();
                reader.constants.insert(constant.ident.to_string(), name);
            }
            Item::Fn(function) => reader.functions.push(function.sig.ident.to_string()),
            Item::Use(_) => {}
            item => return no(item, "functions, constants, use"),
        }
    }
    let functions = file.items.iter().filter_map(|item| match item {
        Item::Fn(function) => Some(function),
        _ => None,
    });
    functions.map(|function| reader.function(function)).collect()
}

fn path(expr: &Expr) -> Option<String> {
    let Expr::Path(path) = expr else { return None };
    Some(path.path.get_ident()?.to_string())
}

impl Reader<'_> {
    fn function(&mut self, function: &ItemFn) -> Result<Function, Refused> {
        let name = function.sig.ident.to_string();
        let machine = function.sig.inputs.to_token_stream().to_string();
        if machine != "m : & impl Machine" {
            return no(&function.sig, "one argument, `m: &impl Machine`");
        }
        let ReturnType::Type(_, result) = &function.sig.output else {
            return no(&function.sig, "a result");
        };
        let body = match result.to_token_stream().to_string().as_str() {
            "bool" => Body::Cond(self.cond(tail(&function.block)?)?),
            "u16" => self.word(&function.block)?,
            _ => return no(result, "bool, u16"),
        };
        Ok(Function { name, body })
    }

    fn word(&mut self, block: &Block) -> Result<Body, Refused> {
        if let [RustStmt::Expr(Expr::If(both), None)] = &block.stmts[..] {
            let Some((_, other)) = &both.else_branch else { return no(both, "an else") };
            let Expr::Block(other) = &**other else { return no(other, "a block") };
            if self.number(tail(&other.block)?)?.value != Some(0) {
                return no(&other.block, "0");
            }
            let number = self.number(tail(&both.then_branch)?)?;
            return Ok(Body::Either(self.cond(&both.cond)?, number));
        }
        if let [RustStmt::Expr(expr, None)] = &block.stmts[..] {
            return self.plain(expr);
        }
        let Some((RustStmt::Local(local), rest)) = block.stmts.split_first() else {
            return no(block, "`let mut word = ..;` first");
        };
        let (Pat::Ident(name), Some(init)) = (&local.pat, &local.init) else {
            return no(local, "`let mut word = ..;`");
        };
        self.word = name.ident.to_string();
        let (value, high) = self.value(&init.expr)?;
        let Some((RustStmt::Expr(last, None), rest)) = rest.split_last() else {
            return no(block, "the word as its result");
        };
        if path(last).as_ref() != Some(&self.word) {
            return no(last, "the word as the result");
        }
        Ok(Body::Word(value, high, self.stmts(rest)?))
    }

    /// A leaf as the result, or the difference of two.
    fn plain(&self, expr: &Expr) -> Result<Body, Refused> {
        let leaf = |expr: &Expr, words: bool| match expr {
            Expr::MethodCall(call) => {
                let name = call.method.to_string();
                let word = matches!(self.leaves.get(&name)?, Leaf::Word(_));
                (word == words).then_some(name)
            }
            _ => None,
        };
        if let Some(name) = leaf(expr, true) {
            return Ok(Body::Leaf(name));
        }
        if let Expr::MethodCall(less) = expr
            && less.method == "wrapping_sub"
            && let Some(first) = leaf(&less.receiver, true)
            && let Some(second) = less.args.first().and_then(|second| leaf(second, true))
        {
            return Ok(Body::Less(first, second));
        }
        if let Expr::Call(call) = expr
            && call.func.to_token_stream().to_string() == "u16 :: from"
            && let Some(name) = call.args.first().and_then(|inner| leaf(inner, false))
            && !matches!(self.leaves[&name], Leaf::Axis(_) | Leaf::Is(_) | Leaf::Code(..))
        {
            return Ok(Body::Leaf(name));
        }
        no(
            expr,
            "a word, a word less another, `u16::from(..)` of a byte, a number or a bit that is 1",
        )
    }

    fn stmts(&mut self, stmts: &[RustStmt]) -> Result<Vec<Stmt>, Refused> {
        stmts.iter().map(|stmt| self.stmt(stmt)).collect()
    }

    fn stmt(&mut self, stmt: &RustStmt) -> Result<Stmt, Refused> {
        let RustStmt::Expr(expr, _) = stmt else { return no(stmt, "an if, a loop or `|=`") };
        match expr {
            Expr::Binary(or) if matches!(or.op, BinOp::BitOrAssign(_)) => {
                if path(&or.left).as_ref() != Some(&self.word) {
                    return no(&or.left, "the word");
                }
                let (value, high) = self.value(&or.right)?;
                Ok(Stmt::Or(value, high))
            }
            Expr::If(branch) => {
                let other = match &branch.else_branch {
                    None => Vec::new(),
                    Some((_, other)) => match &**other {
                        Expr::Block(block) => self.stmts(&block.block.stmts)?,
                        other => return no(other, "a block"),
                    },
                };
                let then = self.stmts(&branch.then_branch.stmts)?;
                Ok(Stmt::If(self.cond(&branch.cond)?, then, other))
            }
            Expr::ForLoop(each) if each.expr.to_token_stream().to_string() == "Axis :: DOWN" => {
                let Pat::Ident(axis) = &*each.pat else { return no(&each.pat, "a name") };
                self.axis = axis.ident.to_string();
                let body = self.stmts(&each.body.stmts)?;
                self.axis.clear();
                Ok(Stmt::Axes(body))
            }
            expr => no(expr, "an if, `for axis in Axis::DOWN` or `word |= ..`"),
        }
    }

    fn value(&self, expr: &Expr) -> Result<(Value, bool), Refused> {
        if let Ok(number) = self.number(expr) {
            return Ok((Value::Number(number), false));
        }
        if let Expr::Binary(shift) = expr
            && matches!(shift.op, BinOp::Shl(_))
            && self.number(&shift.right)?.value == Some(8)
        {
            return Ok((self.value(&shift.left)?.0, true));
        }
        let Expr::Call(call) = expr else { return no(expr, "a number, `u16::from(..)`, `<< 8`") };
        if call.func.to_token_stream().to_string() != "u16 :: from" {
            return no(&call.func, "u16::from");
        }
        let [Expr::MethodCall(inner)] = &call.args.iter().collect::<Vec<_>>()[..] else {
            return no(&call.args, "a byte of the machine or an axis's bit");
        };
        if inner.method == "bit" {
            return match &*inner.receiver {
                Expr::MethodCall(axis) => {
                    let name = axis.method.to_string();
                    match self.leaves.get(&name) {
                        Some(Leaf::Axis(_)) => Ok((Value::Bit(Some(name)), false)),
                        _ => no(axis, "a leaf that is an axis"),
                    }
                }
                axis if !self.axis.is_empty() && path(axis).as_ref() == Some(&self.axis) => {
                    Ok((Value::Bit(None), false))
                }
                axis => no(axis, "the loop's axis or a leaf that is one"),
            };
        }
        let name = inner.method.to_string();
        match self.leaves.get(&name) {
            Some(Leaf::Byte(_)) => Ok((Value::Byte(name), false)),
            _ => no(inner, "a leaf that is a byte"),
        }
    }

    fn cond(&self, expr: &Expr) -> Result<Cond, Refused> {
        match expr {
            Expr::MethodCall(call) if path(&call.receiver).as_deref() == Some("m") => {
                let name = call.method.to_string();
                let of_axis = match call.args.first() {
                    None => true,
                    Some(axis) => !self.axis.is_empty() && path(axis).as_ref() == Some(&self.axis),
                };
                match self.leaves.get(&name) {
                    Some(Leaf::Any(..) | Leaf::Is(_) | Leaf::Code(..)) if of_axis => {
                        Ok(Cond::Leaf(name))
                    }
                    _ => no(call, "a leaf that is true or not, of the loop's axis"),
                }
            }
            Expr::Call(call) => match path(&call.func) {
                Some(name) if self.functions.contains(&name) => Ok(Cond::Call(name)),
                _ => no(call, "a function of this file"),
            },
            Expr::Binary(equal) if matches!(equal.op, BinOp::Eq(_)) => {
                Ok(Cond::Is(self.byte(&equal.left)?, self.number(&equal.right)?))
            }
            Expr::Macro(matches) if matches.mac.path.is_ident("matches") => {
                let args = |input: syn::parse::ParseStream<'_>| {
                    let byte = input.parse::<Expr>()?;
                    input.parse::<syn::Token![,]>()?;
                    Ok((byte, input.parse::<syn::ExprRange>()?))
                };
                let (byte, range) = matches.mac.parse_body_with(args)?;
                let (Some(first), Some(last)) = (&range.start, &range.end) else {
                    return no(&range, "FIRST..=LAST");
                };
                if !matches!(range.limits, syn::RangeLimits::Closed(_)) {
                    return no(&range, "FIRST..=LAST");
                }
                Ok(Cond::Within(self.byte(&byte)?, self.number(first)?, self.number(last)?))
            }
            expr => no(expr, "a leaf, a function, `==`, `matches!`"),
        }
    }

    fn byte(&self, expr: &Expr) -> Result<String, Refused> {
        let name = match expr {
            Expr::MethodCall(call) => call.method.to_string(),
            expr => return no(expr, "a leaf that is a byte"),
        };
        match self.leaves.get(&name) {
            Some(Leaf::Byte(_)) => Ok(name),
            _ => no(expr, "a leaf that is a byte"),
        }
    }

    fn number(&self, expr: &Expr) -> Result<Number, Refused> {
        match expr {
            Expr::Lit(literal) => {
                let Lit::Int(number) = &literal.lit else { return no(literal, "a number") };
                let value = number.base10_parse::<u16>()?;
                Ok(Number { text: value.to_string(), value: Some(value) })
            }
            Expr::Binary(shift) if matches!(shift.op, BinOp::Shl(_)) => {
                let [left, right] = [self.number(&shift.left)?, self.number(&shift.right)?];
                let value = left.value.zip(right.value);
                let Some(value) = value.and_then(|(a, b)| a.checked_shl(b.into())) else {
                    return no(shift, "a number");
                };
                Ok(Number { text: value.to_string(), value: Some(value) })
            }
            expr => match path(expr).and_then(|name| self.constants.get(&name)) {
                Some(name) => Ok(Number { text: name.clone(), value: None }),
                None => no(expr, "a number or a constant of this file"),
            },
        }
    }
}

fn tail(block: &Block) -> Result<&Expr, Refused> {
    match &block.stmts[..] {
        [RustStmt::Expr(expr, None)] => Ok(expr),
        _ => no(block, "one expression"),
    }
}
