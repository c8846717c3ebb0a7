//! A run on the emulated board: starts it, follows it, and sums it up.

mod around;

use std::cell::RefCell;
use std::io::Write;
use std::rc::Rc;
use std::time::Duration;

use emulator::VcdWriter;
use firmware::motion::physics::Count;
use lang::axis::Axis;
use lang::fault::{Fault, LATE_LINE};
use lang::wire::{self, Control, RunState};

use super::engine::{BoardError, BoardRun, Job, Other, Sinks, halves};
use super::hardware::Hardware;
use super::health::Health;
use super::judge::Judge;
use super::link::InProcess;
use super::path::PathRecorder;
use super::rig::{HostAction, Rig};
use super::stuck;
use super::teller::Teller;
use super::uses::Uses;
use super::within::Within;
use crate::client::Client;
use crate::client::status::Status as BoardStatus;
use crate::link::Link;
use crate::scene::heard::Heard;
use crate::sim::record::{Away, Edge, Record, StopReason, Summary};
use crate::sim::trace::{Event, Status, What};
use crate::sim::unattended::Unattended;
use crate::sim::world::Registers;
use crate::sim::{End, Outcome};

/// Longest simulated time between two looks at the pins, us.
const LOOK_US: u64 = 1_000;
/// How long Start is held, us.
const PRESS_US: u64 = 100_000;
/// Longest time from the press to the first statement, filter and image check, us.
const START_PATIENCE_US: u64 = 2_000_000;
/// Longest time that a stop may take, a ramp from the top rate of a slow machine, us.
const STOP_PATIENCE_US: u64 = 60_000_000;
/// The machine comes to rest behind the end of a run.
const REST: Duration = Duration::from_millis(20);

/// See the module.
pub struct Run<'a, 'b, B: Hardware> {
    job: &'a Job<'b>,
    rig: Rc<RefCell<Rig<B>>>,
    client: Client<InProcess<B>>,
    trace: &'a mut dyn FnMut(&Event),
    progress: &'a mut dyn FnMut(u64),
    vcd: Option<VcdWriter<&'a mut dyn Write>>,
    path: PathRecorder,
    judge: Judge,
    within: Within,
    watch: stuck::Watch,
    /// The same for who waits for Start in a world that goes on.
    waits: stuck::Watch,
    /// When Start was pressed last for a program that waits for it, us.
    released_us: u64,
    outputs: Vec<Edge>,
    inputs: Vec<Edge>,
    uses: Uses,
    /// Tick at which the finger leaves Start.
    release_start_at: Option<u64>,
    /// Why the board was told to stop, and when, us.
    stopping: Option<(StopReason, u64)>,
    /// What nobody told it.
    unattended: Unattended,
    /// Puts the trace together.
    teller: Teller<'a>,
    /// Times in which another program ran than the first.
    aways: Vec<Away>,
    /// What a cell has heard.
    heard: Heard,
}

impl<'a, 'b, B: Hardware> Run<'a, 'b, B> {
    /// A run of the job on a board that has its program.
    ///
    /// # Errors
    /// The VCD cannot be written.
    pub fn new(
        job: &'a Job<'b>,
        sinks: Sinks<'a>,
        rig: Rc<RefCell<Rig<B>>>,
        client: Client<InProcess<B>>,
    ) -> Result<Run<'a, 'b, B>, BoardError> {
        let draws = sinks.vcd.is_some();
        let vcd = match sinks.vcd {
            None => None,
            Some(out) => {
                let mut rig = rig.borrow_mut();
                let signals = rig.board().plant().signals();
                let (now, ticks) = (rig.now(), rig.board().ticks_per_second());
                Some(VcdWriter::new(out, &signals, now, ticks).map_err(BoardError::Vcd)?)
            }
        };
        let records = job.options.judged || draws;
        rig.borrow_mut().board().record(records);
        let switches = rig.borrow().switches();
        let unattended = Unattended { switches, ..Unattended::default() };
        let judge = Judge::new(&job.program.profile, &rig.borrow().plant());
        let Sinks { trace, progress, .. } = sinks;
        Ok(Run {
            job,
            rig,
            client,
            trace,
            progress,
            vcd,
            path: PathRecorder::default(),
            judge,
            within: Within::default(),
            watch: stuck::Watch::default(),
            waits: stuck::Watch::default(),
            released_us: 0,
            outputs: Vec::new(),
            inputs: Vec::new(),
            uses: Uses::default(),
            release_start_at: None,
            stopping: None,
            unattended,
            teller: Teller::new(&job.program.profile, job.library()),
            aways: Vec::new(),
            heard: Heard::default(),
        })
    }

