//! Writes what the rules become into `firmware/g2553/generated` and tells the bytes of each function.

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    match make() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn make() -> Result<(), Box<dyn std::error::Error>> {
    let firmware = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let made = lower::of_firmware(&firmware)?;
    for made in &made {
        std::fs::write(firmware.join(format!("g2553/generated/{}.s", made.name)), &made.text)?;
        for (function, bytes) in &made.bytes {
            println!("{}::{function}: {bytes} bytes", made.name);
        }
        let sum = made.bytes.iter().map(|(_, bytes)| bytes).sum::<usize>();
        println!("{}: {sum} bytes", made.name);
    }
    Ok(())
}
