//! Unified clock system (SLAU208, chapter 5): DCO with frequency locked loop, crystals and their
//! faults, dividers and selection.

use super::dco;
use crate::cpu::flags::{OSCOFF, SCG0, SCG1};
use crate::f5::silicon::{Fll, Silicon};
use crate::periph::{NEVER, Rates};

/// Rate of the watch crystal in hertz.
const XT1_HZ: u64 = 32_768;
const DCOFFG: u16 = 0x01;
const XT1LFOFFG: u16 = 0x02;
const XT2OFFG: u16 = 0x08;
const FLAGS: u16 = 0x0F;
const XT1OFF: u16 = 0x0001;
const SMCLKOFF: u16 = 0x0002;
const XT2OFF: u16 = 0x0100;

/// A source of clocks, in the order of SELA, SELS and SELM.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Source {
    Xt1,
    Vlo,
    Refo,
    Dco,
    DcoDivided,
    Xt2,
}

impl Source {
    fn of(field: u16) -> Source {
        match field & 7 {
            0 => Source::Xt1,
            1 => Source::Vlo,
            2 => Source::Refo,
            3 => Source::Dco,
            4 => Source::DcoDivided,
            _ => Source::Xt2,
        }
    }
}

/// A crystal oscillator.
#[derive(Debug, Clone)]
struct Crystal {
    fitted: bool,
    start: u64,
    /// Since when it has been asked to run.
    since: Option<u64>,
}

impl Crystal {
    fn request(&mut self, wanted: bool, now: u64) {
        match (wanted, self.since) {
            (true, None) => self.since = Some(now),
            (false, _) => self.since = None,
            _ => {}
        }
    }

    fn ready_at(&self) -> Option<u64> {
        self.since.filter(|_| self.fitted).map(|since| since + self.start)
    }

    fn runs(&self, now: u64) -> bool {
        self.ready_at().is_some_and(|at| at <= now)
    }
}

/// Registers, oscillators, and the periods that follow from them.
#[derive(Debug, Clone)]
pub struct Ucs {
    ctl: [u16; 9],
    /// Low-power bits of the status register that stop clocks.
    pub gates: u16,
    /// The periods that the registers give.
    pub rates: Rates,
    /// When a crystal starts or the loop makes its next step.
    pub next: u64,
    ticks_per_second: u64,
    vlo_hz: u64,
    refo_hz: u64,
    xt2_hz: u64,
    mode: Fll,
    xt1: Crystal,
    xt2: Crystal,
    /// Pins of the crystals as selected: XT1, XT2.
    pins: [bool; 2],
    /// Whether the crystals ran when that was looked at last.
    running: [bool; 2],
    /// The loop reached its rate.
    locked: bool,
    next_step: u64,
}

impl Ucs {
    /// Registers as after a PUC.
    pub fn new(silicon: &Silicon, vlo_hz: u64, ticks_per_second: u64) -> Ucs {
        let start = |us: u64| us * (ticks_per_second / 1_000_000);
        let mut ucs = Ucs {
            ctl: [0; 9],
            gates: 0,
            rates: Rates::default(),
            next: NEVER,
            ticks_per_second,
            vlo_hz,
            refo_hz: silicon.refo_hz,
            xt2_hz: silicon.xt2_hz,
            mode: silicon.fll,
            xt1: Crystal {
                fitted: silicon.xt1_fitted,
                start: start(silicon.xt1_start_us),
                since: None,
            },
            xt2: Crystal {
                fitted: silicon.xt2_fitted,
                start: start(silicon.xt2_start_us),
                since: None,
            },
            pins: [false; 2],
            running: [false; 2],
            locked: false,
            next_step: 0,
        };
        ucs.reset(0);
        ucs
    }

    /// What a PUC does.
    pub fn reset(&mut self, now: u64) {
        self.ctl = [0, 0x0020, 0x101F, 0, 0x0044, 0, 0xC1CD, 0x0700 | DCOFFG | XT1LFOFFG, 0x0707];
        self.gates = 0;
        self.pins = [false; 2];
        self.locked = false;
        self.next_step = now;
        self.update(now);
    }

    /// The pins of XT1 and XT2 are selected or not.
    pub fn select_pins(&mut self, xt1: bool, xt2: bool, now: u64) {
        if self.pins != [xt1, xt2] {
            self.pins = [xt1, xt2];
            self.update(now);
        }
    }

    /// Reads the register at `offset` from UCSCTL0.
    pub fn read(&self, offset: u16) -> u16 {
        self.ctl[usize::from(offset / 2).min(8)]
    }

    /// Writes the register at `offset` from UCSCTL0, under a mask.
    pub fn write(&mut self, offset: u16, value: u16, now: u64) {
        let n = usize::from(offset / 2).min(8);
        let kept = [0x1FF8, 0x0071, 0x73FF, 0x0077, 0x0777, 0x7777, 0xD1FF, 0x070F, 0x0707][n];
        // Flags are cleared by the program, never set.
        self.ctl[n] = if n == 7 { value & self.ctl[7] & kept } else { value & kept };
        if matches!(n, 0..=3) {
            self.locked = false;
            self.next_step = now;
        }
        self.update(now);
    }

