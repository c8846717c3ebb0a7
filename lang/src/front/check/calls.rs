//! Who calls whom: recursion is refused, and what is shared between the main program, event
//! handlers and the error handler must not have cells of its own (lang/README.md, Errors and events).

use super::graph::{Graph, NodeId, Op, Target};
use super::{Checker, MAIN};
use crate::front::codes::Code;
use crate::front::diag::Diag;
use crate::front::span::Span;
use crate::hir::{LabelId, RoutineId};

/// Nodes that all walks together may visit. GOSUB targets whose regions overlap ask for a walk
/// each; a script of 10 000 lines with hundreds of them stays far below.
const MAX_VISITS: usize = 20_000_000;

/// Something that is called: a routine, or the lines behind a GOSUB's label.
#[derive(Debug)]
pub(super) struct Proc {
    pub target: Target,
    /// Calls in it, and where.
    pub calls: Vec<(usize, Span)>,
    /// What needs cells: the words and the place.
    cells: Option<(&'static str, Span)>,
    /// Where each context first reaches it.
    reached: [Option<Span>; 3],
}

/// Who may be running: lang/README.md lets these interrupt one another.
const CONTEXTS: [&str; 3] = ["the main program", "an event handler", "the error handler"];

/// The procedures of a script; routines first, in the order of their ids, then labels.
#[derive(Debug, Default)]
pub(super) struct Calls {
    pub procs: Vec<Proc>,
    /// Callees before callers; empty where there is recursion.
    pub order: Vec<usize>,
    routines: usize,
    by_label: Vec<Option<usize>>,
}

impl Calls {
    /// Whether anything that runs calls a routine.
    pub fn reachable(&self, id: RoutineId) -> bool {
        self.procs.get(id.0 as usize).is_some_and(|p| p.reached.iter().any(Option::is_some))
    }

    /// Whether only handlers reach a routine.
    pub fn only_handlers(&self, id: RoutineId) -> bool {
        self.procs.get(id.0 as usize).is_some_and(|p| p.reached[0].is_none()) && self.reachable(id)
    }

    /// The procedure of a target.
    pub fn proc(&self, target: Target) -> Option<usize> {
        match target {
            Target::Routine(id) => Some(id.0 as usize).filter(|&i| i < self.routines),
            Target::Label(id) => *self.by_label.get(id.0 as usize)?,
        }
    }
}

struct Walker<'g> {
    graph: &'g Graph,
    /// Nodes that a routine reaches without a GOSUB: a GOTO to one of these leaves a GOSUB's lines.
    main_flow: Vec<bool>,
    seen: Vec<u32>,
    epoch: u32,
    visits: usize,
}

impl Walker<'_> {
    /// Nodes from `start` on; `follow` says to which nodes a GOTO is followed.
    fn region(&mut self, start: NodeId, follow: fn(&Walker<'_>, NodeId) -> bool) -> Vec<NodeId> {
        self.epoch += 1;
        let mut list = vec![start];
        self.seen[start as usize] = self.epoch;
        let mut next = 0;
        while let Some(&node) = list.get(next) {
            next += 1;
            self.visits += 1;
            if self.visits > MAX_VISITS {
                break;
            }
            let step = &self.graph.nodes[node as usize];
            for to in step.next() {
                if step.op == Op::Goto && !follow(self, to) {
                    continue;
                }
                if self.seen[to as usize] != self.epoch {
                    self.seen[to as usize] = self.epoch;
                    list.push(to);
                }
            }
        }
        list
    }
}

