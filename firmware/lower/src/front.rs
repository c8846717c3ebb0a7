//! Functions of the subset from Rust: statements. [`items`] has what a file and its functions say of themselves,
//! [`value`] reads values and conditions.

mod items;
mod value;

pub use items::{About, Rules, about, rules};

use std::collections::{BTreeMap, BTreeSet};

use quote::ToTokens;
use syn::{Block, Expr as Rust, File, Item, ItemFn, Lit, Pat, Stmt as RustStmt};

use crate::Refused;
use crate::leaf::{Kind, Leaves, Type, micro};
use crate::tree::{End, Expr, Function, Number, Order, Size, Stmt, Tried, Var};

/// What is read along the way.
pub(crate) struct Reader<'a> {
    /// The file's name.
    module: &'a str,
    leaves: &'a Leaves,
    rules: &'a Rules,
    /// Constants of the file.
    constants: BTreeMap<String, Number>,
    vars: Vec<Type>,
    names: BTreeMap<String, Var>,
    /// Names of words that bits are put into.
    words: BTreeSet<String>,
    gives: Type,
}

pub(crate) fn no<T>(
    place: &(impl syn::spanned::Spanned + ToTokens),
    wanted: &str,
) -> Result<T, Refused> {
    let text = place.to_token_stream().to_string();
    Err(Refused::at(place, format!("`{text}` is not of the subset: {wanted}")))
}

/// The functions of a file.
///
/// # Errors
/// Something is not of the subset.
pub fn read(
    file: &File,
    module: &str,
    leaves: &Leaves,
    rules: &Rules,
) -> Result<Vec<Function>, Refused> {
    let mut reader = Reader {
        module,
        leaves,
        rules,
        constants: BTreeMap::new(),
        vars: Vec::new(),
        names: BTreeMap::new(),
        words: BTreeSet::new(),
        gives: Type::Nothing,
    };
    for item in &file.items {
        match item {
            // What rustc checks, and rows for others.
            Item::Macro(_) => {}
            Item::Const(constant) if constant.ident == "_" => {}
            Item::Const(constant) => {
                let name = micro(&constant.attrs)?.and_then(|mut said| said.remove("name"));
                let number = match (&*constant.expr, name) {
                    (_, Some(text)) => Number { text, value: None, wide: false },
                    (Rust::Lit(_), None) => reader.number(&constant.expr)?,
                    _ => {
                        return no(
                            constant,
                            "a constant is a number or says its name in the assembler, `micro(\"NAME\")`",
                        );
                    }
                };
                reader.constants.insert(constant.ident.to_string(), number);
            }
            Item::Mod(file) if file.content.is_none() => {}
            Item::Fn(_) | Item::Use(_) | Item::Trait(_) | Item::Impl(_) => {}
            item => return no(item, "functions, constants, traits of leaves, use"),
        }
    }
    let functions = file.items.iter().filter_map(|item| match item {
        Item::Fn(function) => Some(function),
        _ => None,
    });
    functions.map(|function| reader.function(function)).collect()
}

pub(crate) fn path(expr: &Rust) -> Option<String> {
    let Rust::Path(path) = expr else { return None };
    Some(path.path.get_ident()?.to_string())
}

/// `F_SOFT_LIMIT` of `SoftLimit`.
fn upper(prefix: &str, name: &str) -> String {
    let words = name.chars().flat_map(|c| c.is_uppercase().then_some('_').into_iter().chain([c]));
    format!("{prefix}{}", words.collect::<String>().to_uppercase())
}

/// The symbol of what a function fails with: `Fault::SoftLimit`, `Exception::Busy`.
pub(crate) fn failure(expr: &Rust) -> Option<String> {
    item(expr, "Fault").or_else(|| item(expr, "Exception"))
}

/// The symbol of an item of an enum: `Fault::SoftLimit`, `TraceKind::Home`.
pub(crate) fn item(expr: &Rust, of: &str) -> Option<String> {
    let Rust::Path(path) = expr else { return None };
    let mut names = path.path.segments.iter().map(|segment| segment.ident.to_string());
    let (kind, name) = (names.next()?, names.next()?);
    let prefix = match of {
        "Fault" => "F",
        "Exception" => "EX",
        _ => "TRACE",
    };
    (kind == of && names.next().is_none()).then(|| upper(prefix, &name))
}

