//! SIN, COS, ATAN2 and SCALE, and the angles of arcs: one text for compiler, engines and firmware.
//!
//! CORDIC: a vector is turned by angles of which each is the arc tangent of half the last one's tangent. Angles here
//! are whole turns of 2^32, to 1 part in 2^28. Against the exact value SIN and COS are off by 0.501 of 1/10000 at most
//! (the rounding alone is 0.5), ATAN2 by 0.51 of 1/1000 degree; the tests measure it.
//!
//! What wants a product of 64 bits takes the function that makes it, `a * b / c` rounded down, `u32::MAX` where that does
//! not fit or `c` is 0: on the chip it is assembly, elsewhere [`wide`].

use crate::fault::Fault;

/// `a * b / c`, rounded down; `u32::MAX` when it does not fit or `c` is 0.
pub fn wide(a: u32, b: u32, c: u32) -> u32 {
    let quotient = (u64::from(a) * u64::from(b)).checked_div(u64::from(c));
    quotient.and_then(|quotient| u32::try_from(quotient).ok()).unwrap_or(u32::MAX)
}

/// atan(2^-i) of a turn of 2^32; from the last one on each is half the one before.
const ATAN: [u32; 13] = [
    0x2000_0000,
    0x12E4_051E,
    0x09FB_385B,
    0x0511_11D4,
    0x028B_0D43,
    0x0145_D7E1,
    0x00A2_F61E,
    0x0051_7C55,
    0x0028_BE53,
    0x0014_5F2F,
    0x000A_2F98,
    0x0005_17CC,
    0x0002_8BE6,
];
/// 10000 with 16 bits behind the point, times what all turns shorten.
const UNIT: i32 = 397_969_283;
/// 180 degrees.
const HALF: i32 = 180_000;

/// Turns a vector onto the first axis and gives the angle that it had, or by `angle`, at most a quarter, either way.
#[inline(never)]
fn turned(v: &mut [i32; 2], angle: u32, to_axis: bool) -> u32 {
    let [mut x, mut y] = *v;
    let mut rest = angle;
    for i in 0..28_usize {
        let step = ATAN.get(i).copied().unwrap_or_else(|| ATAN[12] >> (i - 12));
        let back = if to_axis { y > 0 } else { rest.cast_signed() < 0 };
        if back {
            (x, y) = (x + (y >> i), y - (x >> i));
            rest = rest.wrapping_add(step);
        } else {
            (x, y) = (x - (y >> i), y + (x >> i));
            rest = rest.wrapping_sub(step);
        }
    }
    *v = [x, y];
    rest
}

/// Angle of a vector whose parts are below 2^29, 2^32 to a turn, to 1 part in 2^28; 0 of no length.
#[inline(never)]
pub fn angle(v: [i32; 2]) -> u32 {
    let [mut x, mut y] = v;
    let mut half = 0;
    if x < 0 {
        (x, y) = (-x, -y);
        half = 1 << 31;
    }
    while (x.unsigned_abs() | y.unsigned_abs()) >> 28 == 0 {
        if x == 0 && y == 0 {
            return 0;
        }
        (x, y) = (x << 1, y << 1);
    }
    turned(&mut [x, y], half, true)
}

/// The sine of an angle in 1/1000 degrees, in 1/10000.
pub fn sin(angle: i32, wide: impl Fn(u32, u32, u32) -> u32) -> i32 {
    shifted_sine(angle, 0, wide)
}

/// The cosine of an angle in 1/1000 degrees, in 1/10000.
pub fn cos(angle: i32, wide: impl Fn(u32, u32, u32) -> u32) -> i32 {
    shifted_sine(angle, 1 << 30, wide)
}

/// The sine of an angle in 1/1000 degrees and `ahead`, 2^32 to a turn.
#[inline(never)]
fn shifted_sine(angle: i32, ahead: u32, wide: impl Fn(u32, u32, u32) -> u32) -> i32 {
    let mut rest = angle % (2 * HALF);
    if rest < 0 {
        rest += 2 * HALF;
    }
    let turn = wide(rest as u32, 1 << 31, HALF as u32).wrapping_add(ahead);
    // From a quarter to three it is the opposite of that half a turn away.
    let opposite = turn.wrapping_add(1 << 30) >> 31 != 0;
    let mut v = [if opposite { -UNIT } else { UNIT }, 0];
    turned(&mut v, if opposite { turn.wrapping_sub(1 << 31) } else { turn }, false);
    (v[1] + (1 << 15)) >> 16
}

/// The angle of the direction `(x, y)` in 1/1000 degrees, -180000 to 180000; 0 where both are 0.
#[inline(never)]
pub fn atan2(mut y: i32, mut x: i32, wide: impl Fn(u32, u32, u32) -> u32) -> i32 {
    if (x.unsigned_abs() | y.unsigned_abs()) >> 28 != 0 {
        (x, y) = (x >> 3, y >> 3);
    }
    let turn = angle([x, y]).cast_signed().unsigned_abs();
    // Twice the thousandths, then rounded. The side is that of `y`: at a half turn the angle's own hangs on the last bit.
    let size = ((wide(turn, 22_500, 1 << 27) + 1) >> 1).cast_signed();
    if y < 0 { -size } else { size }
}

/// `value * times / over`, rounded half away from zero; the product has 64 bits.
///
/// # Errors
/// F02 when `over` is 0, F01 when the result does not fit into 32 bits.
#[inline(never)]
pub fn mul_div(
    value: i32,
    times: i32,
    over: i32,
    wide: impl Fn(u32, u32, u32) -> u32,
) -> Result<i32, Fault> {
    let negative = (value ^ times ^ over) < 0;
    let (value, times, over) = (value.unsigned_abs(), times.unsigned_abs(), over.unsigned_abs());
    if over == 0 {
        return Err(Fault::DivisionByZero);
    }
    let mut size = wide(value, times, over);
    if size == u32::MAX {
        return Err(Fault::Overflow);
    }
    // What is left is less than the divisor: its lower half tells it.
    let rest = value.wrapping_mul(times).wrapping_sub(size.wrapping_mul(over));
    if rest >= over - rest {
        size += 1;
    }
    let result = if negative { size.wrapping_neg() } else { size }.cast_signed();
    if size != 0 && (result < 0) != negative {
        return Err(Fault::Overflow);
    }
    Ok(result)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{HALF, wide};
    use crate::fault::Fault;

    fn sin(angle: i32) -> i32 {
        super::sin(angle, wide)
    }

    fn cos(angle: i32) -> i32 {
        super::cos(angle, wide)
    }

    fn atan2(y: i32, x: i32) -> i32 {
        super::atan2(y, x, wide)
    }

    fn mul_div(value: i32, times: i32, over: i32) -> Result<i32, Fault> {
        super::mul_div(value, times, over, wide)
    }

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
