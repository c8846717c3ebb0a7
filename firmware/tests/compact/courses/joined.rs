//! Lines that are too short to be planned one by one, at the pins of the running image.

use lang::image::course::{Entry, record};
use lang::part::G2553;
use lang::wire::{self, Control, End};

use super::rig::{Line, Mill, Mover, bound, image, in_order, mill, script};
use super::{Place, chords, ended, overridden, paused_twice, ramped, stopped_at_once, whole};

/// A straight way of so many lines, of which the chip joins some: the first is made alone.
struct Way {
    by: Place,
    each: u32,
    count: u32,
    feed: f64,
}

impl Way {
    /// Four lines of 0.05 mm at F3000 are one.
    fn in_x() -> Way {
        Way { by: [0.05, 0.0, 0.0], each: 4, count: 1001, feed: 50_000.0 }
    }

    fn axes(&self) -> usize {
        self.by.iter().filter(|by| **by != 0.0).count()
    }

    /// The least time that a line which is made lasts, s: the next one and all that are joined to it are planned meanwhile, its first segment takes
    /// 0.7 ms, and each step's interrupts 12 us from all that.
    fn least(&self) -> f64 {
        let n = self.axes() - 1;
        let us = 700.0
            + f64::from(G2553.course_us[n])
            + f64::from((self.each - 1) * u32::from(G2553.join_us[n]));
        let most = self.by.iter().fold(0.0, |most, by| f64::max(most, by.abs() * 100.0));
        (us + 12.0 * most * f64::from(self.each)) / 1e6
    }

    /// A board whose program makes it, and its lines as the chip makes them.
    fn board(&self, mill: &Mill, script: &str) -> (Mover, Vec<Line>) {
        let places = chords(self.count, self.by);
        let made = places.iter().copied().step_by(self.each as usize).collect::<Vec<_>>();
        let lines = mill.lines(&made, self.feed);
        let joins = ((self.each - 1) as usize * self.axes()) as u8;
        let last = lines.len() - 1;
        let entry = |n: usize, line: &Line| Entry {
            lines: 1,
            holds: false,
            bound: if n == last { 0 } else { bound(line.exit) },
            joins: if n == last { 0 } else { joins },
        };
        let entries: Vec<_> = lines.iter().enumerate().map(|(n, line)| entry(n, line)).collect();
        (Mover::new(mill, &image(mill, script, record(&shorter(&entries)))), lines)
    }

    /// Of relative lines in a loop.
    fn in_a_loop(&self, mill: &Mill) -> (Mover, Vec<Line>) {
        let words = script(&[self.by], self.feed);
        let (head, line) = words.split_at(words.find("G1").expect("a line"));
        let text = format!("{head}G91\nREPEAT {}\n{line}END REPEAT\n", self.count);
        self.board(mill, &text)
    }
}

/// Entries that are alike as one that holds.
fn shorter(entries: &[Entry]) -> Vec<Entry> {
    let mut few: Vec<Entry> = Vec::new();
    for entry in entries {
        match few.last_mut() {
            Some(last)
                if last.bound == entry.bound && last.joins == entry.joins && last.lines < 100 =>
            {
                (last.lines, last.holds) = (last.lines + 1, true);
            }
            _ => few.push(*entry),
        }
    }
    few
}

/// The pace of the host's slow points, while a host asks without a pause.
#[test]
fn joined_lines_as_short_as_the_host_makes_them_come_in_time() {
    for (by, each) in [([0.05, 0.0, 0.0], 4), ([0.0, 0.04, 0.05], 3), ([0.05, 0.04, 0.04], 2)] {
        for phase in 0..3 {
            let way = Way { by, each, count: 1 + 150 * each, feed: 50_000.0 };
            let mut mill = mill();
            mill.least = way.least();
            let (mut mover, lines) = way.in_a_loop(&mill);
            mover.start();
            mover.run_us(20_000 + phase * 1_000);
            mover.storm = Some(mover.board.cycles());
            mover.end(20);
            let made = whole(&mill, &mover, &lines);
            assert!(mover.replies > 100 && made.time < 1.3 * 150.0 * mill.least, "{made:?}");
        }
    }
}

