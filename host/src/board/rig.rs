//! An emulated board with its machine, and a scenario that acts on both.

mod around;
mod state;

use emulator::{Board, Config, Stop, Wiring as PlantWiring};
use lang::axis::Axis;
use lang::profile::{Profile, Wiring};
use lang::wire::{Seen, TraceKind};

use super::Build;
use super::hardware::Hardware;
use super::observe::{Observed, Sight};
use crate::scene::live::{HostDeed, Shared};
use crate::sim::scene::{Rest, Scene};
use crate::sim::world::{Action, Registers, Scenario, World, WorldError};

/// What the scenario does that only a host on the link can do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HostAction {
    /// Send a synchronisation character.
    Char(i32),
    /// Send the emergency stop: no input has that role.
    EmergencyStop,
    /// Give the AT variable at a register a value.
    Register(u16, i32),
    /// Pause the run, or resume it.
    Pause(bool),
}

/// A board, by default an emulated one, its machine and its world.
pub struct Rig<B: Hardware = Board> {
    board: B,
    /// The machine and the world.
    scene: Scene,
    /// Tick of the scenario's time 0; `None` while it waits for the run.
    zero: Option<u64>,
    host_actions: Vec<HostAction>,
    failed: Option<WorldError>,
    /// What the world does at time 0 beside inputs, until the run begins.
    first: Vec<Action>,
    /// Who sees what the firmware does, if anybody.
    observer: Option<B::Observer>,
    /// What was seen and not taken yet.
    observed: Vec<Observed>,
    /// The board as it was before it was asked something on the side.
    aside: Option<Box<B>>,
    /// Output edges since the last look: tick, number, state.
    outputs: Vec<(u64, i32, bool)>,
    /// Input edges made by the scenario: tick, number, state.
    inputs: Vec<(u64, i32, bool)>,
    /// The cell around the machine, and where its frame has the reference switches.
    cell: Option<Shared>,
    placed: [Option<i32>; 3],
}

impl Rig {
    /// A board with the firmware `image` of a build in its flash and `mill` as the profile that it holds, the machine of
    /// `profile` and a world, which knows these AT variables, powered up.
    ///
    /// # Errors
    /// The world's script fails.
    pub fn new(
        build: &Build,
        image: &emulator::Image,
        profile: &Profile,
        world: &World,
        registers: &Registers,
    ) -> Result<Rig, WorldError> {
        let wiring = match profile.wiring {
            Wiring::Direct => PlantWiring::Direct,
            Wiring::Chain => PlantWiring::Chain,
        };
        let config = Config { part: build.chip.clone(), wiring, ..Config::default() };
        let mut board = Board::with_config(&config, image);
        super::tell_default(build, &mut board);
        Rig::around(board, profile, world, registers)
    }

    /// Puts back what [`Board::flash_contents`] gave, and starts the board anew from it. Firmware
    /// that is older than this tool's is taken over too: it is what the board holds.
    ///
    /// # Errors
    /// The length is not that of the part's flash.
    pub fn restore_flash(&mut self, content: &[u8]) -> Result<(), String> {
        self.board
            .set_flash_contents(content)
            .map_err(|error| format!("it is no flash of this board: {error}"))?;
        self.board.power_cut();
        self.board.power_up();
        Ok(())
    }
}

impl<B: Hardware> Rig<B> {
    /// A rig around a board, with the machine of `profile` and a world, which knows these AT variables.
    ///
    /// # Errors
    /// The world's script fails.
    pub fn around(
        mut board: B,
        profile: &Profile,
        world: &World,
        registers: &Registers,
    ) -> Result<Rig<B>, WorldError> {
        let scene = {
            let mut plant = board.plant_mut();
            plant.limits = super::judge::driver_limits(profile, plant.ticks_per_second());
            Scene::new(profile, world, registers, Scenario::is_empty_and_unattended, &mut plant)?
        };
        let mut rig = Rig {
            board,
            scene,
            zero: None,
            host_actions: Vec::new(),
            failed: None,
            first: Vec::new(),
            observer: None,
            observed: Vec::new(),
            aside: None,
            outputs: Vec::new(),
            inputs: Vec::new(),
            cell: None,
            placed: [None; 3],
        };
        rig.build_cell();
        Ok(rig)
    }

    /// The program waits for Start: see [`Scenario::waits_for_start`].
    pub fn waits_for_start(&mut self, since_us: u64) -> bool {
        self.scene.scenario.waits_for_start(since_us)
    }

