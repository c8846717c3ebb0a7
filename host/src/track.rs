//! What a job leaves behind statement by statement: commanded places, work zeros, F, S, outputs.
//!
//! The check before the first move and a start in the middle both follow the job with it.

use std::collections::BTreeMap;

use lang::axis::Axis;
use lang::effect::{Coord, Effect, Rate, Want};
use lang::fault::Fault;
use lang::isa::{Op, flags};
use lang::place::Place;
use lang::plain::{Argument, MOST, Plain, Touch};
use lang::profile::{OutputRole, Profile, Wiring};
use lang::record::{AxisRecord, MachineRecord};

use crate::sim::machine::axes::Axes;

/// Outputs of the chain wiring and of the direct one.
const OUTPUTS: [i32; 2] = [16, 2];

/// See the module.
#[derive(Debug)]
pub struct Track {
    profile: Profile,
    record: MachineRecord,
    axes: Axes,
    feed: Option<Rate>,
    spindle: Option<i32>,
    outputs: BTreeMap<i32, i32>,
    /// Axes whose work zero the job has set.
    zeroed: [bool; 3],
    drivers: Option<bool>,
    /// The ON lines that are armed: kind, input or period.
    events: [Option<(u8, i32)>; 4],
}

/// An instruction with its values.
pub type Instruction = (Vec<i32>, Vec<u8>);

impl Track {
    /// Every axis at `steps`; bit n of `homed`: axis n is homed.
    pub fn new(profile: &Profile, steps: [i32; 3], homed: u16) -> Track {
        let record = MachineRecord::of(profile);
        let mut axes = Axes::new(profile, &record, true);
        for axis in Axis::ALL {
            axes.adopt(axis, steps[axis.index()]);
            axes.set_homed(axis, homed >> axis.index() & 1 != 0);
        }
        Track {
            profile: profile.clone(),
            record,
            axes,
            feed: None,
            spindle: None,
            outputs: BTreeMap::new(),
            zeroed: [false; 3],
            drivers: None,
            events: [None; 4],
        }
    }

    /// Where an axis is commanded to.
    pub fn place(&self, axis: Axis) -> Place {
        self.axes.place(axis)
    }

    /// Where its work position is 0, um.
    ///
    /// # Errors
    /// F01.
    pub fn zero(&self, axis: Axis) -> Result<i32, Fault> {
        let work = self.axes.work_at(axis, self.axes.steps(axis))?;
        self.axes.place(axis).um.checked_sub(work).ok_or(Fault::Overflow)
    }

    /// F.
    pub fn feed(&self) -> Option<Rate> {
        self.feed
    }

    /// Commanded machine positions, steps.
    pub fn steps(&self) -> [i32; 3] {
        Axis::ALL.map(|axis| self.axes.steps(axis))
    }

    /// Whether what follows an effect depends on what the machine answers.
    pub fn is_open(effect: &Effect) -> bool {
        match effect {
            Effect::Read(_)
            | Effect::Probe { .. }
            | Effect::MoveSpeed { .. }
            | Effect::StopAxe(_) => true,
            Effect::Plain(plain, _) => plain.touches() == Touch::Axes,
            _ => false,
        }
    }

    /// Whether an effect lets events come from then on.
    pub fn arms(effect: &Effect) -> bool {
        matches!(effect, Effect::OnInput { .. } | Effect::OnEvery { .. })
    }

    fn arm(&mut self, slot: u8, kind: u8, value: i32) {
        if let Some(event) = self.events.get_mut(usize::from(slot)) {
            *event = Some((kind, value));
        }
    }

    /// Follows an effect.
    ///
    /// # Errors
    /// The fault that the machine will answer it with.
    pub fn follow(&mut self, effect: &Effect) -> Result<(), Fault> {
        match *effect {
            Effect::Linear { to, .. } | Effect::Arc { to, .. } => self.words(&to)?,
            Effect::MoveAxe { axis, to, .. } => {
                let mut words = [None; 3];
                words[axis.index()] = Some(to);
                self.words(&words)?;
            }
            Effect::Home { axis, .. } => self.home(axis)?,
            Effect::SetPos { axis, value } => {
                self.axes.set_work(axis, value)?;
                self.zeroed[axis.index()] = true;
            }
            Effect::SetFeed(rate) => {
                let (Rate::Um(value) | Rate::Steps(value)) = rate;
                if value <= 0 {
                    return Err(Fault::SpeedRange);
                }
                self.feed = Some(rate);
            }
            Effect::SetSpindle(value) => self.spindle = Some(value),
            Effect::Plain(plain, values) => self.plain(plain, values)?,
            Effect::Motors { on, axis } => {
                self.drivers = Some(on);
                for axis in axis.map_or(Axis::ALL.to_vec(), |axis| vec![axis]) {
                    if !on {
                        self.axes.set_homed(axis, false);
                    }
                }
            }
            Effect::OnEvery { slot, ms } => {
                if ms <= 0 {
                    return Err(Fault::ValueRange);
                }
                self.arm(slot, flags::ON_EVERY, ms);
            }
            Effect::OnInput { slot, n, want } => {
                if !(1..=17).contains(&n) {
                    return Err(Fault::ValueRange);
                }
                let kind = if want == Want::Rise { flags::ON_RISE } else { flags::ON_FALL };
                self.arm(slot, kind, n);
            }
            Effect::OffEvery => self.disarm(|(kind, _)| kind == flags::ON_EVERY),
            Effect::OffInput(n) => self.disarm(|event| event.0 != flags::ON_EVERY && event.1 == n),
            _ => {}
        }
        Ok(())
    }

