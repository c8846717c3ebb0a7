//! What the firmware's machine does on the desktop, without an emulator: a test for each thing that a board is trusted
//! with.

use std::cell::RefCell;
use std::rc::Rc;

use desk::board::NativeBoard;
use emulator::plant::Contact;
use emulator::{Rng, Wiring};
use lang::fault::Fault;
use lang::profile::Profile;
use lang::wire::{Control, End, FAULT, MACHINE_POSITIONS, RunState};
use pasapas::board::DEFAULT;
use pasapas::board::engine::{run_native_traced, run_traced};
use pasapas::board::link::InProcess;
use pasapas::board::rig::Rig;
use pasapas::client::Client;
use pasapas::sim::Options;
use pasapas::sim::trace::{Event, to_text};
use pasapas::sim::world::{Registers, World};
use pasapas::stream::feed::Feed;
use pasapas::stream::job::Job;
use pasapas::stream::pump;
use pasapas::torture::Verdict;
use pasapas::torture::generate::Case;
use pasapas::torture::power::{self, Failure};
use pasapas::torture::programs::{Made, make};
use pasapas::torture::registers;
use pasapas::torture::stand::Stand;
use pasapas::torture::table::Table;
use pasapas::torture::times::{LATER_US, apart};
use proptest::prelude::*;

fn made(script: &str, world: &str) -> Made {
    let case = Case { script: script.to_owned(), world: world.to_owned(), independent: false };
    make(case).expect("it compiles")
}

/// A board that runs a script since some microseconds.
fn running(script: &str, us: u64) -> Stand<NativeBoard> {
    let mut stand = Stand::native();
    stand.upload(&made(script, "").compiled.image, false).expect("it is taken");
    stand.control(Control::Start);
    stand.board.run_us(us);
    stand
}

fn pulses(stand: &Stand<NativeBoard>) -> [u64; 3] {
    stand.board.plant().motors.each_ref().map(|motor| motor.pulses)
}

/// Traces are the emulated board's, and so are the times.
fn as_on_the_board(script: &str, world: &str) {
    let made = made(script, world);
    let (program, compiled, world) = (&made.program, &made.compiled, &made.world);
    let options = Options::default();
    let (_, native) =
        run_native_traced(DEFAULT, program, compiled, world, &options).expect("a run");
    let (image, sidecar) = (&compiled.image, &compiled.sidecar);
    let board = run_traced(DEFAULT, program, image, sidecar, world, &options);
    let (_, board) = board.expect("a run");
    assert_eq!(to_text(&native), to_text(&board), "{script}");
    let (share, place) = apart(&native, &board, LATER_US).expect("times");
    assert!(share <= 1.0, "{script}: {place}");
}

/// A wait behind a start is whole: what the check of the image and its KEEP values took is none of its time.
#[test]
fn the_first_wait_of_a_run_is_whole() {
    let text = "PRINT \"a line that makes the image long enough for its check to take its time\"\n";
    for head in ["", "KEEP kept\n"] {
        let script =
            format!("{head}SetOut 1, ON\nWait 100ms\nSetOut 1, OFF\nEND\n{}", text.repeat(30));
        let made = made(&script, "");
        let (program, compiled) = (&made.program, &made.compiled);
        let options = Options::default();
        let run = run_native_traced(DEFAULT, program, compiled, &made.world, &options);
        let (_, events) = run.expect("a run");
        let us = |n: usize| events[n].us.expect("a time");
        let waited = us(2) - us(1);
        assert!((99_000..102_000).contains(&waited), "{head}{waited} us");
    }
}

