//! Events at random times: whatever the link is doing, no statement is lost, none runs twice, and a
//! handler runs as often as it should.

use std::fmt::Write as _;

use lang::wire::End;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};

use crate::lab::{Case, stream};

/// Moves, pulses, answers and waits, many of each; a handler that moves and counts.
const SCRIPT: &str = "DIM n, i, sum\nON IN 3 RISE GOSUB hit\nF3000\nWait 20ms\n\
    FOR i = 1 TO 25\n\
      MoveRel X, 0.2mm\n  sum = sum + POSST(X) / 1st\n  SetOut 5, i AND 1\n  G91 G1 X0.1 Z-0.1\n  G1 X0.1\n  G90\n\
      Wait 12ms\n  IF OUT(5) THEN Pulse 6, 3ms\n  IF i MOD 5 = 0 THEN sum = sum + 7 / SGN(i)\n\
    NEXT\nWait 400ms\nON IN 3 OFF\nPRINT n; \" \"; i; \" \"; sum\nEND\n\
    hit:\nn = n + 1\nMoveRel Y, 0.3mm\nPRINT \"hit \"; n; \" \"; POSST(Y)\nRETURN\n";

/// What the loop leaves, whatever came between.
const SUM: i32 = 40 * 25 * 26 / 2 - 25 * 20 + 5 * 7;

fn world(edges: &[u32]) -> String {
    let mut text = String::new();
    for at in edges {
        let _ =
            write!(text, "at({at}, || set_in(3, true)); at({}, || set_in(3, false)); ", at + 40);
    }
    text
}

fn check(edges: &[u32]) -> Result<(), TestCaseError> {
    let case = Case { script: SCRIPT.to_owned(), world: world(edges) };
    let (run, outcome, printed) = stream(&case, false);
    let told = format!("{edges:?} {outcome:?}\n{printed}");
    prop_assert_eq!(outcome.end, End::Done, "{}", told);
    let hits = edges.len() as i64;
    let mut wanted: Vec<String> = (1..=hits).map(|n| format!("hit {n} {}st", 30 * n)).collect();
    wanted.push(format!("{hits} 26 {SUM}"));
    prop_assert_eq!(printed.lines().collect::<Vec<_>>(), wanted, "{}", told);
    prop_assert_eq!(run.motors, [25 * 40, hits * 30, -25 * 10], "{}", told);
    Ok(())
}

fn run(seed: u8, cases: u32) {
    let config =
        Config { cases, failure_persistence: None, max_shrink_iters: 40, ..Config::default() };
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[seed; 32]);
    let mut runner = TestRunner::new_with_rng(config, rng);
    // Far enough apart that no edge comes before the one before it is served.
    let edges = prop::collection::vec(220u32..420, 1..9).prop_map(|gaps| {
        let times = gaps.iter().scan(0, |at, gap| {
            *at += gap;
            Some(*at + 100)
        });
        times.collect::<Vec<u32>>()
    });
    if let Err(error) = runner.run(&edges, |edges| check(&edges)) {
        panic!("{error}");
    }
}

#[test]
fn events_at_any_time_lose_and_double_nothing() {
    run(3, 5);
}

#[test]
#[ignore = "minutes: the long form of the test above"]
fn many_events_at_any_time_lose_and_double_nothing() {
    run(4, 400);
}

/// An input that chatters faster than the link: the job comes to its end, whole.
#[test]
fn a_storm_of_edges_harms_nothing() {
    // The filter wants 5 ms of a level: each edge is one.
    let storm = "for i in 0..200 { at(300 + 22 * i, || set_in(3, true)); \
                 at(311 + 22 * i, || set_in(3, false)); }";
    let case = Case { script: SCRIPT.to_owned(), world: storm.to_owned() };
    let (run, outcome, printed) = stream(&case, false);
    assert_eq!(outcome.end, End::Done, "{outcome:?}");
    let last = printed.lines().last().unwrap_or_default();
    let hits: i64 = last.split(' ').next().and_then(|n| n.parse().ok()).expect("a number");
    assert_eq!(last, format!("{hits} 26 {SUM}"));
    assert_eq!(run.motors, [25 * 40, hits * 30, -25 * 10], "{printed}");
    assert!((20..=200).contains(&hits), "{hits}");
}
