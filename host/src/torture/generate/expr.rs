//! Expressions of the generated programs, by kind.

use super::Writer;
use lang::record::feature;

/// Literals at the edges of the arithmetic.
const NUMBERS: [&str; 14] = [
    "0",
    "1",
    "2",
    "3",
    "5",
    "7",
    "10",
    "31",
    "32",
    "-1",
    "1000",
    "65536",
    "2147483647",
    "-2147483648",
];

impl Writer<'_> {
    /// A Number.
    pub(super) fn number(&mut self, depth: usize) -> String {
        if depth == 0 {
            return self.simple_number();
        }
        let d = depth - 1;
        match self.tape.pick(19) {
            0..=2 => self.simple_number(),
            3..=6 => {
                let (a, b) = (self.number(d), self.simple_number());
                let op = self.tape.of(&["+", "-", "*", "/", "MOD", "AND", "OR", "XOR"]);
                format!("({a} {op} {b})")
            }
            7 => {
                let (a, b) = (self.simple_number(), self.number(d));
                let op = self.tape.of(&["+", "-", "*", "AND"]);
                format!("({a} {op} {b})")
            }
            8 => {
                let a = self.number(d);
                let op = self.tape.of(&["<<", ">>"]);
                let count = self.tape.of(&["0", "1", "4", "31", "32", "va"]);
                format!("({a} {op} {count})")
            }
            9 => {
                let name = self.tape.of(&["ABS", "SGN", "SQR", "-", "NOT "]);
                let a = self.number(d);
                format!("({name}({a}))")
            }
            10 => {
                let name = self.tape.of(&["MIN", "MAX"]);
                let (a, b) = (self.simple_number(), self.simple_number());
                format!("{name}({a}, {b})")
            }
            11 if self.arrays => {
                let at = self.index(d);
                format!("cells({at})")
            }
            12 => {
                let at = self.index(d);
                format!("{}({at})", self.tape.of(&["list", "list"]))
            }
            13 => {
                let row = self.index(d);
                let column = self.tape.of(&["0", "1", "0", "vb"]);
                format!("pairs({row}, {column})")
            }
            14 if self.functions > 0 => {
                let a = self.number(d);
                let n = self.tape.pick(self.functions);
                format!("fun_{n}({a})")
            }
            15 => {
                let (a, b) = (self.length(0), self.length(0));
                format!("({a} / {b})")
            }
            17 if self.has(feature::MATHS) => self.turning(d),
            16 => {
                self.tape.of(&["ERR", "ERL", "COUNT(list)", "COUNT(pairs)", "INPORT()"]).to_owned()
            }
            _ => self.simple_number(),
        }
    }

    fn simple_number(&mut self) -> String {
        match self.tape.pick(4) {
            0 => NUMBERS[self.tape.pick(NUMBERS.len())].to_owned(),
            _ => self.number_name(),
        }
    }

    /// A Number variable that is in scope.
    pub(super) fn number_name(&mut self) -> String {
        let names: &[&str] = match (self.in_routine, self.in_handler) {
            (true, _) => &["va", "vb", "arg", "loc"],
            (_, true) => &["va", "vb", "vc"],
            _ => &["va", "vb", "vc", "va"],
        };
        self.tape.of(names).to_owned()
    }

    /// Mostly inside arrays and tables.
    fn index(&mut self, depth: usize) -> String {
        match self.tape.pick(6) {
            0 => "0".to_owned(),
            1 => "1".to_owned(),
            2 => "2".to_owned(),
            3 => "(ABS(va) MOD 3)".to_owned(),
            4 => "va".to_owned(),
            _ => self.number(depth.min(1)),
        }
    }

    /// A Length.
    pub(super) fn length(&mut self, depth: usize) -> String {
        if depth == 0 {
            return self.tape.of(&["5mm", "0.25mm", "12.5mm", "len", "350um", "0.1in"]).to_owned();
        }
        let d = depth - 1;
        match self.tape.pick(9) {
            0..=1 => self.length(0),
            2 => format!("({} + {})", self.length(d), self.length(0)),
            3 => format!("({} - {})", self.length(d), self.length(0)),
            4 => format!("({} * {})", self.length(0), self.tape.of(&["2", "va", "3"])),
            5 => format!("({} / {})", self.length(d), self.tape.of(&["2", "va", "3"])),
            6 => format!("{}({})", self.tape.of(&["PROBED", self.place("POS")]), self.axis()),
            7 => format!("LENGTH({}, {})", self.axis(), self.steps()),
            _ => format!("MIN({}, 15mm)", self.length(d)),
        }
    }

    /// SIN, COS, ATAN2 and SCALE of values of any size.
    fn turning(&mut self, depth: usize) -> String {
        let (a, b) = (self.number(depth), self.simple_number());
        match self.tape.pick(4) {
            0 => format!("SIN({a} * {})", self.tape.of(&["1mdeg", "1deg"])),
            1 => format!("COS({a} * {})", self.tape.of(&["1mdeg", "90deg"])),
            2 => format!("(ATAN2({a}, {b}) / 1mdeg)"),
            _ => {
                let [from, to, low] = [(); 3].map(|()| self.simple_number());
                let high = self.tape.of(&["0", "7", "-1000", "vb", "2147483647"]);
                format!("SCALE({a}, {from}, {to}, {low}, {high})")
            }
        }
    }

    /// A quantity of any size in a unit of its kind.
    pub(super) fn shown(&mut self) -> String {
        let (one, units): (_, &[&str]) = match self.tape.pick(7) {
            0 => return format!("{} IN {}", self.length(1), self.tape.of(&["mm", "um", "in"])),
            1 => return format!("{} IN st", self.steps()),
            2 => ("1um", &["mm", "in", "um"]),
            3 => ("1ms", &["s", "min", "ms"]),
            4 => ("1000um/s", &["mm/s", "mm/min", "in/min", "um/s"]),
            5 => ("1mm/s2", &["mm/s2", "um/s2"]),
            _ => return format!("({} * 1st/s) IN st/s", self.number(1)),
        };
        // Speeds have no unit as small as the stored one.
        let one = one.replace("1000um/s", "0.001mm/s");
        format!("({} * {one}) IN {}", self.number(1), self.tape.of(units))
    }

    /// Steps.
    pub(super) fn steps(&mut self) -> String {
        match self.tape.pick(6) {
            0 => "100st".to_owned(),
            1 => "725st".to_owned(),
            2 => format!("{}({})", self.place("POSST"), self.axis()),
            3 => format!("(33st * {})", self.tape.of(&["2", "va"])),
            4 => format!("PROBEDST({})", self.axis()),
            _ => {
                let length = self.length(0);
                format!("STEPS({}, {length})", self.axis())
            }
        }
    }

    /// An axis letter.
    pub(super) fn axis(&mut self) -> &'static str {
        self.tape.of(&["X", "Y", "Z"])
    }

    /// A condition.
    pub(super) fn truth(&mut self, depth: usize) -> String {
        let d = depth.saturating_sub(1);
        match self.tape.pick(if depth == 0 { 6 } else { 12 }) {
            0..=2 => {
                let (a, b) = (self.number(d), self.simple_number());
                format!("({a} {} {b})", self.relation())
            }
            3 => {
                let (a, b) = (self.length(0), self.length(d));
                format!("({a} {} {b})", self.relation())
            }
            4 => {
                let n = self.tape.of(&["1", "3", "4", "va", "5"]);
                format!("{}({n})", self.tape.of(&["IN", "OUT"]))
            }
            5 => {
                let name = self.tape.of(&["PROBEOK", "HOMED", self.place("MOVING")]);
                format!("{name}({})", self.axis())
            }
            6 => format!("(NOT {})", self.truth(d)),
            7..=9 => {
                let (a, b) = (self.truth(d), self.truth(0));
                format!("({a} {} {b})", self.tape.of(&["AND", "OR", "XOR", "ANDALSO", "ORELSE"]))
            }
            10 => self.tape.of(&["TIMEDOUT", "va.0", "(vb + 1).4", "va.31"]).to_owned(),
            _ => self.tape.of(&["(TIMER() < 90s)", "(tm < 90s)", "RISE(3)", "FALL(4)"]).to_owned(),
        }
    }

    /// A look at a place that changes with time is no matter of two engines' agreement while an
    /// axis moves on its own.
    fn place(&self, name: &'static str) -> &'static str {
        match name {
            _ if !self.independent => name,
            "POS" => "PROBED",
            "POSST" => "PROBEDST",
            _ => "PROBEOK",
        }
    }

    fn relation(&mut self) -> &'static str {
        self.tape.of(&["=", "<>", "<", "<=", ">", ">="])
    }
}
