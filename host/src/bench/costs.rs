//! Planning times of a line on the part that plans it while the one before plays: of each VM instruction and of the whole.
//! Slow points are bounded by these times ([`crate::course`]).
//!
//! The emulated chip executes one instruction at a time and is inspected in between.

use std::collections::{BTreeMap, BTreeSet};

use emulator::Board;
use lang::back::disasm;
use lang::image::Image;
use lang::isa::Op;
use lang::profile::Profile;
use lang::wire::{CRC_START, crc16};

use super::stand::{Stand, fast_mill, image_for, image_on};
use super::{Sink, at_most};
use crate::board::G2553;
use crate::course::{self, costs};

/// Vector of the step interrupt (SLAS735, interrupt vector addresses).
const STEP: u16 = 0xFFFA;
/// `mov.b @r5+, r12`: the VM takes an instruction, or an operand.
const TAKES: u16 = 0x457C;
/// The VM's program counter.
const PC: usize = 5;
/// Bit of a slot's mask: a line of a course begins with it.
const BEGINS: u16 = 1 << 15;
/// The line under way ends at speed (`M_THROUGH`).
const THROUGH: u8 = 4;
/// A program runs (`RUN` of the image).
const RUNS: u8 = 2;
/// It has failed.
const FAILED: u8 = 4;
/// The next line of a course waits (`M_NEXT` of the image).
const WAITS: u8 = 8;

/// The main loop executes it, and not the VM's core: a round goes by.
fn is_of_main_loop(op: Op) -> bool {
    matches!(op, Op::Err | Op::Erl | Op::Course | Op::ToSteps | Op::ToLength)
}

/// A board with a program of the machine that has been started, to be looked at.
struct Watched {
    board: Board,
    /// Code of the program, and where its instructions begin.
    code: Vec<u8>,
    starts: BTreeSet<usize>,
}

impl Watched {
    fn of(profile: &Profile, image: &[u8]) -> Result<Watched, String> {
        let mut stand = Stand::on(&G2553, profile)?;
        stand.upload(image)?;
        let mut board = stand.copy();
        board.plant_mut().stop_at_output = false;
        board.plant_mut().switches = [None; 3];
        board.plant_mut().press_start(true);
        let state = board.symbol("RUN").ok_or("the image has no RUN")?;
        let end = board.cycles() + 3 * 16_000_000;
        while board.peek8(state) != RUNS && board.cycles() < end {
            board.run_us(1);
        }
        board.plant_mut().press_start(false);
        let parsed = Image::new(image).map_err(|flaw| format!("{flaw:?}"))?;
        let starts = disasm::instructions(&parsed).iter().map(|insn| insn.pc).collect();
        Ok(Watched { board, code: parsed.code.to_vec(), starts })
    }

    fn at(&self, symbol: &str) -> Result<u16, String> {
        self.board.symbol(symbol).ok_or_else(|| format!("the image has no {symbol}"))
    }

    /// Cycles so far, but for those of interrupts.
    fn outside(&self) -> u64 {
        let interrupts = self.board.stats().interrupts.values();
        self.board.cycles() - interrupts.map(|one| one.total).sum::<u64>()
    }

    /// The same but for step interrupts alone.
    fn between_steps(&self) -> u64 {
        let steps = self.board.stats().interrupts.get(&STEP);
        self.board.cycles() - steps.map_or(0, |one| one.total)
    }
}

