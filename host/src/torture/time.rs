//! Time: programs that never wait, the worst load of interrupts, a main loop that hangs.

use emulator::{Config, Reset, Rng};
use lang::fault::Fault;
use lang::record::{BoardRecord, feature};
use lang::wire::{
    Control, FAULT, HOMED, MACHINE_POSITIONS, MISSED_DEADLINES, PROFILE_WINDOW, RESET_CAUSE,
    RUN_STATE, RunState,
};

use super::power::image;
use super::stand::{Answer, BOOT_US, Fresh, Stand, framed, read_body, words};
use super::{Row, Settings, Sink, Verdict};
use crate::board::Build;

/// Programs that never wait.
const BUSY: [&str; 6] = [
    "DO\nLOOP",
    "DIM a\nDO\na = (a + 7919) MOD 46337\na = a * a / (a + 1)\nLOOP",
    "DIM a\nDO\na = SQR(2147483647 - a) + SQR(a)\nLOOP",
    "DIM a, b\nDO\nFOR a = 1 TO 30000\nNEXT\nLOOP",
    "DIM a\nagain:\nGOSUB sub_1\nGOTO again\nsub_1:\na = a XOR 1\nRETURN",
    "DIM a\nDO\nPRINT a\nSetOut 2, ON\nSetOut 2, OFF\nLOOP",
];
/// A board answers within so many us: the VM yields every 2 ms, and a request takes its time.
const ANSWER_US: u64 = 12_000;
/// A run ends so soon behind a stop, us: flash work included.
const STOP_US: u64 = 60_000;
/// Longest interval of the watchdog, us: 512 periods of the slowest VLO of 4 kHz.
const WATCHDOG_US: u64 = 130_000;
/// Last word of the program area, which no small program reaches: a jump to itself stands here.
const NOWHERE: u16 = 0xFDFE;
/// `jmp $`
const JUMP_TO_ITSELF: u16 = 0x3FFF;

/// A program that never waits: the link answers in time, and a stop ends it.
///
/// # Errors
/// What did not hold.
pub fn busy(stand: &mut Stand, rng: &mut Rng) -> Result<(), String> {
    stand.control(Control::Start);
    for _ in 0..6 {
        stand.board.run_us(rng.below(30_000));
        let began = stand.board.cycles();
        stand.board.uart_take();
        stand.board.uart_send(&framed(&read_body(RUN_STATE, 1)));
        stand.board.run_us(ANSWER_US);
        let per_us = stand.ticks(1);
        let first = stand.board.uart_take().first().map(|(at, _)| (at - began) / per_us);
        let state = stand.state();
        if first.is_none() || state != Some(RunState::Running as u16) {
            return Err(format!("the answer began after {first:?} us, in state {state:?}"));
        }
    }
    let by_hand = rng.below(2) == 0;
    if by_hand {
        stand.board.plant_mut().press_stop(true);
        stand.board.run_us(STOP_US);
        stand.board.plant_mut().press_stop(false);
        if stand.state() != Some(RunState::Paused as u16) {
            return Err("the Stop button does not pause it".to_owned());
        }
    }
    stand.control(Control::Stop);
    stand.board.run_us(STOP_US);
    match stand.state() {
        Some(state) if state == RunState::Ready as u16 => Ok(()),
        state => Err(format!("behind a stop the state is {state:?}")),
    }
}

/// Three axes at their top, events, inputs that chatter and requests without a rest: every step is
/// made and every request answered, or the count of missed deadlines says so.
fn loaded(stand: &mut Stand, rng: &mut Rng) -> Result<(), String> {
    stand.control(Control::Start);
    let mut unanswered = 0;
    for _ in 0..12 {
        let plant = stand.board.plant_mut();
        (1..=5).for_each(|n| plant.set_input(n, rng.below(2) == 0));
        let first = [MACHINE_POSITIONS, RUN_STATE, 5000][rng.below(3) as usize];
        let asked = stand.ask(&read_body(first, 1 + rng.below(60) as u8));
        unanswered += u32::from(!matches!(asked, Answer::Reply(_)));
    }
    for _ in 0..400 {
        if stand.state() == Some(RunState::Ready as u16) {
            break;
        }
        stand.board.run_us(10_000);
    }
    let missed = stand.read(MISSED_DEADLINES).ok_or("no answer at the end")?;
    if unanswered > 0 && missed == 0 {
        return Err(format!("{unanswered} requests were not answered, but no deadline was missed"));
    }
    for axis in 0..3 {
        let told = stand.read_long(MACHINE_POSITIONS + 2 * axis).ok_or("no answer at the end")?;
        let truly = stand.board.plant().motors[usize::from(axis)].position;
        if i64::from(told) != truly {
            return Err(format!("axis {axis} is at {truly}, but told at {told}"));
        }
    }
    match stand.board.plant().violations().first() {
        Some(first) => Err(format!("pulses that no driver takes: {first:?}")),
        None => Ok(()),
    }
}

/// The processor goes nowhere from now on, as after a stroke of lightning.
pub fn hang(stand: &mut Stand) {
    stand.board.poke16(NOWHERE, JUMP_TO_ITSELF);
    stand.board.set_reg(0, NOWHERE);
}

