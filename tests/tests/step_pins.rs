//! STEP and DIR at the pins: events that come while the step engine still arms the axes lose no step and shorten neither a
//! pulse nor the pause behind one; DIR stands before a step as long as the profile says, and never changes beside an
//! active STEP.

mod engine;

use emulator::Signal;
use engine::{CLOCK, COMPARE, CONTROL, COUNTER, Engine, HOME, TICK, axes, pulses, put_axis};
use firmware::motion::{Block, Feed, Manner, Pace, Path, PathSegment, Segment, Single};
use lang::record::AxisRecord;

/// Interrupts are held off for each number of cycles up to this one.
const LONGEST: u64 = 400;
/// The least that the drivers of the manual's table want of STEP low at these pulses, DM542: 2.5 us.
const DRIVER: u64 = 63;
/// Ticks of the shortest pulse that the engine promises: 3 us.
const PULSE: u64 = 75;

/// Holds interrupts off for `cycles`, from shortly before the next event of a channel that is enabled. False when none
/// came near while the processor was idle.
fn hold(engine: &mut Engine, cycles: u64) -> bool {
    let board = &mut engine.board;
    for _ in 0..4_000 {
        let now = board.bus_read16(COUNTER);
        let near = (0..4).any(|channel| {
            let enabled = board.bus_read16(CONTROL + 2 * channel) & 0x10 != 0;
            let away = board.bus_read16(COMPARE + 2 * channel).wrapping_sub(now) as i16;
            enabled && (1..=4).contains(&away)
        });
        if near && board.reg(0) == HOME && board.reg(2) & 8 != 0 {
            board.set_reg(2, 0u16);
            board.run_for(cycles * TICK);
            board.set_reg(2, 8u16);
            return true;
        }
        board.step();
    }
    false
}

/// What was found behind a run with interrupts held off at random.
struct Found {
    /// Times that they were.
    held: u64,
    late: u16,
    /// Counted less made, each axis.
    lost: [i64; 3],
    high: u64,
    low: u64,
}

fn found(mut engine: Engine, held: u64) -> Found {
    let late = engine.late();
    let counted = [0, 1, 2].map(|axis| engine.count(axis));
    let (mut made, mut ended) = ([0i16; 3], [None; 3]);
    let (mut high, mut low) = (u64::MAX, u64::MAX);
    for pulse in pulses(&mut engine, true) {
        made[pulse.axis] = made[pulse.axis].wrapping_add(1);
        high = high.min(pulse.to - pulse.from);
        if let Some(ended) = ended[pulse.axis].replace(pulse.to) {
            low = low.min(pulse.from - ended);
        }
    }
    let lost = [0, 1, 2].map(|axis| i64::from(counted[axis].wrapping_sub(made[axis])));
    Found { held, late, lost, high, low }
}

fn check(found: &Found, width: u16) {
    let Found { held, late, lost, high, low } = found;
    let told = format!("{held} holds, {late} late, lost {lost:?}, high {high}, low {low}");
    println!("{told}");
    assert!(*held >= 3 * LONGEST && *late > 100, "nothing was late: {told}");
    assert_eq!(*lost, [0; 3], "{told}");
    assert!(*high >= u64::from(width).max(PULSE) && *low >= DRIVER, "{told}");
}

/// Three axes on a path at their top rate.
fn path(top: u32, width: u16) -> Found {
    let mut axes = axes(top);
    for axis in &mut axes {
        (axis.accel, axis.decel, axis.start_rate) = (300_000, 300_000, 4_000);
    }
    let mut engine = Engine::new(width);
    let mut path = Path::new(20, CLOCK);
    let mut segment = PathSegment::default();
    let mut held = 0;
    for way in [[30_000, 20_000, 29_000], [30_000, 30_000, 30_000]] {
        let block = Block { steps: way, um: [0; 3], manner: Manner::new(Feed::Rapid, false) };
        assert!(path.push(&axes, &block));
    }
    loop {
        while engine.room() && path.next_segment(&axes, &mut segment) {
            engine.put(&segment);
        }
        if path.is_idle() && !engine.running() {
            return found(engine, held);
        }
        held += u64::from(hold(&mut engine, held % (LONGEST + 1)));
        engine.board.run_us(150);
    }
}

#[test]
fn a_late_event_of_a_path_loses_nothing() {
    check(&path(90_000, 0), 0);
}

#[test]
fn a_late_event_of_a_path_with_long_pulses_loses_nothing() {
    check(&path(40_000, 250), 250);
}

/// Three axes on their own at their top rate.
fn singles(top: u32, width: u16) -> Found {
    let axis = AxisRecord { accel: 300_000, decel: 300_000, start_rate: 4_000, ..axes(top)[0] };
    let mut engine = Engine::new(width);
    let step = engine.step;
    for n in 0..3 {
        engine.board.poke16(step + 12 + 2 * n, 1);
    }
    let mut singles = [Single::new(0, CLOCK); 3];
    for (single, way) in singles.iter_mut().zip([30_000, 29_990, 29_000]) {
        single.go(&axis, way, Pace::of(&axis));
    }
    let mut held = 0;
    loop {
        for (n, single) in (0..).zip(&mut singles) {
            let next = engine.play + engine::SINGLE * n + 12;
            let mut segment = Segment::default();
            if engine.board.peek16(next + 8) == 0 && single.next_segment(&mut segment) {
                put_axis(&mut engine, n, &segment, single.negative());
            }
        }
        let runs = (1..4).any(|channel| engine.board.bus_read16(CONTROL + 2 * channel) & 0x10 != 0);
        if !runs && singles.iter().all(Single::is_idle) {
            return found(engine, held);
        }
        held += u64::from(hold(&mut engine, held % (LONGEST + 1)));
        engine.board.run_us(150);
    }
}

