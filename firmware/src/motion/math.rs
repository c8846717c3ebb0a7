//! Exact products and quotients through 64 bits: positions, and the increments of a line.

// On the chip the 64-bit product and quotient are assembly (shared/math.rs): the compiler's own
// 64-bit division is 600 bytes.
// SAFETY: both are pure functions of their arguments by the compiler's own calling convention.
#[cfg(target_arch = "msp430")]
#[allow(unsafe_code)]
unsafe extern "C" {
    safe fn pasapas_mul_div(a: u32, b: u32, c: u32) -> u32;
    safe fn pasapas_fraction(a: u32, c: u32) -> u32;
    safe fn pasapas_high(a: u32, b: u32) -> u32;
}

/// `a * b / c`, rounded down, with a 64-bit product; `u32::MAX` when it does not fit or `c` is 0.
#[cfg(target_arch = "msp430")]
#[inline(always)]
pub fn mul_div(a: u32, b: u32, c: u32) -> u32 {
    pasapas_mul_div(a, b, c)
}

#[cfg(not(target_arch = "msp430"))]
pub use lang::trig::wide as mul_div;

/// `a * b / 2^32`, rounded down.
#[cfg(target_arch = "msp430")]
#[inline(always)]
pub fn high(a: u32, b: u32) -> u32 {
    pasapas_high(a, b)
}

/// `a * b / 2^32`, rounded down.
#[cfg(not(target_arch = "msp430"))]
pub fn high(a: u32, b: u32) -> u32 {
    ((u64::from(a) * u64::from(b)) >> 32) as u32
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

/// Size of a number. Inlined it is 37 bytes on the chip, and it is wanted two dozen times.
#[inline(never)]
pub fn size(value: i32) -> u32 {
    value.unsigned_abs()
}

/// `size` with the sign of `like`.
#[inline(never)]
pub fn signed(size: i32, like: i32) -> i32 {
    if like < 0 { size.wrapping_neg() } else { size }
}

/// The largest size.
#[inline(never)]
pub fn largest(values: &[i32; 3]) -> u32 {
    let mut most = 0;
    for &value in values {
        most = size(value).max(most);
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mul_div_saturates() {
        assert_eq!(mul_div(3_000_000_000, 3_000_000_000, 3_000_000_000), 3_000_000_000);
        assert_eq!(mul_div(u32::MAX, 2, 1), u32::MAX);
        assert_eq!(mul_div(1, 1, 0), u32::MAX);
    }
}
