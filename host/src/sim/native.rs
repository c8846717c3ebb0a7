//! The machine of a simulation: the firmware's own, on the desktop's chip, with the world around its pins.
//!
//! An engine calls [`Native::look`] between statements and [`Native::begin`] for each effect; both come back with a
//! [`Step`]. All rules are the firmware's ([`firmware::machine`]): here time goes on, the world acts at its times, and
//! what the machine tells becomes the trace and the record. The engine owns the control flow
//! ([`desk::driven`]).

mod around;
mod ask;
mod books;
mod ending;
mod pieces;

use desk::board::NativeBoard;
use desk::driven::{self, Entered, Request};
use desk::{Desk, Noticed, PER_MS, PER_US, Sight};
use lang::axis::Axis;
use lang::fault::Fault;
use lang::profile::Profile;
use lang::record::MachineRecord;
use lang::vm::flag;
use lang::wire::{Control, Seen};

use self::around::Around;
use self::pieces::Pieces;
use super::log::Log;
use super::record::StopReason;
use super::scene::{Rest, Scene, filters_us};
use super::step::Step;
use super::view::{AxisView, View};
use super::world::{Action, Registers, Scenario, World, WorldError};
use super::{End, Options, SimError, Sink, told};

/// From power-up to the first statement, us: the board has booted, filters have settled, and nobody waits for a host
/// that takes what is printed.
const BOOT_US: u64 = 700_000;
/// Passes of the machine between two questions whether the user wants an end.
const QUESTION: u32 = 64;
/// Bytes kept of a printed line.
const LONGEST: usize = 4_096;

/// See the module.
pub struct Native {
    board: NativeBoard,
    scene: Scene,
    log: Log,
    profile: Profile,
    options: Options,
    /// Tick of the scenario's time 0; `None` before the run.
    zero: Option<u64>,
    /// What the world does at time 0 beside inputs, until the run begins.
    first: Vec<Action>,
    /// Texts of the program, by index.
    texts: Vec<String>,
    /// What has come of the line that is being printed.
    printed: Vec<u8>,
    /// Line of the statement that runs.
    line: u32,
    statements: u64,
    /// What the machine told of the run's end.
    ended: Option<End>,
    /// Why the run is to end although its program goes on.
    stop: Option<StopReason>,
    /// The end was asked for, in this line.
    stopping: Option<u32>,
    /// When something happened last, us, as far as the end of an idle run counts.
    alive_us: u64,
    /// When the machine told the end, us.
    ended_us: Option<u64>,
    /// When the last thing happened of a run that ended as nothing could happen any more, us.
    idle_us: u64,
    /// A fault was handed to the engine whose handling the machine has begun.
    raised: bool,
    /// The effect that goes on is part of a larger statement.
    held: bool,
    /// The world has failed.
    failed: Option<WorldError>,
    /// Lines whose wait for Start an unattended world ended, and whether that of the wait under way is noted.
    released: Vec<u32>,
    pressed: bool,
    /// The least and the greatest place that each motor has reached, steps from power-up.
    reached: [[i64; 2]; 3],
    pulses: [u64; 3],
    /// Accepted inputs, number n in bit n - 1.
    inputs: u32,
    pieces: Pieces,
    passes: u32,
    /// The cell around the machine.
    around: Option<Around>,
}

impl Native {
    /// A machine at the beginning of a run; `texts` are those of PRINT, by index, `registers` the AT variables.
    ///
    /// # Errors
    /// The world's script fails at its start.
    pub fn new(
        profile: &Profile,
        world: &World,
        options: &Options,
        texts: Vec<String>,
        registers: &Registers,
        sink: Sink,
    ) -> Result<Native, SimError> {
        let mut board = NativeBoard::with(profile);
        let scene =
            Scene::new(profile, world, registers, Scenario::is_unattended, &mut board.plant_mut())?;
        let record = MachineRecord::of(profile);
        let mut own = Native {
            board,
            scene,
            log: Log::new(options, record.axes, sink),
            profile: profile.clone(),
            options: *options,
            zero: None,
            first: Vec::new(),
            texts,
            printed: Vec::new(),
            line: 1,
            statements: 0,
            ended: None,
            stop: None,
            stopping: None,
            alive_us: 0,
            ended_us: None,
            idle_us: 0,
            raised: false,
            held: false,
            failed: None,
            released: Vec::new(),
            pressed: false,
            reached: [[0; 2]; 3],
            pulses: [0; 3],
            inputs: 0,
            pieces: Pieces::default(),
            passes: 0,
            around: None,
        };
        own.build_cell();
        own.boot()?;
        Ok(own)
    }

