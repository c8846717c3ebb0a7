//! The running image with a busy host, and what is planned for its motions.

use emulator::{Signal, Stop, TICKS_PER_SECOND};
use firmware::motion::scaled::Scaled;
use firmware::motion::{Block, Feed, Manner, Pace, Path, PathSegment, Segment, Single};
use lang::record::{AxisRecord, MachineRecord};
use lang::wire::{CRC_START, crc16};

use crate::chip::{BOOT_US, CLOCK, Chip};
use crate::line::{aim, feed_word, in_the_unit_of};
use crate::machine::{install, mill};

/// Zero flag of the status register.
const ZERO: u16 = 2;
/// The machine stack's end.
const STACK: u16 = 0x0400;
/// Vector of Timer1_A CCR0.
pub(super) const STEP: u16 = 0xFFFA;
/// General interrupt enable of the status register.
const GIE: u16 = 8;
pub(super) const MS: u64 = TICKS_PER_SECOND / 1_000;
/// Registers read while axes move: the positions.
const POSITIONS: u16 = 2400;

/// A step: its instant in ticks, and whether it went in positive direction.
pub(super) type Step = (u64, bool);

/// The running image.
pub(super) struct Machine {
    pub(super) chip: Chip,
    pub(super) axes: [AxisRecord; 3],
    /// Instant of the next request of a host that never rests, if there is one.
    pub(super) request: Option<u64>,
    /// Bytes of its replies.
    pub(super) replies: usize,
    /// Levels of the DIR pins.
    dirs: [bool; 3],
}

impl Machine {
    /// A board that has come up, with these axes, and with a busy host or none.
    pub(super) fn new(axes: [AxisRecord; 3], host: bool) -> Machine {
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
    pub(super) fn run(&mut self, ticks: u64) {
        let end = self.chip.board.cycles() + ticks;
        while self.chip.board.cycles() < end {
            self.run_some(end);
        }
    }

    /// The image runs to a breakpoint; `false`: it does not come there in so many ticks.
    pub(super) fn run_to(&mut self, place: u16, ticks: u64) -> bool {
        self.chip.board.set_breakpoint(place);
        let end = self.chip.board.cycles() + ticks;
        let mut stop = Stop::Time;
        while self.chip.board.cycles() < end && stop != Stop::Breakpoint(place.into()) {
            stop = self.run_some(end);
        }
        self.chip.board.clear_breakpoint(place);
        stop == Stop::Breakpoint(place.into())
    }

    /// The image runs to the host's next request, and no further than `end`.
    fn run_some(&mut self, end: u64) -> Stop {
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
        self.chip.board.run_until(until)
    }

    /// Calls a routine from the main loop, with interrupts on, between two passes.
    pub(super) fn call(&mut self, routine: &str, registers: &[(usize, u16)]) {
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
    pub(super) fn line(&mut self, steps: [i32; 3], feed: Feed) -> Plan {
        let from = self.positions();
        aim(&mut self.chip, from, [0, 1, 2].map(|n| from[n] + steps[n]));
        self.chip.set_long("FEED", 0, feed_word(feed));
        let begin = if feed == Feed::Rapid { "line_rapid" } else { "line_begin" };
        self.call(begin, &[(12, 7)]);
        Plan::line(self.chip.word("STEP_FRAC").into(), &self.axes, steps, feed)
    }

    /// Begins a motion of one axis at its own pace. Returns what is planned for it.
    pub(super) fn axis(&mut self, n: u16, steps: i32, pace: Pace) -> Plan {
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

    pub(super) fn positions(&self) -> [i32; 3] {
        [0, 4, 8].map(|at| self.chip.long("ACTUAL", at) as i32)
    }

    pub(super) fn commanded(&self) -> [i32; 3] {
        [0, 4, 8].map(|at| self.chip.long("STEPS", at) as i32)
    }

    pub(super) fn moving(&self) -> bool {
        self.chip.byte("MOVING") != 0
    }

    /// Lets the motion come to its end.
    pub(super) fn finish(&mut self, seconds: u64) {
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
    pub(super) fn steps(&mut self) -> [Vec<Step>; 3] {
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

    /// Waits until no step comes any more.
    pub(super) fn rest(&mut self) {
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

/// The steps of segments: the engine's definition in plain Rust. `time` is in 1/65536 ticks and
/// begins with the fraction that the motion before left.
#[derive(Default)]
pub(super) struct Plan {
    pub(super) steps: [Vec<Step>; 3],
    time: u64,
    acc: [u32; 3],
}

impl Plan {
    pub(super) fn play(&mut self, ramp: &Segment, inc: [u32; 3], negative: u8) {
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

    pub(super) fn line(from: u64, axes: &[AxisRecord; 3], steps: [i32; 3], feed: Feed) -> Plan {
        let (feed, axes) = &in_the_unit_of(feed, *axes);
        let mut path = Path::new(0, CLOCK);
        let manner = Manner::new(*feed, true);
        path.push_ending(axes, &Block { steps, um: [0; 3], manner }, Scaled::ZERO);
        let mut plan = Plan { time: from, acc: [1 << 31; 3], ..Plan::default() };
        let mut segment = PathSegment::default();
        while path.next_segment(axes, &mut segment) {
            plan.play(&segment.ramp, segment.inc, segment.negative);
        }
        plan
    }

    pub(super) fn axis(from: u64, axis: &AxisRecord, n: u16, steps: i32, pace: Pace) -> Plan {
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
