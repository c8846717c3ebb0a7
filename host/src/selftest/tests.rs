//! The test on virtual boards, which pass it, and on boards with something wrong, which do not.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use lang::profile::Profile;
use lang::record::BoardRecord;

use super::{Ask, Plan, Report, Trouble, Verdict, run};
use crate::board::link::InProcess;
use crate::board::rig::Rig;
use crate::board::{Build, F5529, G2553, G2553_HANDLERS};
use crate::client::Client;
use crate::link::{Link, Mode};
use crate::sim::world::{Registers, World};

pub(super) const ALL: Plan = Plan {
    unplugged: true,
    jumpers: true,
    captures: false,
    hands: false,
    replace: false,
    rates: true,
    listen: Duration::from_secs(2),
};

/// Wires from the outputs to the inputs of their numbers, but for some.
pub(super) fn wires(ends: impl Fn(u16) -> Option<u16>) -> World {
    let wire = |n: u16| {
        let end = ends(n)?;
        Some(format!(
            "after_out({n}, true, 0, || set_in({end}, true));\nafter_out({n}, false, 0, || set_in({end}, \
             false));\n"
        ))
    };
    let text: String = (1..=16).filter_map(wire).collect();
    World::parse("wires", &text).expect("a world")
}

/// A link whose clock runs otherwise than the board's.
struct Skewed(InProcess, f64);

