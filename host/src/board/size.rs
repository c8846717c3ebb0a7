//! Flash and RAM of the firmware image by module, and their ceilings.

use std::collections::BTreeMap;

use super::Build;
use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};
use serde::{Deserialize, Serialize};

/// The ceilings, as shipped with the sources.
const BUDGET: &str = include_str!("../../../firmware/budget.toml");

/// Ceilings of a shipped image (firmware/budget.toml).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Budget {
    /// Bytes of code, constants and vectors.
    pub flash: u64,
    /// Bytes of static RAM: what is left is stack.
    pub ram: u64,
    /// Bytes of stack at the deepest point that `pasapas torture stack` reaches, interrupts included.
    pub stack: u16,
    /// Cycles of the longest step interrupt of three axes, from its acceptance to the end of RETI.
    pub interrupt: u64,
}

/// What one module uses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Use {
    /// Bytes of flash.
    pub flash: u64,
    /// Bytes of static RAM.
    pub ram: u64,
}

/// What the image uses.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sizes {
    /// By module of the firmware.
    pub modules: BTreeMap<String, Use>,
    /// In all, from the sections: padding and tables without a symbol included.
    pub total: Use,
}

/// A build's ceilings.
///
/// # Errors
/// The file is no TOML of this form.
pub fn budget(build: &Build) -> Result<Budget, String> {
    let parts: BTreeMap<String, Budget> =
        toml::from_str(BUDGET).map_err(|error| format!("firmware/budget.toml: {error}"))?;
    let own = parts.get(build.part.name).copied();
    own.ok_or_else(|| format!("firmware/budget.toml does not name {}", build.part.name))
}

/// Takes an ELF image apart.
///
/// # Errors
/// The bytes are no ELF file.
pub fn sizes(elf: &[u8]) -> Result<Sizes, String> {
    let file = object::File::parse(elf).map_err(|error| error.to_string())?;
    let mut sizes = Sizes::default();
    let mut kinds = BTreeMap::new();
    for section in file.sections() {
        let kind = match section.kind() {
            SectionKind::Text | SectionKind::ReadOnlyData => Memory::Flash,
            SectionKind::UninitializedData => Memory::Ram,
            SectionKind::Data => Memory::Both,
            // The vectors and the boot loader's key word are linked as plain bytes.
            _ if section.address() != 0 && section.size() > 0 => Memory::Flash,
            _ => continue,
        };
        kind.add(section.size(), &mut sizes.total);
        kinds.insert(section.index().0, (kind, section.address() + section.size()));
    }
    let mut symbols: Vec<_> = file
        .symbols()
        .filter(|symbol| !matches!(symbol.kind(), SymbolKind::File | SymbolKind::Section))
        .filter_map(|symbol| {
            let section = symbol.section_index()?;
            let (kind, end) = *kinds.get(&section.0)?;
            let name = symbol.name().ok()?.to_owned();
            Some((symbol.address(), Named::of(name), symbol.size(), kind, end))
        })
        .collect();
    // Stable: of two marks in one place the first is that of a module that leaves no code here.
    symbols.sort_by_key(|(address, named, ..)| (*address, !matches!(named, Named::Mark(_))));
    // Assembly has no sizes: each of its symbols reaches to the next one.
    let mut covered = 0;
    let mut assembly = UNMARKED.to_owned();
    for (i, (address, named, size, kind, end)) in symbols.iter().enumerate() {
        let owner = match named {
            Named::Mark(module) => {
                assembly.clone_from(module);
                module
            }
            Named::Rust(module) => {
                UNMARKED.clone_into(&mut assembly);
                module
            }
            Named::Plain => &assembly,
        };
        let next = symbols.get(i + 1).map_or(*end, |next| next.0.min(*end));
        let reach = if *size > 0 { address + size } else { next };
        let from = (*address).max(covered);
        if reach > from {
            kind.add(reach - from, sizes.modules.entry(owner.clone()).or_default());
            covered = reach;
        }
    }
    for (module, bytes) in fixed_ram(&file) {
        sizes.modules.entry(module).or_default().ram += bytes;
        sizes.total.ram += bytes;
    }
    Ok(sizes)
}

/// Which memory a section takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Memory {
    Flash,
    Ram,
    /// Initialised data: kept in flash, used in RAM.
    Both,
}

impl Memory {
    fn add(self, bytes: u64, to: &mut Use) {
        if self != Memory::Ram {
            to.flash += bytes;
        }
        if self != Memory::Flash {
            to.ram += bytes;
        }
    }
}

/// The module of assembly that has no mark before it.
const UNMARKED: &str = "assembly";
/// Before the name of a module in the label at its first byte, in assembly; `$` and what follows
/// tell apart the sections of one module.
const MARK: &str = "module.";
/// The same in the name of the address where a module's variables begin, where RAM is laid out by
/// hand (firmware/g2553/ram.rs).
const RAM_MARK: &str = "ram.";
/// The end of RAM (msp430-rt's linker script).
const RAM_END: &str = "_stack_start";

/// RAM that is laid out by addresses instead of sections, by module.
fn fixed_ram(file: &object::File<'_>) -> Vec<(String, u64)> {
    let mut marks: Vec<(u64, Option<String>)> = file
        .symbols()
        .filter_map(|symbol| {
            let name = symbol.name().ok()?;
            let module = name.strip_prefix(RAM_MARK).map(path);
            (module.is_some() || name == RAM_END).then_some((symbol.address(), module))
        })
        .collect();
    marks.sort_by_key(|(address, _)| *address);
    let reaches = marks.windows(2).filter_map(|pair| match pair {
        [(from, Some(module)), (to, _)] => Some((module.clone(), to - from)),
        _ => None,
    });
    reaches.collect()
}

