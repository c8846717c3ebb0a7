//! The checker: from the syntax tree to the checked program.
//!
//! Names are declared first, kinds are inferred over the whole text, then every statement is
//! checked and lowered. G-code blocks are taken apart before that, and their modal state is
//! followed over a graph of the control flow ([`gcode`]).

mod aout;
mod argument;
mod bits;
mod calls;
mod clocks;
mod control;
mod declare;
mod ends;
mod expr;
mod fold;
mod func;
mod gcode;
mod graph;
mod infer;
mod kinds;
mod labels;
mod limits;
mod machine;
mod names;
mod order;
mod stmt;
mod timers;
mod turning;

use std::collections::{HashMap, HashSet};

use super::ast::{Name, Script};
use super::codes::Code;
use super::diag::{Diag, Diags};
use super::facts::{Fact, Facts};
use super::span::Span;
use super::words::nearest;
use crate::hir::{self, Program, RoutineId, Storage, Var, VarId};
use crate::kind::Kind;
use crate::profile::Profile;
pub use limits::WHICH_PORT;
use names::{Entity, Names, Symbol};

/// The main program's scope.
const MAIN: RoutineId = RoutineId(0);

/// Checks a script for a machine, adding to what the parser found. The program is there when
/// `diags` has no error afterwards, the facts always.
pub fn check(
    script: &Script,
    text: &str,
    profile: &Profile,
    diags: &mut Diags,
) -> (Option<Program>, Facts) {
    let mut checker = Checker::new(script, text, profile, core::mem::take(diags));
    checker.declare_all();
    checker.infer_all();
    checker.find_clocks();
    checker.find_labels();
    let graph = graph::build(&mut checker);
    let calls = calls::check(&mut checker, &graph);
    gcode::analyse(&mut checker, &graph, &calls);
    checker.handler_routines = (0..script.routines.len() as u32 + 1)
        .map(|id| calls.only_handlers(RoutineId(id)))
        .collect();
    let bodies = checker.lower_all();
    checker.report_unused();
    checker.check_targets();
    checker.check_feeds();
    let facts = checker.facts();
    let program = checker.program(bodies, &calls);
    *diags = checker.diags;
    (program, facts)
}

/// The byte range that the checked program keeps of a span.
fn range(span: Span) -> hir::Span {
    span.start as usize..span.end as usize
}

/// What is known of a SUB or FUNCTION, or of the main program.
#[derive(Debug, Default)]
struct Info {
    params: Vec<VarId>,
    locals: Vec<VarId>,
    result: Option<Kind>,
}

struct Checker<'a> {
    script: &'a Script,
    text: &'a str,
    profile: &'a Profile,
    diags: Diags,
    names: Names<'a>,
    vars: Vec<Var>,
    /// Variables whose kind the script leaves to be inferred.
    open: Vec<VarId>,
    tables: Vec<hir::Table>,
    ports: Vec<hir::Port>,
    analogs: Vec<(String, i32)>,
    /// By [`RoutineId`]; the main program first.
    infos: Vec<Info>,
    labels: labels::Labels<'a>,
    /// The routine that is being looked at.
    scope: RoutineId,
    /// Loops and blocks around the statement that is being lowered.
    around: stmt::Around,
    /// G-code blocks with their modal state.
    gcode: gcode::Blocks<'a>,
    /// Variables that a SUB or FUNCTION writes: a call may change them.
    written_by_routines: HashSet<VarId>,
    /// TIMERs, with the FUNCTIONs that read them.
    timers: HashMap<VarId, RoutineId>,
    /// Variables and parameters that hold readings of TIMER.
    clocks: HashSet<VarId>,
    /// Routines that only handlers reach.
    handler_routines: Vec<bool>,
    /// Where the decimals of the last `2,5mm` begin; 0 for none.
    after_comma: u32,
    /// Next event slot.
    events: u8,
    keeps: u8,
    statements: u32,
    limits: limits::Limits,
}

