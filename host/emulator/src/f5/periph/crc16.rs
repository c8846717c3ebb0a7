//! CRC module (SLAU208, chapter 12): CRC-16-CCITT, a byte a write.

/// The result register.
#[derive(Debug, Clone, Copy, Default)]
pub struct Crc16 {
    input: u16,
    result: u16,
}

impl Crc16 {
    fn byte(&mut self, byte: u8) {
        self.result ^= u16::from(byte) << 8;
        for _ in 0..8 {
            let out = self.result & 0x8000 != 0;
            self.result = self.result << 1 ^ if out { 0x1021 } else { 0 };
        }
    }

    /// Reads the register at `offset` from CRCDI.
    pub fn read(&self, offset: u16) -> u16 {
        match offset {
            0 | 2 => self.input,
            4 => self.result,
            _ => self.result.reverse_bits(),
        }
    }

    /// Writes the register at `offset` from CRCDI; a byte when `mask` covers no more.
    pub fn write(&mut self, offset: u16, value: u16, mask: u16) {
        match offset {
            0 | 2 => {
                self.input = value & mask;
                let order = |byte: u8| if offset == 0 { byte.reverse_bits() } else { byte };
                let [low, high] = value.to_le_bytes();
                if mask & 0x00FF != 0 {
                    self.byte(order(low));
                }
                if mask & 0xFF00 != 0 {
                    self.byte(order(high));
                }
            }
            4 => self.result = self.result & !mask | value & mask,
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_usual_check_value_comes_out() {
        let mut crc = Crc16::default();
        crc.write(4, 0xFFFF, 0xFFFF);
        for byte in *b"123456789" {
            crc.write(2, u16::from(byte), 0x00FF);
        }
        assert_eq!(crc.read(4), 0x29B1);
        let mut reversed = Crc16::default();
        reversed.write(4, 0xFFFF, 0xFFFF);
        for byte in *b"123456789" {
            reversed.write(0, u16::from(byte.reverse_bits()), 0x00FF);
        }
        assert_eq!(reversed.read(6), 0x29B1u16.reverse_bits());
    }
}
