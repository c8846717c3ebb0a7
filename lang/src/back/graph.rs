//! What calls what: dead code, contexts, depth of the expression stack and of the call stack.

use std::collections::HashMap;

use crate::back::ir::{Handler, Item, Label, Unit};
use crate::hir::{Program, RoutineId, Span};
use crate::isa::Op;
use crate::record::feature;

/// A place in the code: routine by its position in the unit, item.
type Place = (usize, usize);

/// Bits of the contexts that a routine runs in.
pub mod context {
    /// Main program.
    pub const MAIN: u8 = 1;
    /// Event handlers.
    pub const EVENT: u8 = 2;
    /// Error handlers.
    pub const ERROR: u8 = 4;
}

/// Findings.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    /// For each routine by its position: contexts that reach it.
    pub contexts: Vec<u8>,
    /// For each routine by its position: routines that it calls, in the main program those that
    /// are called in each context.
    pub callees: Vec<Vec<(RoutineId, u8)>>,
    /// Deepest expression of one routine.
    pub frame: usize,
    /// Values of callers that wait below it, at most.
    pub below: usize,
    /// Deepest place from which a FUNCTION is called.
    pub func_depth: usize,
    /// Calls open at once.
    pub calls: usize,
    /// Where the deepest expression stands.
    pub stack_span: Span,
    /// Where the longest chain of calls begins.
    pub calls_span: Span,
}

impl Graph {
    /// Values on the expression stack at most.
    pub const fn stack(&self) -> usize {
        self.below + self.frame
    }
}

/// Follows the code from its entries and drops what nothing reaches.
pub fn analyse(program: &Program, unit: &mut Unit) -> Graph {
    let walk = Walk::new(unit);
    let main = vec![(0, 0)];
    let events: Vec<Place> =
        unit.events.iter().filter_map(|handler| walk.handler(unit, *handler)).collect();
    let mut alive = walk.reach(unit, main.iter().chain(&events).copied(), true, false).0;
    let errors: Vec<Place> = walk.error_handlers(unit, &alive);
    alive = walk.reach(unit, main.iter().chain(&events).chain(&errors).copied(), true, false).0;

    let error_reach = walk.reach(unit, errors.iter().copied(), true, true).0;
    drop_dead(unit, &alive, &error_reach);
    // The items have moved.
    let mut walk = Walk::new(unit);
    let events: Vec<Place> =
        unit.events.iter().filter_map(|handler| walk.handler(unit, *handler)).collect();
    let everything: Vec<Vec<bool>> =
        unit.routines.iter().map(|routine| vec![true; routine.items.len()]).collect();
    let errors = walk.error_handlers(unit, &everything);

    let mut graph = Graph {
        contexts: vec![0; unit.routines.len()],
        callees: vec![Vec::new(); unit.routines.len()],
        stack_span: 0..0,
        calls_span: 0..0,
        ..Graph::default()
    };
    let roots = [
        (context::MAIN, main, false),
        (context::EVENT, events, false),
        (context::ERROR, errors, true),
    ];
    let depths = Depths::of(unit);
    (graph.frame, graph.stack_span) = depths.deepest(unit);
    graph.func_depth = depths.func_depth(unit);
    for (bit, places, stops) in roots {
        if places.is_empty() {
            continue;
        }
        let (reached, _) = walk.reach(unit, places.iter().copied(), true, stops);
        for (r, items) in reached.iter().enumerate() {
            if items.iter().any(|&hit| hit) {
                graph.contexts[r] |= bit;
            }
            for (item, _) in unit.routines[r].items.iter().zip(items).filter(|(_, hit)| **hit) {
                if let Item::Call(_, callee) = item {
                    graph.callees[r].push((*callee, bit));
                }
            }
        }
        let mut longest = Chain::default();
        for &place in &places {
            let chain = walk.chain(unit, &depths, place, stops);
            longest.below = longest.below.max(chain.below);
            if chain.calls >= longest.calls {
                longest.calls = chain.calls;
                longest.first = chain.first;
            }
        }
        // A handler is itself an entry of the call stack.
        let handler = usize::from(bit != context::MAIN);
        graph.calls += longest.calls + handler;
        graph.below += longest.below;
        if bit == context::MAIN {
            graph.calls_span = longest.first.map_or(0..0, |place| span_at(unit, place));
        }
    }
    if graph.stack_span.is_empty() {
        graph.stack_span = program.routine(RoutineId(0)).span.clone();
    }
    graph
}

