//! Variation: the deviations of a run, drawn from a seed, written and read as text, and taken back one by one until
//! the fewest and smallest are left that still give the same class of outcome.
//!
//! A run is a pure function of script, cell and list of deviations. Each row of the file and each thing draws from a
//! stream of its own, so that taking one deviation back leaves all others as they were.

mod numbers;
mod text;

pub use numbers::{value, values};

use super::scene::{Scene, Spread, Vary};

/// A deviation from what the cell file says.
#[derive(Clone, Debug, PartialEq)]
pub struct Deviation {
    /// `stuck`, or the key of a number: `nozzle.build_ms`, `tray.at`.
    pub what: String,
    /// The thing that it strikes; empty for the run.
    pub of: String,
    /// How much: difference of a number in its own unit, us of a fault, steps of a stall.
    pub by: Vec<f64>,
    /// When a fault of the run comes, us.
    pub at_us: Option<u64>,
}

/// A stream of random numbers, by its seed alone: splitmix64 (Steele, Lea, Flood 2014).
struct Stream(u64);

impl Stream {
    /// The stream of a row and a thing.
    fn new(seed: u64, row: usize, thing: usize) -> Self {
        let mut stream = Self(
            seed ^ (row as u64).wrapping_mul(0xA076_1D64_78BD_642F)
                ^ (thing as u64).wrapping_mul(0xE703_7ED1_A0B4_28DB),
        );
        stream.next();
        stream
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ (mixed >> 31)
    }