/// Scripts that execute the VM's instructions with the numbers for which they take longest. `SetOut 1, OFF` ends what is looked at.
const SCRIPTS: &[&str] = &[
    // Constants, cells, sums.
    "DIM i, a, b, c, d, e\nFOR i = 1 TO 40\na = 0: b = 1: c = 127: d = 250: e = 12000\na = 100000: b = 32000: c = 300000: d = 123456789: e = -5\n\
     a = a + b: b = a - c: c = c + 1: d = d + 1: a = i + b\nNEXT\n",
    // Products, quotients, roots, shifts.
    "DIM i, a, b, c, d\nd = 1\nFOR i = 1 TO 31\na = 46340: b = a * a: b = b * -1: c = 2147483647: b = c / 1: b = c / d: b = c MOD 7: b = -c / 3: b = c MOD -d\n\
     b = SQR(c): b = SQR(i): b = SQR(1 << (i - 1)): a = 1 << i: a = -1 >> i: a = c / 65535: a = c / 65537: a = c MOD 65537: a = i * i: a = -c * d: a = 65535 * 32767\nNEXT\n",
    // Lesser, greater, bits, comparisons, jumps.
    "DIM i, a, b, c\nFOR i = -20 TO 20\na = MIN(i, -i): b = MAX(i, -i): c = ABS(i): c = -i: a = i AND 7: a = i OR b: a = i XOR b: a = NOT i\n\
     a = (i < 0) + (i = 0) + (i > 0) + (i <= b) + (i >= b) + (i <> b)\nIF i < 0 THEN b = 1\nIF i = 0 THEN b = 1\nIF i > 0 THEN b = 1\nIF i <= a THEN b = 1\nIF i >= a THEN b = 1\nIF i <> a THEN b = 1\n\
     IF a THEN b = 2\nIF i < 0 ANDALSO b > 3 THEN b = 1\nIF i < 0 ORELSE b > 3 THEN b = 1\nSELECT CASE i\nCASE 1, 2, 3\nc = 1\nCASE 5 TO 9\nc = 2\nCASE ELSE\nc = 3\nEND SELECT\nNEXT\n",
    // Loops, arrays.
    "DIM i, a, q(5)\nFOR i = 0 TO 4\nq(i) = i: a = q(i)\nNEXT\nFOR i = 1 TO 1000 STEP 100\nNEXT\nFOR i = 1000 TO 1 STEP -99\nNEXT\nFOR i = 300 TO 340\nNEXT\nFOR i = 1 TO q(4) STEP q(1)\nNEXT\n\
     FOR i = 1 TO a\nNEXT\nREPEAT 5\nEND REPEAT\ni = 0\nDO\ni = i + 1\nLOOP UNTIL i > 20\nWHILE i > 0\ni = i - 1\nWEND\n",
    // Calls.
    "DIM i, a\nFOR i = 1 TO 20\nGOSUB g\nx_\ny_ i\na = f_(i) + f_(f_(i))\na = ERR: a = ERL\nNEXT\nEND\ng:\nRETURN\nSUB x_\nEND SUB\nSUB y_(v)\nIF v > 3 THEN EXIT SUB\nv = v + 1\nEND SUB\nFUNCTION f_(n)\nRETURN n + 1\nEND FUNCTION\n",
    // Tables, units.
    "DIM i, a, l AS LENGTH, s AS STEPS\nTABLE t = 1, 2, 3, 4\nTABLE u(2) = 1, 2; 3, 40000; 5, 6\nTABLE w(3) = 1, 2, 3; 100000, 2000000000, -5\nFOR i = 0 TO 1\n\
     a = t(i): a = u(i, 0): a = u(i, 1): a = w(i, 0): a = w(i, 1): a = w(i, 2): l = LENGTH(X, 48000st): s = STEPS(X, 120mm): s = STEPS(Y, l): l = LENGTH(Z, s)\nNEXT\n",
];

/// The most cycles of the VM's instructions, from taking one to taking the next, interrupts apart; with the main loop's round
/// of those that it executes.
///
/// # Errors
/// The board does not run the scripts.
pub fn instructions() -> Result<BTreeMap<Op, u64>, String> {
    let mill = Profile::built_in("mill").map_err(|error| error.to_string())?;
    let mut most = BTreeMap::new();
    for script in SCRIPTS {
        let text = script.replace("\nEND\n", "\nSetOut 1, OFF\nEND\n");
        let text = format!("{text}SetOut 1, OFF\n");
        let (_, image) = image_for(&mill, &text)?;
        let mut watched = Watched::of(&mill, &image)?;
        watched.instructions(&mut most)?;
    }
    Ok(most)
}

