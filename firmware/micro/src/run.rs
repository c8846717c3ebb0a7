//! An interpreter for tests: runs micro-code on whatever memory, registers and routines of instructions its
//! [`World`] has. It knows which flags the machine leaves at what; to look at any other is an error.

use std::fmt;

use crate::decode::{Code, Kind, Op, Place, Wrong, decode};
use crate::isa::{FAULTED, Formula, NOT_YET, Own};

/// Flags: `None` for one that the machine leaves at nothing that its notation tells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags {
    /// Zero.
    pub z: Option<bool>,
    /// Negative.
    pub n: Option<bool>,
    /// Carry: no borrow.
    pub c: Option<bool>,
    /// Overflow.
    pub v: Option<bool>,
}

impl Flags {
    /// All of them known.
    #[must_use]
    pub const fn of(z: bool, n: bool, c: bool, v: bool) -> Flags {
        Flags { z: Some(z), n: Some(n), c: Some(c), v: Some(v) }
    }

    /// Of a sum or difference of `bits` bits; the carry is in the bit above.
    fn sum(a: u32, b: u32, sum: u64, bits: u32) -> Flags {
        let top = |x: u64| x >> (bits - 1) & 1 == 1;
        let (a, b) = (u64::from(a), u64::from(b));
        let zero = sum & ((1 << bits) - 1) == 0;
        let over = top(a) == top(b) && top(a) != top(sum);
        Flags::of(zero, top(sum), sum >> bits & 1 == 1, over)
    }

    /// Of `a - b` in `bits` bits.
    fn compared(a: u32, b: u32, bits: u32) -> Flags {
        let mask = (1u64 << bits) - 1;
        let inverse = !u64::from(b) & mask;
        let sum = (u64::from(a) & mask) + inverse + 1;
        Flags::sum((u64::from(a) & mask) as u32, inverse as u32, sum, bits)
    }

    /// Of a value's bits: carry says that it is not zero.
    const fn tested(value: u8) -> Flags {
        Flags::of(value == 0, value & 0x80 != 0, value != 0, false)
    }
}

/// What routines find and leave.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Registers {
    /// r13:r12.
    pub acc: u32,
    /// r8: 4 * axis.
    pub axis: u16,
    /// r9: the record, or whatever is read from.
    pub record: u16,
    /// The flags.
    pub flags: Flags,
}

impl Registers {
    fn low(&self) -> u16 {
        self.acc as u16
    }

    fn set_low(&mut self, low: u16) {
        self.acc = self.acc & 0xFFFF_0000 | u32::from(low);
    }
}

/// How a routine of instructions ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Called {
    /// Its caller goes on, at the address behind the bytes that it took.
    On(u16),
    /// It ended its caller.
    Ended,
}

/// What micro-code runs in.
pub trait World: Code {
    /// Writes a byte.
    fn set_byte(&mut self, at: u16, value: u8);
    /// Runs a routine of instructions, whose own bytes in the code begin at `behind`.
    fn call(&mut self, routine: u16, behind: u16, registers: &mut Registers) -> Called;
    /// An operation of scaled numbers: from plus to most, and bound.
    fn scaled(&mut self, op: Formula, acc: u32, x: u32) -> u32;
    /// An integer as a scaled number.
    fn new_scaled(&mut self, value: u32) -> u32;
    /// Writes a word.
    fn set_word(&mut self, at: u16, value: u16) {
        let [low, high] = value.to_le_bytes();
        self.set_byte(at, low);
        self.set_byte(at.wrapping_add(1), high);
    }
}

/// How a routine of micro-code ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// It returned.
    Returned,
    /// Instructions go on here.
    Instructions(u16),
}

/// Why it cannot go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trap {
    /// No operation stands there.
    Wrong(u16, Wrong),
    /// It looks at this flag, which nothing has left.
    Flag(u16, char),
    /// Too many operations.
    Endless(u16),
}

impl fmt::Display for Trap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Trap::Wrong(at, wrong) => write!(f, "{at:04x}: {wrong}"),
            Trap::Flag(at, flag) => write!(f, "{at:04x}: looks at {flag}, which nothing has left"),
            Trap::Endless(at) => write!(f, "{at:04x}: does not end"),
        }
    }
}

/// What `WANTED` and `BELOW` return.
const ILLEGAL_VALUE: u16 = 3;
/// Operations that one call may take.
const MOST: u32 = 100_000;

/// What comes after an operation.
enum Then {
    On,
    To(u16),
    Return,
    Leave,
}

/// Runs the routine of micro-code at an address.
///
/// # Errors
/// When the code is not what the verifier accepts, or does not end.
pub fn run(world: &mut impl World, at: u16, registers: &mut Registers) -> Result<End, Trap> {
    let mut left = MOST;
    routine(world, at, registers, &mut left)
}

