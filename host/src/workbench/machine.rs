//! Requests that reach the board: each goes to the port's owner, and its answer to the page.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use lang::axis::Axis;
use lang::profile::AxisProfile;
use lang::record::BoardRecord;
use lang::wire::{self, Control, command};
use serde_json::{Value, json};

use super::bench::Bench;
use super::client::Client;
use super::library;
use super::message::{HoldWish, MoveWish, ToPage, Wish};
use super::session::Answer;
use super::streamed::Middle;
use crate::board::live::Touch;
use crate::client::orders;
use crate::client::status::long;
use crate::helm::{Board, Debug, Hold, Pace, SLOWEST};
use crate::sim::world::Button;

/// Longest move by a button, um: a mistyped digit must not cross the machine.
const LONGEST_MOVE_UM: u32 = 1_000_000;
/// A reference run that takes longer has failed.
const HOME_TIME: Duration = Duration::from_secs(300);

/// Does a wish, or has it done.
///
/// # Errors
/// Why it is not done, in words.
pub fn serve(
    bench: &Arc<Bench>,
    client: &Arc<Client>,
    ask: u32,
    wish: Wish,
) -> Result<Answer, String> {
    let later = Ask { bench, client, ask };
    match wish {
        Wish::Upload => return later.upload(),
        Wish::Stream => return later.stream(None),
        Wish::StreamFrom { line, way: None } => return later.way(line),
        Wish::StreamFrom { line, way: Some(way) } => {
            return later.stream(Some(Middle { line, way }));
        }
        Wish::Bring(name) => return later.bring_file(&name),
        Wish::Library => return later.answer(library::list),
        Wish::Choose(number) => {
            bench.helm.refresh();
            return later.answer(move |board| library::select(board, number));
        }
        Wish::Erase(number) => {
            bench.helm.refresh();
            return later.answer(move |board| library::erase(board, number));
        }
        Wish::Profile => return later.profile(),
        Wish::Start if bench.control_streamed(Control::Start) => {}
        Wish::Pause if bench.control_streamed(Control::Pause) => {}
        Wish::Resume if bench.control_streamed(Control::Resume) => {}
        Wish::Start => return later.run(Control::Start, None),
        Wish::Run(program) => return later.run(Control::Start, Some(program)),
        Wish::Pause => return later.run(Control::Pause, None),
        Wish::Resume => return later.run(Control::Resume, None),
        Wish::Debug { breaks, step } => later.debug(breaks, step)?,
        Wish::Go { step } => bench.helm.debug(Debug::Pace(pace(step))),
        Wish::Breaks(breaks) => {
            bench.helm.debug(Debug::Breaks(breaks.into_iter().collect::<BTreeSet<u32>>()));
        }
        Wish::Override([feed, rapid]) => {
            if !(10..=200).contains(&feed) || !(10..=100).contains(&rapid) {
                return Err("an override lies in 10..200 %, of rapid moves in 10..100 %".to_owned());
            }
            if bench.setting.is_operators() && feed > 100 {
                return Err(
                    "this page makes the work slower, not faster than it is written".to_owned()
                );
            }
            return later.write(wire::OVERRIDES, vec![feed, rapid]);
        }
        Wish::Set { cell, value } => {
            let cells = bench.helm.picture().1.cells.len();
            if usize::from(cell) >= cells {
                return Err("the stored program has no such variable".to_owned());
            }
            let operator = bench.setting.is_operators();
            match bench.on_board(&bench.helm.picture().1) {
                Some(known) => known.loaded.may_set(cell, value, operator)?,
                None if operator => return Err("the stored program is not known here".to_owned()),
                None => {}
            }
            let value = value.cast_unsigned();
            let words = vec![value as u16, (value >> 16) as u16];
            return later.write(wire::CELLS + 2 * cell, words);
        }
        Wish::Hold(wish) => later.hold(&wish)?,
        Wish::Release(id) => bench.helm.release(client.user, id),
        Wish::Jog(wish) => return later.travel(wish, true),
        Wish::GoTo(wish) => return later.travel(wish, false),
        Wish::Zero(axis) => {
            let mut order = vec![command::SET_POSITION, axis.0.index() as u16 + 1];
            order.extend(orders::words(0));
            return later.order(order);
        }
        Wish::Place => return later.place(),
        Wish::Home(axes) => return later.home(axes.into_iter().map(|axis| axis.0).collect()),
        Wish::Probe(wish) => return later.probe(&wish),
        Wish::Output(n, on) => {
            let coil = n.checked_sub(1).filter(|coil| *coil < 16);
            let coil = coil.ok_or("outputs count from 1 to 16")?;
            return later.ask(move |board| {
                board.set_coil(wire::COILS + coil, on).map_err(|error| error.to_string())
            });
        }
        Wish::Input(n, on) if bench.setting.live.is_some() => {
            bench.touch_input(n, on.unwrap_or(false))?;
        }
        Wish::Input(n, on) => {
            let number = n.checked_sub(1).filter(|n| *n < 16).ok_or("inputs count from 1 to 16")?;
            let level = on.map_or(0xFFFF, u16::from);
            return later.order(vec![command::FORCE_INPUT, number, level]);
        }
        Wish::Press { stop, down } => {
            let live = bench.setting.live.as_ref().ok_or("a real board has its own buttons")?;
            live.touch(Touch::Button(if stop { Button::Stop } else { Button::Start }, down));
        }
        _ => return Err("this wish is not one of the machine's".to_owned()),
    }
    Ok(Answer::Done)
}

