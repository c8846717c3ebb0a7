//! Background poller of the boards of a line: one exchange at a time, between the requests of clients.

use std::sync::Arc;
use std::time::Instant;

use super::line::{Board, Look, Seen, Watch};
use super::named::Names;
use super::station::Station;
use crate::client::ClientError;
use crate::client::print::LINE_END;
use crate::helm::{Picture, Round};

/// Bytes of a printed line that is still open; a longer one is told in pieces.
const LONGEST_LINE: usize = 1024;

/// The state of looking at a board.
struct One {
    round: Round,
    /// The round's picture, while the program's variables are still to be read.
    picture: Option<Picture>,
    names: Names,
    began: Instant,
    due: Instant,
    /// Print that has no line end yet.
    line: Vec<u8>,
    /// What was told last: it answers, it does not.
    up: Option<bool>,
}

/// The looks at all boards of a line.
pub struct Looks {
    watch: Watch,
    each: Vec<One>,
}

impl Looks {
    /// Looks at so many boards.
    pub fn new(watch: Watch, count: usize) -> Looks {
        let one = || {
            let now = Instant::now();
            One {
                round: Round::new(),
                picture: None,
                names: Names::default(),
                began: now,
                due: now,
                line: Vec::new(),
                up: None,
            }
        };
        Looks { watch, each: (0..count).map(|_| one()).collect() }
    }

    /// Which board's look is due next, and when. Those that are left alone are not looked at.
    pub fn next(&self, stations: &[Arc<Station>]) -> Option<(usize, Instant)> {
        let places = self.each.iter().enumerate().filter(|(place, _)| stations[*place].may_ask());
        places.map(|(place, one)| (place, one.due)).min_by_key(|(_, due)| *due)
    }

    /// Makes the next exchange of a look.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn look(&mut self, place: usize, board: &mut Board) -> Result<(), ClientError> {
        let one = &mut self.each[place];
        if one.picture.is_some() {
            if !one.names.look(board)? {
                self.tell(place);
            }
            return Ok(());
        }
        if one.round.is_fresh() {
            one.began = Instant::now();
            if self.watch.prints {
                one.line.extend(board.take_print()?);
            }
            while let Some(end) = one.line.iter().position(|byte| *byte == LINE_END) {
                let text: Vec<u8> = one.line.drain(..=end).collect();
                let text = String::from_utf8_lossy(&text[..end]).into_owned();
                (self.watch.tell)(place, Look::Print(text));
            }
            if one.line.len() > LONGEST_LINE {
                let text = String::from_utf8_lossy(&std::mem::take(&mut one.line)).into_owned();
                (self.watch.tell)(place, Look::Print(text));
            }
        }
        let picture = one.round.look(board)?;
        // What hardly takes time goes on at once, the next round when it is time.
        one.due = Instant::now();
        if let Some(picture) = picture {
            let crc = picture.identity.as_ref().map(|identity| identity.program_crc);
            one.names.begin(crc.and_then(|crc| (self.watch.program)(place, crc)));
            one.picture = Some(picture);
            if one.names.is_empty() {
                self.tell(place);
            }
        }
        Ok(())
    }

    /// Tells what a whole round brought.
    fn tell(&mut self, place: usize) {
        let one = &mut self.each[place];
        let Some(mut picture) = one.picture.take() else { return };
        if let Some(status) = picture.status.as_mut().filter(|status| status.fault.is_some()) {
            status.line = status.line.or_else(|| one.names.line(status.fault_pc));
        }
        (one.up, one.due) = (Some(true), one.began + self.watch.every);
        let seen = Seen { picture, variables: one.names.values() };
        (self.watch.tell)(place, Look::Picture(Box::new(seen)));
    }

    /// A board does not answer.
    pub fn silent(&mut self, place: usize) {
        let one = &mut self.each[place];
        one.round.restart();
        one.picture = None;
        one.due = Instant::now() + self.watch.every;
        if one.up != Some(false) {
            one.up = Some(false);
            (self.watch.tell)(place, Look::Silent);
        }
    }
}