/// A hang in a run: the watchdog resets the chip, outputs are safe, F17 is told.
///
/// # Errors
/// What did not hold.
pub fn hung(stand: &mut Stand, rng: &mut Rng, hang: &dyn Fn(&mut Stand)) -> Result<(), String> {
    stand.control(Control::Start);
    stand.board.run_us(5_000 + rng.below(150_000));
    let ran = stand.state() == Some(RunState::Running as u16);
    stand.board.run_us(rng.below(3_000));
    hang(stand);
    stand.board.run_us(WATCHDOG_US);
    if stand.board.last_reset() != Reset::Watchdog {
        let reset = stand.board.last_reset();
        let pc = stand.board.reg(0);
        return Err(format!("a board that hangs is at {pc:04X}, its last reset was by {reset:?}"));
    }
    if stand.board.plant().outputs() != BoardRecord::DEFAULT.reset_on {
        return Err("outputs are on behind a watchdog reset".to_owned());
    }
    let pulses = |stand: &Stand| stand.board.plant().motors.each_ref().map(|motor| motor.pulses);
    let before = pulses(stand);
    stand.board.run_us(BOOT_US);
    if pulses(stand) != before {
        return Err("steps behind a watchdog reset".to_owned());
    }
    let cause = stand.read(RESET_CAUSE).ok_or("no answer behind a watchdog reset")?;
    let fault = stand.read(FAULT);
    if cause & 1 == 0 || ran && fault != Some(Fault::Watchdog.number().into()) {
        return Err(format!("cause {cause:04X} and fault {fault:?}"));
    }
    match stand.read(HOMED) {
        Some(0) => Ok(()),
        homed => Err(format!("homed is {homed:?} behind a watchdog reset")),
    }
}

/// A board that runs its program by itself after a power-up, and after no other reset: what hung stays at rest, with its
/// fault.
///
/// # Errors
/// What did not hold.
pub fn autorun(stand: &mut Stand, rng: &mut Rng, hang: &dyn Fn(&mut Stand)) -> Result<(), String> {
    for _ in 0..2 {
        stand.board.run_us(500_000 + BOOT_US + rng.below(50_000));
        match stand.state() {
            Some(state) if state == RunState::Running as u16 => {}
            state => return Err(format!("after a power-up the state is {state:?}")),
        }
        hang(stand);
        stand.board.run_us(WATCHDOG_US);
        stand.board.run_us(500_000 + BOOT_US + rng.below(500_000));
        match (stand.state(), stand.read(FAULT)) {
            (Some(state), Some(fault))
                if state == RunState::Fault as u16
                    && fault == u16::from(Fault::Watchdog.number()) => {}
            found => return Err(format!("after a watchdog reset state and fault are {found:?}")),
        }
        stand.board.power_cut();
        stand.board.power_up();
    }
    Ok(())
}

/// A board with a program and, behind a power-up, a profile.
///
/// # Errors
/// The board does not take them.
pub fn board(build: &Build, script: &str, record: Option<BoardRecord>) -> Result<Fresh, String> {
    let mut stand = Stand::new(build, &Config::default())?;
    let taken = |answer| format!("the upload of {script:?} was answered by {answer:?}");
    stand.upload(&image(script)?, false).map_err(taken)?;
    if let Some(record) = record {
        for (n, part) in words(&record.sealed().to_bytes()).chunks(16).enumerate() {
            stand.write(PROFILE_WINDOW + 16 * n as u16, part);
        }
        stand.board.power_cut();
        stand.board.power_up();
    }
    Ok(Fresh::new(stand))
}

/// Faults of time.
///
/// # Errors
/// The shipped firmware is damaged, or the table cannot be written.
pub fn run(settings: &Settings, sink: Sink<'_>) -> Result<(), String> {
    settings.builds.iter().try_for_each(|build| on_boards(build, settings, sink))
}

fn on_boards(build: &Build, settings: &Settings, sink: Sink<'_>) -> Result<(), String> {
    type Case = fn(&mut Stand, &mut Rng) -> Result<(), String>;
    let never =
        BUSY.iter().map(|script| board(build, script, None)).collect::<Result<Vec<_>, _>>()?;
    let has = |feature| build.part.features & feature != 0;
    let on_lines = "ON IN 1 RISE GOSUB edge\nON IN 2 FALL GOSUB edge\nON EVERY 10ms GOSUB edge\n";
    let arc = if has(feature::ARC) { "G2 X6 Y6 I6 J0" } else { "MoveAxe Y, 9mm\nMoveAxe Y, 0mm" };
    let load = format!(
        "DIM n\n{}FOR n = 1 TO 3\nG1 X12 Y9 Z-7 F4800\nG1 X0 Y0 Z0\n{arc}\nNEXT\nEND\n\
         edge:\nn = n + 0\nRETURN",
        if has(feature::EVENTS) { on_lines } else { "" }
    );
    let moves = "DO\nSetOut 1, ON\nG1 X40 Y30 F3000\nSetOut 2, ON\nG1 X0 Y0\nLOOP";
    let auto = BoardRecord {
        sequence: 1,
        flags: BoardRecord::CHAIN | BoardRecord::AUTORUN,
        ..BoardRecord::DEFAULT
    };
    let cases: [(&'static str, Case, Vec<Fresh>, [u64; 3]); 4] = [
        ("programs that never wait", busy, never, [6, 120, 1_200]),
        ("steps, events, link at once", loaded, vec![board(build, &load, None)?], [2, 60, 600]),
        (
            "a main loop that hangs",
            |stand, rng| hung(stand, rng, &hang),
            vec![board(build, moves, None)?],
            [4, 200, 2_000],
        ),
        (
            "autorun, hung",
            |stand, rng| autorun(stand, rng, &hang),
            vec![board(build, moves, Some(auto))?],
            [2, 20, 100],
        ),
    ];
    for (fault, case, boards, [short, usual, long]) in cases {
        let mut row = Row::on(build, "time", fault, settings);
        row.run(settings, settings.count(short, usual, long), |n| {
            let mut stand = boards[n as usize % boards.len()].copy();
            let mut rng = settings.rng(fault, n);
            case(&mut stand, &mut rng).map_or_else(Verdict::Lost, |()| Verdict::Survived)
        });
        sink(row)?;
    }
    Ok(())
}
