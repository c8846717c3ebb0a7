//! The master against links that misbehave.

mod late;
mod torn;

use std::collections::VecDeque;
use std::io;
use std::time::Duration;

use super::{Client, ClientError, orders};
use crate::link::{Link, Mode};
use lang::axis::Axis;
use lang::isa::FINGERPRINT;
use lang::record::feature;
use lang::wire::{self, CRC_START, crc16};

/// A link whose other end answers the n-th request with the n-th script entry; time passes only
/// while nothing comes.
pub(crate) struct Scripted {
    now: Duration,
    answers: VecDeque<Vec<u8>>,
    pending: VecDeque<u8>,
    pub(crate) sent: Vec<Vec<u8>>,
    only_at: Option<Mode>,
    mode: Mode,
}

impl Scripted {
    pub(crate) fn new(answers: impl IntoIterator<Item = Vec<u8>>) -> Scripted {
        Scripted {
            now: Duration::ZERO,
            answers: answers.into_iter().collect(),
            pending: VecDeque::new(),
            sent: Vec::new(),
            only_at: None,
            mode: Mode::DEFAULT,
        }
    }
}

impl Link for Scripted {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.sent.push(bytes.to_vec());
        if self.only_at.is_none_or(|mode| mode == self.mode) {
            self.pending.extend(self.answers.pop_front().unwrap_or_default());
        }
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        // Bytes trickle in three at a time, as a slow line gives them.
        let count = self.pending.len().min(3);
        for (place, byte) in buffer.iter_mut().zip(self.pending.drain(..count)) {
            *place = byte;
        }
        self.now += if count == 0 { patience } else { Duration::from_micros(100) };
        Ok(count)
    }

    fn now(&self) -> Duration {
        self.now
    }

    fn pause(&mut self, time: Duration) {
        self.now += time;
    }

    fn set_mode(&mut self, mode: Mode) -> io::Result<bool> {
        self.mode = mode;
        Ok(true)
    }
}

/// A frame with its CRC.
pub(crate) fn framed(bytes: &[u8]) -> Vec<u8> {
    let mut frame = bytes.to_vec();
    let crc = bytes.iter().fold(CRC_START, |crc, byte| crc16(crc, *byte));
    frame.extend(crc.to_le_bytes());
    frame
}

#[test]
fn a_lost_reply_is_asked_for_again() {
    let reply = framed(&[1, 3, 2, 0x12, 0x34]);
    let mut client = Client::new(Scripted::new([vec![], vec![0xFF; 9], reply]), 1);
    assert_eq!(client.holding(5, 1).ok(), Some(vec![0x1234]));
    assert_eq!(client.link().sent.len(), 3);
}

#[test]
fn silence_and_noise_end_in_bounded_time_and_are_told_apart() {
    let mut silent = Client::new(Scripted::new([]), 1);
    assert!(matches!(silent.holding(5, 1), Err(ClientError::Silent)));
    assert!(silent.link().now() < Duration::from_secs(3));
    let mut noisy = Client::new(Scripted::new([vec![0xA5; 100_000]]), 1);
    assert!(matches!(noisy.holding(5, 1), Err(ClientError::Noise(_))));
    assert!(noisy.link().now() < Duration::from_secs(6));
}

#[test]
fn an_exception_is_not_asked_for_again() {
    let mut client = Client::new(Scripted::new([framed(&[1, 0x86, 6])]), 1);
    let error = client.write(5, 1).unwrap_err();
    assert!(error.is_exception(lang::wire::Exception::Busy));
    assert_eq!(client.link().sent.len(), 1);
}

#[test]
fn a_reply_that_is_lost_beyond_a_gateway_is_asked_for_again() {
    let silent = || framed(&[1, 0x83, 11]);
    let reply = framed(&[1, 3, 2, 0x12, 0x34]);
    let mut client = Client::new(Scripted::new([silent(), silent(), reply]), 1);
    assert_eq!(client.holding(5, 1).ok(), Some(vec![0x1234]));
    assert_eq!(client.link().sent.len(), 3);
    // A board that is gone is told in bounded time, and what must not be repeated is not.
    let mut gone = Client::new(Scripted::new(std::iter::repeat_with(silent).take(40)), 1);
    assert!(matches!(gone.holding(5, 1), Err(ClientError::Exception(11))));
    assert!(gone.link().sent.len() > 4);
    assert!(gone.link().now() < Duration::from_secs(3));
    let mut once = Client::new(Scripted::new(std::iter::repeat_with(silent).take(40)), 1);
    assert!(matches!(once.once(|client| client.holding(5, 1)), Err(ClientError::Exception(11))));
    assert_eq!(once.link().sent.len(), 1);
}

