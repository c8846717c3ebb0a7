//! The whole image of the MSP430F5529 with both lines busy, at the top rates: no step is lost, no pulse or pause is shorter than
//! the manual says, and paths hold their rate.

mod rig;

use emulator::{Board, Format, Link, Parity, Signal, Silicon};
use lang::profile::Profile;
use lang::wire::{self, Control, RunState};
use rig::company::{Company, fast, long, send, start};
use rig::{BOOT_US, frame, off, read, write_body};

/// Steps a second that a path may have, and each of three axes on its own.
const PATH: u64 = 91_000;
/// The rate that a motion begins with.
const START: u64 = 4_000;
const ALONE: u64 = 40_000;

/// What the pins made of a run.
#[derive(Debug, Default)]
struct Made {
    /// Times of X's steps, ticks.
    steps: Vec<u64>,
    /// Longest that a step of an axis waited, between two others on a ramp or at its top rate, beyond the longer one of the
    /// intervals around it, ticks.
    pause: u64,
    /// Shortest high and low time of any STEP, ticks.
    high: u64,
    low: u64,
    ticks_per_second: u64,
}

impl Made {
    /// Steps a second between two parts of the run.
    fn rate(&self, from: f64, to: f64) -> f64 {
        let at = |part: f64| (self.steps.len() as f64 * part) as usize;
        let time = self.steps[at(to)] - self.steps[at(from)];
        (at(to) - at(from)) as f64 * self.ticks_per_second as f64 / time as f64
    }

    /// The lowest rate over 20 steps of the run's middle half.
    fn least(&self) -> f64 {
        let quarter = self.steps.len() / 4;
        let middle = &self.steps[quarter..3 * quarter];
        let longest = middle.windows(21).map(|window| window[20] - window[0]).max();
        20.0 * self.ticks_per_second as f64 / longest.unwrap_or(u64::MAX) as f64
    }
}

/// Runs a program with the lines that are to be busy so, which read 100 registers again and again.
fn run(profile: &Profile, script: &str, busy: [bool; 2]) -> Made {
    let mut board = off(Silicon::default(), profile, script);
    board.power_up();
    board.set_uart_format_on(Link::Rs485, Format { baud: 115_200, parity: Parity::None });
    board.run_us(BOOT_US);
    let before: Vec<i64> = board.plant().motors.iter().map(|motor| motor.position).collect();
    board.record(true);
    board.take_edges();
    start(&mut board);
    let mut company = Company::new(busy);
    let mut made = Made {
        high: u64::MAX,
        low: u64::MAX,
        ticks_per_second: board.ticks_per_second(),
        ..Made::default()
    };
    let (mut rose, mut fell, mut still) = ([0; 3], [0; 3], 0);
    let mut last = [[0; 3]; 3];
    while still < 400 {
        company.ask(&mut board);
        board.run_us(500);
        still += 1;
        for edge in board.take_edges() {
            let Signal::Step(axis) = edge.signal else { continue };
            let axis = usize::from(axis);
            still = 0;
            if edge.level {
                rose[axis] = edge.cycle;
                if fell[axis] != 0 {
                    made.low = made.low.min(edge.cycle - fell[axis]);
                }
                if axis == 0 {
                    made.steps.push(edge.cycle);
                }
                let [first, second, third] = last[axis];
                if first != 0 {
                    let around = (second - first).max(edge.cycle - third);
                    // At the rate that a motion begins and ends with it may also rest.
                    if around < 4 * made.ticks_per_second / 5 / START {
                        made.pause = made.pause.max((third - second).saturating_sub(around));
                    }
                }
                last[axis] = [second, third, edge.cycle];
            } else {
                fell[axis] = edge.cycle;
                made.high = made.high.min(edge.cycle - rose[axis]);
            }
        }
    }
    // The last replies.
    board.run_us(50_000);
    assert_eq!(read(&mut board, wire::RUN_STATE), Some(RunState::Ready as u16));
    assert_eq!(read(&mut board, wire::FAULT), Some(0));
    for axis in 0..3 {
        let counted = board.plant().motors[usize::from(axis)].position - before[usize::from(axis)];
        let said = long(&mut board, wire::MACHINE_POSITIONS + 2 * axis);
        assert_eq!(i64::from(said), counted, "axis {axis}: a step is lost");
    }
    made
}

/// Lines of so many steps of each of the axes, one behind the other, at the top rate.
fn lines(axes: usize, steps: u32, count: u32) -> String {
    let mm = f64::from(steps) / 100.0;
    let feed = PATH as f64 / 100.0 * 60.0 * (axes as f64).sqrt();
    let mut text = format!("G0 X0 Y0 Z0\nF{:.0}\n", feed.min(100_000.0));
    for n in 1..=count {
        text += "G1";
        for axis in &["X", "Y", "Z"][..axes] {
            text += &format!(" {axis}{:.2}", f64::from(n) * mm);
        }
        text += "\n";
    }
    text
}

