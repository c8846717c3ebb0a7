//! Events that come while the step engine still arms the axes: none loses a step, shortens a pulse or the pause
//! behind one.

mod engine;

use engine::{CLOCK, COMPARE, CONTROL, COUNTER, Engine, HOME, TICK, axes, pulses, put_axis};
use firmware::motion::{Block, Feed, Manner, Pace, Path, PathSegment, Segment, Single};
use lang::record::AxisRecord;

/// Interrupts are held off for each number of cycles up to this one.
const LONGEST: u64 = 400;
/// The least that a DRV8825 wants of STEP high and of STEP low: 1.9 us.
const DRIVER: u64 = 48;
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
