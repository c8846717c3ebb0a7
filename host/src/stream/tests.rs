//! Jobs streamed to the real firmware in the emulator.

mod handlers;
mod middle;
mod others;

use std::time::Duration;

use lang::back::{self, Compiled};
use lang::fault::Fault;
use lang::front::ProfileChoice;
use lang::front::source::Source;
use lang::hir::Program;
use lang::profile::Profile;
use lang::wire::{self, Control, End, Exception, RunState, Stream};

use super::check::{self, Checked};
use super::feed::{Feed, Refused};
use super::job::{Goal, Job};
use super::pump::{self, Outcome, Progress};
use crate::bench::stand::Stand;
use crate::bench::stream::raster;
use crate::client::stream::Slots;
use crate::link::Link;
use crate::track::Track;

fn mill() -> Profile {
    Profile::built_in("mill").expect("built in")
}

fn compile(text: &str) -> (Program, Compiled) {
    let source = Source::new("job", text.to_owned());
    let (program, diags) = lang::front::compile(&source, ProfileChoice::built_in());
    let program = program.unwrap_or_else(|| panic!("{}", diags.render(&source)));
    let compiled = back::compile(&program).expect("it fits");
    (program, compiled)
}

/// Streams a job and gives its end and what it printed.
fn stream(stand: &mut Stand, text: &str, watcher: pump::Watcher<'_>) -> (Outcome, String) {
    let (_, compiled) = compile(text);
    let slots = stand.client().stream_slots().expect("an answer").expect("it can stream");
    let mut job = Job::new(Feed::new(&compiled).expect("streamable"), slots.bytes.into());
    let mut printed = Vec::new();
    let outcome =
        pump::run(stand.client(), &mut job, slots, watcher, &mut |bytes| printed.extend(bytes));
    (outcome.expect("an end"), String::from_utf8(printed).expect("text"))
}

/// A board that runs the first piece of a job by hand.
fn by_hand(text: &str) -> (Stand, Slots) {
    let (_, compiled) = compile(text);
    let mut stand = Stand::new(&mill()).expect("a board");
    let client = stand.client();
    let slots = client.stream_slots().expect("an answer").expect("it can stream");
    let mut job = Job::new(Feed::new(&compiled).expect("streamable"), slots.bytes.into());
    client.stream_open(&slots, job.machine()).expect("opened");
    let piece = job.piece().expect("a piece");
    assert!(client.stream_piece(&slots, 0, &piece.bytes).expect("taken"));
    client.stream_control(Stream::Run).expect("running");
    (stand, slots)
}

fn quietly(_: &Progress) -> Option<Control> {
    None
}

#[test]
fn a_raster_runs_through_without_a_stop_for_want_of_a_piece() {
    let laser = Profile::built_in("laser").expect("built in");
    let mut stand = Stand::new(&laser).expect("a board");
    let (outcome, _) = stream(&mut stand, &raster(250, 1000), &mut quietly);
    assert_eq!((outcome.end, outcome.starved), (End::Done, 0), "{outcome:?}");
    assert!(outcome.pieces > 5, "{outcome:?}");
    // Two rows and a half of 10 mm, 40 steps/mm.
    assert_eq!(stand.motors(), [200, 8, 0]);
    assert_eq!(outcome.line, 511, "{outcome:?}");
}

#[test]
#[ignore = "ten minutes of the board's time, two of this computer's"]
fn a_raster_of_92_000_lines_never_starves() {
    let laser = Profile::built_in("laser").expect("built in");
    let mut stand = Stand::new(&laser).expect("a board");
    let (outcome, _) = stream(&mut stand, &raster(92_000, 1000), &mut quietly);
    let rate = 92_000.0 / outcome.time.as_secs_f64();
    println!("{rate:.0} lines/s, {outcome:?}");
    assert_eq!((outcome.end, outcome.starved), (End::Done, 0));
}

