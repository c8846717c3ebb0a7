//! Handlers of streamed jobs on the real firmware in the emulator: what the link, its user and the
//! emergency stop do to them.

use std::time::Duration;

use lang::axis::Axis;
use lang::fault::Fault;
use lang::wire::{Called, Control, End, Exception, RunState, Stream};

use super::super::feed::Feed;
use super::super::job::Job;
use super::super::pump::{self, Outcome};
use super::{by_hand, checked, compile, mill, quietly, stream};
use crate::bench::stand::Stand;
use crate::client::stream::Call;
use crate::link::Link;
use crate::sim::trace::What;
use crate::sim::world::World;
use crate::sim::{Engine, Options, run_traced};
use crate::track::Track;

/// Streams a job to a board in a world; it prints and ends as in the simulation.
fn as_in_the_simulation(text: &str, world: &str) -> (Outcome, [i64; 3]) {
    let world = World::parse("world", world).expect("a world");
    let (program, _) = compile(text);
    let (simulated, trace) =
        run_traced(&program, Engine::Vm, &world, &Options::default()).expect("simulated");
    let mut stand = Stand::in_world(&mill(), &world).expect("a board");
    stand.rig().borrow_mut().begin();
    let (outcome, printed) = stream(&mut stand, text, &mut quietly);
    let lines: String = trace
        .iter()
        .filter_map(|event| match &event.what {
            What::Print { text, .. } => Some(format!("{text}\n")),
            _ => None,
        })
        .collect();
    assert_eq!(printed, lines, "{outcome:?}");
    assert_eq!(outcome.fault, simulated.end.fault);
    let motors = stand.motors();
    for axis in Axis::ALL {
        if let Some(What::End { pos, .. }) = trace.last().map(|event| &event.what) {
            assert_eq!(motors[axis.index()], i64::from(pos.get(axis).unwrap_or(0)));
        }
    }
    (outcome, motors)
}

#[test]
fn errors_are_handled_as_in_a_stored_program() {
    let text = "DIM n, a\nON ERROR GOTO oops\nF600\nG1 X2\na = 1 / n\nWait -5ms * (n + 1)\n\
        G1 X[4mm + a * 1mm]\nn = 7\nON ERROR STOP\nPRINT \"n=\"; n\nEND\noops:\na = a + 1\n\
        PRINT \"F\"; ERR; \" in \"; ERL\nRESUME NEXT\n";
    let (outcome, motors) = as_in_the_simulation(text, "");
    assert_eq!((outcome.end, motors), (End::Done, [600, 0, 0]), "{outcome:?}");
}

#[test]
fn events_are_served_between_statements_and_in_waits() {
    let text = "DIM n, ticks\nON IN 3 RISE GOSUB hit\nON EVERY 300ms GOSUB tick\n\
        MoveAxe X, 10mm, 10mm/s\nn = n + 10\nMoveAxe X, 20mm, 10mm/s\nWait 1s\nON EVERY OFF\n\
        ON IN 3 OFF\nPRINT n; \" \"; ticks > 3\nEND\n\
        hit:\nPRINT \"hit \"; n\nn = n + 1\nRETURN\nSUB tick\nticks = ticks + 1\nEND SUB\n";
    let world = "at(500, || set_in(3, true)); at(700, || set_in(3, false)); \
                 at(1500, || set_in(3, true));";
    let (outcome, motors) = as_in_the_simulation(text, world);
    assert_eq!((outcome.end, motors), (End::Done, [2000, 0, 0]), "{outcome:?}");
}

#[test]
fn an_event_in_the_last_statement_is_served_and_the_job_still_ends() {
    let text = "DIM n\nON IN 3 RISE GOSUB hit\nSetOut 1, ON\nPRINT \"on\"\nWait 900ms\nEND\n\
        hit:\nn = n + 1\nPRINT \"hit \"; n\nMoveAxe Y, 2mm\nRETURN\n";
    let (outcome, motors) = as_in_the_simulation(text, "at(600, || set_in(3, true));");
    assert_eq!((outcome.end, motors), (End::Done, [0, 200, 0]), "{outcome:?}");
}

#[test]
fn an_error_in_a_handler_ends_the_run_at_its_line() {
    let text = "DIM n\nON ERROR GOTO oops\nON IN 3 RISE GOSUB hit\nMoveAxe X, 8mm, 10mm/s\n\
        PRINT \"behind\"\nWait 1s\nEND\nhit:\nPRINT \"hit\"\nn = 1 / n\nRETURN\noops:\n\
        PRINT \"oops \"; ERL\nn = 1 / n\nRESUME NEXT\n";
    let (outcome, _) = as_in_the_simulation(text, "at(400, || set_in(3, true));");
    assert_eq!((outcome.end, outcome.line), (End::Fault, 14), "{outcome:?}");
}

