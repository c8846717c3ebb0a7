//! Input and output of a card's client: bytes become lines, characters for a program that waits for
//! one, and stops.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Longest line; the card's own has 256 bytes for all that waits.
const LONGEST: usize = 255;
/// Lines that wait.
const MOST_LINES: usize = 4_096;
/// Characters that wait for a program.
const MOST_CHARACTERS: usize = 256;

/// A byte that stops, at any time and in the middle of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// 253: stop; a stored program may go on by `@0S`.
    Pause,
    /// 254: reset of the card.
    Reset,
    /// 255: software stop (binder, "Arrêt du logiciel").
    Software,
}

/// Whose conversation it is: clients come and go.
pub type Visit = u64;

/// What comes next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Heard {
    /// Whose it is.
    pub visit: Visit,
    /// How many stops there were when it was said: none of these is meant for it.
    pub stops: u64,
    /// What.
    pub said: Said,
}

/// What was said.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Said {
    /// A whole line.
    Line(String),
    /// Something that is answered by this character.
    Refused(char),
    /// The card was reset.
    Reset,
}

#[derive(Default)]
struct State {
    visit: Visit,
    lines: VecDeque<(u64, Said)>,
    /// The line that comes.
    half: Vec<u8>,
    /// What is wrong with it.
    flaw: Option<char>,
    /// A stored program runs: what is no line is for it.
    runs: bool,
    characters: VecDeque<u8>,
    out: Vec<u8>,
    /// What stands behind answers.
    end: Vec<u8>,
    usual_end: &'static [u8],
}

/// See the module.
pub struct Talk {
    state: Mutex<State>,
    came: Condvar,
}

impl Talk {
    /// Nobody has said anything; `end` stands behind answers.
    pub fn new(end: &'static [u8]) -> Talk {
        let state = State { end: end.to_vec(), usual_end: end, ..State::default() };
        Talk { state: Mutex::new(state), came: Condvar::new() }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes a byte, behind so many stops. A stop is to be carried out by the caller at once.
    pub fn take(&self, byte: u8, stops: u64) -> Option<Stop> {
        let mut state = self.state();
        match byte {
            253 => return Some(Stop::Pause),
            254 => return Some(Stop::Reset),
            255 => return Some(Stop::Software),
            b'\r' | b'\n' => {
                let half = std::mem::take(&mut state.half);
                let flaw = state.flaw.take();
                let text = String::from_utf8_lossy(&half).trim().to_owned();
                if text.is_empty() && flaw.is_none() {
                    return None;
                }
                // Once a line was lost no later one counts until all that waits is answered.
                let lost = state.lines.len() >= MOST_LINES
                    || matches!(state.lines.back(), Some((_, Said::Refused('6'))));
                if state.lines.len() < 2 * MOST_LINES {
                    let said = match flaw {
                        _ if lost => Said::Refused('6'),
                        Some(flaw) => Said::Refused(flaw),
                        None => Said::Line(text),
                    };
                    state.lines.push_back((stops, said));
                }
                self.came.notify_one();
            }
            _ if state.runs && state.half.is_empty() && byte != b'@' => {
                if state.characters.len() < MOST_CHARACTERS && (33..=125).contains(&byte) {
                    state.characters.push_back(byte);
                }
            }
            _ => {
                if !(byte == b' ' || byte == b'\t' || byte.is_ascii_graphic()) {
                    state.flaw.get_or_insert('5');
                }
                if state.half.len() >= LONGEST {
                    state.flaw.get_or_insert('5');
                } else {
                    state.half.push(byte);
                }
            }
        }
        None
    }

    /// Everything that waited, and the line in whose middle the stop came, is answered by `F` instead of
    /// being carried out; a reset forgets it.
    pub fn stopped(&self, stop: Stop) {
        let mut state = self.state();
        if stop == Stop::Reset {
            state.lines.clear();
            state.half.clear();
            state.flaw = None;
            state.characters.clear();
            state.out.clear();
            state.end = state.usual_end.to_vec();
            // A card that was reset answers nothing of before.
            state.visit += 1;
            state.lines.push_back((0, Said::Reset));
        } else {
            state.lines.iter_mut().for_each(|(_, said)| *said = Said::Refused('F'));
            if !state.half.is_empty() {
                state.flaw = Some('F');
            }
        }
        self.came.notify_one();
    }

    /// The client is gone: what it said and was not carried out is forgotten, and the next one hears
    /// no answer of this one's.
    pub fn left(&self) {
        let mut state = self.state();
        state.visit += 1;
        state.lines.clear();
        state.half.clear();
        state.flaw = None;
        state.characters.clear();
        state.out.clear();
        state.end = state.usual_end.to_vec();
    }

    /// What comes next; none within the time.
    pub fn next(&self, wait: Duration) -> Option<Heard> {
        let mut state = self.state();
        if state.lines.is_empty() {
            state = self.came.wait_timeout(state, wait).unwrap_or_else(PoisonError::into_inner).0;
        }
        let (stops, said) = state.lines.pop_front()?;
        Some(Heard { visit: state.visit, stops, said })
    }

    /// Answers a line of a visit with a character and more behind it.
    pub fn answer(&self, visit: Visit, answer: char, more: &str) {
        let mut state = self.state();
        if state.visit == visit {
            let State { out, end, .. } = &mut *state;
            out.extend(answer.to_string().bytes());
            out.extend(more.bytes());
            out.extend(&*end);
        }
    }

    /// Sends a character that a program sends.
    pub fn send(&self, byte: u8) {
        self.state().out.push(byte);
    }

    /// Answers have CR and LF behind them from now on, or what they had at first.
    pub fn set_handshake(&self, on: bool) {
        let mut state = self.state();
        state.end = if on { b"\r\n".to_vec() } else { state.usual_end.to_vec() };
    }

    /// Whether a stored program runs, which may wait for characters.
    pub fn set_runs(&self, runs: bool) {
        let mut state = self.state();
        state.runs = runs;
        state.characters.clear();
    }

    /// A character for the program.
    pub fn character(&self) -> Option<u8> {
        self.state().characters.pop_front()
    }

    /// Takes what is to go out.
    pub fn outgoing(&self) -> Vec<u8> {
        std::mem::take(&mut self.state().out)
    }
}

#[cfg(test)]
mod tests {
    use super::{MOST_LINES, Said, Stop, Talk};
    use std::time::Duration;

