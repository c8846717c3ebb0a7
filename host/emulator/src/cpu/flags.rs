//! Status register bits and the arithmetic that sets them (SLAU144, section 3.4.6).

/// Carry.
pub const C: u16 = 0x0001;
/// Zero.
pub const Z: u16 = 0x0002;
/// Negative.
pub const N: u16 = 0x0004;
/// Interrupts enabled.
pub const GIE: u16 = 0x0008;
/// CPU off.
pub const CPUOFF: u16 = 0x0010;
/// Low-frequency oscillator off.
pub const OSCOFF: u16 = 0x0020;
/// DCO generator off unless it clocks something.
pub const SCG0: u16 = 0x0040;
/// SMCLK off.
pub const SCG1: u16 = 0x0080;
/// Overflow.
pub const V: u16 = 0x0100;

const CNZV: u16 = C | N | Z | V;

/// Width of an operation.
#[derive(Clone, Copy)]
pub struct Width {
    /// All bits of an operand.
    pub mask: u16,
    /// Its sign bit.
    pub msb: u16,
}

impl Width {
    /// Width of a byte or word operation.
    #[inline(always)]
    pub const fn of(byte: bool) -> Width {
        if byte { Width { mask: 0xFF, msb: 0x80 } } else { Width { mask: 0xFFFF, msb: 0x8000 } }
    }
}

#[inline(always)]
fn negative_zero(result: u16, w: Width) -> u16 {
    (if result & w.msb != 0 { N } else { 0 }) | (if result == 0 { Z } else { 0 })
}

/// `a + b + carry`: result and status register.
#[inline(always)]
pub fn add(a: u16, b: u16, carry: u16, w: Width, sr: u16) -> (u16, u16) {
    let (a, b) = (a & w.mask, b & w.mask);
    let wide = u32::from(a) + u32::from(b) + u32::from(carry);
    let result = wide as u16 & w.mask;
    let mut flags = negative_zero(result, w);
    if wide > u32::from(w.mask) {
        flags |= C;
    }
    if (a ^ result) & (b ^ result) & w.msb != 0 {
        flags |= V;
    }
    (result, sr & !CNZV | flags)
}

/// Decimal `a + b + C`. V is undefined in the user's guide and stays as it was; digits above 9
/// are added like the hardware's digit adder does: ten is taken off once.
pub fn dadd(a: u16, b: u16, w: Width, sr: u16) -> (u16, u16) {
    let mut carry = sr & C;
    let mut result = 0;
    let mut shift = 0;
    while w.mask >> shift != 0 {
        let mut digit = (a >> shift & 15) + (b >> shift & 15) + carry;
        carry = u16::from(digit >= 10);
        if carry != 0 {
            digit -= 10;
        }
        result |= (digit & 15) << shift;
        shift += 4;
        if shift == 16 {
            break;
        }
    }
    (result, sr & !(C | N | Z) | negative_zero(result, w) | carry)
}

/// Flags of AND, BIT and SXT: C is "not zero", V is reset.
#[inline(always)]
pub fn logic(result: u16, w: Width, sr: u16) -> u16 {
    sr & !CNZV | negative_zero(result, w) | u16::from(result != 0)
}

/// Flags of XOR: as `logic`, but V tells that both operands were negative.
#[inline(always)]
pub fn xor(a: u16, b: u16, result: u16, w: Width, sr: u16) -> u16 {
    logic(result, w, sr) | (if a & b & w.msb != 0 { V } else { 0 })
}

/// Flags of RRA and RRC: C is the bit that left, V is reset.
#[inline(always)]
pub fn shifted(result: u16, out: u16, w: Width, sr: u16) -> u16 {
    sr & !CNZV | negative_zero(result, w) | out & C
}