    /// Presses Start until the program runs; the world's time begins there.
    ///
    /// # Errors
    /// The board does not start it, or the user interrupts.
    pub fn start(&mut self) -> Result<(), BoardError> {
        let ticks = |us| self.rig.borrow().ticks(us);
        let (press, patience, look) = (ticks(PRESS_US), ticks(START_PATIENCE_US), ticks(LOOK_US));
        let pressed = self.rig.borrow().now();
        self.release_start_at = Some(pressed + press);
        self.rig.borrow_mut().board().plant_mut().press_start(true);
        while !self.rig.borrow().has_begun() {
            if (self.job.options.interrupted)() {
                return Err(BoardError::Board("interrupted before the program started".to_owned()));
            }
            let now = self.rig.borrow().now();
            if now > pressed + patience {
                let status = self.client.status()?;
                let fault = status.fault.unwrap_or_default();
                return Err(BoardError::Board(format!(
                    "the program did not start; the board is {} {fault}",
                    status.state
                )));
            }
            self.rig.borrow_mut().run_to_event(now + look)?;
            // What was seen before the run, or waits for the host, must not hold the time: the patience counts on it.
            let stands = self.rig.borrow().now() == now && !self.rig.borrow().has_begun();
            if stands {
                self.rig.borrow_mut().run_until(now + look)?;
            }
            self.release_start();
        }
        self.path.start(&self.rig.borrow());
        self.within.begin(told(&self.rig.borrow()));
        Ok(())
    }

    /// Start is let go at its time, by hand: the scenario has buttons of its own.
    fn release_start(&mut self) {
        let now = self.rig.borrow().now();
        if self.release_start_at.is_some_and(|tick| tick <= now) {
            self.release_start_at = None;
            self.rig.borrow_mut().board().plant_mut().press_start(false);
        }
    }

    /// Follows the run to its end.
    ///
    /// # Errors
    /// The world fails, the board does not end the run, or the VCD cannot be written.
    pub fn follow(&mut self) -> Result<What, BoardError> {
        loop {
            let limit = {
                let rig = self.rig.borrow();
                let left = self.job.options.limit_us.saturating_sub(rig.us()).max(1);
                rig.now() + rig.ticks(LOOK_US.min(left))
            };
            self.rig.borrow_mut().run_to_event(limit)?;
            self.look()?;
            let observed = self.rig.borrow_mut().take_observed();
            for seen in observed {
                let us = self.rig.borrow().us_at(seen.tick);
                // What a stop brings about is no sign of life.
                if self.stopping.is_none() {
                    self.watch.something_happened(us);
                    self.waits.something_happened(us);
                }
                let Some(what) = self.teller.tell(&seen) else { continue };
                self.path.event(&what);
                self.within.tell(&what);
                if let What::Run { line, .. } = what {
                    self.turn(us, line);
                }
                if let Some(line) = what.motion_line() {
                    let away = self.aways.last().filter(|last| last.to_us == u64::MAX);
                    self.judge.line(seen.tick, away.map_or(line, |away| away.line));
                }
                self.tell_cell(us, &what);
                let event = Event { what, us: self.job.options.times.then_some(us) };
                (self.trace)(&event);
                if matches!(event.what, What::End { .. }) {
                    return Ok(event.what);
                }
            }
            self.host_actions()?;
            self.stop_in_time()?;
        }
    }

    /// RUN in this line has begun a program.
    fn turn(&mut self, us: u64, line: u32) {
        let (place, program) = self.teller.runs();
        if let Some(own) = program {
            self.rig.borrow_mut().set_registers(&Registers::on_board(own.program));
        }
        let open = self.aways.last_mut().filter(|last| last.to_us == u64::MAX);
        match open {
            Some(last) if place == 0 => last.to_us = us,
            None if place != 0 => {
                self.aways.push(Away { from_us: us, to_us: u64::MAX, line });
            }
            _ => {}
        }
    }

