//! Exact products and quotients through 64 bits: positions, and the increments of a line.

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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn isqrt_is_the_floor_of_the_root(v: u32) {
            prop_assert_eq!(u32::from(isqrt(v)), v.isqrt());
        }
    }

    #[test]
    fn mul_div_saturates() {
        assert_eq!(mul_div(3_000_000_000, 3_000_000_000, 3_000_000_000), 3_000_000_000);
        assert_eq!(mul_div(u32::MAX, 2, 1), u32::MAX);
        assert_eq!(mul_div(1, 1, 0), u32::MAX);
    }
}