impl Watched {
    fn instructions(&mut self, most: &mut BTreeMap<Op, u64>) -> Result<(), String> {
        let [code, enters] = [self.at("VM_CODE")?, self.at("pasapas_vm_run")?];
        let mut last: Option<(Op, u64)> = None;
        let mut fresh = false;
        let (end, state) = (self.board.cycles() + 16_000_000, self.at("RUN")?);
        while self.board.cycles() < end && self.board.peek8(state) == RUNS {
            let pc = self.board.reg(0);
            if pc == enters {
                fresh = true;
            }
            if self.board.peek16(pc) == TAKES {
                let at = usize::from(self.board.reg(PC).wrapping_sub(self.board.peek16(code)));
                if self.starts.contains(&at) {
                    let now = self.outside();
                    if let Some((op, from)) = last
                        && (!fresh || is_of_main_loop(op))
                    {
                        let own = most.entry(op).or_insert(0);
                        *own = (*own).max(now - from);
                    }
                    fresh = false;
                    let Some((op, _)) = Op::decode(self.code[at]) else { break };
                    let shape = lang::isa::shape(self.code[at]);
                    let effect =
                        shape.is_none_or(|shape| shape.class() == lang::isa::Class::Effect);
                    last = (!effect).then_some((op, now));
                }
            }
            self.board.step();
        }
        Ok(())
    }
}

/// How the chip came from one line of a course to the next, s.
#[derive(Clone, Copy, Debug)]
pub struct Junction {
    /// From the beginning of the window until the next line is planned, step interrupts apart.
    pub planned_s: f64,
    /// From then on, or from when there was room for it, until its first segment waits: the same.
    pub shaped_s: f64,
}

/// The junctions of a program with slow points that runs to its end while a host asks all the while, or never.
///
/// # Errors
/// The board does not run it.
pub fn junctions(
    profile: &Profile,
    image: &[u8],
    question: Option<&[u8]>,
) -> Result<Vec<Junction>, String> {
    let mut watched = Watched::of(profile, image)?;
    let at = |name| watched.at(name);
    let (slot_at, motion, segment) = (at("STEP_SLOT")?, at("MOTION")?, at("course_line")?);
    let left = at("LEFT")?;
    let (run, state) = (at("SLOT0")?, at("RUN")?);
    let size = at("SLOT1")? - run;
    let second = |cycles: u64| cycles as f64 / 16e6;
    let mut found = Vec::new();
    // Of the last three changes of a segment: when, and when by the processor's time between steps.
    let mut changes = [(0, 0); 3];
    let (mut slot, mut waited) = (0, false);
    let (mut free, mut planned, mut shaped) = (None, None, None);
    let mut asks = watched.board.cycles();
    let end = asks + 16_000_000 * 20;
    while watched.board.cycles() < end && watched.board.peek8(state) == RUNS {
        if let Some(body) = question
            && asks <= watched.board.cycles()
        {
            let crc = body.iter().fold(CRC_START, |crc, &byte| crc16(crc, byte));
            let sent = watched.board.uart_send(&[body, &crc.to_le_bytes()].concat());
            asks = sent + 16 * (1_500 + 180 * u64::from(body[5]));
            watched.board.uart_take();
        }
        watched.board.step();
        let board = &watched.board;
        let now = || (board.cycles(), watched.between_steps());
        let flags = board.peek8(motion);
        let waits = flags & WAITS != 0;
        if free.is_none()
            && flags & (WAITS | THROUGH) == THROUGH
            && (board.peek16(left) | board.peek16(left + 2)) == 0
        {
            free = Some(now());
        }
        if waits && planned.is_none() && board.reg(0) == segment {
            planned = Some(now());
        }
        if planned.is_some() && shaped.is_none() {
            let marked = |at: u16| board.peek16(at + 8) != 0 && board.peek16(at + 10) & BEGINS != 0;
            if marked(run) || marked(run + size) {
                shaped = Some(now());
            }
        }
        let own = board.peek16(slot_at);
        if own != slot {
            slot = own;
            changes = [changes[1], changes[2], now()];
        }
        if waited && !waits {
            let [_, last, _] = changes;
            if let (Some(free), Some(planned), Some(shaped)) =
                (free.take(), planned.take(), shaped.take())
            {
                let room = if planned.0 > last.0 { planned.1 } else { last.1 };
                found.push(Junction {
                    planned_s: second(planned.1.saturating_sub(free.1)),
                    shaped_s: second(shaped.1.saturating_sub(room)),
                });
            }
        }
        waited = waits;
    }
    if watched.board.peek8(state) == FAILED {
        return Err(format!("a fault behind {} junctions", found.len()));
    }
    Ok(found)
}