#[test]
fn loops_jumps_subs_and_variables_become_straight_code() {
    let text = "DIM i, n, far AS LENGTH\n\
        TABLE steps_of = 1mm, 2mm, 4mm\n\
        F1200\n\
        FOR i = 0 TO 2\n  G1 X[steps_of(i)] Y[steps_of(i) * 2]\nNEXT\n\
        again:\nn = n + 1\nup n\nIF n < 40 THEN GOTO again\n\
        far = 7mm\nSELECT CASE n\nCASE 40\nG1 X[far]\nCASE ELSE\nG1 X0\nEND SELECT\n\
        PRINT \"n=\"; n; \" \"; far\n\
        SUB up(k)\n  IF k MOD 2 = 0 THEN\n    G1 Z-1\n  ELSE\n    G1 Z0\n  END IF\nEND SUB\n";
    let mut stand = Stand::new(&mill()).expect("a board");
    let (outcome, printed) = stream(&mut stand, text, &mut quietly);
    assert_eq!(outcome.end, End::Done, "{outcome:?}");
    assert_eq!(printed, "n=40 7000um\n");
    assert_eq!(stand.motors(), [700, 800, -100]);
}

#[test]
fn what_the_machine_answers_steers_the_job() {
    let text = "DIM i\n\
        REPEAT 5\n  IF IN(3) THEN\n    MoveRel X, 1mm\n  ELSE\n    MoveRel Y, 1mm\n  END IF\nEND REPEAT\n\
        WaitIn? 5, ON, 20ms\nIF TIMEDOUT THEN PRINT \"late\"\n\
        PRINT POS(X); \",\"; POSST(Y)\n";
    let mut stand = Stand::new(&mill()).expect("a board");
    stand.rig().borrow_mut().board().plant_mut().set_input(3, true);
    let (outcome, printed) = stream(&mut stand, text, &mut quietly);
    assert_eq!((outcome.end, outcome.starved), (End::Done, 0), "{outcome:?}");
    assert_eq!(printed, "late\n5000um,0st\n");
    assert_eq!(stand.motors(), [500, 0, 0]);
}

#[test]
fn a_text_longer_than_a_piece_arrives_whole() {
    let long: String = ('a'..='z').cycle().take(250).collect();
    let mut stand = Stand::new(&mill()).expect("a board");
    let text = format!("Wait 10ms\nPRINT \"{long}\"\n");
    let (outcome, printed) = stream(&mut stand, &text, &mut quietly);
    assert_eq!(outcome.end, End::Done);
    // Nobody waits for the host in a run without trace: the ring is shorter than the line.
    assert!(printed.is_empty() || printed == format!("{long}\n"), "{printed}");
}

#[test]
fn it_pauses_goes_on_and_stops_cleanly() {
    let text = "SetOut 1, ON\nF600\nG1 X10\nG1 X20\nG1 X30\nG1 X40\nSetOut 1, OFF\n";
    let mut stand = Stand::new(&mill()).expect("a board");
    let mut seen = Vec::new();
    let mut pauses = 0;
    let (outcome, _) = stream(&mut stand, text, &mut |progress: &Progress| {
        if seen.last() != Some(&progress.state) {
            seen.push(progress.state);
        }
        match progress.state {
            Some(RunState::Running) if pauses == 0 && progress.line >= 4 => {
                pauses = 1;
                Some(Control::Pause)
            }
            Some(RunState::Paused) if pauses < 20 => {
                pauses += 1;
                (pauses == 20).then_some(Control::Resume)
            }
            _ => None,
        }
    });
    assert_eq!(outcome.end, End::Done, "{outcome:?}");
    assert!(seen.contains(&Some(RunState::Paused)), "{seen:?}");
    assert_eq!(stand.motors(), [4000, 0, 0], "no step is lost in a pause");

    let (outcome, _) = stream(&mut stand, text, &mut |progress: &Progress| {
        (progress.line >= 4).then_some(Control::Stop)
    });
    assert_eq!(outcome.end, End::Stopped, "{outcome:?}");
    assert!((3..7).contains(&outcome.line), "{outcome:?}");
    let status = stand.client().status().expect("an answer");
    assert_eq!((status.state, &status.outputs[..]), ("empty", &[][..]));
}

