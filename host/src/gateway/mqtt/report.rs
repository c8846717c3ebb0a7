//! Reports of a board: its state whenever it changes, and events.

use serde_json::{Map, Value, json};

use crate::gateway::line::{Look, Seen};
use crate::gateway::named::Named;
use crate::helm::Picture;

/// What was told of a board last.
pub struct Report {
    /// The board's name.
    pub name: String,
    /// The state as it was told, and as it is to be told.
    pub state: String,
    /// Runs begun, and whether one goes on.
    runs: Option<(u16, bool)>,
    /// Lines printed since the last picture, which tells the run that they belong to.
    lines: Vec<String>,
}

/// The state of a board that shows a picture.
fn state_of(seen: &Seen) -> Value {
    let picture = &seen.picture;
    let status = picture.status.as_ref().and_then(|status| serde_json::to_value(status).ok());
    let mut state = match status {
        Some(Value::Object(state)) => state,
        _ => Map::new(),
    };
    // It changes with each statement and says nothing to who has not the image.
    state.remove("program_counter");
    state.insert("health".to_owned(), json!("up"));
    if let Some(identity) = &picture.identity {
        state.insert("firmware".to_owned(), json!(identity.firmware));
        state.insert("program_crc".to_owned(), json!(identity.program_crc));
    }
    state.insert("cells".to_owned(), json!(picture.cells));
    let value = |named: &Named| named.real().map_or_else(|| json!(named.value), |real| json!(real));
    let variables: Map<String, Value> =
        seen.variables.iter().map(|named| (named.name.clone(), value(named))).collect();
    if !variables.is_empty() {
        state.insert("variables".to_owned(), Value::Object(variables));
    }
    Value::Object(state)
}

impl Report {
    /// Nothing is known yet.
    pub fn new(name: &str) -> Report {
        Report {
            name: name.to_owned(),
            state: json!({ "health": "unknown" }).to_string(),
            runs: None,
            lines: Vec::new(),
        }
    }

    /// Takes what a look brought: whether the state changed, and what happened, oldest first.
    pub fn hear(&mut self, look: Look) -> (bool, Vec<Value>) {
        let (state, events) = match look {
            Look::Print(text) => {
                self.lines.push(text);
                return (false, Vec::new());
            }
            Look::Silent => (json!({ "health": "silent" }), self.printed()),
            Look::Picture(seen) => (state_of(&seen), self.happened(&seen.picture)),
        };
        let state = state.to_string();
        let changed = state != self.state;
        self.state = state;
        (changed, events)
    }

    fn printed(&mut self) -> Vec<Value> {
        let lines = std::mem::take(&mut self.lines).into_iter();
        lines.map(|text| json!({ "event": "print", "text": text })).collect()
    }

    /// Begin, prints and end of a run in this order, though one look may find all of them.
    fn happened(&mut self, picture: &Picture) -> Vec<Value> {
        use lang::wire::RunState;
        let printed = self.printed();
        let Some(status) = &picture.status else { return printed };
        let on = |state| {
            matches!(
                state,
                RunState::Running | RunState::Paused | RunState::WaitStart | RunState::Stopping
            )
        };
        let (runs, goes_on) = (status.runs, status.run_state.is_some_and(on));
        let before = self.runs.replace((runs, goes_on));
        // What was before the gateway came is not known.
        let Some((old_runs, went_on)) = before else { return printed };
        let mut events = Vec::new();
        let begun = runs.wrapping_sub(old_runs);
        // The board counts runs since its reset.
        let reset = runs < old_runs && begun > u16::MAX / 2;
        if reset {
            events.push(json!({ "event": "reset" }));
        }
        let ended = |run: u16| {
            let mut event = json!({ "event": "end", "run": run, "status": status.last_end });
            if status.last_end == Some("fault") {
                event["event"] = json!("fault");
                event["fault"] = json!(status.fault);
                event["text"] = json!(status.text);
                event["line"] = json!(status.line);
                event["input"] = json!(status.input);
            }
            event
        };
        let starts = begun > 0 && !reset;
        if starts {
            let between = u32::from(begun) - 1 + u32::from(went_on);
            if between > 0 {
                // Runs that ended between two looks: how is not known of any but the last.
                events.push(json!({ "event": "ended_unseen", "count": between }));
            }
            events.push(json!({ "event": "start", "run": runs }));
        }
        events.extend(printed);
        if !goes_on && !reset && (starts || went_on) {
            events.push(ended(runs));
        }
        events
    }
}

#[cfg(test)]
mod tests {
    use super::Report;
    use crate::client::status::StatusWords;
    use crate::gateway::line::{Look, Seen};
    use crate::helm::Picture;
    use lang::wire::{self, End, RunState};

    fn picture(state: RunState, end: End, runs: u16) -> Look {
        let mut run = vec![0; usize::from(StatusWords::RUN_LENGTH)];
        let mut set = |register: u16, value: u16| {
            run[usize::from(register - wire::RUN_STATE)] = value;
        };
        set(wire::RUN_STATE, state as u16);
        set(wire::LAST_END, end as u16);
        set(wire::RUN_COUNT, runs);
        if end == End::Fault {
            set(wire::FAULT, 7);
            set(wire::FAULT_LINE, 12);
        }
        let words = StatusWords { run, ..StatusWords::default() };
        let status = Some(words.status());
        let picture = Picture { status, ..Picture::default() };
        Look::Picture(Box::new(Seen { picture, variables: Vec::new() }))
    }

    fn names(report: &mut Report, look: Look) -> Vec<String> {
        let events = report.hear(look).1;
        events.iter().map(|event| event["event"].as_str().unwrap_or_default().to_owned()).collect()
    }

    #[test]
    fn each_run_has_its_begin_and_its_end_however_short_it_was() {
        let mut report = Report::new("drill");
        let none: [&str; 0] = [];
        assert_eq!(names(&mut report, picture(RunState::Ready, End::Done, 3)), none);
        assert_eq!(names(&mut report, picture(RunState::Running, End::Done, 4)), ["start"]);
        assert_eq!(names(&mut report, picture(RunState::Paused, End::Done, 4)), none);
        assert_eq!(names(&mut report, picture(RunState::Ready, End::Done, 4)), ["end"]);
        names(&mut report, Look::Print("hello".to_owned()));
        let short = names(&mut report, picture(RunState::Ready, End::Done, 5));
        assert_eq!(short, ["start", "print", "end"]);
        let unseen = names(&mut report, picture(RunState::Running, End::Done, 8));
        assert_eq!(unseen, ["ended_unseen", "start"]);
        let (_, events) = report.hear(picture(RunState::Fault, End::Fault, 8));
        assert_eq!((&events[0]["fault"], &events[0]["line"]), (&"F07".into(), &12.into()));
        assert_eq!(names(&mut report, picture(RunState::Ready, End::None, 0)), ["reset"]);
    }

    #[test]
    fn the_state_is_told_when_it_changes_alone() {
        let mut report = Report::new("drill");
        assert!(report.hear(picture(RunState::Ready, End::Done, 3)).0);
        assert!(!report.hear(picture(RunState::Ready, End::Done, 3)).0);
        assert!(report.hear(Look::Silent).0);
        assert!(!report.hear(Look::Silent).0);
        assert!(!report.hear(Look::Print("x".to_owned())).0);
    }
}
