//! Writes the part's memory map where the linker finds it (`link.x` comes from `msp430-rt`), and what the assembly
//! takes from the tables of `firmware/micro` and of the opcodes.

use lang::isa;
use lang::part::chip::Chip;
use lang::part::{Part, SEGMENT};
use std::path::Path;

/// Address behind the program store: the chip's last segment belongs to the vectors and to the
/// firmware's `.tail`.
const STORE_END: usize = 0xFE00;

/// What the linker may use of a chip up to its vectors, which begin at `end`. TAIL is what is left of the last
/// segment below them and what stands in front of them: sections named .tail.* go there.
fn map(chip: &Chip, segments: u8, end: usize, more: &str, sections: &str) -> String {
    let ([ram, ram_size], rom) = (chip.ram, chip.flash[0] as usize);
    let store = STORE_END - SEGMENT * usize::from(segments);
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
fn small(chip: &Chip, segments: u8) -> String {
    let more = "  BSLKEY  : ORIGIN = 0xFFDE, LENGTH = 0x0002
  VECTORS : ORIGIN = 0xFFE0, LENGTH = 0x0020
";
    map(chip, segments, 0xFFDE, more, "  .bslkey : { KEEP(*(.bslkey)) } > BSLKEY\n")
}

/// An MSP430X: 64 vectors, and flash above 64 KB, where compiled functions go that `far` has made for
/// addresses from 10000 on.
fn large(chip: &Chip, segments: u8) -> String {
    let [first, bytes] = chip.flash;
    let end = first + bytes;
    let high = end.clamp(0x1_0000, 0x2_0000) - 0x1_0000;
    let more = end.max(0x2_0000) - 0x2_0000;
    let regions = format!(
        "  VECTORS : ORIGIN = 0xFF80, LENGTH = 0x0080
  HIGH    : ORIGIN = 0x10000, LENGTH = {high:#x}
  MORE    : ORIGIN = 0x20000, LENGTH = {more:#x}
"
    );
    let sections = "  .high : { *(.high.*) } > HIGH\n  .more : { *(.more.*) } > MORE\n";
    map(chip, segments, 0xFF80, &regions, sections)
}

/// The code of each effect: `OP_SET_OUT` of `Op::SetOut`.
fn effects() -> String {
    let rows = isa::ROWS.iter().filter(|row| row.class == isa::Class::Effect);
    let sets = rows.map(|row| {
        let name = format!("{:?}", row.op);
        let words =
            name.chars().flat_map(|c| c.is_uppercase().then_some('_').into_iter().chain([c]));
        format!(".set OP{}, {:#x}\n", words.collect::<String>().to_uppercase(), row.code)
    });
    sets.collect()
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
        // What of `firmware::WHOLE` the map wants.
        let chip = Chip { flash: [0x8000, 0x8000], ..*part.chip };
        small(&chip, 6)
    } else if has("F5529") {
        large(part.chip, part.segments)
    } else {
        small(part.chip, part.segments)
    };
    let out = std::env::var("OUT_DIR").unwrap_or_default();
    for (name, text) in [("memory.x", map), ("micro.s", micro::asm::notation() + &effects())] {
        if let Err(error) = std::fs::write(Path::new(&out).join(name), text) {
            println!("cargo:error=cannot write {name}: {error}");
        }
    }
    println!("cargo:rustc-link-search={out}");
}