    /// 0 to below 1.
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Normal with standard deviation 1 (Box and Muller), cut at four of them: what is beyond is no tolerance.
    fn normal(&mut self) -> f64 {
        let (u, v) = (1.0 - self.unit(), self.unit());
        ((-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()).clamp(-4.0, 4.0)
    }
}

/// A difference with at most three decimals, so that its text is exact.
fn short(number: f64) -> f64 {
    (number * 1000.0).round() / 1000.0
}

/// The deviations of a run.
#[must_use]
pub fn draw(scene: &Scene, seed: u64) -> Vec<Deviation> {
    let mut list = Vec::new();
    for (row, vary) in scene.varies.iter().enumerate() {
        match vary {
            Vary::Number { key, spread, each } => {
                let things = if *each {
                    things_of(scene, key.split('.').next().unwrap_or_default())
                } else {
                    vec![String::new()]
                };
                let values = values(scene, key);
                if values.is_empty() {
                    continue;
                }
                for (index, thing) in things.into_iter().enumerate() {
                    let mut stream = Stream::new(seed, row, index);
                    let by = values
                        .iter()
                        .map(|&value| short(difference(*spread, value, &mut stream)))
                        .collect();
                    list.push(Deviation { what: key.clone(), of: thing, by, at_us: None });
                }
            }
            Vary::Fault { fault, of, chance, up_to_us, steps, within_us } => {
                // Parts of a feeder are struck one by one; a feeder that is slow is one.
                let parts =
                    matches!(fault.as_str(), "missing" | "stuck" | "lost" | "double" | "turned");
                let things = match of {
                    Some(of) if parts => things_of(scene, of),
                    of => vec![of.clone().unwrap_or_default()],
                };
                for (index, thing) in things.into_iter().enumerate() {
                    let mut stream = Stream::new(seed, row, index);
                    let (strikes, size, time) = (stream.unit(), stream.unit(), stream.unit());
                    // A tolerance without a chance always comes, of some size.
                    let certain = *chance == 0.0 && matches!(fault.as_str(), "slow" | "late");
                    if strikes >= *chance && !certain {
                        continue;
                    }
                    let by = match (up_to_us, steps) {
                        (Some(most), _) => vec![(size * *most as f64).round()],
                        (None, Some(steps)) => vec![f64::from(*steps)],
                        (None, None) => Vec::new(),
                    };
                    let at_us = within_us.map(|within| (time * within as f64) as u64);
                    list.push(Deviation { what: fault.clone(), of: thing, by, at_us });
                }
            }
        }
    }
    list
}

fn difference(spread: Spread, value: f64, stream: &mut Stream) -> f64 {
    match spread {
        Spread::Sigma(sigma) => stream.normal() * sigma,
        Spread::Range(least, most) => least + stream.unit() * (most - least),
        Spread::Share(share) => stream.normal() * share * value,
    }
}

/// Parts of an endless feeder or belt that draw faults and differences of their own; those after them have none.
const FED: u32 = 200;

/// The things that a name stands for: those of a feeder or a belt, also the parts that come later, else itself.
fn things_of(scene: &Scene, name: &str) -> Vec<String> {
    let feeder = scene.feeders.iter().find(|feeder| feeder.name == name);
    let belt = scene.conveyors.iter().find(|belt| belt.name == name && belt.feeds.is_some());
    let count = match (feeder, belt) {
        (Some(feeder), _) if feeder.advances() => feeder.length.unwrap_or(FED).min(FED),
        (Some(feeder), _) => feeder.pockets.len() as u32,
        (None, Some(_)) => FED,
        (None, None) => return vec![name.to_owned()],
    };
    (1..=count).map(|number| format!("{name}.{number}")).collect()
}

/// The scene with all deviations of its numbers. A number never leaves what is possible: times and pressures stay at 0
/// or above.
#[must_use]
pub fn applied(mut scene: Scene, deviations: &[Deviation]) -> Scene {
    for deviation in deviations {
        apply(&mut scene, deviation);
    }
    scene
}

/// Faults that only make something later: `late` people, `slow` sensors and feeders, sensors that `bounce`.
fn slower(scene: &mut Scene, deviation: &Deviation) {
    let us = deviation.by.first().copied().unwrap_or(0.0).max(0.0) as u64;
    let name = &deviation.of;
    match deviation.what.as_str() {
        "late" => {
            for person in scene.persons.iter_mut().filter(|person| person.name == *name) {
                person.after_us += us;
            }
        }
        "slow" | "bounce" => {
            for sensor in scene.sensors.iter_mut().filter(|sensor| sensor.name == *name) {
                if deviation.what == "bounce" {
                    sensor.bounce_us += us;
                } else {
                    sensor.on_us += us;
                    sensor.off_us += us;
                }
            }
            for feeder in scene.feeders.iter_mut().filter(|feeder| feeder.name == *name) {
                feeder.advance_us += us;
            }
        }
        _ => {}
    }
}

fn apply(scene: &mut Scene, deviation: &Deviation) {
    if !deviation.what.contains('.') {
        return slower(scene, deviation);
    }
    numbers::each(scene, &deviation.what, &deviation.of, &mut |index, number, least| {
        if let Some(by) = deviation.by.get(index) {
            *number = (*number + by).max(least);
        }
    });
}

/// Shrinks a list of deviations: `keeps` runs a shorter or smaller one and says whether the class of its outcome is the
/// same. Halves go first, then single ones, then magnitudes are halved, at most `runs` runs in all (delta debugging,
/// Zeller and Hildebrandt 2002).
pub fn shrink(
    deviations: &[Deviation],
    runs: usize,
    mut keeps: impl FnMut(&[Deviation]) -> bool,
) -> Vec<Deviation> {
    let mut list = deviations.to_vec();
    let mut left = runs;
    let mut holds = |candidate: &[Deviation]| {
        if left == 0 {
            return false;
        }
        left -= 1;
        keeps(candidate)
    };
    let mut piece = list.len().div_ceil(2);
    while piece > 0 && !list.is_empty() {
        let mut from = 0;
        let mut taken = false;
        while from < list.len() {
            let mut candidate = list.clone();
            candidate.drain(from..(from + piece).min(list.len()));
            if holds(&candidate) {
                list = candidate;
                taken = true;
            } else {
                from += piece;
            }
        }
        piece = if piece == 1 && taken { 1 } else { piece / 2 };
    }
    for index in 0..list.len() {
        // Half of it, as long as that still does it; then by quarters of the last step back.
        for number in 0..list[index].by.len() {
            let mut step = list[index].by[number] / 2.0;
            while step.abs() >= 0.001_f64.max(list[index].by[number].abs() / 64.0) {
                let mut candidate = list.clone();
                candidate[index].by[number] = short(candidate[index].by[number] - step);
                if holds(&candidate) {
                    list = candidate;
                } else {
                    step /= 2.0;
                }
            }
        }
    }
    list
}

#[cfg(test)]
mod tests {
    use super::{Deviation, shrink};
    use proptest::prelude::*;

