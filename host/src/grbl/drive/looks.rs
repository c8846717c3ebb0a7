//! State of the machine that is kept from poll to poll.

use std::time::{Duration, Instant};

use lang::wire;

use crate::client::{Client, ClientError};
use crate::grbl::settings::Machine;
use crate::link::Link;

/// Between two looks at inputs while it runs.
const INPUTS: Duration = Duration::from_millis(120);

/// What is remembered from look to look.
#[derive(Default)]
pub(super) struct Looks {
    /// When and where the last one was.
    place: Option<(Instant, [f64; 3])>,
    pub speed: f64,
    inputs_at: Option<Instant>,
    pub inputs: u32,
    pub limits: u8,
    pub moving: bool,
}

impl Looks {
    /// Speed from two places and their times, mm/min.
    pub fn pace(&mut self, place: [f64; 3]) {
        let now = Instant::now();
        if let Some((then, before)) = self.place {
            let time = now.duration_since(then).as_secs_f64();
            if time < 0.04 {
                return;
            }
            let way: f64 = place.iter().zip(before).map(|(a, b)| (a - b).powi(2)).sum();
            self.speed = if time < 1.0 { way.sqrt() / time * 60.0 } else { 0.0 };
        }
        self.place = Some((now, place));
    }

    /// Whether the axes were there at the last look, too.
    pub fn stands(&self, steps: [i32; 3], machine: &Machine) -> bool {
        self.place.is_some_and(|(_, before)| before == machine.place(steps))
    }

    /// Reads inputs and what moves, if it is time.
    pub fn inputs<L: Link>(&mut self, client: &mut Client<L>) -> Result<(), ClientError> {
        if self.inputs_at.is_none_or(|at| at.elapsed() > INPUTS) {
            self.inputs_now(client)?;
        }
        Ok(())
    }

    pub fn inputs_now<L: Link>(&mut self, client: &mut Client<L>) -> Result<(), ClientError> {
        let count = wire::LIMITS - wire::INPUTS + 1;
        let words = client.input(wire::INPUTS, count)?;
        let at = |register: u16| words[usize::from(register - wire::INPUTS)];
        self.inputs = u32::from(at(wire::INPUTS)) | u32::from(at(wire::INPUTS_HIGH)) << 16;
        self.moving = (at(wire::MOVING) | at(wire::HOMING)) & 0xFF != 0;
        let limits = at(wire::LIMITS);
        self.limits = (limits | limits >> 8) as u8;
        self.inputs_at = Some(Instant::now());
        Ok(())
    }
}