/// The host that feeds is gone; another one goes on asking how the board is, as an HMI and a gateway always do.
#[test]
fn a_job_ends_two_seconds_behind_its_own_host_whoever_else_asks() {
    let second = Duration::from_millis(1000);
    let (_, compiled) = compile("SetOut 1, ON\nSetOut 3, ON\nF600\nG1 X200\n");
    let mut stand = Stand::new(&mill()).expect("a board");
    let client = stand.client();
    let slots = client.stream_slots().expect("an answer").expect("it can stream");
    let mut job = Job::new(Feed::new(&compiled).expect("streamable"), slots.bytes.into());
    client.stream_open(&slots, job.machine()).expect("open");
    let piece = job.piece().expect("a piece");
    assert!(client.stream_piece(&slots, 0, &piece.bytes).expect("sent"));
    client.stream_control(Stream::Run).expect("it runs");
    client.stream_control(Stream::Finish).expect("it is whole");
    // As long as it looks after its job, the job goes on.
    for _ in 0..20 {
        client.link().pause(second / 5);
        client.stream_standing().expect("an answer");
    }
    let gone = client.link().now();
    let status = client.status().expect("an answer");
    assert_eq!((status.state, &status.outputs[..]), ("running", &[1, 3][..]));
    // By the board's time: the questions take some of it, too.
    let mut ran = Duration::ZERO;
    for _ in 0..40 {
        client.link().pause(second / 10);
        let status = client.status().expect("an answer");
        let passed = client.link().now() - gone;
        if passed < second * 19 / 10 {
            assert_eq!(status.state, "running", "not before two seconds are over: {passed:?}");
            ran = passed;
        }
        // The print is anybody's, and so is what `stream_slots` reads.
        client.take_print().expect("an answer");
        client.stream_slots().expect("an answer");
        // Who reads the whole block asks of the job, too, and feeds nothing all the same.
        let block = wire::STREAM_RESULT - wire::RUN_STATE + 1;
        client.holding(wire::RUN_STATE, block).expect("an answer");
        if status.state != "running" {
            assert!(passed < second * 12 / 5, "it ended after {passed:?} only");
            break;
        }
    }
    assert!(ran > second * 3 / 2, "looked at until {ran:?} only");
    client.link().pause(second);
    let status = client.status().expect("an answer");
    assert_eq!((status.state, status.fault.as_deref()), ("fault", Some("F18")));
    assert!(status.outputs.is_empty() && status.moving.is_empty(), "{status:?}");
}

#[test]
fn a_job_that_only_computes_is_stopped_too() {
    let mut stand = Stand::new(&mill()).expect("a board");
    let text = "DIM n\nagain:\nn = 1 - n\nGOTO again\n";
    let (outcome, _) = stream(&mut stand, text, &mut |_: &Progress| Some(Control::Stop));
    assert_eq!((outcome.end, outcome.pieces), (End::Stopped, 0));
}

#[test]
fn a_lost_link_ends_the_run_with_f18_and_outputs_off() {
    let (mut stand, _) = by_hand("SetOut 2, ON\nF60\nG1 X100\nG1 X0\n");
    let client = stand.client();
    client.link().pause(Duration::from_millis(1500));
    let status = client.status().expect("an answer");
    assert_eq!((status.state, &status.outputs[..]), ("running", &[2][..]));
    client.link().pause(Duration::from_millis(2500));
    let status = client.status().expect("an answer");
    assert_eq!(status.state, "fault");
    assert_eq!(status.fault, Some(Fault::LinkLost.to_string()));
    assert!(status.outputs.is_empty(), "{status:?}");
    let there = stand.motors();
    assert!((50..1000).contains(&there[0]), "{there:?}");
    stand.client().link().pause(Duration::from_millis(500));
    assert_eq!(stand.motors(), there, "it stands");
}

