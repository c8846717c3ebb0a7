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