impl Reader<'_> {
    fn var(&mut self, name: &str, kind: Type) -> Var {
        self.vars.push(kind);
        self.names.insert(name.to_owned(), self.vars.len() - 1);
        self.vars.len() - 1
    }

    fn function(&mut self, function: &ItemFn) -> Result<Function, Refused> {
        let name = function.sig.ident.to_string();
        let rule = &self.rules[&format!("{}::{name}", self.module)];
        (self.vars, self.names, self.words) = Default::default();
        self.gives = rule.gives;
        let takes = rule.takes.iter().map(|(name, kind)| (self.var(name, *kind), *kind)).collect();
        words(&function.block, &mut self.words);
        let list = |key: &str| {
            let text = rule.said.get(key).map_or("", String::as_str);
            text.split(", ").filter(|one| !one.is_empty()).map(str::to_owned).collect::<Vec<_>>()
        };
        let mut body = self.block(&function.block, true)?;
        let within = rule.said.contains_key("within");
        if rule.gives == Type::Nothing && !within {
            ended(&mut body);
        }
        Ok(Function {
            name,
            label: rule.label.clone(),
            takes,
            gives: rule.gives,
            holds: rule.holds,
            record: rule.said.get("of").cloned(),
            entry: rule.said.contains_key("entry"),
            begins: rule.said.get("begins").cloned(),
            zero: rule.zero,
            longs: list("longs"),
            bytes: list("bytes"),
            vars: self.vars.clone(),
            within,
            body,
            line: function.sig.ident.span().start().line,
        })
    }

    /// Statements; the value of the last one is the function's when `last`.
    fn block(&mut self, block: &Block, last: bool) -> Result<Vec<Stmt>, Refused> {
        let mut stmts = Vec::new();
        for (n, stmt) in block.stmts.iter().enumerate() {
            let last = last && n + 1 == block.stmts.len();
            match stmt {
                RustStmt::Expr(expr, None) if last => stmts.push(self.end(expr)?),
                stmt => stmts.push(self.stmt(stmt, last)?),
            }
        }
        Ok(stmts)
    }

    fn other(&mut self, branch: &syn::ExprIf, last: bool) -> Result<Vec<Stmt>, Refused> {
        match &branch.else_branch {
            None => Ok(Vec::new()),
            Some((_, other)) => match &**other {
                Rust::Block(block) => self.block(&block.block, last),
                other if last => Ok(vec![self.end(other)?]),
                Rust::If(other) => Ok(vec![self.branch(other, last)?]),
                other => no(other, "a block"),
            },
        }
    }

    fn branch(&mut self, branch: &syn::ExprIf, last: bool) -> Result<Stmt, Refused> {
        let cond = self.cond(&branch.cond)?;
        let then = self.block(&branch.then_branch, last)?;
        Ok(Stmt::If(cond, then, self.other(branch, last)?))
    }

    fn stmt(&mut self, stmt: &RustStmt, last: bool) -> Result<Stmt, Refused> {
        match stmt {
            RustStmt::Local(local) => self.local(local),
            RustStmt::Expr(expr, _) => match expr {
                Rust::Assign(set) => {
                    let Some(&var) = path(&set.left).and_then(|name| self.names.get(&name)) else {
                        return no(&set.left, "a variable");
                    };
                    Ok(Stmt::Set(var, self.value(&set.right)?.0))
                }
                Rust::Binary(or) if matches!(or.op, syn::BinOp::BitOrAssign(_)) => {
                    let Some(&var) = path(&or.left).and_then(|name| self.names.get(&name)) else {
                        return no(&or.left, "a word");
                    };
                    Ok(Stmt::Or(var, self.value(&or.right)?.0))
                }
                Rust::If(branch) => self.branch(branch, last && self.gives == Type::Nothing),
                Rust::ForLoop(each) => {
                    let order = match each.expr.to_token_stream().to_string().as_str() {
                        "Axis :: DOWN" => Order::Down,
                        "Axis :: UP" => Order::Up,
                        "Axis :: FOUR" => Order::Four,
                        _ => return no(&each.expr, "Axis::DOWN, Axis::UP, Axis::FOUR"),
                    };
                    let Pat::Ident(axis) = &*each.pat else { return no(&each.pat, "a name") };
                    let var = self.var(&axis.ident.to_string(), Type::Axis);
                    Ok(Stmt::Axes(order, var, self.block(&each.body, false)?))
                }
                Rust::Loop(each) => Ok(Stmt::Loop(self.block(&each.body, false)?)),
                Rust::Continue(_) => Ok(Stmt::Continue),
                Rust::Return(back) => match &back.expr {
                    None => Ok(Stmt::Return(End::Nothing)),
                    Some(expr) => self.end(expr),
                },
                Rust::Match(of) => self.choice(of, last && self.gives == Type::Nothing),
                Rust::Try(tried) => match &*tried.expr {
                    Rust::MethodCall(map) if map.method == "map_err" => {
                        let to = map.args.first().map(|to| to.to_token_stream().to_string());
                        if to.as_deref() != Some("| _ | Exception :: IllegalValue") {
                            return no(map, "map_err(|_| Exception::IllegalValue)");
                        }
                        Ok(Stmt::Call(self.call(&map.receiver)?, Tried::Refuses))
                    }
                    call => Ok(Stmt::Call(self.call(call)?, Tried::Ends)),
                },
                expr => self.action(expr),
            },
            stmt => no(stmt, "let, an assignment, a call, if, match, for, loop, return"),
        }
    }

    /// A call whose result is not looked at: a leaf that writes among them.
    fn action(&mut self, expr: &Rust) -> Result<Stmt, Refused> {
        if let Rust::MethodCall(call) = expr
            && path(&call.receiver).as_deref() == Some("m")
            && let Some(leaf) = self.leaves.get(&call.method.to_string())
        {
            let place = match &leaf.kind {
                Kind::Place(..) => {
                    let (axis, value) = self.arguments(call)?;
                    let Some(value) = value else { return no(call, "a leaf that writes") };
                    let mut place = self.place(leaf, axis);
                    if let Some((_, kind)) = leaf.takes.last() {
                        place.size = size(*kind);
                    }
                    let value = match value {
                        Expr::Number(_) if place.size == Size::Long => Expr::Wide(Box::new(value)),
                        value => value,
                    };
                    return Ok(Stmt::Put(place, value));
                }
                Kind::Bit(byte, Some(on)) => Some((byte.clone(), *on)),
                _ => None,
            };
            if let Some((byte, on)) = place {
                let (Some(axis), None) = self.arguments(call)? else { return no(call, "an axis") };
                return Ok(Stmt::Bit(byte, axis, on));
            }
        }
        Ok(Stmt::Call(self.call(expr)?, Tried::Never))
    }

    /// Statements and the value behind them.
    fn ended(&mut self, block: &Block) -> Result<(Vec<Stmt>, Expr, Option<Type>), Refused> {
        let Some((RustStmt::Expr(last, None), stmts)) = block.stmts.split_last() else {
            return no(block, "a value at the end");
        };
        let stmts = stmts.iter().map(|stmt| self.stmt(stmt, false)).collect::<Result<_, _>>()?;
        let (value, kind) = self.value(last)?;
        Ok((stmts, value, kind))
    }

    fn local(&mut self, local: &syn::Local) -> Result<Stmt, Refused> {
        let (mut pat, mut kind) = (&local.pat, None);
        if let Pat::Type(typed) = pat {
            kind = crate::leaf::type_of(&typed.ty.to_token_stream().to_string());
            pat = &typed.pat;
        }
        if let (Pat::Wild(_), Some(init)) = (pat, &local.init) {
            return Ok(Stmt::Call(self.call(&init.expr)?, Tried::Never));
        }
        let (Pat::Ident(name), Some(init)) = (pat, &local.init) else {
            return no(local, "`let name = ..;`");
        };
        let name = name.ident.to_string();
        if let Rust::If(branch) = &*init.expr
            && let Some((_, other)) = &branch.else_branch
            && let Rust::Block(other) = &**other
            && let cond = self.cond(&branch.cond)?
            && (branch.then_branch.stmts.len() > 1
                || other.block.stmts.len() > 1
                || cond.is_of_parts())
        {
            let (mut then, value, of) = self.ended(&branch.then_branch)?;
            let (mut other, also, _) = self.ended(&other.block)?;
            let var = self.var(&name, kind.or(of).unwrap_or(Type::Byte));
            then.push(Stmt::Set(var, value));
            other.push(Stmt::Set(var, also));
            return Ok(Stmt::If(cond, then, other));
        }
        let (value, of) = self.value(&init.expr)?;
        if self.words.contains(&name) {
            return Ok(Stmt::Word(self.var(&name, Type::Word), value));
        }
        let kind = kind.or(of).unwrap_or(Type::Byte);
        if !matches!(kind, Type::Byte | Type::Long | Type::Axis) {
            return no(local, "a variable is u8, i32 or an axis, or a word that bits are put into");
        }
        let var = self.var(&name, kind);
        Ok(if kind == Type::Axis { Stmt::Axis(var, value) } else { Stmt::Set(var, value) })
    }

    fn choice(&mut self, of: &syn::ExprMatch, last: bool) -> Result<Stmt, Refused> {
        let value = self.value(&of.expr)?.0;
        let (mut arms, mut other) = (Vec::new(), None);
        for arm in &of.arms {
            if arm.guard.is_some() || other.is_some() {
                return no(&arm.pat, "a constant, `_` last");
            }
            let body = match &*arm.body {
                Rust::Block(block) => self.block(&block.block, last)?,
                body if last => vec![self.end(body)?],
                body => vec![self.stmt(&RustStmt::Expr(body.clone(), None), false)?],
            };
            match &arm.pat {
                Pat::Wild(_) => other = Some(body),
                Pat::Ident(name) => match self.constants.get(&name.ident.to_string()) {
                    Some(number) => arms.push((number.clone(), body)),
                    None => return no(&arm.pat, "a constant of this file"),
                },
                Pat::Lit(number) => arms.push((self.number(&Rust::Lit(number.clone()))?, body)),
                pat => return no(pat, "a constant, `_` last"),
            }
        }
        match other {
            Some(other) => Ok(Stmt::Match(value, arms, other)),
            None => no(of, "`_` last"),
        }
    }

    /// The function's result.
    fn end(&mut self, expr: &Rust) -> Result<Stmt, Refused> {
        match expr {
            Rust::If(branch) => return self.branch(branch, true),
            Rust::Match(of) => return self.choice(of, true),
            Rust::Return(_) | Rust::ForLoop(_) | Rust::Loop(_) | Rust::Assign(_) => {
                return self.stmt(&RustStmt::Expr(expr.clone(), None), true);
            }
            _ => {}
        }
        if path(expr).as_deref() == Some("DONE") {
            return Ok(Stmt::Return(End::Done));
        }
        if path(expr).as_deref() == Some("NOT_YET") {
            return Ok(Stmt::Return(End::NotYet));
        }
        if let Rust::Call(call) = expr
            && let Some(name) = path(&call.func)
            && let Some(argument) = call.args.first()
        {
            match name.as_str() {
                "Ok" if matches!(argument, Rust::Tuple(unit) if unit.elems.is_empty()) => {
                    return Ok(Stmt::Return(End::Done));
                }
                "Err" => {
                    let Some(fault) = failure(argument) else {
                        return no(argument, "Fault::.., Exception::..");
                    };
                    return Ok(Stmt::Return(End::Fault(fault)));
                }
                _ => {}
            }
        }
        Ok(match self.gives {
            Type::Nothing => match self.action(expr)? {
                Stmt::Call(call, _) => Stmt::Return(End::Value(Expr::Call(call))),
                stmt => stmt,
            },
            Type::Bool => Stmt::Return(End::Cond(Box::new(self.cond(expr)?))),
            Type::Fault | Type::Progress => Stmt::Return(End::Value(Expr::Call(self.call(expr)?))),
            _ => Stmt::Return(End::Value(self.value(expr)?.0)),
        })
    }

    fn number(&self, expr: &Rust) -> Result<Number, Refused> {
        match expr {
            Rust::Lit(literal) => {
                let Lit::Int(number) = &literal.lit else { return no(literal, "a number") };
                Ok(Number::of(number.base10_parse::<u16>()?))
            }
            Rust::Paren(inner) => self.number(&inner.expr),
            Rust::Binary(pair) => {
                let [left, right] = [self.number(&pair.left)?, self.number(&pair.right)?];
                let op = pair.op.to_token_stream().to_string();
                let values = left.value.zip(right.value);
                if let Some((a, b)) = values {
                    let value = match op.as_str() {
                        "<<" => a.checked_shl(b.into()),
                        "|" => Some(a | b),
                        "+" => a.checked_add(b),
                        "-" => a.checked_sub(b),
                        _ => None,
                    };
                    return match value {
                        Some(value) => Ok(Number::of(value)),
                        None => no(pair, "a number"),
                    };
                }
                if !matches!(op.as_str(), "|" | "+" | "-") {
                    return no(pair, "a number");
                }
                let text = format!("({}{op}{})", left.text, right.text);
                Ok(Number { text, value: None, wide: left.wide || right.wide })
            }
            expr => match path(expr).and_then(|name| self.constants.get(&name)) {
                Some(number) => Ok(number.clone()),
                None => no(expr, "a number or a constant of this file"),
            },
        }
    }
}

