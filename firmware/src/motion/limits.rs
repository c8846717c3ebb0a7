//! What the planner must know of an axis.

use super::math::mul_div;

/// Scale, rates and ramps of one axis, from the machine's profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AxisLimits {
    /// `steps` motor steps move the axis by `um` micrometres; both 1..=65535.
    pub steps: u16,
    /// See `steps`.
    pub um: u16,
    /// Start and stop rate, steps/s.
    pub start: u32,
    /// Top rate, steps/s.
    pub top: u32,
    /// Ramp up, steps/s2.
    pub accel: u32,
    /// Ramp down, steps/s2.
    pub decel: u32,
}

impl AxisLimits {
    /// A number of steps as micrometres, rounded down.
    pub fn to_um(&self, steps: u32) -> u32 {
        mul_div(steps, u32::from(self.um), u32::from(self.steps))
    }
}
