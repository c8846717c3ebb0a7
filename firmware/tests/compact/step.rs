//! Motions at the pins: the whole image runs from reset, its main loop, its link and its interrupts,
//! and every step edge is held to what `firmware::motion` plans.

use emulator::{Signal, Stop, TICKS_PER_SECOND};
use firmware::motion::physics;
use firmware::motion::scaled::Scaled;
use firmware::motion::{Block, Feed, Manner, Pace, Path, PathSegment, Segment, Single};
use lang::record::{AxisRecord, MachineRecord};
use lang::wire::{CRC_START, crc16};
use proptest::prelude::*;

use crate::chip::{BOOT_US, CLOCK, Chip};
use crate::line::{aim, feed_word, in_the_unit_of};
use crate::machine::{install, mill};
use crate::ramp::PAUSE;

/// The machine stack's end.
const STACK: u16 = 0x0400;
/// Vector of Timer1_A CCR0.
const STEP: u16 = 0xFFFA;
/// General interrupt enable of the status register.
const GIE: u16 = 8;
const MS: u64 = TICKS_PER_SECOND / 1_000;
/// Ramps of single axes at the most, steps/s2.
const STEEP: u32 = 50_000;
/// Registers read while axes move: the positions.
const POSITIONS: u16 = 2400;

/// A step: its instant in ticks, and whether it went in positive direction.
type Step = (u64, bool);

/// The running image.
struct Machine {
    chip: Chip,
    axes: [AxisRecord; 3],
    /// Instant of the next request of a host that never rests, if there is one.
    request: Option<u64>,
    /// Bytes of its replies.
    replies: usize,
    /// Levels of the DIR pins.
    dirs: [bool; 3],
}

impl Machine {
    /// A board that has come up, with these axes, and with a busy host or none.
    fn new(axes: [AxisRecord; 3], host: bool) -> Machine {
        let mut chip = Chip::new();
        chip.board.reset_pin();
        chip.board.run_us(BOOT_US);
        install(&mut chip, &MachineRecord { axes, ..mill() });
        chip.board.record(true);
        chip.board.clear_stats();
        let request = host.then(|| chip.board.cycles());
        Machine { chip, axes, request, replies: 0, dirs: [false; 3] }
    }

    /// The image runs for a while; a busy host asks for positions again and again.
    fn run(&mut self, ticks: u64) {
        let end = self.chip.board.cycles() + ticks;
        while self.chip.board.cycles() < end {
            let mut until = end;
            if let Some(due) = self.request {
                if due <= self.chip.board.cycles() {
                    let [high, low] = POSITIONS.to_be_bytes();
                    let body = [1, 3, high, low, 0, 6];
                    let crc = body.iter().fold(CRC_START, |crc, &byte| crc16(crc, byte));
                    self.chip.board.uart_send(&[&body[..], &crc.to_le_bytes()].concat());
                    self.request = Some(due + 6 * MS);
                    self.replies += self.chip.board.uart_take().len();
                }
                until = end.min(due + 6 * MS);
            }
            self.chip.board.run_until(until);
        }
    }

    /// Calls a routine from the main loop, with interrupts on, between two passes.
    fn call(&mut self, routine: &str, registers: &[(usize, u16)]) {
        let main = self.chip.at("loop");
        self.chip.board.set_breakpoint(main);
        assert_eq!(self.chip.board.run_for(100 * MS), Stop::Breakpoint(main.into()), "no pass");
        assert_eq!(self.chip.reg(1), STACK);
        let at = self.chip.at(routine);
        self.chip.board.poke16(STACK - 2, main);
        for &(register, value) in registers {
            self.chip.board.set_reg(register, value);
        }
        // Micro-code lies at odd addresses.
        let entry = if at & 1 == 1 { self.chip.at("micro_go") } else { at };
        for (register, value) in [(0, entry), (1, STACK - 2), (2, GIE), (11, at)] {
            self.chip.board.set_reg(register, value);
        }
        assert_eq!(self.chip.board.run_for(100 * MS), Stop::Breakpoint(main.into()), "{routine}");
        self.chip.board.clear_breakpoint(main);
    }