/// Statements behind which a function without a result ends: a call returns in its place.
fn ended(stmts: &mut Vec<Stmt>) {
    let end = match stmts.pop() {
        Some(Stmt::Return(end)) => end,
        Some(Stmt::Call(call, Tried::Never)) if call.when.is_none() => End::Value(Expr::Call(call)),
        // What only parts have goes on behind it.
        Some(Stmt::If(cond, mut then, mut other)) if !cond.is_of_parts() => {
            ended(&mut then);
            if !other.is_empty() {
                ended(&mut other);
            }
            stmts.push(Stmt::If(cond, then, other));
            End::Nothing
        }
        last => {
            stmts.extend(last);
            End::Nothing
        }
    };
    stmts.push(Stmt::Return(end));
}

/// Of a place of this type.
fn size(kind: Type) -> Size {
    match kind {
        Type::Byte => Size::Byte,
        Type::Word => Size::Word,
        _ => Size::Long,
    }
}

/// Names of words that bits are put into.
fn words(block: &Block, to: &mut BTreeSet<String>) {
    let text = block.to_token_stream().to_string();
    let parts = text.split(" |= ").collect::<Vec<_>>();
    for part in &parts[..parts.len().saturating_sub(1)] {
        to.extend(part.rsplit(' ').next().map(str::to_owned));
    }
}
