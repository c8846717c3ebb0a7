//! Times of uploads.

use lang::profile::Profile;

use super::stand::{Stand, image_for};
use super::{Sink, at_most};

/// A program of at most so many bytes, and hardly fewer.
fn program(mill: &Profile, most: usize) -> Result<Vec<u8>, String> {
    let line = |i: usize| format!("a = a + {}\n", 30_000 + 37 * (i % 2000));
    let image = |lines: usize| {
        let text: String = ["DIM a\n".to_owned()].into_iter().chain((0..lines).map(line)).collect();
        image_for(mill, &text).map(|(_, image)| image)
    };
    // The lines are alike.
    let (few, many) = (image(10)?.len(), image(110)?.len());
    let lines = 10 + (most - few) * 100 / (many - few);
    for lines in (0..lines).rev() {
        let image = image(lines)?;
        if image.len() <= most {
            return Ok(image);
        }
    }
    Err("no program is as short".to_owned())
}

/// Figures `upload_3k` and `upload_32k`: erase, transfer and check included, at 115200.
///
/// # Errors
/// The board does not take the program.
pub fn run(sink: Sink<'_>) -> Result<(), String> {
    let mill = Profile::built_in("mill").map_err(|error| error.to_string())?;
    for (name, bytes, must, aim) in
        [("upload_3k", 3072, 1.5, 0.8), ("upload_32k", 32_767, 6.0, 4.0)]
    {
        let image = program(&mill, bytes)?;
        let mut stand = Stand::new(&mill)?;
        let time = stand.upload(&image)?.as_secs_f64() * bytes as f64 / image.len() as f64;
        sink(at_most(name, "s", time, must, aim))?;
    }
    Ok(())
}
