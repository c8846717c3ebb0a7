//! The test stand: an emulated board with a script on it, watched at its pins.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use emulator::{Board, Edge, Family, Signal, TICKS_PER_SECOND};
use lang::back::Compiled;
use lang::hir::Program;
use lang::part::Part;
use lang::profile::{BUILT_IN, Profile};
use lang::record::BoardRecord;
use lang::wire::{Control, RunState};

use super::code::program;
use crate::board::judge::Judge;
use crate::board::link::InProcess;
use crate::board::rig::Rig;
use crate::board::{Build, DEFAULT};
use crate::client::identity::Identity;
use crate::client::{Client, ClientError};
use crate::course;
use crate::link::Link;
use crate::sim::world::{Registers, World};
use crate::stream::pump::Outcome;

/// Vectors of the step engine's timer: of Timer1_A (SLAS735, interrupt vector addresses) and of the F5529's
/// TA0 (SLAS590).
fn step_vectors(family: Family) -> [u16; 2] {
    match family {
        Family::Msp430 => [0xFFF8, 0xFFFA],
        Family::Msp430X => [0xFFE8, 0xFFEA],
    }
}

/// Ends the record of edges, on which the judge looks; gives them in ticks of `hz`.
fn judged(rig: &mut Rig, judge: &mut Judge, hz: u64) -> Result<Vec<Edge>, String> {
    rig.board().record(false);
    let mut edges = rig.board().take_edges();
    judge.take(&edges);
    judge.judge(&rig.plant(), false)?;
    let unit = rig.board().ticks_per_second() / hz;
    edges.iter_mut().for_each(|edge| edge.cycle /= unit);
    Ok(edges)
}

/// A board with a program.
pub struct Stand {
    rig: Rc<RefCell<Rig>>,
    client: Client<InProcess>,
    profile: Profile,
    part: Part,
    /// Of the edges' times, in a second.
    hz: u64,
}

/// The mill with another top rate and ramps, the shortest pulses and no fuss about travel.
///
/// # Errors
/// The profile refuses the rates.
pub fn fast_mill(top_rate: u32, accel: u32) -> Result<Profile, String> {
    let text = BUILT_IN[0]
        .1
        .replace("top_rate = 8000", &format!("top_rate = {top_rate}"))
        .replace("accel = 25000", &format!("accel = {accel}"))
        .replace("pulse_us = 3", "pulse_us = 2")
        .replace("dir_setup_us = 2", "dir_setup_us = 1");
    Profile::parse(&text).map_err(|error| error.to_string())
}

impl Stand {
    /// A board that nobody chose with the profile, without a program.
    ///
    /// # Errors
    /// The board does not answer.
    pub fn new(profile: &Profile) -> Result<Stand, String> {
        Stand::on(DEFAULT, profile)
    }

    /// The same with a build's chip.
    ///
    /// # Errors
    /// The board does not answer.
    pub fn on(build: &Build, profile: &Profile) -> Result<Stand, String> {
        Stand::with(build, profile, &World::empty())
    }

    /// The default board in a world, whose time begins when the rig is told so.
    ///
    /// # Errors
    /// The board does not answer, or the world fails.
    pub fn in_world(profile: &Profile, world: &World) -> Result<Stand, String> {
        Stand::with(DEFAULT, profile, world)
    }

    fn with(build: &Build, profile: &Profile, world: &World) -> Result<Stand, String> {
        let firmware = build.image().map_err(|error| error.to_string())?;
        let rig = Rig::new(build, &firmware, profile, world, &Registers::default())
            .map_err(|e| e.to_string())?;
        let rig = Rc::new(RefCell::new(rig));
        let mut client = Client::new(InProcess::new(Rc::clone(&rig)), 1);
        client.find().map_err(|error| error.to_string())?;
        let text = |error: ClientError| error.to_string();
        let record = BoardRecord::of(profile, client.board_record().map_err(text)?.sequence + 1);
        client.set_board_record(&record).map_err(text)?;
        client.restart().map_err(text)?;
        client.find().map_err(text)?;
        Ok(Stand { rig, client, profile: profile.clone(), part: build.part, hz: TICKS_PER_SECOND })
    }

    /// Gives edges in ticks of the chip's step timer instead of cycles of 16 MHz.
    pub fn in_ticks(mut self) -> Stand {
        self.hz = self.part.clock.into();
        self
    }

    /// The board's master.
    pub fn client(&mut self) -> &mut Client<InProcess> {
        &mut self.client
    }

    /// Compiles a script for the profile and brings it to the board; gives the time that took.
    ///
    /// # Errors
    /// The script is wrong or the board refuses it.
    pub fn upload(&mut self, image: &[u8]) -> Result<Duration, String> {
        let before = self.client.link().now();
        self.client.upload(image, true, &mut |_| {}).map_err(|error| error.to_string())?;
        Ok(self.client.link().now() - before)
    }

    /// Starts the program and follows it to its end, at most `limit` of its time; gives the edges
    /// at the pins, at cycles of 16 MHz.
    ///
    /// # Errors
    /// It does not start, ends in a fault, or makes steps that no motor of the profile follows.
    pub fn run(&mut self, limit: Duration) -> Result<Vec<Edge>, String> {
        self.run_asking(limit, Duration::from_millis(50))
    }