impl<'a> Checker<'a> {
    fn new(script: &'a Script, text: &'a str, profile: &'a Profile, diags: Diags) -> Checker<'a> {
        let routines = script.routines.len() + 1;
        Checker {
            script,
            text,
            profile,
            diags,
            names: Names::new(routines),
            vars: Vec::new(),
            open: Vec::new(),
            tables: Vec::new(),
            ports: Vec::new(),
            analogs: Vec::new(),
            infos: (0..routines).map(|_| Info::default()).collect(),
            labels: labels::Labels::new(routines),
            scope: MAIN,
            around: stmt::Around::default(),
            gcode: gcode::Blocks::default(),
            written_by_routines: HashSet::new(),
            timers: HashMap::new(),
            clocks: HashSet::new(),
            handler_routines: Vec::new(),
            after_comma: 0,
            events: 0,
            keeps: 0,
            statements: 0,
            limits: limits::Limits::default(),
        }
    }

    fn error(
        &mut self,
        code: Code,
        span: Span,
        message: impl Into<String>,
        hint: impl Into<String>,
    ) {
        self.diags.push(Diag::new(code, span, message).hint(hint));
    }

    /// The routine of an id; None for the main program.
    fn routine(&self, id: RoutineId) -> Option<&'a super::ast::Routine> {
        self.script.routines.get((id.0 as usize).checked_sub(1)?)
    }

