//! Analog inputs: sampled and filtered each millisecond by the firmware's own rule.

use firmware::analog::{ANALOGS, crosses, filtered, millivolts, sample};
use lang::profile::{FIRST_THRESHOLD, Profile};
use lang::record::{BoardRecord, ThresholdRecord};

/// A millisecond, us.
const MS: u64 = 1_000;

/// Analog inputs, from 0.
#[derive(Debug)]
pub struct Analog {
    levels: [ThresholdRecord; ANALOGS],
    /// What is at the pins, as samples.
    samples: [u16; ANALOGS],
    values: [u16; ANALOGS],
    /// Inputs that thresholds make.
    on: [bool; ANALOGS],
    /// The next sample is taken then, us; only while something changes.
    due: Option<u64>,
}

impl Analog {
    /// All at 0 V.
    pub fn new(profile: &Profile) -> Analog {
        let levels = BoardRecord::of(profile, 0).more().thresholds;
        let (samples, values) = ([0; ANALOGS], [0; ANALOGS]);
        Analog { levels, samples, values, on: [false; ANALOGS], due: None }
    }

    /// What was there before power-up needs no filter. Gives the inputs that thresholds make.
    pub fn settle(&mut self) -> Vec<(i32, bool)> {
        self.values = self.samples;
        self.due = None;
        self.cross()
    }

    /// The voltage at input `n`, from 1, is this from `now` on.
    pub fn drive(&mut self, n: i32, mv: u16, now: u64) {
        let place = usize::try_from(n - 1).ok();
        if let Some(own) = place.and_then(|place| self.samples.get_mut(place)) {
            *own = sample(mv.into());
            self.due = self.due.or(Some((now / MS + 1) * MS));
        }
    }

    /// When a sample changes something next, us.
    pub fn next_us(&self) -> Option<u64> {
        self.due
    }

    /// Takes the sample that is due at `now`; gives the inputs that thresholds make, with their states.
    pub fn sample(&mut self, now: u64) -> Vec<(i32, bool)> {
        if self.due.is_none_or(|due| due > now) {
            return Vec::new();
        }
        for ((value, sample), levels) in self.values.iter_mut().zip(self.samples).zip(self.levels) {
            *value = filtered(*value, sample, levels.filter());
        }
        self.due = (self.values != self.samples).then_some((now / MS + 1) * MS);
        self.cross()
    }

    fn cross(&mut self) -> Vec<(i32, bool)> {
        let mut made = Vec::new();
        for (n, (on, levels)) in (FIRST_THRESHOLD..).zip(self.on.iter_mut().zip(self.levels)) {
            let source = usize::from(levels.analog());
            if let Some(value) = source.checked_sub(1).and_then(|place| self.values.get(place)) {
                *on = crosses(levels, *value, *on);
                made.push((n, *on));
            }
        }
        made
    }

    /// `AIN(n)`, mV.
    pub fn read(&self, n: u8) -> i32 {
        let place = usize::from(n.wrapping_sub(1)) % ANALOGS;
        let divided = |a: u32, b: u32, c: u32| (u64::from(a) * u64::from(b) / u64::from(c)) as u32;
        millivolts(self.values[place], divided).into()
    }
}