    /// Whether nobody is there: see [`World::unattended`].
    pub fn is_unattended(&self) -> bool {
        self.scene.scenario.is_unattended()
    }

    /// Whether nobody is there, by the word of a file whose world may still act.
    pub fn acts_unattended(&self) -> bool {
        let scenario = &self.scene.scenario;
        scenario.is_unattended() && !scenario.is_empty_and_unattended()
    }

    /// Where the scenario or the cell put the reference switches, steps from power-up.
    pub fn switches(&self) -> [Option<i32>; 3] {
        let world = |axis| self.scene.scenario.switch_place(axis);
        Axis::ALL.map(|axis| world(axis).or(self.placed[axis.index()]))
    }

    /// The board.
    pub fn board(&mut self) -> &mut B {
        &mut self.board
    }

    /// Ticks of the board's chip in so many microseconds.
    pub fn ticks(&self, us: u64) -> u64 {
        us.saturating_mul(self.board.ticks_per_second() / 1_000_000)
    }

    /// Whole microseconds in so many ticks.
    pub fn whole_us(&self, ticks: u64) -> u64 {
        ticks / self.ticks(1)
    }

    /// Present time in ticks since power-up.
    pub fn now(&self) -> u64 {
        self.board.cycles()
    }

    /// Time of the scenario, us; 0 before it began.
    pub fn us(&self) -> u64 {
        self.us_at(self.now())
    }

    /// The same of an instant, in ticks since power-up.
    pub fn us_at(&self, tick: u64) -> u64 {
        self.zero.map_or(0, |zero| self.whole_us(tick.saturating_sub(zero)))
    }

    /// Whether the scenario's time has begun.
    pub fn has_begun(&self) -> bool {
        self.zero.is_some()
    }

    /// The scenario's time begins now.
    pub fn begin(&mut self) {
        self.begin_at(self.now());
    }

    fn begin_at(&mut self, tick: u64) {
        self.zero = Some(tick);
        self.begin_cell(tick);
        for action in std::mem::take(&mut self.first) {
            self.apply(action);
        }
    }

    /// Watches what the firmware does from now on; the scenario's time begins with the next run.
    /// `false` when this image cannot be watched.
    pub fn observe(&mut self) -> bool {
        self.observer = self.board.observer();
        self.observer.is_some()
    }

    /// Does what the world does at time 0 to inputs that only scripts read, so that they have come
    /// through their filters when the run begins. Anything else waits for that.
    ///
    /// # Errors
    /// A callback of the world fails.
    pub fn set_the_scene(&mut self) -> Result<(), WorldError> {
        let actions = self.scene.scenario.advance(0).inspect_err(|error| {
            self.failed = Some(error.clone());
        })?;
        for action in actions {
            match action {
                Action::Input { n, .. } if !self.scene.has_role(n) => self.apply(action),
                Action::Analog { .. } => self.apply(action),
                _ => self.first.push(action),
            }
        }
        self.scene.place_probe(&mut self.board.plant_mut());
        Ok(())
    }

    /// From now on these are the AT variables.
    pub fn set_registers(&mut self, registers: &Registers) {
        self.scene.scenario.set_registers(registers);
    }

    /// What the operator has given AT variables before the time of the scenario begins, of a scene that
    /// is set.
    pub fn take_registers(&mut self) -> Vec<(u16, i32)> {
        let is_register = |action: &Action| matches!(action, Action::Register { .. });
        let first = std::mem::take(&mut self.first);
        let (registers, others): (Vec<Action>, Vec<Action>) =
            first.into_iter().partition(is_register);
        self.first = others;
        let pair = |action| match action {
            Action::Register { register, value } => Some((register, value)),
            _ => None,
        };
        registers.into_iter().filter_map(pair).collect()
    }

    /// When the scenario or the cell acts next, in ticks.
    fn next_action(&self) -> Option<u64> {
        let zero = self.zero?;
        let world = self.scene.scenario.next_us().map(|us| zero.saturating_add(self.ticks(us)));
        [world, self.board.plant().due()].into_iter().flatten().min()
    }

    /// Whether nothing is planned any more.
    pub fn world_is_over(&self) -> bool {
        self.scene.scenario.next_us().is_none() && self.board.plant().due().is_none()
    }

    /// Runs to a tick, letting the world act at its times.
    ///
    /// # Errors
    /// A callback of the world fails.
    pub fn run_until(&mut self, limit: u64) -> Result<(), WorldError> {
        while self.advance(limit)? {}
        Ok(())
    }

