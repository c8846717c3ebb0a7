//! Writes the part's memory map where the linker finds it (`link.x` comes from `msp430-rt`), and what the assembly
//! takes from the tables of `firmware/micro`.

use lang::part::{F5529, G2553, G2553_HANDLERS, Part, SEGMENT};
use std::path::Path;

/// Address behind the program store: the chip's last segment belongs to the vectors and to the
/// firmware's `.tail`.
const STORE_END: usize = 0xFE00;

/// Start and length of RAM, start of flash (SLAS735, SLAS800: memory organization).
const SMALL: [usize; 3] = [0x0200, 0x0200, 0xC000];
/// For tests: the small part's RAM, 32 KB of flash and the large part's store.
const WHOLE: [usize; 3] = [0x0200, 0x0200, 0x8000];

/// The MSP430F5529's (SLAS590: memory organization): 2 KB of USB RAM, which is plain RAM while that module is
/// off, in front of the 8 KB.
const F5529_MEMORY: [usize; 3] = [0x1C00, 0x2800, 0x4400];

/// What the linker may use of a chip up to its vectors, which begin at `end`. TAIL is what is left of the last
/// segment below them and what stands in front of them: sections named .tail.* go there.
fn map(
    [ram, ram_size, rom]: [usize; 3],
    part: &Part,
    end: usize,
    more: &str,
    sections: &str,
) -> String {
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
fn small(memory: [usize; 3], part: &Part) -> String {
    let more = "  BSLKEY  : ORIGIN = 0xFFDE, LENGTH = 0x0002
  VECTORS : ORIGIN = 0xFFE0, LENGTH = 0x0020
";
    map(memory, part, 0xFFDE, more, "  .bslkey : { KEEP(*(.bslkey)) } > BSLKEY\n")
}

/// The MSP430F5529: 64 vectors, and flash above 64 KB, where compiled functions go that `far` has made for
/// addresses from 10000 to 1FFFF.
fn large() -> String {
    let more = "  VECTORS : ORIGIN = 0xFF80, LENGTH = 0x0080
  HIGH    : ORIGIN = 0x10000, LENGTH = 0x10000
";
    map(F5529_MEMORY, &F5529, 0xFF80, more, "  .high : { *(.high.*) } > HIGH\n")
}

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let has = |feature: &str| std::env::var_os(format!("CARGO_FEATURE_{feature}")).is_some();
    let map = if has("F5529") {
        large()
    } else if !has("G2553") {
        return;
    } else if has("WHOLE") {
        small(WHOLE, &F5529)
    } else if has("HANDLERS") {
        small(SMALL, &G2553_HANDLERS)
    } else {
        small(SMALL, &G2553)
    };
    let out = std::env::var("OUT_DIR").unwrap_or_default();
    for (name, text) in [("memory.x", map), ("micro.s", micro::asm::notation())] {
        if let Err(error) = std::fs::write(Path::new(&out).join(name), text) {
            println!("cargo:error=cannot write {name}: {error}");
        }
    }
    println!("cargo:rustc-link-search={out}");
}