pub(super) const fn pace(step: bool) -> Pace {
    if step { Pace::Step } else { Pace::Go }
}

/// A wish whose answer comes later.
pub(super) struct Ask<'a> {
    /// What the pages share.
    pub bench: &'a Arc<Bench>,
    /// Who asks.
    pub client: &'a Arc<Client>,
    /// Number of the wish.
    pub ask: u32,
}

impl Ask<'_> {
    /// Has the helm do something; what comes of it is the answer.
    pub(super) fn ask(
        &self,
        job: impl FnOnce(&mut Board) -> Result<(), String> + Send + 'static,
    ) -> Result<Answer, String> {
        self.answer(move |board| job(board).map(|()| None))
    }

    /// The same with a value.
    pub(super) fn answer(
        &self,
        job: impl FnOnce(&mut Board) -> Result<Option<Value>, String> + Send + 'static,
    ) -> Result<Answer, String> {
        let (client, ask) = (self.client.clone(), self.ask);
        let done = move |result: Result<Option<Value>, String>| {
            client.send(&match result {
                Ok(Some(value)) => ToPage::Answer { ask, value },
                Ok(None) => ToPage::Done { ask, words: None },
                Err(words) => ToPage::Refused { ask, words },
            });
        };
        let asked = self.bench.helm.ask(self.client.user, move |board| {
            done(board.map_err(str::to_owned).and_then(job));
        });
        asked.map(|()| Answer::Later).map_err(|_| "too much waits for the board already".to_owned())
    }

    /// Asks the board where it stands: a picture is made of several looks, of which one may be older
    /// than the axes' rest.
    fn place(&self) -> Result<Answer, String> {
        self.answer(|board| {
            let words = |error: crate::client::ClientError| error.to_string();
            if board.input(wire::MOVING, 1).map_err(words)?[0] & 0xFF != 0 {
                return Err("an axis moves: wait until it rests".to_owned());
            }
            let own = board.holding(wire::MACHINE_POSITIONS, 6).map_err(words)?;
            let at = |n: usize| long(own[2 * n], own[2 * n + 1]);
            Ok(Some(json!({ "X": at(0), "Y": at(1), "Z": at(2) })))
        })
    }

    fn order(&self, order: Vec<u16>) -> Result<Answer, String> {
        self.ask(move |board| board.order(&order, refused))
    }

    fn write(&self, first: u16, words: Vec<u16>) -> Result<Answer, String> {
        self.ask(move |board| board.write_all(first, &words).map_err(|error| error.to_string()))
    }

    /// Gives the board the script's machine, and restarts it.
    fn profile(&self) -> Result<Answer, String> {
        let profile = self.bench.profile()?;
        if self.bench.setting.live.is_some() {
            return Err(
                "the virtual board is built as one machine: end the workbench and start it \
                with --profile"
                    .to_owned(),
            );
        }
        self.ask(move |board| {
            let words = |error: crate::client::ClientError| error.to_string();
            let held = board.board_record().map_err(words)?;
            let wanted = BoardRecord::of(&profile, held.sequence.wrapping_add(1));
            board.set_board_record(&wanted).map_err(words)?;
            board.restart().map_err(words)?;
            board.find().map_err(words)
        })
    }

    fn hold(&self, wish: &HoldWish) -> Result<(), String> {
        let profile = self.bench.profile()?;
        let own = orders::present(&profile, wish.axis.0)?;
        let rate = speed(own, wish.speed);
        if rate < SLOWEST {
            let least = own.scale.length(SLOWEST as i32).unwrap_or(i32::MAX);
            return Err(format!(
                "{} is too slow to be held: a step instead, or a speed of {:.3} mm/s or more",
                wish.axis.0.letter(),
                f64::from(least) / 1000.0
            ));
        }
        let travel = [own.min_um, own.max_um].map(|um| orders::steps(own, um.into()));
        let [up, down] = orders::ramps(own);
        let hold = Hold::new(
            (self.client.user, wish.id),
            wish.axis.0,
            wish.positive,
            (rate, up.min(down)),
            (travel[0], travel[1]),
        )
        .bounded(wish.to.map(i64::from));
        self.bench.helm.hold(hold).map_err(|_| "another jog is not over yet".to_owned())
    }

    /// Moves an axis by a distance, or to a work position.
    fn travel(&self, wish: MoveWish, relative: bool) -> Result<Answer, String> {
        bounded(wish.um)?;
        let profile = self.bench.profile()?;
        let axis = wish.axis();
        let own = orders::present(&profile, axis)?.clone();
        let steps = orders::steps(&own, wish.um.into());
        self.ask(move |board| {
            let (machine, work) = places(board, axis)?;
            let target = if relative { work + steps } else { steps };
            within(board, axis, &own, machine, machine + target - work)?;
            let rate = speed(&own, wish.speed);
            board.order(&orders::move_to(axis, orders::ramps(&own), rate, target), refused)
        })
    }

    fn probe(&self, wish: &MoveWish) -> Result<Answer, String> {
        bounded(wish.um)?;
        let profile = self.bench.profile()?;
        let axis = wish.axis();
        let own = orders::present(&profile, axis)?.clone();
        let steps = orders::steps(&own, wish.um.into());
        let order = orders::probe(&profile, axis, speed(&own, wish.speed), steps)?;
        self.ask(move |board| {
            let (machine, _) = places(board, axis)?;
            within(board, axis, &own, machine, machine + steps)?;
            board.order(&order, refused)
        })
    }

    /// Reference runs one after the other, each begun when the one before has ended well.
    fn home(&self, axes: Vec<Axis>) -> Result<Answer, String> {
        let profile = self.bench.profile()?;
        let axes = if axes.is_empty() {
            profile.home_order.iter().map(|name| Axis::from(*name)).collect()
        } else {
            axes
        };
        let runs: Result<Vec<_>, String> =
            axes.iter().map(|axis| Ok((*axis, orders::home(&profile, *axis)?))).collect();
        let runs = runs?;
        if self.bench.homing.swap(true, Ordering::SeqCst) {
            return Err("a reference run goes on already".to_owned());
        }
        let (bench, client, ask) = (self.bench.clone(), self.client.clone(), self.ask);
        std::thread::spawn(move || {
            let result =
                runs.iter().try_for_each(|(axis, order)| home(&bench, &client, *axis, order));
            bench.homing.store(false, Ordering::SeqCst);
            client.send(&match result {
                Ok(()) => ToPage::Done { ask, words: None },
                Err(words) => ToPage::Refused { ask, words },
            });
        });
        Ok(Answer::Later)
    }
}

