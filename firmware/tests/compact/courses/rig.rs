//! Courses of lines whose slow points this test computes, on the running image, and what its pins show of them.

use emulator::plant::Contact;
use emulator::{Board, Signal};
use firmware::motion::scaled::Scaled;
use lang::back::{self, Courses, disasm};
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::image::Image;
use lang::image::course::{Entry, record};
use lang::profile::Profile;
use lang::record::{AxisRecord, BoardRecord, MachineRecord};
use lang::wire::{CRC_START, Control, RUN_CONTROL, RunState, TraceKind, crc16};

use crate::chip::{BOOT_US, Chip};
use crate::rig::{COMMITTED, IMAGE, PROFILE, SLOT, T_FULL, T_HEARD, T_ON};

/// Cycles in a second.
pub(super) const HZ: f64 = 16_000_000.0;
/// What the host wants of a corner: speeds at which an axis may bend, as a share of its ramp over this time, s.
const BEND: f64 = 0.01;
/// The least time that a line takes, s: [`G2553`] plans the next one meanwhile.
pub(super) const LEAST: f64 = 0.007;

/// A line: where it ends, steps; its length, um; the speed at its end, um/s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) to: [i32; 3],
    pub(super) from: [i32; 3],
    pub(super) length: f64,
    pub(super) exit: f64,
    pub(super) top: f64,
}

/// The machine whose lines these are.
pub(super) struct Mill {
    pub(super) profile: Profile,
    pub(super) axes: [AxisRecord; 3],
    /// The least time that a line takes, s.
    pub(super) least: f64,
}

/// The built-in `mill` that need not be homed.
pub(super) fn mill() -> Mill {
    let mut profile = Profile::built_in("mill").expect("mill is built in");
    profile.require_homing = false;
    let axes = MachineRecord::of(&profile).axes;
    Mill { profile, axes, least: LEAST }
}

impl Mill {
    /// Each step so many times finer.
    pub(super) fn finer(&mut self, times: u32) {
        for axis in
            [&mut self.profile.x, &mut self.profile.y, &mut self.profile.z].into_iter().flatten()
        {
            axis.scale.steps *= times as u16;
            for rate in [&mut axis.top_rate, &mut axis.accel, &mut axis.start_rate] {
                *rate *= times as i32;
            }
            axis.decel = axis.decel.map(|decel| decel * times as i32);
        }
        self.axes = MachineRecord::of(&self.profile).axes;
    }

    fn steps(&self, place: [f64; 3]) -> [i32; 3] {
        let scale = |axis: &AxisRecord| f64::from(axis.steps) / f64::from(axis.um);
        [0, 1, 2].map(|a| ((place[a] * 1000.0).round() * scale(&self.axes[a])).round() as i32)
    }

    /// Um in a step.
    pub(super) fn um(&self, a: usize) -> f64 {
        f64::from(self.axes[a].um) / f64::from(self.axes[a].steps)
    }

    /// Lines through these places, mm, from 0, at a feed in um/s.
    pub(super) fn lines(&self, places: &[[f64; 3]], feed: f64) -> Vec<Line> {
        let mut from = [0; 3];
        let mut lines = Vec::new();
        for to in places.iter().map(|place| self.steps(*place)) {
            if to == from {
                continue;
            }
            let way = [0, 1, 2].map(|a| f64::from(to[a] - from[a]) * self.um(a));
            let length = way.iter().map(|way| way * way).sum::<f64>().sqrt();
            let most = |rate: &dyn Fn(&AxisRecord) -> u32| {
                (0..3)
                    .filter(|a| way[*a] != 0.0)
                    .map(|a| f64::from(rate(&self.axes[a])) * self.um(a) * length / way[a].abs())
                    .fold(f64::MAX, f64::min)
            };
            let top = most(&|axis| axis.top_rate).min(feed).min(length / self.least);
            lines.push(Line { to, from, length, exit: 0.0, top });
            from = to;
        }
        for n in 0..lines.len().saturating_sub(1) {
            lines[n].exit = self.corner(&lines[n], &lines[n + 1]).min(lines[n].top);
            lines[n].exit = lines[n].exit.min(lines[n + 1].top);
        }
        for n in (1..lines.len()).rev() {
            // A little less than the machine's: it plans its ramps lower by a 32nd.
            let fall = 2.0 * self.ramp(&lines[n], |axis| axis.decel) * 0.96 * lines[n].length;
            let start = self.ramp(&lines[n], |axis| axis.start_rate.into());
            let end = lines[n].exit.max(start);
            lines[n - 1].exit = lines[n - 1].exit.min((end * end + fall).sqrt());
        }
        lines
    }

