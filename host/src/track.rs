//! Abstract interpreter of a job's modal state: commanded positions, work zeros, F, S, outputs after each statement.
//!
//! The check before the first move and a start in the middle both follow the job with it.

mod along;
mod approach;

use std::collections::BTreeMap;

use lang::axis::Axis;
use lang::effect::{Act, Action, Coord, Effect, Rate, Want};
use lang::fault::Fault;
use lang::isa::{Op, flags};
use lang::place::Place;
use lang::plain::{Argument, MOST, Plain, Touch};
use lang::profile::{AxisProfile, OutputRole, Profile, Wiring};
use lang::record::{AxisRecord, MachineRecord};
use lang::vm::encode::encode;

use self::along::Along;
pub use self::approach::Approach;
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
    /// Values that analog outputs were given.
    aouts: BTreeMap<i32, i32>,
    /// Axes whose work zero the job has set.
    zeroed: [bool; 3],
    /// Axes that the job has sent anywhere.
    touched: [bool; 3],
    /// The highest machine position of Z that it has commanded, um.
    top: Option<i32>,
    drivers: Option<bool>,
    /// The ON lines that are armed: kind, input or period.
    events: [Option<(u8, i32)>; 4],
    along: Along,
}

/// An instruction with its values.
pub type Instruction = (Vec<i32>, Vec<u8>);