    /// How messages call a routine.
    fn routine_name(&self, id: RoutineId) -> &'a str {
        self.routine(id).map_or("the main program", |r| &r.name.text)
    }

    /// Ids of all routines with their bodies, the main program first.
    fn bodies(&self) -> impl Iterator<Item = (RoutineId, &'a super::ast::Block)> + use<'a> {
        let script = self.script;
        let subs = script.routines.iter().map(|r| &r.body);
        (0..).map(RoutineId).zip(core::iter::once(&script.body).chain(subs))
    }

    /// Whether only handlers reach a routine.
    fn handler_only(&self, id: RoutineId) -> bool {
        self.handler_routines.get(id.0 as usize).copied().unwrap_or(false)
    }

    /// A new variable.
    fn add_var(&mut self, name: &str, kind: Kind, span: Span, storage: Storage) -> VarId {
        let id = VarId(self.vars.len() as u32);
        let name = name.to_owned();
        let panel = crate::hir::Panel::default();
        let span = range(span);
        self.vars.push(Var { name, kind, len: 1, array: false, storage, panel, span });
        if let Storage::Local(routine) = storage {
            self.infos[routine.0 as usize].locals.push(id);
        }
        id
    }

    /// A variable that the script does not see, of the routine that is being looked at.
    fn hidden(&mut self, what: &str, kind: Kind, span: Span) -> VarId {
        let storage = if self.scope == MAIN { Storage::Global } else { Storage::Local(self.scope) };
        self.add_var(what, kind, span, storage)
    }

    /// What a name stands for; an error that proposes the nearest where there is none.
    fn resolve(&mut self, name: &'a Name) -> Option<Symbol<'a>> {
        self.resolve_as(name, |text| match super::words::foreign_target(&name.key) {
            Some(hint) => hint.to_owned(),
            None => format!("declare it first: `DIM {text}`"),
        })
    }

    /// The same with the hint for a name that is like no other.
    fn resolve_as(
        &mut self,
        name: &'a Name,
        hint: impl FnOnce(&str) -> String,
    ) -> Option<Symbol<'a>> {
        if let Some(symbol) = self.names.take(self.scope, &name.key) {
            return Some(symbol);
        }
        if self.script.lost.contains(&*name.key) {
            // Its declaration has an error.
            return None;
        }
        let words = hint(&name.text);
        // A word of another language is meant as it stands, whatever is called nearly so.
        let foreign = super::words::foreign_function(&name.key) == Some(&*words);
        let near = if self.diags.dropped() == 0 && !foreign {
            nearest(&name.text, self.names.visible(self.scope))
        } else {
            None
        };
        let diag =
            Diag::new(Code::UnknownName, name.span, format!("nothing is called `{}`", name.text));
        self.diags.push(match near {
            Some(near) => diag.near(near),
            None if words.contains("`DIM ") => {
                diag.hint(words).fix(self.declarations(), format!("DIM {}\n", name.text))
            }
            // A name of another language whose value is a word of ours: it takes its place.
            None => {
                let value = words.strip_prefix("write `").and_then(|rest| rest.strip_suffix('`'));
                let value = value.filter(|value| matches!(*value, "ON" | "OFF")).map(str::to_owned);
                let span = diag.span;
                let diag = diag.hint(words);
                match value {
                    Some(value) => diag.fix(span, value),
                    None => diag,
                }
            }
        });
        None
    }

    /// Where a declaration for the present routine may be put: before its first statement.
    fn declarations(&self) -> Span {
        let first = |body: &super::ast::Block| body.first().map(|stmt| stmt.span.start);
        let at = match self.routine(self.scope) {
            Some(routine) => first(&routine.body),
            None => {
                let routines = self.script.routines.first().map(|r| r.span.start);
                first(&self.script.body).into_iter().chain(routines).min()
            }
        };
        Span::point(at.unwrap_or(0))
    }

    /// Warns of names that nothing mentions; where something is wrong, that may be why.
    fn report_unused(&mut self) {
        if self.diags.has_errors() {
            return;
        }
        let unused: Vec<(Span, String)> =
            self.names.unused().filter_map(|s| Some((s.span?, s.text.to_owned()))).collect();
        for (span, text) in unused {
            let message = format!("`{text}` is never used");
            self.error(Code::Unused, span, message, "remove it, or use it");
        }
        for (span, text) in self.labels.unused() {
            let message = format!("nothing goes to the label `{text}`");
            self.error(Code::Unused, span, message, "remove it");
        }
    }

    /// What is known of each declared name.
    fn facts(&self) -> Facts {
        let open: HashSet<VarId> = self.open.iter().copied().collect();
        let fact = |entity: Entity| {
            let mut fact = Fact { kinds: Vec::new(), inferred: false, value: None, storage: None };
            match entity {
                Entity::Const(kind, value) => {
                    fact = Fact { kinds: vec![kind], inferred: true, value, ..fact };
                }
                Entity::Port(_, n) | Entity::Analog(_, n) => fact.value = n,
                Entity::Var(id) => {
                    let var = &self.vars[id.0 as usize];
                    fact.kinds = vec![var.kind];
                    fact.inferred = open.contains(&id);
                    fact.value = var.array.then_some(var.len as i32);
                    fact.storage = Some(var.storage);
                }
                Entity::Table(id) => {
                    let table = &self.tables[id.0 as usize];
                    fact.kinds.clone_from(&table.kinds);
                    fact.inferred = true;
                    fact.value = i32::try_from(table.values.len() as u32 / table.columns).ok();
                }
                Entity::Routine(id) => {
                    fact.kinds.extend(self.infos[id.0 as usize].result);
                    fact.inferred = self.routine(id).is_some_and(|r| r.result.is_none());
                }
            }
            fact
        };
        self.names.declared().filter_map(|s| Some((s.span?.start, fact(s.entity)))).collect()
    }

    fn program(&mut self, bodies: Vec<hir::Block>, calls: &calls::Calls) -> Option<Program> {
        if self.diags.has_errors() {
            return None;
        }
        let routines = bodies
            .into_iter()
            .zip(core::mem::take(&mut self.infos))
            .enumerate()
            .map(|(i, (body, info))| {
                let id = RoutineId(i as u32);
                let routine = self.routine(id);
                hir::Routine {
                    name: routine.map_or_else(String::new, |r| r.name.text.to_string()),
                    params: info.params,
                    locals: info.locals,
                    result: info.result,
                    body,
                    span: routine.map_or(0..0, |r| range(r.span)),
                    reachable: calls.reachable(id),
                }
            })
            .collect();
        Some(Program {
            profile: self.profile.clone(),
            vars: core::mem::take(&mut self.vars),
            tables: core::mem::take(&mut self.tables),
            routines,
            labels: self.labels.to_hir(),
            ports: core::mem::take(&mut self.ports),
            analogs: core::mem::take(&mut self.analogs),
            statements: self.statements,
            last_line: self.script.last_line.max(1),
        })
    }
}
