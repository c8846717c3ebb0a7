//! Requests from a card to its board: in turn with all others, except stops, which go first.
//! Stops are counted, so that a request made before one is not executed after it.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::channel;
use std::sync::{Arc, Weak};

use lang::wire::{self, Control, Direct, Exception, RunState, command};

use super::talk::Stop;
use crate::client::ClientError;
use crate::gateway::Gateway;
use crate::gateway::line::Board;
use crate::gateway::turns::Asker;

/// What the card answers instead of `0`.
pub type Answer = char;
/// A limit, or a switch that was not found.
pub const LIMIT: Answer = '2';
/// The user stopped it; also when the board is not there any more.
pub const STOPPED: Answer = 'F';
/// It cannot be done now.
pub const NOT_NOW: Answer = '5';
/// The machine is not the one of the card's file.
pub const NO_MACHINE: Answer = '4';

/// Counts stops, and sends them to the board past all that waits.
#[derive(Clone)]
pub struct Stopper {
    pub(super) gateway: Weak<Gateway>,
    pub(super) board: usize,
    pub(super) asker: Asker,
    pub(super) count: Arc<AtomicU64>,
    /// The last one was a software stop.
    software: Arc<AtomicBool>,
}

impl Stopper {
    /// For the board with this number in the gateway's file.
    pub fn new(gateway: &Arc<Gateway>, board: usize, asker: Asker) -> Stopper {
        let gateway = Arc::downgrade(gateway);
        Stopper { gateway, board, asker, count: Arc::default(), software: Arc::default() }
    }

    /// Whether a software stop came since there were so many stops.
    pub fn was_software(&self, stops: u64) -> bool {
        self.count() != stops && self.software.load(Ordering::SeqCst)
    }

    /// Stops what moves, as the byte wants it. It does not wait for the board.
    pub fn stop(&self, stop: Stop) {
        self.software.store(stop == Stop::Software, Ordering::SeqCst);
        self.count.fetch_add(1, Ordering::SeqCst);
        self.send(stop);
    }

    /// How many stops there were.
    pub fn count(&self) -> u64 {
        self.count.load(Ordering::SeqCst)
    }

    /// The gateway ends: a stored program goes on, what a client's command moves does not.
    pub fn end(&self) {
        self.count.fetch_add(1, Ordering::SeqCst);
        // Nobody is left who could be told that it did not help.
        let _ = self.ask(true, |board| {
            let runs = board.run_state()?.0.is_some_and(is_running);
            if runs { Ok(()) } else { halt(board, Stop::Software, false) }
        });
    }

    /// Sends a stop past all that waits; it is not counted.
    pub fn send(&self, stop: Stop) {
        let Some(gateway) = self.gateway.upgrade() else { return };
        let place = &gateway.places[self.board];
        let job = Box::new(move |board: Result<&mut Board, &str>| {
            if let Ok(board) = board {
                let runs = board.run_state().is_ok_and(|(state, _)| state.is_some_and(is_running));
                // Who asked for it sees by its looks whether it helped.
                let _ = halt(board, stop, runs);
            }
        });
        gateway.lines[place.line].order(self.asker, place.station, true, job);
    }

    /// Does something with the board, in its turn; the answer for a client when it cannot be done.
    ///
    /// # Errors
    /// The board is not there, or does not do it.
    pub fn ask<T: Send + 'static>(
        &self,
        urgent: bool,
        job: impl FnOnce(&mut Board) -> Result<T, ClientError> + Send + 'static,
    ) -> Result<T, Trouble> {
        let gateway = self.gateway.upgrade().ok_or(Trouble::Gone)?;
        let place = &gateway.places[self.board];
        let (to, done) = channel();
        let job = Box::new(move |board: Result<&mut Board, &str>| {
            let result = board.map_err(|_| Trouble::Gone);
            let result = result.and_then(|board| job(board).map_err(Trouble::Board));
            // Whoever waits for it is there.
            let _ = to.send(result);
        });
        gateway.lines[place.line].order(self.asker, place.station, urgent, job);
        drop(gateway);
        done.recv().unwrap_or(Err(Trouble::Gone))
    }
}

/// Why the board did not do it.
#[derive(Debug)]
pub enum Trouble {
    /// It is not there.
    Gone,
    /// It refused, or did not answer.
    Board(ClientError),
}

impl Trouble {
    /// What the card answers.
    pub fn answer(&self) -> Answer {
        match self {
            Trouble::Board(error) if error.is_exception(Exception::IllegalValue) => LIMIT,
            Trouble::Board(error) if error.is_exception(Exception::Busy) => NOT_NOW,
            _ => STOPPED,
        }
    }
}

/// Whether a stored program is under way.
pub const fn is_running(state: RunState) -> bool {
    matches!(state, RunState::Running | RunState::WaitStart | RunState::Paused | RunState::Stopping)
}

/// Ends what moves.
fn halt(board: &mut Board, stop: Stop, runs: bool) -> Result<(), ClientError> {
    match stop {
        Stop::Reset => board.write(wire::RUN_CONTROL, Control::EmergencyStop as u16),
        Stop::Pause if runs => board.write(wire::RUN_CONTROL, Control::Pause as u16),
        Stop::Pause | Stop::Software => {
            board.write_all(wire::COMMAND, &[command::DIRECT, u16::from(Direct::Stop as u8)])
        }
    }
}
