//! The micro-code of each image keeps to what `micro::verify` demands.

use emulator::Image;
use lang::part::{G2553, PARTS};
use micro::decode::Code;
use micro::image::entries;
use micro::verify::verify;

/// An image as `micro` reads it.
#[derive(Clone)]
pub struct Elf(Image);

impl Elf {
    /// A part's image.
    pub fn of(part: &str) -> Elf {
        let name = format!("{}/image/pasapas-{part}.elf", env!("CARGO_MANIFEST_DIR"));
        let bytes = std::fs::read(&name).unwrap_or_else(|error| panic!("{name}: {error}"));
        Elf(Image::parse(&bytes).expect("an ELF file"))
    }
}

impl Code for Elf {
    fn byte(&self, at: u16) -> u8 {
        self.0.byte(at).unwrap_or(0xFF)
    }
    fn symbol(&self, name: &str) -> Option<u16> {
        self.0.symbol(name).map(|at| at as u16)
    }
    fn places_end(&self, at: u16) -> Option<u16> {
        let ends = self.0.symbols.iter().filter(|(name, _)| name.starts_with("micro.places."));
        ends.map(|(_, end)| *end as u16).filter(|end| *end > at).min()
    }
}

#[test]
fn the_micro_code_of_every_image_is_sound() {
    let small = PARTS.iter().filter(|part| part.chip == G2553.chip).map(|part| part.name);
    for part in small.chain(["whole"]) {
        let elf = Elf::of(part);
        let entries = entries(&elf);
        let report = verify(&elf, &entries);
        let findings = report.findings.iter().map(|finding| format!("{finding}\n"));
        assert!(report.findings.is_empty(), "{part}:\n{}", findings.collect::<String>());
        assert!(report.operations > 1500, "{part} has only {} operations", report.operations);
        println!("{part}: {} operations, {} bytes", report.operations, report.bytes);
    }
}
