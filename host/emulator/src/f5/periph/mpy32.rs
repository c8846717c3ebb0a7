//! Hardware multiplier MPY32 (SLAU208, chapter 25): 16 and 32 bits, signed and unsigned, and
//! accumulating. Fractional and saturating modes and operands of 8 bits are refused.

/// What a write did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Nothing to mention.
    Done,
    /// A mode that is not modelled.
    Unsupported,
}

const SIGNED: u16 = 0x10;
const ACCUMULATE: u16 = 0x20;
const OP1_LONG: u16 = 0x40;
const OP2_LONG: u16 = 0x80;
const CARRY: u16 = 0x01;
const FRACTIONAL: u16 = 0x04;
const SATURATING: u16 = 0x08;
const DELAYED: u16 = 0x300;

/// Registers.
#[derive(Debug, Clone, Default)]
pub struct Mpy32 {
    op1: u32,
    op2: u32,
    ctl: u16,
    result: u64,
    sum_extension: u16,
    /// When the multiplication began.
    began: u64,
    /// Cycles from then until each word of the result is ready.
    ready: [u8; 4],
}

impl Mpy32 {
    fn signed(&self) -> bool {
        self.ctl & SIGNED != 0
    }

    fn accumulates(&self) -> bool {
        self.ctl & ACCUMULATE != 0
    }

    /// A register between MPY and MACS32H: which operand mode, and which half.
    fn first_operand(offset: u16) -> Option<(u16, Option<u32>)> {
        match offset {
            0x00..=0x06 => Some((offset / 2, None)),
            0x10..=0x1E => Some(((offset - 0x10) / 4, Some(u32::from((offset / 2) & 1)))),
            _ => None,
        }
    }

    /// Whether the register holds an operand: using it changes what a main program began.
    pub fn is_operand(offset: u16) -> bool {
        Mpy32::first_operand(offset).is_some() || matches!(offset, 0x08 | 0x20 | 0x22)
    }

    /// Reads the register at even `offset` from MPY, and whether that is too early.
    pub fn read(&self, offset: u16, now: u64, cycle: u64) -> Option<(u16, bool)> {
        let word = |n: u32| (self.result >> (16 * n)) as u16;
        if let Some((_, half)) = Mpy32::first_operand(offset) {
            return Some(((self.op1 >> (16 * half.unwrap_or(0))) as u16, false));
        }
        let (value, n) = match offset {
            0x08 | 0x20 => return Some((self.op2 as u16, false)),
            0x22 => return Some(((self.op2 >> 16) as u16, false)),
            0x2C => return Some((self.ctl, false)),
            0x0A => (word(0), 0),
            0x0C => (word(1), 1),
            0x0E => (self.sum_extension, 1),
            0x24..=0x2A => {
                let n = (offset - 0x24) / 2;
                (word(u32::from(n)), usize::from(n))
            }
            _ => return None,
        };
        // To whole cycles, whose length may have changed meanwhile.
        let passed = (now.saturating_sub(self.began) + cycle / 2) / cycle.max(1);
        Some((value, passed < u64::from(self.ready[n])))
    }

    /// Writes the register at even `offset` from MPY.
    pub fn write(&mut self, offset: u16, value: u16, now: u64) -> Option<Outcome> {
        if let Some((mode, half)) = Mpy32::first_operand(offset) {
            self.ctl = self.ctl & !(SIGNED | ACCUMULATE | OP1_LONG)
                | if mode & 1 != 0 { SIGNED } else { 0 }
                | if mode & 2 != 0 { ACCUMULATE } else { 0 };
            match half {
                None => self.op1 = u32::from(value),
                Some(half) => {
                    let shift = 16 * half;
                    self.op1 = self.op1 & !(0xFFFF << shift) | u32::from(value) << shift;
                    self.ctl |= OP1_LONG;
                }
            }
            return Some(Outcome::Done);
        }
        match offset {
            0x08 => {
                self.op2 = u32::from(value);
                self.ctl &= !OP2_LONG;
                self.multiply(now);
            }
            0x20 => {
                self.op2 = self.op2 & 0xFFFF_0000 | u32::from(value);
                self.ctl |= OP2_LONG;
            }
            0x22 => {
                self.op2 = self.op2 & 0xFFFF | u32::from(value) << 16;
                self.ctl |= OP2_LONG;
                self.multiply(now);
            }
            0x0A | 0x24 => self.put(0, value),
            0x0C | 0x26 => self.put(1, value),
            0x28 => self.put(2, value),
            0x2A => self.put(3, value),
            0x0E => self.sum_extension = value,
            0x2C => {
                self.ctl = value & 0x03FD;
                if value & (FRACTIONAL | SATURATING | DELAYED) != 0 {
                    return Some(Outcome::Unsupported);
                }
            }
            _ => return None,
        }
        Some(Outcome::Done)
    }

