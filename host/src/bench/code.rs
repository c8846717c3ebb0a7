//! Bytes: programs and firmware.

use lang::back::{self, Compiled};
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::hir::Program;

use super::{Sink, at_most};
use crate::board;
use crate::board::size::sizes;

/// The scripts that the mean is taken over: those of the sources that this tool was built from.
/// Folder of the examples.
pub(super) const EXAMPLES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples");

/// Twenty holes from a table: what a hole costs beside the table is the loop's share.
const HOLES: &str = "DIM i\n\
    TABLE holes(2) = 0mm,0mm; 2mm,1mm; 4mm,3mm; 6mm,2mm; 8mm,8mm; 1mm,9mm; 2mm,7mm; 3mm,4mm; \
    5mm,5mm; 6mm,7mm; 7mm,1mm; 9mm,2mm; 4mm,8mm; 3mm,6mm; 8mm,3mm; 1mm,1mm; 2mm,2mm; 3mm,3mm; \
    4mm,4mm; 5mm,6mm\n\
    G99 G81 R1 Z-2 F300 X[holes(0, 0)] Y[holes(0, 1)]\n\
    FOR i = 1 TO COUNT(holes) - 1\n\
    X[holes(i, 0)] Y[holes(i, 1)]\n\
    NEXT\n";

/// Compiles a script of ours.
pub fn program(name: &str, text: &str) -> Result<(Program, Compiled), String> {
    let source = Source::new(name, text.to_owned());
    let (program, diags) = compile(&source, ProfileChoice::built_in());
    let program = program.ok_or_else(|| diags.render(&source))?;
    let compiled = back::compile(&program).map_err(|excesses| format!("{name}: {excesses:?}"))?;
    Ok((program, compiled))
}

/// Figures `bytes_per_statement`, `bytes_per_hole`, `firmware_flash`.
///
/// # Errors
/// An example does not compile.
pub fn run(sink: Sink<'_>) -> Result<(), String> {
    let (mut bytes, mut statements) = (0, 0);
    let wrong = |error: std::io::Error| format!("{EXAMPLES}: {error}");
    for entry in std::fs::read_dir(EXAMPLES).map_err(wrong)? {
        let path = entry.map_err(wrong)?.path();
        if path.extension().is_some_and(|extension| extension == "bas") {
            let text = std::fs::read_to_string(&path).map_err(wrong)?;
            let (_, compiled) = program(&path.display().to_string(), &text)?;
            bytes += compiled.code_bytes;
            statements += compiled.statements;
        }
    }
    let mean = bytes as f64 / f64::from(statements.max(1));
    sink(at_most("bytes_per_statement", "bytes", mean, 4.0, 3.2))?;
    let (_, holes) = program("holes", HOLES)?;
    let (_, fewer) = program("fewer", &HOLES.replace("; 5mm,6mm", ""))?;
    let hole = (holes.image.len() - fewer.image.len()) as f64;
    sink(at_most("bytes_per_hole", "bytes", hole, 4.0, 4.0))?;
    let image = sizes(board::G2553.elf)?;
    sink(at_most("firmware_flash", "bytes", image.total.flash as f64, 13_824.0, 12_288.0))
}
