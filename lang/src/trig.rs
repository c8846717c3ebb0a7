//! SIN, COS, ATAN2 and SCALE: one text for compiler, engines and firmware, by sums and shifts of 32 bits.
//!
//! CORDIC: a vector is turned by angles of which each is the arc tangent of half the last one's tangent. Angles here
//! are 1/16384 of a thousandth of a degree, so that 90 degrees fit and 24 turns leave 3 millionths of a degree. Against
//! the exact value SIN and COS are off by 0.501 of 1/10000 at most (the rounding alone is 0.5), ATAN2 by 0.51 of 1/1000
//! degree; the tests measure it.

use crate::fault::Fault;

/// Arc tangents of 1, 1/2, 1/4...
const TURNS: [i32; 24] = [
    737_280_000,
    435_241_798,
    229_969_813,
    116_736_268,
    58_594_662,
    29_325_895,
    14_666_526,
    7_333_711,
    3_666_911,
    1_833_463,
    916_732,
    458_366,
    229_183,
    114_592,
    57_296,
    28_648,
    14_324,
    7_162,
    3_581,
    1_790,
    895,
    448,
    224,
    112,
];
/// Bits of an angle below 1/1000 degree.
const ANGLE: u8 = 14;
/// Bits of a sine below 1/10000.
const SINE: u8 = 16;
/// 10000 with the bits of [`SINE`], times what all turns shorten.
const UNIT: i32 = 397_969_283;
/// 180 degrees.
const HALF: i32 = 180_000;

/// Turns `(x, y)` and counts the angle in `z`: until `z` is 0, or, `to_axis`, until `y` is.
fn turned(mut x: i32, mut y: i32, mut z: i32, to_axis: bool) -> (i32, i32) {
    let mut shift = 0_u8;
    for turn in &TURNS {
        let (dx, dy) = (y >> shift, x >> shift);
        let forward = if to_axis { y < 0 } else { z >= 0 };
        if forward {
            x -= dx;
            y += dy;
            z -= turn;
        } else {
            x += dx;
            y -= dy;
            z += turn;
        }
        shift += 1;
    }
    (y, z)
}

/// The sine of an angle in 1/1000 degrees, in 1/10000.
pub fn sin(angle: i32) -> i32 {
    let mut rest = angle % (2 * HALF);
    let mut negative = rest < 0;
    if negative {
        rest = -rest;
    }
    if rest >= HALF {
        rest -= HALF;
        negative = !negative;
    }
    if rest > HALF / 2 {
        rest = HALF - rest;
    }
    let (y, _) = turned(UNIT, 0, rest << ANGLE, false);
    let size = (y + (1 << (SINE - 1))) >> SINE;
    if negative { -size } else { size }
}

/// The cosine of an angle in 1/1000 degrees, in 1/10000.
pub fn cos(angle: i32) -> i32 {
    sin(HALF / 2 - angle % (2 * HALF))
}

/// The angle of the direction `(x, y)` in 1/1000 degrees, above -180000 to 180000; 0 where both are 0.
pub fn atan2(y: i32, x: i32) -> i32 {
    let (mut a, mut b) = (x.unsigned_abs(), y.unsigned_abs());
    if a | b == 0 {
        return 0;
    }
    while a | b >= 1 << 29 {
        a >>= 1;
        b >>= 1;
    }
    while a | b < 1 << 28 {
        a <<= 1;
        b <<= 1;
    }
    let (_, z) = turned(a as i32, b as i32, 0, true);
    let mut angle = ((z + (1 << (ANGLE - 1))) >> ANGLE).clamp(0, HALF / 2);
    if x < 0 {
        angle = HALF - angle;
    }
    if y < 0 { -angle } else { angle }
}

