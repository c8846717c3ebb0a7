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
    let mut alive = walk.reach(unit, main.iter().chain(&events).copied(), false);
    let errors: Vec<Place> = walk.error_handlers(unit, &alive);
    alive = walk.reach(unit, main.iter().chain(&events).chain(&errors).copied(), false);

    let error_reach = walk.reach(unit, errors.iter().copied(), true);
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
        let reached = walk.reach(unit, places.iter().copied(), stops);
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
            let chain = match walk.chains.get(&(place, stops)) {
                Some(&known) => known,
                None => walk.chain(unit, &depths, place, stops),
            };
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
    /// For each item the last of the walks that came by, and their number.
    seen: Vec<Vec<u32>>,
    walks: u32,
}

impl Walk {
    fn new(unit: &Unit) -> Walk {
        let mut walk = Walk {
            routines: HashMap::new(),
            labels: HashMap::new(),
            chains: HashMap::new(),
            seen: unit.routines.iter().map(|routine| vec![0; routine.items.len()]).collect(),
            walks: 0,
        };
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

    /// Marks every item that is reached, callees included; with `stops` a GOTO that leaves an error
    /// handler is not followed.
    fn reach(
        &self,
        unit: &Unit,
        roots: impl Iterator<Item = Place>,
        stops: bool,
    ) -> Vec<Vec<bool>> {
        let mut hit: Vec<Vec<bool>> =
            unit.routines.iter().map(|routine| vec![false; routine.items.len()]).collect();
        let mut new = |(r, i): Place| !core::mem::replace(&mut hit[r][i], true);
        let mut todo: Vec<Place> = roots.collect();
        while let Some(start) = todo.pop() {
            self.follow(unit, start, stops, &mut new, &mut todo, |_, callee, todo| {
                todo.push(callee);
            });
        }
        hit
    }

    /// The calls that are reached from a place without going into any: each with its callee.
    fn calls(&mut self, unit: &Unit, place: Place, stops: bool) -> Vec<(Place, Place)> {
        let mut calls = Vec::new();
        let mut todo = vec![place];
        let mut seen = core::mem::take(&mut self.seen);
        self.walks += 1;
        let walk = self.walks;
        let mut new = |(r, i): Place| core::mem::replace(&mut seen[r][i], walk) != walk;
        while let Some(start) = todo.pop() {
            self.follow(unit, start, stops, &mut new, &mut todo, |call, callee, _| {
                calls.push((call, callee));
            });
        }
        self.seen = seen;
        calls
    }

    /// Follows the items of a routine from a place on, as long as each is `new`; where else control
    /// may go is added to `todo`.
    fn follow(
        &self,
        unit: &Unit,
        (r, start): Place,
        stops: bool,
        new: &mut impl FnMut(Place) -> bool,
        todo: &mut Vec<Place>,
        mut call: impl FnMut(Place, Place, &mut Vec<Place>),
    ) {
        let resumes = unit.features & feature::LINES != 0;
        let items = &unit.routines[r].items;
        for i in start..items.len() {
            if !new((r, i)) {
                break;
            }
            let item = &items[i];
            let callee = match item {
                Item::Call(_, id) => self.routines.get(id).map(|&callee| (callee, 0)),
                Item::Gosub(label) => self.labels.get(label).copied(),
                _ => None,
            };
            if let Some(callee) = callee {
                call((r, i), callee, todo);
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

    /// The longest chain of calls from a place. Chains may be as long as there are routines, so
    /// nothing here calls itself.
    fn chain(&mut self, unit: &Unit, depths: &Depths, place: Place, stops: bool) -> Chain {
        let mut open = vec![Open::new(place, self.calls(unit, place, stops))];
        // A ring of calls is the checker's error; here it only must not run for ever.
        self.chains.insert((place, stops), Chain::default());
        loop {
            let Some(top) = open.last_mut() else { return Chain::default() };
            let Some(&((r, i), callee)) = top.calls.get(top.next) else {
                let Open { place, longest, .. } = *top;
                self.chains.insert((place, stops), longest);
                open.pop();
                if open.is_empty() {
                    return longest;
                }
                continue;
            };
            let Some(&inner) = self.chains.get(&(callee, stops)) else {
                self.chains.insert((callee, stops), Chain::default());
                let calls = self.calls(unit, callee, stops);
                open.push(Open::new(callee, calls));
                continue;
            };
            top.next += 1;
            top.longest.below = top.longest.below.max(inner.below + depths.0[r][i]);
            if inner.calls + 1 > top.longest.calls {
                top.longest.calls = inner.calls + 1;
                top.longest.first = Some((r, i));
            }
        }
    }
}

/// A place whose chain is being looked for.
struct Open {
    place: Place,
    /// Calls and callees.
    calls: Vec<(Place, Place)>,
    /// The call that is looked at.
    next: usize,
    longest: Chain,
}

impl Open {
    fn new(place: Place, calls: Vec<(Place, Place)>) -> Open {
        Open { place, calls, next: 0, longest: Chain::default() }
    }
}
