//! Events of the MSP430F5529's step engine that become due at each cycle of the time in which its interrupt arms the axes, with
//! both lines busy: no step is lost, none comes later than the next one is due, and each late one is counted in its own register.

mod rig;

use std::collections::BTreeMap;

use emulator::{Board, Format, Link, Parity, Signal, Silicon, Stop};
use lang::wire::{self, RunState};
use rig::company::{Company, fast, long, start};
use rig::{BOOT_US, off, read};

/// An event follows the one before in each number of cycles up to this, so many times.
const WINDOW: u32 = 400;
const ROUNDS: u32 = 3;
/// One of so many events does.
const EACH: u32 = 9;
/// Arming takes longer than this: what is due in so many cycles is late for sure.
const SURELY: u32 = 60;
/// Shortest low time of STEP, ns.
const LOW_NS: u64 = 2_500;

/// Places in the step engine's memory: events that came late, and when the event of a path is due.
const LATE: u16 = 18;
const DUE: u16 = 40;
/// Compare register of channel 0.
const COMPARE: u16 = 0x0352;
/// In a segment: its change of interval, and events that are left.
const DIF: u16 = 4;
const EVENTS: u16 = 8;

/// What is looked at: the place in the handler where the next event is scheduled by the segment at r15, and where the time
/// stands of the event that has just come.
#[derive(Clone, Copy)]
enum Kind {
    Path,
    Single,
}

impl Kind {
    fn place(self) -> &'static str {
        match self {
            Kind::Path => "path_schedule",
            Kind::Single => "single_schedule",
        }
    }

    fn due(self, board: &mut Board, step: u16) -> u16 {
        match self {
            Kind::Path => board.peek16(step + DUE),
            // r13 is twice the channel's number.
            Kind::Single => board.bus_read16(COMPARE + board.reg(13)),
        }
    }
}

fn long_at(board: &Board, at: u16) -> u32 {
    u32::from(board.peek16(at)) | u32::from(board.peek16(at + 2)) << 16
}

fn set_long(board: &mut Board, at: u16, value: u32) {
    board.poke16(at, value as u16);
    board.poke16(at + 2, (value >> 16) as u16);
}

/// An event that was brought forward: the interval that its segment goes on with, and when it is due.
struct Moved {
    interval: u32,
    due: u16,
}

/// Brings events forward in a run; how late the latest came, and how many were late for sure.
fn disturb(board: &mut Board, kind: Kind) -> (i16, u32) {
    let step = board.symbol("PASAPAS_STEP").expect("a name");
    let place = board.symbol(kind.place()).expect("a name");
    board.set_breakpoint(place);
    let mut company = Company::new([true; 2]);
    let mut moved: BTreeMap<u16, Moved> = BTreeMap::new();
    let (mut seen, mut made, mut sure, mut latest, mut still) = (0, 0, 0, 0, 0);
    let slice = board.ticks_per_second() / 2_000;
    while still < 400 {
        company.ask(board);
        if board.run_for(slice) != Stop::Breakpoint(place.into()) {
            still += 1;
            continue;
        }
        (still, seen) = (0, seen + 1);
        let segment = board.reg(15);
        let due = kind.due(board, step);
        if let Some(moved) = moved.remove(&segment) {
            set_long(board, segment, moved.interval);
            latest = latest.max(due.wrapping_sub(moved.due) as i16);
        } else if seen % EACH == 0
            && made < ROUNDS * (WINDOW + 1)
            && board.peek16(segment + EVENTS) > 4
        {
            let cycles = made % (WINDOW + 1);
            let interval = long_at(board, segment).wrapping_add(long_at(board, segment + DIF));
            set_long(board, segment, cycles << 16);
            moved.insert(segment, Moved { interval, due: due.wrapping_add(cycles as u16) });
            made += 1;
            sure += u32::from(cycles <= SURELY);
        }
    }
    board.clear_breakpoint(place);
    assert_eq!(made, ROUNDS * (WINDOW + 1), "the run is too short");
    (latest, sure)
}

