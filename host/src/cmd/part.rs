//! `--part`: which chip's firmware.

use clap::Args;
use lang::back::Compiled;
use lang::image::Image;

use super::Console;
use super::script::Script;
use crate::board::{BUILDS, Build, DEFAULT};
use crate::failure::Failure;
use crate::render::Note;

/// The option of the commands that have to do with a board's chip.
#[derive(Clone, Copy, Debug, Args)]
pub struct Choice {
    /// The board's firmware: g2553 (16 KB of flash, 512 bytes of RAM), g2553-handlers (the same chip
    /// with ON ERROR and events) or virtual (everything). Without it the first of them that runs the
    /// program
    #[arg(long, value_name = "NAME", value_parser = named)]
    pub part: Option<&'static Build>,
}

/// The build that `--part` names.
pub fn named(name: &str) -> Result<&'static Build, String> {
    Build::named(name).ok_or_else(|| {
        let names: Vec<&str> = BUILDS.iter().map(|build| build.part.name).collect();
        format!("the parts are {}", names.join(", "))
    })
}

impl Choice {
    /// The part asked for, or the one of a board that nobody chose.
    pub fn or_default(self) -> &'static Build {
        self.part.unwrap_or(DEFAULT)
    }

    /// Whether the board that would run the script looks ahead: the part asked for, or the smallest
    /// one that runs it.
    ///
    /// # Errors
    /// The part asked for lacks something that the program wants; that was written.
    pub fn looks_ahead(self, script: &Script, console: &Console) -> Result<bool, Failure> {
        let parts = self.part.as_ref().map_or(&BUILDS[..], std::slice::from_ref);
        if parts.iter().all(|build| build.part.look_ahead) {
            return Ok(true);
        }
        // What is too large for any board has no part without look-ahead either.
        let Ok(compiled) = lang::back::compile(&script.program) else { return Ok(true) };
        Ok(self.for_program(script, &compiled, console)?.part.look_ahead)
    }

    /// The part asked for, or the smallest one that runs the program.
    ///
    /// # Errors
    /// The part asked for lacks something that the program wants; that was written.
    pub fn for_program(
        self,
        script: &Script,
        compiled: &Compiled,
        console: &Console,
    ) -> Result<&'static Build, Failure> {
        let Ok(image) = Image::new(&compiled.image) else { return Ok(self.or_default()) };
        let runs = |build: &&Build| build.part.lacks(&image.header, image.events()).is_none();
        let first = BUILDS.into_iter().find(runs);
        let Some(build) = self.part else { return Ok(first.unwrap_or(DEFAULT)) };
        let part = build.part;
        let Some(lack) = part.lacks(&image.header, image.events()) else { return Ok(build) };
        let text =
            format!("`{}` for the {} lacks what this program wants: {lack}", part.name, part.chip);
        let hint = match first {
            Some(other) => {
                format!("`--part {}` has it; or write the program without it", other.part.name)
            }
            None => "no part has it: write the program without it".to_owned(),
        };
        let note = Note::error(script.source.name(), "B008", text).hint(hint);
        Err(console.refuse(&note))
    }
}
