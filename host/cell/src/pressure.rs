//! The pressure of a vacuum nozzle: an exponential in time toward what pump, seal and leak decide. Its crossings of a
//! level are solved, so switch, grip and loss come at their true microsecond.

use super::scene::Vacuum;

/// Highest voltage at a pin, mV: what lies above the supply is cut off by the pin.
pub const MOST_MV: f64 = 3_300.0;

impl Vacuum {
    /// Voltage of the pressure sensor at a pressure in kPa, V.
    #[must_use]
    pub fn volts_at(&self, kpa: f64) -> f64 {
        let share = (kpa - self.kpa[0]) / (self.kpa[1] - self.kpa[0]);
        self.volts[0] + share * (self.volts[1] - self.volts[0])
    }
}

/// Pressure below ambient, kPa, as a law in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pressure {
    /// kPa at `since`.
    from: f64,
    /// kPa that it goes to.
    target: f64,
    /// Time constant, us; above 0.
    tau_us: f64,
    /// Begin of this law, us.
    since: u64,
}

/// Shortest time constant, us: a key of 0 ms means at once.
const AT_ONCE_US: f64 = 1.0;

impl Pressure {
    /// No vacuum.
    #[must_use]
    pub fn none() -> Self {
        Self { from: 0.0, target: 0.0, tau_us: AT_ONCE_US, since: 0 }
    }

    /// kPa at a time, not before the begin of the law.
    #[must_use]
    pub fn at(&self, us: u64) -> f64 {
        let gone = us.saturating_sub(self.since) as f64;
        self.target + (self.from - self.target) * (-gone / self.tau_us).exp()
    }

    /// The law from now on. A leak lowers what a sealed nozzle reaches: in the balance of `dp/dt = (sealed - p) / build -
    /// leak` the pressure is `sealed - leak * build`.
    #[must_use]
    pub fn toward(&self, vacuum: &Vacuum, pump: bool, sealed: bool, now: u64) -> Self {
        let (target, tau_us) = match (pump, sealed) {
            (true, true) => (
                (vacuum.sealed_kpa - vacuum.leak_kpa_s * vacuum.build_us / 1e6).max(0.0),
                vacuum.build_us,
            ),
            (true, false) => (vacuum.open_kpa, vacuum.vent_us.min(vacuum.build_us)),
            (false, _) => (0.0, vacuum.vent_us),
        };
        Self { from: self.at(now), target, tau_us: tau_us.max(AT_ONCE_US), since: now }
    }

    /// kPa that it goes to.
    #[must_use]
    pub fn target(&self) -> f64 {
        self.target
    }

    /// The first whole microsecond from `now` on at which it is at or beyond `level`, on the side that it goes to; `now`
    /// when it is there already, `None` when it never comes there.
    #[must_use]
    pub fn crosses(&self, level: f64, now: u64) -> Option<u64> {
        let rises = self.target > self.from;
        let beyond = |kpa: f64| if rises { kpa >= level } else { kpa < level };
        if beyond(self.at(now)) {
            return Some(now);
        }
        if !beyond(self.target) {
            return None;
        }
        let share = (level - self.target) / (self.from - self.target);
        let when = self.since + (-self.tau_us * share.ln()).max(0.0).ceil() as u64;
        // Rounding of the logarithm may be one off.
        let mut when = when.max(now + 1).saturating_sub(1).max(now);
        while !beyond(self.at(when)) {
            when += 1;
        }
        Some(when)
    }
}

#[cfg(test)]
mod tests {
    use super::Pressure;
    use crate::scene::Vacuum;
    use proptest::prelude::*;

    fn vacuum(build_ms: f64, vent_ms: f64, leak: f64) -> Vacuum {
        Vacuum {
            sealed_kpa: 60.0,
            open_kpa: 8.0,
            hold_kpa: 20.0,
            build_us: build_ms * 1000.0,
            vent_us: vent_ms * 1000.0,
            leak_kpa_s: leak,
            reach: 1.0,
            gap: 0.2,
            press: 1.0,
            hold_n: None,
            input: None,
            on_kpa: 30.0,
            off_kpa: 25.0,
            analog: None,
            volts: [0.5, 4.5],
            kpa: [0.0, 100.0],
        }
    }

    #[test]
    fn a_nozzle_holds_after_its_build_up() {
        let vacuum = vacuum(90.0, 15.0, 0.0);
        let sealed = Pressure::none().toward(&vacuum, true, true, 1_000_000);
        // 90 ms * ln(60 / 40)
        assert_eq!(sealed.crosses(20.0, 1_000_000), Some(1_036_492));
        let open = sealed.toward(&vacuum, true, false, 1_500_000);
        assert_eq!(open.crosses(5.0, 1_500_000), None, "an open nozzle stays at 8 kPa");
    }

    proptest! {
        /// The solved crossing is the first microsecond at which the level is passed.
        #[test]
        fn a_crossing_is_the_first(
            build in 0.0..3.0f64, vent in 0.0..3.0f64, leak in 0.0..100.0f64, pump in any::<bool>(), sealed in any::<bool>(),
            first in 0u64..5000, level in 0.0..70.0f64, later in 0u64..3000,
        ) {
            let vacuum = vacuum(build, vent, leak);
            let law = Pressure::none().toward(&vacuum, true, true, 0).toward(&vacuum, pump, sealed, first);
            let now = first + later;
            let rises = law.target() > law.at(first);
            let beyond = |us: u64| if rises { law.at(us) >= level } else { law.at(us) < level };
            match law.crosses(level, now) {
                Some(when) => {
                    prop_assert!(beyond(when));
                    prop_assert!(when == now || !beyond(when - 1), "{when} is not the first");
                }
                None => prop_assert!(!beyond(now + 60_000)),
            }
        }
    }
}
