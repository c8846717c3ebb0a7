//! From the card's instructions to a script.

use std::collections::BTreeSet;

use super::flow::{self, Flow, Settings};
use super::instr::{Axes, Item, Op, Pair, Pairs};
use crate::Job;
use crate::codes::Code;
use crate::diag::{Diag, Diags};
use crate::script::{Made, Script, Units, time};
use lang::axis::Axis;
use lang::profile::Scale;

/// Blocks within one another that a script may have, less one for what stands inside.
const MAX_NESTING: usize = 60;

/// Where the instructions come from.
pub(crate) struct Source {
    /// For the script's head.
    pub what: &'static str,
    /// The scale of each axis, where the source tells it.
    pub scales: [Option<Scale>; 3],
    /// Whether the source's text stands behind what was made of it.
    pub remarks: bool,
}

/// Writes the script.
pub(crate) fn script(job: &Job<'_>, items: &[Item], source: &Source, diags: &mut Diags) -> Made {
    let flow = Flow::of(items);
    if flow.nesting() > MAX_NESTING {
        let text = format!("loops nest {} deep; the card takes 4", flow.nesting());
        diags.push(Diag::new(Code::BadJump, 1, 1, text));
        return Made::default();
    }
    let mut labels = BTreeSet::new();
    for (at, item) in items.iter().enumerate() {
        let block =
            matches!(item.op, Op::Loop { .. }) && flow.at(at).is_some_and(|part| part.structured);
        if let Some(to) = item.op.target().filter(|_| !block) {
            labels.insert((to, flow.depth(at, to)));
        }
    }
    let zeroed = items.iter().fold(Axes(0), |all, item| match item.op {
        Op::Zero(axes) => Axes(all.0 | axes.0),
        _ => all,
    });
    let mut writer = Writer {
        job,
        items,
        flow,
        labels,
        settings: flow::settings(items),
        units: Units::new(source.scales, job.profile),
        zeroed,
        pulse_out: 0,
        pulse_in: 0,
        remarks: source.remarks,
        script: Script::new(job.name, source.what, job.profile),
        diags,
    };
    writer.check_axes();
    writer.head();
    writer.body();
    writer.script.finish()
}

pub(super) struct Writer<'a, 'd> {
    pub(super) job: &'a Job<'a>,
    items: &'a [Item],
    flow: Flow,
    /// Instruction and how many of the loops that begin there stand before the label.
    labels: BTreeSet<(usize, usize)>,
    settings: Vec<Option<Settings>>,
    pub(super) units: Units,
    /// Axes whose work zero the program moves: their targets are work positions.
    zeroed: Axes,
    pub(super) pulse_out: i64,
    pub(super) pulse_in: i64,
    remarks: bool,
    pub(super) script: Script,
    pub(super) diags: &'d mut Diags,
}

impl Writer<'_, '_> {
    /// The machine must have what the program uses.
    fn check_axes(&mut self) {
        for item in self.items {
            let axes = match &item.op {
                Op::Relative(pairs) | Op::Absolute(pairs) | Op::UntilImpulse(pairs) => {
                    let moved = |axis: &Axis| {
                        pairs.axes[axis.index()].is_some_and(|pair| pair.steps != 0)
                            || *axis == Axis::Z && pairs.back.is_some_and(|pair| pair.steps != 0)
                    };
                    Axis::ALL
                        .iter()
                        .filter(|axis| moved(axis))
                        .fold(0, |set, axis| set | 1 << (*axis as u8))
                }
                Op::Home(axes) | Op::Zero(axes) => axes.0,
                Op::Arc { .. } => 3,
                _ => 0,
            };
            let missing = Axes(axes).list().find(|axis| self.job.profile.axis(*axis).is_none());
            if let Some(axis) = missing {
                let text = format!(
                    "the machine `{}` has no axis {}",
                    self.job.profile.name,
                    axis.letter()
                );
                let diag = Diag::new(Code::WrongAxis, item.line, item.col, text);
                self.diags.push(diag.hint("choose another with `--profile`"));
            }
        }
    }