    /// From power-up to the first statement.
    fn boot(&mut self) -> Result<(), SimError> {
        let filters = filters_us(&self.profile);
        self.wait(BOOT_US - filters);
        for action in self.scene.scenario.advance(0)? {
            match action {
                Action::Input { n, .. } if !self.scene.has_role(n) => {
                    self.board.disturb();
                    self.scene.apply(action, &mut self.board.plant_mut());
                }
                Action::Analog { .. } => {
                    self.board.disturb();
                    self.scene.apply(action, &mut self.board.plant_mut());
                }
                _ => self.first.push(action),
            }
        }
        self.scene.place_probe(&mut self.board.plant_mut());
        self.wait(filters);
        self.board.desk().drive(&self.profile);
        self.board.controller_mut().begin_at(driven::IMAGE);
        self.board.controller_mut().vm.flags |= flag::WITHIN;
        self.board.take_seen();
        self.zero = Some(self.board.desk().ticks());
        self.pulses = self.board.plant().motors.each_ref().map(|motor| motor.pulses);
        self.take_outputs();
        self.look_at_inputs();
        self.begin_cell();
        for action in std::mem::take(&mut self.first) {
            self.apply(action);
        }
        Ok(())
    }

    /// Lets a board without a program run for a time, us.
    fn wait(&mut self, us: u64) {
        let end = self.board.desk().ticks() + us * PER_US;
        while self.board.desk().ticks() < end {
            self.board.drive(end);
            self.board.plant_mut().take_output_changes();
        }
    }

    /// Simulated time, us.
    pub fn now_us(&self) -> u64 {
        self.us_at(self.board.desk().ticks())
    }

    fn us_at(&self, tick: u64) -> u64 {
        self.zero.map_or(0, |zero| tick.saturating_sub(zero) / PER_US)
    }

    /// Line of the statement that runs.
    pub fn line(&self) -> u32 {
        self.line
    }

    /// Line of the statement that runs: what follows is its doing.
    pub fn set_line(&mut self, line: u32) {
        self.line = line;
        self.board.desk().set_line(line);
        // The statements before it have taken their times, though the machine has not waited for them yet.
        let owed_us = self.board.desk().owed() / PER_US;
        self.log.begin(self.now_us() + owed_us, line);
    }

    /// `count` statements without effects are about to run.
    pub fn pass(&mut self, count: u32) {
        self.statements += u64::from(count);
        self.board.desk().owe(u64::from(count) * self.options.statement_us * PER_US);
        if self.board.desk().owed() >= PER_MS {
            self.settle();
        }
    }

    /// Lets the time pass that the engine's statements have taken.
    fn settle(&mut self) {
        while self.board.desk().owed() != 0 && !self.is_halted() {
            self.board.desk().wake();
            self.turn();
        }
    }

    /// Whether the program has a handler for errors from now on.
    pub fn set_handled(&mut self, on: bool) {
        let handler = if on { Desk::error_handler() } else { 0 };
        self.board.controller_mut().vm.handler = handler;
    }

    /// Whether there is something for [`Native::look`].
    pub fn needs_attention(&self) -> bool {
        let controller = self.board.controller();
        let pending = |kind: u8| kind & firmware::machine::controller::PENDING != 0;
        self.is_halted()
            || !controller.session.executes()
            || controller.program.late.is_some()
            || controller.program.events.iter().any(|event| pending(event.kind))
            || Desk::stands_at_handler(controller.vm.pc)
    }

    /// Looks at everything that may come between two statements.
    pub fn look(&mut self) -> Step {
        self.settle();
        self.may_come_between(true);
        self.board.desk().wake();
        self.until_done()
    }

    /// Whether a handler may come now.
    fn may_come_between(&mut self, may: bool) {
        let flags = &mut self.board.controller_mut().vm.flags;
        *flags = if may { *flags & !flag::WITHIN } else { *flags | flag::WITHIN };
    }

    /// Goes on until the machine has done what it was asked for, or something comes between.
    fn until_done(&mut self) -> Step {
        let step = loop {
            self.turn();
            if let Some(step) = self.news() {
                break step;
            }
        };
        self.may_come_between(false);
        step
    }

