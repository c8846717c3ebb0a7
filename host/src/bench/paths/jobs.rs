//! The set of paths, each written as lines of constants, as a table read in a loop, and as relative moves in
//! loops.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use super::ideal::{Kind, Leg};

/// A script with the path that it draws between output 1 going on and off.
#[derive(Clone, Debug)]
pub struct Job {
    /// Its stable name.
    pub name: String,
    /// The script.
    pub text: String,
    /// The path from 0.
    pub legs: Vec<Leg>,
    /// One of the few that stand for all.
    pub short: bool,
}

/// A way to write a path down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    /// A line of constants each.
    Lines,
    /// A loop over a table.
    Table,
    /// A loop over relative lines, so many times.
    Loop(u32),
}

/// A path under construction, in um; arcs are chords beside the words that draw them.
#[derive(Clone, Debug, Default)]
struct Course {
    at: [i32; 3],
    legs: Vec<(Kind, [f64; 3])>,
    /// Where each line ends, with the words of an arc.
    blocks: Vec<(Kind, [i32; 3], String)>,
}

impl Course {
    fn to(&mut self, x: f64, y: f64, z: f64) {
        self.go(Kind::Line, [x, y, z]);
    }

    fn rapid(&mut self, x: f64, y: f64, z: f64) {
        self.go(Kind::Rapid, [x, y, z]);
    }

    fn go(&mut self, kind: Kind, to: [f64; 3]) {
        self.at = to.map(|um| um.round() as i32);
        self.legs.push((kind, self.at.map(f64::from)));
        self.blocks.push((kind, self.at, String::new()));
    }

    /// Counterclockwise by a part of a turn about a centre beside the present place.
    fn arc(&mut self, offset: [f64; 2], turn: f64, rise: f64) {
        let from = self.at.map(f64::from);
        let center = [from[0] + offset[0], from[1] + offset[1]];
        let radius = offset[0].hypot(offset[1]);
        let begin = (-offset[1]).atan2(-offset[0]);
        // Chords of 1 degree.
        let chords = (turn.abs() * 360.0).ceil() as u32;
        let at = |n: u32| {
            let part = f64::from(n) / f64::from(chords);
            let angle = begin + part * turn * TAU;
            let [x, y] = [center[0] + radius * angle.cos(), center[1] + radius * angle.sin()];
            [x, y, from[2] + part * rise]
        };
        self.legs.extend((1..=chords).map(|n| (Kind::Arc, at(n))));
        self.at = at(chords).map(|um| um.round() as i32);
        let words = format!(" I{} J{}", mm(offset[0] as i32), mm(offset[1] as i32));
        self.blocks.push((
            Kind::Arc,
            self.at,
            format!("{}{words}", if turn > 0.0 { 3 } else { 2 }),
        ));
    }

    /// The same path so many times, each from the end of the one before.
    fn legs(&self, times: u32, feed: f64) -> Vec<Leg> {
        let by = self.at.map(f64::from);
        let shifted = |pass: u32| {
            self.legs.iter().map(move |(kind, to)| {
                let to = std::array::from_fn(|n| to[n] + f64::from(pass) * by[n]);
                Leg { to, kind: *kind, feed }
            })
        };
        (0..times).flat_map(shifted).collect()
    }

    /// A job that draws this path with F in mm a minute.
    fn job(&self, name: &str, form: Form, feed: u32) -> Job {
        let mut text = format!("G90\nG0 X0 Y0 Z0\nF{feed}\n");
        let (times, what) = match form {
            Form::Loop(times) => (times, "loop"),
            Form::Lines => (1, "lines"),
            Form::Table => (1, "table"),
        };
        match form {
            Form::Lines => text += &format!("SetOut 1, ON\n{}", self.lines(false)),
            Form::Loop(times) => {
                let body = self.lines(true);
                text += &format!("SetOut 1, ON\nG91\nREPEAT {times}\n{body}END REPEAT\nG90\n");
            }
            Form::Table => text += &self.table(),
        }
        text += "SetOut 1, OFF\n";
        let feed_um = f64::from(feed) * 1000.0 / 60.0;
        let name = format!("{name}_f{feed}_{what}");
        Job { name, text, legs: self.legs(times, feed_um.round()), short: false }
    }