/// Refuses a length in um that a button may not ask for. The smallest number has no positive
/// counterpart: `abs` would leave it negative, and within every bound.
fn bounded(um: i32) -> Result<(), String> {
    if um.unsigned_abs() > LONGEST_MOVE_UM {
        return Err("a move by a button is no longer than 1 m".to_owned());
    }
    Ok(())
}

/// Steps per second of a speed in um/s, within the axis's.
fn speed(axis: &AxisProfile, um_s: u32) -> u32 {
    let rate = orders::steps(axis, um_s.into()).clamp(1, axis.top_rate.into());
    u32::try_from(rate).unwrap_or(1)
}

/// What the board takes for out of range.
pub(super) fn refused() -> String {
    "the board refuses this: a rate, a place or an input is out of its range".to_owned()
}

/// Machine and work position of an axis, steps.
pub(super) fn places(board: &mut Board, axis: Axis) -> Result<(i64, i64), String> {
    let words = |error: crate::client::ClientError| error.to_string();
    let first = 2 * axis.index() as u16;
    let machine = board.holding(wire::MACHINE_POSITIONS + first, 2).map_err(words)?;
    let work = board.input(wire::WORK_POSITIONS + first, 2).map_err(words)?;
    let value = |words: &[u16]| i64::from(long(words[0], words[1]));
    Ok((value(&machine), value(&work)))
}