#[test]
fn lines_are_joined_in_any_number_and_as_statements_of_their_own() {
    for (each, count) in [(2, 301), (3, 400), (4, 393)] {
        let way = Way { each, count, ..Way::in_x() };
        let mut mill = mill();
        mill.least = way.least();
        let statements = script(&chords(count, way.by), way.feed);
        for (mut mover, lines) in [way.in_a_loop(&mill), way.board(&mill, &statements)] {
            mover.start();
            mover.end(30);
            whole(&mill, &mover, &lines);
            assert_eq!((mover.byte("JOINS"), mover.longs("UM")[0]), (0, 50 * count as i32));
        }
    }
}

#[test]
fn a_pause_among_joined_lines_loses_nothing() {
    let (way, mill) = (Way::in_x(), mill());
    for at in (30..600).step_by(45) {
        let (mut mover, lines) = way.in_a_loop(&mill);
        mover.start();
        mover.run_us(at * 1000 + at);
        paused_twice(&mut mover, 150_000);
        mover.end(20);
        whole(&mill, &mover, &lines);
    }
}

#[test]
fn a_stop_among_joined_lines_ends_the_run_where_it_brakes() {
    let (way, mill) = (Way { count: 401, ..Way::in_x() }, mill());
    let text = format!("G90\nG0 X0\n{}", script(&chords(way.count, way.by), way.feed));
    for at in (62..480).step_by(37) {
        let (mut mover, lines) = way.board(&mill, &text);
        mover.start();
        mover.run_us(at * 1000 + at);
        // In a pause, too, where none of what was joined is left behind.
        if at % 4 == 1 {
            mover.control(Control::Pause);
            mover.run_us(200_000);
        }
        mover.control(Control::Stop);
        mover.end(5);
        mover.run_us(100_000);
        ended(&mover, End::Stopped, None);
        let here = (mover.byte("JOINS"), mover.longs("UM")[0]);
        assert_eq!(here, (0, mover.motors()[0] * 10), "{at}");
        in_order(&mover.steps, &lines, false);
        ramped(&mill, &mover, &lines);
        mover.control(Control::Start);
        mover.end(20);
        ended(&mover, End::Done, None);
        assert_eq!(mover.motors(), lines[lines.len() - 1].to, "{at}");
    }
}

#[test]
fn an_emergency_stop_among_joined_lines_ends_the_steps_at_once() {
    let (way, mill) = (Way::in_x(), mill());
    for at in [41, 202, 337, 610] {
        let (mut mover, lines) = way.in_a_loop(&mill);
        mover.start();
        mover.run_us(at * 1000);
        stopped_at_once(&mut mover, &lines);
    }
}

#[test]
fn another_override_is_taken_among_joined_lines() {
    let (way, mill) = (Way { count: 2001, ..Way::in_x() }, mill());
    let (mut mover, lines) = way.in_a_loop(&mill);
    mover.start();
    overridden(&mill, &mut mover, &lines, &[100, 60, 200, 25, 140, 10, 37, 100]);
}

/// A host that reads much at once, of what takes long to tell: the state of the run, all of the device's own, bits.
#[test]
fn no_question_of_a_host_makes_a_line_late() {
    let read = |function: u8, first: u16, count: u8| {
        let [high, low] = first.to_be_bytes();
        [1, function, high, low, 0, count]
    };
    let run = (wire::COMMANDED - wire::RUN_STATE) as u8;
    let questions = [
        read(3, wire::RUN_STATE, run),
        read(3, wire::VERSION, 100),
        read(1, wire::COILS, 16),
        read(2, wire::INPUT_BITS, 17),
    ];
    for (question, each) in questions.into_iter().flat_map(|own| [(own, 1), (own, 4)]) {
        let way = Way { each, count: 1 + 150 * each, ..Way::in_x() };
        let mut mill = mill();
        mill.least = way.least();
        let (mut mover, lines) = way.in_a_loop(&mill);
        mover.start();
        let mut replies = 0;
        while mover.byte("LAST_END") == 0 {
            mover.ask(&question);
            mover.run_us(12_000 + 1_000 * u64::from(question[5]) + 370 * (replies % 11));
            replies += u64::from(!mover.board.uart_take().is_empty());
        }
        assert!(replies > 4, "{question:?}: {replies}");
        whole(&mill, &mover, &lines);
    }
}
