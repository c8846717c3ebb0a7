//! A rate and a ramp tried on the machine: to and fro, and then a look at where the reference switch
//! closes. Steps that were lost stand between the two looks.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use lang::axis::Axis;
use lang::front::ProfileChoice;
use lang::profile::{AxisProfile, Profile};
use lang::wire::{self, Control, RunState};
use serde::Deserialize;
use serde_json::{Value, json};

use super::super::bench::{Bench, lock};
use super::super::client::Client;
use super::super::machine::{ask_for, home as home_run, places, refused};
use super::{checked, steps};
use crate::client::ClientError;
use crate::client::orders;
use crate::helm::Board;
use crate::sim::trace::AxisLetter;
use crate::trial;

/// Between two looks at a moving axis.
const LOOK: Duration = Duration::from_millis(40);
/// Time that a move may take beyond that of its way.
const PATIENCE: Duration = Duration::from_secs(20);
/// Least room between the switch and the runs, um.
const APART: i64 = 2000;
/// How far behind its place the switch is looked for, um; less than what set-up opens the travel by.
const BEYOND: i64 = 4000;
/// Steps and um that a switch itself may differ by.
const TOLERANCE: (i64, i64) = (2, 20);
/// A program that does nothing, so that the board has the machine's axes.
const STUB: &str = "Wait 1ms\n";

/// What is tried.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialWish {
    axis: AxisLetter,
    /// Steps/s.
    rate: i32,
    /// Steps/s2.
    accel: i32,
    /// How far away from the switch it runs, um.
    way_um: i32,
    /// How often to and fro.
    times: u32,
}

/// A program that does nothing for a machine.
///
/// # Errors
/// The machine's profile is wrong.
pub fn stub(profile: &Profile) -> Result<Vec<u8>, String> {
    let choice = ProfileChoice::Given(Box::new(profile.clone()));
    Ok(trial::load(STUB, choice)?.compiled.image)
}

/// The axis with another rate and ramp.
fn quick(profile: &Profile, axis: Axis, rate: i32, accel: i32) -> Result<Profile, String> {
    let mut quick = profile.clone();
    let own = steps::part(&mut quick, axis).ok_or("the machine has no such axis")?;
    (own.top_rate, own.accel, own.decel) = (rate, accel, None);
    own.start_rate = own.start_rate.min(rate);
    own.home.fast_rate = own.home.fast_rate.min(rate);
    own.home.slow_rate = own.home.slow_rate.min(own.home.fast_rate);
    checked(quick)
}

/// Runs a trial in a thread of its own; what comes of it goes to `told`.
///
/// # Errors
/// The wish is out of range, or another one is under way.
pub fn run(
    bench: &Arc<Bench>,
    client: &Arc<Client>,
    wish: &TrialWish,
    told: impl FnOnce(Result<Value, String>) + Send + 'static,
) -> Result<(), String> {
    let machine = bench.profile()?;
    let axis = wish.axis.0;
    let own = orders::present(&machine, axis)?.clone();
    if !(1000..=2_000_000).contains(&wish.way_um) || !(1..=20).contains(&wish.times) {
        return Err("a trial goes 1 to 2000 mm, 1 to 20 times".to_owned());
    }
    let fast = quick(&machine, axis, wish.rate, wish.accel)?;
    let order = orders::home(&machine, axis)?;
    let runs = Runs {
        bench: bench.clone(),
        client: client.clone(),
        axis,
        open: orders::steps(&own, own.home.position_um.into()),
        away: -i64::from(own.home.direction.sign()),
        apart: orders::steps(&own, APART.max(own.home.clearance_um.into())),
        own,
    };
    let (way_um, times, rates) = (wish.way_um, wish.times, (wish.rate, wish.accel));
    if bench.homing.swap(true, Ordering::SeqCst) {
        return Err("a reference run or a trial goes on already".to_owned());
    }
    let words = format!("{} is being tried at {} steps/s", axis.letter(), wish.rate);
    *lock(&bench.trial) = Some(words);
    std::thread::spawn(move || {
        let (bench, client) = (runs.bench.clone(), runs.client.clone());
        let result = runs
            .bring(&fast)
            .and_then(|()| runs.judge(&order, i64::from(way_um), times, rates))
            .and_then(|found| {
                // Whatever came of it, the machine is again what the profile says.
                runs.bring(&machine)?;
                home_run(&bench, &client, axis, &order)?;
                Ok(found)
            });
        if result.is_err() {
            // Whoever stopped it, or left, or whatever went wrong: nothing moves on.
            bench.helm.stop();
            let _ = runs.bring(&machine);
        }
        *lock(&bench.trial) = None;
        bench.homing.store(false, Ordering::SeqCst);
        told(result);
    });
    Ok(())
}

/// How a move ended.
enum Ended {
    There,
    /// The reference switch stopped it here, steps.
    Switch(i64),
}

struct Runs {
    bench: Arc<Bench>,
    client: Arc<Client>,
    axis: Axis,
    own: AxisProfile,
    /// Where the switch opens, steps.
    open: i64,
    /// Sign of the way away from the switch.
    away: i64,
    /// From there to the nearest end of the runs, steps.
    apart: i64,
}

