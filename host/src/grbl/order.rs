//! A session's commands to the machine, in machine coordinates, and their text in the language.

use std::fmt::Write;

use super::modal::Spindle;

/// A place in um, machine frame; axes that stay are left out.
pub type Target = [Option<i32>; 3];

/// Something for the machine, in the order in which it is done.
#[derive(Clone, Debug, PartialEq)]
pub enum Order {
    /// As fast as the axes go; a laser is dark.
    Rapid(Target),
    /// A straight line.
    Line {
        /// Where to.
        to: Target,
        /// um/s
        feed: i32,
        /// A laser's or PWM's power, where the machine has one.
        power: Option<i32>,
    },
    /// An arc in a plane, with a straight third axis.
    Arc {
        /// 17 to 19.
        plane: u8,
        /// G2.
        clockwise: bool,
        /// Where to.
        to: Target,
        /// The centre from the start, um: X Y, Z X or Y Z.
        center: [i32; 2],
        /// um/s
        feed: i32,
        /// As that of a line.
        power: Option<i32>,
    },
    /// Waits for so many ms at rest.
    Dwell(u32),
    /// M3, M4, M5 with the power that holds.
    Spindle(Spindle, Option<i32>),
    /// Coolant on or off.
    Coolant(bool),
    /// Waits for Start.
    Halt,
    /// An output, from 1.
    Output(u16, bool),
    /// Moves an axis until the probe's input changes.
    Probe {
        /// Which.
        axis: usize,
        /// How far at most, um.
        limit: i32,
        /// um/s
        feed: i32,
        /// The input, from 1.
        input: i32,
        /// Whether it looks for the contact's end.
        away: bool,
    },
    /// The reference run of all axes that have one.
    Home,
    /// The drivers.
    Motors(bool),
}

const LETTERS: [char; 3] = ['X', 'Y', 'Z'];

/// A whole number of um as mm.
fn mm(um: i32) -> String {
    let size = um.unsigned_abs();
    let sign = if um < 0 { "-" } else { "" };
    format!("{sign}{}.{:03}", size / 1000, size % 1000)
}

/// Makes text of orders.
#[derive(Debug, Default)]
pub struct Writer {
    text: String,
    /// Line of the text that comes next, from 1.
    line: u32,
    /// For each line of the text the number of the client's line.
    numbers: Vec<u32>,
    feed: Option<i32>,
    power: Option<i32>,
}

impl Writer {
    /// A text of its own: it sets what it needs.
    pub fn new() -> Writer {
        let mut writer = Writer::default();
        writer.statement(0, "G17 G21 G90 G94 G64");
        writer
    }

    fn statement(&mut self, number: u32, text: &str) {
        self.text.push_str(text);
        self.text.push('\n');
        self.line += 1;
        self.numbers.push(number);
    }

    /// Adds an order of the client's line `number`.
    pub fn put(&mut self, number: u32, order: &Order) {
        let text = match order {
            Order::Rapid(to) => format!("G0{}", words(to)),
            Order::Line { to, feed, power } => {
                self.power(number, *power);
                format!("G1{}{}", words(to), self.feed(*feed))
            }
            Order::Arc { plane, clockwise, to, center, feed, power } => {
                self.power(number, *power);
                let letters = match plane {
                    18 => ['K', 'I'],
                    19 => ['J', 'K'],
                    _ => ['I', 'J'],
                };
                let center: String =
                    letters.iter().zip(center).map(|(l, v)| format!(" {l}{}", mm(*v))).collect();
                let g = if *clockwise { 2 } else { 3 };
                let feed = self.feed(*feed);
                // The plane holds for this block: every arc names its own.
                format!("G{plane} G{g}{}{center}{feed}", words(to))
            }
            Order::Dwell(ms) => format!("Wait {ms}ms"),
            Order::Spindle(Spindle::Off, _) => "M5".to_owned(),
            Order::Spindle(way, power) => {
                self.power = *power;
                let power = power.map_or(String::new(), |power| format!(" S{power}"));
                let m = if *way == Spindle::Clockwise { 3 } else { 4 };
                format!("M{m}{power}")
            }
            Order::Coolant(on) => if *on { "M8" } else { "M9" }.to_owned(),
            Order::Halt => "WaitStart".to_owned(),
            Order::Output(n, on) => format!("SetOut {n}, {}", if *on { "ON" } else { "OFF" }),
            Order::Probe { axis, limit, feed, input, away } => {
                let (letter, limit, feed) = (LETTERS[*axis], mm(*limit), mm(*feed));
                let state = if *away { "OFF" } else { "ON" };
                let text = format!("Probe? {letter}, {limit}mm, {feed}mm/s, {input}, {state}");
                self.statement(number, &text);
                // What it found comes back as print: the registers tell of commands' probes only.
                format!("PRINT {axis}; \" \"; PROBEOK({letter}); \" \"; PROBEDST({letter}) / 1st")
            }
            Order::Home => "Home".to_owned(),
            Order::Motors(on) => format!("Motors {}", if *on { "ON" } else { "OFF" }),
        };
        self.statement(number, &text);
    }