    /// Begins a line; the machine rests. Returns what is planned for it.
    fn line(&mut self, steps: [i32; 3], feed: Feed) -> Plan {
        let from = self.positions();
        aim(&mut self.chip, from, [0, 1, 2].map(|n| from[n] + steps[n]));
        self.chip.set_long("FEED", 0, feed_word(feed));
        self.call("line_begin", &[(12, 7), (13, u16::from(feed == Feed::Rapid))]);
        Plan::line(self.chip.word("STEP_FRAC").into(), &self.axes, steps, feed)
    }

    /// Begins a motion of one axis at its own pace. Returns what is planned for it.
    fn axis(&mut self, n: u16, steps: i32, pace: Pace) -> Plan {
        let from = self.positions();
        let mut to = from;
        to[usize::from(n)] += steps;
        aim(&mut self.chip, from, to);
        for (at, part) in [(0, pace.speed), (4, pace.accel), (8, pace.decel)] {
            self.chip.set_long("TEMP", at, part.0);
        }
        self.chip.set_byte("N", n as u8);
        self.call("axis_begin", &[(12, 1 << n)]);
        let axis = &self.axes[usize::from(n)];
        Plan::axis(self.chip.word("STEP_FRAC").into(), axis, n, steps, pace)
    }

    fn positions(&self) -> [i32; 3] {
        [0, 4, 8].map(|at| self.chip.long("ACTUAL", at) as i32)
    }

    fn commanded(&self) -> [i32; 3] {
        [0, 4, 8].map(|at| self.chip.long("STEPS", at) as i32)
    }

    fn moving(&self) -> bool {
        self.chip.byte("MOVING") != 0
    }

    /// Lets the motion come to its end.
    fn finish(&mut self, seconds: u64) {
        for _ in 0..seconds * 100 {
            if !self.moving() {
                // The places follow in the same pass of the main loop.
                self.run(MS);
                return;
            }
            self.run(10 * MS);
        }
        panic!("the motion has no end: {:?} of {:?}", self.positions(), self.commanded());
    }

    /// The steps of each axis since the last call.
    fn steps(&mut self) -> [Vec<Step>; 3] {
        let dirs = &mut self.dirs;
        let mut out = [const { Vec::new() }; 3];
        for edge in self.chip.board.take_edges() {
            match edge.signal {
                Signal::Dir(a) => dirs[usize::from(a)] = edge.level,
                Signal::Step(a) if edge.level => {
                    out[usize::from(a)].push((edge.cycle, dirs[usize::from(a)]));
                }
                _ => {}
            }
        }
        out
    }
}

/// The steps of segments: the engine's definition in plain Rust. `time` is in 1/65536 ticks and
/// begins with the fraction that the motion before left.
#[derive(Default)]
struct Plan {
    steps: [Vec<Step>; 3],
    time: u64,
    acc: [u32; 3],
}

impl Plan {
    fn play(&mut self, ramp: &Segment, inc: [u32; 3], negative: u8) {
        let mut interval = ramp.interval;
        for event in 1..=ramp.events {
            self.time += u64::from(interval);
            interval = interval.wrapping_add_signed(ramp.dif);
            if event & ramp.mask != 0 {
                continue;
            }
            for (a, inc) in inc.into_iter().enumerate() {
                let (sum, carry) = self.acc[a].overflowing_add(inc);
                self.acc[a] = sum;
                if carry {
                    self.steps[a].push((self.time >> 16, negative >> a & 1 == 0));
                }
            }
        }
    }

    fn line(from: u64, axes: &[AxisRecord; 3], steps: [i32; 3], feed: Feed) -> Plan {
        let (feed, axes) = &in_the_unit_of(feed, *axes);
        let mut path = Path::new(0, CLOCK);
        let manner = Manner::new(*feed, true);
        path.push(axes, &Block { steps, um: [0; 3], manner });
        let mut plan = Plan { time: from, acc: [1 << 31; 3], ..Plan::default() };
        let mut segment = PathSegment::default();
        while path.next_segment(axes, &mut segment) {
            plan.play(&segment.ramp, segment.inc, segment.negative);
        }
        plan
    }

