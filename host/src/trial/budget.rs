//! How long a simulation may take, and what is shown of one that does not come to its end.
//!
//! A script is simulated at each pause in typing. A production script often loops for ever; all that a
//! day of it would show is in its first turns. So a run that is cut is shown up to the end of the third
//! turn of its outermost loop.

use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

use crate::sim::trace::Event;

/// Statements of a first look: a fraction of a second.
const LIVE_STATEMENTS: u64 = 1_000_000;
/// Statements of a long look: a second or two of a desktop, and what an endless script leaves in memory
/// meanwhile.
const LONG_STATEMENTS: u64 = 5_000_000;
/// Turns of an endless loop that are shown.
const TURNS: usize = 3;

/// Asked now and then; `true` ends the simulation where it is.
pub type Ended = Rc<dyn Fn() -> bool>;

/// See the module.
pub struct Budget {
    /// Statements that may be executed.
    pub statements: u64,
    /// Show everything that was simulated, not only the first turns of a loop.
    pub all: bool,
    /// When it is enough.
    pub ended: Ended,
}

impl Budget {
    /// A look at each pause in typing.
    pub fn live(ended: impl Fn() -> bool + 'static) -> Budget {
        Budget { statements: LIVE_STATEMENTS, all: false, ended: Rc::new(ended) }
    }

    /// A longer look at the same text, as far as it goes.
    pub fn long(ended: impl Fn() -> bool + 'static) -> Budget {
        Budget { statements: LONG_STATEMENTS, all: true, ended: Rc::new(ended) }
    }
}

thread_local! {
    // The simulator takes a plain function: what it asks is this thread's.
    static ASKED: RefCell<Option<Ended>> = const { RefCell::new(None) };
}

/// Whether the simulation of this thread shall end.
pub fn is_over() -> bool {
    ASKED.with_borrow(|asked| asked.as_ref().is_some_and(|ended| ended()))
}

/// Runs a simulation that [`is_over`] may end.
pub fn within<T>(ended: &Ended, run: impl FnOnce() -> T) -> T {
    ASKED.set(Some(ended.clone()));
    let result = run();
    ASKED.set(None);
    result
}

/// The outermost loop of a run that was cut: its line, and when the last turn that is shown ends, us.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Turns {
    /// Line of the first statement of the loop that had an effect.
    pub line: u32,
    /// Turns that are shown.
    pub turns: usize,
    /// End of the last one, us.
    pub us: u64,
}

/// Finds the loop: statements of inner loops come more often than those of the outermost one, and those
/// before it come once. `None`: nothing came often enough, or the turns take no time.
pub fn turns(events: &[Event]) -> Option<Turns> {
    // An arc has many events; one after the other they are one turn's. Only where a whole loop is in one
    // line each of them counts.
    found(events, true).or_else(|| found(events, false))
}

fn found(events: &[Event], joined: bool) -> Option<Turns> {
    let mut times: HashMap<u32, Vec<u64>> = HashMap::new();
    let mut before = None;
    for event in events {
        let (line, us) = (event.what.line(), event.us.unwrap_or(0));
        let seen = times.entry(line).or_default();
        if seen.last() != Some(&us) && !(joined && before == Some(line)) {
            seen.push(us);
        }
        before = Some(line);
    }
    let often = times.iter().filter(|(line, seen)| **line > 0 && seen.len() > TURNS);
    let (line, seen) = often.min_by_key(|(line, seen)| (seen.len(), seen[0], **line))?;
    Some(Turns { line: *line, turns: TURNS, us: seen[TURNS] }).filter(|own| own.us > 0)
}

#[cfg(test)]
mod tests {
    use super::{Turns, is_over, turns, within};
    use crate::sim::trace::{Event, What};
    use std::rc::Rc;

    fn event(us: u64, line: u32) -> Event {
        Event { us: Some(us), what: What::Wait { line, ms: 1 } }
    }

    #[test]
    fn the_outermost_loop_is_found() {
        let mut events = vec![event(1, 1), event(2, 2)];
        for turn in 0..6 {
            let at = 10 + 100 * turn;
            events.push(event(at, 3));
            events.extend((1..=4).map(|n| event(at + n, 4)));
            events.push(event(at + 9, 5));
        }
        assert_eq!(turns(&events), Some(Turns { line: 3, turns: 3, us: 310 }));
        // Four turns are needed to know the end of the third; a long way without a loop has none.
        assert_eq!(turns(&events[..16]), None);
        let straight: Vec<Event> = (1..1000).map(|n| event(n.into(), n)).collect();
        assert_eq!(turns(&straight), None);
        let alone: Vec<Event> = (1..9).map(|n| event(n * 50, 7)).collect();
        assert_eq!(turns(&alone), Some(Turns { line: 7, turns: 3, us: 200 }));
        let still: Vec<Event> = (0..9).map(|_| event(0, 1)).collect();
        assert_eq!(turns(&still), None);
    }

    #[test]
    fn a_run_is_ended_by_whoever_it_belongs_to() {
        assert!(!is_over());
        assert!(within(&(Rc::new(|| true) as super::Ended), is_over));
        assert!(!is_over(), "the next one is another");
    }
}
