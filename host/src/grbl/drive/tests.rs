//! The drive against a board that comes back after the cable was out.

use std::sync::Arc;

use lang::profile::Profile;
use lang::record::feature;
use lang::wire::{self, Control, RunState};

use super::Drive;
use crate::client::Client;
use crate::client::tests::{Scripted, framed};
use crate::grbl::desk::Wants;

fn reply(function: u8, words: &[u16]) -> Vec<u8> {
    let head = [1, function, 2 * words.len() as u8];
    let bytes = words.iter().flat_map(|word| word.to_be_bytes());
    framed(&head.into_iter().chain(bytes).collect::<Vec<u8>>())
}

/// Whether the run that a board counts as this one is stopped after run 5 was lost with the board.
fn is_stopped(runs: u16) -> bool {
    let mut words = vec![0; usize::from(wire::STREAM_RESULT - wire::STREAM_CALL) + 1];
    words[usize::from(wire::RUN_STATE - wire::STREAM_CALL)] = RunState::Running as u16;
    words[usize::from(wire::RUN_COUNT - wire::STREAM_CALL)] = runs;
    let inputs = vec![0; usize::from(wire::LIMITS - wire::INPUTS) + 1];
    let [high, low] = wire::RUN_CONTROL.to_be_bytes();
    let stop = framed(&[1, 6, high, low, 0, Control::Stop as u8]);
    let answers = [
        reply(3, &[feature::STREAM]),
        reply(3, &SLOTS),
        reply(3, &words),
        reply(4, &inputs),
        stop.clone(),
    ];
    let mut client = Client::new(Scripted::new(answers), 1);
    let slots = client.stream_slots().expect("it answers").expect("it has some");
    let mill = Profile::built_in("mill").expect("built in");
    let mut drive = Drive::new(Arc::default(), mill, Box::new(|| Err("gone".to_owned())));
    drive.orphan = Some(5);
    drive.board = Some((client, slots));
    drive.once(&Wants::default()).expect("it answers");
    let (client, _) = drive.board.as_mut().expect("it is there");
    client.link().sent.contains(&stop)
}

/// The registers of the slots: how many, bytes of one, registers of a request.
const SLOTS: [u16; 3] = [2, 256, 60];

#[test]
fn only_the_run_that_was_lost_is_stopped_when_the_board_is_back() {
    assert!(is_stopped(5));
    assert!(!is_stopped(6), "somebody else has started a program meanwhile");
    assert!(!is_stopped(0), "the board was reset, and another program runs");
}
