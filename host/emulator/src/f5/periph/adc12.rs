//! ADC12_A (SLAU208, chapter 28): single conversions and sequences that software starts, of 12 bits, by its own oscillator.

use crate::periph::NEVER;

const SC: u16 = 1;
const ENC: u16 = 1 << 1;
const ON: u16 = 1 << 4;
const MSC: u16 = 1 << 7;
const BUSY: u16 = 1;
/// ADC12CONSEQ: a sequence of channels, once.
const SEQUENCE: u16 = 1;
/// End of a sequence, in a control byte.
const EOS: u8 = 1 << 7;
/// Cycles of a conversion after the sampling, of 12 bits.
const CONVERT: u64 = 13;
/// Cycles of the sampling, by ADC12SHTx.
const SAMPLE: [u64; 16] =
    [4, 8, 16, 32, 64, 96, 128, 192, 256, 384, 512, 768, 1024, 1024, 1024, 1024];
/// Typical rate of its oscillator, Hz (SLAS590, "12-Bit ADC, Timing Parameters": 4.2 to 5.4 MHz).
const OSCILLATOR_HZ: u64 = 4_800_000;
/// Channels at pins P6.4, P6.5, P6.6 and P7.0.
const PINS: [u8; 4] = [4, 5, 6, 12];

/// The module's registers.
#[derive(Clone, Debug)]
pub struct Adc12 {
    ctl: [u16; 3],
    ie: u16,
    ifg: u16,
    control: [u8; 16],
    memory: [u16; 16],
    /// The memory that the running conversion goes to.
    place: usize,
    /// When the running conversion ends.
    pub next: u64,
}

impl Default for Adc12 {
    fn default() -> Adc12 {
        // 12 bits, as after a reset.
        let ctl = [0, 0, 0x20];
        let (control, memory) = ([0; 16], [0; 16]);
        Adc12 { ctl, ie: 0, ifg: 0, control, memory, place: 0, next: NEVER }
    }
}

impl Adc12 {
    /// Reads the word at an even offset from ADC12CTL0.
    pub fn read(&mut self, offset: u16) -> u16 {
        let n = usize::from(offset);
        match offset {
            0x00 => self.ctl[0],
            0x02 => self.ctl[1] | if self.next == NEVER { 0 } else { BUSY },
            0x04 => self.ctl[2],
            0x0A => self.ifg,
            0x0C => self.ie,
            0x10..=0x1E => u16::from_le_bytes([self.control[n - 0x10], self.control[n - 0x0F]]),
            0x20..=0x3E => {
                let place = (n - 0x20) / 2;
                self.ifg &= !(1 << place);
                self.memory[place]
            }
            _ => 0,
        }
    }

    /// Writes the bytes that `mask` covers of the word at an even offset; `false` for what is not modelled.
    pub fn write(&mut self, offset: u16, value: u16, mask: u16, now: u64, second: u64) -> bool {
        let open = self.ctl[0] & ENC == 0;
        let n = usize::from(offset);
        match offset {
            0x00 => {
                let value = self.ctl[0] & !mask | value & mask;
                // While ENC is set the rest stands.
                let kept =
                    if open { value } else { self.ctl[0] & !(ENC | SC) | value & (ENC | SC) };
                self.ctl[0] = kept & !SC;
                let starts = kept & (SC | ENC | ON) == SC | ENC | ON && self.next == NEVER;
                if starts {
                    self.place = usize::from(self.ctl[1] >> 12);
                    self.next = now + self.duration(second);
                }
            }
            0x02 | 0x04 if open => {
                let own = &mut self.ctl[n / 2];
                *own = *own & !mask | value & mask & !BUSY;
            }
            0x0A => self.ifg = self.ifg & !mask | value & mask,
            0x0C => self.ie = self.ie & !mask | value & mask,
            0x10..=0x1E if open => {
                for (at, byte) in value.to_le_bytes().into_iter().enumerate() {
                    if mask >> (8 * at) & 0xFF != 0 {
                        self.control[n - 0x10 + at] = byte;
                    }
                }
            }
            _ => {}
        }
        let sequence = self.ctl[1] >> 1 & 3;
        let own_clock = self.ctl[1] & 0x0CF8 == 0;
        let twelve_bits = self.ctl[2] & 0x138 == 0x20;
        sequence <= SEQUENCE && own_clock && twelve_bits && self.ie == 0
    }

