//! How a board comes to where a job goes on in its middle.

use lang::wire::End;

use super::super::feed::Feed;
use super::super::job::{Goal, Job};
use super::super::{near, pump};
use super::{compile, from_line, mill, quietly};
use crate::bench::stand::Stand;
use crate::track::Track;

/// The board is brought to where the job goes on lifted and dark: outputs that were on are off on the whole way, Z goes up
/// first and down last, and what the job had on comes on there.
#[test]
fn a_job_that_goes_on_in_the_middle_comes_there_dark_and_lifted() {
    let text = "G0 Z5\nSetOut 1, ON\nF600\nG0 X20 Y10\nG1 Z-2\nG1 X30\nG1 Y20\n";
    let (program, compiled) = compile(text);
    let mut stand = Stand::new(&mill()).expect("a board");
    let client = stand.client();
    let slots = client.stream_slots().expect("an answer").expect("it can stream");
    client.set_coil(lang::wire::COILS, true).expect("switched");
    client.set_coil(lang::wire::COILS + 2, true).expect("switched");
    let mut job = Job::new(Feed::new(&compiled).expect("streamable"), slots.bytes.into());
    let mut track = Track::new(&program.profile, [0; 3], 0);
    job.skip(from_line(6), &mut track).expect("the state is known");
    let approach = track.approach([0; 3], [0; 3], None).expect("a way");
    let legs: Vec<_> = approach.legs.iter().map(|leg| leg.map(|p| p.map(|p| p.um))).collect();
    let wanted =
        [[None, None, Some(5_000)], [Some(20_000), Some(10_000), None], [None, None, Some(-2_000)]];
    assert_eq!(legs, wanted);
    let lifted = track.approach([0; 3], [0; 3], Some(12_000)).expect("a way");
    assert_eq!(lifted.legs[0][2].map(|place| place.um), Some(12_000));
    // Never down first, whatever the lift says.
    let high = track.approach([0, 0, 900], [0; 3], Some(1_000)).expect("a way");
    assert_eq!(high.legs[0][2], None);
    job.lead(track.darkens(0b101));
    job.lead(approach.instructions());
    job.lead(track.restore().expect("a state"));
    let mut lit = Vec::new();
    let outcome =
        pump::run_observed(client, &mut job, slots, &mut quietly, None, &mut |client, _, _| {
            let coils = client.coils(lang::wire::COILS, 3)?;
            let place = client.stream_standing()?.steps;
            lit.push((place, coils));
            Ok(())
        });
    assert_eq!(outcome.expect("an end").end, End::Done);
    let moving: Vec<_> = lit.iter().filter(|(place, _)| *place != [0; 3]).collect();
    let on_the_way = |place: &[i32; 3]| place[0] < 2_000 || place[1] < 1_000 || place[2] > -200;
    assert!(moving.iter().any(|(place, _)| on_the_way(place)), "{lit:?}");
    for (place, coils) in &moving {
        assert!(!on_the_way(place) || coils == &[false; 3], "{place:?}: {coils:?}");
        assert!(!coils[2], "{place:?}: output 3 was never the job's");
    }
    assert!(moving.iter().any(|(_, coils)| coils[0]), "{lit:?}");
    assert_eq!(stand.motors(), [3000, 2000, -200]);
}

#[test]
fn the_boards_own_zero_says_where_a_zeroed_job_lies() {
    let (program, compiled) = compile("G92 X0 Y0\nG0 Z5\nF600\nG1 X10\nG1 Y10\n");
    let mut job = Job::new(Feed::new(&compiled).expect("streamable"), 180);
    let mut track = Track::new(&program.profile, [0; 3], 0);
    job.skip(from_line(5), &mut track).expect("the state is known");
    // The work's corner lay at machine 30, 40; the run was stopped at 35, 40.
    let approach = track.approach([3_500, 4_000, 500], [3_000, 4_000, 0], None).expect("a way");
    assert_eq!(approach.steps, [4_000, 4_000, 500]);
    let restored = track.restore().expect("a state");
    assert_eq!(restored[0].0, [10_000], "X is 10 mm from its zero there");
}

#[test]
fn the_nearest_line_to_a_place_is_found() {
    let text =
        "F600\nG0 X50 Y0\nREPEAT 3\nG91\nG1 Y1\nG90\nG1 X10\nG91\nG1 Y1\nG90\nG1 X50\nEND REPEAT\n";
    let (program, compiled) = compile(text);
    let near = |place| {
        let feed = Feed::new(&compiled).expect("streamable");
        near::nearest(feed, &program.profile, place).expect("it draws")
    };
    let (goal, far) = near([30_000, 4_000]);
    assert!(matches!(goal, Goal::Effect { line: 11, .. }) && far == 0.0, "{goal:?} {far}");
    let mut job = Job::new(Feed::new(&compiled).expect("streamable"), 180);
    let mut track = Track::new(&program.profile, [0; 3], 0);
    job.skip(goal, &mut track).expect("the state is known");
    assert_eq!(track.steps(), [1_000, 400, 0], "before the line in its second pass");
    let (_, far) = near([30_000, 100_000]);
    assert_eq!(far, 94_000.0);
}

