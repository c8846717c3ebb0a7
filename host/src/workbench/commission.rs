//! A page's wishes of a set-up: the profile in the making, and the board that it is tried on.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use lang::profile::{InputRole, Profile};
use lang::record::BoardRecord;
use serde_json::Value;

use super::bench::{Bench, lock};
use super::client::Client;
use super::machine::Ask;
use super::message::{SetupWish, ToPage};
use super::session::Answer;
use super::setup::{self, Setup};
use crate::client::ClientError;
use crate::client::identity::differences;
use crate::helm::Board;

/// Does a wish, or has it done.
///
/// # Errors
/// Why it is not done, in words.
pub fn serve(
    bench: &Arc<Bench>,
    client: &Arc<Client>,
    ask: u32,
    wish: SetupWish,
) -> Result<Answer, String> {
    let folder: PathBuf = lock(&bench.desk).folder();
    // What a trial goes by stays as it is, and nothing is written while the machine is not what it was.
    if bench.homing.load(Ordering::SeqCst) && !matches!(wish, SetupWish::Look) {
        return Err("a reference run or a trial goes on: wait, or halt it".to_owned());
    }
    match wish {
        SetupWish::Look => {}
        SetupWish::Open { name, base } => {
            let opened = Setup::open(&folder, &name, base.as_deref())?;
            *lock(&bench.setup) = Some(opened);
        }
        SetupWish::Close => *lock(&bench.setup) = None,
        SetupWish::Change(patch) => with(bench, |own| own.change(&patch))?,
        SetupWish::Scale { axis, asked_um, measured_um } => {
            with(bench, |own| own.scale(axis.0.letter(), asked_um, measured_um))?;
        }
        SetupWish::Done { step, words } if step != "stop" => {
            with(bench, |own| own.done(&step, &words))?
        }
        SetupWish::Done { .. } => stopped(bench)?,
        SetupWish::Apply => return apply(&Ask { bench, client, ask }),
        SetupWish::Trial(wish) => {
            with(bench, |_| Ok(()))?;
            let page = client.clone();
            setup::try_rate(bench, client, &wish, move |result| {
                page.send(&match result {
                    Ok(value) => ToPage::Answer { ask, value },
                    Err(words) => ToPage::Refused { ask, words },
                });
            })?;
            return Ok(Answer::Later);
        }
        SetupWish::Finish { when, untried_stop } => {
            return Ok(Answer::Value(with(bench, |own| own.finish(&when, untried_stop))?));
        }
    }
    Ok(Answer::Value(shown(bench, &folder)))
}

fn with<T>(bench: &Bench, job: impl FnOnce(&mut Setup) -> Result<T, String>) -> Result<T, String> {
    let mut setup = lock(&bench.setup);
    job(setup.as_mut().ok_or("no set-up is open: name the machine first")?)
}

fn shown(bench: &Bench, folder: &std::path::Path) -> Value {
    let mut value = match &*lock(&bench.setup) {
        Some(setup) => setup.shown(),
        None => setup::choices(folder),
    };
    // The chip of the board that answers: its picture is the one that helps.
    let picture = bench.helm.picture().1;
    value["chip"] = picture.identity.as_ref().map(|own| own.part().chip.name).into();
    value
}

/// The emergency stop was tried: the board itself must say so.
fn stopped(bench: &Bench) -> Result<(), String> {
    let (_, picture) = bench.helm.picture();
    let status = picture.status.as_ref().ok_or("there is no board")?;
    with(bench, |own| {
        let stops = own
            .profile()
            .inputs
            .iter()
            .filter(|input| input.role == Some(InputRole::EmergencyStop));
        let numbers: Vec<i32> = stops.map(|input| input.n).collect();
        if numbers.is_empty() {
            return Err("no input of this machine is an emergency stop: give one that role first"
                .to_owned());
        }
        let told = status.state == "fault" && status.fault.as_deref() == Some("F14");
        let input = status.input.filter(|n| numbers.contains(&i32::from(*n)));
        match input {
            Some(n) if told => {
                own.done("stop", &format!("input {n}, pressed: the board told F14 and every axis ceased"))
            }
            _ => Err("the board has told no emergency stop (F14): let an axis move, press it, and look at \
                      its wiring and polarity if nothing comes"
                .to_owned()),
        }
    })
}

/// Brings the machine to the board: axes in a program that does nothing, the rest in its record.
fn apply(later: &Ask<'_>) -> Result<Answer, String> {
    let bench = later.bench.clone();
    let (machine, profile) = with(&bench, |own| Ok((own.machine(), own.profile().clone())))?;
    let image = setup::stub(&machine)?;
    later.answer(move |board| {
        bring(board, &image, &profile)?;
        bench.setting.address.store(profile.link.address, Ordering::SeqCst);
        let value = with(&bench, |own| {
            own.applied(profile);
            Ok(own.shown())
        })?;
        Ok(Some(value))
    })
}

fn bring(board: &mut Board, image: &[u8], profile: &Profile) -> Result<(), String> {
    let words = |error: ClientError| error.to_string();
    board.bring(image, (None, "setup"), true, &mut |_| ()).map_err(|error| error.to_string())?;
    let held = board.board_record().map_err(words)?;
    let wanted =
        BoardRecord { lock: held.lock, ..BoardRecord::of(profile, held.sequence.wrapping_add(1)) }
            .sealed();
    if !differences(&held, &wanted).is_empty() {
        board.set_board_record(&wanted).map_err(words)?;
    }
    // The directions of the axes hold from a start on.
    board.restart().map_err(words)?;
    board.set_address(wanted.address);
    board.find().map_err(words)?;
    let left = differences(&board.board_record().map_err(words)?, &wanted);
    if left.is_empty() {
        return Ok(());
    }
    Err(format!("the board came back with another {}", left.join(", ")))
}