    /// A conversion ends, with these voltages at the pins and the supply, mV.
    pub fn event(&mut self, pins: [u16; 4], supply: u32, second: u64) {
        let control = self.control[self.place];
        let mv = match PINS.iter().position(|channel| *channel == control & 0x0F) {
            Some(pin) => pins[pin].into(),
            None if control & 0x0F == 11 => supply / 2,
            None => 0,
        };
        let full = supply.max(1);
        self.memory[self.place] = ((mv * 4095 + full / 2) / full).min(4095) as u16;
        self.ifg |= 1 << self.place;
        let goes_on = self.ctl[1] >> 1 & 3 == SEQUENCE && control & EOS == 0;
        if goes_on && self.ctl[0] & MSC != 0 {
            self.place = (self.place + 1) % 16;
            self.next += self.duration(second);
        } else {
            self.next = NEVER;
        }
    }

    fn duration(&self, second: u64) -> u64 {
        let shift = if self.place < 8 { 8 } else { 12 };
        let sampling = SAMPLE[usize::from(self.ctl[0] >> shift & 15)];
        (sampling + CONVERT) * second / OSCILLATOR_HZ
    }
}

#[cfg(test)]
mod tests {
    use super::Adc12;
    use crate::periph::NEVER;

    const SECOND: u64 = 48_000_000;

    #[test]
    fn a_sequence_fills_its_memories_one_by_one_and_then_rests() {
        let mut adc = Adc12::default();
        assert!(adc.write(0x02, 1 << 9 | 1 << 1, 0xFFFF, 0, SECOND));
        for (n, channel) in [4, 5, 6, 12 | 0x80].into_iter().enumerate() {
            let word = 0x10 + (n as u16 & !1);
            let (value, mask) = if n % 2 == 0 { (channel, 0xFF) } else { (channel << 8, 0xFF00) };
            assert!(adc.write(word, value, mask, 0, SECOND));
        }
        assert!(adc.write(0x00, 0x2292, 0xFFFF, 0, SECOND), "ENC without SC");
        assert_eq!(adc.next, NEVER);
        assert!(adc.write(0x00, 0x2293, 0xFFFF, 100, SECOND));
        let each = 29 * SECOND / 4_800_000;
        for n in 1..=4 {
            assert_eq!((adc.next, adc.read(0x02) & 1), (100 + n * each, 1));
            adc.event([0, 1650, 3300, 4000], 3300, SECOND);
        }
        assert_eq!((adc.next, adc.read(0x02) & 1), (NEVER, 0));
        assert_eq!([0x20, 0x22, 0x24, 0x26].map(|at| adc.read(at)), [0, 2048, 4095, 4095]);
        assert_eq!(adc.read(0x0A), 0, "reading took the flags");
        // ENC has to go and come again for the next one.
        assert!(adc.write(0x00, 0x2290, 0xFFFF, 9000, SECOND));
        assert!(adc.write(0x00, 0x2293, 0xFFFF, 9000, SECOND));
        assert_eq!(adc.next, 9000 + each);
    }

    #[test]
    fn what_is_not_modelled_is_told() {
        let mut adc = Adc12::default();
        assert!(!adc.write(0x02, 3 << 1, 0xFFFF, 0, SECOND), "repeated sequences");
        let mut adc = Adc12::default();
        assert!(!adc.write(0x0C, 1, 0xFFFF, 0, SECOND), "interrupts");
    }
}
