//! What stands around a controller's pins: motors, switches and plates as the profile and the world say, and the world's
//! actions on them. The emulated board and the simulated chip have the same.

use std::rc::Rc;

use emulator::Plant;
use emulator::plant::Contact;
use lang::axis::Axis;
use lang::profile::{Direction, InputRole, Profile, Wiring};

use crate::scene::live::Shared;

use super::world::{Action, Button, Registers, Scenario, World, WorldError};

/// Where a reference switch stands when the world does not say: this far away, um.
pub const SWITCH_AWAY_UM: i64 = 20_000;

/// How long what is at the inputs of a machine takes through every filter, us: 50 ms at contacts; of an analog input ten times
/// the time constant.
pub fn filters_us(profile: &Profile) -> u64 {
    let slowest = profile.analogs.iter().map(|analog| analog.slowest_ms()).max();
    (u64::from(slowest.unwrap_or(0)) * 10_000).max(60_000)
}

/// What an action leaves to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rest {
    /// Nothing.
    Nothing,
    /// This input has changed.
    Input(i32, bool),
    /// A host sends a synchronisation character.
    Char(i32),
    /// A host sends the emergency stop: no input has that role.
    EmergencyStop,
    /// A host gives the AT variable at a register a value.
    Register(u16, i32),
}

/// See the module.
pub struct Scene {
    /// The machine.
    pub profile: Profile,
    /// The world in motion.
    pub scenario: Scenario,
    /// Machine position less motor position, steps: homing counts anew.
    pub offset: [i64; 3],
    /// Steps that motors lost to stalls, signed by direction of the loss in machine steps.
    pub lost: [i64; 3],
}

impl Scene {
    /// The machine of `profile` in a world, which knows these AT variables, around the pins of a plant. `puts` tells
    /// whether the caller puts the reference switches whose places nobody gave; else they stand [`SWITCH_AWAY_UM`] off.
    ///
    /// # Errors
    /// The world's script fails.
    pub fn new(
        profile: &Profile,
        world: &World,
        registers: &Registers,
        puts: fn(&Scenario) -> bool,
        plant: &mut Plant,
    ) -> Result<Scene, WorldError> {
        let scenario = world.start(registers)?;
        let scene = Scene { profile: profile.clone(), scenario, offset: [0; 3], lost: [0; 3] };
        let puts = puts(&scene.scenario);
        scene.build(puts, plant);
        Ok(scene)
    }

    /// Motors, switches and polarities.
    fn build(&self, puts: bool, plant: &mut Plant) {
        let Scene { profile, scenario, .. } = self;
        plant.stop_at_output = true;
        if profile.step_invert {
            plant.steps_are_low();
        }
        for (axis, own) in profile.axes() {
            plant.motors[axis.index()].inverted = own.invert;
            let usual = (!puts).then(|| self.away(axis));
            let place = scenario.switch_place(axis).map(i64::from).or(usual);
            self.put_switch(axis, place, plant);
        }
        for input in profile.inputs.iter().filter(|input| input.invert) {
            if let Ok(n) = u8::try_from(input.n) {
                let usual = profile.wiring == Wiring::Direct || n == plant.probe_input();
                plant.set_active_low(n, !usual);
            }
        }
        self.place_probe(plant);
    }

    /// Way to a reference switch whose place nobody gave, steps, signed.
    pub fn away(&self, axis: Axis) -> i64 {
        self.profile.axis(axis).map_or(0, |own| {
            let away = SWITCH_AWAY_UM * i64::from(own.scale.steps) / i64::from(own.scale.um);
            i64::from(own.home.direction.sign()) * away
        })
    }

    /// The axis's reference switch stands there, steps from power-up; with `None` it is out of the way.
    pub fn put_switch(&self, axis: Axis, place: Option<i64>, plant: &mut Plant) {
        let Some(own) = self.profile.axis(axis) else { return };
        let above = own.home.direction == Direction::Positive;
        let i = axis.index();
        plant.switches[i] = place.map(|position| Contact { axis: i, position, above });
    }

