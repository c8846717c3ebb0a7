//! Inputs with their filters, and the plant behind reference switches and probe.

use lang::axis::Axis;
use lang::fault::Fault;
use lang::profile::{Profile, Wiring};
use lang::record::MachineRecord;

use crate::sim::world::Scenario;

/// Filter time where the profile names no input, ms.
const FILTER_MS: u8 = 5;
/// Where a reference switch is unless the world says: so far from power-up, um.
const SWITCH_UM: i64 = 20_000;
/// Number of the Start button: one that no input of a wiring has.
pub const START: i32 = 18;
/// Number of the Stop button.
pub const STOP: i32 = 19;
/// Highest input number and one more.
const INPUTS: usize = 18;
/// The same with the buttons.
const LINES: usize = 20;

/// One input.
#[derive(Clone, Copy, Debug, Default)]
struct Input {
    /// What the world drives.
    driven: bool,
    /// What the plant does: a switch, the plate.
    sensed: bool,
    /// After the filter.
    state: bool,
    /// When the filter follows, us.
    due: Option<u64>,
    filter_us: u64,
}

impl Input {
    fn raw(&self) -> bool {
        self.driven || self.sensed
    }

    fn change(&mut self, now: u64) {
        if self.raw() == self.state {
            self.due = None;
        } else if self.due.is_none() {
            self.due = Some(now + self.filter_us);
        }
    }
}

/// All inputs, and the buttons Start and Stop: the board has one filter for all of them.
#[derive(Debug)]
pub struct Inputs {
    lines: [Input; LINES],
    count: i32,
}

impl Inputs {
    /// Every input off.
    pub fn new(profile: &Profile) -> Inputs {
        let named = profile.inputs.iter().map(|input| input.filter_ms);
        let filter_us = u64::from(named.max().unwrap_or(FILTER_MS)) * 1_000;
        let lines = [Input { filter_us, ..Input::default() }; LINES];
        Inputs { lines, count: profile.wiring.inputs() }
    }

    /// What was there before power-up needs no filter; a button that is pressed then is pressed
    /// now.
    pub fn settle(&mut self) {
        for line in &mut self.lines[..INPUTS] {
            line.state = line.raw();
            line.due = None;
        }
    }

    /// Numbers of the inputs that are on, behind their filters.
    pub fn on(&self) -> Vec<i32> {
        let lines = self.lines[..INPUTS].iter().zip(0..).filter(|(line, _)| line.state);
        lines.map(|(_, n)| n).collect()
    }

    fn line(&mut self, n: i32) -> Option<&mut Input> {
        usize::try_from(n).ok().and_then(|n| self.lines.get_mut(n))
    }

    /// The world drives an input.
    pub fn drive(&mut self, n: i32, on: bool, now: u64) {
        if let Some(line) = self.line(n) {
            line.driven = on;
            line.change(now);
        }
    }

    /// The plant drives an input.
    pub fn sense(&mut self, n: i32, on: bool, now: u64) {
        if let Some(line) = self.line(n)
            && line.sensed != on
        {
            line.sensed = on;
            line.change(now);
        }
    }

    /// Unfiltered state.
    pub fn raw(&self, n: i32) -> bool {
        usize::try_from(n).ok().and_then(|n| self.lines.get(n)).is_some_and(Input::raw)
    }

    /// When a filter follows next, us.
    pub fn next_us(&self) -> Option<u64> {
        self.lines.iter().filter_map(|line| line.due).min()
    }

    /// An input whose filter follows at `now`, with its new state.
    pub fn take_filtered(&mut self, now: u64) -> Option<(i32, bool)> {
        let (n, line) = self
            .lines
            .iter_mut()
            .enumerate()
            .find(|(_, line)| line.due.is_some_and(|due| due <= now))?;
        line.due = None;
        line.state = line.raw();
        Some((n as i32, line.state))
    }

    /// `IN(n)`.
    ///
    /// # Errors
    /// F20 for a number that the wiring lacks.
    pub fn read(&self, n: i32) -> Result<bool, Fault> {
        if !(1..=self.count).contains(&n) {
            return Err(Fault::ValueRange);
        }
        Ok(self.lines[n as usize].state)
    }

    /// `INPORT()`: input n is bit n - 1.
    pub fn port(&self) -> i32 {
        self.bits(|line| line.state)
    }

    /// All inputs without their filters, as a probe sees them.
    pub fn raw_port(&self) -> i32 {
        self.bits(Input::raw)
    }

    fn bits(&self, of: impl Fn(&Input) -> bool) -> i32 {
        (1..=self.count).fold(0, |bits, n| bits | i32::from(of(&self.lines[n as usize])) << (n - 1))
    }
}