/// Finds the calls, refuses recursion and shared cells.
pub(super) fn check(checker: &mut Checker<'_>, graph: &Graph) -> Calls {
    let count = graph.nodes.len();
    let mut walker =
        Walker { graph, main_flow: vec![false; count], seen: vec![0; count], epoch: 0, visits: 0 };
    let mut calls = Calls {
        routines: graph.entries.len(),
        by_label: vec![None; graph.labels.len()],
        ..Calls::default()
    };
    let mut regions = Vec::new();
    for (i, &entry) in graph.entries.iter().enumerate() {
        let region = walker.region(entry, |_, _| true);
        region.iter().for_each(|&node| walker.main_flow[node as usize] = true);
        calls.add(Target::Routine(RoutineId(i as u32)));
        regions.push(region);
    }
    for node in &graph.nodes {
        if let Op::Gosub(Target::Label(label), _) = node.op {
            calls.add_label(label);
        }
    }
    for (target, _) in &graph.events {
        if let Target::Label(label) = *target {
            calls.add_label(label);
        }
    }
    for i in regions.len()..calls.procs.len() {
        let start = graph.entry(calls.procs[i].target);
        regions.push(walker.region(start, |w, to| !w.main_flow[to as usize]));
    }
    for (i, region) in regions.iter().enumerate() {
        for &node in region {
            let (target, span) = match graph.nodes[node as usize].op {
                Op::Call(id, span) => (Target::Routine(id), span),
                Op::Gosub(target, span) => (target, span),
                Op::Uses(what, span) => {
                    calls.procs[i].cells.get_or_insert((what, span));
                    continue;
                }
                _ => continue,
            };
            if let Some(callee) = calls.proc(target) {
                calls.procs[i].calls.push((callee, span));
            }
        }
    }
    if walker.visits > MAX_VISITS {
        let hint = "end each GOSUB's lines with RETURN, or make SUBs of them";
        let span = Span::default();
        checker.error(
            Code::TooTangled,
            span,
            "the GOSUBs of this script run into one another too much",
            hint,
        );
        return calls;
    }
    calls.sort(checker);
    calls.reach(&mut walker);
    calls.check_shared(checker);
    calls
}

impl Calls {
    fn add(&mut self, target: Target) {
        self.procs.push(Proc { target, calls: Vec::new(), cells: None, reached: [None; 3] });
    }

    fn add_label(&mut self, label: LabelId) {
        if self.by_label[label.0 as usize].is_none() {
            self.by_label[label.0 as usize] = Some(self.procs.len());
            self.add(Target::Label(label));
        }
    }

    /// Callees before callers, by depth-first search; reports the first circle from each start.
    fn sort(&mut self, checker: &mut Checker<'_>) {
        #[derive(Clone, Copy, PartialEq)]
        enum Mark {
            New,
            Open,
            Done,
        }
        let mut marks = vec![Mark::New; self.procs.len()];
        let mut order = Vec::with_capacity(self.procs.len());
        let mut recursive = false;
        for start in 0..self.procs.len() {
            if marks[start] != Mark::New {
                continue;
            }
            marks[start] = Mark::Open;
            let mut stack: Vec<(usize, usize)> = vec![(start, 0)];
            while let Some(top) = stack.last_mut() {
                let (proc, at) = *top;
                top.1 += 1;
                let Some(&(callee, span)) = self.procs[proc].calls.get(at) else {
                    marks[proc] = Mark::Done;
                    order.push(proc);
                    stack.pop();
                    continue;
                };
                match marks[callee] {
                    Mark::Done => {}
                    Mark::New => {
                        marks[callee] = Mark::Open;
                        stack.push((callee, 0));
                    }
                    Mark::Open => {
                        recursive = true;
                        let from = stack.iter().position(|(p, _)| *p == callee).unwrap_or(0);
                        let ring: Vec<usize> = stack[from..].iter().map(|(p, _)| *p).collect();
                        self.report_ring(checker, &ring, span);
                    }
                }
            }
        }
        if !recursive {
            self.order = order;
        }
    }

    fn report_ring(&self, checker: &mut Checker<'_>, ring: &[usize], span: Span) {
        let name = |&proc: &usize| self.name(checker, proc);
        let first = ring.first().map(name).unwrap_or_default();
        let message = if ring.len() > 1 {
            let through: Vec<String> = ring[1..].iter().map(name).collect();
            format!("{first} calls itself through {}", through.join(", "))
        } else {
            format!("{first} calls itself")
        };
        let diag = Diag::new(Code::Recursion, span, message)
            .hint("use a loop: without recursion the stack that a script needs is known");
        checker.diags.push(diag);
    }

