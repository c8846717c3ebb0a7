//! Declarations: CONST, INPUT, OUTPUT, DIM, KEEP, TABLE, parameters, SUBs and FUNCTIONs.

use super::expr::value_of;
use super::names::Entity;
use super::{Checker, MAIN, kinds, range};
use crate::front::ast::{Block, Expr, ExprKind, KindRef, Name, Stmt, StmtKind, Variable};
use crate::front::codes::Code;
use crate::front::diag::Diag;
use crate::front::span::Span;
use crate::front::words::Func;
use crate::hir::{self, RoutineId, Storage, TableId, VarId};
use crate::kind::Kind;
use std::rc::Rc;

/// First holding register of the variables (firmware/README.md, Link).
const FIRST_REGISTER: i32 = 3000;
/// Largest array: far more than any device has, small enough that sums of sizes stay in range.
const MAX_ARRAY: i32 = 100_000;
/// KEEP values that the device stores.
const MAX_KEEPS: u8 = 8;

impl<'a> Checker<'a> {
    /// Declares every name, the main program's first: they are visible in all routines.
    pub(super) fn declare_all(&mut self) {
        let profile = self.profile;
        for input in &profile.inputs {
            if let Some(name) = &input.name {
                self.names.predeclare(name, Entity::Port(false, Some(input.n)));
            }
        }
        for output in &profile.outputs {
            if let Some(name) = &output.name {
                self.names.predeclare(name, Entity::Port(true, Some(output.n)));
            }
        }
        for analog in &profile.analogs {
            if let Some(name) = &analog.name {
                self.names.predeclare(name, Entity::Analog(false, Some(analog.n)));
            }
        }
        for aout in &profile.aouts {
            if let Some(name) = &aout.name {
                self.names.predeclare(name, Entity::Analog(true, Some(aout.n)));
            }
        }
        let script = self.script;
        for (i, routine) in script.routines.iter().enumerate() {
            let id = RoutineId(i as u32 + 1);
            self.declare(&routine.name, Entity::Routine(id));
            if routine.is_function {
                self.infos[i + 1].result = Some(routine.result.map_or(Kind::Number, |r| r.kind));
            }
        }
        for (id, body) in self.bodies() {
            self.scope = id;
            if let Some(routine) = self.routine(id) {
                for param in &routine.params {
                    let kind = kind_or_open(param.kind);
                    let storage = Storage::Local(id);
                    let var = self.add_var(&param.name.text, kind, param.name.span, storage);
                    if param.kind.is_none() {
                        self.open.push(var);
                    }
                    self.infos[id.0 as usize].locals.pop();
                    self.infos[id.0 as usize].params.push(var);
                    self.declare(&param.name, Entity::Var(var));
                }
            }
            self.declare_block(body);
        }
        self.scope = MAIN;
    }

    fn declare(&mut self, name: &'a Name, entity: Entity) {
        if let Err(first) = self.names.declare(self.scope, name, entity) {
            // SUBs are declared before the rest: the first one is the one that stands first.
            let other = first.unwrap_or(name.span);
            let (first, again) = match other.start < name.span.start {
                true => (other, name.span),
                false => (name.span, other),
            };
            let message = format!("`{}` is declared twice", name.text);
            let mut diag = Diag::new(Code::DeclaredTwice, again, message)
                .hint("give one of them another name");
            if first != again {
                diag = diag.label(first, "first declared here");
            }
            self.diags.push(diag);
        }
    }

    fn declare_block(&mut self, block: &'a Block) {
        for stmt in block {
            self.declare_stmt(stmt);
            for inner in stmt.blocks() {
                self.declare_block(inner);
            }
        }
    }

    fn declare_stmt(&mut self, stmt: &'a Stmt) {
        match &stmt.kind {
            StmtKind::Const(list) => {
                for (name, value) in list {
                    let folded = self.constant(value);
                    let kind = folded.map_or(Kind::Number, |(kind, _)| kind);
                    self.declare(name, Entity::Const(kind, folded.map(|(_, value)| value)));
                }
            }
            StmtKind::Port { output, ports } => {
                for (name, value) in ports {
                    let what = if *output { "OUTPUT" } else { "INPUT" };
                    let n = self.plain_constant(value, what);
                    let n = n.filter(|&n| self.check_port(*output, n, value.span));
                    if let Some(n) = n {
                        let name = name.text.to_string();
                        self.ports.push(hir::Port { output: *output, n, name });
                    }
                    self.declare(name, Entity::Port(*output, n));
                }
            }
            StmtKind::Analog(list) => {
                for (name, value) in list {
                    let n = self.plain_constant(value, "ANALOG");
                    let n = n.filter(|&n| self.check_analog(n, value.span));
                    self.analogs.extend(n.map(|n| (name.text.to_string(), n)));
                    self.declare(name, Entity::Analog(false, n));
                }
            }
            StmtKind::Dim(variables) => {
                for variable in variables {
                    self.dim(variable);
                }
            }
            StmtKind::Keep(variables) => {
                for variable in variables {
                    self.keep(variable);
                }
            }
            StmtKind::Table { name, width, columns, rows } => {
                self.table(name, width.as_deref(), columns, rows);
            }
            _ => {}
        }
    }

