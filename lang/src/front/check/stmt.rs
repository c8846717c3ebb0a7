//! Statements: lowering of blocks, assignments, calls, jumps, events.

use super::ends::Lit;
use super::labels::BlockId;
use super::names::Entity;
use super::{Checker, MAIN, argument, kinds, range};
use crate::called;
use crate::effect::Want;
use crate::front::ast::{Block, Enclosing, Expr, Name, Stmt, StmtKind};
use crate::front::codes::Code;
use crate::front::span::Span;
use crate::hir::{self, GosubTarget, LoopKind, Place};
use crate::kind::Kind;

/// Event handlers that can be armed together.
const MAX_EVENTS: u8 = 4;

/// What stands around the statement that is being lowered.
#[derive(Debug, Default)]
pub(super) struct Around {
    /// Open loops, innermost last, and whether an EXIT leaves them.
    pub loops: Vec<(LoopKind, bool)>,
    /// The block that it stands in.
    pub block: BlockId,
}

/// Whether control goes on behind a statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Then {
    GoesOn,
    Never,
}

/// A lowered statement, or several, and whether control goes on behind them.
pub(super) type Lowered = (Vec<hir::StmtKind>, Then);

impl<'a> Checker<'a> {
    /// Lowers all routines, the main program first.
    pub(super) fn lower_all(&mut self) -> Vec<hir::Block> {
        let mut bodies = Vec::new();
        for (id, body) in self.bodies() {
            self.scope = id;
            self.around = Around::default();
            let (mut block, _) = self.block(body);
            let prologue =
                if id == MAIN { self.gcode_prologue() } else { self.gcode_sub_prologue(id) };
            block.splice(0..0, prologue);
            bodies.push(block);
        }
        self.scope = MAIN;
        bodies
    }

    /// Lowers a block; says whether control reaches its end.
    pub(super) fn block(&mut self, block: &'a Block) -> (hir::Block, Then) {
        let outer = core::mem::replace(&mut self.around.block, self.labels.block(block));
        let mut lowered = Vec::with_capacity(block.len());
        let mut then = Then::GoesOn;
        let mut warned = false;
        let mut lit = Lit::default();
        let mut before = Span::point(0);
        for stmt in block {
            if matches!(stmt.kind, StmtKind::Label(_)) {
                then = Then::GoesOn;
            }
            // Where something is wrong, that may be why.
            let sure = !self.diags.has_errors();
            if then == Then::Never && !warned && sure && !is_declaration(stmt) {
                let hint = "remove it, or put a label before it that something goes to";
                self.error(Code::Unreachable, stmt.span, "nothing reaches this statement", hint);
                warned = true;
            }
            // Several may be parts of one of the text.
            let part = core::mem::replace(&mut before, stmt.span) == stmt.span;
            if !is_declaration(stmt) && !matches!(stmt.kind, StmtKind::Label(_)) && !part {
                self.statements += 1;
            }
            if !matches!(stmt.kind, StmtKind::Gcode(_)) {
                self.gcode.forget_position();
            }
            let Some((kinds, after)) = self.stmt(stmt) else { continue };
            if then == Then::GoesOn {
                then = after;
            }
            self.follow_outputs(&mut lit, &kinds, stmt.span);
            let place = |kind| hir::Stmt { line: stmt.line, span: range(stmt.span), kind };
            lowered.extend(kinds.into_iter().map(place));
        }
        self.around.block = outer;
        (lowered, then)
    }