#[test]
fn damaged_and_foreign_pieces_are_refused() {
    let (_, compiled) = compile("F60\nG1 X10\n");
    let mut stand = Stand::new(&mill()).expect("a board");
    let client = stand.client();
    let slots = client.stream_slots().expect("an answer").expect("it can stream");
    let mut job = Job::new(Feed::new(&compiled).expect("streamable"), slots.bytes.into());
    client.stream_open(&slots, job.machine()).expect("opened");
    assert!(
        client.stream_control(Stream::Run).expect_err("no piece").is_exception(Exception::Busy)
    );
    let piece = job.piece().expect("a piece");
    for at in 20..piece.bytes.len() {
        let mut bad = piece.bytes.clone();
        bad[at] ^= 0x10;
        let error = client.stream_piece(&slots, 0, &bad).expect_err("damaged");
        assert!(error.is_exception(Exception::DeviceFailure), "byte {at}: {error}");
    }
    assert_eq!(client.stream_standing().expect("an answer").accepted, 0);
    assert!(client.stream_piece(&slots, 0, &piece.bytes).expect("the whole one"));
}

#[test]
fn a_fault_tells_its_line_and_ends_the_run() {
    let text = "DIM n\nF600\nG1 X5\nWait (n - 5) * 1ms\nG1 X7\n";
    let mut stand = Stand::new(&mill()).expect("a board");
    let (outcome, _) = stream(&mut stand, text, &mut quietly);
    assert_eq!((outcome.end, outcome.fault), (End::Fault, Some(Fault::ValueRange)), "{outcome:?}");
    assert_eq!(outcome.line, 4);
    assert_eq!(stand.motors(), [500, 0, 0], "what came before is done");
    let _ = stand.client().control(Control::Acknowledge);
    let (outcome, _) = stream(&mut stand, "DIM n\nF600\nG1 X6\nn = 1 / n\nG1 X7\n", &mut quietly);
    let expected = (End::Fault, Some(Fault::DivisionByZero), 4);
    assert_eq!((outcome.end, outcome.fault, outcome.line), expected);
    assert_eq!(stand.motors(), [600, 0, 0]);
}

#[test]
fn the_stored_program_and_its_keeps_outlive_a_streamed_job() {
    let (_, stored) = compile("KEEP parts\nparts = parts + 7\nMoveAxe X, 5mm\n");
    let mut stand = Stand::new(&mill()).expect("a board");
    stand.upload(&stored.image).expect("stored");
    stand.run(Duration::from_secs(5)).expect("it runs");
    let (outcome, _) = stream(&mut stand, "F600\nG1 X3\nG1 X1\n", &mut quietly);
    assert_eq!(outcome.end, End::Done);
    let client = stand.client();
    assert_eq!(client.holding(lang::wire::KEEPS, 2).expect("an answer"), [7, 0]);
    assert_eq!(client.identity().expect("an answer").program_bytes as usize, stored.image.len());
    stand.run(Duration::from_secs(5)).expect("it runs again");
    assert_eq!(stand.motors(), [500, 0, 0]);
    assert_eq!(stand.client().holding(lang::wire::KEEPS, 2).expect("an answer"), [14, 0]);
}

#[test]
fn axes_on_their_own_waits_for_start_and_zeros_outlive_a_piece() {
    // The waits fill several pieces; X goes on by itself meanwhile.
    let waits = "Wait 1ms\n".repeat(120);
    let text = format!(
        "START MoveAxe X, 30mm\n{waits}MoveAxe Y, 2mm\nWaitMove\nM0\nSetPos X, 0mm\n{waits}\
         F6000\nG1 X1\nMoveSpeed Z, -5mm/s\n{waits}StopAxe Z\nMoveAxe Z, 0mm\n"
    );
    let mut stand = Stand::new(&mill()).expect("a board");
    let mut pressed = false;
    let (outcome, _) = stream(&mut stand, &text, &mut |progress: &Progress| {
        let waits = progress.state == Some(RunState::WaitStart);
        (waits && !std::mem::replace(&mut pressed, true)).then_some(Control::Start)
    });
    assert_eq!(outcome.end, End::Done, "{outcome:?}");
    assert!(pressed && outcome.pieces > 3, "{outcome:?}");
    assert_eq!(stand.motors(), [3100, 200, 0]);
}

