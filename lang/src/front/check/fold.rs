//! Arithmetic on constants with the language's own semantics.

use crate::fault::Fault;
use crate::hir::{BinOp, UnOp};
use crate::profile::Scale;
use crate::trig;

/// One operand.
pub(super) fn unary(op: UnOp, a: i32) -> Result<i32, Fault> {
    match op {
        UnOp::Neg => a.checked_neg().ok_or(Fault::Overflow),
        UnOp::BitNot => Ok(!a),
        UnOp::LogNot => Ok(i32::from(a == 0)),
        UnOp::Abs => a.checked_abs().ok_or(Fault::Overflow),
        UnOp::Sgn => Ok(a.signum()),
        UnOp::Sqr => a.checked_isqrt().ok_or(Fault::ValueRange),
        UnOp::Sin => Ok(trig::sin(a, trig::wide)),
        UnOp::Cos => Ok(trig::cos(a, trig::wide)),
    }
}

/// Two operands.
pub(super) fn binary(op: BinOp, a: i32, b: i32) -> Result<i32, Fault> {
    let shift = || u32::try_from(b).ok().filter(|n| *n < 32).ok_or(Fault::BadShift);
    match op {
        BinOp::Add => a.checked_add(b).ok_or(Fault::Overflow),
        BinOp::Sub => a.checked_sub(b).ok_or(Fault::Overflow),
        BinOp::Mul => a.checked_mul(b).ok_or(Fault::Overflow),
        BinOp::Div if b == 0 => Err(Fault::DivisionByZero),
        BinOp::Div => a.checked_div(b).ok_or(Fault::Overflow),
        BinOp::Mod if b == 0 => Err(Fault::DivisionByZero),
        // The least number MOD -1 is 0, not a fault.
        BinOp::Mod => Ok(a.wrapping_rem(b)),
        BinOp::And => Ok(a & b),
        BinOp::Or => Ok(a | b),
        BinOp::Xor => Ok(a ^ b),
        BinOp::Shl => Ok(a << shift()?),
        BinOp::Shr => Ok(a >> shift()?),
        BinOp::Eq => Ok(i32::from(a == b)),
        BinOp::Ne => Ok(i32::from(a != b)),
        BinOp::Lt => Ok(i32::from(a < b)),
        BinOp::Le => Ok(i32::from(a <= b)),
        BinOp::Gt => Ok(i32::from(a > b)),
        BinOp::Ge => Ok(i32::from(a >= b)),
        BinOp::Min => Ok(a.min(b)),
        BinOp::Max => Ok(a.max(b)),
        BinOp::Atan2 => Ok(trig::atan2(a, b, trig::wide)),
    }
}

/// um to steps of an axis, half away from zero.
pub(super) fn to_steps(scale: Scale, um: i32) -> Result<i32, Fault> {
    ratio(um, scale.steps, scale.um)
}

/// Steps of an axis to um, half away from zero.
pub(super) fn to_length(scale: Scale, steps: i32) -> Result<i32, Fault> {
    scale.length(steps).ok_or(Fault::Overflow)
}

fn ratio(value: i32, num: u16, den: u16) -> Result<i32, Fault> {
    let product = i64::from(value) * i64::from(num);
    let den = i64::from(den.max(1));
    let magnitude = (product.abs() + den / 2) / den;
    // An odd denominator has no tie; for an even one den / 2 rounds the tie away from zero.
    i32::try_from(magnitude * product.signum()).map_err(|_| Fault::Overflow)
}

#[cfg(test)]
mod tests {
    use super::{binary, to_length, to_steps, unary};
    use crate::fault::Fault;
    use crate::hir::{BinOp, UnOp};
    use crate::profile::Scale;

    #[test]
    fn the_edges_fault_as_the_language_says() {
        assert_eq!(binary(BinOp::Div, i32::MIN, -1), Err(Fault::Overflow));
        assert_eq!(binary(BinOp::Mod, i32::MIN, -1), Ok(0));
        assert_eq!(binary(BinOp::Mod, -7, 3), Ok(-1));
        assert_eq!(binary(BinOp::Mod, 7, 0), Err(Fault::DivisionByZero));
        assert_eq!(binary(BinOp::Shl, 1, 32), Err(Fault::BadShift));
        assert_eq!(binary(BinOp::Shr, -8, 1), Ok(-4));
        assert_eq!(unary(UnOp::Neg, i32::MIN), Err(Fault::Overflow));
        assert_eq!(unary(UnOp::Sqr, 99), Ok(9));
        assert_eq!(unary(UnOp::Sqr, -1), Err(Fault::ValueRange));
    }

    #[test]
    fn conversions_round_half_away_from_zero() {
        let scale = Scale { steps: 400, um: 4000 };
        assert_eq!(to_steps(scale, 5), Ok(1));
        assert_eq!(to_steps(scale, -5), Ok(-1));
        assert_eq!(to_steps(scale, 4), Ok(0));
        assert_eq!(to_length(scale, 480), Ok(4800));
        assert_eq!(to_length(scale, i32::MAX), Err(Fault::Overflow));
        assert_eq!(to_steps(Scale { steps: 1, um: 3 }, -5), Ok(-2));
    }
}