    /// The same, but comes back at the first thing that is observed or that the host has to do.
    ///
    /// # Errors
    /// A callback of the world fails.
    pub fn run_to_event(&mut self, limit: u64) -> Result<(), WorldError> {
        let quiet = |rig: &Rig<B>| rig.observed.is_empty() && rig.host_actions.is_empty();
        while quiet(self) && self.advance(limit)? {}
        Ok(())
    }

    /// Runs to the next thing that happens; `false` when that is the limit.
    fn advance(&mut self, limit: u64) -> Result<bool, WorldError> {
        let limit = limit.max(self.now());
        if self.aside.is_some() {
            return Ok(self.board.run_until(limit) != Stop::Time && self.board.powered());
        }
        self.act()?;
        let until = self.next_action().map_or(limit, |next| next.min(limit));
        let stop = self.board.run_until(until.max(self.now()));
        self.look_at_cell();
        self.look_at_outputs();
        for observed in self.board.look(self.observer.as_mut(), stop) {
            self.see(observed);
        }
        match stop {
            Stop::NoPower => Ok(false),
            Stop::Time => Ok(self.now() < limit),
            _ => Ok(true),
        }
    }

    /// The observer has seen something.
    fn see(&mut self, observed: Observed) {
        match observed.sight {
            Sight::Beside(Seen::Begun, _) if self.zero.is_none() => self.begin_at(observed.tick),
            Sight::Event { kind: TraceKind::Home, argument, value, .. } => {
                let axis = usize::from(argument & !lang::wire::TRACE_OK);
                if let Some(axis) = Axis::from_index(axis) {
                    self.homed(axis, value);
                }
            }
            _ => {}
        }
        self.observed.push(observed);
    }

    /// What was observed since the last call.
    pub fn take_observed(&mut self) -> Vec<Observed> {
        std::mem::take(&mut self.observed)
    }

    /// Whatever the board does from now on does not count: [`Rig::come_back`] undoes it.
    pub fn set_aside(&mut self) {
        self.aside = self.board.aside();
        if self.aside.is_some() {
            let now = self.now();
            self.board.plant_mut().surround(now, None);
        }
    }

    /// The board is as it was at [`Rig::set_aside`].
    pub fn come_back(&mut self) {
        if let Some(board) = self.aside.take() {
            self.board = *board;
        }
    }

    /// Why the world failed, if it has.
    pub fn failure(&self) -> Option<&WorldError> {
        self.failed.as_ref()
    }

    fn act(&mut self) -> Result<(), WorldError> {
        if let Some(error) = self.failed.clone() {
            return Err(error);
        }
        if self.zero.is_none() {
            return Ok(());
        }
        let us = self.us();
        if self.scene.scenario.next_us().is_none_or(|next| next > us) {
            return Ok(());
        }
        self.stand_by_world(us);
        let actions = self.scene.scenario.advance(us).inspect_err(|error| {
            self.failed = Some(error.clone());
        })?;
        for action in actions {
            self.apply(action);
        }
        self.look_at_touch();
        self.scene.place_probe(&mut self.board.plant_mut());
        Ok(())
    }

    fn apply(&mut self, action: Action) {
        let now = self.now();
        match self.scene.apply(action, &mut self.board.plant_mut()) {
            Rest::Nothing => {}
            Rest::Input(n, on) => self.inputs.push((now, n, on)),
            Rest::EmergencyStop => self.host_actions.push(HostAction::EmergencyStop),
            // There is one register for them: of several at an instant the last one counts.
            Rest::Char(c) => {
                self.host_actions.retain(|action| !matches!(action, HostAction::Char(_)));
                self.host_actions.push(HostAction::Char(c));
            }
            Rest::Register(register, value) => {
                self.host_actions.push(HostAction::Register(register, value));
            }
        }
    }

    fn look_at_outputs(&mut self) {
        let per_us = self.ticks(1);
        let zero = self.zero;
        for change in self.board.plant_mut().take_output_changes() {
            let n = i32::from(change.output);
            let on = self.scene.is_on(n, change.on);
            if zero.is_none() {
                // Only the level counts: before a board has its profile, pins of wiring `direct` are a clock's.
                self.outputs.retain(|(_, other, _)| *other != n);
            }
            self.outputs.push((change.cycle, n, on));
            if let Some(zero) = zero {
                let us = change.cycle.saturating_sub(zero) / per_us;
                self.scene.scenario.output_changed(n, on, us);
            }
        }
    }
}