fn span_at(unit: &Unit, (r, i): Place) -> Span {
    let marks = unit.routines[r].items[..=i].iter().rev();
    let mark = marks.filter_map(|item| match item {
        Item::Mark(mark) => Some(mark.span.clone()),
        _ => None,
    });
    mark.take(1).next().unwrap_or(0..0)
}

/// Where RESUME NEXT goes on behind the statement that begins with the mark at `i`.
fn resumption(
    items: &[Item],
    r: usize,
    i: usize,
    resume: Option<Label>,
    labels: &HashMap<Label, Place>,
) -> Option<Place> {
    match resume {
        Some(label) => labels.get(&label).copied(),
        None => {
            let next = items[i + 1..].iter().position(|item| matches!(item, Item::Mark(_)))?;
            Some((r, i + 1 + next))
        }
    }
}

/// Drops items that are not reached, and `leave` where no error handler can be open.
fn drop_dead(unit: &mut Unit, alive: &[Vec<bool>], errors: &[Vec<bool>]) {
    for (routine, (alive, errors)) in unit.routines.iter_mut().zip(alive.iter().zip(errors)) {
        let mut i = 0;
        routine.items.retain(|item| {
            let (alive, in_error) = (alive[i], errors[i]);
            i += 1;
            let needed = *item != Item::Plain(Op::Leave) || in_error;
            matches!(item, Item::Label(_)) || alive && needed
        });
    }
    let main = unit.routines.first().map(|routine| routine.id);
    unit.routines.retain(|routine| {
        Some(routine.id) == main || routine.items.iter().any(|item| !matches!(item, Item::Label(_)))
    });
}

/// Depth of the expression stack before each item, counted from what the routine found.
struct Depths(Vec<Vec<usize>>);

impl Depths {
    fn of(unit: &Unit) -> Depths {
        let of_routine = |items: &Vec<Item>| {
            let mut depth = 0usize;
            let step = |item: &Item| {
                let before = depth;
                let (pops, pushes) = item.effect();
                depth = depth.saturating_sub(pops.into()) + usize::from(pushes);
                if item.ends() {
                    depth = 0;
                }
                before
            };
            items.iter().map(step).collect()
        };
        Depths(unit.routines.iter().map(|routine| of_routine(&routine.items)).collect())
    }

    fn deepest(&self, unit: &Unit) -> (usize, Span) {
        let mut found = (0, 0..0);
        for (r, depths) in self.0.iter().enumerate() {
            for (i, &before) in depths.iter().enumerate() {
                let item = &unit.routines[r].items[i];
                let (pops, pushes) = item.effect();
                let depth = match item {
                    // The device puts them on the stack for the effect to take.
                    Item::Inline(_, values, _) => before + values.len(),
                    _ => before.saturating_sub(pops.into()) + usize::from(pushes),
                };
                if depth > found.0 {
                    found = (depth, span_at(unit, (r, i)));
                }
            }
        }
        found
    }

    fn func_depth(&self, unit: &Unit) -> usize {
        let sites = self.0.iter().zip(&unit.routines).flat_map(|(depths, routine)| {
            depths.iter().zip(&routine.items).filter_map(|(&depth, item)| {
                matches!(item, Item::Call(Op::Func, _)).then_some(depth)
            })
        });
        sites.max().unwrap_or(0)
    }
}

/// The longest chain of calls from a place.
#[derive(Clone, Copy, Debug, Default)]
struct Chain {
    /// Calls.
    calls: usize,
    /// Values of callers below the last.
    below: usize,
    /// The first call of the chain.
    first: Option<Place>,
}

struct Walk {
    routines: HashMap<RoutineId, usize>,
    labels: HashMap<Label, Place>,
    chains: HashMap<(Place, bool), Chain>,
}