/// Whether it is one of an analog output: these have numbers of their own.
fn is_analog(action: &Action) -> bool {
    matches!(action.act, Act::Analog(_))
}

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
            aouts: BTreeMap::new(),
            zeroed: [false; 3],
            touched: [false; 3],
            top: None,
            drivers: None,
            events: [None; 4],
            along: Along::default(),
        }
    }

    /// The machine.
    pub fn profile(&self) -> &Profile {
        &self.profile
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
        self.end_path(effect);
        match *effect {
            Effect::Linear { to, .. } | Effect::Arc { to, .. } => {
                let before = self.steps();
                self.words(&to)?;
                self.block(effect, before);
            }
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
            Effect::Sync(own) => {
                match own.act {
                    Act::Set(_) => self.output(own.n)?,
                    Act::Pulse(ms) if ms < 0 => return Err(Fault::ValueRange),
                    Act::Pulse(_) => self.output(own.n)?,
                    Act::Analog(value) => self.aout(own.n, value)?,
                }
                self.along.add(own);
            }
            Effect::SetAout { n, value } => {
                self.aout(n, value)?;
                self.along.forget(|own| own.n == n && is_analog(own));
                self.aouts.insert(n, value);
            }
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

    /// A statement that waits for the path's end carries out what is to act along it.
    fn end_path(&mut self, effect: &Effect) {
        let ms = match effect {
            Effect::Linear { .. }
            | Effect::Arc { .. }
            | Effect::SetFeed(_)
            | Effect::SetSpindle(_)
            | Effect::Sync(_) => return,
            Effect::Plain(Plain::Wait, [ms, _]) | Effect::Plain(Plain::Pulse, [_, ms]) => {
                Some(f64::from(*ms).max(0.0))
            }
            Effect::Plain(plain, _) if !plain.waits() => Some(0.0),
            Effect::SetPos { .. } | Effect::Motors { .. } | Effect::SetAout { .. } => Some(0.0),
            Effect::PrintText(_) | Effect::PrintValue(..) | Effect::PrintEnd => Some(0.0),
            _ => None,
        };
        let acted = self.along.end(ms);
        self.acted(&acted);
    }

    /// A block of the path that began at `before`, steps, was followed.
    fn block(&mut self, effect: &Effect, before: [i32; 3]) {
        let after = self.steps();
        let records = &self.record.axes;
        let um_per_step =
            [0, 1, 2].map(|i| f64::from(records[i].um) / f64::from(records[i].steps.max(1)));
        let steps = [0, 1, 2].map(|i| f64::from(after[i]) - f64::from(before[i]));
        let by = [0, 1, 2].map(|i| steps[i] * um_per_step[i]);
        let um = match effect {
            Effect::Arc { clockwise, plane, center, .. } => {
                along::arc(by, *clockwise, *plane, center, um_per_step)
            }
            _ => along::straight(by),
        };
        let seconds = match (effect, self.feed) {
            (Effect::Linear { rapid: true, .. }, _) | (_, None) => {
                let each =
                    [0, 1, 2].map(|i| steps[i].abs() / f64::from(records[i].top_rate.max(1)));
                each.into_iter().fold(0.0, f64::max)
            }
            (_, Some(Rate::Um(rate))) => um / f64::from(rate.max(1)),
            (_, Some(Rate::Steps(rate))) => along::straight(steps) / f64::from(rate.max(1)),
        };
        let acted = self.along.block(um, seconds * 1000.0);
        self.acted(&acted);
    }

    fn acted(&mut self, actions: &[Action]) {
        for Action { n, act, .. } in actions {
            match *act {
                Act::Set(level) => self.outputs.insert(*n, level),
                // It is over.
                Act::Pulse(_) => self.outputs.insert(*n, 0),
                Act::Analog(value) => self.aouts.insert(*n, value),
            };
        }
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
            Touch::Output => {
                self.along.forget(|own| own.n == first && !is_analog(own));
                self.outputs.insert(first, second);
            }
            Touch::Off => {
                self.along.forget(|own| own.n == first && !is_analog(own));
                self.outputs.insert(first, 0);
            }
            Touch::Port => {
                self.along.forget(|own| own.n <= 8 && !is_analog(own));
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

    /// Whether an analog output takes a value.
    fn aout(&self, n: i32, value: i32) -> Result<(), Fault> {
        let own = self.profile.aouts.iter().find(|aout| aout.n == n);
        if !own.is_some_and(|aout| (0..=aout.full()).contains(&value)) {
            return Err(Fault::ValueRange);
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
                self.went(axis);
            }
        }
        Ok(())
    }

    /// The axis was sent to where it is commanded now.
    fn went(&mut self, axis: Axis) {
        self.touched[axis.index()] = true;
        if axis == Axis::Z {
            let um = self.axes.place(axis).um;
            self.top = Some(self.top.map_or(um, |top| self.higher(top, um)));
        }
    }

    /// The higher one of two positions of Z, um.
    fn higher(&self, a: i32, b: i32) -> i32 {
        let down = self.profile.z.as_ref().is_some_and(AxisProfile::counts_down);
        if down { a.min(b) } else { a.max(b) }
    }

    /// Axes that the job has homed.
    pub fn homed(&self) -> impl Iterator<Item = Axis> + '_ {
        Axis::ALL.into_iter().filter(|axis| self.axes.is_homed(*axis))
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
        self.went(axis);
        Ok(())
    }

    /// Outputs of those in `on` (bit n - 1) that an approach switches off: all but what a role keeps.
    pub fn darkens(&self, on: u16) -> Vec<Instruction> {
        let kept = |n: i32| {
            let role = self.profile.outputs.iter().find(|output| output.n == n);
            matches!(
                role.and_then(|output| output.role),
                Some(OutputRole::Enable | OutputRole::Lamp)
            )
        };
        let off = |n: i32| (vec![n, 0], vec![Op::SetOut.code()]);
        (1..=self.most_outputs()).filter(|n| on >> (n - 1) & 1 != 0 && !kept(*n)).map(off).collect()
    }

    /// What brings a board whose axes stand where the job does into the state that was followed, without a
    /// motion: work zeros, F, S, drivers, outputs that are on, spin-up time, ON lines, and outputs that are still to act
    /// along the path. Of a pulse that had begun there is no rest.
    ///
    /// # Errors
    /// F01.
    pub fn restore(&self) -> Result<Vec<Instruction>, Fault> {
        let mut list: Vec<Instruction> = Vec::new();
        for axis in Axis::ALL {
            let i = axis.index();
            if self.zeroed[i] {
                // The board counts its zero from where the axis stands now.
                let work = self.axes.work_at(axis, self.axes.steps(axis))?;
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
        list.extend(self.aouts.iter().map(|(&n, &v)| (vec![n, v], vec![Op::SetAout.code()])));
        let spin_up = i32::from(self.profile.run.spin_up_ms);
        if spin_up > 0 && self.outputs.values().any(|on| *on != 0) {
            list.push((vec![spin_up], vec![Op::Wait.code()]));
        }
        for (slot, event) in (0..).zip(&self.events) {
            if let Some((kind, value)) = *event {
                list.push((vec![value], vec![Op::Event.code(), kind | slot]));
            }
        }
        // Last: what waits for the path's end would carry them out.
        let left = self.along.effects().filter_map(|effect| encode(&effect));
        list.extend(left.map(|own| (own.values().to_vec(), own.code().to_vec())));
        Ok(list)
    }
}
