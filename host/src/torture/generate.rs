//! Generated programs with the worlds around them.
//!
//! A program is made of the choices of a tape, so that proptest can shrink one that differs.

mod expr;
mod gcode;
mod machine;
mod tape;
mod world;

use lang::part::{F5529, Part};
use lang::record::feature;
use tape::Tape;

/// The timer of each generated program.
pub const TIMER: &str = "tm";

/// A script and its world.
#[derive(Clone, Debug)]
pub struct Case {
    /// BASIC.
    pub script: String,
    /// Rhai.
    pub world: String,
    /// Axes move on their own: where one is depends on the instant.
    pub independent: bool,
}

/// Writes a program by the choices of a tape.
struct Writer<'t> {
    tape: Tape<'t>,
    out: String,
    arrays: bool,
    functions: usize,
    subs: usize,
    gosubs: usize,
    in_routine: bool,
    in_handler: bool,
    /// Loops around, innermost last.
    loops: Vec<&'static str>,
    /// FORs of one routine use different variables.
    counters: usize,
    /// Moves along a path: the device then has half the cells.
    path: bool,
    independent: bool,
    events: bool,
    /// Nothing hangs on an instant.
    still: bool,
    /// What it is to run on.
    part: Part,
}

/// Makes a case of a tape, of all that the language has.
pub fn generate(data: &[u16]) -> Case {
    write(data, false, F5529)
}

/// Makes a case of a tape without what the part lacks; it may still be too large for it.
pub fn generate_for(part: Part, data: &[u16]) -> Case {
    write(data, false, part)
}

/// Makes a case of a tape whose world answers the program instead of acting at times of its own:
/// an engine that takes longer for a statement sees the same.
pub fn generate_still(part: Part, data: &[u16]) -> Case {
    write(data, true, part)
}

fn write(data: &[u16], still: bool, part: Part) -> Case {
    let mut tape = Tape::new(data);
    let flavour = tape.pick(8);
    let has = |wanted: u16| part.features & wanted != 0;
    let mut writer = Writer {
        arrays: matches!(flavour, 0..=3 | 6),
        functions: 1 + tape.pick(2),
        subs: 1 + tape.pick(2),
        gosubs: 1,
        tape,
        out: String::new(),
        in_routine: false,
        in_handler: false,
        loops: Vec::new(),
        counters: 0,
        path: matches!(flavour, 4 | 5 | 7),
        independent: matches!(flavour, 6 | 7) && has(feature::START),
        events: matches!(flavour, 2 | 5 | 6) && has(feature::EVENTS),
        still,
        part,
    };
    writer.program();
    let world = writer.world();
    Case { script: writer.out, world, independent: writer.independent }
}

