//! Operator actions: Start, Stop, emergency stop, switches and the link at random instants of
//! random programs. Positions stay right or are marked unknown, nothing moves without a request,
//! and after the end outputs are as the profile says.

use emulator::plant::Contact;
use emulator::{Board, Config, Rng};
use lang::axis::Axis;
use lang::fault::Fault;
use lang::record::{BoardRecord, OutputStates, feature};
use lang::wire::{Control, FAULT, HOMED, MACHINE_POSITIONS, PROFILE_WINDOW, RUN_COUNT, RunState};

use super::generate::{Case, generate_for};
use super::programs::{Made, make_for, tape};
use super::stand::{Answer, BOOT_US, Fresh, Stand, words};
use super::table::Table;
use super::{DESK, Row, Settings, Sink, Verdict};
use crate::board::{Build, F5529};

/// Longest time that a run may take to end once it was stopped, in looks.
const LOOKS: u32 = 800;
const LOOK_US: u64 = 10_000;
/// Steps cease so soon behind an emergency stop, us: the event that is armed is at most 2 ms away.
const CEASE_US: u64 = 4_000;
/// What is done to a run.
const WHAT: &str = "buttons, switches, link";
/// Hold, door and emergency stop of the boards here.
const HOLD: u8 = 6;
const DOOR: u8 = 7;
const EMERGENCY: u8 = 8;

/// What is checked; a test shows that each check can fail.
pub struct People<B = Board> {
    stand: Stand<B>,
    record: BoardRecord,
    rng: Rng,
    script: String,
    /// The program has KEEP values.
    keeps: bool,
}

/// Pulses of each axis so far.
fn pulses<B: Table>(stand: &Stand<B>) -> [u64; 3] {
    Axis::ALL.map(|axis| stand.board.plant().motors[axis.index()].pulses)
}

/// A board record with roles and random states of the outputs.
fn record(rng: &mut Rng) -> BoardRecord {
    let mut states = || {
        let keep = rng.bits() as u16;
        OutputStates { keep, on: rng.bits() as u16 & !keep }
    };
    let (pause, fault, end) = (states(), states(), states());
    BoardRecord {
        sequence: 1,
        hold: [HOLD, 0],
        door: [0, DOOR],
        emergency: [0, EMERGENCY, 0, 0],
        pause,
        fault,
        end,
        spindle: 0,
        ..BoardRecord::DEFAULT
    }
    .sealed()
}

/// Gives the board a record of its own, and restarts it.
fn give_record<B: Table>(stand: &mut Stand<B>, rng: &mut Rng) -> Result<BoardRecord, String> {
    let record = record(rng);
    for (n, part) in words(&record.to_bytes()).chunks(16).enumerate() {
        match stand.write(PROFILE_WINDOW + 16 * n as u16, part) {
            Answer::Reply(_) => {}
            answer => return Err(format!("the profile was answered by {answer:?}")),
        }
    }
    stand.control(Control::Restart);
    stand.board.run_us(BOOT_US);
    Ok(record)
}

/// Which board profile the hands play with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Roles {
    /// That of a board that was never given one.
    Default,
    /// Roles for hold, door and emergency stop, and random states of the outputs.
    Random,
}

impl<B: Table> People<B> {
    /// A board with a profile and the program.
    ///
    /// # Errors
    /// The board does not take them.
    pub fn new(
        mut stand: Stand<B>,
        made: &Made,
        mut rng: Rng,
        roles: Roles,
    ) -> Result<People<B>, String> {
        let record = match roles {
            Roles::Default => BoardRecord::DEFAULT,
            Roles::Random => give_record(&mut stand, &mut rng)?,
        };
        let image = &made.compiled.image;
        let keep = image.get(1).is_some_and(|features| u16::from(*features) & feature::KEEP != 0);
        stand.upload(image, keep).map_err(|answer| format!("upload: {answer:?}"))?;
        for (axis, side) in [(0, -1), (1, -1), (2, 1)] {
            let position = side * (50 + rng.below(500) as i64);
            let switch = Contact { axis, position, above: side > 0 };
            stand.board.plant_mut().switches[axis] = Some(switch);
        }
        stand.board.plant_mut().probes[2] = Some(Contact { axis: 2, position: -300, above: false });
        Ok(People { stand, record, rng, script: made.case.script.clone(), keeps: keep })
    }

    /// A while of random activity.
    ///
    /// # Errors
    /// What did not hold.
    pub fn play(&mut self) -> Result<(), String> {
        self.press_start();
        for _ in 0..4 + self.rng.below(12) {
            self.stand.board.run_us(self.rng.below(60_000));
            self.act()?;
        }
        Ok(())
    }