/// Whether it was done nobody knows: an axis that may move is stopped, and the board is asked how it stands.
#[test]
fn a_reply_lost_beyond_a_gateway_leaves_it_open_whether_a_request_was_done() {
    let silent = |function: u8| framed(&[1, 0x80 | function, 11]);
    for lost in [Vec::new(), vec![0xA5; 9], silent(16)] {
        let mut client = Client::new(Scripted::new([lost]), 1);
        let order = orders::move_to(Axis::X, [100; 2], 100, 100);
        assert!(client.order(&order, String::new).is_err());
        let [high, low] = wire::COMMAND.to_be_bytes();
        let stop = framed(&[1, 16, high, low, 0, 2, 4, 0, wire::command::STOP_AXES as u8, 0, 7]);
        assert!(client.link().sent[1..].contains(&stop), "{:?}", client.link().sent);
    }
    // What the board refuses did not begin.
    let mut client = Client::new(Scripted::new([framed(&[1, 0x90, 3])]), 1);
    assert!(client.order(&[wire::command::MOVE_TO], String::new).is_err());
    assert_eq!(client.link().sent.len(), 1);

    let mut client = Client::new(Scripted::new([silent(6)]), 1);
    assert!(client.restart().is_ok(), "it resets before its reply is out");

    let version = |low| framed(&[1, 3, 2, 0, low]);
    let mut client = Client::new(Scripted::new([version(0), silent(16), version(1)]), 1);
    assert!(client.unlock("code").is_ok(), "the lock is open");
    let mut client = Client::new(Scripted::new([version(0), silent(16), version(0)]), 1);
    assert!(matches!(client.unlock("code"), Err(ClientError::Exception(11))), "it is locked");
}

/// A gateway passes on what it does not know: a reply is one to this request only.
#[test]
fn a_reply_that_is_passed_on_names_what_was_asked() {
    let passed = |reply: &[u8], pdu: &[u8], length| {
        let mut client = Client::new(Scripted::new([framed(reply)]), 1);
        client.pass_on(1, pdu, length, false)
    };
    let write = [6, 0, 5, 0, 9];
    assert_eq!(passed(&[1, 6, 0, 5, 0, 9], &write, 5).ok(), Some(write.to_vec()));
    let several = [16, 0, 5, 0, 1, 2, 0, 9];
    assert!(passed(&[1, 16, 0, 5, 0, 1], &several, 5).is_ok());
    assert_eq!(passed(&[1, 0x86, 6], &write, 5).ok(), Some(vec![0x86, 6]), "refused");
    for other in [[1, 6, 0, 4, 0, 9], [1, 6, 0, 5, 0, 8], [1, 16, 0, 5, 0, 9]] {
        assert!(passed(&other, &write, 5).is_err(), "{other:?}");
    }
    assert!(passed(&[1, 16, 0, 6, 0, 1], &several, 5).is_err());
    assert!(passed(&[1, 5, 0, 4, 0xFF, 0], &[5, 0, 5, 0xFF, 0], 5).is_err());

    // What one board owes is remembered while another one is asked.
    let answers = [vec![], framed(&[2, 3, 2, 0, 7]), framed(&[1, 3, 2, 0, 8])];
    let mut client = Client::new(Scripted::new(answers), 2);
    assert!(client.pass_on(1, &[3, 0, 5, 0, 1], 4, false).is_err());
    assert!(client.pass_on(2, &[3, 0, 5, 0, 1], 4, false).is_ok());
    // The late reply of board 1 is none to the echo that comes before its next request.
    assert!(client.pass_on(1, &[3, 0, 6, 0, 1], 4, false).is_err());
    assert_eq!(client.link().sent[2][..2], [1, 8]);
}

#[test]
fn rate_and_parity_are_found() {
    for mode in Mode::all() {
        let answers = std::iter::repeat_with(|| framed(&[1, 3, 2, 0, 1])).take(40);
        let mut link = Scripted::new(answers);
        link.only_at = Some(mode);
        let mut client = Client::new(link, 1);
        assert!(client.find().is_ok());
        assert_eq!(client.mode(), mode);
    }
}

#[test]
fn a_program_with_keep_is_announced_as_one() {
    // Who the board is: 3060 bytes of room, none taken.
    let mut identity = vec![1, 3, 28, 0, 1, 0, 1];
    identity.extend(FINGERPRINT.to_be_bytes());
    identity.extend([0, 0, 0, 0, 0x0B, 0xF4, 0x0B, 0xF4]);
    identity.resize(31, 0);
    for (features, announced) in [(feature::KEEP, 0x8000 | 30), (feature::ARC, 30)] {
        let answers = [framed(&identity), framed(&[1, 6, 0x13, 0xC5, 0, 30])];
        let mut client = Client::new(Scripted::new(answers), 1);
        let mut image = [0; 30];
        image[1] = features as u8;
        assert!(client.upload(&image, false, &mut |_| {}).is_err(), "the board is gone by then");
        let request = &client.link().sent[1];
        assert_eq!(request[1..4], [6, 0x13, 0xC5]);
        assert_eq!(u16::from_be_bytes([request[4], request[5]]), announced);
    }
}

/// The board is not asked to take what it would not do.
#[test]
fn the_small_chip_refuses_step_invert_by_name() {
    let mut profile = lang::profile::Profile::built_in("thesis").expect("built in");
    profile.step_invert = true;
    let record = lang::record::BoardRecord::of(&profile, 1);
    let features = lang::part::G2553.features.to_be_bytes();
    let mut identity = vec![1, 3, 28, 0, 1, 0, 1];
    identity.extend(FINGERPRINT.to_be_bytes());
    identity.extend(features);
    identity.resize(31, 0);
    let mut client = Client::new(Scripted::new([framed(&identity)]), 1);
    let refused = client.set_board_record(&record).expect_err("it has no such output");
    assert!(matches!(refused, ClientError::NoStepLow), "{refused}");
    assert!(refused.to_string().contains("step_invert"), "{refused}");
    assert_eq!(client.link().sent.len(), 1, "nothing is written");
}
