//! How long a simulation may take, and what is shown of one that does not come to its end.
//!
//! A script is simulated at each pause in typing. A production script often loops for ever; all that a
//! day of it would show is in its first turns. So a run that is cut is shown up to the end of the third
//! turn of its outermost loop.

use std::cell::RefCell;
use std::collections::{BTreeSet, HashMap};
use std::rc::Rc;

use lang::hir::{Block, DoTest, Program, StmtKind};

use crate::sim::trace::Event;

/// Statements of a first look: a fraction of a second.
const LIVE_STATEMENTS: u64 = 1_000_000;
/// Statements of a long look: a second or two of a desktop, and what an endless script leaves in memory
/// meanwhile.
const LONG_STATEMENTS: u64 = 5_000_000;
/// Turns of an endless loop that are shown.
const TURNS: usize = 3;

/// Asked now and then whether it is enough; it is told whether the program may loop for ever.
pub type Ended = Rc<dyn Fn(bool) -> bool>;

/// Told of each statement: its line, and the simulated time, us.
pub type Told = Rc<dyn Fn(u32, u64)>;

/// See the module.
pub struct Budget {
    /// Statements that may be executed.
    pub statements: u64,
    /// Show everything that was simulated, not only the first turns of a loop.
    pub all: bool,
    /// When it is enough.
    pub ended: Ended,
    /// Who is told how far it is.
    pub told: Told,
}

impl Budget {
    /// A look at each pause in typing.
    pub fn live(ended: impl Fn(bool) -> bool + 'static) -> Budget {
        Budget {
            statements: LIVE_STATEMENTS,
            all: false,
            ended: Rc::new(ended),
            told: Rc::new(|_, _| ()),
        }
    }

    /// A longer look at the same text, as far as it goes.
    pub fn long(ended: impl Fn(bool) -> bool + 'static) -> Budget {
        Budget {
            statements: LONG_STATEMENTS,
            all: true,
            ended: Rc::new(ended),
            told: Rc::new(|_, _| ()),
        }
    }

    /// The same with somebody who is told of each statement.
    #[must_use]
    pub fn telling(self, told: impl Fn(u32, u64) + 'static) -> Budget {
        Budget { told: Rc::new(told), ..self }
    }
}

thread_local! {
    // The simulator takes a plain function: what it asks is this thread's.
    static ASKED: RefCell<Option<Rc<dyn Fn() -> bool>>> = const { RefCell::new(None) };
}

/// Whether the simulation of this thread shall end.
pub fn is_over() -> bool {
    ASKED.with_borrow(|asked| asked.as_ref().is_some_and(|ended| ended()))
}

/// Runs a simulation that [`is_over`] may end.
pub fn within<T>(ended: Rc<dyn Fn() -> bool>, run: impl FnOnce() -> T) -> T {
    ASKED.set(Some(ended));
    let result = run();
    ASKED.set(None);
    result
}

/// The first turns of a loop without an end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Turns {
    /// Line of the statement by which they are counted.
    pub line: u32,
    /// How many.
    pub turns: usize,
    /// End of the last one, us.
    pub us: u64,
}

/// Counts the turns of a program's loops that may go on for ever, by the statements that stand in them
/// directly: those of loops within come more often.
pub struct Counter {
    lines: BTreeSet<u32>,
    endless: bool,
    times: HashMap<u32, Vec<u64>>,
    before: u32,
}

impl Counter {
    /// For a program and its lines with effects; one without such a loop counts nothing.
    pub fn new(program: &Program, effects: &[u32]) -> Counter {
        let mut lines = BTreeSet::new();
        for routine in &program.routines {
            let jumps = has_goto(&routine.body);
            direct(&routine.body, jumps, &mut lines);
        }
        let endless = !lines.is_empty();
        lines.retain(|line| effects.contains(line));
        Counter { lines, endless, times: HashMap::new(), before: 0 }
    }

    /// Whether the program may loop for ever.
    pub fn may_loop_for_ever(&self) -> bool {
        self.endless
    }

    /// Takes an event of the run; the turns, when it begins the one behind the last that is shown.
    pub fn hear(&mut self, event: &Event) -> Option<Turns> {
        let (line, us) = (event.what.line(), event.us.unwrap_or(0));
        let before = std::mem::replace(&mut self.before, line);
        if !self.lines.contains(&line) {
            return None;
        }
        let times = self.times.entry(line).or_default();
        // An arc has many events; one after the other they are of one turn, unless the loop has no
        // other line.
        let goes_on = before == line && self.lines.len() > 1;
        if goes_on || times.last() == Some(&us) {
            return None;
        }
        times.push(us);
        (times.len() > TURNS).then_some(Turns { line, turns: TURNS, us })
    }
}

