//! Whether the pins do what the board says: TA2 of the MSP430F5529 counts and times edges through wires from them.

use std::time::Duration;

use lang::axis::Axis;
use lang::fault::Fault;
use lang::part::pins::{self, Pin};
use lang::record::{BoardRecord, MoreRecord};
use lang::wire::{self, Control, command};

use super::{Ask, Bench, Trouble};
use crate::client::orders::words;
use crate::link::Link;

/// Ticks of a microsecond: cycles of 25 MHz.
const PER_US: f64 = 25.0;
/// Bits of [`wire::MEASURE`]: count, capture, ticks of eight cycles; edges at P2.3 and P2.4.
const COUNT: u16 = 1;
const CAPTURE: u16 = 2;
const SLOW: u16 = 1 << 3;
const RISING: u16 = 1;
const FALLING: u16 = 2;
const BOTH: u16 = 3;
const FIRST: u16 = 4;
const SECOND: u16 = 6;
/// DIR stands for so long behind a pulse, us.
const HOLD_US: f64 = 1.0;
/// Steps a second of the move that an emergency stop ends.
const SPEED: i64 = 20_000;
/// How often: of a board that stops by its millisecond alone one of five comes this early once in 10 000 tests.
const STOPS: u32 = 5;
/// Frequency of the PWM that presses the stop at a pin, Hz: its periods are no multiple of the board's millisecond.
const STOP_HZ: u16 = 97;
/// Ramp of the fast moves, steps/s2.
const STEEP: i64 = 300_000;
/// Period of the pulses that are timed at the PWM's pin, us, and their width.
const PERIOD_US: f64 = 2_000.0;
const SERVO_US: u16 = 1_000;

/// What was found: samples or edges, shortest and longest of both ways, the last.
struct Found {
    count: u16,
    there: [u16; 2],
    back: [u16; 2],
    last: i16,
}

/// A pin as a person finds it: its name and its place at the header.
fn at(pin: Pin) -> String {
    format!("P{}.{} ({})", pin.port, pin.bit, pin.at)
}