#[test]
fn a_handler_may_end_the_job_without_a_word_to_the_machine() {
    let text = "DIM n\nON ERROR GOTO oops\nMoveAxe X, 1mm\nn = 1 / n\nMoveAxe X, 5mm\noops:\nEND\n";
    let (outcome, motors) = as_in_the_simulation(text, "");
    assert_eq!((outcome.end, motors), (End::Done, [100, 0, 0]), "{outcome:?}");
}

/// What a program computes while the board has nothing to do is interrupted, too.
#[test]
fn a_job_that_only_computes_is_interrupted() {
    let text = "DIM n, m\nON IN 3 RISE GOSUB hit\nm = 5 + IN(4)\nDO\n  m = (m * 3 + 1) MOD 1001\nLOOP UNTIL n = 1\n\
        PRINT \"left\"\nEND\nhit:\nn = 1\nRETURN\n";
    let (outcome, _) = as_in_the_simulation(text, "at(400, || set_in(3, true));");
    assert_eq!(outcome.end, End::Done, "{outcome:?}");
}

#[test]
fn a_job_with_handlers_begins_anew_in_the_middle() {
    let text = "DIM n\nON ERROR GOTO oops\nON IN 3 RISE GOSUB hit\nMoveAxe X, 50mm\n\
        n = n + 4\nWait 600ms\nn = 1 / (n - n)\nPRINT n\nEND\n\
        hit:\nPRINT \"hit \"; n\nRETURN\noops:\nPRINT \"F\"; ERR\nRESUME NEXT\n";
    let (program, compiled) = compile(text);
    let world = World::parse("world", "at(300, || set_in(3, true));").expect("a world");
    let mut stand = Stand::in_world(&mill(), &world).expect("a board");
    let slots = stand.client().stream_slots().expect("an answer").expect("it can stream");
    let mut job = Job::new(Feed::new(&compiled).expect("streamable"), slots.bytes.into());
    let mut track = Track::new(&program.profile, [0; 3], 0);
    job.skip(super::from_line(6), &mut track).expect("the state is known");
    job.lead(track.restore().expect("a state"));
    stand.rig().borrow_mut().begin();
    let mut printed = Vec::new();
    let mut print = |bytes: &[u8]| printed.extend_from_slice(bytes);
    let outcome = pump::run(stand.client(), &mut job, slots, &mut quietly, &mut print);
    assert_eq!(outcome.expect("an end").end, End::Done);
    assert_eq!(String::from_utf8_lossy(&printed), "hit 4\nF2\n4\n");
    assert_eq!(stand.motors(), [0; 3]);

    let mut job = Job::new(Feed::new(&compiled).expect("streamable"), 180);
    let refused = job.skip(super::from_line(13), &mut Track::new(&program.profile, [0; 3], 0));
    assert!(refused.expect_err("the handler").text.contains("handler"));
}

#[test]
fn the_check_before_the_first_move_knows_handlers() {
    let text = "ON ERROR GOTO oops\nG1 X400 F600\nG1 X5\nEND\noops:\nRESUME NEXT\n";
    assert_eq!(checked(text, 7).expect("handled").open, None);
    let refused = checked(&text.replace("END", "ON ERROR STOP\nG1 X401"), 7);
    assert_eq!(refused.expect_err("not handled").line, 5);
    let text = "ON IN 3 RISE GOSUB hit\nG1 X5 F600\nhit:\nRETURN\n";
    assert_eq!(checked(text, 0).expect("sound").open, Some(1));
}

/// A job whose handler is called while X goes on by itself and output 2 is on.
const CALLS: &str = "SetOut 2, ON\nON IN 3 RISE GOSUB hit\nON EVERY 5s GOSUB hit\nSTART MoveAxe X, 80mm\nWait 60s\nEND\n\
    hit:\nSend 65\nRETURN\n";

fn edge(stand: &mut Stand, on: bool) {
    stand.rig().borrow_mut().board().plant_mut().set_input(3, on);
    stand.client().link().pause(Duration::from_millis(40));
}

fn called(stand: &mut Stand) -> Option<Call> {
    stand.client().stream_standing().expect("an answer").call
}

const EDGE: Option<Call> = Some(Call { place: Called::Within, slot: 0, fault: None });