    /// Ends a run that is over although its program is not.
    fn stop_in_time(&mut self) -> Result<(), BoardError> {
        let us = self.rig.borrow().us();
        match self.stopping {
            Some((_, since)) if us > since + STOP_PATIENCE_US => {
                let status = self.client.status()?;
                Err(BoardError::Board(format!(
                    "the board does not end the run: it is {}, axes {:?} move, {} of the \
                     statements' code",
                    status.state, status.moving, status.program_counter
                )))
            }
            Some(_) => Ok(()),
            None => {
                if let Some(reason) = self.is_over(us)? {
                    self.stopping = Some((reason, us));
                    self.client.control(Control::Stop)?;
                }
                Ok(())
            }
        }
    }

    /// The limit is reached, or nothing can happen any more.
    fn is_over(&mut self, us: u64) -> Result<Option<StopReason>, BoardError> {
        if (self.job.options.interrupted)() {
            return Ok(Some(StopReason::Interrupted));
        }
        if us >= self.job.options.limit_us {
            return Ok(Some(StopReason::Limit));
        }
        if self.rig.borrow().cell().is_some_and(|cell| cell.get().must_end()) {
            return Ok(Some(StopReason::Collision));
        }
        let world_is_over = self.rig.borrow().world_is_over();
        let pulses = self.rig.borrow().pulses();
        if !world_is_over {
            // Nobody is there to press Start, whatever the world of a file still does.
            if self.rig.borrow().acts_unattended() && self.waits.is_quiet(us, pulses) {
                let status = self.status()?;
                let waits =
                    status.run_state == Some(RunState::WaitStart) && status.moving.is_empty();
                // Once for each wait: the press ends it.
                let anew = self.waits.since_us() >= self.released_us;
                if waits && anew && self.rig.borrow_mut().waits_for_start(self.waits.since_us()) {
                    self.unattended.released.push(self.teller.line_of(status.program_counter));
                    self.released_us = us;
                }
            }
            // What the world does last may still be on its way through the input's filter.
            self.watch.something_happened(us);
            return Ok(None);
        }
        if !self.watch.is_quiet(us, pulses) {
            return Ok(None);
        }
        let status = self.status()?;
        let rests = status.moving.is_empty();
        let line = self.teller.line_of(status.program_counter);
        let (_, Some(Other { program, .. })) = self.teller.runs() else { return Ok(None) };
        let over = match status.run_state {
            // What a pause interrupted still counts as moving.
            Some(RunState::Paused) => true,
            Some(RunState::WaitStart) if rests => {
                if self.rig.borrow_mut().cell_waits_for_start() {
                    return Ok(None);
                }
                if self.rig.borrow_mut().waits_for_start(self.watch.since_us()) {
                    self.unattended.released.push(line);
                    self.released_us = us;
                    return Ok(None);
                }
                !stuck::has_ticks(program)
            }
            Some(RunState::Running) => rests && stuck::waits_for_ever(program, line),
            _ => false,
        };
        Ok(over.then_some(StopReason::Idle))
    }

    /// The board's state, asked for without a trace of the question on the board.
    fn status(&mut self) -> Result<BoardStatus, BoardError> {
        self.rig.borrow_mut().set_aside();
        let status = self.client.status();
        self.rig.borrow_mut().come_back();
        Ok(status?)
    }

    /// What happened at the pins since the last look.
    fn look(&mut self) -> Result<(), BoardError> {
        self.release_start();
        let mut rig = self.rig.borrow_mut();
        let outputs = rig.take_output_edges();
        let inputs = rig.take_input_edges();
        let edge = |(tick, n, on)| Edge { us: rig.us_at(tick), n, on };
        for own in outputs.into_iter().map(edge) {
            self.uses.edge(&own);
            if self.job.options.record {
                self.outputs.push(own);
            }
        }
        if self.job.options.record {
            self.inputs.extend(inputs.into_iter().map(edge));
            self.path.sample(&rig);
        }
        let edges = rig.board().take_edges();
        self.judge.take(&edges);
        if let Some(vcd) = &mut self.vcd {
            vcd.write(&edges).map_err(BoardError::Vcd)?;
        }
        for ([least, greatest], at) in self.unattended.reached.iter_mut().zip(rig.motors()) {
            let at = i32::try_from(at).unwrap_or_default();
            *least = at.min(*least);
            *greatest = at.max(*greatest);
        }
        self.within.look(told(&rig), rig.lost());
        let now = rig.us();
        drop(rig);
        (self.progress)(now);
        Ok(())
    }