#[test]
fn a_late_event_of_axes_on_their_own_loses_nothing() {
    check(&singles(50_000, 0), 0);
}

#[test]
fn a_late_event_of_axes_on_their_own_with_long_pulses_loses_nothing() {
    check(&singles(40_000, 250), 250);
}

/// Ticks for which DIR stands behind the end of a pulse: 1 us.
const HOLD: u64 = 25;

/// Holds all changes of DIR to the steps of their axes; the number of them.
fn dirs_stand(engine: &mut Engine, setup: u64, low: bool) -> u32 {
    let (mut active, mut ended, mut turned) = ([false; 3], [None; 3], [None; 3]);
    let mut changes = 0;
    for edge in engine.board.take_edges() {
        let at = edge.cycle / TICK;
        match edge.signal {
            Signal::Step(axis) => {
                let axis = usize::from(axis);
                active[axis] = edge.level != low;
                if !active[axis] {
                    ended[axis] = Some(at);
                } else if let Some(turned) = turned[axis] {
                    assert!(
                        at - turned >= setup,
                        "a step of axis {axis} {} ticks behind DIR",
                        at - turned
                    );
                }
            }
            Signal::Dir(axis) => {
                let axis = usize::from(axis);
                assert!(!active[axis], "DIR of axis {axis} changes in a pulse");
                if let Some(ended) = ended[axis] {
                    assert!(
                        at - ended >= HOLD,
                        "DIR of axis {axis} changes {} ticks behind a pulse",
                        at - ended
                    );
                    changes += 1;
                }
                turned[axis] = Some(at);
            }
            _ => {}
        }
    }
    changes
}

/// Zigzags of which each line turns axes round at up to their start rate of 50 000 steps/s.
fn zigzag(width: u16, setup: u16, low: bool) -> u32 {
    let mut axes = axes(50_000);
    for axis in &mut axes {
        (axis.accel, axis.decel, axis.start_rate) = (1_000_000, 1_000_000, 50_000);
    }
    let mut engine = Engine::with_signals(width, setup, low);
    let mut path = Path::new(1_000, CLOCK);
    let mut segment = PathSegment::default();
    let mut dice = 0x1234_5678u32;
    let mut lines = 0;
    loop {
        while lines < 400 && path.has_room() {
            let mut way = [0; 3];
            for way in &mut way {
                dice = dice.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                *way = (dice >> 16) as i32 % 200 - 100;
            }
            way[2] = if lines % 2 == 0 { 150 } else { -150 };
            let block = Block { steps: way, um: [0; 3], manner: Manner::new(Feed::Rapid, false) };
            assert!(path.push(&axes, &block));
            lines += 1;
        }
        while engine.room() && path.next_segment(&axes, &mut segment) {
            engine.put(&segment);
        }
        if path.is_idle() && !engine.running() {
            return dirs_stand(&mut engine, setup.into(), low);
        }
        engine.board.run_us(200);
    }
}

#[test]
fn dir_of_a_path_stands_before_and_behind_steps() {
    for low in [false, true] {
        for (width, setup) in [(0, 50), (0, 750), (250, 125), (500, 750)] {
            let changes = zigzag(width, setup, low);
            assert!(
                changes > 300,
                "{changes} changes with pulses of {width} ticks, set-up {setup}, low {low}"
            );
        }
    }
}

/// An axis on its own that is sent to and fro.
fn to_and_fro(width: u16, setup: u16, low: bool) -> u32 {
    let axis =
        AxisRecord { accel: 1_000_000, decel: 1_000_000, start_rate: 40_000, ..axes(40_000)[0] };
    let mut engine = Engine::with_signals(width, setup, low);
    let step = engine.step;
    for n in 0..3 {
        engine.board.poke16(step + 12 + 2 * n, 1);
    }
    let mut single = Single::new(0, CLOCK);
    let mut turns = 0;
    loop {
        if single.is_idle() {
            if turns == 60 {
                break;
            }
            turns += 1;
            single.go(&axis, if turns % 2 == 0 { 0 } else { 40 }, Pace::of(&axis));
        }
        let next = engine.play + 12;
        let mut segment = Segment::default();
        if engine.board.peek16(next + 8) == 0 && single.next_segment(&mut segment) {
            put_axis(&mut engine, 0, &segment, single.negative());
        }
        engine.board.run_us(20);
    }
    engine.board.run_us(5_000);
    dirs_stand(&mut engine, setup.into(), low)
}

#[test]
fn dir_of_an_axis_on_its_own_stands_before_and_behind_steps() {
    for low in [false, true] {
        for (width, setup) in [(0, 50), (0, 750), (250, 125), (500, 750)] {
            let changes = to_and_fro(width, setup, low);
            assert!(
                changes > 50,
                "{changes} changes with pulses of {width} ticks, set-up {setup}, low {low}"
            );
        }
    }
}