    /// None after an error.
    fn stmt(&mut self, stmt: &'a Stmt) -> Option<Lowered> {
        let one = |kind| Some((vec![kind], Then::GoesOn));
        let last = |kind| Some((vec![kind], Then::Never));
        match &stmt.kind {
            StmtKind::Const(_)
            | StmtKind::Port { .. }
            | StmtKind::Analog(_)
            | StmtKind::Dim(_)
            | StmtKind::Keep(_)
            | StmtKind::Table { .. } => Some((Vec::new(), Then::GoesOn)),
            StmtKind::Label(name) => {
                let id = self.labels.id(self.scope, &name.key)?;
                let mut kinds = vec![hir::StmtKind::Label(id)];
                kinds.extend(self.gcode_label_prologue(id));
                Some((kinds, Then::GoesOn))
            }
            StmtKind::Assign { target, index, bit: None, value } => {
                one(self.assign(target, index, value)?)
            }
            StmtKind::Assign { target, index, bit: Some(bit), value } => {
                one(self.assign_bit(target, index, *bit, value, stmt)?)
            }
            StmtKind::Call { name, args } => one(self.call(name, args, stmt.span)?),
            StmtKind::If { .. }
            | StmtKind::Select { .. }
            | StmtKind::For { .. }
            | StmtKind::While { .. }
            | StmtKind::Do { .. }
            | StmtKind::Repeat { .. } => self.compound(stmt),
            StmtKind::Exit(what) => last(self.exit(*what, stmt.span)?),
            StmtKind::Continue(what) => {
                let kind = loop_kind(*what)?;
                self.enclosing(kind, "CONTINUE", stmt.span)?;
                last(hir::StmtKind::Continue(kind))
            }
            StmtKind::Goto(name) => {
                let label = self.jump(name, self.around.block)?;
                last(hir::StmtKind::Goto(label))
            }
            StmtKind::Gosub(name) => {
                let target = match self.sub_target(name) {
                    Some(target) => target?,
                    None => GosubTarget::Label(self.jump(name, self.around.block)?),
                };
                one(hir::StmtKind::Gosub(target))
            }
            StmtKind::Return(None) => last(hir::StmtKind::Return),
            StmtKind::Return(Some(value)) => last(self.return_value(value)?),
            StmtKind::End => last(hir::StmtKind::End),
            StmtKind::Run(name) => {
                if let Err(why) = called::check(&name.text) {
                    let hint =
                        "write the name that `pasapas list` shows, or the file's without .bas";
                    self.error(Code::BadProgram, name.span, why, hint);
                    return None;
                }
                // A handler may go on behind one that there is not.
                one(hir::StmtKind::Run(name.text.clone()))
            }
            StmtKind::OnError(None) => one(hir::StmtKind::OnError(None)),
            StmtKind::OnError(Some(name)) => {
                let label = self.handler_label(name)?;
                one(hir::StmtKind::OnError(Some(label)))
            }
            StmtKind::ResumeNext => last(hir::StmtKind::ResumeNext),
            StmtKind::Resume => last(hir::StmtKind::Resume),
            StmtKind::OnIn { input, handler } => {
                one(self.on_input(input, handler.as_ref(), stmt.span)?)
            }
            StmtKind::OnEvery(None) => one(hir::StmtKind::OffEvery),
            StmtKind::OnEvery(Some((time, name))) => {
                let every = self.quantity(time, argument::TIME, "ON EVERY");
                let target = self.event_target(name);
                let slot = self.event_slot(stmt.span)?;
                let (every, target) = (every?, target?);
                self.check_time(&every, time.span, 1);
                one(hir::StmtKind::OnEvery { slot, every, target })
            }
            StmtKind::Machine(machine) => {
                let mut kinds = self.machine(machine, stmt.span)?;
                kinds.extend(self.machine_moved(machine));
                Some((kinds, Then::GoesOn))
            }
            StmtKind::Gcode(words) => self.gcode_block(words, stmt),
        }
    }

    fn assign(
        &mut self,
        target: &'a Name,
        index: &'a [Expr],
        value: &'a Expr,
    ) -> Option<hir::StmtKind> {
        let place = self.place(target, index);
        let lowered = self.expr(value);
        let ((place, kind), lowered) = (place?, lowered?);
        if let Place::Var(var) = place
            && self.reader(var).is_some()
        {
            let found = lowered.kind;
            let restart = self.restart(var, &lowered, value.span);
            return restart.map_err(|why| self.wrong_restart(target, value, found, why)).ok();
        }
        if !kinds::fits(kind, lowered.kind) {
            let what = format!("`{}`, {},", target.text, kinds::a(kind));
            self.wrong_assignment(&what, kind, value, lowered.kind);
            return None;
        }
        Some(hir::StmtKind::Assign(place, lowered))
    }

