//! Integer arithmetic of the planner: 32 bits wide, no floats, and division only once per segment.

/// Product that stays at `u32::MAX` instead of wrapping.
pub fn mul_sat(a: u32, b: u32) -> u32 {
    a.saturating_mul(b)
}

// On the chip the 64-bit product and quotient are assembly (board/math.rs): the compiler's own
// 64-bit division is 600 bytes.
// SAFETY: both are pure functions of their arguments by the compiler's own calling convention.
#[cfg(target_arch = "msp430")]
#[allow(unsafe_code)]
unsafe extern "C" {
    safe fn pasapas_mul_div(a: u32, b: u32, c: u32) -> u32;
    safe fn pasapas_fraction(a: u32, c: u32) -> u32;
}

/// `a * b / c`, rounded down, with a 64-bit product; `u32::MAX` when it does not fit or `c` is 0.
#[cfg(target_arch = "msp430")]
#[inline(always)]
pub fn mul_div(a: u32, b: u32, c: u32) -> u32 {
    pasapas_mul_div(a, b, c)
}

/// `a * b / c`, rounded down, with a 64-bit product; `u32::MAX` when it does not fit or `c` is 0.
#[cfg(not(target_arch = "msp430"))]
pub fn mul_div(a: u32, b: u32, c: u32) -> u32 {
    if c == 0 {
        return u32::MAX;
    }
    u32::try_from(u64::from(a) * u64::from(b) / u64::from(c)).unwrap_or(u32::MAX)
}

/// `a * 2^32 / c`, rounded down; `u32::MAX` unless `a` is below `c`.
#[cfg(target_arch = "msp430")]
#[inline(always)]
pub fn fraction(a: u32, c: u32) -> u32 {
    pasapas_fraction(a, c)
}

/// `a * 2^32 / c`, rounded down; `u32::MAX` unless `a` is below `c`.
#[cfg(not(target_arch = "msp430"))]
pub fn fraction(a: u32, c: u32) -> u32 {
    if a >= c {
        return u32::MAX;
    }
    ((u64::from(a) << 32) / u64::from(c)) as u32
}

/// `value * 2^by`, rounded down for a negative `by`; `u32::MAX` when it does not fit.
pub fn scale(value: u32, by: i8) -> u32 {
    if by <= 0 {
        value.checked_shr(u32::from(by.unsigned_abs())).unwrap_or(0)
    } else if value.leading_zeros() >= u32::from(by.unsigned_abs()) {
        value << by
    } else if value == 0 {
        0
    } else {
        u32::MAX
    }
}

/// Number of significant bits, 0..=32.
pub fn bits(value: u32) -> u8 {
    (32 - value.leading_zeros()) as u8
}

/// Square root, rounded down.
pub fn isqrt(value: u32) -> u16 {
    let mut rest = value;
    let mut root: u32 = 0;
    let mut bit: u32 = 1 << 30;
    while bit != 0 {
        let trial = root + bit;
        root >>= 1;
        if rest >= trial {
            rest -= trial;
            root += bit;
        }
        bit >>= 2;
    }
    root as u16
}

/// Length of a vector, to 1 part in 2^14: the largest component is brought to 15 bits, so that
/// three squares fit into 32 bits.
pub fn length(v: [u32; 3]) -> u32 {
    let largest = v[0] | v[1] | v[2];
    if v[0] == largest && v[1] | v[2] == 0 || v[1] == largest && v[0] | v[2] == 0 {
        return largest;
    }
    let by = 15 - bits(largest) as i8;
    let mut sum = 0;
    for c in v {
        let c = scale(c, by);
        sum += c * c;
    }
    scale(u32::from(isqrt(sum)), -by)
}

/// `sqrt(a * b)` to 1 part in 2^14, without a 64-bit product.
pub fn root_of_product(a: u32, b: u32) -> u32 {
    let ea = bits(a) as i8 - 16;
    let mut eb = bits(b) as i8 - 16;
    if (ea + eb) % 2 != 0 {
        eb += 1;
    }
    let root = isqrt(mul_sat(scale(a, -ea), scale(b, -eb)));
    scale(u32::from(root), (ea + eb) / 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn isqrt_is_the_floor_of_the_root(v: u32) {
            let r = u64::from(isqrt(v));
            prop_assert!(r * r <= u64::from(v) && (r + 1) * (r + 1) > u64::from(v));
        }

        #[test]
        fn length_is_close(x in 0u32..1 << 30, y in 0u32..1 << 30, z in 0u32..1 << 30, cut in 0u8..30) {
            let v = [x >> cut, y >> cut, z >> cut];
            let exact = v.iter().map(|&c| f64::from(c).powi(2)).sum::<f64>().sqrt();
            prop_assert!((f64::from(length(v)) - exact).abs() <= exact / 8192.0 + 1.0);
        }

        #[test]
        fn root_of_product_is_close(a: u32, b: u32, cut in 0u8..31) {
            let (a, b) = (a >> cut, b >> (31 - cut));
            let exact = (f64::from(a) * f64::from(b)).sqrt();
            prop_assert!((f64::from(root_of_product(a, b)) - exact).abs() <= exact / 8192.0 + 1.0);
        }

        #[test]
        fn scale_shifts_and_saturates(v: u32, by in -40i8..40) {
            let exact = (f64::from(v) * f64::from(by).exp2()).floor().min(f64::from(u32::MAX));
            prop_assert_eq!(f64::from(scale(v, by)), exact);
        }
    }

    #[test]
    fn mul_div_saturates() {
        assert_eq!(mul_div(3_000_000_000, 3_000_000_000, 3_000_000_000), 3_000_000_000);
        assert_eq!(mul_div(u32::MAX, 2, 1), u32::MAX);
        assert_eq!(mul_div(1, 1, 0), u32::MAX);
    }
}