    fn feed(&mut self, feed: i32) -> String {
        if self.feed.replace(feed) == Some(feed) {
            return String::new();
        }
        // 1 um/s is 0.06 mm/min.
        let hundredths = i64::from(feed) * 6;
        format!(" F{}.{:02}", hundredths / 100, hundredths % 100)
    }

    fn power(&mut self, number: u32, power: Option<i32>) {
        if let Some(power) = power
            && self.power.replace(power) != Some(power)
        {
            self.statement(number, &format!("S{power}"));
        }
    }

    /// Lines of the text so far.
    pub fn lines(&self) -> u32 {
        self.line
    }

    /// The text, and for each of its lines the number of the client's line.
    pub fn finish(self) -> (String, Vec<u32>) {
        (self.text, self.numbers)
    }
}

fn words(to: &Target) -> String {
    let mut text = String::new();
    for (letter, um) in LETTERS.iter().zip(to) {
        if let Some(um) = um {
            // A String takes all.
            let _ = write!(text, " {letter}{}", mm(*um));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{Order, Writer};
    use crate::grbl::modal::Spindle;

    #[test]
    fn orders_become_statements_that_compile() {
        let mut writer = Writer::new();
        let line = |x, power| Order::Line { to: [Some(x), None, None], feed: 10_000, power };
        let arc = Order::Arc {
            plane: 17,
            clockwise: true,
            to: [Some(7000), Some(1), Some(1)],
            center: [1000, 0],
            feed: 1,
            power: None,
        };
        let orders = [
            Order::Rapid([None, Some(1), Some(-12_345)]),
            Order::Spindle(Spindle::Clockwise, Some(0)),
            line(5000, Some(300)),
            line(6000, Some(300)),
            line(5000, Some(0)),
            arc,
            Order::Probe { axis: 2, limit: 9000, feed: 1500, input: 17, away: true },
            Order::Dwell(250),
            Order::Output(3, true),
            Order::Coolant(true),
            Order::Halt,
            Order::Home,
            Order::Motors(false),
        ];
        for (n, order) in orders.iter().enumerate() {
            writer.put(n as u32 + 1, order);
        }
        let (text, numbers) = writer.finish();
        let wanted = [
            "G17 G21 G90 G94 G64",
            "G0 Y0.001 Z-12.345",
            "M3 S0",
            "S300",
            "G1 X5.000 F600.00",
            "G1 X6.000",
            "S0",
            "G1 X5.000",
            "G17 G2 X7.000 Y0.001 Z0.001 I1.000 J0.000 F0.06",
            "Probe? Z, 9.000mm, 1.500mm/s, 17, OFF",
            "PRINT 2; \" \"; PROBEOK(Z); \" \"; PROBEDST(Z) / 1st",
            "Wait 250ms",
            "SetOut 3, ON",
            "M8",
            "WaitStart",
            "Home",
            "Motors OFF",
        ];
        assert_eq!(text.lines().collect::<Vec<_>>(), wanted);
        assert_eq!(numbers, [0, 1, 2, 3, 3, 4, 5, 5, 6, 7, 7, 8, 9, 10, 11, 12, 13]);
        let profile = lang::profile::Profile::built_in("mill").expect("built in");
        crate::grbl::drive::compiled(&text, &profile).expect("it compiles");
    }
}