/// VM time: what the program's own instructions take is counted by a typical instruction's cycles, and multiplications
/// take more.
#[test]
fn computing_takes_its_time() {
    let script = "DIM i, sum, n\nSetOut 1, ON\nFOR i = 1 TO 3000\nsum = sum + i * 3\n\
         IF sum > 90000 THEN sum = sum - 90000\nn = n XOR sum\nNEXT\nSetOut 1, OFF\nPRINT sum; \" \"; n";
    let made = made(script, "");
    let (program, compiled) = (&made.program, &made.compiled);
    let options = Options::default();
    let native = run_native_traced(DEFAULT, program, compiled, &made.world, &options);
    let (image, sidecar) = (&compiled.image, &compiled.sidecar);
    let board = run_traced(DEFAULT, program, image, sidecar, &made.world, &options);
    let [native, board] = [native, board].map(|run| run.expect("a run").1);
    assert_eq!(to_text(&native), to_text(&board));
    let us = |events: &[Event]| events[1].us.zip(events[0].us).map(|(end, start)| end - start);
    let [native, board] = [us(&native), us(&board)].map(|us| us.expect("times") as f64);
    assert!((0.6..1.2).contains(&(native / board)), "{native} us, {board} us on the board");
}

#[test]
fn handlers_come_between_statements() {
    as_on_the_board(
        "DIM n, i\nON IN 3 RISE GOSUB edge\nON EVERY 70ms GOSUB tick\nFOR i = 1 TO 40\nWait 11ms\nNEXT\nPRINT n\nEND\n\
         edge:\nSetOut 2, ON\nWait 5ms\nSetOut 2, OFF\nRETURN\nSUB tick\nn = n + 1\nEND SUB\n",
        "at(123, || set_in(3, true)); at(223, || set_in(3, false)); at(321, || set_in(3, true));",
    );
    as_on_the_board(
        "DIM a\nON ERROR GOTO oops\nMoveAxe X, 1mm\nPRINT 1 / a\nPRINT \"behind\"\nEND\noops:\nSetOut 1, ON\n\
         PRINT ERR; \" \"; ERL\nRESUME NEXT",
        "",
    );
}

/// Between any two steps: the one that is armed is made, and no other.
#[test]
fn an_emergency_stop_ends_steps_at_once() {
    let mut rng = Rng::new(5);
    for n in 0..40 {
        let mut stand = running("MoveAxe X, 200mm", 200_000 + rng.below(300_000));
        assert_eq!(stand.state(), Some(RunState::Running as u16));
        let before = pulses(&stand)[0];
        assert!(before > 0, "case {n}");
        stand.control(Control::EmergencyStop);
        let ceased = pulses(&stand);
        stand.board.run_us(200_000);
        assert_eq!(pulses(&stand), ceased, "case {n}");
        assert_eq!(stand.read(FAULT), Some(Fault::EmergencyStop.number().into()));
        let at = stand.board.plant().motors[0].position;
        assert_eq!(stand.read_long(MACHINE_POSITIONS).map(i64::from), Some(at), "case {n}");
    }
}

#[test]
fn a_limit_switch_ends_a_run() {
    for position in [60_i64, 333, 2_000] {
        let mut stand = running("Wait 50ms\nMoveAxe X, -100mm", 0);
        let switch = Contact { axis: 0, position: -position, above: false };
        stand.board.plant_mut().switches[0] = Some(switch);
        stand.board.run_us(6_000_000);
        assert_eq!(stand.read(FAULT), Some(Fault::LimitSwitch.number().into()), "{position}");
        let at = stand.board.plant().motors[0].position;
        // Two looks of a millisecond behind the switch at 8 000 steps/s at most.
        assert!((-position - 20..=-position).contains(&at), "{at} behind {position}");
        assert_eq!(stand.read_long(MACHINE_POSITIONS).map(i64::from), Some(at));
    }
}

#[test]
fn a_path_goes_on_where_it_was_paused() {
    let script = "G90\nF1200\nG1 X4 Y1\nG1 X8 Y3\nG1 X12 Y2\nG1 X14 Y8";
    let ends = |pauses: &[u64]| {
        let mut stand = running(script, 0);
        for us in pauses {
            stand.board.run_us(*us);
            stand.control(Control::Pause);
            stand.board.run_us(900_000);
            assert_eq!(stand.state(), Some(RunState::Paused as u16));
            let rests = pulses(&stand);
            stand.board.run_us(200_000);
            assert_eq!(pulses(&stand), rests, "it rests");
            stand.control(Control::Resume);
        }
        stand.board.run_us(5_000_000);
        assert_eq!(stand.state(), Some(RunState::Ready as u16));
        (pulses(&stand), stand.board.plant().motors.each_ref().map(|motor| motor.position))
    };
    let whole = ends(&[]);
    for pauses in [&[60_000][..], &[150_000, 90_000], &[210_000, 30_000, 120_000]] {
        assert_eq!(ends(pauses), whole, "{pauses:?}");
    }
}

