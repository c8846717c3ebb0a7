//! What is no plain move: probing, pulses, other cards, circles, ports.

use super::arc::{self, End};
use super::emit::{Writer, word};
use super::instr::{Item, Pair, Pairs};
use crate::codes::Code;
use crate::diag::Diag;
use crate::script::mm;
use lang::axis::Axis;
use lang::profile::Scale;

impl Writer<'_, '_> {
    /// `6`: each axis by itself is a probe; an impulse ends all of them.
    pub(super) fn until_impulse(&mut self, item: &Item, pairs: &Pairs) {
        let mut moving: Vec<(Axis, Pair)> = Axis::ALL
            .into_iter()
            .filter_map(|axis| Some((axis, pairs.axes[axis.index()]?)))
            .chain(pairs.back.map(|pair| (Axis::Z, pair)))
            .collect();
        moving.retain(|(_, pair)| pair.steps != 0);
        let sideways = moving.iter().filter(|(axis, _)| *axis != Axis::Z).count();
        if sideways > 1 {
            let text = "a probe moves one axis; this one moves X and Y together";
            self.refuse(item, Code::Unsupported, text, "write two moves, one for each axis");
            return;
        }
        self.diags.once(
            Diag::new(
                Code::Changed,
                item.line,
                item.col,
                format!(
                    "the impulse is that of the probe, input {}, not of the Stop key",
                    self.job.profile.probe_input()
                ),
            )
            .note(),
        );
        let mut condition = String::new();
        for (axis, pair) in moving {
            let sign = if pair.steps < 0 { '-' } else { '+' };
            let letter = axis.letter();
            let text = format!(
                "{condition}Probe? {letter}, POSST({letter}) {sign} {}st, {}st/s",
                pair.steps.abs(),
                pair.rate
            );
            self.write(item, &text);
            condition = format!("IF NOT PROBEOK({letter}) THEN {condition}");
        }
    }

    pub(super) fn pulse(&mut self, item: &Item, option: i64) {
        match option {
            1 => self.write(item, "SetOut pulse_out, ON"),
            2 => self.write(item, "SetOut pulse_out, OFF"),
            3 => self.write(item, "Pulse pulse_out, 500ms"),
            4 => self.write(item, "WaitStart"),
            5 => {
                self.script.open("DO");
                self.write(item, "Pulse pulse_out, 500ms");
                self.script.line("WaitIn? pulse_in, ON, 500ms");
                self.script.close("LOOP WHILE TIMEDOUT");
            }
            _ => {
                self.write(item, "WaitStart");
                self.script.line("Pulse pulse_out, 500ms");
            }
        }
    }

    pub(super) fn tell(&mut self, item: &Item, text: &str, wait: bool) {
        self.warn(
            item,
            Code::Changed,
            "`8` starts another card: the script prints the command, and the host must pass it on",
        );
        self.write(item, &format!("PRINT \"@{text}\""));
        if wait {
            self.script.remarked("WaitChar 48", "the other card's answer, passed on by the host");
        }
    }

    pub(super) fn arc(&mut self, at: usize, item: &Item, length: i64, rate: i64, from: [i64; 2]) {
        let Some(clockwise) = self.settings(at).clockwise else {
            let text = "the ways to this circle bring both senses";
            return self.refuse(
                item,
                Code::Inconsistent,
                text,
                "write `F0` or `F-1` before the circle",
            );
        };
        let scales =
            [Axis::X, Axis::Y].map(|axis| self.job.profile.axis(axis).map(|part| part.scale));
        let [Some(scale), Some(other)] = scales else { return };
        if u32::from(scale.steps) * u32::from(other.um)
            != u32::from(other.steps) * u32::from(scale.um)
        {
            let text = "X and Y have different scales: this is no circle in mm";
            return self.refuse(item, Code::Unsupported, text, "choose a profile with one scale");
        }
        let center = format!(
            "{} {}",
            word('I', &self.units.steps(Axis::X, -from[0])),
            word('J', &self.units.steps(Axis::Y, -from[1]))
        );
        let end = match arc::end(from, length, clockwise) {
            End::Start => String::new(),
            End::At(to_x, to_y) => self.arc_end(scale, from, [to_x, to_y]),
            End::Beyond => {
                let text = format!("{length} steps are more than a whole circle of this radius");
                return self.refuse(
                    item,
                    Code::OutOfRange,
                    text,
                    "a circle of radius r has 8 r steps",
                );
            }
        };
        let plane = match self.settings(at).plane {
            Some(0) => "",
            _ => "G17 ",
        };
        let turn = if clockwise { "G2" } else { "G3" };
        self.write(item, &format!("{plane}G91 {turn} {end}{center} F[{rate}st/s]"));
    }

    /// The end's words: whole steps where they lie on the circle, else what does to a micrometre.
    fn arc_end(&self, scale: Scale, from: [i64; 2], to: [f64; 2]) -> String {
        let step_um = f64::from(scale.um) / f64::from(scale.steps);
        #[expect(clippy::cast_precision_loss, reason = "24-bit values are exact")]
        let [x, y] = from.map(|steps| steps as f64);
        let radius = x.hypot(y);
        let miss = (to[0].round().hypot(to[1].round()) - radius).abs();
        let words = [(Axis::X, to[0], x, from[0]), (Axis::Y, to[1], y, from[1])].map(
            |(axis, to, start, steps)| {
                #[expect(clippy::cast_possible_truncation, reason = "within 25 bits")]
                let text = if miss * step_um <= 4.0 || miss <= 0.0009 * radius {
                    self.units.steps(axis, to.round() as i64 - steps)
                } else {
                    mm(((to - start) * step_um).round() as i64)
                };
                word(axis.letter(), &text)
            },
        );
        format!("{} {} ", words[0], words[1])
    }

    pub(super) fn port(&mut self, item: &Item, first: i64, bit: i64, value: i64) {
        let last = if bit == 0 { first + 7 } else { first + bit - 1 };
        let outputs = i64::from(self.job.profile.wiring.outputs());
        if last > outputs {
            let text =
                format!("output {last}: the machine `{}` has {outputs}", self.job.profile.name);
            return self.refuse(
                item,
                Code::OutOfRange,
                text,
                "choose a profile with `wiring = \"chain\"`",
            );
        }
        let switch = |n: i64, on: bool| format!("SetOut {n}, {}", if on { "ON" } else { "OFF" });
        match (bit, first) {
            (0, 1) => self.write(item, &format!("SetPort {value}")),
            (0, _) => {
                let list: Vec<String> =
                    (0..8).map(|i| switch(first + i, value >> i & 1 != 0)).collect();
                self.write(item, &list[..4].join(" : "));
                self.script.line(&list[4..].join(" : "));
            }
            _ => self.write(item, &switch(last, value != 0)),
        }
    }
}