    fn axis(from: u64, axis: &AxisRecord, n: u16, steps: i32, pace: Pace) -> Plan {
        let mut single = Single::new(0, CLOCK);
        single.go(axis, steps, pace);
        let mut plan = Plan { time: from, acc: [1 << 31; 3], ..Plan::default() };
        let mut inc = [0; 3];
        inc[usize::from(n)] = u32::MAX;
        let mut segment = Segment::NONE;
        while single.next_segment(&mut segment) {
            plan.play(&segment, inc, u8::from(steps < 0) << n);
        }
        plan
    }
}

/// Every edge must lie on the tick of the plan, seen from the first one: none was armed late.
fn agree(made: &[Vec<Step>; 3], plan: &Plan) -> Result<(), TestCaseError> {
    let first = |steps: &[Vec<Step>; 3]| steps.iter().flatten().map(|step| step.0).min();
    let (from, begin) = (first(&plan.steps).unwrap_or(0), first(made).unwrap_or(0));
    for (a, (made, planned)) in made.iter().zip(&plan.steps).enumerate() {
        for (n, (m, p)) in made.iter().zip(planned).enumerate() {
            prop_assert_eq!(m.0 - begin, p.0 - from, "axis {}, step {}", a, n);
            prop_assert_eq!(m.1, p.1, "direction of axis {} at step {}", a, n);
        }
        prop_assert_eq!(made.len(), planned.len(), "steps of axis {}", a);
    }
    Ok(())
}

/// What the motor of an axis can follow.
fn bounds(axis: &AxisRecord) -> physics::Limits {
    physics::Limits {
        start: axis.start_rate.into(),
        top: axis.top_rate.into(),
        accel: axis.accel.into(),
        decel: axis.decel.into(),
    }
}

/// An axis of a machine that somebody could build.
fn axis() -> impl Strategy<Value = AxisRecord> {
    (200u16..1_000, 2_000u32..20_000, 20_000u32..200_000, 20_000u32..200_000, 1u16..5).prop_map(
        |(start_rate, top_rate, accel, decel, um)| AxisRecord {
            flags: AxisRecord::PRESENT,
            steps: 100,
            um: um * 250,
            start_rate,
            top_rate,
            accel,
            decel,
            ..mill().axes[0]
        },
    )
}

fn distance() -> impl Strategy<Value = i32> {
    prop_oneof![Just(0), -9..10i32, -500..500i32, -9_000..9_000i32]
}

fn line() -> impl Strategy<Value = ([i32; 3], Feed)> {
    let feed = prop_oneof![
        Just(Feed::Rapid),
        (2_000u32..200_000).prop_map(Feed::Um),
        (300u32..20_000).prop_map(Feed::Steps)
    ];
    ([distance(), distance(), distance()], feed)
}

#[test]
fn every_edge_falls_on_its_tick_while_the_link_is_busy() {
    let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(5) };
    proptest!(config, |(
        axes in [axis(), axis(), axis()],
        lines in prop::collection::vec(line(), 3),
        n in 0u16..3, by in distance(),
    )| {
        let mut machine = Machine::new(axes, true);
        let mut place = [0; 3];
        for (steps, feed) in lines {
            let plan = machine.line(steps, feed);
            machine.finish(60);
            for (place, by) in place.iter_mut().zip(steps) {
                *place += by;
            }
            prop_assert_eq!(machine.positions(), place);
            agree(&machine.steps(), &plan)?;
        }
        // As steep as the planner's own property of its ramps has them.
        let steep = Scaled::new(STEEP);
        let pace = Pace::of(&axes[usize::from(n)]).with_ramps(steep, steep);
        let plan = machine.axis(n, by, pace);
        machine.finish(60);
        place[usize::from(n)] += by;
        prop_assert_eq!(machine.positions(), place);
        let made = machine.steps();
        agree(&made, &plan)?;
        let times: Vec<u64> = made[usize::from(n)].iter().map(|step| step.0).collect();
        let bounds = bounds(&AxisRecord {
            accel: axes[usize::from(n)].accel.min(STEEP),
            decel: axes[usize::from(n)].decel.min(STEEP),
            ..axes[usize::from(n)]
        });
        prop_assert_eq!(physics::check(&times, &bounds), Ok(()));
        prop_assert!(machine.replies > 0, "the link is silent");
    });
}

