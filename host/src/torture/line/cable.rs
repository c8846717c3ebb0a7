//! Injects cable faults: unplugged at each byte of an upload, and noise in both directions.

use std::cell::RefCell;
use std::io;
use std::rc::Rc;
use std::time::Duration;

use emulator::{Board, Rng};
use lang::profile::Profile;

use super::super::power::image;
use super::super::stand::identity;
use super::super::{Row, Settings, Sink, Verdict};
use crate::board::Build;
use crate::board::link::InProcess;
use crate::board::rig::Rig;
use crate::client::Client;
use crate::link::{Link, Mode};
use crate::sim::world::{Registers, World};

/// Bytes of the longest upload here, and some more.
const LONGEST: u64 = 600;

/// A cable between a client and the board.
struct Cable {
    board: InProcess,
    /// Bytes to the board until it is pulled.
    left: Rc<RefCell<u64>>,
    /// One byte of so many is damaged, 0 for none.
    noise: u64,
    rng: Rng,
}

impl Cable {
    fn through(&mut self, bytes: &mut [u8]) {
        for byte in bytes {
            if self.noise != 0 && self.rng.below(self.noise) == 0 {
                *byte ^= 1 << self.rng.below(8);
            }
        }
    }
}

impl Link for Cable {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut bytes = bytes.to_vec();
        let left = *self.left.borrow();
        bytes.truncate(usize::try_from(left).unwrap_or(usize::MAX).min(bytes.len()));
        *self.left.borrow_mut() -= bytes.len() as u64;
        self.through(&mut bytes);
        self.board.send(&bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        let count = self.board.receive(buffer, patience)?;
        if *self.left.borrow() == 0 {
            return Ok(0);
        }
        self.through(&mut buffer[..count]);
        Ok(count)
    }

    fn now(&self) -> Duration {
        self.board.now()
    }

    fn pause(&mut self, time: Duration) {
        self.board.pause(time);
    }

    fn set_mode(&mut self, mode: Mode) -> io::Result<bool> {
        self.board.set_mode(mode)
    }
}

/// Does to a board what a cable must not.
pub type Spoil<'a> = &'a dyn Fn(&mut Board);

/// A client's board with the old program on it.
struct Desk {
    client: Client<Cable>,
    left: Rc<RefCell<u64>>,
    rig: Rc<RefCell<Rig>>,
    old: Vec<u8>,
    new: Vec<u8>,
}

impl Desk {
    fn new(build: &Build, noise: u64, rng: Rng) -> Result<Desk, String> {
        let firmware = build.image().map_err(|error| error.to_string())?;
        let profile = Profile::built_in("mill").map_err(|error| error.to_string())?;
        let rig = Rig::new(build, &firmware, &profile, &World::empty(), &Registers::default());
        let rig = Rc::new(RefCell::new(rig.map_err(|error| error.to_string())?));
        let left = Rc::new(RefCell::new(u64::MAX));
        let cable =
            Cable { board: InProcess::new(Rc::clone(&rig)), left: Rc::clone(&left), noise, rng };
        let mut client = Client::new(cable, 1);
        let old = image("PRINT \"old\"\nSetOut 1, ON\nWait 5ms")?;
        let new = image("PRINT \"new\"\nSetOut 2, ON")?;
        client.link().noise = 0;
        client.find().map_err(|error| error.to_string())?;
        client.upload(&old, false, &mut |_| {}).map_err(|error| error.to_string())?;
        client.link().noise = noise;
        Ok(Desk { client, left, rig, old, new })
    }

    /// What the board holds, over a sound cable.
    fn held(&mut self) -> Result<(), String> {
        *self.left.borrow_mut() = u64::MAX;
        self.client.link().noise = 0;
        let board = self.client.identity().map_err(|error| format!("plugged in: {error}"))?;
        let found = (board.program_bytes, board.program_crc);
        if found != identity(&self.old) && found != identity(&self.new) {
            return Err(format!("neither the old program nor the new one: {found:04X?}"));
        }
        let new = self.new.clone();
        self.client.upload(&new, false, &mut |_| {}).map_err(|error| format!("again: {error}"))
    }
}

/// Pulls the cable behind byte `n` of an upload; `None` when the upload has not so many.
///
/// # Errors
/// What did not hold.
pub fn pulled(build: &Build, n: u64, spoil: Spoil<'_>) -> Result<Option<()>, String> {
    let mut desk = Desk::new(build, 0, Rng::new(n))?;
    *desk.left.borrow_mut() = n;
    let new = desk.new.clone();
    let began = desk.client.link().now();
    let result = desk.client.upload(&new, false, &mut |_| {});
    spoil(desk.rig.borrow_mut().board());
    if desk.client.link().now() - began > Duration::from_secs(20) {
        return Err("the client does not give up".to_owned());
    }
    match (result, *desk.left.borrow()) {
        (Ok(()), 1..) => return Ok(None),
        (Ok(()), 0) => {}
        (Err(error), _) if error.to_string().is_empty() => {
            return Err("the client says nothing".to_owned());
        }
        (Err(_), _) => {}
    }
    desk.held().map(Some)
}

/// An upload over a cable on which one byte of 60 to 800 is damaged.
///
/// # Errors
/// What did not hold.
pub fn noisy(build: &Build, mut rng: Rng, spoil: Spoil<'_>) -> Result<(), String> {
    let noise = 60 + rng.below(740);
    let mut desk = Desk::new(build, noise, rng)?;
    let new = desk.new.clone();
    // It may fail, but then it says so: what it says it has done must be done.
    let done = desk.client.upload(&new, false, &mut |_| {}).is_ok();
    spoil(desk.rig.borrow_mut().board());
    desk.client.link().noise = 0;
    let board = desk.client.identity().map_err(|error| error.to_string())?;
    if done && (board.program_bytes, board.program_crc) != identity(&new) {
        return Err("the client says that the program is there, but it is not".to_owned());
    }
    desk.held()
}

/// Bad cables.
///
/// # Errors
/// The table cannot be written.
pub fn run(build: &Build, settings: &Settings, sink: Sink<'_>) -> Result<(), String> {
    let mut row = Row::on(build, "line", "cable pulled at each byte", settings);
    let cases = settings.count(5, 150, LONGEST).clamp(1, LONGEST);
    row.run(settings, cases, |n| match pulled(build, n * (LONGEST / cases), &|_| {}) {
        Ok(Some(())) => Verdict::Survived,
        Ok(None) => Verdict::Skipped,
        Err(text) => Verdict::Lost(text),
    });
    sink(row)?;
    let fault = "uploads over a noisy cable";
    let mut row = Row::on(build, "line", fault, settings);
    row.run(settings, settings.count(5, 150, 1_500), |n| {
        noisy(build, settings.rng(fault, n), &|_| {})
            .map_or_else(Verdict::Lost, |()| Verdict::Survived)
    });
    sink(row)
}