    /// Fault flags that stand.
    pub fn faults(&self) -> u16 {
        self.ctl[7] & FLAGS
    }

    /// A crystal started, or the loop makes a step.
    pub fn event(&mut self, now: u64) {
        if self.next_step <= now {
            self.step(now);
        }
        self.update(now);
    }

    fn range(&self) -> u16 {
        self.ctl[1] >> 4 & 7
    }

    /// DCOCLK is that many times DCOCLKDIV.
    fn loop_divider(&self) -> u64 {
        1 << (self.ctl[2] >> 12 & 7).min(5)
    }

    /// Rate of the loop's reference before its divider, in hertz: REFO stands in for what failed.
    fn reference(&self, now: u64) -> u64 {
        match self.ctl[3] >> 4 & 7 {
            0 if self.xt1.runs(now) => XT1_HZ,
            5 if self.xt2.runs(now) => self.xt2_hz,
            _ => self.refo_hz,
        }
    }

    fn reference_divider(&self) -> u64 {
        [1, 2, 4, 8, 12, 16, 16, 16][usize::from(self.ctl[3] & 7)]
    }

    /// Rate of DCOCLK that the loop is set to, in hertz.
    fn wanted(&self, now: u64) -> f64 {
        let factor = self.loop_divider() * (u64::from(self.ctl[2] & 0x3FF) + 1);
        (factor * self.reference(now)) as f64 / self.reference_divider() as f64
    }

    fn loop_runs(&self) -> bool {
        self.gates & SCG0 == 0
    }

    fn value(&self) -> u16 {
        self.ctl[0] >> 3
    }

    /// The loop compares once in a period of its divided reference, and moves by one step at most.
    fn step(&mut self, now: u64) {
        let hz = self.reference(now).max(1);
        let period = self.ticks_per_second * self.reference_divider() / hz;
        self.next_step = now + period;
        let wanted = self.wanted(now);
        let best = dco::value_for(self.range(), wanted);
        let value = self.value();
        if self.mode == Fll::AtOnce {
            self.locked = true;
            self.ctl[0] = value_bits(best);
        } else if value == best && self.mode == Fll::Ramp {
            self.locked = true;
        } else if dco::hertz(self.range(), value) <= wanted {
            self.ctl[0] = value_bits((value + 1).min(dco::STEPS - 1));
        } else {
            self.ctl[0] = value_bits(value.saturating_sub(1));
        }
    }

    /// Rate of DCOCLK in hertz.
    fn dco_hz(&self, now: u64) -> f64 {
        if self.locked && self.loop_runs() {
            self.wanted(now)
        } else {
            dco::hertz(self.range(), self.value())
        }
    }

    /// Starts and stops oscillators, raises faults, and computes the periods and the next event.
    pub fn update(&mut self, now: u64) {
        let selects = [self.ctl[4] >> 8, self.ctl[4] >> 4, self.ctl[4]].map(Source::of);
        let reference = self.ctl[3] >> 4 & 7;
        let asks = |source: Source, field: u16| selects.contains(&source) || reference == field;
        let xt1 = asks(Source::Xt1, 0) || self.ctl[6] & XT1OFF == 0;
        let xt2 = asks(Source::Xt2, 5) || self.ctl[6] & XT2OFF == 0;
        self.xt1.request(xt1 && self.pins[0], now);
        self.xt2.request(xt2 && self.pins[1], now);
        let running = [self.xt1.runs(now), self.xt2.runs(now)];
        if self.running != running {
            self.running = running;
            self.locked = false;
            self.next_step = now;
        }
        if xt1 && !self.xt1.runs(now) {
            self.ctl[7] |= XT1LFOFFG;
        }
        if xt2 && !self.xt2.runs(now) {
            self.ctl[7] |= XT2OFFG;
        }
        if matches!(self.value() / 32, 0 | 31) && !self.locked {
            self.ctl[7] |= DCOFFG;
        }
        self.rates = self.periods(selects, now);
        let crystal = [&self.xt1, &self.xt2].into_iter().filter_map(Crystal::ready_at);
        self.next = crystal.filter(|at| *at > now).min().unwrap_or(NEVER);
        let steps = self.loop_runs() && (!self.locked || self.mode == Fll::Hunting);
        if steps {
            self.next_step = self.next_step.max(now);
            self.next = self.next.min(self.next_step);
        }
    }