    fn deviation(text: &str) -> Deviation {
        Deviation::parse(text).unwrap()
    }

    #[test]
    fn texts_are_read_as_they_are_written() {
        for text in [
            "stuck tray.11 813ms",
            "tray.at tray.3 0.31 -0.2",
            "pause at 12.5s",
            "stall Y 12st at 2s",
            "nozzle.build_ms 12.25",
            "late 'tool change' 5000ms",
            "late 'at' 5000ms",
            "late '5' 5000ms",
            "late '5ms' 5000ms at 2s",
            "'fine nozzle.build_ms' 12.25",
            "'the tray.at' 'the tray.3' 0.31 -0.2",
        ] {
            assert_eq!(deviation(text).text(), text);
        }
        assert_eq!(
            Deviation::parse("stuk tray.1").unwrap_err(),
            "`stuk` is no fault; `stuck` is meant?"
        );
        assert!(Deviation::parse("pause at noon").is_err());
        assert_eq!(
            Deviation::parse("late tool change 5000ms").unwrap_err(),
            "\"late tool change 5000ms\": `change` is no number; a name with blanks stands in quotes: 'tool change'"
        );
        assert!(Deviation::parse("late 'tool change 5000ms").unwrap_err().contains("has no end"));
    }

    #[test]
    fn what_does_not_matter_is_taken_back() {
        let list: Vec<Deviation> = (1..=15)
            .map(|pocket| deviation(&format!("tray.at tray.{pocket} 0.4 0.1")))
            .chain([deviation("stuck tray.11 813ms")])
            .collect();
        let mut runs = 0;
        let left = shrink(&list, 200, |list| {
            runs += 1;
            list.iter().any(|one| one.what == "stuck" && one.by[0] >= 310_000.0)
        });
        assert_eq!(left.len(), 1);
        assert!((310_000.0..330_000.0).contains(&left[0].by[0]), "{}", left[0].text());
        assert!(runs < 60, "{runs} runs");
    }

    proptest! {
        /// Whatever pair of deviations is to blame is what is left.
        #[test]
        fn the_guilty_are_left(count in 1usize..30, a in 0usize..30, b in 0usize..30) {
            let (a, b) = (a % count, b % count);
            let list: Vec<Deviation> = (0..count).map(|index| deviation(&format!("missing tray.{index}"))).collect();
            let guilty = [list[a].clone(), list[b].clone()];
            let left = shrink(&list, 10_000, |list| guilty.iter().all(|one| list.contains(one)));
            let mut wanted = vec![a.min(b), a.max(b)];
            wanted.dedup();
            prop_assert_eq!(left, wanted.into_iter().map(|index| list[index].clone()).collect::<Vec<_>>());
        }

        /// Any name that a cell file may give is read as it is written.
        #[test]
        fn any_name_is_read_as_it_is_written(
            of in "[A-Za-z0-9_ .-]{1,12}", by in proptest::option::of(0u32..1000), at in proptest::option::of(0u64..1000),
        ) {
            let by = by.map(|ms| f64::from(ms) * 1000.0).into_iter().collect();
            let own = Deviation { what: "late".to_owned(), of, by, at_us: at.map(|ms| ms * 1000) };
            prop_assert_eq!(Deviation::parse(&own.text()), Ok(own));
        }

        /// Any text is read or refused.
        #[test]
        fn any_text_ends_well(text in ".{0,40}") {
            if let Ok(deviation) = Deviation::parse(&text) {
                prop_assert!(!deviation.text().is_empty());
            }
        }
    }
}
