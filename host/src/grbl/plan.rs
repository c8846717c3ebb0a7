//! Executes a line: new modal words and offsets, commands for the machine, and what to wait for.
//!
//! The order within a line is Grbl's (gcode.c, `gc_execute_line`). Nothing changes until the
//! whole line is valid.

mod path;

use super::Error;
use super::block::{Block, Extra, Flow, Once, Stored};
use super::modal::{INCH, Modal, Motion, Offsets, Point, Spindle};
use super::order::{Order, Target};
use super::settings::Machine;

/// Farthest place that a client may name, mm.
const FARTHEST: f64 = 1_000_000.0;
/// Slowest and fastest feed that is passed on, um/s.
const FEEDS: (f64, f64) = (1.0, 16_000_000.0);
/// Longest dwell, s.
const LONGEST_DWELL: f64 = 2_000_000.0;

/// What a plan is made from.
#[derive(Clone, Copy, Debug)]
pub struct Here<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// The modal words before the line.
    pub modal: &'a Modal,
    /// The offsets before the line.
    pub offsets: &'a Offsets,
    /// Where the lines before it lead to, machine frame.
    pub at: Point,
    /// Axes that know their place.
    pub homed: [bool; 3],
    /// Per cent of S.
    pub speed_override: u16,
}

/// What is waited for before the line is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sync {
    /// Rest.
    Rest,
    /// Rest; then the program is over.
    End,
    /// A probe; a miss is an alarm unless it is quiet.
    Probe {
        /// G38.3, G38.5
        quiet: bool,
    },
    /// The reference run.
    Home,
    /// Rest; then the place is told.
    Place,
    /// Rest; then an input, from 1, is told.
    Input(u16),
}

/// See the module.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The modal words behind the line.
    pub modal: Modal,
    /// The offsets behind it, where they differ.
    pub offsets: Option<Box<Offsets>>,
    /// Where it leads to, machine frame.
    pub to: Point,
    /// For the machine.
    pub orders: Vec<Order>,
    /// What is waited for.
    pub sync: Option<Sync>,
    /// How long it takes at least, s.
    pub seconds: f64,
    /// Whether an output that M42 set is on: `Some` where the line sets one.
    pub output: Option<(u16, bool)>,
    /// Asks what this is.
    pub firmware: bool,
}

/// Why a line is not done.
#[derive(Clone, Debug, PartialEq)]
pub enum Refusal {
    /// With this answer.
    Error(Error),
    /// With this answer, and words before it.
    Told(Error, String),
    /// Its end lies out of the travel of this axis.
    Travel(usize),
}

impl From<Error> for Refusal {
    fn from(error: Error) -> Refusal {
        Refusal::Error(error)
    }
}

/// A place in whole um.
///
/// # Errors
/// It is too far away.
pub fn um(mm: f64) -> Result<i32, Error> {
    // NaN is too far, too.
    if mm.abs() <= FARTHEST { Ok((mm * 1000.0).round() as i32) } else { Err(Error::TARGET) }
}

/// A feed in mm/min as um/s, within what a board takes.
pub fn feed(mm_min: f64) -> i32 {
    (mm_min * 1000.0 / 60.0).clamp(FEEDS.0, FEEDS.1).round() as i32
}

/// The axes of a move that come to another um. `Err` where there is no such axis, the travel ends
/// before, or the machine wants to be homed first.
///
/// # Errors
/// See above.
pub fn target(here: &Here<'_>, from: Point, to: Point) -> Result<Target, Refusal> {
    let mut target = [None; 3];
    for i in 0..3 {
        let (start, end) = (um(from[i])?, um(to[i])?);
        let Some(axis) = &here.machine.axes[i] else {
            if end != 0 {
                let words = format!("the machine {} has no {}", here.machine.name, LETTERS[i]);
                return Err(Refusal::Told(Error::UNSUPPORTED, words));
            }
            continue;
        };
        if end == start {
            continue;
        }
        if here.machine.require_homing && !here.homed[i] {
            let words = format!("{} has to be homed first ($H)", LETTERS[i]);
            return Err(Refusal::Told(Error::LOCKED, words));
        }
        if here.homed[i] && !(um(axis.min)?..=um(axis.max)?).contains(&end) {
            return Err(Refusal::Travel(i));
        }
        target[i] = Some(end);
    }
    Ok(target)
}

