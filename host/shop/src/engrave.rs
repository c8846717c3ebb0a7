//! Pictures for a laser: PNG and JPEG in lines, SVG along its paths.
//!
//! [`picture`] decodes, [`dither`] makes powers of greys, [`raster`] the lines, [`trace`] the paths of a
//! drawing; [`write`] puts both into a script or into G-code. Lengths are in mm, powers are S words.

pub mod dither;
pub mod picture;
pub mod raster;
#[cfg(test)]
mod tests;
pub mod trace;
mod write;

use lang::profile::{OutputRole, Profile, PwmKind};

pub use write::{Form, write};

use crate::Wrong;

/// Largest file that is read, bytes.
pub const MAX_BYTES: usize = 64 << 20;
/// Longest job that is written, bytes: as long as the importers and `stream` read.
pub const MAX_TEXT: usize = 64 << 20;

/// A laser as the job needs it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Laser {
    /// S of full power.
    pub full: u32,
    /// The power follows the speed (M4).
    pub follows: bool,
    /// Smallest and greatest X and Y, mm.
    pub travel: [[f64; 2]; 2],
    /// Way that X needs from rest to a speed of 1 mm/s, times the speed squared, mm.
    pub ramp: f64,
}

impl Laser {
    /// That of a profile.
    ///
    /// # Errors
    /// The machine has no laser; in words.
    pub fn of(profile: &Profile) -> Result<Laser, String> {
        let pwm = profile.pwm.as_ref().filter(|pwm| pwm.kind == PwmKind::Laser);
        let role = profile.outputs.iter().any(|output| output.role == Some(OutputRole::Laser));
        let (Some(x), Some(y)) = (&profile.x, &profile.y) else {
            return Err(format!("the machine {} has no X and Y", profile.name));
        };
        if pwm.is_none() && !role {
            return Err(format!(
                "the machine {} has no laser: --profile laser, or an output with role = \"laser\"",
                profile.name
            ));
        }
        let mm = |um: i32| f64::from(um) / 1000.0;
        let accel = x.accel.min(x.decel.unwrap_or(x.accel));
        // mm/s2.
        let accel = f64::from(accel) * f64::from(x.scale.um) / f64::from(x.scale.steps) / 1000.0;
        Ok(Laser {
            full: pwm.map_or(1000, |pwm| pwm.range.unsigned_abs()),
            follows: pwm.is_some(),
            travel: [[mm(x.min_um), mm(y.min_um)], [mm(x.max_um), mm(y.max_um)]],
            ramp: 0.5 / accel.max(1.0),
        })
    }

    /// What lies outside of the travel; with a remedy.
    fn holds(&self, low: [f64; 2], high: [f64; 2]) -> Result<(), Wrong> {
        for (n, letter) in ["X", "Y"].into_iter().enumerate() {
            let [from, to] = [self.travel[0][n], self.travel[1][n]];
            if low[n] < from - 1e-6 || high[n] > to + 1e-6 {
                let words = format!(
                    "{letter} goes from {:.3} to {:.3} mm, the machine from {from} to {to}",
                    low[n], high[n]
                );
                let hint = "a smaller --size, a shorter --overscan, or another place with --at";
                return Err(Wrong::whole(words, hint));
            }
        }
        Ok(())
    }
}

/// A straight way of a job.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Where to.
    pub to: [f64; 2],
    /// S; none for a rapid move, dark.
    pub power: Option<u32>,
}

/// The ways of a job, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Job {
    /// The ways.
    pub steps: Vec<Step>,
    /// Remarks for its head.
    pub head: Vec<String>,
}

impl Job {
    /// How long it takes at least, s: the ways at this speed, mm/s.
    pub fn seconds(&self, speed: f64) -> f64 {
        self.way(|_| true) / speed
    }

    /// The length of some of its ways, mm.
    pub fn way(&self, of: impl Fn(&Step) -> bool) -> f64 {
        let mut at = [0.0; 2];
        let mut sum = 0.0;
        for step in &self.steps {
            if of(step) {
                sum += (step.to[0] - at[0]).hypot(step.to[1] - at[1]);
            }
            at = step.to;
        }
        sum
    }
}
