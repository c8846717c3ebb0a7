//! The chip's half of motion in the emulator: arithmetic and step engine against their twins.

mod engine;

use emulator::Board;
use engine::{
    CLOCK, DIR_OUT, Engine, HOME, HZ, SINGLE, STACK, TICK, VECTOR, axes, board, put_axis, quiet,
    steps,
};
use firmware::motion::scaled::Scaled;
use firmware::motion::{
    Arc, Block, Ends, Feed, Manner, Pace, Path, PathSegment, Segment, Single, physics,
};
use lang::record::AxisRecord;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;

/// A chip on which single functions are called, interrupts off.
struct Chip {
    board: Board,
    /// Longest call, cycles.
    worst: u64,
}

impl Chip {
    fn new() -> Chip {
        let mut board = board();
        quiet(&mut board);
        board.set_breakpoint(HOME);
        Chip { board, worst: 0 }
    }

    /// Calls a function with two 32-bit arguments; its 32-bit result.
    fn call(&mut self, name: &str, a: u32, b: u32) -> u32 {
        let at = self.board.far_symbol(name).unwrap_or_else(|| panic!("no symbol {name}"));
        // CALLA #at (SLAU208, 6.5.2) in front of the loop.
        let (call, sp) = (HOME - 4, STACK + 2);
        self.board.poke16(call, 0x13B0 | (at >> 16) as u16);
        self.board.poke16(call + 2, at as u16);
        for (register, value) in
            [(0, call), (1, sp), (2, 0), (12, a as u16), (13, (a >> 16) as u16)]
        {
            self.board.set_reg(register, value);
        }
        self.board.set_reg(14, b as u16);
        self.board.set_reg(15, (b >> 16) as u16);
        let from = self.board.cycles();
        for kept in 4..11 {
            self.board.set_reg(kept, 0x1110 * kept as u16);
        }
        self.board.run_for(100_000 * TICK);
        assert_eq!(self.board.reg(0), HOME, "{name}({a:#x}, {b:#x}) did not return");
        assert_eq!(self.board.reg(1), sp, "{name} leaves the stack as it was");
        for kept in 4..11 {
            assert_eq!(self.board.reg(kept), 0x1110 * kept as u16, "{name} keeps r{kept}");
        }
        self.worst = self.worst.max((self.board.cycles() - from) / TICK);
        u32::from(self.board.reg(12)) | u32::from(self.board.reg(13)) << 16
    }
}

/// Zero, or a number in the planner's range.
fn scaled() -> impl Strategy<Value = Scaled> {
    prop_oneof![
        1 => Just(Scaled::ZERO),
        9 => (0x80_0000u32..0x100_0000, 96u32..170).prop_map(|(m, e)| Scaled(e << 24 | m)),
    ]
}

#[test]
fn scaled_arithmetic_is_that_of_its_twin() {
    let mut chip = Chip::new();
    let mut runner = TestRunner::new(ProptestConfig::with_cases(400));
    let chip = std::cell::RefCell::new(&mut chip);
    let pairs = (scaled(), scaled(), 0u32..30);
    runner
        .run(&pairs, |(a, b, near)| {
            let mut chip = chip.borrow_mut();
            // Half of the cases compare neighbours, where carries and exact ties live.
            let b = if near < 15 && a.0 != 0 { Scaled(a.0 ^ near) } else { b };
            let two = [
                ("times", a.times(b).0),
                ("over", a.over(b).0),
                ("plus", a.plus(b).0),
                ("minus", a.minus(b).0),
                ("min", a.least(b).0),
                ("max", a.most(b).0),
                ("root", a.root().0),
                ("floor", a.floor()),
                ("new", Scaled::new(a.0).0),
            ];
            for (name, twin) in two {
                let chips = chip.call(&format!("pasapas_scaled_{name}"), a.0, b.0);
                prop_assert_eq!(chips, twin, "{}({:x}, {:x})", name, a.0, b.0);
            }
            let exponent = chip.call("pasapas_scaled_exponent_over", a.0, b.0) as i8;
            prop_assert_eq!(exponent, a.exponent_over(b));
            Ok(())
        })
        .unwrap();
    assert!(chip.borrow().worst < 1_000, "{} cycles", chip.borrow().worst);
}