    fn put(&mut self, n: u32, value: u16) {
        self.result = self.result & !(0xFFFF << (16 * n)) | u64::from(value) << (16 * n);
    }

    fn multiply(&mut self, now: u64) {
        let (long1, long2) = (self.ctl & OP1_LONG != 0, self.ctl & OP2_LONG != 0);
        let wide = long1 || long2;
        let extend = |value: u32, long: bool| match (self.signed(), long) {
            (true, true) => i64::from(value.cast_signed()),
            (true, false) => i64::from((value as u16).cast_signed()),
            (false, true) => i64::from(value),
            (false, false) => i64::from(value as u16),
        };
        let product = extend(self.op1, long1).wrapping_mul(extend(self.op2, long2)).cast_unsigned();
        // A product of two 16-bit operands leaves the upper half of the result to its sign.
        let bits = if wide { 64 } else { 32 };
        let mask = if wide { u64::MAX } else { 0xFFFF_FFFF };
        let old = if self.accumulates() { self.result & mask } else { 0 };
        let (sum, over) = old.overflowing_add(product & mask);
        let carry = if wide { over } else { sum > mask };
        let carry = carry && self.accumulates();
        let sum = sum & mask;
        let negative = sum >> (bits - 1) & 1 != 0;
        self.sum_extension =
            if self.signed() { if negative { 0xFFFF } else { 0 } } else { u16::from(carry) };
        self.ctl = self.ctl & !CARRY | u16::from(carry);
        self.result = if !wide && self.signed() && negative { sum | !mask } else { sum };
        self.began = now;
        self.ready = match (long1, long2) {
            (false, false) => [3, 3, 4, 4],
            (true, false) => [3, 5, 6, 7],
            (false, true) => [0, 3, 4, 4],
            (true, true) => [0, 3, 5, 6],
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn result(writes: &[(u16, u16)]) -> (u64, u16) {
        let mut m = Mpy32::default();
        for (offset, value) in writes {
            assert_eq!(m.write(*offset, *value, 0), Some(Outcome::Done));
        }
        let word = |offset| m.read(offset, 1000, 1).map_or(0, |(value, _)| u64::from(value));
        let all = word(0x24) | word(0x26) << 16 | word(0x28) << 32 | word(0x2A) << 48;
        assert_eq!((word(0x0A), word(0x0C)), (all & 0xFFFF, all >> 16 & 0xFFFF));
        (all, word(0x0E) as u16)
    }

    #[test]
    fn products_and_sums_of_the_guide() {
        assert_eq!(result(&[(0, 0x1234), (8, 0x5678)]), (0x1234 * 0x5678, 0));
        assert_eq!(result(&[(2, 0xFFFF), (8, 5)]).0 as u32, (-5i32).cast_unsigned());
        assert_eq!(result(&[(2, 0xFFFF), (8, 5)]).1, 0xFFFF);
        // 2^32 - 1 squared, by halves.
        let squared = [(0x10, 0xFFFF), (0x12, 0xFFFF), (0x20, 0xFFFF), (0x22, 0xFFFF)];
        assert_eq!(result(&squared).0, 0xFFFF_FFFE_0000_0001);
        let signed = [(0x14, 0xFFFE), (0x16, 0xFFFF), (0x20, 3), (0x22, 0)];
        assert_eq!(result(&signed), ((-6i64).cast_unsigned(), 0xFFFF));
        // Accumulated twice: the carry out of 32 bits.
        let twice = [(0, 0xFFFF), (8, 0xFFFF), (4, 0xFFFF), (8, 0xFFFF)];
        assert_eq!(result(&twice), ((0xFFFE_0001u64 * 2) & 0xFFFF_FFFF, 1));
    }

    #[test]
    fn an_early_look_at_the_result_is_noticed() {
        let mut m = Mpy32::default();
        m.write(0, 3, 0);
        m.write(8, 4, 100);
        assert_eq!(m.read(0x0A, 102, 1), Some((12, true)));
        assert_eq!(m.read(0x0A, 103, 1), Some((12, false)));
        assert_eq!(m.write(0x2C, 4, 0), Some(Outcome::Unsupported));
    }
}