    /// What an assignment writes, with its kind.
    pub(super) fn place(&mut self, target: &'a Name, index: &'a [Expr]) -> Option<(Place, Kind)> {
        let symbol = self.resolve(target)?;
        let Entity::Var(var) = symbol.entity else {
            let (what, hint) = match symbol.entity {
                Entity::Const(..) => ("a CONST, which never changes", "use a variable: `DIM`"),
                Entity::Port(true, _) => {
                    ("the name of an output", "outputs are set by `SetOut name, ON`")
                }
                Entity::Port(false, _) => ("the name of an input", "inputs are read: `IN(name)`"),
                Entity::Analog(false, _) => {
                    ("the name of an analog input", "these are read: `AIN(name)`")
                }
                Entity::Analog(true, _) => {
                    ("the name of an analog output", "these are set by `SetAout name, value`")
                }
                Entity::Table(_) => ("a TABLE, which stands in flash", "use an array: `DIM a(8)`"),
                _ => ("a SUB or FUNCTION", "its value is given by RETURN"),
            };
            self.error(Code::WrongUse, target.span, format!("`{}` is {what}", target.text), hint);
            return None;
        };
        let info = &self.vars[var.0 as usize];
        let (kind, array) = (info.kind, info.array);
        let place = if !index.is_empty() {
            Place::Elem(var, Box::new(self.index(var, &symbol, index, target.span)?))
        } else if array {
            let hint = format!("write which value: `{}(0) = ...`", target.text);
            self.error(Code::WrongUse, target.span, format!("`{}` is an array", target.text), hint);
            return None;
        } else {
            Place::Var(var)
        };
        Some((place, kind))
    }

    fn wrong_assignment(&mut self, what: &str, kind: Kind, value: &'a Expr, found: Kind) {
        let (verb, hint) = match (kind, found) {
            (Kind::Truth, Kind::Number) => ("can not take", "compare it: `x <> 0`".to_owned()),
            (Kind::Length, Kind::Steps) => {
                ("can not take", "convert it: `LENGTH(X, steps)`".to_owned())
            }
            (Kind::Steps, Kind::Length) => {
                ("can not take", "convert it: `STEPS(X, length)`".to_owned())
            }
            (Kind::Number | Kind::Truth, _) => (
                "can not take",
                format!("declare it `AS {found}`, or divide by `{}`", kinds::unit_of(found)),
            ),
            _ => ("can not take", {
                let unit = crate::front::literal::example(kind);
                format!(
                    "write the value with its unit, as in `{unit}`, or declare the name `AS {found}`"
                )
            }),
        };
        let message = format!("{what} {verb} {}", kinds::a(found));
        self.error(Code::AssignKind, value.span, message, hint);
    }

    fn call(&mut self, name: &'a Name, args: &'a [Expr], span: Span) -> Option<hir::StmtKind> {
        let declare = |name: &str| format!("declare it: `SUB {name}` ... `END SUB`");
        let symbol = self.resolve_as(name, declare)?;
        let Entity::Routine(id) = symbol.entity else {
            let message = format!("`{}` is not a SUB", name.text);
            self.error(
                Code::WrongUse,
                name.span,
                message,
                "a statement begins with a SUB or a statement word",
            );
            return None;
        };
        let args = self.arguments(id, args, span)?;
        Some(hir::StmtKind::Call(id, args))
    }

    fn exit(&mut self, what: Enclosing, span: Span) -> Option<hir::StmtKind> {
        match loop_kind(what) {
            Some(kind) => {
                self.enclosing(kind, "EXIT", span)?;
                let open = self.around.loops.iter_mut().rev().find(|(k, _)| *k == kind)?;
                open.1 = true;
                Some(hir::StmtKind::Exit(kind))
            }
            None => {
                let function = what == Enclosing::Function;
                match self.routine(self.scope) {
                    Some(routine) if routine.is_function == function => {
                        Some(hir::StmtKind::ExitRoutine)
                    }
                    other => {
                        let word = if function { "FUNCTION" } else { "SUB" };
                        let hint = match other {
                            None => "the run ends with END",
                            Some(_) if function => "write `EXIT SUB`",
                            Some(_) => "write `EXIT FUNCTION`, or `RETURN value`",
                        };
                        self.error(
                            Code::NotInside,
                            span,
                            format!("EXIT {word} outside a {word}"),
                            hint,
                        );
                        None
                    }
                }
            }
        }
    }