    /// The least of the axes' along a line, um.
    pub(super) fn ramp(&self, line: &Line, of: impl Fn(&AxisRecord) -> u32) -> f64 {
        (0..3)
            .filter(|a| line.to[*a] != line.from[*a])
            .map(|a| {
                let way = f64::from(line.to[a] - line.from[a]).abs() * self.um(a);
                f64::from(of(&self.axes[a])) * self.um(a) * line.length / way
            })
            .fold(f64::MAX, f64::min)
    }

    /// The speed at which no axis bends by more than its ramp does in [`BEND`].
    fn corner(&self, one: &Line, two: &Line) -> f64 {
        let unit =
            |line: &Line, a: usize| f64::from(line.to[a] - line.from[a]) * self.um(a) / line.length;
        (0..3)
            .map(|a| {
                let bend = (unit(one, a) - unit(two, a)).abs();
                let ramp = f64::from(self.axes[a].accel) * self.um(a);
                if bend == 0.0 { f64::MAX } else { ramp * BEND / bend }
            })
            .fold(f64::MAX, f64::min)
    }
}

/// A speed's square as an entry has it.
pub(super) fn bound(speed: f64) -> u16 {
    (Scaled::new((speed * speed) as u32).0 >> 16) as u16
}

/// A slow point for each line, the last one's too: a record that ended before it would begin anew with it in a loop.
pub(super) fn each(lines: &[Line]) -> Vec<u8> {
    let entry = |line: &Line| Entry { lines: 1, holds: false, bound: bound(line.exit), joins: 0 };
    record(&lines.iter().map(entry).collect::<Vec<_>>())
}

/// G1 statements to places, mm.
pub(super) fn script(places: &[[f64; 3]], feed: f64) -> String {
    let mut text = format!("G90\nF{}\n", (feed * 60.0 / 1000.0).round());
    let mut last = [0.0; 3];
    for place in places {
        let words: Vec<String> = (0..3)
            .filter(|a| place[*a] != last[*a])
            .map(|a| format!("{}{:.3}", ["X", "Y", "Z"][a], place[a]))
            .collect();
        if !words.is_empty() {
            text += &format!("G1 {}\n", words.join(" "));
        }
        last = *place;
    }
    text
}

/// The image of a script in which one course begins with the first G1.
pub(super) fn image(mill: &Mill, script: &str, record: Vec<u8>) -> Vec<u8> {
    let source = Source::new("test.bas", script.to_owned());
    let choice = ProfileChoice::Given(Box::new(mill.profile.clone()));
    let (program, diags) = compile(&source, choice);
    let program = program.unwrap_or_else(|| panic!("{script}: {diags:?}"));
    let plain = back::compile(&program).expect("it fits");
    let insns = disasm::instructions(&Image::new(&plain.image).expect("an image"));
    let first = insns.iter().find(|insn| insn.text.starts_with("line")).expect("a line");
    let courses = Courses { pool: firmware::WHOLE.course_pool, records: vec![(first.pc, record)] };
    back::compile_with(&program, &courses).expect("it fits").image
}

/// Reads speeds and places, which takes the board longest: 24 registers from 2400 on.
const REQUEST: [u8; 6] = [1, 3, 0x09, 0x60, 0, 24];
/// Cycles from one request to the next: the reply has just gone.
const BUSY: u64 = 16 * 7_000;