/// A marked module as Rust writes its path.
fn path(marked: &str) -> String {
    marked.split('$').next().unwrap_or_default().replace('.', "::")
}

/// What a symbol's name says of its module.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Named {
    /// The assembly from here on belongs to this one.
    Mark(String),
    /// Crate and first module of a Rust path; of the machine its room.
    Rust(String),
    /// Nothing: a name in assembly.
    Plain,
}

impl Named {
    fn of(symbol: String) -> Named {
        if let Some(marked) = symbol.strip_prefix(MARK) {
            return Named::Mark(path(marked));
        }
        let names = rust_path(&symbol);
        Named::Rust(match names.as_slice() {
            [] if symbol == "main" => "main loop, with what is inlined there".to_owned(),
            [] => return Named::Plain,
            // The machine's library is most of an image: it is told by its rooms.
            [_, "machine", room, ..] if room.starts_with(char::is_lowercase) => {
                format!("machine::{room}")
            }
            [own] | [own, _] => shorten(own),
            [own, module, ..] if module.starts_with(char::is_lowercase) => {
                format!("{}::{module}", shorten(own))
            }
            [own, ..] => shorten(own),
        })
    }
}

/// The image's crate is called `board` in its sources.
fn shorten(name: &str) -> String {
    if name.starts_with("pasapas_") { "board".to_owned() } else { name.to_owned() }
}

/// The identifiers of a mangled Rust path (RFC 2603, "v0"), the crate first; empty for names that
/// are none. Disambiguators and back references are skipped.
fn rust_path(symbol: &str) -> Vec<&str> {
    let Some(rest) = symbol.strip_prefix("_R") else { return Vec::new() };
    let bytes = rest.as_bytes();
    let mut names = Vec::new();
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        match byte {
            // A namespace's letter may be an `s` too, but follows its N at once.
            b'N' => at += 2,
            b's' | b'B' => {
                let end = rest[at..].find('_').map_or(bytes.len(), |end| at + end + 1);
                at = end;
            }
            b'0'..=b'9' => {
                let digits = rest[at..].bytes().take_while(u8::is_ascii_digit).count();
                let Ok(length) = rest[at..at + digits].parse::<usize>() else { break };
                let start = at + digits + usize::from(bytes.get(at + digits) == Some(&b'_'));
                let Some(name) = rest.get(start..start.saturating_add(length)) else { break };
                names.push(name);
                at = start + length.max(1);
            }
            _ => at += 1,
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::{Named, budget, rust_path, sizes};
    use crate::board::{BUILDS, G2553};

    fn rust(module: &str) -> Named {
        Named::Rust(module.to_owned())
    }

    #[test]
    fn mangled_names_give_their_modules() {
        let limit = "_RNvMNtCsc9aW8vY704S_13pasapas_g25535motorNtB2_5Motor5limit";
        assert_eq!(rust_path(limit), ["pasapas_g2553", "motor", "Motor", "limit"]);
        assert_eq!(Named::of(limit.to_owned()), rust("board::motor"));
        let ramp = "_RNvMs0_NtNtCsi6qYChXgaJc_8firmware6motion4rampNtB5_3Run7segment";
        assert_eq!(Named::of(ramp.to_owned()), rust("firmware::motion"));
        assert_eq!(Named::of("_RNvCsc9aW8vY704S_13pasapas_g25534CORE".to_owned()), rust("board"));
        assert_eq!(Named::of("PASAPAS_STEP".to_owned()), Named::Plain);
        let mark = Named::of("module.link.map$blocks".to_owned());
        assert_eq!(mark, Named::Mark("link::map".to_owned()));
        assert!(rust_path("_R99999999999999999999").is_empty());
    }

    #[test]
    fn the_shipped_image_keeps_its_ceilings() {
        for build in BUILDS {
            let name = build.part.name;
            let (budget, used) = (budget(build).expect("a budget"), sizes(build.elf).expect("ELF"));
            let used = used.total;
            assert!(used.flash <= budget.flash, "{name}: flash {} of {}", used.flash, budget.flash);
            assert!(used.ram <= budget.ram, "{name}: RAM {} of {}", used.ram, budget.ram);
        }
    }

    #[test]
    fn modules_cover_nearly_all_of_the_image() {
        for build in BUILDS {
            let sizes = sizes(build.elf).expect("an ELF image");
            let covered: u64 = sizes.modules.values().map(|own| own.flash).sum();
            let all = sizes.total.flash;
            assert!(covered <= all && covered * 10 >= all * 9, "{covered} of {all}");
            let largest = sizes.modules.values().map(|own| own.flash).max();
            assert!(largest.is_some_and(|most| most * 4 < all), "one module takes {largest:?}");
        }
    }

    #[test]
    fn ram_laid_out_by_hand_is_counted_to_its_end() {
        let sizes = sizes(G2553.elf).expect("an ELF image");
        assert_eq!(sizes.total.ram, 512);
        let pool = sizes.modules.get("pool").map(|own| own.ram);
        assert_eq!(pool, Some(G2553.part.pool_for(0).into()));
    }
}
