//! Unsigned numbers with a 24-bit mantissa and a power of two: the planner's arithmetic.
//!
//! Speeds from 1 step in a minute to 100 000 steps/s, their squares and the energies of ramps
//! span 60 bits. On a 16-bit chip without a multiplier a 24-bit mantissa with an exponent is
//! smaller and faster than 64-bit integers, and it needs no analysis of ranges. Every operation
//! is integer arithmetic, truncates, and is defined to the last bit: the chip's version is
//! assembly (f5529/scaled.rs, g2553/scaled.rs), this one is its twin, and a test holds them together.

/// `mantissa * 2^(exponent - 128)`: exponent in the top byte, mantissa below with its top bit (bit
/// 23) set, or 0. Two such numbers compare like the integers that hold them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[repr(transparent)]
pub struct Scaled(pub u32);

impl Scaled {
    /// Nothing.
    pub const ZERO: Scaled = Scaled(0);
    /// Above every value.
    pub const MAX: Scaled = Scaled(u32::MAX);

    /// [`Scaled::new`] for constants other than 0.
    pub const fn constant(value: u32) -> Scaled {
        let up = value.leading_zeros();
        Scaled((136 - up) << BITS | value << up >> 8)
    }

    /// [`Scaled::shifted`] for constants other than 0.
    pub const fn shift(self, by: i8) -> Scaled {
        Scaled(self.0.wrapping_add_signed((by as i32) << BITS))
    }

    /// How far the integers that hold the two lie apart: its top byte is the power of two just below `self / other`.
    #[must_use]
    pub const fn gap(self, other: Scaled) -> i32 {
        self.0.wrapping_sub(other.0) as i32
    }

    /// `self * 2^by`.
    #[must_use]
    pub fn shifted(self, by: i8) -> Scaled {
        if self.0 == 0 {
            return self;
        }
        Scaled(self.0.wrapping_add_signed(i32::from(by) << BITS))
    }
}

/// Bits of a mantissa.
const BITS: u32 = 24;