/// A step: its instant, the axis, whether in positive direction.
pub(super) type Step = (u64, usize, bool);

/// The board that runs by itself, its edges recorded.
pub(super) struct Mover {
    pub(super) board: Board,
    pub(super) steps: Vec<Step>,
    dirs: [bool; 3],
    /// A host that asks again as soon as it has its answer: instant of the next request.
    pub(super) storm: Option<u64>,
    /// Bytes of its replies.
    pub(super) replies: usize,
}

impl Mover {
    pub(super) fn new(mill: &Mill, image: &[u8]) -> Mover {
        let mut board = Chip::new().board;
        let mut put = |first: u16, bytes: &[u8]| {
            for (address, &byte) in (first..).zip(bytes) {
                board.poke8(address, byte);
            }
        };
        put(SLOT, &COMMITTED.to_le_bytes());
        put(IMAGE, image);
        put(PROFILE, &BoardRecord::of(&mill.profile, 1).to_bytes());
        board.reset_pin();
        board.run_us(BOOT_US + 500_000);
        let mut mover =
            Mover { board, steps: Vec::new(), dirs: [false; 3], storm: None, replies: 0 };
        assert_eq!(mover.state(), RunState::Ready, "refused {}", mover.byte("REFUSAL"));
        mover.board.record(true);
        mover.board.clear_stats();
        mover.take();
        mover
    }

    /// Address of a symbol.
    pub(super) fn at(&self, symbol: &str) -> u16 {
        self.board.symbol(symbol).unwrap_or_else(|| panic!("the image has no {symbol}"))
    }

    pub(super) fn byte(&self, symbol: &str) -> u8 {
        self.board.peek8(self.at(symbol))
    }

    /// The three 32-bit values at a symbol.
    pub(super) fn longs(&self, symbol: &str) -> [i32; 3] {
        let word = |at: u16| u32::from(self.board.peek16(at));
        let at = self.at(symbol);
        [0, 4, 8].map(|n| (word(at + n + 2) << 16 | word(at + n)).cast_signed())
    }

    pub(super) fn state(&self) -> RunState {
        RunState::from_number(self.byte("RUN").into()).expect("a run state")
    }

    /// Where the motors stand, steps.
    pub(super) fn motors(&self) -> [i32; 3] {
        [0, 1, 2].map(|n| self.board.plant().motors[n].position as i32)
    }

    fn take(&mut self) {
        for edge in self.board.take_edges() {
            match edge.signal {
                Signal::Dir(a) => {
                    let inverted = self.board.plant().motors[usize::from(a)].inverted;
                    self.dirs[usize::from(a)] = edge.level != inverted;
                }
                Signal::Step(a) if edge.level => {
                    let a = usize::from(a);
                    self.steps.push((edge.cycle, a, self.dirs[a]));
                }
                _ => {}
            }
        }
    }

    pub(super) fn run_us(&mut self, us: u64) {
        let end = self.board.cycles() + 16 * us;
        while self.board.cycles() < end {
            let mut until = end;
            if let Some(due) = self.storm {
                if due <= self.board.cycles() {
                    self.ask(&REQUEST);
                    self.storm = Some(due + BUSY);
                    self.replies += self.board.uart_take().len();
                }
                until = end.min(due + BUSY);
            }
            self.board.run_until(until);
        }
        self.take();
    }

    /// Sends a request, without its CRC.
    pub(super) fn ask(&mut self, body: &[u8]) {
        let crc = body.iter().fold(CRC_START, |crc, &byte| crc16(crc, byte));
        self.board.uart_send(&[body, &crc.to_le_bytes()].concat());
    }

    /// The answer to a request, without its CRC.
    pub(super) fn answer(&mut self, body: &[u8]) -> Vec<u8> {
        self.board.uart_take();
        self.ask(body);
        self.run_us(30_000);
        let mut reply: Vec<u8> = self.board.uart_take().iter().map(|byte| byte.1).collect();
        reply.truncate(reply.len().saturating_sub(2));
        reply
    }

