//! `pasapas disasm`: the instructions of a script or of an image.

use clap::Args;
use lang::back::disasm::listing;
use lang::image::{Image, crc_in, crc_of};
use serde_json::json;

use super::console::{Console, Options};
use super::script::{self, Code};
use crate::failure::Failure;
use crate::input::code;
use crate::render::Note;

/// `pasapas disasm`
#[derive(Debug, Args)]
pub struct Disasm {
    /// A script or an image that `build -o` wrote
    file: String,
}

impl Disasm {
    /// Prints the listing.
    ///
    /// # Errors
    /// The script is wrong or the image is none.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let file = &self.file;
        let Code { image, compiled, .. } = script::load_code(file, options, console)?;
        let parsed = Image::new(&image).map_err(|flaw| {
            let text = format!("the image cannot be taken apart: {flaw:?}");
            console.refuse(&Note::error(file, code::IMAGE, text))
        })?;
        let header = parsed.header;
        if console.json() {
            for insn in lang::back::disasm::instructions(&parsed) {
                console
                    .json_line(&json!({ "pc": insn.pc, "bytes": insn.bytes, "text": insn.text }))?;
            }
            return Ok(());
        }
        let crc = if crc_in(&image) == crc_of(&image) { "right" } else { "WRONG" };
        console.result(&format!(
            "image of {} bytes, CRC {crc}: code {}, data {}, {} cells, stack {}, calls {}, \
             {} KEEP values, features {:#04x}\n",
            header.len,
            header.code_len,
            parsed.data.len(),
            header.cells,
            header.stack,
            header.calls,
            header.keeps,
            header.features,
        ))?;
        let sidecar = compiled.as_ref().map(|compiled| &compiled.sidecar);
        console.result(&listing(&parsed, sidecar))
    }
}