    /// The board.
    pub fn stand(&mut self) -> &mut Stand<B> {
        &mut self.stand
    }

    fn press_start(&mut self) {
        self.stand.board.plant_mut().press_start(true);
        self.stand.board.run_us(12_000 + self.rng.below(40_000));
        self.stand.board.plant_mut().press_start(false);
    }

    fn act(&mut self) -> Result<(), String> {
        let rng = &mut self.rng;
        let board = &mut self.stand.board;
        match rng.below(16) {
            0..=2 => self.press_start(),
            3 | 4 => {
                board.plant_mut().press_stop(true);
                // Held for 2 s it ends the run.
                let held = if rng.below(4) == 0 { 2_100_000 } else { rng.below(90_000) };
                self.stand.board.run_us(held);
                self.stand.board.plant_mut().press_stop(false);
            }
            5..=9 => {
                let n = 1 + rng.below(5) as u8;
                board.plant_mut().set_input(n, rng.below(2) == 0);
            }
            // Without these roles they are inputs as any other.
            10..=12 if self.record.emergency == [0; 4] => {
                board.plant_mut().set_input(EMERGENCY, rng.below(2) == 0)
            }
            10 => board
                .plant_mut()
                .set_input(if rng.below(2) == 0 { HOLD } else { DOOR }, rng.below(3) == 0),
            11 => {
                board.plant_mut().set_input(EMERGENCY, true);
                self.stand.board.run_us(1_000 * u64::from(2 * self.record.filter) + CEASE_US);
                self.ceased()?;
                self.stand.board.plant_mut().set_input(EMERGENCY, false);
            }
            12 => {
                self.control(Control::EmergencyStop);
                self.stand.board.run_us(CEASE_US);
                self.ceased()?;
            }
            _ => {
                let codes = [Control::Start, Control::Pause, Control::Resume, Control::Stop];
                let code = codes[rng.below(4) as usize];
                if let Answer::Silence | Answer::Noise(_) = self.control(code) {
                    return Err(format!("{code:?} was not answered"));
                }
            }
        }
        Ok(())
    }

    /// A run control. An erase stops the chip for 10 ms and what comes meanwhile is lost (SLAS735, flash
    /// memory): where KEEP values are written it is said once more, as every host does.
    fn control(&mut self, code: Control) -> Answer {
        match self.stand.control(code) {
            Answer::Silence | Answer::Noise(_) if self.keeps => self.stand.control(code),
            answer => answer,
        }
    }

    /// An emergency stop has just come.
    fn ceased(&mut self) -> Result<(), String> {
        let before = pulses(&self.stand);
        if self.stand.state() != Some(RunState::Fault as u16) {
            // A start between the stop and this look acknowledges it.
            return Err("an emergency stop latches no fault".to_owned());
        }
        let fault = self.stand.read(FAULT).ok_or("no answer in an emergency stop")?;
        if fault != u16::from(Fault::EmergencyStop.number()) {
            return Err(format!("an emergency stop latches F{fault:02}"));
        }
        if self.stand.read(HOMED) != Some(0) {
            return Err("positions are known behind an emergency stop".to_owned());
        }
        self.stand.board.run_us(20_000);
        if pulses(&self.stand) != before {
            return Err("steps behind an emergency stop".to_owned());
        }
        self.outputs_are(self.record.fault, "behind an emergency stop")
    }

    /// Outputs that the profile does not leave as they are have its states.
    fn outputs_are(&mut self, wanted: OutputStates, when: &str) -> Result<(), String> {
        let outputs = self.stand.board.plant().outputs();
        if (outputs ^ wanted.on) & !wanted.keep != 0 {
            let OutputStates { keep, on } = wanted;
            return Err(format!("outputs {outputs:04X} {when}, not {on:04X} but for {keep:04X}"));
        }
        Ok(())
    }

