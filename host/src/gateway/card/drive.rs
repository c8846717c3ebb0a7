//! Moves for a card's client, made by commands of the board that end by themselves: the link may
//! break at any time, and an axis goes no farther than commanded.
//!
//! A command is sent by the line's thread, which checks in the same step whether a stop has come: a stop
//! overtakes all waiting requests, and no move that was requested before it starts after it.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use import::card::Phase;
use lang::axis::Axis;
use lang::fault::Fault;
use lang::profile::{AxisProfile, Profile};
use lang::record::MachineRecord;
use lang::wire::{self, Control, End, Exception, RunState, command};

use super::stopper::{Answer, LIMIT, NO_MACHINE, NOT_NOW, STOPPED, Stopper, Trouble, is_running};
use super::talk::Stop;
use crate::client::orders::{home, move_to, ramps, words};
use crate::client::status::{StatusWords, long};
use crate::client::{Client, ClientError};
use crate::gateway::Gateway;
use crate::gateway::inside::{ADDRESS, Inside};
use crate::gateway::turns::Asker;

/// Between two looks at a board that moves. The board itself ends a move of several axes 2 s after
/// the last one.
const LOOK: Duration = Duration::from_millis(25);
/// Looks at a resting board before it is sure that nothing begins any more.
const RESTS: u32 = 4;
/// Looks without an answer before the board is given up.
const MISSES: u32 = 40;
/// Longest move or reference run.
const LONGEST: Duration = Duration::from_secs(600);
/// What a machine's position may differ by from what was asked for in all moves so far, and still be
/// that: lengths are micrometres.
const CLOSE: i64 = 2;

/// How a board stands.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Axes that move or search their switch.
    moving: u16,
    /// Axes whose last reference run failed.
    missed: u16,
    /// What it does.
    pub state: Option<RunState>,
    /// Its fault.
    fault: Option<Fault>,
    /// How its last run ended.
    pub end: Option<End>,
    /// Runs begun.
    pub runs: u16,
    /// Machine positions, steps.
    pub steps: [i32; 3],
}

/// See the module.
pub struct Drive {
    stops: Stopper,
    pub profile: Profile,
    /// Speeds of reference runs that the client wants, steps/s.
    pub speeds: [Option<i64>; 3],
    /// Where the client's moves lead to, steps: a position is rounded each time, this is not.
    wanted: [Option<i64>; 3],
}

impl Drive {
    /// A board of the gateway with this machine.
    pub fn new(gateway: &Arc<Gateway>, board: usize, asker: Asker, profile: Profile) -> Drive {
        let stops = Stopper::new(gateway, board, asker);
        Drive { stops, profile, speeds: [None; 3], wanted: [None; 3] }
    }

    /// What stops it.
    pub fn stopper(&self) -> Stopper {
        self.stops.clone()
    }

    /// A master of its own, for what takes more than an exchange or two.
    pub fn client(&self) -> Option<Client<Inside>> {
        let gateway = self.stops.gateway.upgrade()?;
        Some(Client::new(Inside::new(&gateway, self.stops.board, self.stops.asker), ADDRESS))
    }

    /// Asks how the board stands.
    ///
    /// # Errors
    /// It does not answer.
    pub fn look(&self) -> Result<Look, Answer> {
        let look = self.stops.ask(false, |board| {
            let motion = board.input(wire::MOVING, 2)?;
            let run = board.holding(wire::RUN_STATE, StatusWords::RUN_LENGTH)?;
            Ok((motion, run))
        });
        let (motion, run) = look.map_err(|trouble| trouble.answer())?;
        let at = |register: u16| run[usize::from(register - wire::RUN_STATE)];
        let position = |n: u16| {
            let register = wire::MACHINE_POSITIONS + 2 * n;
            long(at(register), at(register + 1))
        };
        Ok(Look {
            moving: (motion[0] | motion[1]) & 0xFF,
            missed: motion[1] >> 8,
            state: RunState::from_number(at(wire::RUN_STATE)),
            fault: u8::try_from(at(wire::FAULT)).ok().and_then(Fault::from_number),
            end: End::from_number(at(wire::LAST_END)),
            runs: at(wire::RUN_COUNT),
            steps: [0, 1, 2].map(position),
        })
    }

    /// Sends an order unless a stop has come since their number was `stops`.
    fn order(&self, stops: u64, order: Vec<u16>) -> Result<(), Answer> {
        let count = self.stops.count.clone();
        let machine = MachineRecord::of(&self.profile).hash();
        let sent = self.stops.ask(false, move |board| {
            if count.load(Ordering::SeqCst) != stops {
                return Err(ClientError::Interrupted);
            }
            // Somebody else may have brought a program for another machine.
            let by_program = order[0] == command::JOG;
            if by_program && board.holding(wire::PROGRAM_PROFILE, 1)?[0] != machine {
                return Err(ClientError::Exception(Exception::Busy as u8));
            }
            board.once(|board| board.write_all(wire::COMMAND, &order))
        });
        sent.map_err(|trouble| {
            if matches!(&trouble, Trouble::Board(error) if error.may_be_done()) {
                // Nothing tells whether the board took it: what moves is stopped.
                self.stops.send(Stop::Software);
            }
            trouble.answer()
        })
    }