impl Link for Skewed {
    fn send(&mut self, bytes: &[u8]) -> std::io::Result<()> {
        self.0.send(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> std::io::Result<usize> {
        self.0.receive(buffer, patience)
    }

    fn now(&self) -> Duration {
        self.0.now().mul_f64(self.1)
    }

    fn pause(&mut self, time: Duration) {
        self.0.pause(time);
    }

    fn set_mode(&mut self, mode: Mode) -> std::io::Result<bool> {
        self.0.set_mode(mode)
    }
}

pub(super) type Board = (Rc<RefCell<Rig>>, Client<InProcess>);

fn board(build: &Build, world: &World) -> Board {
    board_of(build, world, &Profile::built_in("mill").expect("built in"))
}

/// A board with its profile's part in its flash.
pub(super) fn board_of(build: &Build, world: &World, profile: &Profile) -> Board {
    let firmware = build.image().expect("the firmware");
    let rig = Rig::new(build, &firmware, profile, world, &Registers::default()).expect("a rig");
    let rig = Rc::new(RefCell::new(rig));
    let record = BoardRecord::of(profile, 1).to_bytes();
    let first = build.part.profiles[0];
    (first..).zip(record).for_each(|(at, byte)| rig.borrow_mut().board().poke8(at, byte));
    rig.borrow_mut().begin();
    let mut client = Client::new(InProcess::new(Rc::clone(&rig)), 1);
    client.find().expect("it answers");
    (rig, client)
}

fn measured(board: &mut Client<InProcess>, plan: Plan) -> Result<Report, Trouble> {
    run(board, plan, &mut |_| {}, &mut |_| {})
}

/// The checks that found something else than expected.
pub(super) fn bad(report: &Report) -> Vec<&str> {
    let bad = report.rows.iter().filter(|row| row.verdict == Verdict::Bad);
    bad.map(|row| row.check.as_str()).collect()
}

#[test]
fn virtual_boards_keep_what_is_promised() {
    for build in [&G2553, &G2553_HANDLERS, &F5529] {
        let (_rig, mut client) = board(build, &wires(Some));
        let before = client.board_record().expect("its profile");
        let report = measured(&mut client, ALL).expect("it is measured");
        assert_eq!(bad(&report), [""; 0], "{}: {:#?}", build.part.name, report.rows);
        assert_eq!(report.part, build.part.name);
        let left = if build.part == F5529.part { 2 } else { 4 };
        assert!(report.rows.len() >= 20 && report.left == left, "{:#?}", report.rows);
        let after = client.board_record().expect("its profile");
        assert_eq!((before.flags, before.rate), (after.flags, after.rate));
        assert_eq!(client.identity().expect("it answers").program_bytes, 0);
    }
}

/// A board that was never told how it is wired is measured with a profile of the test's own, and is told nothing by it.
#[test]
fn a_board_without_a_profile_has_none_afterwards() {
    let (rig, mut client) = board(&F5529, &wires(|_| None));
    for place in F5529.part.profiles {
        (place..)
            .zip([0xFF; BoardRecord::SIZE])
            .for_each(|(at, byte)| rig.borrow_mut().board().poke8(at, byte));
    }
    rig.borrow_mut().board().reset_pin();
    client.find().expect("it answers");
    assert_ne!(client.board_record().expect("its profile").flags & BoardRecord::UNWIRED, 0);
    let plan = Plan { unplugged: false, jumpers: false, rates: false, ..ALL };
    let report = measured(&mut client, plan).expect("it is measured");
    assert_eq!(bad(&report), [""; 0], "{:#?}", report.rows);
    assert_ne!(client.board_record().expect("its profile").flags & BoardRecord::UNWIRED, 0);
    assert_eq!(client.status().expect("its state").blocked_by, Some(lang::wire::UNWIRED));
}

#[test]
fn each_fault_is_found_by_its_check() {
    // A wire that is broken, one that goes elsewhere, and no emergency stop.
    let world = wires(|n| match n {
        1 | 7 => None,
        3 => Some(4),
        n => Some(n),
    });
    let (_rig, mut client) = board(&F5529, &world);
    let report = measured(&mut client, ALL).expect("it is measured");
    assert_eq!(
        bad(&report),
        ["it comes back through 16 wires", "outputs behind a reset", "emergency stop by a contact"]
    );
    let found = report.rows.iter().find(|row| row.check.starts_with("it comes back"));
    let found = found.map(|row| row.found.as_str());
    let told = "output 1 changes nothing; output 3 changes [4]; output 7 changes nothing";
    assert_eq!(found, Some(told));
    // A clock that is off: that of the board, as the computer sees it.
    let plan = Plan { unplugged: false, ..ALL };
    for (build, off) in [(&G2553, 1.04), (&F5529, 0.992)] {
        let (_rig, client) = board(build, &World::empty());
        let mut client = Client::new(Skewed(client.into_link(), off), 1);
        let report = run(&mut client, plan, &mut |_| {}, &mut |_| {}).expect("it is measured");
        let found = bad(&report);
        assert!(found.contains(&"millisecond"), "{found:?}");
    }
    // A line with noise.
    let (rig, mut client) = board(&F5529, &World::empty());
    rig.borrow_mut().board().set_uart_noise(5, 200);
    let noisy = measured(&mut client, plan);
    let seen = |check: &&str| check.starts_with("link at") || check.starts_with("requests while");
    let found = noisy.map(|report| bad(&report).iter().any(seen));
    assert!(found.unwrap_or(true), "noise is not seen");
}

/// KEEP values take two segments behind their program: they alone are erased again and again.
#[test]
fn segments_are_erased_under_requests() {
    let plan = Plan { unplugged: false, listen: Duration::from_millis(100), ..ALL };
    let (rig, mut client) = board(&F5529, &World::empty());
    let report = measured(&mut client, plan).expect("it is measured");
    let row = report.rows.iter().find(|row| row.check == "requests while flash is erased");
    assert!(row.is_some_and(|row| row.verdict == Verdict::Good), "{row:?}");
    let mut rig = rig.borrow_mut();
    let erases = &rig.board().wear().erases;
    let again = erases.values().filter(|count| **count > 1);
    assert!(again.sum::<u32>() >= 3, "{erases:x?}");
}

#[test]
fn nothing_is_moved_or_switched_unasked() {
    let (rig, mut client) = board(&F5529, &World::empty());
    let plan = Plan { unplugged: false, ..ALL };
    let report = measured(&mut client, plan).expect("it is measured");
    let left: Vec<&str> = report
        .rows
        .iter()
        .filter(|row| matches!(row.verdict, Verdict::Left(_)))
        .map(|row| row.check.as_str())
        .collect();
    assert_eq!(
        left,
        ["outputs", "inputs", "motion", "pulses, widths and times at the pins", "Start, Stop, RST"]
    );
    let mut rig = rig.borrow_mut();
    assert_eq!((rig.pulses(), rig.take_output_edges()), ([0; 3], Vec::new()));
}

#[test]
fn a_program_is_given_up_only_when_that_is_said() {
    let (_rig, mut client) = board(&G2553, &World::empty());
    let plan = Plan { unplugged: false, listen: Duration::from_secs(1), ..ALL };
    // As a fresh board with a program of its own.
    let (_, image) = crate::bench::stand::image_for(
        &Profile::built_in("mill").expect("built in"),
        "SetOut 1, ON\n",
    )
    .expect("a program");
    client.upload(&image, true, &mut |_| {}).expect("it is taken");
    let refused = measured(&mut client, plan).expect_err("it holds a program");
    assert!(refused.to_string().contains("--replace"), "{refused}");
    assert!(client.identity().expect("it answers").program_bytes > 0);
    assert!(measured(&mut client, Plan { replace: true, ..plan }).is_ok());
}

#[test]
fn hands_are_seen() {
    let plan = Plan { hands: true, unplugged: false, listen: Duration::from_millis(100), ..ALL };
    let verdicts = |report: &Report| {
        let rows = report.rows.iter().filter(|row| ["Start", "Stop", "RST"].contains(&&*row.check));
        rows.map(|row| row.verdict == Verdict::Good).collect::<Vec<_>>()
    };
    let (rig, mut client) = board(&F5529, &World::empty());
    let mut press = |ask: Ask<'_>| {
        let Ask::Press(words) = ask else { return };
        let mut rig = rig.borrow_mut();
        rig.board().plant_mut().press_start(words.contains("Start"));
        rig.board().plant_mut().press_stop(words.contains("Stop"));
        if words.contains("RST") {
            rig.board().reset_pin();
        }
    };
    let report = run(&mut client, plan, &mut |_| {}, &mut press).expect("it is measured");
    assert_eq!(verdicts(&report), [true; 3], "{:#?}", report.rows);
    // Nobody is there.
    let (_rig, mut client) = board(&F5529, &World::empty());
    let report = measured(&mut client, plan).expect("it is measured");
    assert_eq!(verdicts(&report), [false; 3], "{:#?}", report.rows);
}

/// A link that is at a standstill each time that an erase is asked for, as often as it says: the computer's clock goes on,
/// the board's does not.
struct Stalls {
    link: InProcess,
    times: u32,
    left: Duration,
    lag: Duration,
}

impl Link for Stalls {
    fn send(&mut self, bytes: &[u8]) -> std::io::Result<()> {
        let [a, b] = lang::wire::UPLOAD_CONTROL.to_be_bytes();
        let replace = lang::wire::Upload::Replace as u8;
        if self.times > 0 && bytes.get(1..6) == Some(&[6, a, b, 0, replace]) {
            self.times -= 1;
            self.left = Duration::from_millis(900);
        }
        self.link.send(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> std::io::Result<usize> {
        if self.left.is_zero() {
            return self.link.receive(buffer, patience);
        }
        let waited = patience.min(self.left);
        self.left -= waited;
        self.lag += waited;
        Ok(0)
    }

    fn now(&self) -> Duration {
        self.link.now() + self.lag
    }

    fn pause(&mut self, time: Duration) {
        self.link.pause(time);
    }

    fn set_mode(&mut self, mode: Mode) -> std::io::Result<bool> {
        self.link.set_mode(mode)
    }
}

/// How long an erase takes is the board's time: a computer that is busy for a while makes no flash slow. One that is slow
/// each time is.
#[test]
fn a_busy_computer_makes_no_flash_slow() {
    let plan = Plan { unplugged: false, rates: false, listen: Duration::from_millis(100), ..ALL };
    for (times, good) in [(2, true), (u32::MAX, false)] {
        let (_rig, client) = board(&G2553, &World::empty());
        let link =
            Stalls { link: client.into_link(), times, left: Duration::ZERO, lag: Duration::ZERO };
        let mut client = Client::new(link, 1);
        let report = run(&mut client, plan, &mut |_| {}, &mut |_| {}).expect("it is measured");
        let row = report.rows.iter().find(|row| row.check == "erase of the program area");
        let verdict = row.map(|row| row.verdict == Verdict::Good);
        assert_eq!(verdict, Some(good), "{times}: {row:?}");
    }
}
