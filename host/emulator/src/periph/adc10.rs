//! ADC10, single conversions (SLAU144, chapter 22).

use super::{NEVER, Rates};

const SC: u16 = 0x01;
const ENC: u16 = 0x02;
/// ADC10IFG in ADC10CTL0.
pub const IFG: u16 = 0x04;
/// ADC10IE in ADC10CTL0.
pub const IE: u16 = 0x08;
const ON: u16 = 0x10;
const REF2_5V: u16 = 0x40;
const BUSY: u16 = 0x01;
/// Typical rate of the module's own oscillator (SLAS735: 3.7 to 6.3 MHz).
const ADC10OSC_HZ: u64 = 5_000_000;

/// ADC10 registers.
#[derive(Debug, Clone)]
pub struct Adc10 {
    /// ADC10CTL0
    pub ctl0: u16,
    ctl1: u16,
    mem: u16,
    /// ADC10AE0, ADC10DTC0, ADC10DTC1, stored only.
    pub bytes: [u8; 3],
    /// ADC10SA, stored only.
    pub sa: u16,
    /// When the running conversion ends.
    pub next: u64,
}

impl Default for Adc10 {
    fn default() -> Self {
        Adc10 { ctl0: 0, ctl1: 0, mem: 0, bytes: [0; 3], sa: 0x200, next: NEVER }
    }
}

impl Adc10 {
    /// Reads a word register.
    pub fn read(&mut self, addr: u16) -> u16 {
        match addr {
            0x1B0 => self.ctl0,
            0x1B2 => self.ctl1 | if self.next == NEVER { 0 } else { BUSY },
            0x1B4 => {
                self.ctl0 &= !IFG;
                self.mem
            }
            _ => self.sa,
        }
    }

    /// Writes a word register.
    pub fn write(&mut self, addr: u16, value: u16, now: u64, clock: &Rates) {
        match addr {
            0x1B0 => {
                if self.ctl0 & value & ENC != 0 {
                    // Set-up bits are locked while ENC is set.
                    self.ctl0 = self.ctl0 & !0x0F | value & 0x0F;
                } else {
                    self.ctl0 = value;
                }
                if self.ctl0 & (SC | ENC | ON) == SC | ENC | ON && self.next == NEVER {
                    self.next = now + self.duration(clock);
                }
                self.ctl0 &= !SC;
            }
            0x1B2 if self.ctl0 & ENC == 0 => self.ctl1 = value & !BUSY,
            0x1BC => self.sa = value,
            _ => {}
        }
    }

    /// Ends the running conversion, with the supply at `vcc` millivolts.
    pub fn finish(&mut self, vcc: u32) {
        self.next = NEVER;
        let reference = match self.ctl0 >> 13 {
            1 if self.ctl0 & REF2_5V != 0 => 2500,
            1 => 1500,
            _ => vcc,
        };
        let input = match self.ctl1 >> 12 {
            // Temperature sensor at 25 degrees Celsius: 986 mV + 3.55 mV/K * 25 K.
            10 => 1075,
            11 => vcc / 2,
            _ => 0,
        };
        // Rounding of the ideal transfer function, clipped at full scale.
        self.mem = (input * 1023 / reference.max(1)).min(1023) as u16;
        self.ctl0 |= IFG;
    }

    fn duration(&self, clock: &Rates) -> u64 {
        let sample = [4, 8, 16, 64][usize::from(self.ctl0 >> 11 & 3)];
        let source = match self.ctl1 >> 3 & 3 {
            0 => 0,
            1 => clock.aclk,
            2 => clock.mclk,
            _ => clock.smclk,
        };
        let cycles = (sample + 13) * (u64::from(self.ctl1 >> 5 & 7) + 1);
        if source == 0 { cycles * clock.second / ADC10OSC_HZ } else { cycles * source }
    }
}
