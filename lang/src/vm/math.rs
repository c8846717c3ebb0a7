//! Arithmetic of the language: 32 bits, every overflow is a fault (lang/README.md, Values and kinds).

use crate::fault::Fault;
use crate::isa::Op;
use crate::trig;

/// An instruction of two operands, left and right.
///
/// # Errors
/// F01, F02, F04 as the opcode table says.
pub fn binary(op: Op, left: i32, right: i32) -> Result<i32, Fault> {
    let truth = |value: bool| Ok(i32::from(value));
    match op {
        Op::Add => left.checked_add(right).ok_or(Fault::Overflow),
        Op::Sub => left.checked_sub(right).ok_or(Fault::Overflow),
        Op::Mul => left.checked_mul(right).ok_or(Fault::Overflow),
        Op::Div if right == 0 => Err(Fault::DivisionByZero),
        Op::Div => left.checked_div(right).ok_or(Fault::Overflow),
        Op::Mod if right == 0 => Err(Fault::DivisionByZero),
        Op::Mod => Ok(left.wrapping_rem(right)),
        Op::Min => Ok(left.min(right)),
        Op::Max => Ok(left.max(right)),
        Op::Atan2 => Ok(trig::atan2(left, right, trig::wide)),
        Op::And => Ok(left & right),
        Op::Or => Ok(left | right),
        Op::Xor => Ok(left ^ right),
        Op::Shl => Ok(left << shift(right)?),
        Op::Shr => Ok(left >> shift(right)?),
        Op::Eq | Op::JumpEq => truth(left == right),
        Op::Ne | Op::JumpNe => truth(left != right),
        Op::Lt | Op::JumpLt => truth(left < right),
        Op::Le | Op::JumpLe => truth(left <= right),
        Op::Gt | Op::JumpGt => truth(left > right),
        Op::Ge | Op::JumpGe => truth(left >= right),
        _ => Err(Fault::ImageRefused),
    }
}

fn shift(count: i32) -> Result<u32, Fault> {
    u32::try_from(count).ok().filter(|&count| count < 32).ok_or(Fault::BadShift)
}

/// An instruction of one operand.
///
/// # Errors
/// F01, F20 as the opcode table says.
pub fn unary(op: Op, value: i32) -> Result<i32, Fault> {
    match op {
        Op::Neg => value.checked_neg().ok_or(Fault::Overflow),
        Op::Abs => value.checked_abs().ok_or(Fault::Overflow),
        Op::Sqr => root(value).ok_or(Fault::ValueRange),
        Op::Sin => Ok(trig::sin(value, trig::wide)),
        Op::Cos => Ok(trig::cos(value, trig::wide)),
        _ => Err(Fault::ImageRefused),
    }
}

/// Integer square root, bit by bit; `None` below 0.
fn root(value: i32) -> Option<i32> {
    let mut rest = u32::try_from(value).ok()?;
    let mut root = 0;
    let mut bit = 1u32 << 30;
    while bit != 0 {
        let trial = root + bit;
        root >>= 1;
        if rest >= trial {
            rest -= trial;
            root += bit;
        }
        bit >>= 2;
    }
    i32::try_from(root).ok()
}

/// `value * times / over`, rounded half away from zero.
///
/// # Errors
/// F01 when the result does not fit into 32 bits; F20 when `over` is 0.
pub fn scale(value: i32, times: u16, over: u16) -> Result<i32, Fault> {
    if over == 0 {
        return Err(Fault::ValueRange);
    }
    let product = u64::from(value.unsigned_abs()) * u64::from(times);
    let size = (product + u64::from(over / 2)) / u64::from(over);
    // Half away from zero: over / 2 is rounded down, so an odd divisor has no exact half.
    let size = i64::try_from(size).map_err(|_| Fault::Overflow)?;
    i32::try_from(if value < 0 { -size } else { size }).map_err(|_| Fault::Overflow)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{Op, binary, root, scale, unary};
    use crate::fault::Fault;

    #[test]
    fn the_edges_of_the_language_page() {
        assert_eq!(binary(Op::Div, i32::MIN, -1), Err(Fault::Overflow));
        assert_eq!(binary(Op::Mod, i32::MIN, -1), Ok(0));
        assert_eq!(binary(Op::Mod, 5, 0), Err(Fault::DivisionByZero));
        assert_eq!(binary(Op::Div, -7, 2), Ok(-3));
        assert_eq!(binary(Op::Mod, -7, 2), Ok(-1));
        assert_eq!(binary(Op::Shl, 3, 31), Ok(i32::MIN));
        assert_eq!(binary(Op::Shr, -8, 1), Ok(-4));
        assert_eq!(binary(Op::Shl, 1, 32), Err(Fault::BadShift));
        assert_eq!(binary(Op::Shr, 1, -1), Err(Fault::BadShift));
        assert_eq!(unary(Op::Neg, i32::MIN), Err(Fault::Overflow));
        assert_eq!(unary(Op::Abs, i32::MIN), Err(Fault::Overflow));
        assert_eq!(unary(Op::Sqr, -1), Err(Fault::ValueRange));
    }

    #[test]
    fn scaling_rounds_half_away_from_zero() {
        assert_eq!(scale(5, 1, 2), Ok(3));
        assert_eq!(scale(-5, 1, 2), Ok(-3));
        assert_eq!(scale(7, 1, 3), Ok(2));
        assert_eq!(scale(8, 1, 3), Ok(3));
        assert_eq!(scale(i32::MIN, 1, 1), Ok(i32::MIN));
        assert_eq!(scale(i32::MAX, 2, 1), Err(Fault::Overflow));
    }

    proptest! {
        #[test]
        fn the_root_is_the_floor_of_the_real_one(value in 0i32..) {
            let r = i64::from(root(value).unwrap());
            prop_assert!(r * r <= i64::from(value) && i64::from(value) < (r + 1) * (r + 1));
        }
    }
}