    fn lines(&self, relative: bool) -> String {
        let mut text = String::new();
        let mut before = [0; 3];
        for (kind, to, words) in &self.blocks {
            text += match kind {
                Kind::Rapid => "G0",
                Kind::Line => "G1",
                Kind::Arc => "G",
            };
            text += words.get(..1).unwrap_or_default();
            for (n, letter) in "XYZ".chars().enumerate() {
                if to[n] != before[n] || !words.is_empty() && n < 2 {
                    let um = if relative { to[n] - before[n] } else { to[n] };
                    let _ = write!(text, " {letter}{}", mm(um));
                }
            }
            text += words.get(1..).unwrap_or_default();
            text.push('\n');
            before = *to;
        }
        text
    }

    fn table(&self) -> String {
        let flat = self.blocks.iter().all(|(_, to, _)| to[2] == 0);
        let columns = if flat { 2 } else { 3 };
        let row = |to: &[i32; 3]| {
            to[..columns].iter().map(|um| format!("{}mm", mm(*um))).collect::<Vec<_>>().join(", ")
        };
        let rows: Vec<String> = self.blocks.iter().map(|(_, to, _)| row(to)).collect();
        let z = if flat { "" } else { " Z[p(i, 2)]" };
        format!(
            "DIM i\nTABLE p({columns}) = {}\nSetOut 1, ON\nFOR i = 0 TO COUNT(p) - 1\n\
             G1 X[p(i, 0)] Y[p(i, 1)]{z}\nNEXT\n",
            rows.join("; ")
        )
    }
}

/// Micrometres as millimetres.
fn mm(um: i32) -> String {
    format!("{}{}.{:03}", if um < 0 { "-" } else { "" }, um.abs() / 1000, um.abs() % 1000)
}

/// A line of chords, in um.
fn chord(length: f64) -> Course {
    let mut course = Course::default();
    course.to(length, 0.0, 0.0);
    course
}

/// A polygon on a circle about a place beside the beginning, with a fall of Z over each turn, um.
fn round(radius: f64, chord: f64, turns: f64, fall: f64) -> Course {
    let mut course = Course::default();
    let count = (turns * TAU * radius / chord).round() as u32;
    for n in 1..=count {
        let part = f64::from(n) / f64::from(count) * turns;
        let (sin, cos) = (part * TAU).sin_cos();
        course.to(radius * (1.0 - cos), radius * (1.0 + sin), -part * fall);
    }
    course
}

/// Periods of a sine of some amplitude.
fn sine(period: f64, amplitude: f64, chords: u32, periods: u32) -> Course {
    let mut course = Course::default();
    for n in 1..=chords * periods {
        let x = f64::from(n) / f64::from(chords);
        course.to(x * period, amplitude * (1.0 - (x * TAU).cos()), 0.0);
    }
    course
}

/// A spiral from the middle outward, chords of one length.
fn spiral(pitch: f64, turns: f64, chord: f64) -> Course {
    let mut course = Course::default();
    let middle = pitch * (turns + 1.0);
    course.to(middle, middle, 0.0);
    let mut turn = 0.05;
    while turn < turns {
        let radius = pitch * turn;
        let (sin, cos) = (turn * TAU).sin_cos();
        course.to(middle + radius * cos, middle + radius * sin, 0.0);
        turn += chord / (TAU * radius).max(chord * 4.0);
    }
    course
}