    fn host_actions(&mut self) -> Result<(), BoardError> {
        let actions = self.rig.borrow_mut().take_host_actions();
        for action in actions {
            match action {
                HostAction::Char(c) => {
                    let value = u16::try_from(c).unwrap_or(0);
                    self.client.write(wire::CHAR_IN, value)?;
                }
                HostAction::EmergencyStop => self.client.control(Control::EmergencyStop)?,
                HostAction::Pause(pauses) => {
                    self.client.control(if pauses { Control::Pause } else { Control::Resume })?;
                }
                HostAction::Register(register, value) => {
                    self.client.write_all(register, &halves(value))?;
                }
            }
        }
        Ok(())
    }

    /// Lets the machine come to rest, compares pulses with positions, and adds up.
    ///
    /// # Errors
    /// The board does not answer, or the VCD cannot be written.
    pub fn finish(&mut self, end: What) -> Result<BoardRun, BoardError> {
        let us = self.rig.borrow().us();
        self.client.link().pause(REST);
        self.look()?;
        let What::End { status, fault, line, pos, .. } = end else {
            return Err(BoardError::Board("the trace has no end".to_owned()));
        };
        let identity = self.client.identity()?;
        let late_events = self.client.late_events()?;
        let late_line = status == Status::Fault && self.client.status()?.text == Some(LATE_LINE[0]);
        let mut rig = self.rig.borrow_mut();
        let health = Health { late_events, ..rig.board().health(&identity) };
        let mut failures = rig.failures(&pos);
        failures.extend(self.within.strayed());
        for axis in Axis::ALL {
            let i = axis.index();
            let there = rig.motors()[i] + rig.offset()[i];
            if let Some(told) = pos.get(axis)
                && rig.lost()[i] == 0
                && there != i64::from(told)
            {
                failures.push(format!(
                    "{} made step pulses to {there}, but the trace ends at {told}",
                    axis.letter()
                ));
            }
        }
        let number = fault.as_ref().and_then(|code| code.get(1..)?.parse().ok());
        let fault_number = number.and_then(Fault::from_number);
        let abrupt = matches!(fault_number, Some(Fault::EmergencyStop | Fault::LimitSwitch));
        let judged = self.judge.judge(&rig.plant(), abrupt).unwrap_or_else(|text| {
            failures.push(text);
            Count::default()
        });
        let steps = self.path.pulses(&rig);
        let profile = &self.job.program.profile;
        let travel_um = Axis::ALL.map(|axis| {
            profile.axis(axis).map_or(0, |own| {
                steps[axis.index()] * u64::from(own.scale.um) / u64::from(own.scale.steps)
            })
        });
        let stopped = (status == Status::Stopped)
            .then_some(self.stopping.map_or(StopReason::Button, |(reason, _)| reason));
        // Nothing happened in the time that it took to find that nothing can.
        let us = if stopped == Some(StopReason::Idle) { self.watch.since_us() } else { us };
        let outputs = self.uses.until(us);
        let (place, own) = self.teller.runs();
        let summary = Summary {
            status,
            fault,
            stopped,
            line,
            program: (place != 0).then(|| own.map_or("", |own| own.name).to_owned()),
            us,
            statements: 0,
            steps,
            travel_um,
            outputs,
        };
        let remarks = rig.warnings().into_iter().take(5);
        let remarks = remarks.map(|warning| format!("the emulator warns: {warning}")).collect();
        let tick = rig.now();
        drop(rig);
        if let Some(vcd) = self.vcd.take() {
            vcd.finish(tick).map_err(BoardError::Vcd)?;
        }
        let [inputs, outputs] = [&mut self.inputs, &mut self.outputs].map(std::mem::take);
        let mut record: Record = std::mem::take(&mut self.path).record(inputs, outputs);
        record.show(&self.aways);
        let end = End { status, fault: fault_number, line };
        let alone = self.rig.borrow().is_unattended();
        let unattended =
            if alone { std::mem::take(&mut self.unattended) } else { Unattended::default() };
        let vars = Vec::new();
        let cell = self.judge_cell(us, &end);
        let outcome = Outcome {
            end,
            summary,
            record,
            vars,
            failures,
            unattended,
            program: place,
            onward: None,
            late_line,
            cell,
        };
        Ok(BoardRun { outcome, remarks, health, judged })
    }
}

/// Where the motors stand, steps as the trace counts them.
fn told<B: Hardware>(rig: &Rig<B>) -> [i64; 3] {
    let (motors, offset) = (rig.motors(), rig.offset());
    std::array::from_fn(|axis| motors[axis] + offset[axis])
}