    /// All axes are homed.
    pub(super) fn home(&mut self) {
        self.board.poke8(self.at("HOMED"), 7);
    }

    /// Motors of these axes, bit per axis, turn the other way.
    pub(super) fn wire(&mut self, inverted: u8) {
        for (a, motor) in self.board.plant_mut().motors.iter_mut().enumerate() {
            motor.inverted = inverted & 1 << a != 0;
            self.dirs[a] = motor.inverted;
        }
    }

    /// Power fails and comes back; somebody moves the axes to where they began.
    pub(super) fn power_cut(&mut self) {
        self.board.power_cut();
        self.board.power_up();
        for motor in &mut self.board.plant_mut().motors {
            motor.position = 0;
        }
        self.board.run_us(BOOT_US + 500_000);
        self.take();
        self.steps.clear();
    }

    /// A host traces from here on.
    pub(super) fn trace(&mut self) {
        self.board.poke8(self.at("TRACING"), *T_ON | *T_HEARD);
    }

    /// Presses Start.
    pub(super) fn start(&mut self) {
        self.board.plant_mut().press_start(true);
        self.run_us(30_000);
        self.board.plant_mut().press_start(false);
    }

    /// As a host commands; taken when it comes back.
    pub(super) fn control(&mut self, control: Control) {
        let [high, low] = RUN_CONTROL.to_be_bytes();
        let body = [1, 6, high, low, 0, control as u8];
        // A start checks the program first.
        let mut answer = self.answer(&body);
        if answer.is_empty() {
            self.run_us(400_000);
            answer = self.board.uart_take().iter().map(|byte| byte.1).collect();
            answer.truncate(6);
        }
        assert_eq!(answer, body, "{control:?} in {:?}", self.state());
    }

    /// A contact of an axis as its reference switch.
    pub(super) fn switch(&mut self, axis: usize, position: i64, above: bool) {
        let contact = Contact { axis, position, above };
        self.board.plant_mut().switches[axis] = Some(contact);
    }

    /// Takes events until the run has ended: their kinds.
    pub(super) fn traced(&mut self, seconds: u64) -> Vec<u8> {
        let mut kinds = Vec::new();
        let at = self.at("TRACING");
        for _ in 0..seconds * 1000 {
            self.run_us(1_000);
            let flags = self.board.peek8(at) | *T_HEARD;
            if flags & *T_FULL != 0 && self.board.peek16(self.at("TRACE_NUMBER")) != 0 {
                kinds.push(self.byte("TRACE_KIND"));
            }
            self.board.poke8(at, flags & !*T_FULL);
            if kinds.last() == Some(&(TraceKind::End as u8)) {
                return kinds;
            }
        }
        panic!("no end: {kinds:?} at {:?}", self.motors());
    }

    /// Until the run has ended.
    pub(super) fn end(&mut self, seconds: u64) {
        for _ in 0..seconds * 100 {
            if self.byte("LAST_END") != 0 && self.byte("MOVING") == 0 {
                return;
            }
            self.run_us(10_000);
        }
        panic!("no end: {:?} at {:?}", self.state(), self.motors());
    }
}

/// A place along a path: instant, s; way, um; line.
type Sample = (f64, f64, usize);

/// The steps of an axis that a line makes, with the line's number.
fn planned(lines: &[Line], a: usize) -> Vec<(usize, bool)> {
    let steps = |(n, line): (usize, &Line)| {
        let by = line.to[a] - line.from[a];
        vec![(n, by > 0); by.unsigned_abs() as usize]
    };
    lines.iter().enumerate().flat_map(steps).collect()
}

