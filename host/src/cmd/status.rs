//! `pasapas status` and `pasapas watch`: the state of a board.

use std::time::Duration;

use crate::client::identity::late_clause;
use crate::client::print::LINE_END;
use clap::Args;
use lang::axis::Axis;
use lang::wire::{self, RunState};

use super::console::{Console, Options};
use super::port::{Board, Port};
use crate::client::status::{Status as State, holds};
use crate::failure::Failure;

/// `pasapas status`
#[derive(Debug, Args)]
pub struct Status {
    #[command(flatten)]
    port: Port,
}

impl Status {
    /// Prints the state once.
    ///
    /// # Errors
    /// The board does not answer.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let mut board = self.port.connect(options, console)?;
        let identity = board.identity()?;
        let mut state = board.status()?;
        let unit = board.aout_unit()?;
        state.analog_outputs = board.aouts(unit)?;
        let late_events = board.late_events()?;
        if console.json() {
            let mut line = serde_json::to_value(&state).unwrap_or_default();
            if let Some(object) = line.as_object_mut() {
                object.insert(
                    "board".to_owned(),
                    serde_json::to_value(&identity).unwrap_or_default(),
                );
                object.insert("late_events".to_owned(), late_events.into());
                if let Some([cause, remedy]) = state.advice {
                    object.insert("cause".to_owned(), cause.into());
                    object.insert("remedy".to_owned(), remedy.into());
                }
            }
            return console.json_line(&line);
        }
        let mut text = describe(&state);
        text += &format!(
            "program   {}\nboard     firmware {}, register map {}, instruction set {:04X}\n\
             health    {} bytes of stack never used, {} ms served late (erasing flash makes some), reset \
             cause {}\n{}",
            match identity.program_bytes {
                0 => format!("none, {} bytes free", identity.free_bytes),
                bytes => format!("{bytes} bytes, {} more fit beside it", identity.free_bytes),
            },
            identity.firmware,
            identity.wire_version,
            identity.instruction_set,
            identity.stack_free,
            identity.missed_deadlines,
            reset_cause(identity.reset_cause),
            late_clause(late_events).map_or_else(String::new, |text| format!("steps     {text}\n")),
        );
        console.result(&text)
    }
}

/// The bits of the reset's cause in words.
fn reset_cause(bits: u16) -> String {
    let names = [
        (2, "power on"),
        (3, "RST pin"),
        (0, "watchdog"),
        (4, "NMI"),
        (5, "the crystal does not run"),
        (6, "the crystal failed, and runs again"),
    ];
    let set: Vec<&str> =
        names.iter().filter(|(bit, _)| bits >> bit & 1 != 0).map(|(_, name)| *name).collect();
    if set.is_empty() { "software".to_owned() } else { set.join(", ") }
}

/// The state for people.
fn describe(state: &State) -> String {
    let mut text = format!("state     {}", state.state);
    if let Some(fault) = &state.fault {
        text += &format!(", {fault} {}", state.text.unwrap_or_default());
        if let Some(line) = state.line {
            text += &format!(" in line {line}");
        }
        if let Some(input) = state.input {
            text += &format!(", input {input}");
        }
    }
    if let Some(end) = state.last_end {
        text += &format!(" (last run: {end})");
    }
    if let Some([cause, remedy]) = state.advice {
        text += &format!("\ncause     {cause}\nremedy    {remedy}");
    }
    text += "\nposition ";
    for (axis, place) in Axis::ALL.into_iter().zip(state.pos.values()) {
        let homed = if state.homed.contains(&axis.letter()) { "" } else { " (not homed)" };
        text += &format!(" {} {} st{homed}", axis.letter(), place.unwrap_or(0));
    }
    let list = |numbers: &[u16]| {
        let words: Vec<String> = numbers.iter().map(u16::to_string).collect();
        if words.is_empty() { "none".to_owned() } else { words.join(" ") }
    };
    text += &format!("\ninputs    on: {}", list(&state.inputs));
    text += &format!("\noutputs   on: {}\n", list(&state.outputs));
    for own in &state.analog_outputs {
        text += &format!("analog    output {own}\n");
    }
    if let Some(input) = state.blocked_by {
        text += &match input {
            wire::UNWIRED => format!("blocked   {}\n", holds(input)),
            input => format!("blocked   by input {input}\n"),
        };
    }
    text
}

/// `pasapas watch`
#[derive(Debug, Args)]
pub struct Watch {
    #[command(flatten)]
    port: Port,
    /// Time between two looks
    #[arg(long, value_name = "MS", default_value_t = 200)]
    every: u64,
    /// End after this many looks
    #[arg(long, value_name = "N")]
    count: Option<u64>,
}

