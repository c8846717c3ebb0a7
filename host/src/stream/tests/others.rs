//! A second client of the board while a job is fed.

use lang::wire::{self, End, Exception, Stream};

use super::super::feed::Feed;
use super::super::job::{Job, More};
use super::super::pump;
use super::{compile, mill, quietly};
use crate::bench::stand::Stand;

/// Trace mode has no one who takes the events of a job that is fed: the axes would stand with the spindle on.
#[test]
fn nobody_can_trace_a_job_that_is_fed_or_tell_its_end() {
    let lines: String = (1..=120).map(|n| format!("G1 X{}\n", n % 2 * 4)).collect();
    let (_, compiled) = compile(&format!("SetOut 1, ON\nF3000\n{lines}SetOut 1, OFF\n"));
    let mut stand = Stand::new(&mill()).expect("a board");
    let client = stand.client();
    let slots = client.stream_slots().expect("an answer").expect("it can stream");
    let mut job = Job::new(Feed::new(&compiled).expect("streamable"), slots.bytes.into());
    let mut tried = 0;
    let outcome =
        pump::run_observed(client, &mut job, slots, &mut quietly, None, &mut |client, now, _| {
            if now.begun == 0 || tried == 10 {
                return Ok(());
            }
            tried += 1;
            for mode in [1, wire::TRACE_QUEUED] {
                let refused = client.write(wire::TRACE_MODE, mode).expect_err("refused");
                assert!(refused.is_exception(Exception::Busy), "{refused}");
            }
            client.write(wire::TRACE_MODE, 0)?;
            client.stream_control(Stream::Finish)
        });
    let outcome = outcome.expect("an end");
    assert_eq!((outcome.end, outcome.starved, tried), (End::Done, 0, 10), "{outcome:?}");
    assert_eq!(outcome.count, job.count());
}

/// The board has run out of pieces as somebody else tells it that there is none to come.
#[test]
fn a_job_that_somebody_else_has_ended_is_not_done() {
    let (_, first) = compile("F600\nG1 X1\n");
    let mut stand = Stand::new(&mill()).expect("a board");
    let client = stand.client();
    let slots = client.stream_slots().expect("an answer").expect("it can stream");
    let mut job = Job::new(Feed::new(&first).expect("streamable"), slots.bytes.into());
    job.follow_with(Box::new(|| More::Wait));
    let outcome =
        pump::run_observed(client, &mut job, slots, &mut quietly, None, &mut |client, now, _| {
            if now.dry { client.stream_control(Stream::Finish) } else { Ok(()) }
        });
    let outcome = outcome.expect("an end");
    assert_eq!(outcome.end, End::Stopped, "{outcome:?}");
}
