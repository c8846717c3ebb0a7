//! Events that become due at each cycle of the time in which the interrupt arms the axes, with the link busy: no step is
//! lost, and what the pins show is less than one event behind the plan.

use emulator::Signal;
use firmware::motion::Feed;
use lang::record::AxisRecord;

use super::rig::{MS, Machine};
use crate::machine::mill;

/// An event follows the one before in each number of cycles up to this, so many times.
const WINDOW: u32 = 400;
const ROUNDS: u32 = 3;
/// One of so many events does.
const EACH: u32 = 7;
/// Shortest high and low time of STEP, cycles of 62.5 ns: 3 and 2.5 us, as the most demanding driver of the manual's table wants
/// (firmware/README.md, Drivers and switches).
const HIGH: u64 = 48;
const LOW: u64 = 40;
/// Compare register of the events.
const TA1CCR0: u16 = 0x0192;
/// In a segment: the change of its interval, and events that are left.
const CHANGE: u16 = 4;
const EVENTS: u16 = 8;

/// A line of so many steps at a rate with events brought forward, pulses of `width` ticks or the shortest; how late the latest
/// came, cycles.
fn latest(steps: [i32; 3], rate: u32, width: u16) -> i16 {
    let axis = AxisRecord {
        flags: AxisRecord::PRESENT,
        steps: 400,
        um: 4_000,
        start_rate: 400,
        top_rate: rate,
        accel: 200_000,
        decel: 200_000,
        ..mill().axes[0]
    };
    let mut machine = Machine::new([axis; 3], true);
    machine.chip.set_word("WIDTH", width);
    machine.line(steps, Feed::Rapid);
    let (place, slots) = (machine.chip.at("step_schedule"), machine.chip.at("SLOT0"));
    let (mut seen, mut made, mut latest) = (0, 0, i16::MIN);
    let mut moved: Option<(u16, u32, u16)> = None;
    while machine.run_to(place, 20 * MS) {
        seen += 1;
        let segment = slots + machine.chip.reg(15);
        let due = machine.chip.board.bus_read16(TA1CCR0);
        let long = |machine: &Machine, at: u16| {
            let board = &machine.chip.board;
            u32::from(board.peek16(at)) | u32::from(board.peek16(at + 2)) << 16
        };
        let set_long = |machine: &mut Machine, at: u16, value: u32| {
            machine.chip.board.poke16(at, value as u16);
            machine.chip.board.poke16(at + 2, (value >> 16) as u16);
        };
        if let Some((segment, interval, wanted)) = moved.take() {
            set_long(&mut machine, segment, interval);
            latest = latest.max(due.wrapping_sub(wanted) as i16);
        } else if seen % EACH == 0
            && made < ROUNDS * (WINDOW + 1)
            && machine.chip.board.peek16(segment + EVENTS) > 4
        {
            let cycles = made % (WINDOW + 1);
            let interval = long(&machine, segment).wrapping_add(long(&machine, segment + CHANGE));
            set_long(&mut machine, segment, cycles << 16);
            moved = Some((segment, interval, due.wrapping_add(cycles as u16)));
            made += 1;
        }
    }
    assert_eq!(made, ROUNDS * (WINDOW + 1), "the run is too short: {seen} events");
    machine.finish(5);
    assert!(machine.replies > 100, "the link is silent");
    let (mut changed, mut least) = ([None; 3], [u64::MAX; 2]);
    let (mut made, mut net, mut dirs) = ([0; 3], [0; 3], [false; 3]);
    for edge in machine.chip.board.take_edges() {
        match edge.signal {
            Signal::Dir(axis) => dirs[usize::from(axis)] = edge.level,
            Signal::Step(axis) => {
                let axis = usize::from(axis);
                if let Some(since) = changed[axis].replace(edge.cycle) {
                    let least = &mut least[usize::from(edge.level)];
                    *least = (*least).min(edge.cycle - since);
                }
                if edge.level {
                    made[axis] += 1;
                    net[axis] += if dirs[axis] { 1 } else { -1 };
                }
            }
            _ => {}
        }
    }
    let [high, low] = least;
    println!("{seen} events, the latest {latest} cycles late; high {high}, low {low} cycles");
    assert_eq!(made, steps.map(i32::unsigned_abs), "a step is lost");
    assert_eq!(net, machine.positions(), "a step is counted that was not made");
    assert!(high >= u64::from(width).max(HIGH) && low >= LOW, "high {high}, low {low} cycles");
    latest
}

/// An event comes before the next one is due, at the rates that the manual names: what is planned and what the motors have
/// been told differ by less than a step of each axis, and no lateness adds up.
#[test]
fn no_event_is_lost_at_any_cycle_of_its_arming() {
    let three = [30_000, 29_000, -28_000];
    for (steps, rate, width) in [(three, 60_000, 0), (three, 40_000, 0), (three, 20_000, 160)] {
        let latest = latest(steps, rate, width);
        let interval = lang::part::G2553.clock / rate;
        assert!(
            u32::try_from(latest).is_ok_and(|latest| latest < interval),
            "{rate} events/s, pulses of {width}: one comes {latest} cycles late, of {interval}"
        );
    }
}