    /// Writes a run control unless a stop has come since.
    ///
    /// # Errors
    /// The answer for the client.
    pub fn control(&self, stops: u64, control: Control) -> Result<(), Answer> {
        let count = self.stops.count.clone();
        let sent = self.stops.ask(false, move |board| {
            if count.load(Ordering::SeqCst) != stops {
                return Err(ClientError::Interrupted);
            }
            board.control(control)
        });
        sent.map_err(|trouble| trouble.answer())
    }

    /// Whether the board is one that this card may move: its profile is the card's, and so is that of the
    /// program on it, by which lines are drawn.
    ///
    /// # Errors
    /// What differs, in words; or the board does not answer.
    pub fn must_fit(&self) -> Result<bool, String> {
        let found = self.stops.ask(false, |board| {
            let record = board.board_record()?;
            let length = board.holding(wire::PROGRAM_LENGTH, 1)?[0];
            Ok((record, length, board.holding(wire::PROGRAM_PROFILE, 1)?[0]))
        });
        let (record, length, machine) = match found {
            Ok(found) => found,
            Err(Trouble::Gone) => return Err("the board does not answer".to_owned()),
            Err(Trouble::Board(error)) => return Err(error.to_string()),
        };
        crate::client::identity::must_match(&record, &self.profile)?;
        if length > 0 && machine != MachineRecord::of(&self.profile).hash() {
            return Err(format!(
                "the program on the board was made for another machine than `{}`: upload one for this \
                 machine, or name its profile in [[card]]",
                self.profile.name
            ));
        }
        Ok(length > 0)
    }

    /// The board at rest, free for a client's order.
    fn ready(&self) -> Result<Look, Answer> {
        let look = self.look()?;
        match look.state {
            Some(RunState::Fault) => Err(answer_of(look.fault)),
            Some(state) if is_running(state) => Err(NOT_NOW),
            _ if look.moving != 0 => Err(NOT_NOW),
            _ => Ok(look),
        }
    }

    /// Moves axes together; `absolute`: to machine positions.
    ///
    /// # Errors
    /// The answer for the client.
    pub fn phase(&mut self, stops: u64, phase: &Phase, absolute: bool) -> Result<(), Answer> {
        let look = self.ready()?;
        let mut targets = Vec::new();
        for (axis, value) in &phase.axes {
            let there = i64::from(look.steps[axis.index()]);
            let known = self.wanted[axis.index()].filter(|at| (at - there).abs() <= CLOSE);
            let target = if absolute { *value } else { known.unwrap_or(there) + value };
            // An axis that the machine has not may be named as long as it is to stand still.
            match self.profile.axis(*axis) {
                None if target != there => return Err('3'),
                None => {}
                Some(_) if target == there => {}
                Some(own) if i32::try_from(target).is_ok() => {
                    targets.push((*axis, own.clone(), target));
                }
                Some(_) => return Err(NOT_NOW),
            }
        }
        let offset = self.offsets(&look)?;
        let order = match &targets[..] {
            [] => return Ok(()),
            [(axis, own, target)] => {
                let top = own.top_rate.unsigned_abs();
                let speed = u32::try_from(phase.rate).unwrap_or(top).clamp(1, top);
                move_to(*axis, ramps(own), speed, target - offset[axis.index()])
            }
            several => line(several, look.steps, offset, phase.rate),
        };
        self.order(stops, order)?;
        for (axis, _, target) in &targets {
            self.wanted[axis.index()] = Some(*target);
        }
        let reached = |look: &Look| {
            targets.iter().all(|(axis, _, target)| {
                (i64::from(look.steps[axis.index()]) - target).abs() <= CLOSE
            })
        };
        let rest = self.wait(reached)?;
        match (reached(&rest), rest.state) {
            (true, _) if self.stops.count() == stops => Ok(()),
            (_, Some(RunState::Fault)) => Err(answer_of(rest.fault)),
            _ => Err(STOPPED),
        }
    }

    /// Machine positions less work positions, steps.
    fn offsets(&self, look: &Look) -> Result<[i64; 3], Answer> {
        let work = self.stops.ask(false, |board| board.input(wire::WORK_POSITIONS, 6));
        let work = work.map_err(|trouble| trouble.answer())?;
        let at = |n: usize| i64::from(long(work[2 * n], work[2 * n + 1]));
        Ok([0, 1, 2].map(|n| i64::from(look.steps[n]) - at(n)))
    }