/// Every step of the path was made, in order; or those up to a stop.
pub(super) fn in_order(steps: &[Step], lines: &[Line], whole: bool) {
    for a in 0..3 {
        let planned = planned(lines, a);
        let made: Vec<bool> = steps.iter().filter(|step| step.1 == a).map(|step| step.2).collect();
        assert!(made.len() <= planned.len(), "axis {a}: {} of {}", made.len(), planned.len());
        let wrong = made.iter().zip(&planned).position(|(made, (_, planned))| made != planned);
        assert_eq!(wrong, None, "axis {a}: a step in the wrong direction");
        assert!(!whole || made.len() == planned.len(), "axis {a}: {} steps", made.len());
    }
}

/// Where the path is when: the steps of each line's axis with most of them.
fn samples(steps: &[Step], lines: &[Line]) -> Vec<Sample> {
    let by = |line: &Line, a: usize| (line.to[a] - line.from[a]).unsigned_abs() as usize;
    let mut begins = Vec::new();
    let mut way = 0.0;
    for line in lines {
        begins.push(way);
        way += line.length;
    }
    let mut samples = Vec::new();
    for a in 0..3 {
        let planned = planned(lines, a);
        let made = steps.iter().filter(|step| step.1 == a);
        let mut nth = 0;
        let mut last = usize::MAX;
        for (step, (n, _)) in made.zip(planned) {
            nth = if n == last { nth + 1 } else { 0 };
            last = n;
            let line = &lines[n];
            let most = (0..3).map(|b| by(line, b)).max().unwrap_or(0);
            if by(line, a) == most {
                let share = (nth as f64 + 0.5) / most as f64;
                samples.push((step.0 as f64 / HZ, begins[n] + share * line.length, n));
            }
        }
    }
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    samples
}

/// What a path made of its ramps and speeds.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Made {
    /// Highest speed, um/s.
    pub(super) top: f64,
    /// Strongest ramps, as shares of what the profile allows.
    pub(super) up: f64,
    pub(super) down: f64,
    /// From the first step to the last, s.
    pub(super) time: f64,
}

/// Ramps over windows of at least 20 events and of 20 ms; where steps of two axes meet, one of them may come a
/// step's time off, which is taken from what is found.
pub(super) fn judge(mill: &Mill, steps: &[Step], lines: &[Line]) -> Made {
    let samples = samples(steps, lines);
    let mut made = Made::default();
    let (first, last) = (samples[0].0, samples[samples.len() - 1].0);
    made.time = last - first;
    let reach = |from: usize| {
        (from + 10..samples.len()).find(|to| samples[*to].0 - samples[from].0 >= 0.02)
    };
    let jitter =
        if lines.iter().all(|line| (0..3).filter(|a| line.to[*a] != line.from[*a]).count() == 1) {
            0.0
        } else {
            12.0
        };
    for from in 0..samples.len() {
        let Some(middle) = reach(from) else { break };
        let Some(to) = reach(middle) else { break };
        let speed =
            |a: usize, b: usize| (samples[b].1 - samples[a].1) / (samples[b].0 - samples[a].0);
        let (one, two) = (speed(from, middle), speed(middle, to));
        made.top = made.top.max(one);
        let time = (samples[to].0 - samples[from].0) / 2.0;
        let slack = 2.0 * jitter / (time * time);
        let within = &lines[samples[from].2..=samples[to].2];
        let ramp = within.iter().map(|line| mill.ramp(line, |axis| axis.accel)).fold(0.0, f64::max);
        let share = ((two - one).abs() / time - slack) / ramp;
        if two > one { made.up = made.up.max(share) } else { made.down = made.down.max(share) }
    }
    made
}

/// When each line was halfway, s.
pub(super) fn passes(steps: &[Step], lines: &[Line]) -> Vec<f64> {
    let samples = samples(steps, lines);
    let mut way = 0.0;
    let mut times = Vec::new();
    for line in lines {
        let half = way + line.length / 2.0;
        times.extend(samples.iter().find(|sample| sample.1 >= half).map(|sample| sample.0));
        way += line.length;
    }
    times
}
