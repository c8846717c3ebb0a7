//! `pasapas upload`: brings a program to a board.

use std::collections::BTreeSet;
use std::path::Path;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use lang::back::Compiled;
use lang::called;
use lang::image::{Image, crc_in};
use lang::profile::Profile;
use lang::record::BoardRecord;
use serde_json::json;

use super::console::{Console, Options};
use super::part;
use super::port::{Board, Port};
use super::script::{self, Code, Script};
use crate::client::ClientError;
use crate::client::identity;
use crate::client::library::Called;
use crate::client::lock::words_of;
use crate::client::upload::UploadError;
use crate::failure::Failure;
use crate::hall::known::{Program, lines, variables};

/// `pasapas upload`
#[derive(Debug, Args)]
pub struct Upload {
    /// A script, or an image that `build -o` wrote
    file: String,
    #[command(flatten)]
    port: Port,
    /// Name or number in the board's library; without it the file's name, whose program it replaces
    #[arg(long = "as", value_name = "NAME|N")]
    called: Option<Called>,
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
        let code = script::load_code(&self.file, options, console)?;
        if let (Some(script), Some(compiled)) = (&code.script, &code.compiled) {
            script::must_fit(script, compiled, console)?;
        }
        let mut board = self.port.connect(options, console)?;
        let identity = board.identity()?;
        identity.check().map_err(|why| Failure::Board(UploadError::Mismatch(why).to_string()))?;
        let own = code.for_board(identity.part(), console)?;
        let Code { image, compiled, script } = own.unwrap_or(code);
        if let Some(script) = &script
            && !self.any_profile
        {
            compare(&mut board, &script.program.profile)?;
        }
        if let Some(script) = &script {
            part::unlimited(script, identity.part(), console)?;
        }
        let bar = bar(image.len(), console);
        let place = (self.called.as_ref(), self.file.as_str());
        let result =
            board.bring(&image, place, self.replace, &mut |bytes| bar.set_position(bytes as u64));
        bar.finish_and_clear();
        let result = result.and_then(|place| match &self.lock {
            Some(code) => Ok(board.set_lock(words_of(code)).map(|()| place)?),
            None => Ok(place),
        });
        if let (Ok(_), Some(script), Some(compiled)) = (&result, &script, &compiled)
            && self.port.is_tcp()
        {
            leave(&mut board, compiled, script, console);
        }
        if result.is_ok() {
            missing(&mut board, &image, console)?;
        }
        match result {
            Ok(place) if console.json() => {
                let mut line = json!({ "uploaded": self.file, "bytes": image.len() });
                if let Some((number, name)) = place {
                    (line["number"], line["name"]) = (json!(number), json!(name));
                }
                console.json_line(&line)
            }
            Ok(place) => {
                let bytes = image.len();
                let place =
                    place.map_or_else(String::new, |(number, name)| format!(" as {number} {name}"));
                console.result(&format!(
                    "{}: {bytes} bytes are on the board{place}; Start or `pasapas start` runs them\n",
                    self.file
                ))
            }
            Err(UploadError::Client(error)) => Err(error.into()),
            Err(error) => Err(Failure::Board(error.to_string())),
        }
    }
}

/// Names what the image runs and the board does not hold.
fn missing(board: &mut Board, image: &[u8], console: &Console) -> Result<(), Failure> {
    let Ok(image) = Image::new(image) else { return Ok(()) };
    let names: BTreeSet<String> =
        called::runs(&image).map(|(_, name)| String::from_utf8_lossy(name).into_owned()).collect();
    if names.is_empty() {
        return Ok(());
    }
    let library = board.library()?.unwrap_or_default();
    for name in names {
        if library.find(&Called::Name(name.clone())).is_none() {
            console.complain(&format!(
                "the program runs \"{name}\", which the board does not hold ({}): there it ends with \
                 F21; `pasapas upload FILE --as \"{name}\"` brings it, and `start` then says which \
                 one begins",
                library.names()
            ));
        }
    }
    Ok(())
}

/// What a gateway may know of a program.
pub fn about(compiled: &Compiled, script: &Script) -> Program {
    let name = Path::new(script.source.name()).file_name().unwrap_or_default();
    Program {
        crc: crc_in(&compiled.image),
        script: name.to_string_lossy().into_owned(),
        profile: script.program.profile.name.clone(),
        variables: variables(&script.program),
        lines: lines(&compiled.sidecar),
    }
}

/// Leaves the names of a program's variables with the gateway, if the board is behind one.
pub fn leave(board: &mut Board, compiled: &Compiled, script: &Script, console: &Console) {
    let unit = board.address();
    match board.leave(unit, &about(compiled, script)) {
        // What answers may be a board, which has no such unit, function or file.
        Ok(()) | Err(ClientError::Exception(1 | 10 | 11)) => {}
        Err(ClientError::Silent | ClientError::Noise(_)) => {}
        Err(error) => {
            console.complain(&format!("the gateway does not keep the program's names: {error}"));
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
    identity::must_match(held, profile)
        .map_err(|why| Failure::Board(format!("{why}; --any-profile goes on all the same")))
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