impl<L: Link> Bench<'_, L> {
    pub(super) fn captures(&mut self) -> Result<(), Trouble> {
        const CHECK: &str = "pulses, widths and times at the pins";
        if !self.plan.captures || !self.plan.unplugged {
            self.left_out(
                CHECK,
                "--unplugged and --captures say that somebody wires pins to P2.2 to P2.4",
            );
            return Ok(());
        }
        if !self.has_crystal() {
            self.left_out(CHECK, "this chip has no timer left for it");
            return Ok(());
        }
        let usual = self.record;
        // What is wired to P2.4 is no limit switch and no probe.
        self.set_record(BoardRecord { reference: [0; 3], probe: 0, ..usual })?;
        let [step, dir, pwm] = [pins::STEP[0], pins::DIR[0], pins::PWM].map(at);
        let [counted, first, second] =
            [pins::COUNTERS[0], pins::COUNTERS[1], pins::INPUTS[0]].map(at);
        self.wire(&format!(
            "STEP X at {step} to {counted}, {first} and {second}, and nothing else to these three"
        ));
        self.pulses("pulses counted at the pin, X alone", &[Axis::X], 90_000)?;
        self.pulses("the same, all axes on their own", &Axis::ALL, 49_000)?;
        self.widths()?;
        self.wire(&format!("DIR X at {dir} to {first}, STEP X at {step} to {second}"));
        self.direction()?;
        self.last_step(usual)?;
        self.wire(&format!("the PWM at {pwm} to {first} and {second}"));
        self.period(usual)?;
        self.tell_timer(0)?;
        self.set_record(BoardRecord { sequence: self.record.sequence, ..usual })
    }

    fn wire(&mut self, wires: &str) {
        (self.ask)(Ask::Wire(wires));
        // Inputs come through their filters.
        self.board.link().pause(Duration::from_millis(100));
    }

    fn tell_timer(&mut self, mode: u16) -> Result<(), Trouble> {
        Ok(self.board.write(wire::MEASURE, mode)?)
    }

    fn found(&mut self) -> Result<Found, Trouble> {
        let words = self.board.holding(wire::MEASURED, 6)?;
        Ok(Found {
            count: words[0],
            there: [words[1], words[2]],
            back: [words[3], words[4]],
            last: words[5] as i16,
        })
    }

    /// Which edge begins a pulse and which ends it.
    fn step_edges(&self) -> (u16, u16) {
        if self.record.flags & BoardRecord::STEP_LOW != 0 {
            (FALLING, RISING)
        } else {
            (RISING, FALLING)
        }
    }

    fn fast(&mut self, axes: &[Axis], rate: i64, distance: i64) -> Result<(), Trouble> {
        for axis in axes {
            let mut order = vec![command::MOVE_BY, axis.index() as u16 + 1];
            for value in [STEEP, rate, STEEP, distance] {
                order.extend(words(value));
            }
            let wrong = || "it refuses a move by hand".to_owned();
            self.board.order(&order, wrong).map_err(Trouble::Words)?;
        }
        Ok(())
    }

    /// As many requests as the line takes until nothing moves.
    fn under_requests(&mut self) -> Result<(), Trouble> {
        let begun = self.board.link().now();
        while self.board.input(wire::MOVING, 1)?[0] & 0xFF != 0 {
            self.board.holding(wire::OWN, 100)?;
            if self.board.link().now() > begun + Duration::from_secs(30) {
                return Err(Trouble::Words("an axis does not come to rest".to_owned()));
            }
        }
        Ok(())
    }

    fn pulses(&mut self, check: &str, axes: &[Axis], rate: i64) -> Result<(), Trouble> {
        const STEPS: i64 = 30_000;
        let late = self.board.late_events()?;
        self.tell_timer(COUNT)?;
        let from = self.place(Axis::X)?;
        self.fast(axes, rate, STEPS)?;
        self.under_requests()?;
        let said = self.place(Axis::X)? - from;
        let made = i64::from(self.found()?.count);
        let late = self.board.late_events()?.wrapping_sub(late);
        let found = format!("{made} at the pin, {said} said, {late} came late");
        let expected = format!("{STEPS} at the pin and said, at {rate} steps/s");
        self.row(check, expected, found, made == STEPS && said == STEPS);
        Ok(())
    }

    fn widths(&mut self) -> Result<(), Trouble> {
        let (begins, ends) = self.step_edges();
        self.tell_timer(CAPTURE | begins << FIRST | ends << SECOND)?;
        self.fast(&Axis::ALL, 49_000, -30_000)?;
        self.under_requests()?;
        let found = self.found()?;
        let us = |ticks: u16| f64::from(ticks) / PER_US;
        // The pause behind a pulse cannot be sampled: the step engine's interrupt ends each pulse before the main loop looks.
        let ([least, most], wanted) = (found.there, f64::from(self.record.pulse));
        let told = if least > most {
            "no pulse".to_owned()
        } else {
            format!("{:.2} to {:.2} us", us(least), us(most))
        };
        let good = least <= most && us(least) >= wanted;
        self.row("width of a pulse", format!("{wanted} us or more"), told, good);
        Ok(())
    }

    /// To and fro without a rest: DIR turns at the pins as fast as it ever does.
    fn direction(&mut self) -> Result<(), Trouble> {
        let (begins, ends) = self.step_edges();
        let mut times = Vec::new();
        for edge in [begins, ends] {
            self.tell_timer(CAPTURE | SLOW | BOTH << FIRST | edge << SECOND)?;
            self.fast(&[Axis::X], 4_000, 8_000)?;
            self.board.link().pause(Duration::from_millis(300));
            self.fast(&[Axis::X], 4_000, -8_000)?;
            self.under_requests()?;
            times.push(self.found()?);
        }
        let setup = f64::from(self.record.setup);
        for (check, least, wanted) in [
            ("from DIR to STEP", times[0].there[0], setup),
            ("from STEP's end to DIR", times[1].back[0], HOLD_US),
        ] {
            let seen = least != u16::MAX;
            let us = 8.0 * f64::from(least) / PER_US;
            let told = if seen { format!("{us:.1} us") } else { "DIR does not turn".to_owned() };
            // A tick is eight cycles.
            let good = seen && us + 8.0 / PER_US >= wanted;
            self.row(check, format!("{wanted} us or more"), told, good);
        }
        Ok(())
    }

    /// From the edge of an emergency stop to the last step.
    ///
    /// At a pin the PWM presses it, as the edges of that come at any instant of the board's millisecond. An output's come
    /// right before the look at the inputs in a millisecond, which stops as soon as the pin's own interrupt: with them a board
    /// without that interrupt could not be told from one that has it.
    fn last_step(&mut self, usual: BoardRecord) -> Result<(), Trouble> {
        const CHECK: &str = "last step behind an emergency stop";
        let chained = usual.flags & BoardRecord::CHAIN != 0;
        // The pin stops by itself, the chain by the millisecond; two steps that were armed or due may come.
        let most = if chained { 1.1 } else { 0.05 } + 2e3 / SPEED as f64;
        let comes = if chained { self.stop_by_output(usual)? } else { self.stop_by_pwm(usual)? };
        let (mut ms, mut fault, mut stops) = (f64::MIN, 0, 0);
        for _ in 0..STOPS {
            self.tell_timer(CAPTURE | SLOW | comes << FIRST | self.step_edges().0 << SECOND)?;
            self.fast(&[Axis::X], SPEED, 20_000)?;
            self.board.link().pause(Duration::from_millis(300));
            self.board.set_coil(wire::COILS, true)?;
            self.board.link().pause(Duration::from_millis(100));
            fault = self.board.holding(wire::FAULT, 1)?[0];
            let found = self.found()?;
            stops += u32::from(found.count > 0);
            ms = ms.max(8.0 * f64::from(found.last) / PER_US / 1e3);
            self.board.set_coil(wire::COILS, false)?;
            self.board.link().pause(Duration::from_millis(60));
            self.board.control(Control::Acknowledge)?;
            if fault != Fault::EmergencyStop as u16 {
                break;
            }
        }
        let good = stops == STOPS && ms <= most && fault == Fault::EmergencyStop as u16;
        let told = if stops == STOPS {
            format!("{ms:.3} ms behind its edge, fault {fault}")
        } else {
            format!("{stops} of {STOPS} stops come to P2.3, fault {fault}")
        };
        self.row(
            CHECK,
            format!("at most {most:.2} ms, fault {}", Fault::EmergencyStop as u16),
            told,
            good,
        );
        Ok(())
    }

    /// Output 1 of the chain presses an emergency stop at input 1. Which edge of it does.
    fn stop_by_output(&mut self, usual: BoardRecord) -> Result<u16, Trouble> {
        let [step, first, second] = [pins::STEP[0], pins::COUNTERS[1], pins::INPUTS[0]].map(at);
        self.wire(&format!("output 1 to input 1 and to {first}, STEP X at {step} to {second}"));
        let resting = self.board.inputs(wire::INPUT_BITS, 1)?[0];
        let input_invert = usual.input_invert | u16::from(resting);
        self.set_record(BoardRecord {
            emergency: [1, 0, 0, 0],
            input_invert,
            reference: [0; 3],
            probe: 0,
            ..usual
        })?;
        // Not both edges: the stop switches the output off, and no step comes after that edge.
        Ok(if usual.output_invert & 1 != 0 { FALLING } else { RISING })
    }

    /// The PWM presses an emergency stop at input 2 with the next period that begins after output 1 is on. Which edge of
    /// it does.
    fn stop_by_pwm(&mut self, usual: BoardRecord) -> Result<u16, Trouble> {
        let [step, pwm, input] = [pins::STEP[0], pins::PWM, pins::INPUTS[1]].map(at);
        let [first, second] = [pins::COUNTERS[1], pins::INPUTS[0]].map(at);
        self.wire(&format!(
            "input 2 at {input} to the PWM at {pwm} and to {first}, STEP X at {step} to {second}"
        ));
        let more = MoreRecord {
            pwm_hz: STOP_HZ,
            pwm_range: 1_000,
            pwm_output: 1,
            pwm_kind: MoreRecord::SPINDLE,
            ..MoreRecord::NONE
        };
        self.set_record(BoardRecord {
            emergency: [2, 0, 0, 0],
            // A high level presses it.
            input_invert: usual.input_invert | 1 << 1,
            reference: [0; 3],
            probe: 0,
            more,
            ..usual
        })?;
        Ok(RISING)
    }

    fn period(&mut self, usual: BoardRecord) -> Result<(), Trouble> {
        let more = MoreRecord {
            pwm_hz: (1e6 / PERIOD_US) as u16,
            pwm_range: 1_000,
            servo_low: SERVO_US / 2,
            servo_high: SERVO_US,
            pwm_output: 1,
            pwm_kind: MoreRecord::SERVO,
            ..MoreRecord::NONE
        };
        self.set_record(BoardRecord { reference: [0; 3], probe: 0, more, ..usual })?;
        self.board.set_coil(wire::COILS, true)?;
        // The first pulse is none: the pin is let go within a period.
        self.board.link().pause(Duration::from_millis(100));
        self.tell_timer(CAPTURE | RISING << FIRST | FALLING << SECOND)?;
        self.board.link().pause(Duration::from_millis(500));
        let found = self.found()?;
        self.board.set_coil(wire::COILS, false)?;
        let us = |ticks: [u16; 2]| ticks.map(|ticks| f64::from(ticks) / PER_US);
        let ([high, high_most], [low, low_most]) = (us(found.there), us(found.back));
        let near = |value: f64, wanted: f64| (value - wanted).abs() <= 0.006 * wanted;
        let period = high + low;
        let good = near(period, PERIOD_US)
            && near(high_most + low_most, PERIOD_US)
            && near(high, f64::from(SERVO_US));
        let told = if found.count == 0 {
            "no pulses".to_owned()
        } else {
            format!("{high:.1} of {period:.1} us")
        };
        let expected = format!("{SERVO_US} of {PERIOD_US:.0} us, to 0.6 %");
        self.row("pulses and period of the PWM", expected, told, good);
        Ok(())
    }
}
