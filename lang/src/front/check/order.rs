//! Order of evaluation: a statement evaluates its arguments from left to right before it acts.
//!
//! Engines do so for every statement that is one effect. A PRINT of several parts, a G-code block
//! and a canned cycle are several: what must be known before the first of them goes into hidden
//! variables, by assignments in front of it that belong to the same statement.

use super::Checker;
use crate::front::span::Span;
use crate::hir::{ArcCenter, Cycle, CycleKind, Expr, ExprKind, Place, PrintPart, StmtKind};

/// A value of a block.
struct Argument<'e> {
    expr: &'e mut Expr,
    /// It is used more than once, or between the moves: only a constant or a variable will do.
    again: bool,
}

impl Checker<'_> {
    /// A PRINT: FUNCTIONs are called before the line begins, as they may print lines of their own.
    ///
    /// The last value with a call stays in its place: engines evaluate it before the first part.
    pub(super) fn print_in_order(&mut self, mut parts: Vec<PrintPart>) -> Vec<StmtKind> {
        let calls = |part: &PrintPart| matches!(part, PrintPart::Value(e, _) if e.has_call());
        let last = parts.iter().rposition(calls).unwrap_or(0);
        let mut out = Vec::new();
        for part in &mut parts[..last] {
            if let PrintPart::Value(value, _) = part
                && self.may_change(value)
            {
                out.push(self.set_aside(value));
            }
        }
        out.push(StmtKind::Print(parts));
        out
    }

    /// The statements of a G-code block: its words are evaluated in the order of the text where
    /// FUNCTIONs are called, and a cycle's before its first move.
    pub(super) fn block_in_order(&mut self, mut kinds: Vec<StmtKind>) -> Vec<StmtKind> {
        let calls = kinds.iter_mut().flat_map(arguments).any(|a| a.expr.has_call());
        let ordered = calls && !is_ordered(&mut kinds);
        let moves = |argument: &Argument<'_>| {
            if ordered {
                self.may_change(argument.expr)
            } else {
                argument.again && !argument.expr.is_simple()
            }
        };
        let mut list: Vec<_> = kinds.iter_mut().flat_map(arguments).filter(moves).collect();
        list.sort_by_key(|argument| argument.expr.span.start);
        let mut out: Vec<StmtKind> =
            list.into_iter().map(|argument| self.set_aside(argument.expr)).collect();
        out.append(&mut kinds);
        out
    }

    /// Whether the value may be another one after a FUNCTION was called, or fail.
    fn may_change(&self, value: &Expr) -> bool {
        match value.node {
            ExprKind::Const(_) => false,
            ExprKind::Var(var) => self.written_by_routines.contains(&var),
            _ => true,
        }
    }

    /// Puts a value into a hidden variable, which takes its place.
    fn set_aside(&mut self, value: &mut Expr) -> StmtKind {
        let span = Span::new(value.span.start as u32, value.span.end as u32);
        let var = self.hidden("value ahead", value.kind, span);
        let place = Expr { node: ExprKind::Var(var), ..value.clone() };
        StmtKind::Assign(Place::Var(var), core::mem::replace(value, place))
    }
}

/// Whether the order in which the engines evaluate is that of the text, before anything acts.
fn is_ordered(kinds: &mut [StmtKind]) -> bool {
    let mut acted = false;
    let mut at = 0;
    for kind in kinds {
        let constant_feed = matches!(kind, StmtKind::SetFeed(feed) if feed.constant().is_some());
        let cycle = matches!(kind, StmtKind::Cycle(_));
        for argument in arguments(kind).into_iter().filter(|a| a.expr.constant().is_none()) {
            let start = argument.expr.span.start;
            if acted || cycle || start < at {
                return false;
            }
            at = start;
        }
        acted |= !constant_feed;
    }
    true
}

/// The values of one of a block's statements, in the order in which engines evaluate them.
fn arguments(kind: &mut StmtKind) -> Vec<Argument<'_>> {
    let once = |expr| Argument { expr, again: false };
    match kind {
        // A look at Z for the cycles of G98 is no argument.
        StmtKind::Assign(_, value) if !matches!(value.node, ExprKind::Read(_)) => {
            vec![once(value)]
        }
        StmtKind::SetFeed(value) | StmtKind::SetSpindle(value) | StmtKind::SetPos { value, .. } => {
            vec![once(value)]
        }
        StmtKind::Plain(_, list) => list.iter_mut().map(once).collect(),
        StmtKind::SetAout(n, value) => [n, value].map(once).into(),
        StmtKind::Sync(own) => [&mut own.n, &mut own.value, &mut own.lead].map(once).into(),
        StmtKind::Probe { limit, .. } => vec![once(&mut limit.value)],
        StmtKind::Linear { to, .. } => {
            to.iter_mut().flatten().map(|word| once(&mut word.value)).collect()
        }
        StmtKind::Arc { to, center, .. } => {
            let words = to.iter_mut().flatten().map(|word| &mut word.value);
            match center {
                ArcCenter::Offsets(offsets) => {
                    words.chain(offsets.iter_mut().flatten()).map(once).collect()
                }
                ArcCenter::Radius(radius) => words.chain([&mut **radius]).map(once).collect(),
            }
        }
        StmtKind::Cycle(cycle) => of_cycle(cycle),
        _ => Vec::new(),
    }
}

fn of_cycle(cycle: &mut Cycle) -> Vec<Argument<'_>> {
    let repeated = cycle.repeats.is_some();
    let deep = repeated || matches!(cycle.kind, CycleKind::Peck(_));
    let mut list = vec![
        Argument { expr: &mut cycle.z.value, again: deep },
        Argument { expr: &mut cycle.r.value, again: true },
    ];
    list.extend(cycle.repeats.iter_mut().map(|expr| Argument { expr, again: false }));
    for word in cycle.xy.iter_mut().flatten() {
        list.push(Argument { expr: &mut word.value, again: repeated });
    }
    match &mut cycle.kind {
        CycleKind::Drill => {}
        CycleKind::Dwell(expr) | CycleKind::Peck(expr) => {
            list.push(Argument { expr, again: true });
        }
    }
    list
}