/// Lines of statements that stand directly in a loop without an end; `inside`: these do.
fn direct(block: &Block, inside: bool, lines: &mut BTreeSet<u32>) {
    for stmt in block {
        let endless = is_endless(&stmt.kind);
        let loops = matches!(
            stmt.kind,
            StmtKind::For { .. }
                | StmtKind::While { .. }
                | StmtKind::Do { .. }
                | StmtKind::Repeat { .. }
        );
        if inside && !loops {
            lines.insert(stmt.line);
        }
        for block in stmt.kind.blocks() {
            direct(block, endless || inside && !loops, lines);
        }
    }
}

fn is_endless(kind: &StmtKind) -> bool {
    let constant = |test: &Option<Box<DoTest>>| {
        test.as_ref().is_none_or(|test| test.condition.constant().is_some())
    };
    match kind {
        StmtKind::Do { before, after, .. } => constant(before) && constant(after),
        StmtKind::While { condition, .. } => condition.constant().is_some(),
        _ => false,
    }
}

/// Blocks nest at most as deep as the parser lets them.
fn has_goto(block: &Block) -> bool {
    block.iter().any(|stmt| {
        matches!(stmt.kind, StmtKind::Goto(_)) || stmt.kind.blocks().into_iter().any(has_goto)
    })
}

#[cfg(test)]
mod tests {
    use std::rc::Rc;

    use lang::front::ProfileChoice;

    use super::{Counter, Turns, is_over, within};
    use crate::sim::trace::{Event, What};
    use crate::trial::lines::with_effects;
    use crate::trial::load;

    fn counter(text: &str) -> Counter {
        let loaded = load(text, ProfileChoice::built_in()).expect("it compiles");
        Counter::new(&loaded.program, &with_effects(&loaded.compiled))
    }

    fn found(text: &str, events: &[(u64, u32)]) -> Option<Turns> {
        let mut counter = counter(text);
        events.iter().find_map(|(us, line)| {
            counter.hear(&Event { us: Some(*us), what: What::Wait { line: *line, ms: 1 } })
        })
    }

    #[test]
    fn turns_are_those_of_the_loop_without_an_end() {
        let text = "Wait 1s\nDIM n\nDO\nFOR n = 1 TO 5\nWait 1s\nNEXT\nWait 2s\nLOOP\n";
        let mut events = vec![(0, 1)];
        for turn in 0..6 {
            events.extend((1..=5).map(|n| (100 * turn + n, 5)));
            events.push((100 * turn + 6, 7));
        }
        assert_eq!(found(text, &events), Some(Turns { line: 7, turns: 3, us: 306 }));
        assert_eq!(found(text, &events[..24]), None, "the fourth turn is not there");
        // A loop of one line, and one by GOTO.
        let events: Vec<(u64, u32)> = (1..9).map(|n| (n * 50, 2)).collect();
        assert_eq!(found("DO\nWait 1s\nLOOP\n", &events).map(|own| own.us), Some(200));
        assert_eq!(found("again:\nWait 1s\nGOTO again\n", &events).map(|own| own.us), Some(200));
        // An arc of many events is one statement of its turn.
        let arc: Vec<(u64, u32)> = (1..99).map(|n| (n, 2)).collect();
        assert_eq!(found("DO\nWait 1s\nWait 2s\nLOOP\n", &arc), None);
    }

    #[test]
    fn loops_that_may_never_end_are_known() {
        for text in [
            "DO\nWait 1s\nLOOP\n",
            "again:\nWait 1s\nGOTO again\n",
            "WHILE TRUE\nWait 1s\nWEND\n",
            "work\nSUB work\nDIM n\nFOR n = 1 TO 2\nDO\nWait 1s\nLOOP\nNEXT\nEND SUB\n",
        ] {
            assert!(counter(text).may_loop_for_ever(), "{text}");
        }
        for text in [
            "Wait 1s\n",
            "DIM n\nFOR n = 1 TO 9\nWait 1s\nNEXT\n",
            "DIM n\nDO\nn = n + 1\nLOOP UNTIL n = 9\n",
            "REPEAT 9\nWait 1s\nEND REPEAT\n",
        ] {
            assert!(!counter(text).may_loop_for_ever(), "{text}");
        }
    }

    #[test]
    fn a_run_is_ended_by_whoever_it_belongs_to() {
        assert!(!is_over());
        assert!(within(Rc::new(|| true), is_over));
        assert!(!is_over(), "the next one is another");
    }
}