    /// What the engine is to know, if anything.
    fn news(&mut self) -> Option<Step> {
        if let Some(end) = self.ended {
            let own = end.fault.filter(|fault| fault.can_be_handled() || *fault == Fault::Stack);
            return Some(match own {
                Some(fault) if self.stopping.is_none() && !comes_by_itself(fault) => {
                    self.raised = true;
                    Step::Fault(fault)
                }
                _ => Step::Stop,
            });
        }
        if self.is_halted() {
            return Some(Step::Stop);
        }
        let desk = self.board.desk();
        match desk.take_entered() {
            Some(Entered::Event(slot)) => return Some(Step::Event(slot)),
            Some(Entered::Error) => {
                self.raised = true;
                let vm = &self.board.controller().vm;
                let fault = Fault::from_number(vm.fault).unwrap_or(Fault::ImageRefused);
                let between = vm.newest().1 == lang::vm::entry::ERROR_BETWEEN;
                return Some(if between { Step::Late(fault) } else { Step::Fault(fault) });
            }
            None => {}
        }
        let at_handler = Desk::stands_at_handler(self.board.controller().vm.pc);
        let late = self.board.controller().program.late.is_some();
        (desk.is_idle() && !at_handler && !late).then_some(Step::Done(0))
    }

    /// One pass of the machine, with what the world does before it and what it tells after it.
    fn turn(&mut self) {
        self.turn_by(NativeBoard::drive);
    }

    /// The same while the engine waits for the machine and asks for nothing.
    fn turn_idle(&mut self) {
        self.turn_by(NativeBoard::drive_on);
    }

    fn turn_by(&mut self, drive: fn(&mut NativeBoard, u64) -> bool) {
        let mut next = self.scene.scenario.next_us();
        if next.is_some_and(|next| next <= self.now_us()) {
            self.act();
            next = self.scene.scenario.next_us();
        }
        let zero = self.zero.unwrap_or_default();
        let at = |us: u64| zero.saturating_add(us.saturating_mul(PER_US));
        let next = next.map_or(u64::MAX, at);
        let limit = if self.stopping.is_some() { u64::MAX } else { at(self.options.limit_us) };
        let mut due = self.cell_is_due().unwrap_or(u64::MAX);
        if self.around.is_some() {
            // Somebody of the cell may press Start then.
            due = due.min(at(self.alive_us + self.patience_us()));
        }
        let news = drive(&mut self.board, next.min(limit).min(due));
        self.look_at_cell();
        if news {
            self.collect();
        }
        self.look_at_inputs();
        self.watch();
    }

    /// The world does what is due.
    fn act(&mut self) {
        let us = self.now_us();
        if self.failed.is_some() {
            return;
        }
        self.stand_by_world(us);
        match self.scene.scenario.advance(us) {
            Ok(actions) => actions.into_iter().for_each(|action| self.apply(action)),
            Err(error) => {
                self.failed = Some(error);
                self.halt(StopReason::Idle);
            }
        }
        self.look_at_touch();
        self.scene.place_probe(&mut self.board.plant_mut());
    }

    fn apply(&mut self, action: Action) {
        let rest = self.scene.apply(action, &mut self.board.plant_mut());
        let controller = self.board.controller_mut();
        match rest {
            // An engine shares AT variables with the world.
            Rest::Nothing | Rest::Input(..) | Rest::Register(..) => {}
            Rest::Char(c) => controller.talk.char_in = u8::try_from(c).unwrap_or_default(),
            Rest::EmergencyStop => controller.control(Control::EmergencyStop),
        }
        self.board.disturb();
        self.alive_us = self.now_us();
    }

    /// What can be seen of it now.
    pub fn view(&self) -> View {
        let controller = self.board.controller();
        let motor = &controller.motor;
        let axis = |axis: Axis| {
            let (n, i) = (axis.index() as u8, axis.index());
            let steps = motor.position(n);
            let um = motor.convert(n, steps, false).unwrap_or_default();
            AxisView {
                axis,
                um: um.wrapping_sub(motor.offset[i]),
                steps,
                moving: motor.moves(n),
                homed: motor.homed >> i & 1 != 0,
            }
        };
        let (wiring, aouts) = (self.profile.wiring, self.profile.aouts.iter());
        let input = |n: i32| (n, controller.input(n as u8));
        let output = |n: i32| (n, controller.io.outputs >> (n - 1) & 1 != 0);
        View {
            timer: Some(controller.program.timer),
            inputs: (1..=wiring.inputs().min(16)).map(input).collect(),
            outputs: (1..=wiring.outputs().min(16)).map(output).collect(),
            aouts: aouts.map(|own| (own.n, controller.io.aout.value.into())).collect(),
            axes: self.profile.axes().map(|(letter, _)| axis(letter)).collect(),
        }
    }
}

/// Whether a fault is none of a statement's: the run ends by it at once.
fn comes_by_itself(fault: Fault) -> bool {
    matches!(fault, Fault::EmergencyStop | Fault::LimitSwitch | Fault::LinkLost | Fault::Watchdog)
}