impl Walk {
    fn new(unit: &Unit) -> Walk {
        let mut walk =
            Walk { routines: HashMap::new(), labels: HashMap::new(), chains: HashMap::new() };
        for (r, routine) in unit.routines.iter().enumerate() {
            walk.routines.insert(routine.id, r);
            for (i, item) in routine.items.iter().enumerate() {
                if let Item::Label(label) = item {
                    walk.labels.insert(*label, (r, i));
                }
            }
        }
        walk
    }

    fn handler(&self, _unit: &Unit, handler: Handler) -> Option<Place> {
        match handler {
            Handler::Label(label) => self.labels.get(&label).copied(),
            Handler::Routine(id) => self.routines.get(&id).map(|&r| (r, 0)),
        }
    }

    fn error_handlers(&self, unit: &Unit, alive: &[Vec<bool>]) -> Vec<Place> {
        let items = unit.routines.iter().zip(alive);
        let alive = items.flat_map(|(routine, alive)| {
            routine.items.iter().zip(alive).filter_map(|(item, alive)| alive.then_some(item))
        });
        let labels = alive.filter_map(|item| match item {
            Item::OnError(label) => self.labels.get(label).copied(),
            _ => None,
        });
        labels.collect()
    }

    /// Marks every item that is reached, and lists the calls among them. With `into_calls` callees
    /// are followed too; with `stops` a GOTO that leaves an error handler is not.
    fn reach(
        &self,
        unit: &Unit,
        roots: impl Iterator<Item = Place>,
        into_calls: bool,
        stops: bool,
    ) -> (Vec<Vec<bool>>, Vec<Place>) {
        let mut hit: Vec<Vec<bool>> =
            unit.routines.iter().map(|routine| vec![false; routine.items.len()]).collect();
        let mut calls = Vec::new();
        let mut todo: Vec<Place> = roots.collect();
        let resumes = unit.features & feature::LINES != 0;
        while let Some((r, start)) = todo.pop() {
            let items = &unit.routines[r].items;
            for i in start..items.len() {
                if core::mem::replace(&mut hit[r][i], true) {
                    break;
                }
                let item = &items[i];
                let callee = match item {
                    Item::Call(_, id) => self.routines.get(id).map(|&callee| (callee, 0)),
                    Item::Gosub(label) => self.labels.get(label).copied(),
                    _ => None,
                };
                if let Some(callee) = callee {
                    calls.push((r, i));
                    if into_calls {
                        todo.push(callee);
                    }
                } else if !matches!(item, Item::OnError(_))
                    && let Some(place) = item.target().and_then(|label| self.labels.get(&label))
                {
                    todo.push(*place);
                }
                if resumes && let Item::Mark(mark) = item {
                    todo.extend(resumption(items, r, i, mark.resume, &self.labels));
                }
                if item.ends() || stops && *item == Item::Plain(Op::Leave) {
                    break;
                }
            }
        }
        (hit, calls)
    }

    fn chain(&mut self, unit: &Unit, depths: &Depths, place: Place, stops: bool) -> Chain {
        if let Some(&known) = self.chains.get(&(place, stops)) {
            return known;
        }
        // A ring of calls is the checker's error; here it only must not run for ever.
        self.chains.insert((place, stops), Chain::default());
        let mut longest = Chain::default();
        let (_, calls) = self.reach(unit, core::iter::once(place), false, stops);
        for (r, i) in calls {
            let item = &unit.routines[r].items[i];
            let callee = match item {
                Item::Call(_, id) => self.routines.get(id).map(|&callee| (callee, 0)),
                Item::Gosub(label) => self.labels.get(label).copied(),
                _ => None,
            };
            let Some(callee) = callee else { continue };
            let inner = self.chain(unit, depths, callee, stops);
            longest.below = longest.below.max(inner.below + depths.0[r][i]);
            if inner.calls + 1 > longest.calls {
                longest.calls = inner.calls + 1;
                longest.first = Some((r, i));
            }
        }
        self.chains.insert((place, stops), longest);
        longest
    }
}