/// Something for the path.
enum Piece {
    Line(Block),
    Arc(Arc, Feed),
}

impl Piece {
    fn offer(&self, path: &mut Path, axes: &[AxisRecord; 3]) -> bool {
        match self {
            Piece::Line(block) => path.push(axes, block),
            Piece::Arc(arc, feed) => path.push_arc(axes, arc, &Manner::new(*feed, false)),
        }
    }
}

fn line(steps: [i32; 3], feed: Feed, exact: bool) -> Piece {
    Piece::Line(Block { steps, um: [0; 3], manner: Manner::new(feed, exact) })
}

/// Plays blocks on the chip and on the twin; every edge must agree to the tick.
fn plays_as_planned(axes: &[AxisRecord; 3], blocks: &[Piece], width: u16) -> Engine {
    let mut engine = Engine::new(width);
    let mut path = Path::new(20, CLOCK);
    let mut segment = PathSegment::default();
    let mut waiting = blocks.iter();
    let mut planned: [Vec<(u64, bool)>; 3] = Default::default();
    let (mut acc, mut time) = ([0u32; 3], 0u64);
    let mut block = waiting.next();
    for _ in 0..1_000_000 {
        while let Some(b) = block {
            if !b.offer(&mut path, axes) {
                break;
            }
            block = waiting.next();
        }
        if engine.room() {
            if path.next_segment(axes, &mut segment) {
                engine.put(&segment);
                // The twin: the engine's definition in plain Rust.
                let mut interval = segment.ramp.interval;
                if segment.begin {
                    acc = segment.acc.map(|half| u32::from(half) << 16);
                }
                for event in 1..=segment.ramp.events {
                    time += u64::from(interval);
                    interval = interval.wrapping_add_signed(segment.ramp.dif);
                    if event & segment.ramp.mask != 0 {
                        continue;
                    }
                    for a in 0..3 {
                        let (sum, carry) = acc[a].overflowing_add(segment.inc[a]);
                        acc[a] = sum;
                        if carry {
                            planned[a].push((time >> 16, segment.negative >> a & 1 == 0));
                        }
                    }
                }
            } else if path.is_idle() && !engine.running() {
                break;
            }
        }
        engine.board.run_us(8);
    }
    assert_eq!(engine.late(), 0);
    let made = steps(&mut engine);
    let first = planned.iter().flatten().map(|e| e.0).min().expect("steps");
    let begin = made.iter().flatten().map(|e| e.0).min().expect("edges");
    for a in 0..3 {
        for (n, (m, p)) in made[a].iter().zip(&planned[a]).enumerate() {
            assert_eq!(m.1, p.1, "direction of axis {a} at step {n}");
            assert_eq!(m.0 - begin, p.0 - first, "axis {a}, step {n}");
        }
        assert_eq!(made[a].len(), planned[a].len(), "steps of axis {a}");
        let net: i32 = planned[a].iter().map(|e| if e.1 { 1 } else { -1 }).sum();
        assert_eq!(engine.count(a as u16), net as i16);
    }
    engine
}

/// Longest interrupt of channel 0, cycles.
fn worst(engine: &Engine) -> u64 {
    engine.board.stats().interrupts.get(&VECTOR).map_or(0, |stats| stats.worst / TICK)
}

#[test]
fn path_engine_plays_every_edge_as_planned() {
    let ends = Ends {
        first: 0,
        clockwise: true,
        from_um: [0; 3],
        to_um: [10_000, 10_000, 1_000],
        start: [0; 3],
        end: [1_000, 1_000, 100],
    };
    let arc = ends.around([10_000, 0]).expect("an arc");
    let blocks = [
        line([3000, -2000, 700], Feed::Rapid, false),
        line([2000, 100, 0], Feed::Um(60_000), false),
        Piece::Arc(arc, Feed::Um(30_000)),
        line([-1, 7, -3], Feed::Um(2_000), false),
        line([0, 0, -400], Feed::Rapid, true),
        line([5, -5, 5], Feed::Um(300), true),
    ];
    let engine = plays_as_planned(&axes(8_000), &blocks, 0);
    println!("worst {}", worst(&engine));
    assert!(worst(&engine) <= 270, "{} cycles", worst(&engine));
    // Pulses of 20 us, as optocoupled drivers want them.
    plays_as_planned(&axes(8_000), &blocks, 20 * 25);
}