#[test]
fn a_link_lost_while_a_handler_is_awaited_ends_the_run_with_f18_and_outputs_off() {
    let (mut stand, _) = by_hand(CALLS);
    stand.client().link().pause(Duration::from_millis(100));
    assert_eq!(called(&mut stand), None);
    edge(&mut stand, true);
    assert_eq!(called(&mut stand), EDGE);
    let there = stand.motors()[0];
    stand.client().link().pause(Duration::from_millis(1500));
    assert!(stand.motors()[0] > there + 1000, "the axis goes on");
    let status = stand.client().status().expect("an answer");
    assert_eq!((status.state, &status.outputs[..]), ("running", &[2][..]));
    stand.client().link().pause(Duration::from_millis(2500));
    let status = stand.client().status().expect("an answer");
    assert_eq!((status.state, status.fault), ("fault", Some(Fault::LinkLost.to_string())));
    assert!(status.outputs.is_empty() && status.moving.is_empty(), "{:?}", status.outputs);
    let there = stand.motors();
    stand.client().link().pause(Duration::from_millis(300));
    assert_eq!(stand.motors(), there);
}

#[test]
fn stop_and_emergency_stop_end_a_run_that_awaits_a_handler() {
    for (control, end, fault) in [
        (Control::Stop, End::Stopped, None),
        (Control::EmergencyStop, End::Fault, Some(Fault::EmergencyStop)),
    ] {
        let (mut stand, _) = by_hand(CALLS);
        edge(&mut stand, true);
        assert_eq!(called(&mut stand), EDGE);
        stand.client().write(lang::wire::RUN_CONTROL, control as u16).expect("taken");
        stand.client().link().pause(Duration::from_millis(400));
        let standing = stand.client().stream_standing().expect("an answer");
        assert_eq!(standing.end, Some(end));
        assert_eq!(Fault::from_number(standing.fault as u8), fault);
        assert!(stand.client().status().expect("an answer").outputs.is_empty());
        if fault.is_some() {
            stand.client().control(Control::Acknowledge).expect("acknowledged");
        }
        // Nothing of it is left for the next job.
        let text = "MoveRel Y, 1mm\nPRINT \"well\"\n";
        let (outcome, printed) = stream(&mut stand, text, &mut quietly);
        assert_eq!((outcome.end, printed.as_str()), (End::Done, "well\n"));
    }
}

#[test]
fn no_handler_is_called_in_a_pause() {
    let (mut stand, _) = by_hand(CALLS);
    stand.client().link().pause(Duration::from_millis(100));
    stand.client().write(lang::wire::RUN_CONTROL, Control::Pause as u16).expect("taken");
    stand.client().link().pause(Duration::from_millis(500));
    edge(&mut stand, true);
    let standing = stand.client().stream_standing().expect("an answer");
    assert_eq!((standing.state, standing.call), (Some(RunState::Paused), None));
    stand.client().write(lang::wire::RUN_CONTROL, Control::Resume as u16).expect("taken");
    stand.client().link().pause(Duration::from_millis(40));
    assert_eq!(called(&mut stand), EDGE);
}

#[test]
fn what_was_sent_before_the_call_is_refused_and_the_answer_is_taken_once() {
    let (mut stand, slots) = by_hand(CALLS);
    edge(&mut stand, true);
    let standing = stand.client().stream_standing().expect("an answer");
    assert_eq!((standing.call, standing.begun, standing.accepted), (EDGE, 1, 1));
    // As it would have gone on.
    let (_, compiled) = compile("Send 65\nWait 60s\n");
    let mut job = Job::new(Feed::new(&compiled).expect("an image"), slots.bytes.into());
    let mut piece = job.piece().expect("a piece").bytes;
    let client = stand.client();
    assert!(!client.stream_piece(&slots, 1, &piece).expect("refused"));
    let error = client.stream_control(Stream::Finish).expect_err("it waits");
    assert!(error.is_exception(Exception::Busy));
    // The same with its number and as an answer, twice: the reply was lost.
    piece[17] = 1;
    piece[18] = 1;
    let record = [&piece[..20], job.machine(), &piece[20..]].concat();
    piece[4..6].copy_from_slice(&lang::image::crc_of(&record).to_le_bytes());
    for _ in 0..2 {
        assert!(client.stream_piece(&slots, 1, &piece).expect("taken"));
        client.link().pause(Duration::from_millis(30));
        let standing = client.stream_standing().expect("an answer");
        assert_eq!((standing.call, standing.begun, standing.accepted), (None, 2, 2));
    }
    assert_eq!(client.holding(lang::wire::CHAR_OUT, 1).expect("an answer"), [0x0141], "sent once");
}
