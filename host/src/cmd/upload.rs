//! `pasapas upload`: brings a program to a board.

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use lang::profile::Profile;
use lang::record::BoardRecord;
use serde_json::json;

use super::port::{Board, Port};
use super::script::{self, Code};
use super::{Console, Options};
use crate::client::identity::differences;
use crate::client::lock::words_of;
use crate::client::upload::UploadError;
use crate::failure::Failure;

/// `pasapas upload`
#[derive(Debug, Args)]
pub struct Upload {
    /// A script, or an image that `build -o` wrote
    file: String,
    #[command(flatten)]
    port: Port,
    /// Give the stored program up first when both do not fit
    #[arg(long)]
    replace: bool,
    /// Upload although the board's profile is another one
    #[arg(long)]
    any_profile: bool,
    /// Lock program and profile behind the upload: only --unlock CODE replaces them or reads the
    /// profile
    #[arg(long, value_name = "CODE")]
    lock: Option<String>,
}

impl Upload {
    /// Compiles, compares, uploads.
    ///
    /// # Errors
    /// The script is wrong or too large; the board does not answer or refuses.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let Code { image, compiled, script } = script::load_code(&self.file, options, console)?;
        if let (Some(script), Some(compiled)) = (&script, &compiled) {
            script::must_fit(script, compiled, console)?;
        }
        let mut board = self.port.connect(options, console)?;
        if let Some(script) = &script
            && !self.any_profile
        {
            compare(&mut board, &script.program.profile)?;
        }
        let bar = bar(image.len(), console);
        let result =
            board.upload(&image, self.replace, &mut |bytes| bar.set_position(bytes as u64));
        bar.finish_and_clear();
        let result = result.and_then(|()| match &self.lock {
            Some(code) => Ok(board.set_lock(words_of(code))?),
            None => Ok(()),
        });
        match result {
            Ok(()) if console.json() => {
                console.json_line(&json!({ "uploaded": self.file, "bytes": image.len() }))
            }
            Ok(()) => console.result(&format!(
                "{}: {} bytes are on the board; Start or `pasapas start` runs them\n",
                self.file,
                image.len()
            )),
            Err(UploadError::Client(error)) => Err(error.into()),
            Err(error) => Err(Failure::Board(error.to_string())),
        }
    }
}

/// A program for another machine would move this one wrongly.
///
/// # Errors
/// The board's profile is another one; the text says in what.
pub fn compare(board: &mut Board, profile: &Profile) -> Result<(), Failure> {
    must_match(&board.board_record()?, profile)
}

/// [`compare`] with the record that a board holds.
///
/// # Errors
/// As those of [`compare`].
pub fn must_match(held: &BoardRecord, profile: &Profile) -> Result<(), Failure> {
    let mut differ = differences(held, &BoardRecord::of(profile, held.sequence));
    // Where the board hangs on the line is no matter of the program.
    differ.retain(|what| *what != "link");
    if differ.is_empty() {
        return Ok(());
    }
    Err(Failure::Board(format!(
        "the board's profile is not `{name}`, it differs in {}: `pasapas profile set {name}` \
         brings it (a file's name for a profile of your own); --any-profile goes on all the same",
        differ.join(", "),
        name = profile.name
    )))
}

/// Shown on a terminal only.
fn bar(bytes: usize, console: &Console) -> ProgressBar {
    if !console.shows_progress() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(bytes as u64);
    let style = ProgressStyle::with_template("upload {bar:40} {bytes}/{total_bytes} {eta}");
    if let Ok(style) = style {
        bar.set_style(style);
    }
    bar
}