    fn head(&mut self) {
        let has = |test: fn(&Op) -> bool| self.items.iter().any(|item| test(&item.op));
        let pulses = has(|op| matches!(op, Op::Pulse(_)));
        let answered = has(|op| matches!(op, Op::Pulse(5)));
        let waits = has(|op| matches!(op, Op::WaitChar { jump: Some(_), .. }));
        let paths = has(|op| matches!(op, Op::Relative(_) | Op::Absolute(_) | Op::Arc { .. }));
        if pulses {
            let used = |n: i64| {
                self.items.iter().any(|item| {
                    matches!(item.op, Op::Port { first, bit, .. }
                    if bit != 0 && first + bit - 1 == n)
                })
            };
            self.pulse_out = (1..=8).find(|n| !used(*n)).unwrap_or(1);
            self.script.remarked(
                &format!("OUTPUT pulse_out = {}", self.pulse_out),
                "the pulse relay: change the number to where it is wired",
            );
        }
        if answered {
            let used = |n: i64| {
                self.items
                    .iter()
                    .any(|item| matches!(item.op, Op::PortTest { bit, .. } if bit == n))
            };
            self.pulse_in =
                (1..=self.job.profile.wiring.inputs().into()).find(|n| !used(*n)).unwrap_or(1);
            self.script.remarked(
                &format!("INPUT pulse_in = {}", self.pulse_in),
                "the partner's answer: change the number to where it is wired",
            );
            let text = format!(
                "`4 5` waits for its answer at input {}: a repeated pulse cannot wait for the Start button",
                self.pulse_in
            );
            self.diags.once(Diag::new(Code::Said, 1, 1, text).note());
        }
        if waits {
            self.script.line("DIM got");
        }
        for part in self.flow.loops.iter().filter(|part| !part.structured) {
            if matches!(self.items[part.end].op, Op::Loop { times: 1.., .. }) {
                self.script.line(&format!("DIM {}", counter(part.end)));
            }
        }
        if paths {
            self.script.remarked("G61", "the card stops after each move");
        }
        self.script.gap();
    }

    fn body(&mut self) {
        for at in 0..self.items.len() {
            self.label(at, 0);
            let opening: Vec<usize> = self.flow.opening(at).map(|part| part.end).collect();
            for (depth, end) in opening.iter().enumerate() {
                match self.items[*end].op {
                    Op::Loop { times, .. } if times > 0 => {
                        self.script.open(&format!("REPEAT {times}"))
                    }
                    _ => self.script.open("DO"),
                }
                self.label(at, depth + 1);
            }
            self.item(at);
            if self.diags.hopeless() {
                return;
            }
        }
        if self.labels.contains(&(self.items.len(), 0)) {
            self.script.label(&name(self.items.len(), 0));
            self.script.line("END");
        }
    }

    fn label(&mut self, at: usize, depth: usize) {
        if self.labels.contains(&(at, depth)) {
            self.script.label(&name(at, depth));
        }
    }

    /// Writes a statement with the source's text behind it.
    pub(super) fn write(&mut self, item: &Item, statement: &str) {
        if self.remarks {
            self.script.remarked(statement, &item.text);
        } else {
            self.script.line(statement);
        }
    }

    pub(super) fn refuse(&mut self, item: &Item, code: Code, text: impl Into<String>, hint: &str) {
        self.diags.push(Diag::new(code, item.line, item.col, text).hint(hint));
    }

    pub(super) fn warn(&mut self, item: &Item, code: Code, text: impl Into<String>) {
        self.diags.once(Diag::new(code, item.line, item.col, text).warning());
    }