/// Runs a script with events brought forward, at `top` of them in a second, pulses of `pulse_us`. None may come after the next one
/// is due: what is planned and what the motors have been told differ by less than a step of each axis.
fn run(top: u64, pulse_us: u8, script: &str, kind: Kind) {
    let mut profile = fast(top);
    profile.pulse_us = pulse_us;
    let mut board = off(Silicon::default(), &profile, script);
    board.power_up();
    board.set_uart_format_on(Link::Rs485, Format { baud: 115_200, parity: Parity::None });
    board.run_us(BOOT_US);
    let before = [0, 1, 2].map(|axis| board.plant().motors[axis].position);
    board.record(true);
    board.take_edges();
    start(&mut board);
    let (latest, sure) = disturb(&mut board, kind);
    // The last replies.
    board.run_us(50_000);
    assert_eq!(read(&mut board, wire::RUN_STATE), Some(RunState::Ready as u16));
    for (axis, before) in (0..).zip(before) {
        let counted = board.plant().motors[usize::from(axis)].position - before;
        let said = long(&mut board, wire::MACHINE_POSITIONS + 2 * axis);
        assert_eq!(i64::from(said), counted, "axis {axis}: a step is lost");
    }
    let late = read(&mut board, wire::LATE_EVENTS).expect("it answers");
    let step = board.symbol("PASAPAS_STEP").expect("a name");
    assert_eq!(late, board.peek16(step + LATE), "its own register tells them");
    let us = board.ticks_per_second() / 1_000_000;
    let [high, low] = shortest(&mut board).map(|ticks| ticks * 1_000 / us);
    println!(
        "{late} late, {sure} of them for sure, the latest by {latest} cycles; high {high} ns, low {low} ns"
    );
    assert!(u32::from(late) >= sure, "{late} late events are told of {sure}");
    let interval = u64::from(lang::part::F5529.clock) / top;
    assert!(
        u64::try_from(latest).is_ok_and(|latest| latest < interval),
        "an event comes {latest} cycles late, of {interval}"
    );
    assert!(high >= 1_000 * u64::from(pulse_us) && low >= LOW_NS, "high {high} ns, low {low} ns");
}

/// Shortest times for which a STEP was high and low, ticks.
fn shortest(board: &mut Board) -> [u64; 2] {
    let mut changed = [None; 3];
    let mut out = [u64::MAX; 2];
    for edge in board.take_edges() {
        let Signal::Step(axis) = edge.signal else { continue };
        if let Some(since) = changed[usize::from(axis)].replace(edge.cycle) {
            let least = &mut out[usize::from(edge.level)];
            *least = (*least).min(edge.cycle - since);
        }
    }
    out
}

const PATH: &str = "G0 X0 Y0 Z0\nF100000\nG1 X150 Y140 Z150\nG1 X300 Y300 Z290\n";
const ALONE: &str = "START MoveAxe X, 150mm\nSTART MoveAxe Y, 149mm\nSTART MoveAxe Z, 140mm\n\
                     WaitMove X\nWaitMove Y\nWaitMove Z\n";

#[test]
fn no_event_of_a_path_is_lost_at_any_cycle_of_its_arming() {
    run(60_000, 3, PATH, Kind::Path);
}

#[test]
fn no_event_of_a_path_with_long_pulses_is_lost_at_any_cycle_of_its_arming() {
    run(40_000, 8, PATH, Kind::Path);
}

#[test]
fn no_event_of_axes_on_their_own_is_lost_at_any_cycle_of_its_arming() {
    run(30_000, 3, ALONE, Kind::Single);
}

#[test]
fn no_event_of_axes_on_their_own_with_long_pulses_is_lost_at_any_cycle_of_its_arming() {
    run(25_000, 8, ALONE, Kind::Single);
}
