//! Basic Clock Module+ (SLAU144, chapter 5): DCO, VLO, dividers, clock selection.

use super::Rates;
use crate::TICKS_PER_SECOND;
use crate::cpu::flags::{OSCOFF, SCG1};

/// Calibration words of information memory: address of CALDCO, address of CALBC1, hertz, and
/// typical values. Only a DCO set to the pair of a row runs at exactly that rate.
pub const CALIBRATION: [(u16, u16, u64, u8, u8); 4] = [
    (0x10FE, 0x10FF, 1_000_000, 0xBC, 0x86),
    (0x10FC, 0x10FD, 8_000_000, 0x92, 0x8D),
    (0x10FA, 0x10FB, 12_000_000, 0x9E, 0x8E),
    (0x10F8, 0x10F9, 16_000_000, 0x95, 0x8F),
];

/// Typical DCO rate in kHz at DCOx = 3 for each RSELx (SLAS735, "DCO frequency").
const RSEL_KHZ: [u64; 16] =
    [100, 120, 150, 210, 300, 410, 580, 1100, 1300, 1600, 2300, 3400, 4250, 5800, 9000, 15250];

/// Clock module registers and the periods that follow from them.
#[derive(Debug, Clone)]
pub struct Clock {
    /// DCOCTL
    pub dcoctl: u8,
    /// BCSCTL1
    pub bcsctl1: u8,
    /// BCSCTL2
    pub bcsctl2: u8,
    /// BCSCTL3
    pub bcsctl3: u8,
    /// Rate of the very-low-power oscillator in hertz, 4000 to 20 000 (SLAS735).
    pub vlo_hz: u64,
    /// How far the DCO is off, in millionths: all its rates alike. A tick is a cycle of the DCO as it
    /// is, so that what is not clocked by it takes more or fewer ticks.
    pub dco_ppm: i32,
    /// Low-power bits of the status register that stop clocks.
    pub gates: u16,
    /// The periods that the registers give.
    pub rates: Rates,
    /// Whether the DCO is above 16 MHz, or set to a calibrated rate that no tick divides.
    pub rounded: bool,
}

impl Clock {
    /// Registers as after a reset.
    pub fn new(vlo_hz: u64, dco_ppm: i32) -> Clock {
        let mut clock = Clock {
            dcoctl: 0x60,
            bcsctl1: 0x87,
            bcsctl2: 0,
            bcsctl3: 0x05,
            vlo_hz,
            dco_ppm,
            gates: 0,
            rates: Rates { mclk: 1, smclk: 1, ..Rates::default() },
            rounded: false,
        };
        clock.update();
        clock
    }

    /// Ticks in a second of a true clock.
    pub fn ticks_per_second(&self) -> u64 {
        let parts = i64::from(self.dco_ppm).max(-900_000) + 1_000_000;
        TICKS_PER_SECOND / 1000 * parts.unsigned_abs() / 1000
    }

    /// Rate of the DCO in hertz, were it exact.
    pub fn dco_hz(&self) -> u64 {
        let rsel = self.bcsctl1 & 15;
        for (_, _, hz, dco, bc1) in CALIBRATION {
            if self.dcoctl == dco && rsel == bc1 & 15 {
                return hz;
            }
        }
        // About 8 % a step of DCOx, and MODx/32 of a step between two of them.
        let base = RSEL_KHZ[usize::from(rsel)] * 1000;
        let steps = i64::from(self.dcoctl) - (3 << 5);
        let mut hz = base as i64;
        hz += hz * steps * 8 / 3200;
        hz.max(50_000) as u64
    }

    /// Whether ACLK comes from the VLO; there is no crystal on the board.
    pub fn vlo_selected(&self) -> bool {
        self.bcsctl3 & 0x30 == 0x20
    }

    /// Recomputes the periods after a register changed.
    pub fn update(&mut self) {
        let hz = self.dco_hz();
        let dco = ((TICKS_PER_SECOND + hz / 2) / hz).max(1);
        // Settings between the calibrated ones are give-or-take a quarter on a real part anyway.
        let calibrated = CALIBRATION.iter().any(|row| row.2 == hz);
        self.rounded =
            hz > TICKS_PER_SECOND || (calibrated && !TICKS_PER_SECOND.is_multiple_of(hz));
        let low =
            if self.vlo_selected() { self.ticks_per_second() / self.vlo_hz.max(1) } else { 0 };
        let pick = |use_low: bool| if use_low { low } else { dco };
        // Without XT2, SELM = 2 and SELS = 1 select LFXT1CLK or VLO, SELM = 3 too.
        let m = pick(self.bcsctl2 & 0x80 != 0) << (self.bcsctl2 >> 4 & 3);
        // A failed LFXT1 makes MCLK fall back to the DCO.
        self.rates.mclk = if m == 0 { dco } else { m };
        let s = pick(self.bcsctl2 & 0x08 != 0) << (self.bcsctl2 >> 1 & 3);
        self.rates.smclk = if self.gates & SCG1 != 0 { 0 } else { s };
        let a = low << (self.bcsctl1 >> 4 & 3);
        self.rates.aclk = if self.gates & OSCOFF != 0 { 0 } else { a };
        self.rates.second = self.ticks_per_second();
    }

    /// Reads a register by address.
    pub fn read(&self, addr: u16) -> u8 {
        match addr {
            0x53 => self.bcsctl3 & !1 | u8::from(!self.vlo_selected()),
            0x56 => self.dcoctl,
            0x57 => self.bcsctl1,
            _ => self.bcsctl2,
        }
    }

    /// Writes a register by address.
    pub fn write(&mut self, addr: u16, value: u8) {
        match addr {
            0x53 => self.bcsctl3 = value & 0xFC,
            0x56 => self.dcoctl = value,
            0x57 => self.bcsctl1 = value,
            _ => self.bcsctl2 = value,
        }
        self.update();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dco_that_is_off_makes_true_seconds_longer_or_shorter() {
        assert_eq!(Clock::new(12_000, 0).ticks_per_second(), 16_000_000);
        assert_eq!(Clock::new(12_000, 30_000).ticks_per_second(), 16_480_000);
        assert_eq!(Clock::new(12_000, -30_000).ticks_per_second(), 15_520_000);
        let mut fast = Clock::new(10_000, 30_000);
        fast.write(0x53, 0x20);
        assert_eq!(fast.rates.aclk, 1648);
    }

    #[test]
    fn calibrated_rates_are_exact_and_the_reset_rate_is_near_1_1_mhz() {
        let mut clock = Clock::new(12_000, 0);
        assert!((900_000..1_400_000).contains(&clock.dco_hz()));
        clock.write(0x57, 0x8F);
        clock.write(0x56, 0x95);
        assert_eq!((clock.rates.mclk, clock.rates.smclk, clock.rates.aclk), (1, 1, 0));
        clock.write(0x53, 0x20);
        assert_eq!(clock.rates.aclk, 1333);
        clock.write(0x58, 0x04);
        assert_eq!((clock.rates.mclk, clock.rates.smclk), (1, 4));
        clock.gates = SCG1;
        clock.update();
        assert_eq!(clock.rates.smclk, 0);
    }
}
