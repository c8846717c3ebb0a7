//! Writes what the rules become into `firmware/src/compact/made` and tells the bytes of each function.

use std::path::Path;
use std::process::ExitCode;

/// The files of rules.
const FILES: [&str; 1] = ["status"];

fn main() -> ExitCode {
    let firmware = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for name in FILES {
        if let Err(error) = make(&firmware, name) {
            eprintln!("firmware/src/rules/{name}.rs: {error}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

fn make(firmware: &Path, name: &str) -> Result<(), Box<dyn std::error::Error>> {
    let read = |path: &str| std::fs::read_to_string(firmware.join(path));
    let machine = read("src/rules.rs")?;
    let made = lower::lower(&machine, &read(&format!("src/rules/{name}.rs"))?, name)?;
    std::fs::write(firmware.join(format!("src/compact/made/{name}.s")), made.text)?;
    for (function, bytes) in &made.bytes {
        println!("{name}::{function}: {bytes} bytes");
    }
    println!("{name}: {} bytes", made.bytes.iter().map(|(_, bytes)| bytes).sum::<usize>());
    Ok(())
}
