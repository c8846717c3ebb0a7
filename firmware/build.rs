//! Writes the part's memory map where the linker finds it; `link.x` comes from `msp430-rt`.

use lang::part::{G2553, G2553_HANDLERS, Part, SEGMENT, VIRTUAL};
use std::path::Path;

/// Address behind the program store: the chip's last segment belongs to the vectors and to the
/// firmware's `.tail`.
const STORE_END: usize = 0xFE00;

/// Start and length of RAM, start of flash (SLAS735, SLAS800: memory organization).
const SMALL: [usize; 3] = [0x0200, 0x0200, 0xC000];
const LARGE: [usize; 3] = [0x1100, 0x1000, 0x2100];
/// For tests: the small part's RAM, 32 KB of flash and the large part's store.
const WHOLE: [usize; 3] = [0x0200, 0x0200, 0x8000];

/// What the linker may use of a chip. TAIL is what is left of the last segment below the boot
/// loader's key word (FFDE, SLAU319 1.3) and the vectors: sections named .tail.* go there.
fn map([ram, ram_size, rom]: [usize; 3], part: &Part) -> String {
    let store = STORE_END - SEGMENT * usize::from(part.segments);
    format!(
        "MEMORY
{{
  RAM     : ORIGIN = {ram:#06x}, LENGTH = {ram_size:#06x}
  ROM     : ORIGIN = {rom:#06x}, LENGTH = {rom_size:#06x}
  TAIL    : ORIGIN = {STORE_END:#06x}, LENGTH = 0x01DE
  BSLKEY  : ORIGIN = 0xFFDE, LENGTH = 0x0002
  VECTORS : ORIGIN = 0xFFE0, LENGTH = 0x0020
}}

SECTIONS
{{
  .tail : {{ *(.tail .tail.*) }} > TAIL
  .noinit (NOLOAD) : {{ *(.noinit) }} > RAM
  .bslkey : {{ KEEP(*(.bslkey)) }} > BSLKEY
}}
",
        rom_size = store - rom
    )
}

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let has = |feature: &str| std::env::var_os(format!("CARGO_FEATURE_{feature}")).is_some();
    let map = if has("VIRTUAL") {
        map(LARGE, &VIRTUAL)
    } else if !has("G2553") {
        return;
    } else if has("WHOLE") {
        map(WHOLE, &VIRTUAL)
    } else if has("HANDLERS") {
        map(SMALL, &G2553_HANDLERS)
    } else {
        map(SMALL, &G2553)
    };
    let out = std::env::var("OUT_DIR").unwrap_or_default();
    if let Err(error) = std::fs::write(Path::new(&out).join("memory.x"), map) {
        println!("cargo:error=cannot write the memory map: {error}");
    }
    println!("cargo:rustc-link-search={out}");
}