/// Questions of a host that take long to answer: places and speeds, the state of the run, coils; a hundred registers.
const QUESTIONS: [[u8; 6]; 3] =
    [[1, 3, 0x09, 0x60, 0, 24], [1, 3, 0x13, 0x88, 0, 100], [1, 1, 0, 0, 0, 16]];

/// Lines of a path at the mill's top, by their axes.
const WORDS: [(&str, &str); 3] = [
    ("line_planned_x", "X0.9"),
    ("line_planned_xy", "X0.9 Y0.75"),
    ("line_planned_xyz", "X0.9 Y0.75 Z-0.6"),
];

/// Figures of the G2553: `vm_costs`, an instruction's measured cycles at most, as a part of what slow points count for it;
/// `line_planned_x`, `_xy` and `_xyz`, what a line of one to three axes takes until it is planned, while a host asks all
/// the while, and `line_shaped` its first segment behind that.
///
/// # Errors
/// The board does not run the programs.
pub fn run(sink: Sink<'_>) -> Result<(), String> {
    let each = instructions()?.into_iter();
    let parts =
        each.map(|(op, cycles)| cycles as f64 / 16.0 / f64::from(costs::instruction_us(op)));
    sink(at_most("vm_costs", "%", 100.0 * parts.fold(0.0, f64::max), 100.0, 100.0))?;
    let profile = fast_mill(8_000, 25_000)?;
    let mut shaped = 0.0;
    for ((figure, words), must) in WORDS.into_iter().zip(G2553.part.course_us) {
        let text = format!("G0 X0 Y0 Z0\nG91\nF4800\nREPEAT 40\nG1 {words}\nEND REPEAT\n");
        let (_, image) = image_on(&G2553.part, &profile, &text)?;
        let mut planned = 0.0;
        for question in &QUESTIONS {
            for junction in junctions(&profile, &image, Some(question))? {
                planned = f64::max(planned, junction.planned_s);
                shaped = f64::max(shaped, junction.shaped_s);
            }
        }
        let must = f64::from(must);
        sink(at_most(figure, "us", planned * 1e6, must, must))?;
    }
    sink(at_most("line_shaped", "us", shaped * 1e6, course::SHAPED_S * 1e6, course::SHAPED_S * 1e6))
}

#[cfg(test)]
mod tests {
    use lang::isa::{Class, ROWS, shape};
    use lang::part::G2553;

    use super::{Op, costs, instructions};

    /// Instructions that no script of [`super::SCRIPTS`] has: of parts with more memory or handlers, of programs of more than 255
    /// bytes of tables or code, and those that only the compiler's own programs have.
    const UNSEEN: &[Op] = &[
        Op::End,
        Op::LoadFar,
        Op::StoreFar,
        Op::Word,
        Op::Drop,
        Op::Dup,
        Op::Over,
        Op::CallFar,
        Op::TableFar,
        Op::Check,
        Op::Course,
        Op::Leave,
        Op::OnError,
        Op::OnErrorStop,
        Op::ResumeNext,
        Op::More,
        Op::Resume,
        Op::Sin,
        Op::Cos,
        Op::Atan2,
        Op::MulDiv,
    ];

    #[test]
    fn no_instruction_takes_longer_than_slow_points_count_for_it() {
        let measured = instructions().expect("the scripts run");
        for row in ROWS {
            let own = shape(row.code).expect("a row of the table");
            if own.class() == Class::Effect || UNSEEN.contains(&row.op) {
                continue;
            }
            let us =
                *measured.get(&row.op).unwrap_or_else(|| panic!("{:?} was not measured", row.op))
                    as f64
                    / 16.0;
            let counted = f64::from(costs::instruction_us(row.op));
            assert!(us <= counted, "{:?} takes {us} us, counted are {counted}", row.op);
            assert!(counted <= 2.0 * us + 6.0, "{:?} takes {us} us, counted are {counted}", row.op);
        }
        assert_eq!(G2553.clock, 16_000_000);
    }
}