    /// The same with a status request after each `rest`.
    ///
    /// # Errors
    /// As [`Stand::run`].
    pub fn run_asking(&mut self, limit: Duration, rest: Duration) -> Result<Vec<Edge>, String> {
        let (_, runs) = self.client.run_state().map_err(|error| error.to_string())?;
        let mut judge = {
            let mut rig = self.rig.borrow_mut();
            rig.board().record(true);
            Judge::new(&self.profile, &rig.plant())
        };
        match self.client.control(Control::Start) {
            // The board may prepare its flash before it answers: the state tells.
            Ok(()) | Err(ClientError::Silent) => {}
            Err(error) => return Err(error.to_string()),
        }
        let end = self.client.link().now() + limit;
        loop {
            // The link is alive, as the figures demand, but not what is measured.
            self.client.link().pause(rest);
            let status = self.client.status().map_err(|error| error.to_string())?;
            match status.run_state {
                Some(RunState::Ready) if status.runs != runs => break,
                Some(RunState::Fault) => {
                    return Err(format!("fault {}", status.fault.unwrap_or_default()));
                }
                _ if self.client.link().now() > end => return Err("it does not end".to_owned()),
                _ => {}
            }
        }
        judged(&mut self.rig.borrow_mut(), &mut judge, self.hz)
    }

    /// Streams a job to its end; gives the edges at the pins, and how it went.
    ///
    /// # Errors
    /// The board cannot stream, the job ends in anything but done, or it makes steps that no motor of
    /// the profile follows.
    pub fn stream(&mut self, compiled: &Compiled) -> Result<(Vec<Edge>, Outcome), String> {
        let mut judge = {
            let mut rig = self.rig.borrow_mut();
            rig.board().record(true);
            Judge::new(&self.profile, &rig.plant())
        };
        let outcome = super::stream::feed(self, compiled)?;
        let mut rig = self.rig.borrow_mut();
        Ok((judged(&mut rig, &mut judge, self.hz)?, outcome))
    }

    /// Longest step interrupt since the board was made, cycles of the chip, and all that step interrupts took,
    /// cycles of 16 MHz.
    pub fn step_interrupts(&self) -> (u64, u64) {
        let mut rig = self.rig.borrow_mut();
        let unit = rig.board().ticks_per_second() / TICKS_PER_SECOND;
        let cycle = rig.board().ticks_per_second() / u64::from(self.part.clock);
        let vectors = step_vectors(rig.board().part().family);
        let interrupts = &rig.board().stats().interrupts;
        let own = vectors.iter().filter_map(|vector| interrupts.get(vector));
        let (worst, total) =
            own.fold((0, 0), |(worst, total), one| (worst.max(one.worst), total + one.total));
        (worst / cycle, total / unit)
    }

    /// Who the board is, and how it fared.
    ///
    /// # Errors
    /// The board does not answer.
    pub fn identity(&mut self) -> Result<Identity, String> {
        self.client.identity().map_err(|error| error.to_string())
    }

    /// The board's time, s.
    pub fn seconds(&mut self) -> f64 {
        self.client.link().now().as_secs_f64()
    }

    /// A copy of the board as it is, to be tried out without a link.
    pub fn copy(&self) -> Board {
        self.rig.borrow_mut().board().clone()
    }

    /// The board and its machine.
    pub fn rig(&self) -> Rc<RefCell<Rig>> {
        Rc::clone(&self.rig)
    }

    /// Where the motors stand, in steps.
    pub fn motors(&self) -> [i64; 3] {
        self.rig.borrow().motors()
    }
}

/// Compiles a script for a machine of the bench, as every part takes it.
///
/// # Errors
/// It is wrong.
pub fn image_for(profile: &Profile, text: &str) -> Result<(Program, Vec<u8>), String> {
    compiled(profile, text).map(|(program, compiled)| (program, compiled.image))
}

/// [`image_for`], with slow points where the part runs through its corners by them.
///
/// # Errors
/// It is wrong.
pub fn image_on(part: &Part, profile: &Profile, text: &str) -> Result<(Program, Vec<u8>), String> {
    let (program, compiled) = compiled(profile, text)?;
    let image = course::put_into(compiled, &program, part).image;
    Ok((program, image))
}

fn compiled(profile: &Profile, text: &str) -> Result<(Program, Compiled), String> {
    let (mut checked, _) = program("bench", text)?;
    checked.profile = profile.clone();
    let compiled = lang::back::compile(&checked).map_err(|excesses| format!("{excesses:?}"))?;
    Ok((checked, compiled))
}

/// Ticks of the rising edges of a signal.
pub fn rises(edges: &[Edge], signal: Signal) -> Vec<u64> {
    let own = edges.iter().filter(|edge| edge.signal == signal && edge.level);
    own.map(|edge| edge.cycle).collect()
}

/// Ticks from output 1 going on to output 1 going off.
///
/// # Errors
/// It did not do both.
pub fn gate(edges: &[Edge]) -> Result<u64, String> {
    let at = |level| {
        edges.iter().rev().find(|edge| edge.signal == Signal::Out(1) && edge.level == level)
    };
    match (at(true), at(false)) {
        (Some(on), Some(off)) if off.cycle > on.cycle => Ok(off.cycle - on.cycle),
        _ => Err("output 1 did not go on and off".to_owned()),
    }
}