    fn dim(&mut self, variable: &'a Variable) {
        let name = &variable.name;
        let limits = [&variable.least, &variable.greatest]
            .map(|limit| limit.as_ref().and_then(|limit| Some((limit, self.constant(limit)?))));
        // What a limit is fixes the kind as the first assignment does.
        let fixed = limits.iter().flatten().map(|(_, (kind, _))| *kind).next();
        let kind = variable.kind.map(|k| k.kind).or(fixed).unwrap_or(Kind::Number);
        let storage = match &variable.at {
            _ if self.scope != MAIN && variable.at.is_none() => Storage::Local(self.scope),
            None => Storage::Global,
            Some(at) => self.register(variable, at),
        };
        let var = self.add_var(&name.text, kind, name.span, storage);
        if variable.kind.is_none() && fixed.is_none() {
            self.open.push(var);
        }
        if variable.timer {
            self.dim_timer(variable, var);
        }
        self.panel(variable, var, limits);
        if let Some(size) = &variable.size {
            let len = self.plain_constant(size, "the size of an array").unwrap_or(1);
            if !(1..=MAX_ARRAY).contains(&len) {
                self.error(
                    Code::ArraySize,
                    size.span,
                    format!("an array of {len} values"),
                    format!("an array has 1 to {MAX_ARRAY} values; `DIM a(8)` has a(0) to a(7)"),
                );
            }
            self.vars[var.0 as usize].len = len.clamp(1, MAX_ARRAY) as u32;
            self.vars[var.0 as usize].array = true;
        }
        self.declare(name, Entity::Var(var));
        if let Storage::At(_) = storage {
            // The link reads and writes it.
            self.names.take(self.scope, &name.key);
            self.check_overlap(name.span);
        }
    }