impl Runs {
    fn ask<T: Send + 'static>(
        &self,
        job: impl FnOnce(&mut Board) -> Result<T, String> + Send + 'static,
    ) -> Result<T, String> {
        if !self.bench.has_helm(&self.client) {
            return Err("the page gave up the helm: the trial ends".to_owned());
        }
        ask_for(&self.bench, &self.client, job)
    }

    /// Gives the board the axes of a machine.
    fn bring(&self, machine: &Profile) -> Result<(), String> {
        let image = stub(machine)?;
        self.ask(move |board| {
            board
                .bring(&image, (None, "setup"), true, &mut |_| ())
                .map_err(|error| error.to_string())?;
            Ok(())
        })
    }

    fn judge(
        &self,
        order: &[u16],
        way: i64,
        times: u32,
        rates: (i32, i32),
    ) -> Result<Value, String> {
        home_run(&self.bench, &self.client, self.axis, order)?;
        let way = orders::steps(&self.own, way);
        let lost = "the switch does not close where it opened: look at it";
        let before = self.edge(order)?.ok_or(lost)?;
        let near = self.open + self.away * self.apart;
        let mut met = false;
        let mut after = None;
        'runs: for _ in 0..times {
            for target in [near + self.away * way, near] {
                if let Ended::Switch(at) = self.go(target, rates.0, rates.1)? {
                    (met, after) = (true, Some(at));
                    break 'runs;
                }
            }
        }
        if !met {
            after = self.edge(order)?;
        }
        let step_um = f64::from(self.own.scale.um) / f64::from(self.own.scale.steps);
        let lost = after.map(|after| (after - before).abs());
        let most = TOLERANCE.0.max((TOLERANCE.1 as f64 / step_um) as i64);
        // Who meets the switch on the runs has lost steps, whatever the count says.
        let good = !met && lost.is_some_and(|lost| lost <= most);
        let words = match lost {
            Some(lost) if good => {
                format!("no step lost: the switch closes {lost} steps from where it did")
            }
            Some(lost) if !met => {
                format!("{lost} steps lost: {:.3} mm", lost as f64 * step_um / 1000.0)
            }
            Some(_) => "steps lost: it met the switch on its way back".to_owned(),
            None => "steps lost: the switch is no longer where it was".to_owned(),
        };
        Ok(json!({ "good": good, "lost": lost, "words": words }))
    }

    /// Where the switch closes, slowly from outside, steps; `None` where it does not. A reference run
    /// leads off it again.
    fn edge(&self, order: &[u16]) -> Result<Option<i64>, String> {
        let near = self.open + self.away * self.apart;
        let home = &self.own.home;
        if let Ended::Switch(at) = self.go(near, home.fast_rate, self.own.accel)? {
            return Ok(Some(at));
        }
        let behind = self.open - self.away * orders::steps(&self.own, BEYOND);
        let found = match self.go(behind, home.slow_rate, self.own.accel)? {
            Ended::Switch(at) => Some(at),
            Ended::There => None,
        };
        home_run(&self.bench, &self.client, self.axis, order)?;
        Ok(found)
    }

    /// A move to a machine position, until the axis rests.
    fn go(&self, target: i64, rate: i32, accel: i32) -> Result<Ended, String> {
        let axis = self.axis;
        let way = self.ask(move |board| {
            let (machine, work) = places(board, axis)?;
            let ramps = [accel.unsigned_abs(); 2];
            let order = orders::move_to(axis, ramps, rate.unsigned_abs(), target - machine + work);
            board.order(&order, refused)?;
            Ok((target - machine).abs())
        })?;
        let (way, rate, accel) = (way as f64, f64::from(rate.max(1)), f64::from(accel.max(1)));
        let most = PATIENCE + Duration::from_secs_f64(2.0 * (way / rate + rate / accel));
        let begun = Instant::now();
        while begun.elapsed() < most {
            std::thread::sleep(LOOK);
            let words = |error: ClientError| error.to_string();
            let found = self.ask(move |board| {
                if board.input(wire::MOVING, 1).map_err(words)?[0] & 0xFF != 0 {
                    return Ok(None);
                }
                let status = board.status().map_err(words)?;
                let (machine, _) = places(board, axis)?;
                if status.run_state == Some(RunState::Fault) {
                    board.control(Control::Acknowledge).map_err(words)?;
                }
                Ok(Some((
                    machine,
                    status.run_state == Some(RunState::Fault),
                    status.fault,
                    status.text,
                )))
            })?;
            match found {
                None => {}
                Some((at, true, Some(fault), _)) if fault == "F06" => return Ok(Ended::Switch(at)),
                Some((_, true, fault, text)) => {
                    return Err(format!(
                        "{} {}",
                        fault.unwrap_or_default(),
                        text.unwrap_or_default()
                    ));
                }
                Some((at, false, ..)) if at == target => return Ok(Ended::There),
                Some(_) => return Err("it was stopped".to_owned()),
            }
        }
        self.bench.helm.stop();
        Err("the axis did not come to rest; everything is stopped".to_owned())
    }
}
