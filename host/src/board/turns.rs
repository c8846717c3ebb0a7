//! Several clients on the one line of a board: each asks in its turn and gets its own answer.
//!
//! A turn begins with a request and ends when the line is idle after the reply, or when no reply can
//! come any more. Then a Modbus TCP client gets the exception that gateways have for it; a
//! client that speaks as on a serial line gets nothing, as on a serial line.

use crate::link::adu::{Mbap, NotMbap, open_rtu, rtu, rtu_request};

/// Silence that ends a frame: 3.5 characters at 19200 bits per second and more (Modbus over Serial
/// Line V1.02, 2.5.1.1), and more than a character at 9600: within a reply the chip does not pause.
const SILENCE: u64 = 1_750;
/// A board has answered after this long: the commit of an upload takes it 300 ms (wire.rs, Upload).
const NO_ANSWER: u64 = 400_000;
/// At an address that has not answered before there is hardly a board; the others wait meanwhile.
const STRANGER: u64 = 100_000;
/// What is for all boards has no answer, but they need time for it (2.4.1: 100 to 200 ms).
const TURNAROUND: u64 = 150_000;
/// Time on the line of a character at the slowest rate, 11 bits at 9600.
const CHARACTER: u64 = 1_146;
/// `Gateway target device failed to respond` (Modbus Application Protocol V1.1b3, 7).
const NO_TARGET: u8 = 11;

/// How a client speaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Manner {
    /// RTU frames, or whatever bytes one puts on a line.
    Serial,
    /// Modbus TCP.
    Mbap,
}

/// A request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Question {
    /// Bytes for the line.
    Serial(Vec<u8>),
    /// A message of Modbus TCP.
    Mbap(Mbap),
}

/// What a client has asked and the board was not yet asked.
#[derive(Debug)]
pub struct Ask {
    manner: Manner,
    bytes: Vec<u8>,
}

impl Ask {
    /// Of a client that has asked nothing.
    pub fn new(manner: Manner) -> Ask {
        Ask { manner, bytes: Vec::new() }
    }

    /// Whether the client speaks as on a serial line.
    pub fn is_serial(&self) -> bool {
        self.manner == Manner::Serial
    }

    /// Where bytes that come are appended.
    pub fn bytes(&mut self) -> &mut Vec<u8> {
        &mut self.bytes
    }

    /// Bytes that wait.
    pub fn waiting(&self) -> usize {
        self.bytes.len()
    }

    /// The next request, if all of it is there; `gathered`: no more of it will come.
    ///
    /// # Errors
    /// The client should speak Modbus TCP and does not.
    pub fn next(&mut self, gathered: bool) -> Result<Option<Question>, NotMbap> {
        if self.manner == Manner::Mbap {
            return Ok(Mbap::take(&mut self.bytes)?.map(Question::Mbap));
        }
        let end = match rtu_request(&self.bytes) {
            Some(length) => length,
            None if gathered => self.bytes.len(),
            None => 0,
        };
        let rest = self.bytes.split_off(end);
        let question = std::mem::replace(&mut self.bytes, rest);
        Ok((end > 0).then_some(Question::Serial(question)))
    }
}

/// Bytes for a client.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Answer {
    /// For the client with this number.
    To(u64, Vec<u8>),
    /// The board sent them without being asked: every client that speaks as on a line hears them.
    Unasked(Vec<u8>),
}

struct Turn {
    client: u64,
    question: Question,
    /// The address that was asked; 0 is all.
    address: u8,
    /// When it ends without an answer.
    deadline: u64,
    heard: Vec<u8>,
    /// Of them, passed on.
    passed: usize,
    heard_at: u64,
}

/// See the module.
pub struct Turns {
    turn: Option<Turn>,
    unasked: Vec<u8>,
    /// The address that answered last: that of the board that is asked as unit 0 or 255.
    address: u8,
}

impl Default for Turns {
    fn default() -> Turns {
        Turns { turn: None, unasked: Vec::new(), address: 1 }
    }
}

impl Turns {
    /// Whether the next request may go to the line.
    pub fn is_free(&self) -> bool {
        self.turn.is_none()
    }

    /// It is `client`'s turn at `now`, in us; gives the bytes for the line.
    pub fn begin(&mut self, client: u64, question: Question, now: u64) -> Vec<u8> {
        let frame = match &question {
            Question::Serial(bytes) => bytes.clone(),
            Question::Mbap(message) => {
                let own = matches!(message.unit, 0 | 255);
                rtu(if own { self.address } else { message.unit }, &message.pdu)
            }
        };
        let sent = now + CHARACTER * frame.len() as u64;
        let (address, wait) = match open_rtu(&frame) {
            Some((0, _)) => (0, TURNAROUND),
            Some((address, _)) if address == self.address => (address, NO_ANSWER),
            Some((address, _)) => (address, STRANGER),
            // Nobody answers to what is no frame.
            None => (0, SILENCE),
        };
        self.turn = Some(Turn {
            client,
            question,
            address,
            deadline: sent + wait,
            heard: Vec::new(),
            passed: 0,
            heard_at: now,
        });
        frame
    }