    /// Everything is let go, the run ends, and all is looked at.
    ///
    /// # Errors
    /// What did not hold.
    pub fn end(&mut self, offset: [i64; 3]) -> Result<(), String> {
        {
            let mut plant = self.stand.board.plant_mut();
            plant.press_stop(false);
            plant.press_start(false);
            (1..=8).for_each(|n| plant.set_input(n, false));
        }
        self.stand.control(Control::Stop);
        let resting = [RunState::Ready as u16, RunState::Fault as u16];
        let mut looks = 0;
        loop {
            self.stand.board.run_us(LOOK_US);
            let state = self.stand.state().ok_or("no answer at the end")?;
            if resting.contains(&state) {
                break;
            }
            looks += 1;
            if looks > LOOKS {
                return Err("the run does not end".to_owned());
            }
        }
        let before = pulses(&self.stand);
        for _ in 0..6 {
            let (n, on) = (1 + self.rng.below(5) as u8, self.rng.below(2) == 0);
            self.stand.board.plant_mut().set_input(n, on);
            self.stand.board.run_us(8_000);
        }
        if pulses(&self.stand) != before {
            return Err("an axis moves though nothing runs".to_owned());
        }
        let runs = self.stand.read(RUN_COUNT).ok_or("no answer behind the end")?;
        let fault = self.stand.read(FAULT).ok_or("no answer behind the end")?;
        if fault != 0 {
            self.outputs_are(self.record.fault, &format!("behind F{fault:02}"))?;
        } else if runs > 0 {
            self.outputs_are(self.record.end, "behind the end")?;
        }
        self.positions(offset)?;
        self.health()
    }

    /// Each axis is where the board says, or was homed since: then it counts from its switch.
    fn positions(&mut self, offset: [i64; 3]) -> Result<(), String> {
        for axis in Axis::ALL {
            let i = axis.index();
            let told = self.stand.read_long(MACHINE_POSITIONS + 2 * i as u16);
            let told = i64::from(told.ok_or("no answer behind the end")?);
            let plant = self.stand.board.plant();
            let truly = plant.motors[i].position;
            let opens = plant.switches[i]
                .map(|switch| if switch.above { switch.position - 1 } else { switch.position + 1 });
            // The switch hangs on a shift register: it is seen up to a step late.
            let homed = opens.is_some_and(|opens| (truly - opens - told).abs() <= 1);
            if told != truly - offset[i] && !homed {
                let letter = axis.letter();
                return Err(format!(
                    "{letter} is at {truly}, but told at {told}; its switch opens at {opens:?}"
                ));
            }
            let moves = |line: &str| {
                let word = line.trim_start().split(' ').next().unwrap_or_default();
                let verb = ["MoveAxe", "MoveRel", "MoveSpeed", "START", "Home", "Home?", "Probe"];
                let gcode = word.starts_with('G') && word.len() < 7;
                (gcode || verb.contains(&word.trim_end_matches('?')) || word.starts_with("Probe"))
                    && line.contains(axis.letter())
            };
            if plant.motors[i].pulses > 0 && !self.script.lines().any(moves) {
                return Err(format!("{} moves, but no statement moves it", axis.letter()));
            }
        }
        Ok(())
    }

    fn health(&self) -> Result<(), String> {
        let board = &self.stand.board;
        if let Some(first) = board.plant().violations().first() {
            return Err(format!("pulses that no driver takes: {first:?}"));
        }
        board.warning().map_or(Ok(()), |warning| Err(format!("the emulator warns: {warning}")))
    }
}

/// One program under one pair of hands.
///
/// # Errors
/// What did not hold.
pub fn try_out<B: Table>(stand: Stand<B>, made: &Made, rng: Rng) -> Result<(), String> {
    let mut people = People::new(stand, made, rng, Roles::Random)?;
    people.play()?;
    people.end([0; 3])
}

/// Random hands, on the emulated boards and on the firmware's machine on the desktop.
///
/// # Errors
/// The shipped firmware is damaged, or the table cannot be written.
pub fn run(settings: &Settings, sink: Sink<'_>) -> Result<(), String> {
    for build in settings.builds {
        let fresh = Fresh::new(Stand::new(build, &Config::default())?);
        let row = Row::on(build, "people", WHAT, settings);
        sink(cases(row, build, &fresh, settings, settings.count(16, 500, 5_000)))?;
    }
    if settings.has_desk() {
        let fresh = Fresh::new(Stand::native());
        let row = Row::of(DESK, "people", WHAT, settings);
        sink(cases(row, &F5529, &fresh, settings, settings.count(60, 5_000, 500_000)))?;
    }
    Ok(())
}

fn cases<B: Table>(
    mut row: Row,
    build: &Build,
    fresh: &Fresh<B>,
    settings: &Settings,
    count: u64,
) -> Row {
    row.run(settings, count, |n| {
        let case = generate_for(build.part, &tape(settings, WHAT, n));
        let Some(made) = make_for(build, Case { world: String::new(), ..case }) else {
            return Verdict::Skipped;
        };
        match try_out(fresh.copy(), &made, settings.rng(WHAT, n)) {
            Ok(()) => Verdict::Survived,
            Err(text) => Verdict::Lost(format!("{text}\n{}", made.case.script)),
        }
    });
    row
}
