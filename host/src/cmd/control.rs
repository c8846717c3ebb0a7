//! `pasapas start`, `stop`, `pause` and `resume`: run control of a board.

use std::time::Duration;

use clap::Args;
use lang::wire::{self, Control as Code, Exception, RunState, command};

use super::console::{Console, Options};
use super::library;
use super::port::{Board, Port};
use crate::client::library::Called;
use crate::client::status::{holds, state_name};
use crate::failure::Failure;

/// One of the run controls.
#[derive(Debug, Args)]
pub struct Control {
    #[command(flatten)]
    port: Port,
}

/// `pasapas start`
#[derive(Debug, Args)]
pub struct Start {
    /// A program of the board's library, by name or number: Start runs it from now on
    #[arg(value_name = "NAME|N")]
    program: Option<Called>,
    #[command(flatten)]
    control: Control,
}

impl Start {
    /// Chooses the program, if one is named, and starts it.
    ///
    /// # Errors
    /// As those of [`Control::run`]; there is no such program.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let mut board = self.control.port.connect(options, console)?;
        if let Some(called) = &self.program {
            library::select(&mut board, called)?;
        }
        done(&mut board, Action::Start, console)
    }
}

/// How often axes that move are stopped.
const STOPS: u32 = 20;
/// Rest before it is done again: longer than another process waits between two targets of a held jog.
const AGAIN: Duration = Duration::from_millis(250);
/// Rest between two looks.
const LOOK: Duration = Duration::from_millis(20);

/// What to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Run the stored program, release WaitStart, or acknowledge a fault.
    Start,
    /// End the run on a ramp, or what moves by hand.
    Stop,
    /// Ramp down and pause.
    Pause,
    /// Go on with a paused run.
    Resume,
}

impl Control {
    /// Does it and waits until it shows in the board's state.
    ///
    /// # Errors
    /// The board does not answer, refuses, or stays in another state.
    pub fn run(&self, action: Action, options: &Options, console: &Console) -> Result<(), Failure> {
        let mut board = self.port.connect(options, console)?;
        done(&mut board, action, console)
    }
}

fn done(board: &mut Board, action: Action, console: &Console) -> Result<(), Failure> {
    let done = act(board, action)?;
    if done.acknowledged {
        console.complain("the fault is acknowledged; `pasapas start` again runs");
    }
    tell(done.state, console)
}

/// What an action led to.
#[derive(Clone, Copy, Debug)]
pub struct Done {
    /// The state behind it.
    pub state: RunState,
    /// Start found a fault and acknowledged it: nothing runs yet.
    pub acknowledged: bool,
}

/// Does it and waits until it shows in the board's state.
///
/// # Errors
/// The board does not answer, refuses, or stays in another state.
pub fn act(board: &mut Board, action: Action) -> Result<Done, Failure> {
    let (before, runs) = board.run_state()?;
    let (code, wanted): (Code, &[RunState]) = match (action, before) {
        (Action::Start, Some(RunState::Fault)) => (Code::Acknowledge, &IDLE),
        (Action::Start, _) => (Code::Start, &STARTED),
        (Action::Stop, _) => (Code::Stop, &IDLE),
        (Action::Pause, _) => (Code::Pause, &[RunState::Paused]),
        (Action::Resume, _) => (Code::Resume, &STARTED),
    };
    refuse_impossible(action, before)?;
    if action == Action::Stop && is_idle(before) {
        stop_axes(board)?;
    }
    send(board, code)?;
    let done = |state| Done { state, acknowledged: code == Code::Acknowledge };
    match board.wait_for(wanted)? {
        Ok(state) => Ok(done(state)),
        // A short program is over before its state is seen.
        Err(Some(state)) if board.run_state()?.1 != runs => Ok(done(state)),
        Err(state) => Err(Failure::Board(format!(
            "the board took the command but is {}{}",
            state.map_or("in an unknown state", state_name),
            blocked(board)?
        ))),
    }
}

/// No run, but a jog, homing or probing may be under way, of another process too. That one may be about to tell the axis
/// its next target, which would take the ramp back: what still moves is stopped again.
fn stop_axes(board: &mut Board) -> Result<(), Failure> {
    for _ in 0..STOPS {
        board.write_all(wire::COMMAND, &[command::STOP_AXES, 0b111])?;
        let until = board.link().now() + AGAIN;
        while board.link().now() < until {
            if board.status()?.moving.is_empty() {
                return Ok(());
            }
            board.link().pause(LOOK);
        }
    }
    Err(Failure::Board("an axis still moves: press the machine's Stop".to_owned()))
}

/// Whether no program runs.
pub fn is_idle(state: Option<RunState>) -> bool {
    state.is_some_and(|state| IDLE.contains(&state))
}

/// States in which nothing runs.
const IDLE: [RunState; 3] = [RunState::Ready, RunState::Empty, RunState::Fault];
/// States after a start.
const STARTED: [RunState; 2] = [RunState::Running, RunState::WaitStart];

fn refuse_impossible(action: Action, state: Option<RunState>) -> Result<(), Failure> {
    let text = match (action, state) {
        (Action::Start | Action::Resume, Some(RunState::Empty)) => {
            "the board holds no program, or none is chosen; `pasapas upload` brings one, `pasapas list` shows \
             those that there are"
        }
        (Action::Resume, Some(state)) if state != RunState::Paused => {
            "nothing is paused; `pasapas start` runs the stored program"
        }
        (Action::Pause, Some(state)) if IDLE.contains(&state) => "no program runs",
        _ => return Ok(()),
    };
    Err(Failure::Board(text.to_owned()))
}

fn send(board: &mut Board, code: Code) -> Result<(), Failure> {
    match board.control(code) {
        Ok(()) => Ok(()),
        // The reply may have been lost after the board took it: the state tells.
        Err(error) if error.may_be_done() => Ok(()),
        Err(error) if error.is_exception(Exception::Busy) => {
            Err(Failure::Board(format!("the board cannot do that now{}", blocked(board)?)))
        }
        Err(error) => Err(error.into()),
    }
}

/// The input that keeps it from happening, in words.
fn blocked(board: &mut Board) -> Result<String, Failure> {
    let status = board.status()?;
    Ok(match (status.blocked_by, status.fault) {
        (Some(input), _) => format!(": {}", holds(input)),
        (None, Some(fault)) => format!(": {fault} {}", status.text.unwrap_or_default()),
        (None, None) => String::new(),
    })
}

fn tell(state: RunState, console: &Console) -> Result<(), Failure> {
    if console.json() {
        return console.json_line(&serde_json::json!({ "state": state_name(state) }));
    }
    console.result(&format!("{}\n", state_name(state)))
}

#[cfg(test)]
mod tests {
    use super::{Code, send};
    use crate::client::Client;
    use crate::client::tests::{Scripted, framed};
    use crate::link::Link;

    #[test]
    fn a_start_whose_reply_is_lost_may_have_begun_and_one_that_is_refused_has_not() {
        let start = |reply: Vec<u8>| {
            // The length of the program comes first.
            let link = Scripted::new([framed(&[1, 3, 2, 0, 40]), reply]);
            let link: Box<dyn Link> = Box::new(link);
            send(&mut Client::new(link, 1), Code::Start)
        };
        for lost in [Vec::new(), framed(&[1, 0x86, 11])] {
            assert!(start(lost).is_ok(), "the state of the board tells");
        }
        assert!(start(framed(&[1, 0x86, 4])).is_err());
    }
}