    /// Waits until nothing moves.
    fn wait(&self, reached: impl Fn(&Look) -> bool) -> Result<Look, Answer> {
        let (begun, mut rests, mut misses) = (Instant::now(), 0, 0);
        loop {
            std::thread::sleep(LOOK);
            match self.look() {
                Ok(look) if look.moving == 0 => {
                    rests += 1;
                    // An order is taken within some ms: a look at once would see the axis at rest.
                    if reached(&look) || rests >= RESTS {
                        return Ok(look);
                    }
                }
                Ok(_) => (rests, misses) = (0, 0),
                Err(answer) => {
                    misses += 1;
                    if misses >= MISSES {
                        return Err(answer);
                    }
                }
            }
            if begun.elapsed() > LONGEST {
                self.stops.stop(Stop::Software);
                return Err(STOPPED);
            }
        }
    }

    /// Reference runs, one after the other.
    ///
    /// # Errors
    /// The answer for the client.
    pub fn home(&mut self, stops: u64, axes: &[Axis]) -> Result<(), Answer> {
        for axis in axes {
            let look = self.look()?;
            // Behind a limit or a stop it is the reference run that begins anew (binder, error 2).
            if look.state == Some(RunState::Fault) {
                self.control(stops, Control::Acknowledge)?;
                std::thread::sleep(LOOK);
            }
            self.ready()?;
            let mut order = home(&self.profile, *axis).map_err(|_| '3')?;
            if let Some(rate) = self.speeds[axis.index()] {
                // Slower than the machine's own speed, never faster.
                for at in [6, 8] {
                    let own = i64::from(long(order[at], order[at + 1]));
                    order[at..at + 2].copy_from_slice(&words(own.min(rate)));
                }
            }
            self.order(stops, order)?;
            self.wanted[axis.index()] = None;
            let rest = self.wait(|_| false)?;
            if rest.missed >> axis.index() & 1 != 0 {
                return Err(LIMIT);
            }
            match rest.state {
                Some(RunState::Fault) => return Err(answer_of(rest.fault)),
                _ if self.stops.count() != stops => return Err(STOPPED),
                _ => {}
            }
        }
        Ok(())
    }

    /// Sets eight outputs.
    ///
    /// # Errors
    /// The answer for the client: the machine has fewer.
    pub fn outputs(&self, stops: u64, first: u16, value: u8) -> Result<(), Answer> {
        if i32::from(first) + 7 > self.profile.wiring.outputs() {
            return Err('1');
        }
        let count = self.stops.count.clone();
        let set = self.stops.ask(false, move |board| {
            if count.load(Ordering::SeqCst) != stops {
                return Err(ClientError::Interrupted);
            }
            (0..8).try_for_each(|bit| {
                board.set_coil(wire::COILS + first - 1 + bit, value >> bit & 1 != 0)
            })
        });
        set.map_err(|trouble| trouble.answer())
    }

    /// Eight inputs from the first on, or eight outputs.
    ///
    /// # Errors
    /// The board does not answer.
    pub fn port(&self, outputs: bool, first: u16) -> Result<u8, Answer> {
        let bits = self.stops.ask(false, move |board| match outputs {
            true => board.coils(wire::COILS + first, 8),
            false => board.inputs(wire::INPUT_BITS + first, 8),
        });
        let bits = bits.map_err(|trouble| trouble.answer())?;
        Ok(bits.iter().enumerate().fold(0, |all, (n, on)| all | u8::from(*on) << n))
    }

    /// What a program sends, and whether it takes a character: the last one sent with its count, and
    /// what it has not taken.
    ///
    /// # Errors
    /// The board does not answer.
    pub fn characters(&self) -> Result<[u16; 2], Answer> {
        let words = self.stops.ask(false, |board| board.holding(wire::CHAR_OUT, 2));
        words.map(|words| [words[0], words[1]]).map_err(|trouble| trouble.answer())
    }

    /// Gives the program a character.
    pub fn give(&self, character: u8) {
        // One that does not arrive is as one that was lost on the card's line.
        let _ = self.stops.ask(false, move |board| board.write(wire::CHAR_IN, character.into()));
    }

    /// Acknowledges a fault that a new program does away with: any but an emergency stop.
    ///
    /// # Errors
    /// The answer for the client.
    pub fn clear(&self, stops: u64, look: &Look) -> Result<(), Answer> {
        if look.fault == Some(Fault::EmergencyStop) {
            return Err(STOPPED);
        }
        self.control(stops, Control::Acknowledge)?;
        std::thread::sleep(LOOK);
        Ok(())
    }

    /// The answer for a board with a fault.
    pub fn answer_of_fault(look: &Look) -> Answer {
        answer_of(look.fault)
    }

