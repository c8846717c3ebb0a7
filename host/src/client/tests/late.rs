//! The master against boards whose reply is late or lost, so that it asks again.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::io;
use std::rc::Rc;
use std::time::Duration;

use lang::axis::Axis;
use lang::profile::Profile;
use lang::wire::{self, Control, RunState, Upload};

use crate::bench::stand::image_on;
use crate::board::link::InProcess;
use crate::board::rig::Rig;
use crate::board::{Build, F5529, G2553};
use crate::client::{Client, orders};
use crate::link::{Link, Mode};
use crate::sim::world::{Registers, World};

/// What befalls one request.
#[derive(Clone, Copy, PartialEq)]
enum Mishap {
    /// Its reply is lost.
    Lost,
    /// The board takes it and what is asked after it this much later.
    Late(Duration),
}

/// A link to an emulated board on which a mishap befalls the first request that `meant` names.
struct Mishaps {
    link: InProcess,
    meant: fn(&[u8]) -> bool,
    mishap: Option<Mishap>,
    /// Requests that the board has not taken yet, and when it takes them.
    waiting: VecDeque<Vec<u8>>,
    until: Duration,
    /// The next reply is lost.
    loses: bool,
}

impl Link for Mishaps {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        if (self.meant)(bytes) {
            match self.mishap.take() {
                Some(Mishap::Late(by)) => self.until = self.link.now() + by,
                Some(Mishap::Lost) => self.loses = true,
                None => {}
            }
        }
        if self.link.now() < self.until || !self.waiting.is_empty() {
            self.waiting.push_back(bytes.to_vec());
            return Ok(());
        }
        self.link.send(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        if self.link.now() < self.until {
            let left = patience.min(self.until - self.link.now());
            self.link.pause(left);
            return Ok(0);
        }
        if let Some(bytes) = self.waiting.pop_front() {
            self.link.send(&bytes)?;
            // Up to its end by the silence behind it, so that it is a frame of its own.
            self.link.pause(Duration::from_micros(1_900));
        }
        let count = self.link.receive(buffer, patience)?;
        if self.loses && count > 0 {
            // The rest of it.
            self.link.pause(Duration::from_millis(20));
            while self.link.receive(buffer, Duration::ZERO)? > 0 {}
            self.loses = false;
            return Ok(0);
        }
        Ok(count)
    }

    fn now(&self) -> Duration {
        self.link.now()
    }

    fn pause(&mut self, time: Duration) {
        self.link.pause(time);
    }

    fn set_mode(&mut self, mode: Mode) -> io::Result<bool> {
        self.link.set_mode(mode)
    }
}

/// A link to an emulated board that answers.
pub(super) fn emulated(build: &'static Build) -> InProcess {
    let firmware = build.image().expect("the firmware");
    let mill = Profile::built_in("mill").expect("built in");
    let rig = Rig::new(build, &firmware, &mill, &World::empty(), &Registers::default());
    let rig = Rc::new(RefCell::new(rig.expect("a rig")));
    rig.borrow_mut().begin();
    let mut client = Client::new(InProcess::new(rig), 1);
    client.find().expect("it answers");
    client.into_link()
}

fn client(build: &'static Build, meant: fn(&[u8]) -> bool, mishap: Mishap) -> Client<Mishaps> {
    let link = Mishaps {
        link: emulated(build),
        meant,
        mishap: Some(mishap),
        waiting: VecDeque::new(),
        until: Duration::ZERO,
        loses: false,
    };
    Client::new(link, 1)
}

/// Whether a frame writes that value to a register.
fn writes(frame: &[u8], register: u16, value: u16) -> bool {
    let [a, b] = register.to_be_bytes();
    let [c, d] = value.to_be_bytes();
    frame.get(1..6) == Some(&[6, a, b, c, d])
}

fn writes_words(frame: &[u8]) -> bool {
    frame.get(1) == Some(&16) && frame.len() > 40
}

/// A step of an upload, by its requests.
type Step = (&'static str, fn(&[u8]) -> bool);

const STEPS: [Step; 6] = [
    ("length", |frame| frame.get(1..4) == Some(&[6, 0x13, 0xC5])),
    ("begin", |frame| writes(frame, wire::UPLOAD_CONTROL, Upload::Begin as u16)),
    ("words", writes_words),
    ("commit", |frame| writes(frame, wire::UPLOAD_CONTROL, Upload::Commit as u16)),
    ("select", |frame| writes(frame, wire::SELECTED, 1)),
    ("read", |frame| frame.get(1) == Some(&3)),
];

#[test]
fn a_program_comes_and_starts_whatever_reply_is_late_or_lost() {
    let mill = Profile::built_in("mill").expect("built in");
    for build in [&F5529, &G2553] {
        let script = "KEEP parts\nparts = parts + 7\nWait 5s\n";
        let (_, image) = image_on(&build.part, &mill, script).expect("a program");
        for (what, meant) in STEPS {
            if what == "select" && build.part.programs == 1 {
                continue;
            }
            for mishap in [Mishap::Lost, Mishap::Late(Duration::from_millis(900))] {
                let told = || format!("{}: {what}", build.part.name);
                let mut client = client(build, meant, mishap);
                let brought = client.bring(&image, (None, "job.bas"), true, &mut |_| {});
                assert!(brought.is_ok(), "{}: {}", told(), brought.unwrap_err());
                assert!(client.link().mishap.is_none(), "{}: it did not happen", told());
                client
                    .control(Control::Start)
                    .unwrap_or_else(|error| panic!("{}: {error}", told()));
                let state = client.wait_for(&[RunState::Running]).expect("it answers");
                assert_eq!(state, Ok(RunState::Running), "{}", told());
            }
        }
    }
}

/// Reads have no register in their replies: the second one to an older read is no value of the next.
#[test]
fn a_late_reply_is_no_reply_to_the_next_read() {
    let late = Mishap::Late(Duration::from_millis(900));
    let mut client = client(&F5529, |frame| frame.get(1) == Some(&3), late);
    let version = client.holding(wire::VERSION, 1).expect("it answers");
    let fingerprint = client.holding(wire::ISA_FINGERPRINT, 1).expect("it answers");
    assert_eq!(fingerprint, [lang::isa::FINGERPRINT]);
    assert_eq!(client.holding(wire::VERSION, 1).expect("it answers"), version);
    assert_ne!(version, fingerprint);
}

/// A link with a pause before each request, as a busy computer makes them.
struct Slow(InProcess);

impl Link for Slow {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.pause(Duration::from_millis(7));
        self.0.send(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        self.0.receive(buffer, patience)
    }

    fn now(&self) -> Duration {
        self.0.now()
    }

    fn pause(&mut self, time: Duration) {
        self.0.pause(time);
    }

    fn set_mode(&mut self, mode: Mode) -> io::Result<bool> {
        self.0.set_mode(mode)
    }
}

/// An axis that a status shows at rest rests at the place that it shows.
#[test]
fn an_axis_at_rest_is_shown_where_it_rests() {
    for build in [&F5529, &G2553] {
        let mut client = Client::new(Slow(emulated(build)), 1);
        for n in 1u16..40 {
            let order = orders::move_to(Axis::X, [50_000; 2], 1000, i64::from(n) * 25);
            client.order(&order, String::new).expect("it moves");
            client.link().pause(Duration::from_millis(u64::from(n % 8)));
            let rest = loop {
                let status = client.status().expect("it answers");
                if status.moving.is_empty() {
                    break status.pos;
                }
            };
            assert_eq!(rest, client.status().expect("it answers").pos, "{}: {n}", build.part.name);
        }
    }
}