    /// LABEL, MIN and MAX of a variable, the limits with their values.
    fn panel(
        &mut self,
        variable: &'a Variable,
        var: VarId,
        limits: [Option<(&'a Expr, (Kind, i32))>; 2],
    ) {
        let label = variable.label.as_ref();
        let first = [&variable.least, &variable.greatest].into_iter().flatten().next();
        if variable.at.is_none()
            && let Some(span) = label.map(|text| text.span).or(first.map(|limit| limit.span))
        {
            self.error(
                Code::BadAt,
                span,
                format!("`{}` is no variable of a panel", variable.name.text),
                "LABEL, MIN and MAX belong to a variable with AT: `DIM qty AT 3000 MIN 1 MAX 500`",
            );
            return;
        }
        let kind = self.vars[var.0 as usize].kind;
        for (limit, (own, _)) in limits.into_iter().flatten() {
            if own != kind && !(kinds::is_plain(own) && kinds::is_plain(kind)) {
                let message = format!(
                    "`{}` is {}, its limit {}",
                    variable.name.text,
                    kinds::a(kind),
                    kinds::a(own)
                );
                let hint = "MIN and MAX have the kind of their variable";
                self.error(Code::ArgumentKind, limit.span, message, hint);
            }
        }
        let mut panel =
            hir::Panel { label: label.map(|text| text.text.clone()), ..Default::default() };
        if let Some((_, (_, least))) = limits[0] {
            panel.limits.least = least;
        }
        if let Some((limit, (_, greatest))) = limits[1] {
            panel.limits.greatest = greatest;
            if greatest < panel.limits.least {
                let message = format!("no value of `{}` is allowed", variable.name.text);
                self.error(Code::BadAt, limit.span, message, "MAX is at least MIN");
            }
        }
        self.vars[var.0 as usize].panel = panel;
    }

    /// The register behind AT.
    fn register(&mut self, variable: &'a Variable, at: &'a Expr) -> Storage {
        if self.scope != MAIN {
            self.error(
                Code::BadAt,
                at.span,
                format!("`{}` has an address but is local", variable.name.text),
                "declare it outside the SUB: a local's cell is shared",
            );
            return Storage::Local(self.scope);
        }
        let Some(address) = self.plain_constant(at, "AT") else { return Storage::Global };
        match u16::try_from(address) {
            Ok(register) if address >= FIRST_REGISTER && address % 2 == 0 => Storage::At(register),
            _ => {
                self.error(
                    Code::BadAt,
                    at.span,
                    format!("no variable can stand at register {address}"),
                    format!(
                        "addresses are even, from {FIRST_REGISTER} on: two registers a variable"
                    ),
                );
                Storage::Global
            }
        }
    }

    /// The variable added last must not overlap an earlier one.
    fn check_overlap(&mut self, span: Span) {
        let registers = |var: &hir::Var| match var.storage {
            Storage::At(at) => Some(u32::from(at)..u32::from(at) + 2 * var.len),
            _ => None,
        };
        let Some((last, earlier)) = self.vars.split_last() else { return };
        let Some(own) = registers(last) else { return };
        let clash = earlier.iter().find_map(|var| {
            let other = registers(var)?;
            (own.start < other.end && other.start < own.end).then(|| var.clone())
        });
        if let Some(var) = clash {
            let diag = Diag::new(
                Code::BadAt,
                span,
                format!("register {} is taken by `{}`", own.start, var.name),
            )
            .label(Span::new(var.span.start as u32, var.span.end as u32), "declared here")
            .hint("give each variable registers of its own");
            self.diags.push(diag);
        }
    }

    fn keep(&mut self, variable: &'a Variable) {
        let name = &variable.name;
        let kind = variable.kind.map_or(Kind::Number, |k| k.kind);
        if variable.timer {
            let hint = "it counts in a run: `DIM name AS TIMER`";
            let message = format!("`{}` is a TIMER and can not be kept", name.text);
            self.error(Code::BadKeep, name.span, message, hint);
        }
        if self.scope != MAIN {
            self.error(
                Code::BadKeep,
                name.span,
                format!("KEEP `{}` stands inside a SUB", name.text),
                "declare it outside: there is one for the whole script",
            );
        }
        let extras = [&variable.at, &variable.least, &variable.greatest];
        let extra = extras.into_iter().flatten().next().map(|extra| extra.span);
        if let Some(extra) = extra.or(variable.label.as_ref().map(|label| label.span)) {
            let hint = "KEEP values stand at holding registers 4000 on";
            self.error(Code::BadKeep, extra, "KEEP takes a name, and the size of an array", hint);
        }
        let size = variable.size.as_ref();
        let len = size.map_or(Some(1), |size| self.plain_constant(size, "the size of an array"));
        let len = len.unwrap_or(1);
        if let (Some(size), ..1) = (size, len) {
            let hint = "`KEEP a(4)` has a(0) to a(3)";
            self.error(Code::ArraySize, size.span, format!("an array of {len} values"), hint);
        }
        let len = len.clamp(1, MAX_ARRAY) as u32;
        if u32::from(self.keeps) + len > MAX_KEEPS.into() {
            self.error(
                Code::BadKeep,
                name.span,
                match size {
                    Some(_) => format!("`{}` has more values than can be kept", name.text),
                    None => format!("`{}` is one KEEP too many", name.text),
                },
                format!("the device keeps {MAX_KEEPS} values; pack two small ones into one"),
            );
            self.keeps = 0;
        }
        let var = self.add_var(&name.text, kind, name.span, Storage::Keep(self.keeps));
        self.vars[var.0 as usize].len = len;
        self.vars[var.0 as usize].array = size.is_some();
        self.keeps = self.keeps.saturating_add(len.min(MAX_KEEPS.into()) as u8);
        self.declare(name, Entity::Var(var));
    }

    fn table(
        &mut self,
        name: &'a Name,
        width: Option<&'a Expr>,
        names: &[Rc<str>],
        rows: &'a [Vec<Expr>],
    ) {
        let columns = match width {
            None => names.len().max(1) as i32,
            Some(width) => self.plain_constant(width, "the number of columns").unwrap_or(1),
        };
        if let (None, [], [_, second, ..]) = (width, names, rows) {
            let span = second.first().map_or(name.span, |e| e.span);
            let hint = format!(
                "write `TABLE {}({}) = ...`, or names for the columns",
                name.text,
                second.len()
            );
            self.error(Code::TableShape, span, "rows without the number of columns", hint);
        }
        if columns < 1 {
            let span = width.map_or(name.span, |w| w.span);
            let hint = "write how many values a row has: `TABLE t(2) = 1, 2; 3, 4`";
            self.error(Code::TableShape, span, format!("a table with {columns} columns"), hint);
        }
        let columns = columns.max(1) as usize;
        let mut column_kinds: Vec<Option<Kind>> = vec![None; columns.min(rows_width(rows))];
        let mut values = Vec::new();
        let mut ok = true;
        for row in rows {
            if columns > 1 && row.len() != columns {
                let span = row.first().map_or(name.span, |e| e.span);
                self.error(
                    Code::TableShape,
                    span,
                    format!("a row of `{}` has {} values, not {columns}", name.text, row.len()),
                    "rows are parted by `;`, values by `,`",
                );
                ok = false;
                continue;
            }
            for (i, cell) in row.iter().enumerate() {
                let Some((kind, value)) = self.constant(cell) else {
                    ok = false;
                    continue;
                };
                values.push(value);
                let Some(slot) = column_kinds.get_mut(i % columns) else { continue };
                *slot = match *slot {
                    None => Some(kind),
                    Some(known) if kinds::is_plain(known) && kinds::is_plain(kind) => {
                        Some(if known == kind { kind } else { Kind::Number })
                    }
                    Some(known) if known == kind => Some(kind),
                    Some(known) => {
                        self.error(
                            Code::TableKinds,
                            cell.span,
                            format!(
                                "column {} of `{}` holds {known}, this is {}",
                                i % columns,
                                name.text,
                                kinds::a(kind)
                            ),
                            "a column has one kind; a table of mixed kinds needs columns: `TABLE t(2) = ...`",
                        );
                        ok = false;
                        Some(known)
                    }
                };
            }
        }
        if ok && values.is_empty() {
            self.error(
                Code::TableShape,
                name.span,
                format!("`{}` has no values", name.text),
                "write `TABLE t = 1, 2, 3`",
            );
        }
        let id = TableId(self.tables.len() as u32);
        self.tables.push(hir::Table {
            name: name.text.to_string(),
            columns: column_kinds.len().max(1) as u32,
            names: names.iter().map(|name| name.to_string()).collect(),
            kinds: column_kinds.into_iter().map(|k| k.unwrap_or(Kind::Number)).collect(),
            values,
            span: range(name.span),
        });
        self.declare(name, Entity::Table(id));
    }

    /// Kind and value of an expression that must be constant.
    pub(super) fn constant(&mut self, expr: &'a Expr) -> Option<(Kind, i32)> {
        if let Some((span, what)) = self.not_constant(expr) {
            let hint = "only literals, CONSTs, COUNT, STEPS and LENGTH are known beforehand";
            self.error(Code::NotConstant, span, format!("{what} is not a constant"), hint);
            return None;
        }
        let folded = self.expr(expr)?;
        match folded.node {
            hir::ExprKind::Const(value) => Some((folded.kind, value)),
            _ => None,
        }
    }

    /// The value of an expression where it is known beforehand.
    pub(super) fn quiet_constant(&mut self, expr: &'a Expr) -> Option<i32> {
        if self.not_constant(expr).is_some() {
            return None;
        }
        self.expr(expr).as_ref().and_then(value_of)
    }

    /// A constant Number.
    pub(super) fn plain_constant(&mut self, expr: &'a Expr, what: &str) -> Option<i32> {
        let (kind, value) = self.constant(expr)?;
        if kinds::is_plain(kind) {
            return Some(value);
        }
        let message = format!("{what} needs a Number, this is {}", kinds::a(kind));
        self.error(Code::ArgumentKind, expr.span, message, "write a whole number without a unit");
        None
    }

    /// The first part of an expression that is only known at run time.
    fn not_constant(&self, expr: &'a Expr) -> Option<(Span, String)> {
        match &expr.kind {
            ExprKind::Literal { .. } | ExprKind::Axis(_) => None,
            ExprKind::Name(name) | ExprKind::Apply(name, _) => {
                match self.names.look(self.scope, &name.key) {
                    Some(Entity::Const(..) | Entity::Port(..) | Entity::Analog(..)) | None => None,
                    Some(_) => Some((name.span, format!("`{}`", name.text))),
                }
            }
            ExprKind::Builtin(func, args) => match func {
                Func::Count => None,
                Func::Abs
                | Func::Min
                | Func::Max
                | Func::Sgn
                | Func::Sqr
                | Func::Steps
                | Func::Length => args.iter().find_map(|arg| self.not_constant(arg)),
                _ => Some((expr.span, format!("{}()", func.text()))),
            },
            ExprKind::Unary(_, inner) => self.not_constant(inner),
            ExprKind::Binary(_, left, right) => {
                self.not_constant(left).or_else(|| self.not_constant(right))
            }
        }
    }
}

/// Values in the widest row: a bound for the columns that are worth remembering.
fn rows_width(rows: &[Vec<Expr>]) -> usize {
    rows.iter().map(Vec::len).max().unwrap_or(0).max(1)
}

/// An open kind stands as Number until inference settles it.
fn kind_or_open(kind: Option<KindRef>) -> Kind {
    kind.map_or(Kind::Number, |k| k.kind)
}
