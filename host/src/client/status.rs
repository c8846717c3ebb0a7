//! Status of a board, and run control.

use std::time::Duration;

use lang::axis::Axis;
use lang::fault::{Fault, LATE_LINE};
use lang::wire::{self, Control, End, RunState};
use serde::Serialize;

use super::aout::AoutValue;
use super::identity::part_of;
use super::{Client, ClientError};
use crate::link::Link;
use crate::sim::trace::{PerAxis, What};

/// How long a run control may take to show in the state: a ramp down from the top rate.
const CONTROL_PATIENCE: Duration = Duration::from_secs(5);

/// A board's state at one instant.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Status {
    /// What it does.
    pub state: &'static str,
    /// Fault code such as `F07`, of a latched fault or the last run's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fault: Option<String>,
    /// The fault's text.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub text: Option<&'static str>,
    /// Where the fault usually comes from, and what to do about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub advice: Option<[&'static str; 2]>,
    /// Its line, where the program tells lines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<u16>,
    /// Offset in the code of the statement that it came from.
    #[serde(skip)]
    pub fault_pc: u16,
    /// The input that caused it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub input: Option<u16>,
    /// How the last run ended: `done`, `stopped`, `fault`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub last_end: Option<&'static str>,
    /// Runs begun since reset.
    pub runs: u16,
    /// Offset in the code of the statement that runs.
    pub program_counter: u16,
    /// Machine positions, steps.
    pub pos: PerAxis,
    /// Axes that are homed.
    pub homed: Vec<char>,
    /// Axes that move.
    pub moving: Vec<char>,
    /// Inputs that are on.
    pub inputs: Vec<u16>,
    /// Outputs that are on.
    pub outputs: Vec<u16>,
    /// Analog outputs, of boards whose profile has them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub analog_outputs: Vec<AoutValue>,
    /// Input that keeps Start or a move from working.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub blocked_by: Option<u16>,
    /// What the number of the state means.
    #[serde(skip)]
    pub run_state: Option<RunState>,
}

impl Status {
    /// Whether its fault may be a line of a path that came too late, which
    /// [`explain_late_line`](Client::explain_late_line) finds out: F14 without an input.
    pub fn may_be_late_line(&self) -> bool {
        self.fault.as_ref() == Some(&Fault::EmergencyStop.to_string()) && self.input.is_none()
    }
}

/// The word for a state in `status`.
pub const fn state_name(state: RunState) -> &'static str {
    match state {
        RunState::Empty => "empty",
        RunState::Ready => "ready",
        RunState::Running => "running",
        RunState::Paused => "paused",
        RunState::Fault => "fault",
        RunState::WaitStart => "waitstart",
        RunState::Stopping => "stopping",
    }
}

/// What a [`Status`] is read from.
#[derive(Clone, Debug, Default)]
pub struct StatusWords {
    /// [`StatusWords::RUN_LENGTH`] registers from [`wire::RUN_STATE`] on.
    pub run: Vec<u16>,
    /// [`wire::MOVING`].
    pub moving: u16,
    /// Inputs 1 to 17.
    pub inputs: Vec<bool>,
    /// Outputs 1 to 16.
    pub outputs: Vec<bool>,
    /// Analog outputs.
    pub aouts: Vec<AoutValue>,
}

impl StatusWords {
    /// Registers of the run: up to the commanded positions.
    pub const RUN_LENGTH: u16 = wire::COMMANDED - wire::RUN_STATE;

    /// What they say; registers that are not there read 0.
    pub fn status(&self) -> Status {
        let at = |register: u16| {
            self.run.get(usize::from(register - wire::RUN_STATE)).copied().unwrap_or(0)
        };
        let run_state = RunState::from_number(at(wire::RUN_STATE));
        let fault = u8::try_from(at(wire::FAULT)).ok().and_then(Fault::from_number);
        let letters = |bits: u16| {
            let on = Axis::ALL.into_iter().filter(|axis| bits >> axis.index() & 1 != 0);
            on.map(Axis::letter).collect()
        };
        let last_end = match End::from_number(at(wire::LAST_END)) {
            Some(End::Done) => Some("done"),
            Some(End::Stopped) => Some("stopped"),
            Some(End::Fault) => Some("fault"),
            Some(End::None) | None => None,
        };
        let position = |axis: Axis| {
            let register = wire::MACHINE_POSITIONS + 2 * axis.index() as u16;
            Some(long(at(register), at(register + 1)))
        };
        let some = |register: u16| Some(at(register)).filter(|n| *n != 0);
        Status {
            state: run_state.map_or("unknown", state_name),
            fault: fault.map(|fault| fault.to_string()),
            text: fault.map(Fault::text),
            advice: fault.map(|fault| [fault.cause(), fault.remedy()]),
            line: some(wire::FAULT_LINE),
            fault_pc: at(wire::FAULT_PC),
            input: some(wire::FAULT_INPUT),
            last_end,
            runs: at(wire::RUN_COUNT),
            program_counter: at(wire::PROGRAM_COUNTER),
            pos: PerAxis::new(Axis::ALL.map(position)),
            homed: letters(at(wire::HOMED)),
            moving: letters(self.moving & 0xFF),
            inputs: on(&self.inputs),
            outputs: on(&self.outputs),
            analog_outputs: self.aouts.clone(),
            blocked_by: some(wire::BLOCKING_INPUT),
            run_state,
        }
    }
}