    /// The answer for a run that has ended.
    pub fn answer_of_end(look: &Look) -> Result<(), Answer> {
        match (look.end, look.state) {
            (_, Some(RunState::Fault)) | (Some(End::Fault), _) => Err(answer_of(look.fault)),
            (Some(End::Done), _) => Ok(()),
            _ => Err(STOPPED),
        }
    }
}

/// What the card answers for a fault.
fn answer_of(fault: Option<Fault>) -> Answer {
    match fault {
        Some(
            Fault::SoftLimit | Fault::LimitSwitch | Fault::HomeNotFound | Fault::HomeStaysClosed,
        ) => LIMIT,
        Some(Fault::NotHomed) => NO_MACHINE,
        _ => STOPPED,
    }
}

/// Command 1111 to work positions: axes in a line, which end 2 s after the last look at the latest.
fn line(
    targets: &[(Axis, AxisProfile, i64)],
    from: [i32; 3],
    offset: [i64; 3],
    rate: i64,
) -> Vec<u16> {
    let um = |own: &AxisProfile, steps: i64| {
        steps as f64 * f64::from(own.scale.um) / f64::from(own.scale.steps)
    };
    let (mut path, mut steps) = (0.0, 0.0);
    for (axis, own, target) in targets {
        let way = target - i64::from(from[axis.index()]);
        path += um(own, way).powi(2);
        steps += (way as f64).powi(2);
    }
    // Steps/s along a path counted in steps become mm/min along the same path.
    let feed = rate as f64 * (path / steps).sqrt() * 60.0 / 1000.0;
    let mut order = vec![command::JOG, 0];
    let mut float = |value: f64| {
        let bits = (value as f32).to_bits();
        order.extend([bits as u16, (bits >> 16) as u16]);
    };
    float(feed);
    let mut mask = 0;
    for (axis, own, target) in targets {
        mask |= 1 << axis.index();
        float(um(own, target - offset[axis.index()]) / 1000.0);
    }
    order[1] = mask;
    order
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, PoisonError};
    use std::time::{Duration, Instant};

    use super::{Drive, line};
    use crate::client::Client;
    use crate::gateway::light::{self, Light, Mishap};
    use crate::gateway::{Config, Gateway};
    use crate::link::Link;
    use lang::axis::Axis;
    use lang::profile::Profile;
    use lang::wire::{COMMAND, Direct, command};

    #[test]
    fn an_order_whose_reply_is_lost_is_stopped_beyond_another_gateway_too() {
        for mishap in [Mishap::Lost, Mishap::Told] {
            let text =
                "[modbus]\nlisten = \"127.0.0.1:0\"\n[[board]]\nname = \"b\"\nport = \"p\"\n";
            let config = Config::parse("test", text).expect("a good file");
            let memory = light::boards(&[1]);
            memory.lock().unwrap_or_else(PoisonError::into_inner).mishaps = vec![(COMMAND, mishap)];
            let open = |_: &str, _: &[u8]| -> crate::gateway::Open {
                let memory = memory.clone();
                Box::new(move || {
                    let link: Box<dyn Link> = Box::new(Light::new(memory.clone()));
                    Ok(Client::new(link, 1))
                })
            };
            let gateway = Arc::new(Gateway::new(&config, Vec::new(), None, open).expect("good"));
            let charly = Profile::built_in("charly").expect("built in");
            let drive = Drive::new(&gateway, 0, 1, charly);
            assert!(drive.order(0, vec![command::MOVE_TO, 1]).is_err());
            let stop = [command::DIRECT, u16::from(Direct::Stop as u8)];
            let begun = Instant::now();
            loop {
                let memory = memory.lock().unwrap_or_else(PoisonError::into_inner);
                let word = |register: u16| memory.registers[&1].get(&register).copied();
                if [COMMAND, COMMAND + 1].map(word) == stop.map(Some) {
                    break;
                }
                drop(memory);
                assert!(begun.elapsed() < Duration::from_secs(10), "{mishap:?}: no stop came");
                std::thread::sleep(Duration::from_millis(10));
            }
        }
    }

    #[test]
    fn a_line_is_drawn_to_work_positions_at_the_speed_along_its_path() {
        let charly = Profile::built_in("charly").expect("built in");
        let own = |axis: Axis| charly.axis(axis).expect("it has it").clone();
        let targets = [(Axis::X, own(Axis::X), 400), (Axis::Y, own(Axis::Y), -300)];
        let order = line(&targets, [100, 100, 0], [100, 0, 0], 1000);
        let float =
            |at: usize| f32::from_bits(u32::from(order[at + 1]) << 16 | u32::from(order[at]));
        assert_eq!((order[0], order[1], order.len()), (command::JOG, 3, 8));
        // 100 steps are a millimetre.
        assert_eq!([float(2), float(4), float(6)], [600.0, 3.0, -3.0]);
    }
}