#[test]
fn the_link_tells_the_speeds_of_axes_that_move() {
    let axis = AxisRecord {
        flags: AxisRecord::PRESENT,
        start_rate: 400,
        top_rate: 2_000,
        accel: 20_000,
        decel: 20_000,
        ..mill().axes[0]
    };
    let mut machine = Machine::new([axis; 3], false);
    machine.line([4_000, -1_000, 0], Feed::Rapid);
    machine.run(500 * MS);
    for (n, speed) in [(0, 2_000), (1, -500), (2, 0)] {
        machine.call("motion_speed", &[(12, n)]);
        assert_eq!(machine.chip.result() as i32, speed, "axis {n}");
    }
    machine.finish(5);
    machine.call("motion_speed", &[(12, 0)]);
    assert_eq!(machine.chip.result(), 0);
}

/// Three axes at a rate while the link is busy: every edge on its tick; the mean interrupt, cycles.
fn three_axes_at(rate: u32) -> u64 {
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
    let axes = [axis; 3];
    let mut machine = Machine::new(axes, true);
    let steps = [40_000, 40_000, -40_000];
    let plan = machine.line(steps, Feed::Rapid);
    machine.finish(5);
    let made = machine.steps();
    agree(&made, &plan).expect("the plan");
    let times: Vec<u64> = made[0].iter().map(|step| step.0).collect();
    assert_eq!(physics::check(&times, &bounds(&axis)), Ok(()));
    assert!(machine.replies > 100, "{} bytes of replies", machine.replies);
    let stats = machine.chip.board.stats().interrupts[&STEP];
    assert!(stats.worst <= 194, "{} cycles", stats.worst);
    stats.total / stats.count
}

#[test]
fn three_axes_make_sixty_thousand_events_a_second_with_the_link_busy() {
    assert!(three_axes_at(40_000) <= 170);
    let mean = three_axes_at(60_000);
    assert!(mean <= 170, "{mean} cycles");
}

#[test]
fn one_axis_makes_sixty_four_thousand_steps_a_second_with_the_link_busy() {
    let axis = AxisRecord {
        flags: AxisRecord::PRESENT,
        start_rate: 1_000,
        top_rate: 64_000,
        accel: 300_000,
        decel: 300_000,
        ..mill().axes[0]
    };
    let mut machine = Machine::new([axis; 3], true);
    let plan = machine.axis(1, -60_000, Pace::of(&axis));
    machine.finish(5);
    let made = machine.steps();
    agree(&made, &plan).expect("the plan");
}

/// What happens to a motion on its way.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Turn {
    /// A pause, and some rest in it, ms.
    Pause(u64),
    Stop,
    Halt,
}

fn turn() -> impl Strategy<Value = Turn> {
    prop_oneof![
        4 => (20u64..60).prop_map(Turn::Pause),
        1 => Just(Turn::Stop),
        1 => Just(Turn::Halt)
    ]
}

/// The instants of steps, run by run: a rest lies between two runs.
fn runs(steps: &[Step], rest: u64) -> Vec<Vec<u64>> {
    let times: Vec<u64> = steps.iter().map(|step| step.0).collect();
    times.chunk_by(|a, b| b - a < rest).map(<[u64]>::to_vec).collect()
}

impl Machine {
    /// Waits until no step comes any more.
    fn rest(&mut self) {
        for _ in 0..1_000 {
            self.call("motion_rests", &[]);
            if self.chip.reg(2) & ZERO != 0 {
                return;
            }
            self.run(2 * MS);
        }
        panic!("the motion does not rest");
    }
}

/// No two steps of a motion lie further apart, ticks: 1/200 s at the start rate.
const REST: u64 = 8 * MS;
/// Zero flag of the status register.
const ZERO: u16 = 2;