    fn said(talk: &Talk) -> Vec<Said> {
        std::iter::from_fn(|| talk.next(Duration::ZERO)).map(|heard| heard.said).collect()
    }

    fn say(talk: &Talk, bytes: &[u8]) -> Vec<Stop> {
        bytes.iter().filter_map(|byte| talk.take(*byte, 0)).collect()
    }

    fn line(text: &str) -> Said {
        Said::Line(text.to_owned())
    }

    #[test]
    fn lines_end_as_each_program_ends_them() {
        let talk = Talk::new(b"");
        say(&talk, b"@07\r@0R7\r\n@0P\n\r\r\n 9 \r@0");
        assert_eq!(said(&talk), [line("@07"), line("@0R7"), line("@0P"), line("9")]);
        say(&talk, b"P\r");
        assert_eq!(said(&talk), [line("@0P")]);
    }

    #[test]
    fn garbage_and_endless_lines_are_answered_and_nothing_else() {
        let talk = Talk::new(b"");
        say(&talk, b"@0\x80A 5\r\0\r");
        say(&talk, &[b'1'; 100_000]);
        assert_eq!(said(&talk), [Said::Refused('5'), Said::Refused('5')]);
        say(&talk, b"\r@0P\r");
        assert_eq!(said(&talk), [Said::Refused('5'), line("@0P")]);
    }

    #[test]
    fn a_stop_acts_in_the_middle_of_a_line_and_undoes_what_waits() {
        let talk = Talk::new(b"");
        assert_eq!(say(&talk, b"@0A 5,900\r@0A 7"), []);
        let stops = say(&talk, b"\xFF");
        assert_eq!(stops, [Stop::Software]);
        talk.stopped(stops[0]);
        say(&talk, b",900\r@0P\r");
        assert_eq!(said(&talk), [Said::Refused('F'), Said::Refused('F'), line("@0P")]);
        say(&talk, b"@0A 5,900\r@0");
        talk.stopped(Stop::Reset);
        say(&talk, b"@07\r");
        assert_eq!(said(&talk), [Said::Reset, line("@07")]);
    }

    #[test]
    fn after_a_lost_line_none_counts_until_all_are_answered() {
        let talk = Talk::new(b"");
        for _ in 0..MOST_LINES + 5 {
            say(&talk, b"@0A 1,900\r");
        }
        let all = said(&talk);
        assert_eq!(all.len(), MOST_LINES + 5);
        assert!(all[MOST_LINES..].iter().all(|one| *one == Said::Refused('6')));
        say(&talk, b"@0P\r");
        assert_eq!(said(&talk), [line("@0P")]);
    }

    #[test]
    fn who_comes_next_hears_no_answer_of_who_left() {
        let talk = Talk::new(b"\r");
        say(&talk, b"@0R7\r@0A 1,900\r");
        let visit = talk.next(Duration::ZERO).expect("a line").visit;
        talk.left();
        talk.answer(visit, '0', "");
        assert_eq!((talk.outgoing(), said(&talk)), (Vec::new(), Vec::new()));
        say(&talk, b"@0P\r");
        let visit = talk.next(Duration::ZERO).expect("a line").visit;
        talk.answer(visit, '0', "00");
        talk.set_handshake(true);
        talk.answer(visit, '5', "");
        assert_eq!(talk.outgoing(), b"000\r5\r\n");
    }

    #[test]
    fn a_program_that_runs_gets_characters_and_lines_stay_lines() {
        let talk = Talk::new(b"");
        talk.set_runs(true);
        say(&talk, b"3\r@0Q\rZ");
        assert_eq!(said(&talk), [line("@0Q")]);
        assert_eq!(
            [talk.character(), talk.character(), talk.character()],
            [Some(b'3'), Some(b'Z'), None]
        );
    }
}