fn routine(
    world: &mut impl World,
    mut at: u16,
    registers: &mut Registers,
    left: &mut u32,
) -> Result<End, Trap> {
    loop {
        *left = left.checked_sub(1).ok_or(Trap::Endless(at))?;
        let op = decode(world, at).map_err(|wrong| Trap::Wrong(at, wrong))?;
        let then = match op.kind {
            Kind::Formula(formula, place) => {
                self::formula(world, formula, place, registers);
                Then::On
            }
            Kind::Routine(n) => {
                let table = world.symbol("micro_table").unwrap_or_default();
                let address = world.word(table + 2 * n as u16);
                call(world, address, &op, registers, left)?
            }
            Kind::Own(Own::Call) => call(world, op.operands[0], &op, registers, left)?,
            Kind::Own(own) => self::own(world, own, &op, registers)?,
        };
        match then {
            Then::On => at = op.end(),
            Then::To(place) => at = place,
            Then::Return => return Ok(End::Returned),
            Then::Leave => return Ok(End::Instructions((op.end() + 1) & !1)),
        }
    }
}

fn call(
    world: &mut impl World,
    routine: u16,
    op: &Op,
    registers: &mut Registers,
    left: &mut u32,
) -> Result<Then, Trap> {
    if routine & 1 == 0 {
        // Bytes that a routine takes stand directly behind its number.
        let behind = if op.kind == Kind::Own(Own::Call) { op.end() } else { op.at + 1 };
        return Ok(match world.call(routine, behind, registers) {
            Called::On(next) => Then::To(next),
            Called::Ended => {
                registers.flags = Flags::default();
                Then::Return
            }
        });
    }
    // The machine has just looked whether the address is odd.
    registers.flags = Flags::of(false, false, true, false);
    match self::routine(world, routine, registers, left)? {
        End::Returned => Ok(Then::On),
        End::Instructions(at) => {
            // They return in the routine's place.
            world.call(at, at, registers);
            Ok(Then::On)
        }
    }
}

fn formula(world: &mut impl World, op: Formula, place: Place, r: &mut Registers) {
    let base = if place.record { r.record } else { 0 };
    let at = place.at.wrapping_add(base).wrapping_add(if place.axis { r.axis } else { 0 });
    let long = |world: &mut dyn World| {
        let high = if place.short { 0 } else { world.word(at.wrapping_add(2)) };
        let x = u32::from(high) << 16 | u32::from(world.word(at));
        if place.new { world.new_scaled(x) } else { x }
    };
    let store = |world: &mut dyn World, value: u32| {
        world.set_word(at, value as u16);
        world.set_word(at.wrapping_add(2), (value >> 16) as u16);
    };
    let mut flags = Flags::default();
    match op {
        Formula::Load => {
            r.acc = long(world);
            flags = Flags::compared(r.acc >> 16, 0, 16);
        }
        Formula::Store => store(world, r.acc),
        Formula::Add | Formula::Sub => {
            let x = long(world);
            let (x, carry) = if op == Formula::Sub { (!x, 1) } else { (x, 0) };
            let sum = u64::from(r.acc) + u64::from(x) + carry;
            flags = Flags::sum(r.acc, x, sum, 32);
            r.acc = sum as u32;
            flags.z = Some(r.acc >> 16 == 0);
        }
        Formula::Word => {
            r.set_low(world.word(at));
            flags = Flags::compared(r.low().into(), 0, 16);
        }
        Formula::Put => world.set_word(at, r.low()),
        Formula::Cmp => flags = Flags::compared(r.low().into(), world.word(at).into(), 16),
        Formula::Clear => world.set_word(at, 0),
        Formula::Base => r.record = world.word(at),
        Formula::Bound => {
            r.acc = r.acc.min(long(world));
            store(world, r.acc);
        }
        _ => {
            let x = long(world);
            r.acc = world.scaled(op, r.acc, x);
        }
    }
    r.flags = flags;
}

