//! Cycles of the VM on the chip.

use std::time::Duration;

use lang::back::disasm::instructions;
use lang::image::Image;
use lang::profile::Profile;

use super::stand::{Stand, gate, image_for};
use super::{Sink, at_most};
use crate::board::{Build, F5529, G2553};

/// Passes of a measured loop: the gate's jitter of 1 ms is then less than a cycle each.
const PASSES: u32 = 30_000;

/// Figures `for_loop` and `simple_op` of the G2553, and `_f5529` of the F5529.
///
/// # Errors
/// The board does not run the loops.
pub fn run(sink: Sink<'_>) -> Result<(), String> {
    let mill = Profile::built_in("mill").map_err(|error| error.to_string())?;
    let (one, mean) = of(&G2553, &mill)?;
    sink(at_most("for_loop", "cycles", one, 160.0, 100.0))?;
    sink(at_most("simple_op", "cycles", mean, 30.0, 20.0))?;
    let (one, mean) = of(&F5529, &mill)?;
    sink(at_most("for_loop_f5529", "cycles", one, 120.0, 100.0))?;
    sink(at_most("simple_op_f5529", "cycles", mean, 24.0, 20.0))
}

/// Cycles of a loop's pass with one sum in it, and of an instruction at mean.
fn of(build: &Build, mill: &Profile) -> Result<(f64, f64), String> {
    let mut stand = Stand::on(build, mill)?;
    let one = cycles(&mut stand, mill, "a = b + i")?;
    let body = "a = b + i: b = a - i: a = a AND b: b = a OR i: a = b XOR i";
    let many = cycles(&mut stand, mill, body)?;
    let operations = many.instructions - one.instructions;
    Ok((one.cycles, (many.cycles - one.cycles) / operations as f64))
}

/// One pass of a loop.
struct Pass {
    cycles: f64,
    instructions: usize,
}

fn cycles(stand: &mut Stand, mill: &Profile, body: &str) -> Result<Pass, String> {
    let text = format!(
        "DIM i, a, b\nb = 7\nSetOut 1, ON\nWait 2ms\nFOR i = 1 TO {PASSES}\n{body}\nNEXT\n\
         SetOut 1, OFF\n"
    );
    let empty = text.replace(&PASSES.to_string(), "1");
    let (_, image) = image_for(mill, &text)?;
    let parsed = Image::new(&image).map_err(|flaw| format!("{flaw:?}"))?;
    let instructions = instructions(&parsed).len();
    stand.upload(&image)?;
    let whole = gate(&stand.run(Duration::from_secs(30))?)?;
    let (_, image) = image_for(mill, &empty)?;
    stand.upload(&image)?;
    let frame = gate(&stand.run(Duration::from_secs(30))?)?;
    let cycles = whole.saturating_sub(frame) as f64 / f64::from(PASSES - 1);
    Ok(Pass { cycles, instructions })
}