/// What stands behind switches and probe: true places and where they change.
#[derive(Debug)]
pub struct Plant {
    /// Steps from power-up = machine position + origin - lost.
    origin: [i32; 3],
    lost: [i32; 3],
    /// Switches, steps from power-up; `None` while one is out of the way.
    places: [Option<i32>; 3],
    /// What lies between the farthest place reached and a switch that is put up behind it, steps.
    away: [i32; 3],
    /// The least and the greatest place that an axis has reached, steps from power-up.
    reached: [[i32; 2]; 3],
    direction: [i32; 3],
    present: [bool; 3],
}

impl Plant {
    /// Every motor at 0, switches 20 mm away in homing direction, or out of the way until
    /// [`Plant::put_switch`] in an unattended scenario.
    pub fn new(profile: &Profile, record: &MachineRecord, scenario: &Scenario) -> Plant {
        let mut plant = Plant {
            origin: [0; 3],
            lost: [0; 3],
            places: [None; 3],
            away: [0; 3],
            reached: [[0; 2]; 3],
            direction: [-1; 3],
            present: [false; 3],
        };
        for (axis, part) in profile.axes() {
            let index = axis.index();
            let scale = &record.axes[index];
            let steps = SWITCH_UM * i64::from(scale.steps) / i64::from(scale.um.max(1));
            plant.direction[index] = part.home.direction.sign();
            plant.away[index] = plant.direction[index] * steps as i32;
            let usual = (!scenario.is_unattended()).then_some(plant.away[index]);
            plant.places[index] = usual;
            plant.present[index] = true;
        }
        debug_assert!(matches!(profile.wiring, Wiring::Direct | Wiring::Chain));
        plant
    }

    /// A motor loses steps in the direction of their sign.
    pub fn lose(&mut self, axis: Axis, steps: i32) {
        self.lost[axis.index()] = self.lost[axis.index()].saturating_add(steps);
    }

    /// The machine position changes from `before` to `after` without motion; steps lost before
    /// are found again.
    pub fn rename(&mut self, axis: Axis, before: i32, after: i32) {
        let index = axis.index();
        let shift = before.saturating_sub(after).saturating_sub(self.lost[index]);
        self.origin[index] = self.origin[index].saturating_add(shift);
        self.lost[index] = 0;
    }

    /// True machine positions of commanded ones.
    pub fn true_positions(&self, at: [i32; 3]) -> [i32; 3] {
        [0, 1, 2].map(|index: usize| at[index].saturating_sub(self.lost[index]))
    }

    /// The axes are commanded to `at`.
    pub fn reach(&mut self, at: [i32; 3]) {
        let truly = self.true_positions(at);
        for (index, [least, greatest]) in self.reached.iter_mut().enumerate() {
            let place = truly[index].saturating_add(self.origin[index]);
            *least = place.min(*least);
            *greatest = place.max(*greatest);
        }
    }

    /// The least and the greatest place that the axis has reached, steps from power-up.
    pub fn reached(&self, axis: Axis) -> [i32; 2] {
        self.reached[axis.index()]
    }

    /// The axis is about to be homed: a switch that was out of the way stands 20 mm beyond all that
    /// the axis has reached.
    pub fn put_switch(&mut self, axis: Axis) {
        let index = axis.index();
        let [least, greatest] = self.reached[index];
        let extreme = if self.direction[index] < 0 { least } else { greatest };
        self.places[index].get_or_insert(extreme.saturating_add(self.away[index]));
    }

    /// Where the axis's reference switch stands, steps from power-up.
    pub fn switch_place(&self, axis: Axis, scenario: &Scenario) -> Option<i32> {
        scenario.switch_place(axis).or(self.places[axis.index()])
    }

    /// Whether the reference switch is closed with the axis commanded to `at`.
    pub fn switch_closed(&self, axis: Axis, at: i32, scenario: &Scenario) -> bool {
        let index = axis.index();
        let Some(place) = self.switch_place(axis, scenario).map(i64::from) else { return false };
        let at = i64::from(at) + i64::from(self.origin[index]) - i64::from(self.lost[index]);
        self.present[index] && if self.direction[index] < 0 { at <= place } else { at >= place }
    }

    /// Commanded places at which the axis's switch or plate changes.
    pub fn thresholds(&self, axis: Axis, scenario: &Scenario) -> impl Iterator<Item = i32> {
        let index = axis.index();
        let lost = self.lost[index];
        let switch = self.switch_place(axis, scenario);
        let switch = switch.map(|place| place.saturating_sub(self.origin[index]));
        let plate = scenario.probe_plate(axis).map(|(place, _)| place);
        [switch, plate]
            .into_iter()
            .flatten()
            .map(move |place| place.saturating_add(lost))
            .flat_map(|place| [place.saturating_sub(1), place, place.saturating_add(1)])
    }
}
