//! G-code blocks of generated programs.

use std::fmt::Write as _;

use lang::record::feature;

use super::Writer;

impl Writer<'_> {
    /// A G-code block with every modal word that it needs.
    pub(super) fn gcode(&mut self) {
        let mode = self.tape.of(&["G90", "G91"]);
        let stop = self.tape.of(&["G64", "G61", "G64"]);
        let feed = self.tape.of(&["F1200", "F600", "F[25mm/s]", "F[900st/s]", "F1250"]);
        let turn = self.tape.of(&["G2", "G3"]);
        let arcs = self.has(feature::ARC);
        let mut text = String::new();
        // Writing to a String does not fail.
        let _ = match self.tape.pick(18) {
            0 | 1 => write!(text, "{mode} G0 X{}", self.word()),
            2..=5 => write!(text, "{stop} {mode} G1 X{} Y{} {feed}", self.word(), self.word()),
            6 => write!(text, "{stop} G91 G1 Z-{} {feed}", self.tape.of(&["1", "0.5"])),
            // A part that draws no arcs gets the chords of these.
            7 => {
                let x = self.tape.of(&["4", "0", "3"]);
                write!(text, "G17 {stop} G91 {turn} X{x} Y0 I2 J0 {feed}")
            }
            8 => {
                let plane =
                    self.tape.of(&["G17 G91 G2 X3 Y3", "G18 G91 G3 X2 Z2", "G19 G91 G2 Y2 Z-2"]);
                write!(text, "{plane} R{} {stop} {feed}", self.tape.of(&["5", "-5", "1"]))
            }
            9 | 15 => write!(text, "{} {feed}\nG80", self.cycle()),
            10 => {
                let spindle = if self.has(feature::POWER) { "M3 S900" } else { "M3" };
                let list = ["G92 X1 Y[len]", spindle, "G4 P0.05", "M9", "G54"];
                write!(text, "{}", self.tape.of(&list))
            }
            12 => write!(text, "{mode} G0 X[spots(ABS(va) MOD 3, 0)] Y[spots(ABS(va) MOD 3, 1)]"),
            13 if arcs => {
                let x = self.tape.of(&["5", "12.5", "-1.2", "[300st]", "[len]"]);
                write!(text, "G17 G90 {stop} {turn} X{x} Y3 R20 {feed}")
            }
            14 if self.has(feature::ACTIONS) && self.tape.chance(3) => {
                let list = [
                    "SYNC SetOut 1, ON",
                    "M63 P1",
                    "SYNC SetOut 2, va > 2, 0.3mm",
                    "SYNC SetOut 2, OFF, -4ms",
                    "SYNC Pulse 4, 9ms, 3ms",
                    "M62 P2\nM63 P2",
                    "SYNC SetOut 1, ON, len",
                ];
                write!(text, "{}", self.tape.of(&list))
            }
            14 if self.has(feature::AOUT) && self.tape.chance(3) => {
                let list = [
                    "SetAout 1, 1200mV",
                    "SetAout 1, 1mV * (va AND 4095)",
                    "M68 E1 Q3.3",
                    "M68 E1 Q[va]",
                    "SYNC SetAout 1, 1V, 0.3mm",
                    "SYNC SetAout 1, 0V, -4ms",
                    "SYNC SetAout 1, vb * 1mV, 3ms",
                    "SYNC SetAout 1, 2V, len",
                    "M67 E1 Q0.7\nM67 E1 Q0",
                ];
                write!(text, "{}", self.tape.of(&list))
            }
            14 => write!(text, "{stop} G90 G1 X[150st] Y[len] Z-1 {feed}"),
            16 => {
                let list = [
                    "G90 G0 X5 Y3",
                    "G90 G0 Z2",
                    "G64 G90 F1250 G1 X7",
                    "G64 G90 G1 Y-2 F600",
                    "G64 G90 G1 Z-1 F600",
                    "G91 G64 G1 X1 Y2 Z-1 F900",
                    "G90 G0 X[spots(ia, 0)] Y[spots(ia, 1)]",
                ];
                write!(text, "{}", self.tape.of(&list))
            }
            17 => {
                let calls = self.functions > 0;
                let x = if calls { "fun_0(vb) AND 7" } else { "vb AND 7" };
                write!(text, "{stop} {mode} G1 Y[va AND 3] X[{x}] {feed}")
            }
            _ => {
                let list = ["G90 G38.3 Z-4 F240", "G28 Z0", "G53 G90 G0 Y3"];
                write!(text, "{}", self.tape.of(&list))
            }
        };
        self.line(&text);
    }

    /// The value of an axis word.
    fn word(&mut self) -> String {
        match self.tape.pick(5) {
            0 => "5".to_owned(),
            1 => "12.5".to_owned(),
            2 => "-1.2".to_owned(),
            3 => format!("[{}]", self.length(1)),
            _ => "[va AND 7]".to_owned(),
        }
    }

    /// A canned cycle: R, Z and Q in either unit, words that fail, words with effects.
    fn cycle(&mut self) -> String {
        let mode = self.tape.of(&["G90", "G90", "G91"]);
        let back = self.tape.of(&["G98", "G99"]);
        let z = self.tape.of(&["-2", "[-150st]", "[-1mm - len / 9]", "-3"]);
        let r = self.tape.of(&["1", "[80st]", "[len / 7]", "0.5"]);
        let hole = match self.tape.pick(4) {
            0 => format!("G82 Z{z} R{r} P{}", self.tape.of(&["0.03", "[va AND 63]"])),
            1 => format!("G83 Z{z} R{r} Q{}", self.tape.of(&["1.1", "[70st]", "[va AND 3]"])),
            2 if mode == "G91" => format!("G81 Z{z} R{r} L{}", self.tape.of(&["2", "[vb AND 3]"])),
            _ => format!("G81 Z{z} R{r}"),
        };
        let calls = self.functions > 0 && self.tape.chance(3);
        let x = match calls {
            true => "[fun_0(va) AND 7]",
            false => self.tape.of(&["5", "12.5", "-1.2", "[len]", "[len * va]"]),
        };
        format!("{back} {mode} G61 {hole} X{x}")
    }
}