    fn item(&mut self, at: usize) {
        let items = self.items;
        let item = &items[at];
        self.script.set_place(item.line);
        match &item.op {
            Op::Relative(pairs) => self.relative(at, item, pairs),
            Op::Absolute(pairs) => self.absolute(at, item, pairs),
            Op::UntilImpulse(pairs) => self.until_impulse(item, pairs),
            Op::Send(c) => self.write(item, &format!("Send {c}")),
            Op::WaitChar { c, jump: None } => self.write(item, &format!("WaitChar {c}")),
            Op::WaitChar { c, jump: Some(to) } => {
                self.script.open("DO");
                self.write(item, "got = CHARIN()");
                self.script.close(&format!("LOOP UNTIL got = {c} OR got = {}", c + 1));
                let jump = self.jump(at, *to);
                self.script.line(&format!("IF got = {} THEN {jump}", c + 1));
            }
            Op::Loop { times, start } => self.repeat(at, *times, *start),
            Op::Jump(to) => {
                let jump = self.jump(at, *to);
                self.write(item, &jump);
            }
            Op::Pulse(option) => self.pulse(item, *option),
            Op::Delay(tenths) => self.write(item, &format!("Wait {}", time(tenths * 100))),
            Op::Home(axes) => {
                // The highest axis first: the tool leaves the work before anything moves sideways.
                let list: Vec<String> =
                    axes.list().rev().map(|axis| axis.letter().to_string()).collect();
                self.write(item, &format!("Home {}", list.join(", ")));
            }
            Op::Tell { text, wait } => self.tell(item, text, *wait),
            Op::Zero(axes) => {
                let list: Vec<String> =
                    axes.list().map(|axis| format!("SetPos {}, 0mm", axis.letter())).collect();
                self.write(item, &list.join(" : "));
            }
            Op::Plane(plane) => {
                let word = ["PLANE XY", "PLANE XZ", "PLANE YZ"][usize::from(*plane % 3)];
                self.write(item, word);
            }
            Op::Solid(_) | Op::Clockwise(_) => self.script.remark(&item.text),
            Op::Arc { length, rate, from } => self.arc(at, item, *length, *rate, *from),
            Op::Port { first, bit, value } => self.port(item, *first, *bit, *value),
            Op::PortTest { bit, value, jump } => {
                let test = match (*bit, *value) {
                    (0, value) => format!("(INPORT() AND 255) = {value}"),
                    (bit, 0) => format!("NOT IN({bit})"),
                    (bit, _) => format!("IN({bit})"),
                };
                let jump = self.jump(at, *jump);
                self.write(item, &format!("IF {test} THEN {jump}"));
            }
        }
    }

    /// GOTO, with the counters of the loops that it leaves set back.
    fn jump(&self, at: usize, to: usize) -> String {
        let mut out = String::new();
        for part in self.flow.left(at, to) {
            if matches!(self.items[part.end].op, Op::Loop { times: 1.., .. }) {
                out += &format!("{} = 0 : ", counter(part.end));
            }
        }
        out + &format!("GOTO {}", name(to, self.flow.depth(at, to)))
    }

    fn repeat(&mut self, at: usize, times: i64, start: usize) {
        let block = self.flow.at(at).is_some_and(|part| part.structured);
        match (block, times) {
            (true, 0) => self.script.close("LOOP"),
            (true, _) => self.script.close("END REPEAT"),
            (false, 0) => {
                let jump = self.jump(at, start);
                self.write(&self.items[at], &jump);
            }
            (false, _) => {
                let counter = counter(at);
                self.write(&self.items[at], &format!("IF {counter} = 0 THEN {counter} = {times}"));
                self.script.line(&format!("{counter} = {counter} - 1"));
                let jump = self.jump(at, start);
                self.script.line(&format!("IF {counter} > 0 THEN {jump}"));
            }
        }
    }

    /// The settings at an instruction; those of the start where nothing reaches it.
    pub(super) fn settings(&self, at: usize) -> Settings {
        self.settings.get(at).copied().flatten().unwrap_or(Settings {
            plane: Some(0),
            solid: Some(false),
            clockwise: Some(true),
        })
    }

    /// Which axes move together, first to last.
    fn groups(&mut self, at: usize, item: &Item) -> Option<Vec<Vec<Axis>>> {
        let settings = self.settings(at);
        let (Some(plane), Some(solid)) = (settings.plane, settings.solid) else {
            let text = "the ways to this move bring different planes, or 3D on and off";
            self.refuse(item, Code::Inconsistent, text, "write `e` and `Z` before the move");
            return None;
        };
        Some(together(solid, plane))
    }

    fn relative(&mut self, at: usize, item: &Item, pairs: &Pairs) {
        let Some(groups) = self.groups(at, item) else { return };
        let mut statements = Vec::new();
        for group in groups {
            let moving: Vec<(Axis, Pair)> = group
                .into_iter()
                .filter_map(|axis| {
                    Some((axis, pairs.axes[axis.index()].filter(|pair| pair.steps != 0)?))
                })
                .collect();
            match moving[..] {
                [] => {}
                [(axis, pair)] => statements.push(self.single("MoveRel", axis, pair)),
                _ => {
                    let words = moving.iter().map(|(axis, pair)| {
                        word(axis.letter(), &self.units.steps(*axis, pair.steps))
                    });
                    let words: Vec<String> = words.collect();
                    let feed = resulting(moving.iter().map(|(_, pair)| pair.rate));
                    statements.push(format!("G91 G1 {} F[{feed}st/s]", words.join(" ")));
                }
            }
        }
        if let Some(back) = pairs.back.filter(|pair| pair.steps != 0) {
            if self.settings(at).plane.is_some_and(|plane| plane != 0) {
                self.warn(
                    item,
                    Code::Changed,
                    "outside plane XY the second Z should be 0: it moves last",
                );
            }
            statements.push(self.single("MoveRel", Axis::Z, back));
        }
        self.statements(item, &statements, pairs);
    }

