//! What the firmware image uses of flash and RAM, by module, and its ceilings.

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
            Some((symbol.address(), symbol.size(), name, kind, end))
        })
        .collect();
    symbols.sort();
    // Assembly has no sizes: each of its symbols reaches to the next one.
    let mut covered = 0;
    for (i, (address, size, name, kind, end)) in symbols.iter().enumerate() {
        let next = symbols.get(i + 1).map_or(*end, |next| next.0.min(*end));
        let reach = if *size > 0 { address + size } else { next };
        let from = (*address).max(covered);
        if reach > from {
            kind.add(reach - from, sizes.modules.entry(module(name)).or_default());
            covered = reach;
        }
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

/// The module of a symbol: crate and first module of a Rust path, `assembly` for plain names.
fn module(symbol: &str) -> String {
    let path = rust_path(symbol);
    match path.as_slice() {
        [] if symbol == "main" => "main loop, with what is inlined there".to_owned(),
        [] => "assembly".to_owned(),
        [own] | [own, _] => shorten(own),
        [own, module, ..] if module.starts_with(char::is_lowercase) => {
            format!("{}::{module}", shorten(own))
        }
        [own, ..] => shorten(own),
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
    use super::{budget, module, rust_path, sizes};
    use crate::board::{BUILDS, G2955};

    #[test]
    fn mangled_names_give_their_modules() {
        let limit = "_RNvMNtCsc9aW8vY704S_13pasapas_g25535motorNtB2_5Motor5limit";
        assert_eq!(rust_path(limit), ["pasapas_g2553", "motor", "Motor", "limit"]);
        assert_eq!(module(limit), "board::motor");
        let ramp = "_RNvMs0_NtNtCsi6qYChXgaJc_8firmware6motion4rampNtB5_3Run7segment";
        assert_eq!(module(ramp), "firmware::motion");
        assert_eq!(module("_RNvCsc9aW8vY704S_13pasapas_g25534CORE"), "board");
        assert_eq!(module("PASAPAS_STEP"), "assembly");
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
        let sizes = sizes(G2955.elf).expect("an ELF image");
        let covered: u64 = sizes.modules.values().map(|own| own.flash).sum();
        assert!(covered <= sizes.total.flash && covered * 10 >= sizes.total.flash * 9, "{covered}");
    }
}