#[test]
fn three_axes_reach_ninety_thousand_steps_a_second() {
    let fast = [line([40_000, 40_000, -40_000], Feed::Rapid, false)];
    let mut axes = axes(90_000);
    for axis in &mut axes {
        axis.accel = 200_000;
        axis.decel = 200_000;
    }
    let engine = plays_as_planned(&axes, &fast, 0);
    let stats = engine.board.stats().interrupts[&VECTOR];
    let mean = stats.total / stats.count / TICK;
    println!("mean {mean} worst {}", worst(&engine));
    assert!(mean <= 190, "{mean} cycles");
}

#[test]
fn started_axes_play_as_planned_and_as_their_motors_can() {
    let axis = axes(20_000)[0];
    let pace = Pace::of(&axis);
    // Targets and the time of each, ms; the later ones find the axis on its way.
    let orders: [&[(u64, i32)]; 3] =
        [&[(0, 9_000), (300, -4_000)], &[(5, -12_000), (250, -3_000)], &[(20, 700), (21, 6_000)]];
    let mut engine = Engine::new(0);
    let step = engine.step;
    // All count up, all DIR pins high.
    for n in 0..3 {
        engine.board.poke16(step + 12 + 2 * n, 1);
    }
    engine.board.bus_write8(DIR_OUT, 0b111);
    let mut singles = [Single::new(0, CLOCK), Single::new(0, CLOCK), Single::new(0, CLOCK)];
    let mut planned: [Vec<(bool, Segment)>; 3] = Default::default();
    let from = engine.board.cycles();
    for _ in 0..40_000 {
        let ms = (engine.board.cycles() - from) / (u64::from(HZ) / 1000 * TICK);
        for (n, single) in singles.iter_mut().enumerate() {
            for (due, target) in orders[n] {
                if ms >= *due && single.target() != *target && planned[n].len() < 1_000 {
                    let last = orders[n].last().is_some_and(|order| order.1 == single.target());
                    if !last {
                        single.go(&axis, *target, pace);
                    }
                }
            }
            let next = engine.play + SINGLE * n as u16 + 12;
            let mut segment = Segment::default();
            if engine.board.peek16(next + 8) == 0 && single.next_segment(&mut segment) {
                planned[n].push((single.negative(), segment));
                put_axis(&mut engine, n as u16, &segment, single.negative());
            }
        }
        engine.board.run_us(50);
    }
    assert_eq!(engine.late(), 0);
    let made = steps(&mut engine);
    let bounds = physics::Limits { start: 400.0, top: 20_000.0, accel: 50_000.0, decel: 50_000.0 };
    for n in 0..3 {
        let target = orders[n].last().expect("an order").1;
        assert_eq!(i32::from(engine.count(n as u16)), target, "axis {n}");
        let mut edges = made[n].as_slice();
        for run in planned[n].chunk_by(|a, b| a.0 == b.0) {
            let times = physics::instants(run.iter().map(|s| &s.1), 0);
            let (these, rest) = edges.split_at(times.len());
            edges = rest;
            let ticks: Vec<u64> = these.iter().map(|e| e.0).collect();
            for (edge, time) in ticks.iter().zip(&times) {
                let off = (edge - ticks[0]).abs_diff(time - times[0]);
                assert!(off <= 1, "axis {n}: an edge is {off} ticks off");
            }
            assert!(these.iter().all(|e| e.1 != run[0].0), "direction of axis {n}");
            let record: Vec<u64> = ticks.iter().map(|at| physics::ticks(*at, HZ)).collect();
            assert_eq!(physics::check(&record, &bounds), Ok(()), "axis {n}");
        }
        assert!(edges.is_empty(), "axis {n} made {} steps more", edges.len());
    }
}