    fn single(&self, statement: &str, axis: Axis, pair: Pair) -> String {
        let distance = self.units.steps(axis, pair.steps);
        format!("{statement} {}, {distance}, {}st/s", axis.letter(), pair.rate)
    }

    /// A target of an absolute move, in work coordinates where the program moves the zero.
    fn target(&self, axis: Axis, steps: i64) -> String {
        let text = self.units.steps(axis, steps);
        if text.ends_with("mm") || !self.zeroed.has(axis) {
            return text;
        }
        format!("LENGTH({}, {text})", axis.letter())
    }

    fn absolute(&mut self, at: usize, item: &Item, pairs: &Pairs) {
        let Some(groups) = self.groups(at, item) else { return };
        let mut statements = Vec::new();
        for group in groups {
            let named: Vec<(Axis, Pair)> = group
                .into_iter()
                .filter_map(|axis| Some((axis, pairs.axes[axis.index()]?)))
                .filter(|(axis, _)| self.job.profile.axis(*axis).is_some())
                .collect();
            match named[..] {
                [] => {}
                [(axis, pair)] => {
                    let target = self.target(axis, pair.steps);
                    statements.push(format!(
                        "MoveAxe {}, {target}, {}st/s",
                        axis.letter(),
                        pair.rate
                    ));
                }
                _ => {
                    let words = named
                        .iter()
                        .map(|(axis, pair)| word(axis.letter(), &self.target(*axis, pair.steps)));
                    let words: Vec<String> = words.collect();
                    let feed = resulting(named.iter().map(|(_, pair)| pair.rate));
                    statements.push(format!("G90 G1 {} F[{feed}st/s]", words.join(" ")));
                }
            }
        }
        self.statements(item, &statements, pairs);
    }

    /// The statements of one instruction, the source's text behind the first.
    fn statements(&mut self, item: &Item, statements: &[String], pairs: &Pairs) {
        let told: Vec<String> = Axis::ALL
            .into_iter()
            .filter_map(|axis| self.units.told(axis, pairs.axes[axis.index()]?.steps))
            .collect();
        let mut rest = statements.iter();
        match rest.next() {
            Some(first) if self.remarks => {
                let text = [&item.text[..], &told.join(" ")].join("  ");
                self.script.remarked(first, &text);
            }
            Some(first) => self.script.remarked(first, &told.join(" ")),
            None => self.script.remark(&format!("{}  moves nothing", item.text)),
        }
        for statement in rest {
            self.script.line(statement);
        }
    }
}

/// Which axes move together, first to last.
pub(super) fn together(solid: bool, plane: u8) -> Vec<Vec<Axis>> {
    match (solid, plane) {
        (true, _) => vec![vec![Axis::X, Axis::Y, Axis::Z]],
        (_, 0) => vec![vec![Axis::X, Axis::Y], vec![Axis::Z]],
        (_, 1) => vec![vec![Axis::X, Axis::Z], vec![Axis::Y]],
        _ => vec![vec![Axis::Y, Axis::Z], vec![Axis::X]],
    }
}

/// The speed of axes that move together: the root of the squares.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "rates have 15 bits"
)]
pub(super) fn resulting(rates: impl Iterator<Item = i64>) -> i64 {
    (rates.map(|rate| (rate * rate) as f64).sum::<f64>().sqrt().round() as i64).max(1)
}

/// A G-code word: a length in mm as it is, anything else in brackets.
pub(super) fn word(letter: char, text: &str) -> String {
    match text.strip_suffix("mm") {
        Some(number) => format!("{letter}{number}"),
        None => format!("{letter}[{text}]"),
    }
}

/// Name of an instruction's label; `depth` loops that begin there stand before it.
fn name(at: usize, depth: usize) -> String {
    match depth {
        0 => format!("step_{}", at + 1),
        1 => format!("step_{}_inside", at + 1),
        _ => format!("step_{}_inside_{depth}", at + 1),
    }
}

/// Name of the variable of a counted loop that is no block.
fn counter(at: usize) -> String {
    format!("passes_{}", at + 1)
}