    fn name(&self, checker: &Checker<'_>, proc: usize) -> String {
        match self.procs[proc].target {
            Target::Routine(MAIN) => "the main program".to_owned(),
            Target::Routine(id) => format!("`{}`", checker.routine_name(id)),
            Target::Label(id) => format!("`{}`", checker.labels.name(id).text),
        }
    }

    /// Marks what each context reaches.
    fn reach(&mut self, walker: &mut Walker<'_>) {
        let graph = walker.graph;
        let mut starts: Vec<(usize, usize, Span)> = vec![(0, 0, Span::default())];
        for &(target, span) in &graph.events {
            starts.extend(self.proc(target).map(|proc| (1, proc, span)));
        }
        for &(label, _) in &graph.errors {
            // A GOTO in the handler itself leaves it: what follows is the main program's.
            let handler = walker.region(graph.labels[label.0 as usize], |_, _| false);
            let beyond: Vec<NodeId> = handler
                .iter()
                .filter(|&&node| graph.nodes[node as usize].op == Op::Goto)
                .flat_map(|&node| graph.nodes[node as usize].next())
                .collect();
            let mut regions = vec![(2, handler)];
            for node in beyond {
                regions.push((0, walker.region(node, |_, _| true)));
            }
            for (context, region) in regions {
                for node in region {
                    let called = match graph.nodes[node as usize].op {
                        Op::Call(id, span) => Some((Target::Routine(id), span)),
                        Op::Gosub(target, span) => Some((target, span)),
                        _ => None,
                    };
                    let proc = called.and_then(|(target, span)| Some((self.proc(target)?, span)));
                    starts.extend(proc.map(|(proc, at)| (context, proc, at)));
                }
            }
        }
        while let Some((context, proc, span)) = starts.pop() {
            if self.procs[proc].reached[context].is_some() {
                continue;
            }
            self.procs[proc].reached[context] = Some(span);
            starts.extend(self.procs[proc].calls.iter().map(|&(callee, at)| (context, callee, at)));
        }
    }

    fn check_shared(&self, checker: &mut Checker<'_>) {
        for (i, proc) in self.procs.iter().enumerate().skip(1) {
            let places: Vec<(usize, Span)> = proc
                .reached
                .iter()
                .enumerate()
                .filter_map(|(context, span)| Some((context, (*span)?)))
                .collect();
            let &[(first, first_span), (second, second_span), ..] = &places[..] else { continue };
            let cells = match proc.target {
                Target::Routine(id) => own_cells(checker, id).or(proc.cells),
                Target::Label(_) => proc.cells,
            };
            let Some((what, span)) = cells else { continue };
            let name = self.name(checker, i);
            let message = format!(
                "{name} has {what} and is reached from {} and from {}",
                CONTEXTS[first], CONTEXTS[second]
            );
            let diag = Diag::new(Code::SharedCells, span, message)
                .label(first_span, format!("{} calls it here", CONTEXTS[first]))
                .label(second_span, format!("{} calls it here", CONTEXTS[second]))
                .hint("write a second one for the handler, or use variables declared outside");
            checker.diags.push(diag);
        }
    }
}

/// A parameter or local of a routine.
fn own_cells(checker: &Checker<'_>, id: RoutineId) -> Option<(&'static str, Span)> {
    let info = &checker.infos[id.0 as usize];
    let parameter = info.params.first().map(|&var| ("a parameter", var));
    let local = info.locals.first().map(|&var| ("a local", var));
    let (what, var) = parameter.or(local)?;
    let span = &checker.vars[var.0 as usize].span;
    Some((what, Span::new(span.start as u32, span.end as u32)))
}