/// Programs of other systems, streamed: the motors end where the traces beside them say.
#[test]
fn imported_programs_end_where_their_traces_do() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/import");
    for name in ["panel.nc", "contour.nc", "badge.gco"] {
        let bytes = std::fs::read(folder.join(name)).expect("a file");
        let made = import::import(name, &bytes, &import::Options::default()).expect("a script");
        let profile = Profile::built_in(&made.profile).expect("built in");
        let mut stand = Stand::new(&profile).expect("a board");
        let (outcome, _) = stream(&mut stand, &made.script, &mut quietly);
        assert_eq!((outcome.end, outcome.starved), (End::Done, 0), "{name}: {outcome:?}");
        let trace = std::fs::read_to_string((folder.join(name)).with_extension("trace"));
        let trace = trace.expect("a trace");
        let end =
            trace.lines().last().and_then(|line| line.split_once("\"pos\":")).expect("an end");
        let place = |axis: &str| {
            let (_, rest) = end.1.split_once(&format!("\"{axis}\":"))?;
            rest.split([',', '}']).next()?.parse::<i64>().ok()
        };
        let wanted = ["X", "Y", "Z"].map(|axis| place(axis).unwrap_or(0));
        assert_eq!(stand.motors(), wanted, "{name}");
        // Arcs reach deepest; the pieces and the frames leave this much of the RAM untouched.
        let free = stand.identity().expect("an answer").stack_free;
        assert!(free >= 64, "{name}: {free} bytes of stack left");
    }
}

fn checked(text: &str, homed: u16) -> Result<Checked, Refused> {
    let (program, compiled) = compile(text);
    check::check(Feed::new(&compiled)?, Track::new(&program.profile, [0; 3], homed))
}

#[test]
fn the_whole_job_is_checked_before_the_first_move() {
    assert_eq!(checked("F600\nG1 X5\nG1 X9\n", 0).expect("sound").count, 3);
    let refused = checked("F600\nG1 X5\nG1 X400\n", 7).expect_err("beyond the travel");
    assert_eq!(refused.line, 3);
    assert!(refused.text.contains("F05"), "{refused:?}");
    assert!(checked("F600\nG1 X5\nG1 X400\n", 0).is_ok(), "an axis that was never homed is free");
    let refused = checked("Home\nF600\nG1 X5\nG1 X400\n", 0).expect_err("homed by then");
    assert_eq!(refused.line, 4);
    let open = checked("F600\nG1 X5\nIF IN(1) THEN G1 X9\n", 0).expect("sound");
    assert_eq!((open.count, open.open), (2, Some(3)));
    let refused = checked("DIM i, n\nREPEAT 3\ni = i + 1\nn = 1 / (2 - i)\nEND REPEAT\n", 0);
    assert!(refused.expect_err("a fault of its own").text.contains("F02"));
}

const fn from_line(line: u32) -> Goal {
    Goal::Line { line, pass: 1 }
}

#[test]
fn a_job_begins_anew_in_the_middle() {
    let text = "G92 X10\nF600 S300\nM3\nG91\nG1 X5\nG1 X5 Y1\nG90\nG1 X30\nM5\n";
    let (program, compiled) = compile(text);
    let mut stand = Stand::new(&mill()).expect("a board");
    let client = stand.client();
    let slots = client.stream_slots().expect("an answer").expect("it can stream");
    let mut job = Job::new(Feed::new(&compiled).expect("streamable"), slots.bytes.into());
    let mut track = Track::new(&program.profile, [0; 3], 0);
    let there = client.stream_standing().expect("an answer").steps;
    job.skip(from_line(8), &mut track).expect("the state is known");
    // Work 10 is machine 0; two moves of 5 mm, 100 steps/mm.
    assert_eq!(track.steps(), [1000, 100, 0]);
    // The board has kept the zero that the job had set.
    let approach = track.approach(there, [-1000, 0, 0], None).expect("a way");
    job.lead(approach.instructions());
    job.lead(track.restore().expect("a state"));
    let outcome = pump::run(client, &mut job, slots, &mut quietly, &mut |_| ()).expect("an end");
    assert_eq!(outcome.end, End::Done);
    // Work 30 is machine 20; Y stands where the job had sent it.
    assert_eq!(stand.motors(), [2000, 100, 0]);

    let mut job = Job::new(Feed::new(&compiled).expect("streamable"), 180);
    let refused = job.skip(from_line(99), &mut Track::new(&program.profile, [0; 3], 0));
    assert!(refused.expect_err("no such line").text.contains("over"));
    let (program, compiled) = compile("F60\nIF IN(1) THEN G1 X1\nG1 X5\n");
    let mut job = Job::new(Feed::new(&compiled).expect("streamable"), 180);
    let refused = job.skip(from_line(3), &mut Track::new(&program.profile, [0; 3], 0));
    assert_eq!(refused.expect_err("it hangs on an input").line, 2);
}

