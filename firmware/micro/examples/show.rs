//! Takes the micro-code of an image apart: `cargo run -p micro --example show firmware/image/pasapas-g2553.elf [NAME]`.

use emulator::Image;
use micro::decode::Code;
use micro::image::{By, entries};
use micro::show::listing;

struct Elf(Image);

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

fn main() {
    let mut words = std::env::args().skip(1);
    let Some(file) = words.next() else {
        eprintln!("Which image? show FILE [NAME]");
        std::process::exit(2);
    };
    let wanted = words.next();
    let bytes = std::fs::read(&file).unwrap_or_else(|error| {
        eprintln!("cannot read {file}: {error}");
        std::process::exit(1);
    });
    let image = Image::parse(&bytes).unwrap_or_else(|error| {
        eprintln!("{file}: {error}");
        std::process::exit(1);
    });
    let elf = Elf(image);
    let name = |at: u16| {
        let names = elf.0.symbols.iter().filter(|(_, place)| **place == u32::from(at));
        let mut names = names.map(|(name, _)| name.clone()).filter(|name| !name.contains('.'));
        names.find(|name| !name.starts_with("DO_"))
    };
    for entry in entries(&elf) {
        let named = match entry.by {
            By::Row(row) => row.name.to_owned(),
            _ => name(entry.at).unwrap_or_else(|| format!("{:04x}", entry.at)),
        };
        if wanted.as_ref().is_none_or(|wanted| *wanted == named) {
            println!("\n{named}\n{}", listing(&elf, &entry, &name));
        }
    }
}