/// Flags behind one of the machine's own operations that does not go elsewhere, and what comes then.
fn own(world: &mut impl World, own: Own, op: &Op, r: &mut Registers) -> Result<Then, Trap> {
    let n = |k: usize| op.operands.get(k).copied().unwrap_or_default();
    let byte = |world: &dyn World| world.byte(n(0));
    let number = n(op.operands.len().saturating_sub(1)) as u8;
    let jump = |yes: bool| if yes { Then::To(op.targets[0]) } else { Then::On };
    let before = r.flags;
    let mut flags = Flags::default();
    let mut then = Then::On;
    if let Some((flag, wanted)) = own.looks_at() {
        let value = match flag {
            'Z' => before.z,
            'N' => before.n,
            'C' => before.c,
            _ => before.v,
        };
        let is = value.ok_or(Trap::Flag(op.at, flag))? == wanted;
        match own {
            Own::Wanted if !is => {
                r.set_low(ILLEGAL_VALUE);
                then = Then::Return;
            }
            Own::Wanted => {}
            Own::ZeroIfCarry => r.acc = if is { 0 } else { r.acc },
            _ => then = jump(is),
        }
    } else {
        match own {
            Own::Call => unreachable!("calls are not the machine's own work"),
            Own::End => then = Then::Leave,
            Own::Return => then = Then::Return,
            Own::Done | Own::NotYet | Own::Fault => {
                r.set_low(match own {
                    Own::Done => 0,
                    Own::NotYet => NOT_YET,
                    _ => FAULTED + n(0),
                });
                then = Then::Return;
            }
            Own::Literal => r.acc = n(0).into(),
            Own::Word16 => r.set_low(n(0)),
            Own::Profile => {
                let board = world.symbol("BOARD").unwrap_or_default();
                let value = world.byte(world.word(board).wrapping_add(n(0)));
                r.set_low(value.into());
                flags = Flags::compared(value.into(), 0, 16);
            }
            Own::AddI => {
                let (a, b) = (u32::from(r.low() as u8), u32::from(number));
                flags = Flags::sum(a, b, u64::from(a + b), 8);
                r.set_low((a + b) as u8 as u16);
            }
            Own::AndI | Own::TestI => {
                let value = r.low() as u8 & number;
                flags = Flags::tested(value);
                if own == Own::AndI {
                    r.set_low(value.into());
                }
            }
            Own::Goto => then = jump(true),
            Own::Switch => {
                let place = op.at.wrapping_add(1).wrapping_add(r.low());
                let offset = i16::from(world.byte(place).cast_signed());
                then = Then::To(place.wrapping_add_signed(offset));
            }
            Own::FirstAxis => r.axis = 8,
            Own::NextAxis => {
                r.axis = r.axis.wrapping_sub(4);
                then = jump(r.axis < 0x8000);
            }
            Own::UpAxis => {
                r.axis = r.axis.wrapping_add(4);
                then = jump(r.axis != 12);
            }
            Own::OrReturn if r.low() != 0 => then = Then::Return,
            Own::OrReturn => flags = Flags::compared(0, 0, 16),
            Own::TestLong => {
                let both = (r.acc >> 16) as u16 | r.low();
                flags = Flags::compared(both.into(), 0, 16);
            }
            Own::Half => {
                let low = r.low();
                r.set_low((low.cast_signed() >> 1).cast_unsigned());
                flags = Flags::of(r.low() == 0, r.low() >= 0x8000, low & 1 == 1, false);
            }
            Own::Below if r.low() >= n(0) => {
                r.set_low(ILLEGAL_VALUE);
                then = Then::Return;
            }
            Own::Below | Own::CmpI => flags = Flags::compared(r.low().into(), n(0).into(), 16),
            Own::Case => then = jump(r.low() == n(0)),
            Own::CaseNot => then = jump(r.low() != n(0)),
            Own::Shift => {
                // Nothing stays nothing: as the machine has it, when the upper half is 0.
                if r.acc >> 16 != 0 {
                    r.acc = r.acc.wrapping_add(u32::from(number) << 24);
                }
            }
            Own::Get => r.acc = byte(world).into(),
            Own::Put => world.set_byte(n(0), r.low() as u8),
            Own::Let => world.set_byte(n(0), number),
            Own::BitsOn => world.set_byte(n(0), byte(world) | number),
            Own::BitsOff => world.set_byte(n(0), byte(world) & !number),
            Own::Compare => flags = Flags::compared(r.low().into(), byte(world).into(), 8),
            Own::Up => {
                let value = u32::from(byte(world));
                flags = Flags::sum(value, 1, u64::from(value + 1), 8);
                world.set_byte(n(0), (value + 1) as u8);
            }
            Own::AxisOn => world.set_byte(n(0), byte(world) | r.low() as u8),
            Own::AxisOff => world.set_byte(n(0), byte(world) & !(r.low() as u8)),
            Own::IfNotAxis => {
                let bit = if r.axis == 0 { 1 } else { (r.axis >> 1) as u8 };
                then = jump(byte(world) & bit == 0);
            }
            Own::IfZero => then = jump(byte(world) == 0),
            Own::IfSet => then = jump(byte(world) != 0),
            Own::IfAny => then = jump(byte(world) & number != 0),
            Own::IfNone => then = jump(byte(world) & number == 0),
            Own::IfIs => then = jump(byte(world) == number),
            Own::IfIsNot => then = jump(byte(world) != number),
            _ => unreachable!("it looks at a flag"),
        }
    }
    // A jump that is taken and an end leave the flags of before.
    r.flags = if matches!(then, Then::On) { flags } else { before };
    Ok(then)
}
