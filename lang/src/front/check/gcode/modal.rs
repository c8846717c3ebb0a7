//! The modal state as a lattice: for each group what holds, and where it was written.

use super::block::Motion;
use crate::front::span::Span;

/// What is followed along the control flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub(super) enum Group {
    /// 0 XY, 1 ZX, 2 YZ
    Plane,
    /// 0 mm, 1 inch
    Units,
    /// 0 absolute, 1 relative
    Distance,
    /// 0 G98, 1 G99
    Retract,
    /// Index of the motion mode.
    Motion,
    /// 0 G64, 1 G61
    Exact,
    /// [`NO_FEED`], [`DEFAULT_FEED`], [`FEED`]
    Feed,
    /// 1: a cycle holds the Z before the first cycle.
    Held,
    /// 0 none, else 1 + index of the held word.
    R,
    Z,
    P,
    Q,
    /// 0 main program, 1 handlers.
    Class,
}

/// Number of groups.
pub(super) const GROUPS: usize = Group::Class as usize + 1;

/// Nothing was written: a handler's start.
pub(super) const UNSET: i32 = -1;
pub(super) const NO_FEED: i32 = 0;
/// The profile's default feed holds.
pub(super) const DEFAULT_FEED: i32 = 1;
pub(super) const FEED: i32 = 2;

/// What one group may be, at one place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Value {
    /// What held when the procedure was entered.
    pub entry: bool,
    /// What was written since, with the place; of several different ones the least and the
    /// greatest.
    pub written: Option<[(i32, Span); 2]>,
}

impl Value {
    pub fn known(value: i32, place: Span) -> Value {
        Value { entry: false, written: Some([(value, place); 2]) }
    }

    const ENTRY: Value = Value { entry: true, written: None };

    /// The one value that it has.
    pub fn single(&self) -> Option<i32> {
        match self.written {
            Some([(low, _), (high, _)]) if low == high && !self.entry => Some(low),
            _ => None,
        }
    }

    fn join(&mut self, other: &Value) -> bool {
        let before = *self;
        self.entry |= other.entry;
        self.written = match (self.written, other.written) {
            (None, written) | (written, None) => written,
            (Some([low, high]), Some([other_low, other_high])) => {
                // Equal values keep the earlier place, so that the order of visits shows nowhere.
                let least =
                    if (other_low.0, other_low.1) < (low.0, low.1) { other_low } else { low };
                let greatest = match other_high.0.cmp(&high.0) {
                    core::cmp::Ordering::Greater => other_high,
                    core::cmp::Ordering::Equal if other_high.1 < high.1 => other_high,
                    _ => high,
                };
                Some([least, greatest])
            }
        };
        *self != before
    }
}

/// The state of all groups.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct State(pub [Value; GROUPS]);

impl State {
    /// As a procedure is entered, whatever that is.
    pub const ENTRY: State = State([Value::ENTRY; GROUPS]);

    /// The script's start: G17 G21 G90 G98 G64, no motion mode.
    pub fn start(default_feed: bool) -> State {
        let mut state = State([Value::known(0, Span::default()); GROUPS]);
        let feed = if default_feed { DEFAULT_FEED } else { NO_FEED };
        state.set(Group::Feed, feed, Span::default());
        state
    }

    /// A handler's start: nothing holds.
    pub fn handler(place: Span) -> State {
        let mut state = State([Value::known(0, place); GROUPS]);
        for group in [
            Group::Plane,
            Group::Units,
            Group::Distance,
            Group::Retract,
            Group::Motion,
            Group::Exact,
        ] {
            state.set(group, UNSET, place);
        }
        state.set(Group::Class, 1, place);
        state
    }

    pub fn get(&self, group: Group) -> &Value {
        &self.0[group as usize]
    }

    /// Writes a group. A value that the script has written already keeps its place: programs
    /// that repeat their words in each block then have few different states.
    pub fn set(&mut self, group: Group, value: i32, place: Span) {
        let slot = &mut self.0[group as usize];
        let same = slot.single() == Some(value);
        if !(same && slot.written.is_some_and(|[(_, before), _]| before != Span::default())) {
            *slot = Value::known(value, place);
        }
    }

    /// The group may be either of two values.
    pub fn set_either(&mut self, group: Group, values: [i32; 2], place: Span) {
        let written = Some(values.map(|value| (value, place)));
        self.0[group as usize] = Value { entry: false, written };
    }

    pub fn motion(&self) -> Option<Motion> {
        self.get(Group::Motion).single().map(Motion::from_value)
    }

    /// Adds what another way brings; says whether that is new.
    pub fn join(&mut self, other: &State) -> bool {
        let mut changed = false;
        for (value, other) in self.0.iter_mut().zip(&other.0) {
            changed |= value.join(other);
        }
        changed
    }

    /// This state behind a call that does `effect`, which is relative to its entry.
    pub fn after(&self, effect: &State) -> State {
        let mut state = *effect;
        for (value, before) in state.0.iter_mut().zip(&self.0) {
            if value.entry {
                value.entry = false;
                value.join(before);
            }
        }
        state
    }
}

/// How a value of a group is written.
pub(super) fn word(group: Group, value: i32) -> &'static str {
    let pick = |words: &[&'static str]| {
        usize::try_from(value).ok().and_then(|i| words.get(i)).copied().unwrap_or("nothing")
    };
    match group {
        Group::Plane => pick(&["G17", "G18", "G19"]),
        Group::Units => pick(&["G21", "G20"]),
        Group::Distance => pick(&["G90", "G91"]),
        Group::Retract => pick(&["G98", "G99"]),
        Group::Exact => pick(&["G64", "G61"]),
        Group::Motion if value >= 0 => Motion::from_value(value).word(),
        Group::Motion => "no motion mode",
        Group::Feed => pick(&["no F", "the default feed", "an F"]),
        _ => pick(&["none"]),
    }
}

/// What a group is called, and the words that set it.
pub(super) fn describe(group: Group) -> (&'static str, &'static str) {
    match group {
        Group::Plane => ("the plane", "G17, G18 or G19"),
        Group::Units => ("the unit", "G21 or G20"),
        Group::Distance => ("the distance mode", "G90 or G91"),
        Group::Retract => ("the retract level", "G98 or G99"),
        Group::Motion => ("the motion mode", "G0, G1, G2 or G3"),
        Group::Exact => ("exact stop", "G61 or G64"),
        Group::Feed => ("the feed", "F"),
        Group::R => ("R of the cycle", "R"),
        Group::Z => ("Z of the cycle", "Z"),
        Group::P => ("P of the cycle", "P"),
        Group::Q => ("Q of the cycle", "Q"),
        Group::Held | Group::Class => ("the state", "the word"),
    }
}