    /// The board sent these bytes, each with its time, us.
    pub fn heard(&mut self, bytes: &[(u64, u8)]) {
        let text = bytes.iter().map(|(_, byte)| *byte);
        match (&mut self.turn, bytes.last()) {
            (Some(turn), Some((tick, _))) => {
                turn.heard.extend(text);
                turn.heard_at = *tick;
            }
            _ => self.unasked.extend(text),
        }
    }

    /// What is to be passed on at `now`; ends the turn when it is over.
    pub fn answers(&mut self, now: u64) -> Vec<Answer> {
        let mut answers = Vec::new();
        if !self.unasked.is_empty() {
            answers.push(Answer::Unasked(std::mem::take(&mut self.unasked)));
        }
        let Some(turn) = &mut self.turn else { return answers };
        let rests = now >= turn.heard_at + SILENCE;
        let reply = open_rtu(&turn.heard).filter(|_| rests);
        let good = reply.is_some_and(|(address, _)| address == turn.address);
        let over = good || now >= turn.deadline && rests;
        match &turn.question {
            Question::Serial(_) => {
                if turn.passed < turn.heard.len() {
                    answers.push(Answer::To(turn.client, turn.heard[turn.passed..].to_vec()));
                    turn.passed = turn.heard.len();
                }
            }
            Question::Mbap(message) if over => {
                let pdu = match reply {
                    Some((_, pdu)) if good => pdu.to_vec(),
                    _ => vec![message.pdu[0] | 0x80, NO_TARGET],
                };
                let answer = Mbap { pdu, ..*message };
                answers.push(Answer::To(turn.client, answer.bytes()));
            }
            Question::Mbap(_) => {}
        }
        if good {
            self.address = turn.address;
        }
        if over {
            self.turn = None;
        }
        answers
    }
}

#[cfg(test)]
mod tests {
    use super::{Answer, Ask, Manner, NO_ANSWER, NO_TARGET, Question, SILENCE, STRANGER, Turns};
    use crate::link::adu::{Mbap, rtu};

    const READ: [u8; 5] = [3, 0x13, 0x88, 0, 1];

    fn asked(manner: Manner, bytes: &[u8]) -> Question {
        let mut ask = Ask::new(manner);
        ask.bytes().extend(bytes);
        ask.next(false).expect("Modbus").expect("a whole request")
    }

    fn said(bytes: &[u8], from: u64) -> Vec<(u64, u8)> {
        bytes.iter().enumerate().map(|(i, byte)| (from + i as u64, *byte)).collect()
    }

    #[test]
    fn a_reply_goes_to_who_asked_and_in_his_manner() {
        let mut turns = Turns::default();
        let message = Mbap { transaction: 77, unit: 255, pdu: READ.to_vec() };
        let frame = turns.begin(5, asked(Manner::Mbap, &message.bytes()), 0);
        assert_eq!(frame, rtu(1, &READ));
        assert!(!turns.is_free());
        turns.heard(&said(&rtu(1, &[3, 2, 0, 9]), 1000));
        assert_eq!(turns.answers(1010), []);
        let reply = Mbap { transaction: 77, unit: 255, pdu: vec![3, 2, 0, 9] };
        assert_eq!(turns.answers(1010 + SILENCE), [Answer::To(5, reply.bytes())]);
        assert!(turns.is_free());

        let reply = rtu(1, &[3, 2, 0, 9]);
        turns.begin(6, asked(Manner::Serial, &rtu(1, &READ)), 0);
        turns.heard(&said(&reply, 1000));
        assert_eq!(turns.answers(1010), [Answer::To(6, reply)]);
        assert!(!turns.is_free());
        assert_eq!(turns.answers(1010 + SILENCE), []);
        assert!(turns.is_free());
    }

    #[test]
    fn an_address_that_nobody_has_is_told_to_the_client() {
        let mut turns = Turns::default();
        let message = Mbap { transaction: 3, unit: 9, pdu: READ.to_vec() };
        let frame = turns.begin(1, asked(Manner::Mbap, &message.bytes()), 0);
        assert_eq!(frame, rtu(9, &READ));
        assert_eq!(turns.answers(STRANGER / 2), []);
        let reply = Mbap { pdu: vec![0x83, NO_TARGET], ..message };
        assert_eq!(turns.answers(NO_ANSWER), [Answer::To(1, reply.bytes())]);
        assert!(turns.is_free());
    }

    #[test]
    fn what_is_no_frame_waits_for_the_rest_and_then_goes_as_it_is() {
        let frame = rtu(1, &READ);
        let mut ask = Ask::new(Manner::Serial);
        ask.bytes().extend(&frame[..6]);
        assert_eq!(ask.next(false), Ok(None));
        ask.bytes().extend(&frame[6..]);
        ask.bytes().push(0x55);
        assert_eq!(ask.next(false), Ok(Some(Question::Serial(frame))));
        assert_eq!(ask.next(false), Ok(None));
        assert_eq!(ask.next(true), Ok(Some(Question::Serial(vec![0x55]))));
        assert_eq!(ask.next(true), Ok(None));
    }

    #[test]
    fn bytes_that_nobody_asked_for_are_for_all_who_listen_as_on_a_line() {
        let mut turns = Turns::default();
        turns.heard(&[(5, 0)]);
        assert_eq!(turns.answers(6), [Answer::Unasked(vec![0])]);
    }
}
