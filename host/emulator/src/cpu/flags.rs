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

/// Width of an operation, on operands in 32 bits.
#[derive(Clone, Copy)]
pub struct Width {
    /// All bits of an operand.
    pub mask: u32,
    /// Its sign bit.
    pub msb: u32,
}

impl Width {
    /// Width of a byte or word operation.
    #[inline(always)]
    pub const fn of(byte: bool) -> Width {
        if byte { Width { mask: 0xFF, msb: 0x80 } } else { Width { mask: 0xFFFF, msb: 0x8000 } }
    }

    /// Width of a 20-bit operation of the MSP430X.
    pub const ADDRESS: Width = Width { mask: 0xF_FFFF, msb: 0x8_0000 };
}

#[inline(always)]
fn negative_zero(result: u32, w: Width) -> u16 {
    (if result & w.msb != 0 { N } else { 0 }) | (if result == 0 { Z } else { 0 })
}

/// `a + b + carry`: result and status register.
#[inline(always)]
pub fn add(a: u32, b: u32, carry: u32, w: Width, sr: u16) -> (u32, u16) {
    let (a, b) = (a & w.mask, b & w.mask);
    let wide = a + b + carry;
    let result = wide & w.mask;
    let mut flags = negative_zero(result, w);
    if wide > w.mask {
        flags |= C;
    }
    if (a ^ result) & (b ^ result) & w.msb != 0 {
        flags |= V;
    }
    (result, sr & !CNZV | flags)
}

/// Decimal `a + b + C`. V is undefined in the user's guide and stays as it was; digits above 9
/// are added like the hardware's digit adder does: ten is taken off once.
pub fn dadd(a: u32, b: u32, w: Width, sr: u16) -> (u32, u16) {
    let mut carry = u32::from(sr & C);
    let mut result = 0;
    let mut shift = 0;
    while w.mask >> shift != 0 {
        let mut digit = (a >> shift & 15) + (b >> shift & 15) + carry;
        carry = u32::from(digit >= 10);
        if carry != 0 {
            digit -= 10;
        }
        result |= (digit & 15) << shift;
        shift += 4;
    }
    (result, sr & !(C | N | Z) | negative_zero(result, w) | carry as u16)
}

/// Flags of AND, BIT and SXT: C is "not zero", V is reset.
#[inline(always)]
pub fn logic(result: u32, w: Width, sr: u16) -> u16 {
    sr & !CNZV | negative_zero(result, w) | u16::from(result != 0)
}

/// Flags of XOR: as `logic`, but V tells that both operands were negative.
#[inline(always)]
pub fn xor(a: u32, b: u32, result: u32, w: Width, sr: u16) -> u16 {
    logic(result, w, sr) | (if a & b & w.msb != 0 { V } else { 0 })
}

/// Flags of RRA and RRC: C is the bit that left, V is reset.
#[inline(always)]
pub fn shifted(result: u32, out: u32, w: Width, sr: u16) -> u16 {
    sr & !CNZV | negative_zero(result, w) | out as u16 & C
}