/// What keeps the board from starting or moving ([`Status::blocked_by`]), a clause.
pub fn holds(input: u16) -> String {
    match input {
        wire::UNWIRED => {
            "it was never told how it is wired: `pasapas profile set FILE` says so".to_owned()
        }
        input => format!("input {input} holds it"),
    }
}

impl<L: Link> Client<L> {
    /// Reads the board's state, without its analog outputs ([`Client::aouts`]).
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn status(&mut self) -> Result<Status, ClientError> {
        let words = StatusWords {
            // Before the places: what rests then is read where it rests.
            moving: self.input(wire::MOVING, 1)?[0],
            run: self.holding(wire::RUN_STATE, StatusWords::RUN_LENGTH)?,
            inputs: self.inputs(wire::INPUT_BITS, 17)?,
            outputs: self.coils(wire::COILS, 16)?,
            aouts: Vec::new(),
        };
        let mut status = words.status();
        if status.may_be_late_line() {
            self.explain_late_line(&mut status)?;
        }
        Ok(status)
    }

    /// Puts text and advice of a line that came too late where the F14 of `status` was one.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn explain_late_line(&mut self, status: &mut Status) -> Result<(), ClientError> {
        if self.was_late_line(status)? {
            let [text, cause, remedy] = LATE_LINE;
            (status.text, status.advice) = (Some(text), Some([cause, remedy]));
        }
        Ok(())
    }

    /// The same end of a run, with the text of a line that came too late where its F14 was one; other events as they are.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn explain_end(&mut self, mut what: What) -> Result<What, ClientError> {
        if let What::End { fault: Some(fault), text, .. } = &mut what
            && *fault == Fault::EmergencyStop.to_string()
        {
            *text = self.status()?.text.map(str::to_owned);
        }
        Ok(what)
    }

    /// Whether F14 was a line of a path that came too late: a part that takes slow points keeps the number of that run.
    fn was_late_line(&mut self, status: &Status) -> Result<bool, ClientError> {
        let words = self.holding(wire::FEATURES, wire::MISSED_DEADLINES - wire::FEATURES + 1)?;
        let run = words[words.len() - 1] >> 8;
        let takes = part_of(words[0]).course_pool > 0;
        Ok(takes && run != 0 && run == status.runs & 0xFF)
    }

    /// The run state alone, with the number of runs begun.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn run_state(&mut self) -> Result<(Option<RunState>, u16), ClientError> {
        let words = self.holding(wire::RUN_STATE, wire::RUN_COUNT - wire::RUN_STATE + 1)?;
        Ok((RunState::from_number(words[0]), words[words.len() - 1]))
    }

    /// Writes a run control once: `Start` means several things, so it must not be repeated when
    /// only its reply was lost.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn control(&mut self, control: Control) -> Result<(), ClientError> {
        let length = match control {
            Control::Start => self.holding(wire::PROGRAM_LENGTH, 1)?[0],
            _ => 0,
        };
        self.while_it_checks(length.into(), |client| {
            client.once(|client| client.write(wire::RUN_CONTROL, control as u16))
        })
    }

    /// Waits until the state is one of `wanted`, or says which it stayed in.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn wait_for(
        &mut self,
        wanted: &[RunState],
    ) -> Result<Result<RunState, Option<RunState>>, ClientError> {
        let end = self.link().now() + CONTROL_PATIENCE;
        loop {
            let (state, _) = self.run_state()?;
            if let Some(state) = state.filter(|state| wanted.contains(state)) {
                return Ok(Ok(state));
            }
            if self.link().now() >= end {
                return Ok(Err(state));
            }
            self.link().pause(Duration::from_millis(20));
        }
    }
}

/// A 32-bit value, low word first.
pub fn long(low: u16, high: u16) -> i32 {
    (u32::from(high) << 16 | u32::from(low)).cast_signed()
}

fn on(bits: &[bool]) -> Vec<u16> {
    (1..).zip(bits).filter(|(_, on)| **on).map(|(n, _)| n).collect()
}