/// `value * times / over`, rounded half away from zero; the product has 64 bits.
///
/// # Errors
/// F02 when `over` is 0, F01 when the result does not fit into 32 bits.
pub fn mul_div(value: i32, times: i32, over: i32) -> Result<i32, Fault> {
    let negative = (value ^ times ^ over) < 0;
    let (times, over) = (times.unsigned_abs(), over.unsigned_abs());
    if over == 0 {
        return Err(Fault::DivisionByZero);
    }
    // Bit by bit: the product in `high` and `low`, then the quotient in `low` and the rest in `high`.
    let (mut high, mut low) = (0_u32, value.unsigned_abs());
    for _ in 0..32 {
        let mut carry = false;
        if low & 1 != 0 {
            (high, carry) = high.overflowing_add(times);
        }
        low = low >> 1 | high << 31;
        high = high >> 1 | u32::from(carry) << 31;
    }
    if high >= over {
        return Err(Fault::Overflow);
    }
    for _ in 0..32 {
        let carry = high >> 31 != 0;
        high = high << 1 | low >> 31;
        low <<= 1;
        if carry || high >= over {
            high = high.wrapping_sub(over);
            low |= 1;
        }
    }
    if high >= over - high {
        low = low.checked_add(1).ok_or(Fault::Overflow)?;
    }
    if low > i32::MAX as u32 + u32::from(negative) {
        return Err(Fault::Overflow);
    }
    let size = low as i32;
    Ok(if negative { size.wrapping_neg() } else { size })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{HALF, atan2, cos, mul_div, sin};
    use crate::fault::Fault;

    #[test]
    fn every_sine_is_the_nearest_but_for_a_thousandth() {
        let mut worst = 0.0_f64;
        for angle in -2 * HALF..=2 * HALF {
            let exact = (f64::from(angle) / 1000.0).to_radians().sin() * 10_000.0;
            worst = worst.max((f64::from(sin(angle)) - exact).abs());
            assert_eq!(cos(angle), sin(angle + HALF / 2), "{angle}");
        }
        assert!(worst < 0.501, "{worst} of 1/10000");
        for (angle, wanted) in [(0, 0), (30_000, 5000), (90_000, 10_000), (270_000, -10_000)] {
            assert_eq!(sin(angle), wanted);
        }
        assert_eq!((cos(0), cos(60_000), cos(90_000), cos(180_000)), (10_000, 5000, 0, -10_000));
    }

    #[test]
    fn directions_on_the_axes_are_exact() {
        for size in [1, 7, 1000, 1 << 28, i32::MAX] {
            assert_eq!(atan2(0, size), 0);
            assert_eq!(atan2(size, size), 45_000);
            assert_eq!(atan2(size, 0), 90_000);
            assert_eq!(atan2(size, -size), 135_000);
            assert_eq!(atan2(0, -size), HALF);
            assert_eq!(atan2(-size, -size), -135_000);
            assert_eq!(atan2(-size, 0), -90_000);
        }
        assert_eq!(atan2(0, 0), 0);
        assert_eq!(atan2(i32::MIN, i32::MIN), -135_000);
    }

    #[test]
    fn products_have_64_bits() {
        assert_eq!(mul_div(i32::MAX, i32::MAX, i32::MAX), Ok(i32::MAX));
        assert_eq!(mul_div(i32::MIN, 1, 1), Ok(i32::MIN));
        assert_eq!(mul_div(i32::MIN, -1, 1), Err(Fault::Overflow));
        assert_eq!(mul_div(i32::MIN, i32::MIN, i32::MIN), Ok(i32::MIN));
        assert_eq!(mul_div(5, 1, 2), Ok(3));
        assert_eq!(mul_div(-5, 1, 2), Ok(-3));
        assert_eq!(mul_div(0, 1, 0), Err(Fault::DivisionByZero));
    }

    proptest! {
        #[test]
        fn angles_are_the_nearest_but_for_a_hundredth(y: i32, x: i32, down in 0..31_u8) {
            let (y, x) = (y >> down, x >> down);
            prop_assume!(x != 0 || y != 0);
            let exact = f64::from(y).atan2(f64::from(x)).to_degrees() * 1000.0;
            let off = (f64::from(atan2(y, x)) - exact).abs();
            prop_assert!(off < 0.51, "{off} of 1/1000 degree");
        }

        #[test]
        fn any_sine_is_that_of_the_angle_within_a_turn(angle: i32) {
            prop_assert_eq!(sin(angle), sin(angle.rem_euclid(2 * HALF)));
            prop_assert_eq!(cos(angle), cos(angle.rem_euclid(2 * HALF)));
        }

        #[test]
        fn scaling_is_that_of_wide_numbers(value: i32, times: i32, over: i32, down in 0..31_u8) {
            let over = over >> down;
            let wide = i128::from(value) * i128::from(times);
            let exact = match i128::from(over) {
                0 => Err(Fault::DivisionByZero),
                over => {
                    let size = (2 * wide.abs() + over.abs()) / (2 * over.abs());
                    let exact = size * wide.signum() * over.signum();
                    i32::try_from(exact).map_err(|_| Fault::Overflow)
                }
            };
            prop_assert_eq!(mul_div(value, times, over), exact);
        }
    }
}