impl Watch {
    /// Prints what PRINT writes and every change of state, until the board is gone.
    ///
    /// # Errors
    /// The board does not answer any more.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let mut board = self.port.connect(options, console)?;
        let mut before = None;
        let mut looks = 0;
        let mut line = Vec::new();
        let unit = board.aout_unit()?;
        loop {
            // Nothing more comes of a line once its run has ended.
            let mut state = board.status()?;
            state.analog_outputs = board.aouts(unit)?;
            let rests = matches!(
                state.run_state,
                Some(RunState::Empty | RunState::Ready | RunState::Fault)
            );
            let mut lines = printed(&mut board, &mut line)?;
            if rests && !line.is_empty() {
                lines.push(String::from_utf8_lossy(&std::mem::take(&mut line)).into_owned());
            }
            for text in lines {
                if console.json() {
                    console.json_line(&serde_json::json!({ "print": text }))?;
                } else {
                    console.result(&format!("> {text}\n"))?;
                }
            }
            // Of what changes all the time only the place is told, in JSON.
            let calm = State { program_counter: 0, ..state.clone() };
            if before.as_ref() != Some(&calm) {
                if console.json() {
                    console.json_line(&state)?;
                } else {
                    console.result(&brief(&state))?;
                }
                before = Some(calm);
            }
            looks += 1;
            if self.count.is_some_and(|count| looks >= count) {
                return Ok(());
            }
            std::thread::sleep(Duration::from_millis(self.every));
        }
    }
}

/// One line for people.
fn brief(state: &State) -> String {
    let [x, y, z] = state.pos.values().map(|place| place.unwrap_or(0));
    let join = |numbers: &[u16]| numbers.iter().map(u16::to_string).collect::<Vec<_>>().join(",");
    let fault =
        state.fault.as_ref().map(|fault| format!(" {fault} {}", state.text.unwrap_or_default()));
    let analog = state.analog_outputs.iter().map(|own| format!("  analog {own}"));
    format!(
        "{}{}  X {x} Y {y} Z {z} st  in [{}]  out [{}]{}\n",
        state.state,
        fault.unwrap_or_default(),
        join(&state.inputs),
        join(&state.outputs),
        analog.collect::<String>()
    )
}

/// Takes what the board has printed; complete lines come back, the rest stays in `partial`.
fn printed(board: &mut Board, partial: &mut Vec<u8>) -> Result<Vec<String>, Failure> {
    let mut lines = Vec::new();
    // Some looks at a time: a program that prints without end must not keep the state from showing.
    for _ in 0..32 {
        let bytes = board.take_print()?;
        if bytes.is_empty() {
            break;
        }
        for byte in bytes {
            if byte == LINE_END {
                lines.push(String::from_utf8_lossy(partial).into_owned());
                partial.clear();
            } else {
                partial.push(byte);
            }
        }
    }
    Ok(lines)
}

#[cfg(test)]
mod tests {
    use lang::fault::Fault;
    use lang::wire::{FAULT, RUN_STATE, RunState};

    use super::{brief, describe};
    use crate::client::aout::AoutValue;
    use crate::client::status::StatusWords;

    #[test]
    fn a_fault_is_told_with_what_may_be_wrong_and_what_to_do() {
        let mut run = vec![0; usize::from(StatusWords::RUN_LENGTH)];
        run[0] = RunState::Fault as u16;
        run[usize::from(FAULT - RUN_STATE)] = Fault::ValueRange as u16;
        let told = describe(&StatusWords { run, ..StatusWords::default() }.status());
        for part in [
            "F20 value out of range",
            "SetPos or G92 names an axis that is moving",
            "WaitMove after START",
        ] {
            assert!(told.contains(part), "{told}");
        }
        let told = describe(&StatusWords::default().status());
        assert!(!told.contains("cause"), "{told}");
        assert!(!told.contains("analog"), "{told}");
    }

    #[test]
    fn an_analog_output_shows_its_value_with_its_unit() {
        let shown = |mv, share| {
            let aouts = vec![AoutValue { n: 1, mv, share }];
            let state = StatusWords { aouts, ..StatusWords::default() }.status();
            [describe(&state), brief(&state), serde_json::to_string(&state).unwrap_or_default()]
        };
        let of_voltage = [
            "analog    output 1 at 1500 mV\n",
            "  analog 1 at 1500 mV\n",
            r#""analog_outputs":[{"n":1,"mv":1500}]"#,
        ];
        let of_share = [
            "analog    output 1 at 40\n",
            "  analog 1 at 40\n",
            r#""analog_outputs":[{"n":1,"share":40}]"#,
        ];
        for (told, parts) in
            [(shown(Some(1500), None), of_voltage), (shown(None, Some(40)), of_share)]
        {
            for (text, part) in told.iter().zip(parts) {
                assert!(text.contains(part), "{text}");
            }
        }
    }
}