    /// The plate counts from the machine's zero, the motor from power-up.
    pub fn place_probe(&self, plant: &mut Plant) {
        for axis in Axis::ALL {
            let i = axis.index();
            plant.probes[i] = self.scenario.probe_plate(axis).map(|(place, side)| Contact {
                axis: i,
                position: i64::from(place) - self.offset[i],
                above: side > 0,
            });
        }
    }

    /// The axis was homed: it rests at this machine position, steps.
    pub fn homed(&mut self, axis: Axis, position: i32, plant: &mut Plant) {
        let i = axis.index();
        self.offset[i] = i64::from(position) - plant.motors[i].position;
        self.lost[i] = 0;
        self.place_probe(plant);
    }

    /// Whether the controller itself does something when the input is on.
    pub fn has_role(&self, n: i32) -> bool {
        let roles = self.profile.inputs.iter().filter(|input| input.n == n);
        let plain = |role: Option<InputRole>| matches!(role, None | Some(InputRole::Probe));
        roles.into_iter().any(|input| !plain(input.role))
            || Axis::ALL.into_iter().any(|axis| self.profile.reference_input(axis) == n)
    }

    /// Whether an output is on, given its level at the pin.
    pub fn is_on(&self, n: i32, level: bool) -> bool {
        level != self.profile.outputs.iter().any(|output| output.n == n && output.invert)
    }

    /// Puts the world's cell around the pins at a time in ticks of the plant, `per_us` of them in a microsecond. Gives the
    /// cell, and where the world or its frame has the reference switches, steps from power-up.
    pub fn build_cell(
        &self,
        now: u64,
        per_us: u64,
        plant: &mut Plant,
    ) -> Option<(Shared, [Option<i32>; 3])> {
        let cell = self.scenario.scene()?;
        let world = Axis::ALL.map(|axis| self.scenario.switch_place(axis));
        let (frame, switches) = cell.frame(&self.profile, world);
        for (axis, place) in Axis::ALL.into_iter().zip(switches) {
            if world[axis.index()].is_none() && place.is_some() {
                self.put_switch(axis, place, plant);
            }
        }
        let shared = Shared::new(cell, frame, &self.profile, per_us);
        plant.surround(now, Some(shared.around()));
        self.scenario.join(Rc::new(shared.clone()));
        Some((shared, switches.map(|place| i32::try_from(place?).ok())))
    }

    /// A motor loses its next steps.
    pub fn stall(&mut self, axis: usize, steps: i32, plant: &mut Plant) {
        let steps = u64::from(steps.unsigned_abs());
        plant.stall(axis, steps);
        if let Some(lost) = self.lost.get_mut(axis) {
            *lost += steps.cast_signed();
        }
    }

    /// Does what the world does.
    pub fn apply(&mut self, action: Action, plant: &mut Plant) -> Rest {
        let emergency = self.profile.input_with(InputRole::EmergencyStop).map(|input| input.n);
        match (action, emergency) {
            (Action::Input { n, on }, _) => set_input(n, on, plant),
            (Action::Button { button: Button::Start, down }, _) => {
                plant.press_start(down);
                Rest::Nothing
            }
            (Action::Button { button: Button::Stop, down }, _) => {
                plant.press_stop(down);
                Rest::Nothing
            }
            (Action::Analog { n, mv }, _) => {
                let place = usize::try_from(n - 1).ok();
                if let Some(input) = place.and_then(|n| plant.analog.get_mut(n)) {
                    *input = mv;
                }
                Rest::Nothing
            }
            (Action::Stall { axis, steps }, _) => {
                self.stall(axis.index(), steps, plant);
                Rest::Nothing
            }
            (Action::EmergencyStop, Some(n)) => set_input(n, true, plant),
            _ if self.scenario.client_is_gone() => Rest::Nothing,
            (Action::EmergencyStop, None) => Rest::EmergencyStop,
            (Action::Char(c), _) => Rest::Char(c),
            (Action::Register { register, value }, _) => Rest::Register(register, value),
        }
    }
}

fn set_input(n: i32, on: bool, plant: &mut Plant) -> Rest {
    match u8::try_from(n) {
        Ok(number) => {
            plant.set_input(number, on);
            Rest::Input(n, on)
        }
        Err(_) => Rest::Nothing,
    }
}