/// Refuses to send a homed axis beyond its travel, or further beyond it; a board without a program
/// does not know the travel.
fn within(
    board: &mut Board,
    axis: Axis,
    own: &AxisProfile,
    at: i64,
    target: i64,
) -> Result<(), String> {
    let homed = board.holding(wire::HOMED, 1).map_err(|error| error.to_string())?[0];
    let [low, high] = [own.min_um, own.max_um].map(|um| orders::steps(own, um.into()));
    if homed >> axis.index() & 1 == 0 || (low.min(at)..=high.max(at)).contains(&target) {
        return Ok(());
    }
    Err(format!(
        "{} would leave its travel: the machine goes from {} to {} mm",
        axis.letter(),
        f64::from(own.min_um) / 1000.0,
        f64::from(own.max_um) / 1000.0
    ))
}

/// Between two looks at a reference run.
const HOME_LOOK: Duration = Duration::from_millis(50);

/// What the registers say of an axis's reference run.
#[derive(Clone, Copy)]
struct Homing {
    under_way: bool,
    failed: bool,
    homed: bool,
}

/// One reference run from its order to its end.
pub(super) fn home(
    bench: &Arc<Bench>,
    client: &Arc<Client>,
    axis: Axis,
    order: &[u16],
) -> Result<(), String> {
    let own = order.to_vec();
    ask_for(bench, client, move |board| board.order(&own, refused))?;
    let begun = Instant::now();
    let letter = axis.letter();
    while begun.elapsed() < HOME_TIME {
        // A command is taken within some ms: a look at once would see the axis still at rest.
        std::thread::sleep(HOME_LOOK);
        if !bench.has_helm(client) {
            bench.helm.stop();
            return Err("the page gave up the helm: the reference run is stopped".to_owned());
        }
        let seen = ask_for(bench, client, move |board| {
            let words = |error: crate::client::ClientError| error.to_string();
            let motion = board.input(wire::MOVING, 2).map_err(words)?;
            let homed = board.holding(wire::HOMED, 1).map_err(words)?[0];
            let bit = |word: u16| word >> axis.index() & 1 != 0;
            Ok(Homing {
                under_way: bit(motion[0] | motion[1]),
                failed: bit(motion[1] >> 8),
                homed: bit(homed),
            })
        })?;
        if seen.under_way {
            continue;
        }
        if seen.failed {
            return Err(format!(
                "{letter} did not find its switch, or it stayed closed: check the switch, its wiring, \
                 and direction and stroke in the profile"
            ));
        }
        return if seen.homed {
            Ok(())
        } else {
            Err(format!("{letter} was stopped before it was homed"))
        };
    }
    bench.helm.stop();
    Err(format!("{letter} did not end its reference run; everything is stopped"))
}

/// Has the helm do something and waits for what comes of it.
pub(super) fn ask_for<T: Send + 'static>(
    bench: &Arc<Bench>,
    client: &Arc<Client>,
    job: impl FnOnce(&mut Board) -> Result<T, String> + Send + 'static,
) -> Result<T, String> {
    let (to, told) = std::sync::mpsc::channel();
    let asked = bench.helm.ask(client.user, move |board| {
        // Nobody waits any more where the page's wish was given up.
        let _ = to.send(board.map_err(str::to_owned).and_then(job));
    });
    asked.map_err(|_| "too much waits for the board already".to_owned())?;
    told.recv().map_err(|_| "the page is gone".to_owned())?
}

#[cfg(test)]
mod tests {
    use super::bounded;

    #[test]
    fn a_move_by_a_button_is_at_most_a_metre_either_way() {
        for um in [0, 1, -1, 1_000_000, -1_000_000] {
            assert!(bounded(um).is_ok(), "{um}");
        }
        for um in [1_000_001, -1_000_001, i32::MAX, i32::MIN, i32::MIN + 1] {
            assert!(bounded(um).is_err(), "{um}");
        }
    }
}
