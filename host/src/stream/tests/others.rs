//! A second client of the board while a job is fed.

use lang::wire::{End, Stream};

use super::super::feed::Feed;
use super::super::job::{Job, More};
use super::super::pump;
use super::{compile, mill, quietly};
use crate::bench::stand::Stand;

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