#[test]
fn a_job_begins_anew_in_a_pass_of_a_loop() {
    let text = "DIM i\nF600\nFOR i = 1 TO 4\n  PRINT \"pass \"; i\n  G1 X[i * 1mm]\nNEXT\n";
    let (program, compiled) = compile(text);
    let mut stand = Stand::new(&mill()).expect("a board");
    let slots = stand.client().stream_slots().expect("an answer").expect("it can stream");
    let mut skipped = |line: u32, pass: u32| {
        let mut job = Job::new(Feed::new(&compiled).expect("streamable"), slots.bytes.into());
        let mut track = Track::new(&program.profile, [0; 3], 0);
        job.skip(Goal::Line { line, pass }, &mut track).map(|()| {
            job.lead(track.restore().expect("a state"));
            let mut printed = Vec::new();
            let mut print = |bytes: &[u8]| printed.extend_from_slice(bytes);
            let run = pump::run(stand.client(), &mut job, slots, &mut quietly, &mut print);
            assert_eq!(run.expect("an end").end, End::Done);
            (track.steps()[0], String::from_utf8(printed).expect("text"))
        })
    };
    assert_eq!(skipped(4, 3).expect("a pass"), (200, "pass 3\npass 4\n".to_owned()));
    assert_eq!(skipped(5, 4).expect("a pass"), (300, String::new()));
    assert_eq!(skipped(3, 2).expect("a pass"), (100, "pass 2\npass 3\npass 4\n".to_owned()));
    let refused = skipped(5, 5).expect_err("no such pass");
    assert!(refused.text.contains("4 times") && refused.line == 5, "{refused:?}");
}

/// The board runs behind the host: what is kept is what was done, not what was sent.
#[test]
fn keeps_count_what_was_done() {
    let text = "KEEP parts\nparts = parts + 100\nREPEAT 60\n  Wait 20ms\n  parts = parts + 1\nEND REPEAT\n";
    let (_, compiled) = compile(text);
    let mut stand = Stand::new(&mill()).expect("a board");
    let mut run = |keeps: i32, watcher: pump::Watcher<'_>| {
        let client = stand.client();
        let slots = client.stream_slots().expect("an answer").expect("it can stream");
        let mut feed = Feed::new(&compiled).expect("streamable");
        feed.set_keeps(&[keeps]);
        let mut job = Job::new(feed, slots.bytes.into());
        pump::run(client, &mut job, slots, watcher, &mut |_| ()).expect("an end")
    };
    assert_eq!(run(7, &mut quietly).keeps, [167]);
    let mut seen = Vec::new();
    let outcome = run(0, &mut |progress: &Progress| {
        seen.extend(&progress.keeps);
        (progress.count >= 30).then_some(Control::Stop)
    });
    assert_eq!(outcome.end, End::Stopped, "{outcome:?}");
    // Statement n is begun when n parts are done.
    assert_eq!(outcome.keeps, [100 + outcome.count as i32], "{outcome:?}");
    assert!((30..45).contains(&outcome.count), "{outcome:?}");
    assert!(seen.is_sorted() && seen.last() <= Some(&145), "{seen:?}");

    let client = stand.client();
    let slots = client.stream_slots().expect("an answer").expect("it can stream");
    let mut feed = Feed::new(&compiled).expect("streamable");
    feed.set_keeps(&[31]);
    let mut job = Job::new(feed, slots.bytes.into());
    job.skip(from_line(4), &mut Track::new(&mill(), [0; 3], 0)).expect("the state is known");
    let outcome = pump::run(client, &mut job, slots, &mut quietly, &mut |_| ()).expect("an end");
    assert_eq!(outcome.keeps, [91], "what was counted before line 4 is not counted again");
}