    fn periods(&self, selects: [Source; 3], now: u64) -> Rates {
        let ticks = |hz: u64| (self.ticks_per_second + hz / 2) / hz.max(1);
        let dco_hz = self.dco_hz(now).max(1.0);
        let dco = ((self.ticks_per_second as f64 / dco_hz).round() as u64).max(1);
        let divided = ((self.ticks_per_second as f64 * self.loop_divider() as f64 / dco_hz).round()
            as u64)
            .max(1);
        let vlo = ticks(self.vlo_hz);
        // A failed crystal is replaced: XT1 by REFO, XT2 by DCOCLKDIV, for ACLK by REFO.
        let period = |source: Source, aclk: bool| match source {
            Source::Xt1 if self.xt1.runs(now) => ticks(XT1_HZ),
            Source::Xt2 if self.xt2.runs(now) => ticks(self.xt2_hz),
            Source::Vlo => vlo,
            Source::Dco => dco,
            Source::Xt1 | Source::Refo => ticks(self.refo_hz),
            Source::Xt2 if aclk => ticks(self.refo_hz),
            Source::DcoDivided | Source::Xt2 => divided,
        };
        let shift = |field: u16| (self.ctl[5] >> field & 7).min(5);
        let [a, s, m] = selects;
        let gate = |off: bool, ticks: u64| if off { 0 } else { ticks };
        let smclk_off = self.gates & SCG1 != 0 || self.ctl[6] & SMCLKOFF != 0;
        Rates {
            mclk: period(m, false) << shift(0),
            smclk: gate(smclk_off, period(s, false) << shift(4)),
            aclk: gate(self.gates & OSCOFF != 0, period(a, true) << shift(8)),
            vlo,
            second: self.ticks_per_second,
        }
    }
}

fn value_bits(value: u16) -> u16 {
    value << 3
}

#[cfg(test)]
mod tests {
    use super::*;

    const TPS: u64 = 10_000_000_000;
    const MS: u64 = TPS / 1000;

    fn settled(silicon: &Silicon, writes: &[(u16, u16)]) -> Ucs {
        let mut ucs = Ucs::new(silicon, 9_400, TPS);
        ucs.select_pins(false, true, 0);
        for (offset, value) in writes {
            ucs.write(*offset, *value, 0);
        }
        let mut guard = 0;
        while ucs.next < 100 * MS && guard < 1_000_000 {
            let at = ucs.next;
            ucs.event(at);
            guard += 1;
        }
        ucs
    }

    /// Table 4.4 of the project's notes: what TI's and public code set.
    #[test]
    fn settings_give_their_rates() {
        let rows = [
            (0x0060, 0x0063, 0x0055, 400),
            (0x0050, 0x003F, 0x0055, 625),
            (0x0060, 0x0018, 0x0052, 400),
            (0x0060, 0x02FA, 0x0020, 400),
        ];
        for (ctl1, ctl2, ctl3, ticks) in rows {
            for fll in [Fll::AtOnce, Fll::Ramp] {
                let silicon = Silicon { fll, ..Silicon::default() };
                let writes = [(12, 0x00CD), (2, ctl1), (4, ctl2), (6, ctl3), (8, 0x0233), (14, 0)];
                let ucs = settled(&silicon, &writes);
                assert_eq!((ucs.rates.mclk, ucs.rates.smclk), (ticks, ticks), "{ctl1:x} {fll:?}");
                assert!((305_000..305_300).contains(&ucs.rates.aclk));
            }
        }
    }

    #[test]
    fn after_a_reset_mclk_is_32_times_refo() {
        let ucs = settled(&Silicon::default(), &[]);
        assert_eq!(ucs.rates.mclk, 9537);
        assert_ne!(ucs.faults() & XT1LFOFFG, 0);
    }

    #[test]
    fn a_missing_xt2_is_replaced_and_its_flag_comes_back() {
        let silicon = Silicon { xt2_fitted: false, ..Silicon::default() };
        let mut ucs = settled(&silicon, &[(12, 0x00CD), (6, 0x0055), (8, 0x0255)]);
        assert_ne!(ucs.faults() & XT2OFFG, 0);
        ucs.write(14, 0, 100 * MS);
        assert_ne!(ucs.faults() & XT2OFFG, 0, "it stands as long as the fault does");
        let rate = 32 * 32_768 / 16;
        assert_eq!(ucs.rates.mclk, (TPS + rate / 2) / rate, "DCOCLKDIV from REFO / 16");
    }

    #[test]
    fn hunting_stays_near_its_rate_and_does_not_stand() {
        let silicon = Silicon { fll: Fll::Hunting, ..Silicon::default() };
        let writes = [(12, 0x00CD), (2, 0x0060), (4, 0x0063), (6, 0x0055), (8, 0x0233)];
        let mut ucs = settled(&silicon, &writes);
        let mut seen = std::collections::BTreeSet::new();
        for _ in 0..1000 {
            let at = ucs.next;
            ucs.event(at);
            seen.insert(ucs.rates.mclk);
        }
        assert!(seen.len() > 1 && seen.iter().all(|t| (398..=402).contains(t)), "{seen:?}");
    }
}
