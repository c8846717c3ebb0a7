//! The supply: its voltage over time, and what the part may do at it (SLAS735, recommended operating
//! conditions).

use super::Bus;
use crate::TICKS_PER_SECOND;
use crate::warn::Kind;

/// Highest rates of the processor by voltage, millivolts and hertz; in between they lie on lines.
const RATES: [(u64, u64); 3] = [(1_800, 6_000_000), (2_700, 12_000_000), (3_300, 16_000_000)];
/// What the calibration may be above its rate without breaking the limit, percent: the limit of the
/// part is that of its calibrated rate.
const TOLERANCE: u64 = 6;
/// Lowest voltage for flash operations, millivolts.
const FLASH_MV: u32 = 2_200;
/// Where the chip leaves its reset on the way up, millivolts (SLAS735, brown-out reset).
const START_MV: u32 = 1_400;

/// The supply of the chip.
#[derive(Debug, Clone, Copy)]
pub struct Supply {
    /// Millivolts once it is up.
    pub vcc: u32,
    /// Ticks from the end of the brown-out reset to there.
    pub rise: u64,
    since: u64,
}

impl Supply {
    /// One that reaches `vcc` millivolts `rise_us` microseconds behind the chip's start.
    #[must_use]
    pub fn new(vcc: u32, rise_us: u64) -> Supply {
        Supply { vcc, rise: rise_us.saturating_mul(TICKS_PER_SECOND / 1_000_000), since: 0 }
    }

    /// It is switched on.
    pub(super) fn up(&mut self, now: u64) {
        self.since = now;
    }

    /// Millivolts at a time.
    #[must_use]
    pub fn at(&self, now: u64) -> u32 {
        let passed = now.saturating_sub(self.since);
        if passed >= self.rise || self.vcc <= START_MV {
            return self.vcc;
        }
        let part = u64::from(self.vcc - START_MV) * passed / self.rise;
        START_MV + u32::try_from(part).unwrap_or(u32::MAX)
    }

    /// The highest rate of the processor at `mv` millivolts, hertz.
    fn most_hz(mv: u32) -> u64 {
        let mv = u64::from(mv);
        let [low, .., top] = RATES;
        if mv < low.0 {
            // Below the operating range nothing is promised; the part starts at about 1 MHz.
            return 1_500_000;
        }
        if mv >= top.0 {
            return top.1;
        }
        let above = RATES.windows(2).find(|pair| mv < pair[1].0);
        above.map_or(top.1, |pair| {
            pair[0].1 + (pair[1].1 - pair[0].1) * (mv - pair[0].0) / (pair[1].0 - pair[0].0)
        })
    }
}

impl Bus {
    /// The processor's rate or the supply has changed.
    pub(crate) fn check_supply(&mut self) {
        let hz = TICKS_PER_SECOND / self.clock.rates.mclk.max(1);
        let most = Supply::most_hz(self.supply.at(self.now));
        if hz > most + most * TOLERANCE / 100 {
            self.warn(Kind::Supply, 0x57);
        }
    }

    /// Flash is written or erased.
    pub(super) fn check_flash_supply(&mut self, addr: u16) {
        if self.supply.at(self.now) < FLASH_MV {
            self.warn(Kind::Supply, addr);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Supply;

    #[test]
    fn rates_and_ramps() {
        assert_eq!(Supply::most_hz(3_300), 16_000_000);
        assert_eq!(Supply::most_hz(3_000), 14_000_000);
        assert_eq!(Supply::most_hz(1_800), 6_000_000);
        assert_eq!(Supply::most_hz(1_500), 1_500_000);
        let supply = Supply::new(3_300, 1000);
        assert_eq!(
            [0, 8_000, 16_000, 99_000].map(|at| supply.at(at)),
            [1_400, 2_350, 3_300, 3_300]
        );
    }
}
