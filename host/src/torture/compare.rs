//! What two engines made of one program, and whether it is the same.

use lang::back::Compiled;
use lang::hir::Program;

use super::generate::Case;
use crate::sim::trace::{Event, PerAxis, Status, What};
use crate::sim::world::World;
use crate::sim::{Options, Outcome, STATEMENT_US, SimError, Sink, rhai_engine, vm_engine};

/// A run on one engine.
pub struct Run {
    /// Its trace.
    pub trace: Vec<Event>,
    /// What it left.
    pub outcome: Outcome,
}

type Log = std::rc::Rc<std::cell::RefCell<Vec<Event>>>;

fn sink() -> (Log, Sink) {
    let log = Log::default();
    let to = log.clone();
    (log, Box::new(move |event: &Event| to.borrow_mut().push(event.clone())))
}

/// Runs a program on the engine `rhai`.
///
/// # Errors
/// The engine refuses the program or its world fails.
pub fn on_rhai(
    program: &Program,
    compiled: &Compiled,
    world: &World,
    options: &Options,
) -> Result<Run, SimError> {
    let (log, sink) = sink();
    let outcome = rhai_engine::run(program, world, options, compiled.calls, sink)?;
    Ok(Run { outcome, trace: log.take() })
}

/// Runs a program on the device's VM.
///
/// # Errors
/// The VM refuses the image or the world fails.
pub fn on_vm(
    program: &Program,
    compiled: &Compiled,
    world: &World,
    options: &Options,
) -> Result<Run, SimError> {
    let (log, sink) = sink();
    let outcome = vm_engine::run(program, compiled, world, options, sink)?;
    Ok(Run { outcome, trace: log.take() })
}

/// How far positions of two runs may differ where they hang on the instant, steps: the engines
/// count statements alike but for those that the compiler removes, 20 us each.
pub const INSTANT: i32 = 4;

/// Whether two lines are the same; positions within `steps`.
pub fn alike(a: &What, b: &What, steps: i32) -> bool {
    let near = |a: &PerAxis, b: &PerAxis| {
        a.values().into_iter().zip(b.values()).all(|pair| match pair {
            (Some(a), Some(b)) => a.abs_diff(b) <= steps.unsigned_abs(),
            (a, b) => a == b,
        })
    };
    match (a, b) {
        (What::Move { line, kind, to }, What::Move { line: l, kind: k, to: t }) => {
            (line, kind) == (l, k) && near(to, t)
        }
        (
            What::End { status, fault, text: _, line, pos },
            What::End { status: s, fault: f, text: _, line: l, pos: p },
        ) => (status, fault, line) == (s, f, l) && near(pos, p),
        _ => a == b,
    }
}

/// The lines of a trace that come in the order of the statements, and those of SYNC, which come when their places do: of
/// these the order and the places hang on the instant.
fn by_order(trace: &[Event]) -> (Vec<&Event>, Vec<(u32, i32, i32)>) {
    let (mut others, mut acts) = (Vec::new(), Vec::new());
    for event in trace {
        match event.what {
            What::Out { line, n, v, sync: true, .. } => acts.push((line, n, v.into())),
            // Behind all outputs that are on or off.
            What::Aout { line, n, mv, share, sync: true, .. } => {
                acts.push((line, 100 + n, mv.or(share).unwrap_or(0)));
            }
            _ => others.push(event),
        }
    }
    acts.sort_unstable();
    (others, acts)
}

/// The first line in which two traces differ.
pub fn trace_difference(a: &[Event], b: &[Event], steps: i32) -> Option<String> {
    let ((a, of_a), (b, of_b)) = (by_order(a), by_order(b));
    if of_a != of_b {
        return Some(format!("SYNC: {of_a:?} and {of_b:?}"));
    }
    let mut both = a.iter().zip(&b);
    if let Some(pair) = both.find(|(a, b)| !alike(&a.what, &b.what, steps)) {
        return Some(format!("{pair:?}"));
    }
    (a.len() != b.len()).then(|| format!("{} and {} lines", a.len(), b.len()))
}

/// What differs between two runs: traces, ends, variables.
pub fn difference(case: &Case, rhai: &Run, vm: &Run) -> Option<String> {
    let ends = [rhai.outcome.end.status, vm.outcome.end.status];
    let steps = if case.independent || ends != [Status::Done; 2] { INSTANT } else { 0 };
    // Where the number of statements ends a run, the two are a few lines apart.
    if ends.contains(&Status::Stopped) {
        let mut both = rhai.trace.iter().zip(&vm.trace);
        let end = |event: &Event| matches!(event.what, What::End { .. });
        let other = both.find(|(a, b)| !alike(&a.what, &b.what, steps));
        return other.filter(|(a, b)| !end(a) && !end(b)).map(|pair| format!("{pair:?}"));
    }
    if let Some(text) = trace_difference(&rhai.trace, &vm.trace, steps) {
        return Some(text);
    }
    if rhai.outcome.end != vm.outcome.end {
        return Some(format!("ends {:?} and {:?}", rhai.outcome.end, vm.outcome.end));
    }
    // The compiler gives no cell to a variable that is never read. The cell of a timer holds the time of its restart,
    // and times are not the same on two engines.
    for var in vm.outcome.vars.iter().filter(|var| var.name != super::generate::TIMER) {
        let other = rhai.outcome.vars.iter().find(|other| other.name == var.name);
        if other != Some(var) {
            return Some(format!("{var:?} on the vm, {other:?}"));
        }
    }
    None
}

/// Times of a statement beside the usual one, us: with one of them what hangs on an instant comes out differently.
const OTHER_TIMES: [u64; 4] = [13, 29, 173, 611];

/// Whether a trace hangs on one instant: two engines agree when the world comes later, or one engine alone gives another
/// trace when its statements take another time. `first` is the run of `rhai`; `runs` gives those of `rhai` and of the VM
/// for a case and the time of a statement, us, `None` when the compiler refuses the case.
pub fn hangs_on_an_instant(
    case: &Case,
    first: &Run,
    runs: impl Fn(&Case, u64) -> Option<(Run, Run)>,
) -> bool {
    let later = [3, 8, 17].into_iter().any(|by| {
        let case = varied(case, by);
        runs(&case, STATEMENT_US).is_none_or(|(a, b)| difference(&case, &a, &b).is_none())
    });
    later
        || OTHER_TIMES.into_iter().any(|us| {
            runs(case, us)
                .is_none_or(|(own, _)| trace_difference(&first.trace, &own.trace, 0).is_some())
        })
}

/// A case in which nothing comes at the same instant: the world later, the ticks rarer.
pub fn varied(case: &Case, by: u32) -> Case {
    let world = case.world.replace("at(", &format!("at({by} + ")).replace("_at(", "_AT(");
    let world = world.replace(&format!("_AT({by} + "), "_at(");
    let script = case.script.replace("70ms", &format!("{}ms", 70 + by));
    Case { script, world, independent: case.independent }
}