/// A rectangle with corners of chords or arcs, um.
fn rounded(side: f64, radius: f64, chords: Option<u32>) -> Course {
    let mut course = Course::default();
    let long = side - 2.0 * radius;
    course.to(radius, 0.0, 0.0);
    let ways = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
    for [x, y] in ways {
        let [cx, cy] = [course.at[0], course.at[1]].map(f64::from);
        course.to(cx + x * long, cy + y * long, 0.0);
        let [cx, cy] = [course.at[0], course.at[1]].map(f64::from);
        match chords {
            None => course.arc([-y * radius, x * radius], 0.25, 0.0),
            Some(count) => {
                for n in 1..=count {
                    let (sin, cos) = (f64::from(n) / f64::from(count) * TAU / 4.0).sin_cos();
                    let [along, aside] = [radius * sin, radius * (1.0 - cos)];
                    course.to(cx + x * along - y * aside, cy + y * along + x * aside, 0.0);
                }
            }
        }
    }
    course
}

fn zigzag(size: f64) -> Course {
    let mut course = Course::default();
    course.to(size / 2.0, size, 0.0);
    course.to(size, 0.0, 0.0);
    course
}

/// Islands as isolation milling goes around them: a lift, a rapid move, a plunge, an octagon.
fn islands(count: i32, lifted: bool) -> Course {
    let mut course = Course::default();
    for n in 0..count {
        let [x, y] = [f64::from(n % 4), f64::from(n / 4)].map(|n| 2_000.0 + 4_000.0 * n);
        let size = 900.0 + 130.0 * f64::from(n % 5);
        if lifted {
            course.rapid(x + size, y, 0.0);
            course.to(x + size, y, -300.0);
        } else {
            course.to(x + size, y, 0.0);
        }
        for k in 1..=16 {
            let (sin, cos) = (f64::from(k) / 16.0 * TAU).sin_cos();
            // Sides of very different lengths, as tracks have them.
            let z = if lifted { -300.0 } else { 0.0 };
            course.to(x + size * cos, y + (size * sin * 1.8).max(0.0), z);
        }
        if lifted {
            course.rapid(x + size, y, 0.0);
        }
    }
    course
}

/// Two rows of a raster of pixels, to and fro.
fn raster(pixel: f64, pixels: u32) -> Course {
    let mut course = Course::default();
    for n in 1..=pixels {
        course.to(pixel * f64::from(n), 0.0, 0.0);
    }
    course.to(pixel * f64::from(pixels), pixel, 0.0);
    for n in (0..pixels).rev() {
        course.to(pixel * f64::from(n), pixel, 0.0);
    }
    course.to(0.0, 2.0 * pixel, 0.0);
    course
}

/// Strokes of letters in chords of some 0.4 mm.
fn letters(count: u32) -> Course {
    let mut course = Course::default();
    for n in 0..count {
        let left = 7_000.0 * f64::from(n);
        // An S, then the stroke down of the next letter.
        for k in 0..=36 {
            let angle = f64::from(k) / 36.0 * 3.0 * std::f64::consts::PI;
            let x = left + 2_000.0 + 2_000.0 * angle.cos() * (1.0 - f64::from(k) / 90.0);
            course.to(x, 250.0 * f64::from(k), 0.0);
        }
        course.to(left + 6_000.0, 9_000.0, 0.0);
        course.to(left + 6_000.0, 0.0, 0.0);
    }
    course
}

/// Lines of every length in every direction, as a drawing program makes them; the same each time.
fn mixed(count: u32) -> Course {
    let mut course = Course::default();
    let (mut seed, mut angle) = (1_u32, 0.3_f64);
    let mut draw = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed >> 8) / f64::from(1 << 24)
    };
    course.to(15_000.0, 15_000.0, 0.0);
    for _ in 0..count {
        angle += (draw() - 0.45) * if draw() > 0.9 { 3.0 } else { 0.4 };
        let length = 60.0 * 40_f64.powf(draw());
        let [x, y] = [course.at[0], course.at[1]].map(f64::from);
        let at = |angle: f64| [x + length * angle.cos(), y + length * angle.sin()];
        let inside = |[x, y]: [f64; 2]| [x, y].iter().all(|um| (0.0..30_000.0).contains(um));
        if !inside(at(angle)) {
            angle += TAU / 2.0;
        }
        let [x, y] = at(angle);
        course.to(x, y, 0.0);
    }
    course
}