/// Lines of so many steps, and how many steps a second a path of them makes on average: with both lines asking without a
/// pause, and with none (firmware/README.md, Drivers and switches).
const HELD: [(u32, [f64; 2]); 4] = [
    (250, [65_000.0, 79_000.0]),
    (500, [75_000.0, 90_900.0]),
    (1_000, [84_000.0, 90_900.0]),
    (4_000, [88_000.0, 90_900.0]),
];
/// Steps of such a path: its first 20 000 are faster, as the blocks that were planned before it began are still there.
const LONG: u32 = 240_000;
/// The same over 20 steps at any time of it.
const LEAST: f64 = 60_000.0;
/// Shortest high and low time of STEP, ns.
const HIGH_NS: u64 = 3_000;
const LOW_NS: u64 = 2_500;

fn holds_its_pulses(made: &Made, what: &str) {
    let ns = |ticks: u64| ticks * 1_000 / (made.ticks_per_second / 1_000_000);
    assert!(ns(made.high) >= HIGH_NS, "{what}: STEP is high for {} ns only", ns(made.high));
    assert!(ns(made.low) >= LOW_NS, "{what}: STEP is low for {} ns only", ns(made.low));
}

#[test]
fn a_path_holds_its_rate_while_both_lines_are_busy() {
    for axes in [1, 2, 3] {
        for (steps, [asked, alone]) in HELD {
            for (busy, most) in [([true; 2], asked), ([false; 2], alone)] {
                let made = run(&fast(PATH), &lines(axes, steps, LONG / steps), busy);
                let what = format!("{axes} axes, lines of {steps} steps, busy: {busy:?}");
                holds_its_pulses(&made, &what);
                assert_eq!(made.steps.len(), LONG as usize, "{what}");
                // Without the ramps at both ends.
                let rate = made.rate(0.25, 0.75);
                assert!(rate >= most, "{what}: {rate:.0} steps/s");
                let least = made.least();
                assert!(least >= LEAST, "{what}: {least:.0} steps/s over 20 of them");
            }
        }
    }
}

#[test]
fn axes_on_their_own_hold_their_rate_while_both_lines_are_busy() {
    let script = |axes: usize| -> String {
        let axes = &["X", "Y", "Z"][..axes];
        let starts = axes.iter().map(|axis| format!("START MoveAxe {axis}, 600mm\n"));
        let waits = axes.iter().map(|axis| format!("WaitMove {axis}\n"));
        starts.chain(waits).collect()
    };
    for axes in [1, 2, 3] {
        let made = run(&fast(ALONE), &script(axes), [true; 2]);
        let what = format!("{axes} axes on their own");
        holds_its_pulses(&made, &what);
        assert_eq!(made.steps.len(), 60_000, "{what}");
        // Without its ramps.
        let least = made.least();
        assert!(least >= 0.99 * ALONE as f64, "{what}: {least:.0} steps/s over 20 of them");
    }
}

/// Longest that a step of axes on their own waits on a ramp while both lines ask without a pause, us: of one, two, three of them
/// (firmware/README.md, Drivers and switches).
const PAUSES_US: [u64; 3] = [100, 400, 750];

#[test]
fn axes_on_their_own_pause_on_ramps_no_longer_than_the_manual_says() {
    for (count, most) in (1..).zip(PAUSES_US) {
        let axes = &["X", "Y", "Z"][..count];
        let mut script = String::new();
        for mm in [60, 0].repeat(6) {
            script.extend(axes.iter().map(|axis| format!("START MoveAxe {axis}, {mm}mm\n")));
            script.extend(axes.iter().map(|axis| format!("WaitMove {axis}\n")));
        }
        let made = run(&fast(ALONE), &script, [true; 2]);
        holds_its_pulses(&made, "ramps");
        let us = made.pause / (made.ticks_per_second / 1_000_000);
        println!("{count} axes pause {us} us");
        assert!(us <= most, "{count} axes pause {us} us");
    }
}

/// The program waits while the engine needs segments, but never for a path that rests.
#[test]
fn a_path_pauses_goes_on_and_stops() {
    let mut board = off(Silicon::default(), &fast(PATH), &lines(3, 500, 120));
    board.power_up();
    board.run_us(BOOT_US);
    start(&mut board);
    board.run_us(300_000);
    let state = |board: &mut Board| read(board, wire::RUN_STATE);
    for (control, wanted) in [
        (Control::Pause, RunState::Paused),
        (Control::Resume, RunState::Running),
        (Control::Pause, RunState::Paused),
        (Control::Resume, RunState::Running),
        (Control::Stop, RunState::Ready),
    ] {
        send(&mut board, Link::Host, &frame(&write_body(wire::RUN_CONTROL, control as u16)));
        board.run_us(if wanted == RunState::Running { 20_000 } else { 700_000 });
        assert_eq!(state(&mut board), Some(wanted as u16), "{control:?}");
    }
}