    fn disarm(&mut self, which: impl Fn((u8, i32)) -> bool) {
        for event in &mut self.events {
            if event.is_some_and(&which) {
                *event = None;
            }
        }
    }

    /// Follows a plain statement by what its row says of it.
    fn plain(&mut self, plain: Plain, values: [i32; MOST]) -> Result<(), Fault> {
        for (argument, value) in plain.arguments().iter().zip(values) {
            match argument {
                Argument::Output => self.output(value)?,
                Argument::Time if value < 0 => return Err(Fault::ValueRange),
                _ => {}
            }
        }
        let [first, second] = values;
        match plain.touches() {
            Touch::Nothing | Touch::Axes => {}
            Touch::Output => _ = self.outputs.insert(first, second),
            Touch::Off => _ = self.outputs.insert(first, 0),
            Touch::Port => {
                for n in 1..=self.most_outputs().min(8) {
                    let role = self.profile.outputs.iter().find(|output| output.n == n);
                    let role = role.and_then(|output| output.role);
                    if !matches!(role, Some(OutputRole::Enable | OutputRole::Lamp)) {
                        self.outputs.insert(n, first >> (n - 1) & 1);
                    }
                }
            }
        }
        Ok(())
    }

    fn most_outputs(&self) -> i32 {
        OUTPUTS[usize::from(self.profile.wiring == Wiring::Direct)]
    }

    fn output(&self, n: i32) -> Result<(), Fault> {
        if (1..=self.most_outputs()).contains(&n) { Ok(()) } else { Err(Fault::ValueRange) }
    }

    fn words(&mut self, to: &[Option<Coord>; 3]) -> Result<(), Fault> {
        let mut places: [Option<Place>; 3] = [None; 3];
        for axis in Axis::ALL.into_iter().rev() {
            if let Some(word) = to[axis.index()] {
                let place = self.axes.aim(axis, word, self.axes.place(axis))?;
                places[axis.index()] = Some(place);
            }
        }
        for axis in Axis::ALL {
            if let Some(place) = places[axis.index()] {
                self.axes.command(axis, place);
            }
        }
        Ok(())
    }

    /// The axis rests behind its clearance move.
    fn home(&mut self, axis: Axis) -> Result<(), Fault> {
        if !self.axes.is_present(axis) {
            return Err(Fault::ValueRange);
        }
        let record = self.record.axes[axis.index()];
        let positive = record.flags & AxisRecord::HOME_POSITIVE != 0;
        let away = if positive { -record.home_clearance } else { record.home_clearance };
        let um = record.home_position.checked_add(away).ok_or(Fault::Overflow)?;
        self.axes.clear_offset(axis);
        self.zeroed[axis.index()] = false;
        self.axes.adopt(axis, self.axes.to_steps(axis, um)?);
        self.axes.set_homed(axis, true);
        Ok(())
    }

    /// What brings a board whose axes stand at `steps` into the state that was followed, without a
    /// motion: work zeros, F, S, drivers, outputs that are on, spin-up time, ON lines.
    ///
    /// # Errors
    /// F01.
    pub fn restore(&self, steps: [i32; 3]) -> Result<Vec<Instruction>, Fault> {
        let mut list: Vec<Instruction> = Vec::new();
        for axis in Axis::ALL {
            let i = axis.index();
            if self.zeroed[i] {
                // The board counts its zero from where the axis stands now.
                let work = self.axes.work_at(axis, steps[i])?;
                list.push((vec![work], vec![Op::SetPos.code(), i as u8]));
            }
        }
        match self.feed {
            Some(Rate::Um(value)) => list.push((vec![value], vec![Op::Feed.code()])),
            Some(Rate::Steps(value)) => list.push((vec![value], vec![Op::FeedSteps.code()])),
            None => {}
        }
        if let Some(value) = self.spindle {
            list.push((vec![value], vec![Op::Spindle.code()]));
        }
        if let Some(on) = self.drivers {
            list.push((vec![on.into()], vec![Op::Motors.code(), flags::ALL_AXES]));
        }
        for (&n, &on) in self.outputs.iter().filter(|(_, on)| **on != 0) {
            list.push((vec![n, on], vec![Op::SetOut.code()]));
        }
        let spin_up = i32::from(self.profile.run.spin_up_ms);
        if spin_up > 0 && self.outputs.values().any(|on| *on != 0) {
            list.push((vec![spin_up], vec![Op::Wait.code()]));
        }
        for (slot, event) in (0..).zip(&self.events) {
            if let Some((kind, value)) = *event {
                list.push((vec![value], vec![Op::Event.code(), kind | slot]));
            }
        }
        Ok(list)
    }
}
