//! A virtual board that stays up in real time, on a pseudo-terminal, a TCP port, or both.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use emulator::Board;
use lang::profile::Profile;

use super::Build;
use super::clients::Clients;
use super::hardware::Hardware;
use super::rig::{HostAction, Rig};
use super::switches::Switches;
use crate::output;
use crate::sim::world::WorldError;

/// Longest stretch of simulated time between two looks at the connections.
const SLICE_US: u64 = 1_000;
/// The same while nobody asks and one who does is heard at once.
const QUIET_US: u64 = 5_000;
/// The host's end of the line follows the chip's rate this often.
const FOLLOW_US: u64 = 50_000;

/// Pace of the board's time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// So many seconds in a second.
    Times(f64),
    /// As fast as it goes.
    Max,
}

/// What is done after each slice, before the board's replies go out.
type After<B> = Box<dyn FnMut(&mut Rig<B>) -> Result<(), ServeError>>;

/// A board's connections, and what goes on beside it.
pub struct Server<B: Hardware = Board> {
    /// Who asks it.
    pub clients: Clients,
    after: Vec<After<B>>,
}

impl<B: Hardware> Default for Server<B> {
    fn default() -> Server<B> {
        Server { clients: Clients::default(), after: Vec::new() }
    }
}

impl Server {
    /// Keeps the board's flash in a file: takes over what it holds, and saves what changes.
    ///
    /// # Errors
    /// The file cannot be read, or is no flash of this board.
    pub fn keep_flash(&mut self, rig: &mut Rig, file: &Path) -> io::Result<()> {
        match fs::read(file) {
            Ok(content) => rig.restore_flash(&content).map_err(io::Error::other)?,
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            Err(error) => return Err(error),
        }
        let (file, mut saved) = (file.to_owned(), rig.board().wear().operations);
        // What a reply says is done outlives the process.
        self.after.push(Box::new(move |rig| {
            let operations = rig.board().wear().operations;
            if std::mem::replace(&mut saved, operations) == operations {
                return Ok(());
            }
            output::replace(&file, &rig.board().flash_contents())
                .map_err(|error| ServeError::Flash(file.clone(), error))
        }));
        Ok(())
    }

    /// Puts the reference switches of a board that was given no world as they are needed.
    pub fn place_switches(&mut self, build: &Build, profile: &Profile) {
        let (mut switches, profile) = (Switches::new(build), profile.clone());
        self.after.push(Box::new(move |rig| {
            switches.look(rig, &profile);
            Ok(())
        }));
    }
}

impl<B: Hardware> Server<B> {
    /// Runs the board until `ended` says so, which may act on board and connections between two slices.
    ///
    /// # Errors
    /// The world fails or a file cannot be written; a client that goes is no error.
    pub fn run(
        &mut self,
        rig: &mut Rig<B>,
        speed: Speed,
        ended: &mut dyn FnMut(&mut Server<B>, &mut Rig<B>) -> bool,
    ) -> Result<(), ServeError> {
        let began = Instant::now();
        let first = rig.now();
        let mut follow_at = first;
        let mut behind = false;
        while !ended(self, rig) {
            // Who is behind the board's time does not rest.
            let slice_us = if self.clients.rest() { QUIET_US } else { SLICE_US };
            let wait = if behind { Duration::ZERO } else { Duration::from_micros(slice_us) };
            self.clients.read(wait);
            if let Some(bytes) = self.clients.next(rig.whole_us(rig.now())) {
                rig.board().uart_send(&bytes);
            }
            let slice = rig.now() + rig.ticks(slice_us);
            let target = match speed {
                Speed::Max => slice,
                Speed::Times(times) => {
                    let us = began.elapsed().as_secs_f64() * times * 1e6;
                    first + rig.ticks(us as u64)
                }
            };
            // A host that fell behind catches up slice by slice, so that replies do not wait.
            rig.run_until(target.min(slice).max(rig.now()))?;
            behind = speed == Speed::Max || target > slice;
            self.after.iter_mut().try_for_each(|after| after(rig))?;
            let heard = rig.board().uart_take();
            let heard = heard.into_iter().map(|(at, byte)| (rig.whole_us(at), byte));
            self.clients.heard(&heard.collect::<Vec<_>>());
            self.clients.answer(rig.whole_us(rig.now()));
            if rig.now() >= follow_at {
                rig.follow_uart();
                follow_at = rig.now() + rig.ticks(FOLLOW_US);
            }
            for action in rig.take_host_actions() {
                press(rig, action);
            }
        }
        self.after.iter_mut().try_for_each(|after| after(rig))
    }
}

/// What a scenario does through the host has no host here; the emergency stop is the RST pin.
fn press<B: Hardware>(rig: &mut Rig<B>, action: HostAction) {
    if action == HostAction::EmergencyStop {
        rig.board().reset_pin();
    }
}

/// Why a board does not stay up.
#[derive(Debug)]
pub enum ServeError {
    /// The world's script fails.
    World(WorldError),
    /// The flash's file cannot be written.
    Flash(PathBuf, io::Error),
}

impl From<WorldError> for ServeError {
    fn from(error: WorldError) -> ServeError {
        ServeError::World(error)
    }
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use lang::profile::Profile;

    use super::{Server, Speed};
    use crate::board::DEFAULT;
    use crate::board::rig::Rig;
    use crate::sim::world::{Registers, World};

    /// Seconds of the board's time for each of the desk's, over so long.
    fn pace(speed: Speed, over: Duration) -> f64 {
        let firmware = DEFAULT.image().expect("an image");
        let mill = Profile::built_in("mill").expect("the mill");
        let (world, registers) = (World::empty(), Registers::default());
        let mut rig = Rig::new(DEFAULT, &firmware, &mill, &world, &registers).expect("a rig");
        let (began, from) = (Instant::now(), rig.now());
        let mut took = Duration::ZERO;
        Server::default()
            .run(&mut rig, speed, &mut |_, _| {
                took = began.elapsed();
                took >= over
            })
            .expect("a run");
        (rig.now() - from) as f64 / rig.ticks(1_000_000) as f64 / took.as_secs_f64()
    }

    #[test]
    fn a_board_keeps_the_pace_it_is_told() {
        let over = Duration::from_secs(1);
        for times in [0.25, 1.0, 2.0] {
            let kept = pace(Speed::Times(times), over) / times;
            // Between two looks a slice of 1 ms passes, and a desk with other work comes late to the last one.
            assert!((0.9..1.01).contains(&kept), "{kept:.3} of {times} times real time");
        }
        let most = pace(Speed::Max, over);
        assert!(most > 2.0, "at most {most:.2} times real time");
    }

    #[test]
    fn a_board_told_to_be_faster_than_the_desk_runs_as_fast_as_it_can() {
        let over = Duration::from_millis(700);
        let most = pace(Speed::Max, over);
        let kept = pace(Speed::Times(1_000.0), over);
        assert!(kept > most * 0.6, "{kept:.2} of {most:.2} times real time");
    }
}
