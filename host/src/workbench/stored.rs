//! Wishes about the stored program: to bring one to the board, and to run it.

use std::sync::Arc;

use lang::profile::Profile;
use lang::record::BoardRecord;
use lang::wire::{self, Control, RunState};
use serde_json::json;

use super::bench::lock;
use super::machine::{Ask, pace};
use super::message::{Shown, ToPage};
use super::programs::OnBoard;
use super::session::Answer;
use crate::client::ClientError;
use crate::client::identity::{differences, most_cells};
use crate::client::status::{holds, long};
use crate::helm::{Board, Debug};
use crate::trial::Loaded;

fn words(error: ClientError) -> String {
    error.to_string()
}

impl Ask<'_> {
    /// Starts, pauses or goes on. A start begins only the `program` that the page shows, if it says
    /// one, and only with the quantities in their ranges.
    pub fn run(&self, control: Control, program: Option<Shown>) -> Result<Answer, String> {
        let known = self.bench.on_board(&self.bench.helm.picture().1);
        self.ask(move |board| {
            let (state, _) = board.run_state().map_err(words)?;
            if (control, state) == (Control::Start, Some(RunState::Ready)) {
                may_begin(board, program, known.as_ref())?;
            }
            let control = match (control, state) {
                (Control::Start, Some(RunState::Empty)) => {
                    return Err("the board holds no program: press Upload".to_owned());
                }
                (Control::Start, Some(RunState::Fault)) => Control::Acknowledge,
                (Control::Resume, Some(state)) if state != RunState::Paused => {
                    return Err("nothing is paused".to_owned());
                }
                (Control::Pause, Some(RunState::Ready | RunState::Empty | RunState::Fault)) => {
                    return Err("no program runs".to_owned());
                }
                (control, _) => control,
            };
            match board.control(control) {
                Err(error) if error.is_exception(wire::Exception::Busy) => {
                    let status = board.status().map_err(words)?;
                    Err(match status.blocked_by {
                        Some(input) => {
                            format!("the board cannot do that now: {}", holds(input))
                        }
                        None => "the board cannot do that now: an axis moves".to_owned(),
                    })
                }
                other => other.map_err(words),
            }
        })
    }

    /// Compiles the text and brings it to the board.
    pub fn upload(&self) -> Result<Answer, String> {
        let name = lock(&self.bench.desk).name();
        self.bring(self.bench.compile()?, name)
    }

    /// Compiles another script of the folder and brings it to the board. The text on the desk stays.
    pub fn bring_file(&self, name: &str) -> Result<Answer, String> {
        let (text, folder) = {
            let desk = lock(&self.bench.desk);
            (desk.read(name)?, desk.folder())
        };
        self.bring(self.bench.load(&text, &folder)?, Some(name.to_owned()))
    }

    /// The answer is what the board holds then, as [`Shown`].
    fn bring(&self, loaded: Loaded, name: Option<String>) -> Result<Answer, String> {
        let (bench, client, ask) = (self.bench.clone(), self.client.clone(), self.ask);
        self.answer(move |board| {
            compare(board, &loaded.program.profile)?;
            let identity = board.identity().map_err(words)?;
            let loaded = Arc::new(loaded.for_part(identity.part()));
            let image = &loaded.compiled.image;
            let all = image.len().max(1) as f32;
            let file = name.as_deref().unwrap_or_default();
            let result = board.bring(image, (None, file), true, &mut |bytes| {
                client.send(&ToPage::Progress { ask, part: bytes as f32 / all });
            });
            result.map_err(|error| error.to_string())?;
            let shown = json!({ "bytes": image.len(), "crc": loaded.crc });
            bench.stored(loaded.clone(), name);
            bench.helm.refresh();
            Ok(Some(shown))
        })
    }

    /// Starts the program of the text and follows it.
    pub fn debug(&self, breaks: Vec<u32>, step: bool) -> Result<(), String> {
        let (_, picture) = self.bench.helm.picture();
        let known = self.bench.on_board(&picture).filter(|known| known.current);
        let loaded = known.ok_or("the board's program is not this text: upload it first")?.loaded;
        in_range(&loaded, |cell| Ok(picture.cells.get(usize::from(cell)).copied().unwrap_or(0)))?;
        let profile = Box::new(loaded.program.profile.clone());
        self.bench.helm.debug(Debug::Start {
            profile,
            line_of: Arc::new(move |pc| loaded.line_of(pc)),
            breaks: breaks.into_iter().collect(),
            pace: pace(step),
        });
        Ok(())
    }
}

/// Whether a run may begin: the board holds what the page shows, and every quantity is in its range.
fn may_begin(
    board: &mut Board,
    program: Option<Shown>,
    known: Option<&OnBoard>,
) -> Result<(), String> {
    let held = board.identity().map_err(words)?;
    let held = Shown { bytes: held.program_bytes, crc: held.program_crc };
    if program.is_some_and(|shown| shown != held) {
        return Err(
            "the board holds another program by now: look which one, and start again".to_owned()
        );
    }
    let Some(known) = known.filter(|known| known.loaded.is(held.bytes, held.crc)) else {
        return Ok(());
    };
    in_range(&known.loaded, |cell| {
        let pair = board.holding(wire::CELLS + 2 * cell, 2).map_err(words)?;
        Ok(long(pair[0], pair[1]))
    })
}

/// Whether the quantities that the script gives a range lie in it; `value` reads a cell.
fn in_range(
    loaded: &Loaded,
    mut value: impl FnMut(u16) -> Result<i32, String>,
) -> Result<(), String> {
    // What lies beyond the map of registers cannot be read by anybody.
    let readable = loaded.quantities().into_iter().filter(|(cell, ..)| *cell < most_cells());
    for (cell, label, limits) in readable {
        let value = value(cell)?;
        if !(limits.least..=limits.greatest).contains(&value) {
            return Err(format!(
                "{label} is {value}: set it between {} and {}",
                limits.least, limits.greatest
            ));
        }
    }
    Ok(())
}

/// A program for another machine would move this one wrongly.
pub(super) fn compare(board: &mut Board, profile: &Profile) -> Result<(), String> {
    let held = board.board_record().map_err(words)?;
    let mut differ = differences(&held, &BoardRecord::of(profile, held.sequence));
    // Where the board hangs on the line is no matter of the program.
    differ.retain(|what| *what != "link");
    if differ.is_empty() {
        return Ok(());
    }
    Err(format!(
        "the board's machine is not `{}`, it differs in {}: press Write machine to board, if this is \
         the machine that hangs on it",
        profile.name,
        differ.join(", ")
    ))
}