    fn enclosing(&mut self, kind: LoopKind, verb: &str, span: Span) -> Option<()> {
        if self.around.loops.iter().any(|(open, _)| *open == kind) {
            return Some(());
        }
        let word = match kind {
            LoopKind::For => "FOR",
            LoopKind::While => "WHILE",
            LoopKind::Do => "DO",
            LoopKind::Repeat => "REPEAT",
        };
        let hint = match self.around.loops.last() {
            Some((LoopKind::For, _)) => format!("the loop around it is a FOR: `{verb} FOR`"),
            Some((LoopKind::While, _)) => format!("the loop around it is a WHILE: `{verb} WHILE`"),
            Some((LoopKind::Do, _)) => format!("the loop around it is a DO: `{verb} DO`"),
            Some((LoopKind::Repeat, _)) => {
                format!("the loop around it is a REPEAT: `{verb} REPEAT`")
            }
            None => format!("{verb} stands inside a loop"),
        };
        self.error(Code::NotInside, span, format!("{verb} {word} outside a {word}"), hint);
        None
    }

    fn return_value(&mut self, value: &'a Expr) -> Option<hir::StmtKind> {
        let lowered = self.expr(value);
        let Some(kind) = self.infos[self.scope.0 as usize].result else {
            let hint = "only a FUNCTION has a value: make it one, or write RETURN alone";
            self.error(Code::NotInside, value.span, "RETURN with a value outside a FUNCTION", hint);
            return None;
        };
        let lowered = lowered?;
        if !kinds::fits(kind, lowered.kind) {
            let what = format!("`{}`, {},", self.routine_name(self.scope), kinds::a(kind));
            self.wrong_assignment(&what, kind, value, lowered.kind);
            return None;
        }
        Some(hir::StmtKind::ReturnValue(lowered))
    }

    fn on_input(
        &mut self,
        input: &'a Expr,
        handler: Option<&'a (Want, Name)>,
        span: Span,
    ) -> Option<hir::StmtKind> {
        let n = self.port(input, false);
        let Some((want, name)) = handler else { return Some(hir::StmtKind::OffInput(n?)) };
        let target = self.event_target(name);
        let slot = self.event_slot(span)?;
        Some(hir::StmtKind::OnInput { slot, n: n?, want: *want, target: target? })
    }

    fn event_slot(&mut self, span: Span) -> Option<u8> {
        let slot = self.events;
        if slot >= MAX_EVENTS {
            let message = format!("the script has more than {MAX_EVENTS} ON IN and ON EVERY lines");
            self.error(
                Code::TooManyEvents,
                span,
                message,
                "read the other inputs in the handler: `IN(n)`",
            );
            return None;
        }
        self.events += 1;
        Some(slot)
    }

    /// Where an event goes: a SUB without parameters, or a label of the main program.
    fn event_target(&mut self, name: &'a Name) -> Option<GosubTarget> {
        match self.sub_target(name) {
            Some(target) => target,
            None => self.handler_label(name).map(GosubTarget::Label),
        }
    }

    /// The SUB of that name; the inner None after an error.
    fn sub_target(&mut self, name: &'a Name) -> Option<Option<GosubTarget>> {
        let Some(Entity::Routine(id)) = self.names.look(MAIN, &name.key) else { return None };
        self.names.take(MAIN, &name.key);
        let routine = self.routine(id)?;
        if routine.is_function || !routine.params.is_empty() {
            let message = format!("`{}` can not be a GOSUB's target", name.text);
            let hint = "the target is a label, or a SUB without parameters";
            self.error(Code::BadTarget, name.span, message, hint);
            return Some(None);
        }
        Some(Some(GosubTarget::Sub(id)))
    }
}

/// The loop of an EXIT or CONTINUE; None for SUB and FUNCTION.
fn loop_kind(what: Enclosing) -> Option<LoopKind> {
    match what {
        Enclosing::For => Some(LoopKind::For),
        Enclosing::While => Some(LoopKind::While),
        Enclosing::Do => Some(LoopKind::Do),
        Enclosing::Repeat => Some(LoopKind::Repeat),
        Enclosing::Sub | Enclosing::Function => None,
    }
}

/// Declares, and does nothing when it is reached.
pub(super) fn is_declaration(stmt: &Stmt) -> bool {
    matches!(
        stmt.kind,
        StmtKind::Const(_)
            | StmtKind::Port { .. }
            | StmtKind::Analog(_)
            | StmtKind::Dim(_)
            | StmtKind::Keep(_)
            | StmtKind::Table { .. }
    )
}