impl Writer<'_> {
    pub(super) fn has(&self, wanted: u16) -> bool {
        self.part.features & wanted != 0
    }

    fn line(&mut self, text: &str) {
        self.out.push_str(text);
        self.out.push('\n');
    }

    fn one_of(&mut self, list: &[&str]) {
        let text = self.tape.of(list);
        self.out.push_str(text);
        self.out.push('\n');
    }

    fn program(&mut self) {
        let errors = self.tape.chance(9) && self.has(feature::LINES);
        let first = self.tape.of(&["", "", " = 3", " = -1 + 6"]);
        self.line(&format!("DIM va{first}, vb, vc, len AS LENGTH, ia, ib"));
        let again = if self.has(feature::RETRY) { ", again" } else { "" };
        self.line(&format!("DIM {TIMER} AS TIMER{again}"));
        if self.arrays {
            let values = self.tape.of(&["", "", " = 7, va", " = 1, 2, vb - 1"]);
            self.line(&format!("DIM cells(3){values}"));
        }
        let keeps = self.tape.chance(4) && self.has(feature::KEEP);
        if keeps {
            self.line("KEEP kept");
        }
        // It takes more than 2 KB.
        let far = self.tape.chance(2) && self.part.segments > 4;
        if far {
            // Texts, tables and routines come to lie beyond the reach of short operands.
            for text in ["long ", "afar "] {
                self.line(&format!("PRINT \"{}\"", text.repeat(50)));
            }
            let values: Vec<String> = (0..140).map(|n| (n * 201).to_string()).collect();
            self.line(&format!("TABLE wide = {}", values.join(", ")));
            self.line("vb = wide(va AND 127)\npad\npad\npad\npad\npad\npad");
        }
        self.line("TABLE list = 3, 1, -4, 1000");
        if self.path {
            self.line("TABLE spots(2) = 1mm, 2mm; 3mm, 2.5mm; 0mm, 6mm");
        }
        self.line("TABLE pairs(2) = 1, 2; 3, 4; 5, 60000");
        if self.still {
            // What the world does at 0 has passed the inputs' filter.
            self.line("Wait 20ms");
        }
        if errors {
            self.line("ON ERROR GOTO oops");
        }
        if self.events {
            self.one_of(&["ON IN 3 RISE GOSUB edge", "ON IN 3 FALL GOSUB edge"]);
            if self.tape.chance(8) && !self.still {
                self.line("ON EVERY 70ms GOSUB tick");
            }
        }
        let count = 3 + self.tape.pick(8);
        self.block(count, 2);
        if errors && self.tape.chance(4) {
            self.line("ON ERROR STOP");
            self.block(2, 1);
        }
        if self.events && self.tape.chance(5) {
            self.one_of(&["ON IN 3 OFF", "ON EVERY OFF"]);
            self.block(2, 1);
        }
        self.line("fin:");
        self.line("PRINT va; \" \"; vb; \" \"; vc; \" \"; len");
        if self.still {
            // The board tells its variables by printing them.
            self.line("PRINT ia; \" \"; ib");
            if keeps {
                self.line("PRINT kept");
            }
            if self.arrays {
                self.line("PRINT cells(0); \" \"; cells(1); \" \"; cells(2)");
            }
        }
        self.line("END");
        self.line("gos_0:");
        self.simple();
        self.line("RETURN");
        if self.events {
            self.in_handler = true;
            self.line("edge:");
            self.line("PRINT \"edge\"");
            self.handled();
            self.line("RETURN");
            self.line("SUB tick");
            self.line("vc = vc XOR 5");
            self.line("END SUB");
            self.in_handler = false;
        }
        if errors {
            self.in_handler = true;
            self.line("oops:");
            self.line("PRINT \"F\"; ERR; \" \"; ERL");
            self.handled();
            if self.has(feature::RETRY) && self.tape.chance(5) {
                // Some failures go when a variable changes; others are given up.
                self.one_of(&["vb = vb + 1", "va = va / 2", "len = 1mm"]);
                self.line("again = again + 1\nIF again < 6 THEN RESUME");
            }
            self.one_of(&["RESUME NEXT", "RESUME NEXT", "GOTO fin", "END"]);
            self.in_handler = false;
        }
        self.routines();
        if far {
            // The most called stands first in the code.
            let steps = "vc = vc XOR 12345\n".repeat(50);
            self.line(&format!("SUB pad\nIF vc > -200000 THEN EXIT SUB\n{steps}END SUB"));
        }
    }

    /// A statement that a handler may have.
    fn handled(&mut self) {
        match self.tape.pick(5) {
            0 => self.line("Wait 15ms"),
            1 => self.line("vc = vc + 1"),
            2 => self.line("SetOut 5, ON"),
            3 => self.line("WaitIn? 4, ON, 20ms"),
            _ => self.line("PRINT vc"),
        }
    }

    fn routines(&mut self) {
        self.in_routine = true;
        let subs = std::mem::take(&mut self.subs);
        let functions = std::mem::take(&mut self.functions);
        for n in 0..functions {
            self.line(&format!("FUNCTION fun_{n}(arg)"));
            let value = self.tape.of(&["", "", " = arg", " = 2"]);
            self.line(&format!("DIM loc{value}"));
            self.counters = 0;
            self.simple();
            if self.tape.chance(6) {
                let condition = self.truth(1);
                self.line(&format!("IF {condition} THEN EXIT FUNCTION"));
            }
            let value = self.number(1);
            self.line(&format!("RETURN {value}"));
            self.line("END FUNCTION");
            // A later one may call those before it.
            self.functions = n + 1;
        }
        for n in 0..subs {
            self.line(&format!("SUB sub_{n}(arg)"));
            let value = self.tape.of(&["", "", " = arg", " = 2"]);
            self.line(&format!("DIM loc{value}"));
            self.counters = 0;
            self.block(2, 1);
            if self.tape.chance(5) {
                let condition = self.truth(0);
                let leave = self.tape.of(&["RETURN", "EXIT SUB"]);
                self.line(&format!("IF {condition} THEN {leave}"));
            }
            self.simple();
            self.line("END SUB");
            self.subs = n + 1;
        }
        self.in_routine = false;
    }

    fn block(&mut self, count: usize, depth: usize) {
        for _ in 0..count {
            if self.tape.is_over() {
                return;
            }
            self.statement(depth);
        }
    }

    fn statement(&mut self, depth: usize) {
        if depth == 0 {
            return self.simple();
        }
        let inner = 1 + self.tape.pick(2);
        match self.tape.pick(16) {
            0..=4 => self.simple(),
            5 => {
                let condition = self.truth(2);
                self.line(&format!("IF {condition} THEN"));
                self.block(inner, depth - 1);
                if self.tape.chance(6) {
                    let condition = self.truth(1);
                    self.line(&format!("ELSEIF {condition} THEN"));
                    self.block(1, depth - 1);
                }
                if self.tape.chance(8) {
                    self.line("ELSE");
                    self.block(1, depth - 1);
                }
                self.line("END IF");
            }
            6 => {
                let condition = self.truth(1);
                let (a, b) = (self.number(1), self.number(0));
                self.line(&format!("IF {condition} THEN va = {a} ELSE vb = {b}"));
            }
            7 => self.select(depth),
            8 | 9 if self.counters < 1 => self.for_loop(depth),
            10 => {
                self.line("WHILE vb < 5");
                self.looped("WHILE", 1, depth - 1);
                self.line("vb = vb + 2");
                self.line("WEND");
            }
            11 => {
                let head = self.tape.of(&["DO", "DO WHILE vc < 9", "DO UNTIL vc > 4"]);
                self.line(head);
                self.looped("DO", 1, depth - 1);
                self.line("vc = vc + 3");
                let tail = self.tape.of(&["LOOP UNTIL vc > 3", "LOOP WHILE vc < 2"]);
                self.line(if head == "DO" { tail } else { "LOOP" });
            }
            12 => {
                let count = self.tape.of(&["2", "0", "3", "(va AND 3)"]);
                self.line(&format!("REPEAT {count}"));
                self.looped("REPEAT", inner, depth - 1);
                self.line("END REPEAT");
            }
            13 => self.machine(),
            _ => self.simple(),
        }
    }

    fn looped(&mut self, kind: &'static str, count: usize, depth: usize) {
        self.loops.push(kind);
        self.block(count, depth);
        self.loops.pop();
    }

    fn select(&mut self, depth: usize) {
        let value = self.number(1);
        self.line(&format!("SELECT CASE {value}"));
        self.one_of(&["CASE 0, 7", "CASE vb", "CASE IS > 100"]);
        self.block(1, depth - 1);
        self.one_of(&["CASE 1 TO 9", "CASE IS <> vc", "CASE va TO vb, 3"]);
        self.block(1, depth - 1);
        if self.tape.chance(8) {
            self.line("CASE ELSE");
            self.block(1, depth - 1);
        }
        self.line("END SELECT");
    }

    fn for_loop(&mut self, depth: usize) {
        let var = if self.in_routine { "loc" } else { "ia" };
        self.counters += 1;
        let head = match self.tape.pick(6) {
            0 => format!("FOR {var} = 1 TO {}", self.tape.of(&["4", "40"])),
            1 => format!("FOR {var} = 5 TO 1 STEP -2"),
            2 => format!("FOR {var} = 0 TO (va AND 3)"),
            3 => format!("FOR {var} = 2147483645 TO 2147483647"),
            4 => format!("FOR {var} = vb TO vb + 6 STEP (va AND 3)"),
            _ => format!("FOR {var} = {}", self.tape.of(&["250 TO 300 STEP 40", "298 TO 300"])),
        };
        self.line(&head);
        self.looped("FOR", 2, depth - 1);
        self.line("NEXT");
        self.counters -= 1;
    }

    /// A statement without a block.
    fn simple(&mut self) {
        match self.tape.pick(20) {
            0..=3 => {
                let value = self.number(3);
                let name = self.number_name();
                self.line(&format!("{name} = {value}"));
            }
            4 if self.tape.chance(8) => {
                let (name, bit) = (self.number_name(), self.tape.of(&["0", "3", "31"]));
                let state = self.truth(1);
                match self.tape.chance(4) {
                    true => self.line("tm = 0s"),
                    false => self.line(&format!("{name}.{bit} = {state}")),
                }
            }
            5 if self.arrays => {
                let (at, value) = (self.tape.of(&["0", "2", "va", "(vb AND 1)"]), self.number(2));
                self.line(&format!("cells({at}) = {value}"));
            }
            6 => {
                let value = self.length(2);
                self.line(&format!("len = {value}"));
            }
            7 => {
                let name = self.number_name();
                let step = self.tape.of(&["+ 1", "- 1", "+ va", "+ 100"]);
                self.line(&format!("{name} = {name} {step}"));
            }
            8 | 9 => {
                let value = match self.tape.pick(6) {
                    0 => self.length(1),
                    1 => self.steps(),
                    2 => self.truth(1),
                    4 | 5 => self.shown(),
                    _ => self.number(2),
                };
                self.line(&format!("PRINT \"p\"; {value}"));
            }
            10 if self.subs > 0 => {
                let value = self.number(1);
                let n = self.tape.pick(self.subs);
                let call = match self.tape.pick(2) {
                    0 => format!("sub_{n} {value}"),
                    _ => format!("CALL sub_{n}({value})"),
                };
                self.line(&call);
            }
            11 if self.gosubs > 0 && !self.in_routine && !self.in_handler => {
                self.gosubs -= 1;
                self.line("GOSUB gos_0");
            }
            12 => {
                if let Some(kind) = self.loops.last().copied() {
                    let condition = self.truth(1);
                    let word = self.tape.of(&["EXIT", "CONTINUE"]);
                    // A CONTINUE would pass by what ends these loops.
                    let word = if matches!(kind, "WHILE" | "DO") { "EXIT" } else { word };
                    self.line(&format!("IF {condition} THEN {word} {kind}"));
                } else if !self.in_routine && self.tape.chance(3) {
                    let condition = self.truth(0);
                    self.line(&format!("IF {condition} THEN GOTO fin"));
                }
            }
            // Its cell would be that of what was interrupted.
            13 if !self.in_handler => {
                let condition = self.truth(1);
                let time = self.tape.of(&["5ms", "3ms", "0ms", "1ms * vb"]);
                self.line(&format!("WAIT UNTIL {condition}, {time}"));
            }
            _ => self.machine(),
        }
    }

    /// A statement that acts on the machine.
    fn machine(&mut self) {
        if self.path && self.tape.chance(9) {
            return self.gcode();
        }
        if self.independent && self.tape.chance(8) {
            return self.on_its_own();
        }
        let axis = self.axis();
        let text = match self.tape.pick(18) {
            0 => format!("SetOut {}, ON", self.tape.of(&["1", "2", "va", "6"])),
            1 => format!("SetOut 2, {}", self.truth(0)),
            2 => format!("Wait {}", self.tape.of(&["20ms", "1s", "0ms", "30ms * vb"])),
            3 => format!("SetPort {}", self.number(1)),
            4 => "Pulse 3, 25ms".to_owned(),
            5 => {
                let want = self.tape.of(&["ON", "OFF", "RISE", "FALL", "va > 2"]);
                let query = self.tape.of(&["?", ""]);
                format!("WaitIn{query} {}, {want}, 120ms", self.tape.of(&["3", "4", "vb"]))
            }
            6..=8 => format!("MoveAxe {axis}, {}", self.length(1)),
            9 => format!("MoveAxe {axis}, {}, 30mm/s", self.steps()),
            10 => format!("MoveRel {axis}, {}, 1500st/s, 200mm/s2", self.length(0)),
            11 => match self.tape.pick(3) {
                0 => format!("MoveRel {axis}, {}", self.length(1)),
                1 => format!("SetPos {axis}, 0mm"),
                _ => {
                    let by = self.length(0);
                    format!("MoveRel {axis}, -{by}, 20mm/s, 9000st/s2, 5000st/s2")
                }
            },
            12 => format!("SetPos {axis}, {}", self.length(0)),
            13 => self.tape.of(&["Home? X", "Home Y", "Home? Z"]).to_owned(),
            14 => {
                let sensor = self.tape.of(&["", ", 4", ", 3, OFF"]);
                let query = self.tape.of(&["?", ""]);
                format!("Probe{query} Z, -8mm, 4mm/s{sensor}")
            }
            15 => "ProbeMask Z, -6mm, 300st/s, 12, 0".to_owned(),
            16 => self.tape.of(&["Send 65", "Send va", "WaitChar? 66, 90ms"]).to_owned(),
            _ => {
                let list =
                    ["Motors OFF", "Motors ON, X", "vc = CHARIN()", "WaitStart", "Home Z, Y"];
                self.tape.of(&list).to_owned()
            }
        };
        self.line(&text);
    }

    fn on_its_own(&mut self) {
        let axis = self.axis();
        let text = match self.tape.pick(7) {
            0 | 1 => format!("START MoveAxe {axis}, {}, 40mm/s", self.length(0)),
            2 => format!("START MoveRel {axis}, 300st"),
            3 => {
                let speed = self.tape.of(&["500st/s", "-3mm/s", "va * 100st/s"]);
                format!("MoveSpeed {axis}, {speed}\nWait 40ms\nStopAxe {axis}")
            }
            4 => format!("StopAxe {axis}"),
            5 => self.tape.of(&["StopAll", "WaitMove X"]).to_owned(),
            _ => "WaitMove".to_owned(),
        };
        self.line(&text);
    }
}