/// Where output `n` (from 0) was seen on, X in steps, of a job that goes on at a line from where it stands there.
fn seen_on(text: &str, line: u32, n: usize) -> Vec<i32> {
    let (program, compiled) = compile(text);
    let mut stand = Stand::new(&mill()).expect("a board");
    let client = stand.client();
    let slots = client.stream_slots().expect("an answer").expect("it can stream");
    let mut job = Job::new(Feed::new(&compiled).expect("streamable"), slots.bytes.into());
    let mut track = Track::new(&program.profile, [0; 3], 0);
    job.skip(from_line(line), &mut track).expect("the state is known");
    let approach = track.approach([0; 3], [0; 3], None).expect("a way");
    job.lead(approach.instructions());
    job.lead(track.restore().expect("a state"));
    let mut on = Vec::new();
    let outcome =
        pump::run_observed(client, &mut job, slots, &mut quietly, None, &mut |client, _, _| {
            if client.coils(lang::wire::COILS, 3)?[n] {
                on.push(client.stream_standing()?.steps[0]);
            }
            Ok(())
        });
    assert_eq!(outcome.expect("an end").end, End::Done);
    on
}

/// What SYNC has told before the line and the path has not come to acts where it does in the whole job.
#[test]
fn what_is_still_to_act_along_the_path_acts_there() {
    let text = "F600\nG0 X0\nG1 X5\nSYNC Pulse 1, 400ms\nG1 X10\nSYNC SetOut 2, ON\nG1 X12\n\
                SYNC SetOut 2, OFF, -3mm\nG1 X13\nG1 X20\nWait 10ms\nG1 X25\n";
    let pulse = seen_on(text, 5, 0);
    assert!(!pulse.is_empty() && pulse.iter().all(|x| (480..=960).contains(x)), "{pulse:?}");
    assert!(seen_on(text, 7, 0).is_empty(), "it was there");
    let bead = seen_on(text, 10, 1);
    let last = bead.last().copied().unwrap_or_default();
    assert!(bead.contains(&1_300) || bead.iter().any(|x| *x > 1_300), "{bead:?}");
    assert!((1_380..=1_520).contains(&last), "off at X 15: {bead:?}");
    assert!(seen_on(text, 12, 1).is_empty(), "the path's end was there");
}

#[test]
fn the_rest_of_a_lag_is_told_and_what_something_else_switched_is_not() {
    let last = |text: &str, line: u32| {
        let (program, compiled) = compile(text);
        let mut job = Job::new(Feed::new(&compiled).expect("streamable"), 180);
        let mut track = Track::new(&program.profile, [0; 3], 0);
        job.skip(from_line(line), &mut track).expect("the state is known");
        let list = track.restore().expect("a state");
        let own = lang::isa::Op::Sync.code();
        let found = list.into_iter().filter(|(_, code)| code[0] == own);
        found.map(|(values, _)| values).collect::<Vec<_>>()
    };
    let sync = "F600\nG1 X5\nSYNC SetOut 2, ON, -600ms\n";
    assert_eq!(last(&format!("{sync}G1 X6\n"), 4), [[2, 1, -600]]);
    assert_eq!(last(&format!("{sync}G1 X8\nG1 X9\n"), 5), [[2, 1, -300]]);
    assert_eq!(last(&format!("{sync}G1 X8\nWait 100ms\nG1 X9\n"), 6), [[2, 1, -200]]);
    assert_eq!(last(&format!("{sync}G1 X8\nWait 400ms\nG1 X9\n"), 6), [[0; 3]; 0]);
    assert_eq!(last(&format!("{sync}G1 X8\nSetOut 2, OFF\nG1 X9\n"), 6), [[0; 3]; 0]);
    assert_eq!(last(&format!("{sync}G1 X8\nMoveAxe X, 1mm\nG1 X9\n"), 6), [[0; 3]; 0]);
    assert_eq!(last("F600\nSYNC Pulse 1, 20ms, 5mm\nG1 X8\n", 3), [[1, 20, 5_000]]);
    let arc = "F600\nSYNC SetOut 2, ON, -8mm\nG2 X10 Y0 I5 J0\nG1 X20\n";
    assert_eq!(last(arc, 4), [[0; 3]; 0], "an arc of 15.7 mm");
}
