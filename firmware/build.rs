//! Writes the part's memory map where the linker finds it (`link.x` comes from `msp430-rt`), and what the assembly
//! takes from the tables of `firmware/micro`.

use lang::part::{Part, SEGMENT};
use std::path::Path;

/// Address behind the program store: the chip's last segment belongs to the vectors and to the
/// firmware's `.tail`.
const STORE_END: usize = 0xFE00;

/// What the linker may use of a chip up to its vectors, which begin at `end`. TAIL is what is left of the last
/// segment below them and what stands in front of them: sections named .tail.* go there.
fn map(part: &Part, end: usize, more: &str, sections: &str) -> String {
    let [ram, ram_size, rom] = part.memory.map(usize::from);
    let store = STORE_END - SEGMENT * usize::from(part.segments);
    format!(
        "MEMORY
{{
  RAM     : ORIGIN = {ram:#06x}, LENGTH = {ram_size:#06x}
  ROM     : ORIGIN = {rom:#06x}, LENGTH = {rom_size:#06x}
  TAIL    : ORIGIN = {STORE_END:#06x}, LENGTH = {tail:#06x}
{more}}}

SECTIONS
{{
  .tail : {{ *(.tail .tail.*) }} > TAIL
  .noinit (NOLOAD) : {{ *(.noinit) }} > RAM
{sections}}}
",
        rom_size = store - rom,
        tail = end - STORE_END,
    )
}

/// A chip with the boot loader's key word (FFDE, SLAU319 1.3) in front of 16 vectors.
fn small(part: &Part) -> String {
    let more = "  BSLKEY  : ORIGIN = 0xFFDE, LENGTH = 0x0002
  VECTORS : ORIGIN = 0xFFE0, LENGTH = 0x0020
";
    map(part, 0xFFDE, more, "  .bslkey : { KEEP(*(.bslkey)) } > BSLKEY\n")
}

/// The MSP430F5529: 64 vectors, and flash above 64 KB, where compiled functions go that `far` has made for
/// addresses from 10000 to 1FFFF.
fn large(part: &Part) -> String {
    let more = "  VECTORS : ORIGIN = 0xFF80, LENGTH = 0x0080
  HIGH    : ORIGIN = 0x10000, LENGTH = 0x10000
";
    map(part, 0xFF80, more, "  .high : { *(.high.*) } > HIGH\n")
}

/// What of `firmware::WHOLE` the map wants.
fn whole(part: Part) -> Part {
    Part { memory: [part.memory[0], part.memory[1], 0x8000], segments: 6, ..part }
}

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed=PASAPAS_PART");
    let has = |feature: &str| std::env::var_os(format!("CARGO_FEATURE_{feature}")).is_some();
    if !has("F5529") && !has("G2553") {
        return;
    }
    let usual = if has("F5529") { "f5529" } else { "g2553" };
    let name = std::env::var("PASAPAS_PART").unwrap_or_else(|_| usual.into());
    let Some(part) = Part::named(&name) else {
        println!("cargo:error=lang::part knows no {name}");
        return;
    };
    println!("cargo:rustc-env=PASAPAS_PART={name}");
    let map = if has("WHOLE") {
        small(&whole(part))
    } else if has("F5529") {
        large(&part)
    } else {
        small(&part)
    };
    let out = std::env::var("OUT_DIR").unwrap_or_default();
    for (name, text) in [("memory.x", map), ("micro.s", micro::asm::notation())] {
        if let Err(error) = std::fs::write(Path::new(&out).join(name), text) {
            println!("cargo:error=cannot write {name}: {error}");
        }
    }
    println!("cargo:rustc-link-search={out}");
}