const LETTERS: [char; 3] = ['X', 'Y', 'Z'];

fn distance(from: Point, to: Point) -> f64 {
    from.iter().zip(to).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// Plans a line.
///
/// # Errors
/// Why it is not done; then nothing of it is.
pub fn plan(block: &Block, here: &Here<'_>) -> Result<Plan, Refusal> {
    let mut planner = Planner {
        block,
        here,
        scale: if block.inches.unwrap_or(here.modal.inches) { INCH } else { 1.0 },
        plan: Plan {
            modal: here.modal.clone(),
            offsets: None,
            to: here.at,
            orders: Vec::new(),
            sync: None,
            seconds: 0.0,
            output: None,
            firmware: false,
        },
    };
    planner.line()?;
    Ok(planner.plan)
}

struct Planner<'a, 'b> {
    block: &'a Block,
    here: &'a Here<'b>,
    /// Millimetres of what the client counts in.
    scale: f64,
    plan: Plan,
}

impl Planner<'_, '_> {
    fn line(&mut self) -> Result<(), Refusal> {
        let block = self.block;
        self.modes();
        let motion = self.motion_of()?;
        self.unused(motion)?;
        self.feed_word(motion)?;
        self.switches();
        self.extra()?;
        if let Some(tool) = block.tool_length {
            let [x, y, z] = block.axes();
            if tool && (x.is_some() || y.is_some() || z.is_none()) {
                return Err(Error::TOOL_AXIS.into());
            }
            let length = if tool { z.unwrap_or(0.0) * self.scale } else { 0.0 };
            self.offsets().tool = length;
        }
        if let Some(once) = block.once {
            self.once(once)?;
        }
        if let Some(motion) = motion {
            self.motion(motion)?;
        }
        self.flow();
        Ok(())
    }

    fn offsets(&mut self) -> &mut Offsets {
        self.plan.offsets.get_or_insert_with(|| Box::new(self.here.offsets.clone()))
    }

    fn work(&self) -> Point {
        let offsets = self.plan.offsets.as_deref().unwrap_or(self.here.offsets);
        offsets.work(self.plan.modal.wcs)
    }

    fn modes(&mut self) {
        let (block, modal) = (self.block, &mut self.plan.modal);
        let keep = |held: &mut bool, new: Option<bool>| *held = new.unwrap_or(*held);
        keep(&mut modal.inches, block.inches);
        keep(&mut modal.relative, block.relative);
        keep(&mut modal.inverse_time, block.inverse_time);
        modal.plane = block.plane.unwrap_or(modal.plane);
        modal.wcs = block.wcs.unwrap_or(modal.wcs);
        modal.motion = block.motion.unwrap_or(modal.motion);
        // M204 S and M42 S are no speeds.
        if block.extra.is_none() {
            modal.speed = block.value('S').unwrap_or(modal.speed);
            modal.tool = block.value('T').map_or(modal.tool, |tool| tool as u32);
        }
    }

    /// The motion that this line makes.
    fn motion_of(&self) -> Result<Option<Motion>, Refusal> {
        let block = self.block;
        let taken = matches!(block.once, Some(Once::SetOffset | Once::Go(_) | Once::Shift))
            || block.tool_length == Some(true);
        if taken {
            return Ok(None);
        }
        if !block.has_axes() {
            return match block.motion {
                Some(Motion::Clockwise | Motion::CounterClockwise | Motion::Probe { .. }) => {
                    Err(Error::NO_AXIS.into())
                }
                _ => Ok(None),
            };
        }
        match self.plan.modal.motion {
            Motion::Off => Err(Error::AXIS_UNUSED.into()),
            motion => Ok(Some(motion)),
        }
    }

    /// Refuses words that nothing in the line uses.
    fn unused(&self, motion: Option<Motion>) -> Result<(), Error> {
        let block = self.block;
        let has = |letter| block.value(letter).is_some();
        let arc = matches!(motion, Some(Motion::Clockwise | Motion::CounterClockwise));
        let offsets = has('I') || has('J') || has('K');
        if offsets && (!arc || has('R')) || has('R') && !arc {
            return Err(Error::UNUSED);
        }
        let parameters =
            matches!(block.once, Some(Once::Dwell | Once::SetOffset)) || block.extra.is_some();
        let l = block.once == Some(Once::SetOffset) || block.extra.is_some();
        if has('P') && !parameters || has('L') && !l {
            return Err(Error::UNUSED);
        }
        if block.machine && !matches!(motion, None | Some(Motion::Rapid | Motion::Line)) {
            return Err(Error::G53);
        }
        Ok(())
    }

    fn feed_word(&mut self, motion: Option<Motion>) -> Result<(), Error> {
        let inverse = self.plan.modal.inverse_time;
        let word = self.block.value('F');
        if self.block.inverse_time.is_some_and(|new| new != self.here.modal.inverse_time) {
            self.plan.modal.feed = 0.0;
        }
        if let Some(value) = word {
            self.plan.modal.feed = if inverse { value } else { value * self.scale };
        }
        let needs = motion.is_some_and(|motion| motion != Motion::Rapid);
        if needs && (self.plan.modal.feed == 0.0 || inverse && word.is_none()) {
            return Err(Error::NO_FEED);
        }
        Ok(())
    }

    /// S as it goes to the machine, with its override.
    fn power(&self) -> Option<i32> {
        let full = self.here.machine.power?;
        let wanted = self.plan.modal.speed * f64::from(self.here.speed_override) / 100.0;
        let on = self.plan.modal.spindle != Spindle::Off;
        on.then(|| wanted.clamp(0.0, f64::from(full)).round() as i32)
    }

    fn switches(&mut self) {
        let (block, machine) = (self.block, self.here.machine);
        let before = self.here.modal;
        let modal = &mut self.plan.modal;
        modal.spindle = block.spindle.unwrap_or(modal.spindle);
        if block.coolant_off {
            (modal.flood, modal.mist) = (false, false);
        }
        modal.flood |= block.flood;
        modal.mist |= block.mist;
        let wet = |modal: &Modal| modal.flood || modal.mist;
        let coolant = wet(modal);
        // The speed of a spindle changes at once, a laser's power with the next line.
        let faster = modal.speed != before.speed && machine.power.is_some() && !machine.laser;
        let (spindle, changed) = (modal.spindle, modal.spindle != before.spindle);
        if machine.spindle.is_some() && (changed || spindle != Spindle::Off && faster) {
            let power = self.power();
            self.plan.orders.push(Order::Spindle(spindle, power));
        }
        if machine.coolant.is_some() && coolant != wet(before) {
            self.plan.orders.push(Order::Coolant(coolant));
        }
    }

    fn extra(&mut self) -> Result<(), Refusal> {
        let Some(extra) = self.block.extra else { return Ok(()) };
        let number = |most: u16| {
            let value = self.block.value('P').ok_or(Error::MISSING)?;
            if value.fract() != 0.0 || !(1.0..=f64::from(most)).contains(&value) {
                return Err(Error::UNSUPPORTED);
            }
            Ok(value as u16)
        };
        match extra {
            Extra::Nothing => {}
            Extra::Rest => self.plan.sync = Some(Sync::Rest),
            Extra::Place => self.plan.sync = Some(Sync::Place),
            Extra::Firmware => self.plan.firmware = true,
            Extra::Input => self.plan.sync = Some(Sync::Input(number(self.here.machine.inputs)?)),
            Extra::Output(on) => {
                let n = number(31)?;
                if self.here.machine.outputs >> (n - 1) & 1 == 0 {
                    let words = format!("output {n} is none that may be set");
                    return Err(Refusal::Told(Error::UNSUPPORTED, words));
                }
                let on = match on {
                    Some(on) => on,
                    None => self.block.value('S').ok_or(Error::MISSING)? != 0.0,
                };
                self.plan.orders.push(Order::Output(n, on));
                self.plan.output = Some((n, on));
            }
        }
        Ok(())
    }

    /// Where the axis words lead to.
    fn words(&self) -> Result<Point, Error> {
        let work = self.work();
        let mut to = self.here.at;
        for (i, word) in self.block.axes().into_iter().enumerate() {
            let Some(value) = word.map(|value| value * self.scale) else { continue };
            to[i] = if self.block.machine {
                value
            } else if self.plan.modal.relative {
                self.here.at[i] + value
            } else {
                value + work[i]
            };
            um(to[i])?;
        }
        Ok(to)
    }

    fn once(&mut self, once: Once) -> Result<(), Refusal> {
        let block = self.block;
        let need_axes = || block.has_axes().then_some(()).ok_or(Error::NO_AXIS);
        match once {
            Once::Dwell => {
                let seconds = block.value('P').ok_or(Error::MISSING)?;
                if seconds > LONGEST_DWELL {
                    return Err(Error::NUMBER.into());
                }
                let ms = (seconds * 1000.0).round() as u32;
                if ms > 0 {
                    self.plan.orders.push(Order::Dwell(ms));
                }
                self.plan.seconds += seconds;
                self.plan.sync = Some(Sync::Rest);
            }
            Once::SetOffset => {
                need_axes()?;
                self.set_offset()?;
                self.plan.sync = Some(Sync::Rest);
            }
            Once::Go(which) => {
                let middle = if block.has_axes() { self.words()? } else { self.here.at };
                let stored = match which {
                    Stored::First => self.here.offsets.g28,
                    Stored::Second => self.here.offsets.g30,
                };
                let named = block.axes();
                let mut to = middle;
                for i in 0..3 {
                    if named[i].is_some() || !block.has_axes() {
                        to[i] = stored[i];
                    }
                }
                self.rapid(middle)?;
                self.rapid(to)?;
            }
            Once::Store(which) => {
                let at = self.here.at;
                match which {
                    Stored::First => self.offsets().g28 = at,
                    Stored::Second => self.offsets().g30 = at,
                }
                self.plan.sync = Some(Sync::Rest);
            }
            Once::Shift => {
                need_axes()?;
                let (at, wcs) = (self.here.at, self.plan.modal.wcs);
                let scale = self.scale;
                let offsets = self.offsets();
                for (i, word) in block.axes().into_iter().enumerate() {
                    let Some(value) = word else { continue };
                    let tool = if i == 2 { offsets.tool } else { 0.0 };
                    offsets.g92[i] = at[i] - offsets.wcs[wcs][i] - tool - value * scale;
                    um(offsets.g92[i])?;
                }
            }
            Once::Unshift => self.offsets().g92 = [0.0; 3],
        }
        Ok(())
    }

    /// G10 L2 and L20.
    fn set_offset(&mut self) -> Result<(), Error> {
        let block = self.block;
        let number = block.value('P').ok_or(Error::MISSING)?;
        let kind = block.value('L').ok_or(Error::MISSING)?;
        if number.fract() != 0.0 {
            return Err(Error::INTEGER);
        }
        if number > 6.0 {
            return Err(Error::NO_WCS);
        }
        if kind != 2.0 && kind != 20.0 {
            return Err(Error::UNSUPPORTED);
        }
        let wcs = if number == 0.0 { self.plan.modal.wcs } else { number as usize - 1 };
        let (at, scale) = (self.here.at, self.scale);
        let offsets = self.offsets();
        for (i, word) in block.axes().into_iter().enumerate() {
            let Some(value) = word.map(|value| value * scale) else { continue };
            let tool = if i == 2 { offsets.tool } else { 0.0 };
            let new = if kind == 2.0 { value } else { at[i] - offsets.g92[i] - tool - value };
            um(new)?;
            offsets.wcs[wcs][i] = new;
        }
        Ok(())
    }

    fn flow(&mut self) {
        match self.block.flow {
            None => {}
            Some(Flow::Halt) => {
                self.plan.orders.push(Order::Halt);
                self.plan.sync = Some(Sync::Rest);
            }
            Some(Flow::End) => {
                let machine = self.here.machine;
                let modal = &mut self.plan.modal;
                if modal.spindle != Spindle::Off && machine.spindle.is_some() {
                    self.plan.orders.push(Order::Spindle(Spindle::Off, None));
                }
                if (modal.flood || modal.mist) && machine.coolant.is_some() {
                    self.plan.orders.push(Order::Coolant(false));
                }
                modal.end_program();
                self.plan.sync = Some(Sync::End);
            }
        }
    }
}

#[cfg(test)]
mod tests;