/// Two small arcs, one to the right and one to the left.
fn tiny_arcs(radius: f64) -> Course {
    let mut course = Course::default();
    course.arc([radius, 0.0], -0.25, 0.0);
    course.arc([0.0, radius], 0.25, 0.0);
    course
}

fn helix() -> Course {
    let mut course = Course::default();
    course.to(0.0, 6_000.0, 0.0);
    for _ in 0..3 {
        course.arc([6_000.0, 0.0], 1.0, -1_500.0);
    }
    course
}

/// Every job of the set.
pub fn all() -> Vec<Job> {
    let mut jobs = Vec::new();
    for feed in [600, 1500, 3000] {
        for um in [50_u32, 100, 200, 500, 1000] {
            // About 3 s each.
            let times = feed * 1000 / 60 * 3 / um;
            let name = format!("chords_{um}um");
            jobs.push(chord(um.into()).job(&name, Form::Loop(times.min(2_000)), feed));
        }
    }
    let circle = round(5_000.0, 100.0, 1.0, 0.0);
    let large = round(10_000.0, 200.0, 1.0, 0.0);
    let wave = sine(10_000.0, 2_500.0, 80, 3);
    let period = sine(20_000.0, 5_000.0, 100, 1);
    let snail = spiral(800.0, 5.0, 300.0);
    let pocket = rounded(30_000.0, 5_000.0, Some(20));
    let thread = round(4_000.0, 250.0, 3.0, 1_000.0);
    let tracks = islands(12, true);
    let outlines = islands(12, false);
    let strokes = letters(5);
    let drawing = mixed(300);
    jobs.extend([
        circle.job("circle_r5_100um", Form::Lines, 1500),
        circle.job("circle_r5_100um", Form::Lines, 3000),
        circle.job("circle_r5_100um", Form::Table, 3000),
        large.job("circle_r10_200um", Form::Table, 600),
        large.job("circle_r10_200um", Form::Table, 3000),
        wave.job("sine", Form::Lines, 1500),
        wave.job("sine", Form::Table, 3000),
        period.job("sine", Form::Loop(4), 3000),
        snail.job("spiral", Form::Lines, 1500),
        snail.job("spiral", Form::Table, 3000),
        pocket.job("rounded_chords", Form::Lines, 1500),
        pocket.job("rounded_chords", Form::Table, 3000),
        rounded(30_000.0, 5_000.0, None).job("rounded_arcs", Form::Lines, 3000),
        zigzag(1_000.0).job("zigzag_1mm", Form::Loop(30), 3000),
        zigzag(4_000.0).job("zigzag_4mm", Form::Loop(12), 1500),
        tracks.job("islands", Form::Lines, 600),
        outlines.job("outlines", Form::Table, 3000),
        raster(250.0, 60).job("raster_250um", Form::Loop(3), 3000),
        raster(100.0, 60).job("raster_100um", Form::Lines, 1500),
        strokes.job("letters", Form::Lines, 1500),
        strokes.job("letters", Form::Table, 3000),
        thread.job("helix_chords", Form::Lines, 1500),
        thread.job("helix_chords", Form::Table, 3000),
        helix().job("helix_arcs", Form::Lines, 3000),
        tiny_arcs(500.0).job("arcs_r0.5", Form::Loop(12), 1500),
        tiny_arcs(2_500.0).job("arcs_r2.5", Form::Loop(6), 3000),
        drawing.job("mixed", Form::Lines, 1500),
        drawing.job("mixed", Form::Table, 3000),
    ]);
    const SHORT: [&str; 6] = [
        "chords_100um_f3000_loop",
        "circle_r5_100um_f3000_table",
        "sine_f3000_table",
        "zigzag_1mm_f3000_loop",
        "rounded_arcs_f3000_lines",
        "helix_chords_f1500_lines",
    ];
    for job in &mut jobs {
        job.short = SHORT.contains(&job.name.as_str());
    }
    jobs
}
