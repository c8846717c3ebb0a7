//! Importing: a long G-code file, its time and its memory.

use std::time::Instant;

use import::Options;

use super::{Sink, at_most};

/// Lines of the file.
const LINES: u32 = 100_000;

/// Figures `import_100k`: a G-code file of 100 000 lines becomes a script; and `import_memory`: the
/// most that this process ever held, where the system tells.
///
/// # Errors
/// The file is refused.
pub fn run(sink: Sink<'_>) -> Result<(), String> {
    let mut text = String::from("G21 G90\nG1 F600 X0 Y0\n");
    for i in 0..LINES {
        text += &format!("G1 X{}.{:03} Y{}.25\n", i % 200, i % 1000, i / 7 % 150);
    }
    let begun = Instant::now();
    let made = import::import("long.nc", text.as_bytes(), &Options::default());
    let time = begun.elapsed().as_secs_f64();
    if let Err(diags) = made {
        return Err(diags.first().map_or_else(String::new, |diag| diag.render("long.nc")));
    }
    sink(at_most("import_100k", "s", time, 1.0, 0.3))?;
    match peak_megabytes() {
        Some(peak) => sink(at_most("import_memory", "MB", peak, 200.0, 100.0)),
        None => Ok(()),
    }
}

/// The largest resident set of this process so far (proc_pid_status(5), VmHWM), MB.
fn peak_megabytes() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: f64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kilobytes / 1024.0)
}