/// Each operation of the flash of each write is cut once, with bits that come out as they like.
#[test]
fn power_may_fail_in_any_operation_of_the_flash() {
    let mut cut = 0;
    for write in power::writes_on_desk().expect("the writes") {
        let most = write.operations();
        // The largest writes are of some thousand words.
        for n in (1..=most).step_by((most / 150).max(1) as usize) {
            let verdict = write.fail(Failure::Cut, n, n, &|_| {}).expect("so many operations");
            assert_eq!(verdict, Verdict::Survived, "operation {n} of {most}");
            cut += 1;
        }
    }
    assert!(cut > 100, "{cut} cuts");
}

/// A job that is streamed leaves the motors where it leaves them from the store, and another board beside it where it was.
#[test]
fn a_job_is_streamed_while_another_machine_runs() {
    let script =
        "DIM i\nG90\nF2400\nFOR i = 1 TO 60\nG1 X3 Y1\nG1 X1 Y4\nG1 X[0.1mm * i] Y0\nNEXT\n";
    let made = made(script, "");
    let mill = Profile::built_in("mill").expect("the mill");
    let board = NativeBoard::with(&mill);
    let rig = Rig::around(board, &mill, &World::empty(), &Registers::default()).expect("a rig");
    let rig = Rc::new(RefCell::new(rig));
    let mut client = Client::new(InProcess::new(Rc::clone(&rig)), 1);
    client.find().expect("it answers");
    let slots = client.stream_slots().expect("an answer").expect("it can stream");
    let mut job = Job::new(Feed::new(&made.compiled).expect("an image"), slots.bytes.into());
    let mut other = running("DO\nMoveAxe Y, 5mm\nMoveAxe Y, 0mm\nLOOP", 0);
    let mut meanwhile = |_: &pump::Progress| {
        other.board.run_us(10_000);
        None
    };
    let outcome =
        pump::run(&mut client, &mut job, slots, &mut meanwhile, &mut |_| ()).expect("a run");
    assert_eq!(outcome.end, End::Done, "{outcome:?}");
    assert!(outcome.pieces > 1, "{outcome:?}");
    let mut stored = running(script, 0);
    stored.board.run_us(60_000_000);
    assert_eq!(stored.state(), Some(RunState::Ready as u16));
    let places = |board: &NativeBoard| board.plant().motors.each_ref().map(|motor| motor.position);
    assert_eq!(places(rig.borrow_mut().board()), places(&stored.board));
    let [x, y, z] = pulses(&other);
    assert!(x == 0 && y > 0 && z == 0);
    assert_eq!(other.state(), Some(RunState::Running as u16));
}

/// Two machines in one process do the same whether the other one is there or not.
#[test]
fn two_machines_at_once_are_two() {
    let scripts =
        ["DO\nMoveAxe X, 3mm\nSetOut 1, ON\nMoveAxe X, 0mm\nSetOut 1, OFF\nLOOP", "G1 Y40 F900"];
    let alone = scripts.map(|script| {
        let mut stand = running(script, 0);
        for _ in 0..100 {
            stand.board.run_us(10_000);
        }
        (pulses(&stand), stand.board.plant().outputs())
    });
    let mut both = scripts.map(|script| running(script, 0));
    for _ in 0..100 {
        for stand in &mut both {
            stand.board.run_us(10_000);
        }
    }
    let together = both.each_ref().map(|stand| (pulses(stand), stand.board.plant().outputs()));
    assert_eq!(alone, together);
    assert_eq!(both[0].board.plant().wiring(), Wiring::Chain);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// Whatever is written, read, pressed, cut or pulled, at whatever time: see [`registers::storm`].
    #[test]
    fn registers_at_any_time(data in prop::collection::vec(any::<u8>(), 0..300)) {
        if let Err(text) = registers::storm(&data) {
            return Err(TestCaseError::fail(text));
        }
    }
}