macro_rules! operations {
    ($($(#[doc = $doc:literal])+ $name:ident($($arg:ident: $type:ty),*) -> $result:ty = $chip:ident;)*) => {
        impl Scaled {
            $(
                $(#[doc = $doc])+
                #[must_use]
                #[inline]
                pub fn $name(self, $($arg: $type),*) -> $result {
                    #[cfg(target_arch = "msp430")]
                    return chip::$chip(self, $($arg),*);
                    #[cfg(not(target_arch = "msp430"))]
                    twin::$name(self, $($arg),*)
                }
            )*
        }

        #[cfg(target_arch = "msp430")]
        #[allow(unsafe_code)]
        mod chip {
            use super::Scaled;
            // SAFETY: pure functions of their arguments by the compiler's own calling convention.
            unsafe extern "C" {
                $(pub safe fn $chip(this: Scaled, $($arg: $type),*) -> $result;)*
                pub safe fn pasapas_scaled_new(value: u32) -> Scaled;
                pub safe fn pasapas_scaled_size(value: i32) -> Scaled;
                pub safe fn pasapas_scaled_squares(values: &[i32; 3]) -> Scaled;
            }
        }
    };
}

operations! {
    /// Product.
    times(other: Scaled) -> Scaled = pasapas_scaled_times;
    /// Quotient; [`Scaled::MAX`] over zero.
    over(other: Scaled) -> Scaled = pasapas_scaled_over;
    /// Sum.
    plus(other: Scaled) -> Scaled = pasapas_scaled_plus;
    /// Difference, at least zero.
    minus(other: Scaled) -> Scaled = pasapas_scaled_minus;
    /// Square root.
    root() -> Scaled = pasapas_scaled_root;
    /// The integer below, at most 2^31 - 1.
    floor() -> u32 = pasapas_scaled_floor;
    /// The power of two just below `self / other`.
    exponent_over(other: Scaled) -> i8 = pasapas_scaled_exponent_over;
    /// The smaller one.
    least(other: Scaled) -> Scaled = pasapas_scaled_min;
    /// The larger one.
    most(other: Scaled) -> Scaled = pasapas_scaled_max;
}

impl Scaled {
    /// An integer; those above 24 bits lose their low bits.
    #[inline]
    pub fn new(value: u32) -> Scaled {
        #[cfg(target_arch = "msp430")]
        return chip::pasapas_scaled_new(value);
        #[cfg(not(target_arch = "msp430"))]
        twin::new(value)
    }

    /// Size of an integer.
    #[inline]
    pub fn size(value: i32) -> Scaled {
        #[cfg(target_arch = "msp430")]
        return chip::pasapas_scaled_size(value);
        #[cfg(not(target_arch = "msp430"))]
        twin::new(value.unsigned_abs())
    }

    /// Sum of the squares of integers.
    #[inline]
    pub fn squares(values: &[i32; 3]) -> Scaled {
        #[cfg(target_arch = "msp430")]
        return chip::pasapas_scaled_squares(values);
        #[cfg(not(target_arch = "msp430"))]
        twin::squares(values)
    }
}

#[cfg(not(target_arch = "msp430"))]
mod twin {
    use super::{BITS, Scaled};

    /// Bits of the mantissa.
    const MASK: u32 = (1 << BITS) - 1;

    /// Puts mantissa and exponent together; an exponent beyond its byte wraps, which no planner
    /// value comes near.
    fn pack(mantissa: u32, exponent: u32) -> Scaled {
        Scaled(exponent << BITS | mantissa)
    }

    fn mantissa(a: Scaled) -> u32 {
        a.0 & MASK
    }

    fn exponent(a: Scaled) -> u32 {
        a.0 >> BITS
    }

    pub fn new(value: u32) -> Scaled {
        if value == 0 { Scaled::ZERO } else { Scaled::constant(value) }
    }

    pub fn squares(values: &[i32; 3]) -> Scaled {
        let sum: u64 = values.iter().map(|&v| u64::from(v.unsigned_abs()).pow(2)).sum();
        if sum == 0 {
            return Scaled::ZERO;
        }
        let up = sum.leading_zeros();
        pack((sum << up >> 40) as u32, 168 - up)
    }

    pub fn floor(a: Scaled) -> u32 {
        match exponent(a) {
            136.. => i32::MAX as u32,
            e @ 105.. => (mantissa(a) << 8) >> (136 - e),
            _ => 0,
        }
    }

    pub fn times(a: Scaled, b: Scaled) -> Scaled {
        if a.0 == 0 || b.0 == 0 {
            return Scaled::ZERO;
        }
        let product = u64::from(mantissa(a)) * u64::from(mantissa(b));
        let e = exponent(a).wrapping_add(exponent(b)).wrapping_sub(104);
        if product >> 47 != 0 {
            pack((product >> 24) as u32, e)
        } else {
            pack((product >> 23) as u32, e.wrapping_sub(1))
        }
    }

    pub fn over(a: Scaled, b: Scaled) -> Scaled {
        if b.0 == 0 {
            return Scaled::MAX;
        }
        if a.0 == 0 {
            return Scaled::ZERO;
        }
        let e = exponent(a).wrapping_sub(exponent(b)).wrapping_add(104);
        let (a, b) = (u64::from(mantissa(a)), u64::from(mantissa(b)));
        if a < b {
            pack(((a << 24) / b) as u32, e)
        } else {
            pack(((a << 23) / b) as u32, e.wrapping_add(1))
        }
    }

    pub fn plus(a: Scaled, b: Scaled) -> Scaled {
        let (big, small) = if a > b { (a, b) } else { (b, a) };
        let gap = exponent(big) - exponent(small);
        if gap >= BITS || small.0 == 0 {
            return big;
        }
        let sum = mantissa(big) + (mantissa(small) >> gap);
        if sum >> BITS != 0 { pack(sum >> 1, exponent(big) + 1) } else { pack(sum, exponent(big)) }
    }

    pub fn minus(a: Scaled, b: Scaled) -> Scaled {
        if a <= b {
            return Scaled::ZERO;
        }
        let gap = exponent(a) - exponent(b);
        if gap >= BITS {
            return a;
        }
        let rest = mantissa(a) - (mantissa(b) >> gap);
        let up = rest.leading_zeros() - 8;
        pack(rest << up, exponent(a).wrapping_sub(up))
    }

    pub fn root(a: Scaled) -> Scaled {
        if a.0 == 0 {
            return a;
        }
        // The radicand takes an even power of two out of the exponent: 47 or 48 bits.
        let e = exponent(a) + 128 - BITS;
        let odd = e & 1;
        let radicand = u64::from(mantissa(a)) << (BITS - odd);
        pack(radicand.isqrt() as u32, (e + odd) / 2)
    }

    pub fn exponent_over(a: Scaled, b: Scaled) -> i8 {
        (a.0.wrapping_sub(b.0) >> BITS) as i8
    }

    pub fn least(a: Scaled, b: Scaled) -> Scaled {
        a.min(b)
    }

    pub fn most(a: Scaled, b: Scaled) -> Scaled {
        a.max(b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn real(s: Scaled) -> f64 {
        f64::from(s.0 & 0xFF_FFFF) * (f64::from(s.0 >> BITS) - 128.0).exp2()
    }

    fn any() -> impl Strategy<Value = Scaled> {
        (1u32 << 23..1 << 24, 90u32..170).prop_map(|(m, e)| Scaled(e << BITS | m))
    }

    fn close(a: Scaled, b: f64) -> Result<(), TestCaseError> {
        prop_assert!(a.0 == 0 || a.0 >> 23 & 1 == 1);
        prop_assert!(
            real(a) <= b * (1.0 + 1e-12) && real(a) >= b * (1.0 - 3e-7),
            "{} {}",
            real(a),
            b
        );
        Ok(())
    }

    proptest! {
        #[test]
        fn arithmetic_agrees_with_reals(a in any(), b in any()) {
            close(a.times(b), real(a) * real(b))?;
            close(a.over(b), real(a) / real(b))?;
            close(a.plus(b), real(a) + real(b))?;
            close(a.root(), real(a).sqrt())?;
            prop_assert_eq!(a < b, real(a) < real(b));
            let d = a.minus(b);
            prop_assert!((real(d) - (real(a) - real(b)).max(0.0)).abs() <= real(a) * 1.2e-7);
        }

        #[test]
        fn squares_agree_with_reals(v in prop::array::uniform3(i32::MIN..), down in 0u32..31) {
            let v = v.map(|v| v >> down);
            close(Scaled::squares(&v), v.iter().map(|&v| f64::from(v).powi(2)).sum())?;
        }

        #[test]
        fn integers_survive(v in 0u32..1 << 24, w in 0u32..1 << 31) {
            prop_assert_eq!(Scaled::new(v).floor(), v);
            prop_assert!(w - Scaled::new(w).floor() <= w >> 23);
            prop_assert_eq!(Scaled::new(v).shifted(-4).floor(), v >> 4);
        }
    }
}