#[test]
fn pauses_lose_no_step_and_stops_leave_the_commanded_place_where_the_axes_stand() {
    let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(8) };
    let turns = prop::collection::vec((1u64..400, turn()), 1..5);
    proptest!(config, |(
        axes in [axis(), axis(), axis()],
        (mut steps, feed) in line(), single: bool, far in 3_000i32..20_000, turns in turns,
    )| {
        let mut machine = Machine::new(axes, true);
        let steep = Scaled::new(STEEP);
        if single {
            steps = [0, -far, 0];
            machine.axis(1, -far, Pace::of(&axes[1]).with_ramps(steep, steep));
        } else {
            steps[2] = far;
            machine.line(steps, feed);
        }
        let mut ended = false;
        for (ms, turn) in turns {
            machine.run(ms * MS);
            match turn {
                Turn::Pause(ms) => {
                    machine.chip.set_byte("MOTION", PAUSE);
                    machine.rest();
                    let there = machine.positions();
                    machine.run(ms * MS);
                    prop_assert_eq!(machine.positions(), there, "it rests in a pause");
                    machine.chip.set_byte("MOTION", 0);
                    continue;
                }
                Turn::Stop => machine.call("motion_stop", &[]),
                Turn::Halt => machine.call("motion_halt", &[]),
            }
            ended = true;
            if turn == Turn::Halt {
                prop_assert!(!machine.moving(), "a halt ends at once");
            }
            break;
        }
        machine.finish(60);
        prop_assert_eq!(machine.chip.byte("MOTION"), 0);
        let place = machine.positions();
        prop_assert_eq!(machine.commanded(), place);
        let made = machine.steps();
        for a in 0..3 {
            let net: i32 = made[a].iter().map(|step| if step.1 { 1 } else { -1 }).sum();
            prop_assert_eq!(place[a], net, "steps of axis {}", a);
            prop_assert!(net.abs() <= steps[a].abs() && net.signum() * steps[a].signum() >= 0);
        }
        if !ended {
            prop_assert_eq!(place, steps);
        }
        if single {
            let bounds = physics::Limits {
                accel: bounds(&axes[1]).accel.min(STEEP.into()),
                decel: bounds(&axes[1]).decel.min(STEEP.into()),
                ..bounds(&axes[1])
            };
            // A halted axis may stand still from any speed: its last run is not looked at.
            let runs = runs(&made[1], REST);
            // A motion halted before its first step has none.
            let braked = runs.len().saturating_sub(usize::from(ended));
            for run in &runs[..braked] {
                prop_assert_eq!(physics::check(run, &bounds), Ok(()));
            }
        }
    });
}

#[test]
fn an_axis_that_meets_a_switch_rests_where_the_twin_does() {
    let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(10) };
    proptest!(config, |(
        axis in axis(), by in prop_oneof![-20_000..-2_000i32, 2_000..20_000i32],
        speed in 100u32..8_000, ms in 5u64..1_500, slow in 0i8..6,
    )| {
        let mut machine = Machine::new([axis; 3], true);
        let ramp = Scaled::new(60_000).shifted(-slow);
        let pace = Pace::of(&axis).with_steps(speed).with_ramps(ramp, ramp);
        machine.axis(1, by, pace);
        machine.run(ms * MS);
        prop_assume!(machine.moving());
        machine.call("motion_poll", &[]);
        let caught = machine.positions()[1];
        machine.call(
            "motion_hit",
            &[(8, 4), (12, caught as u16), (13, (caught as u32 >> 16) as u16)],
        );
        machine.finish(60);
        let rests = machine.positions()[1];
        prop_assert_eq!(machine.commanded()[1], rests);
        let net: i32 = machine.steps()[1].iter().map(|step| if step.1 { 1 } else { -1 }).sum();
        prop_assert_eq!(rests, net);
        let mut twin = Single::new(0, CLOCK);
        twin.go(&axis, by, pace);
        let mut segment = Segment::NONE;
        while twin.position().abs() < caught.abs() {
            prop_assert!(twin.next_segment(&mut segment));
        }
        if twin.hit(&axis, caught) {
            // At once: the step that was armed is made.
            prop_assert!((rests - caught).abs() <= 1, "{} {}", rests, caught);
        } else {
            while twin.next_segment(&mut segment) {}
            prop_assert_eq!(rests, twin.position());
        }
    });
}
