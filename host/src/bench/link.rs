//! Time of an upload.

use lang::profile::Profile;

use super::stand::{Stand, image_for};
use super::{Sink, at_most};
use crate::board::DEFAULT;

/// Bytes that the figure is for.
const BYTES: f64 = 3072.0;

/// Figure `upload_3k`: erase, transfer and check included, at 115200.
///
/// # Errors
/// The board does not take the program.
pub fn run(sink: Sink<'_>) -> Result<(), String> {
    let mill = Profile::built_in("mill").map_err(|error| error.to_string())?;
    let mut text = String::from("DIM a\n");
    let mut image = Vec::new();
    for i in 0..2000 {
        text += &format!("a = a + {}\n", 30_000 + 37 * i);
        if i % 50 == 49 {
            let (_, longer) = image_for(&mill, &text)?;
            if longer.len() > DEFAULT.part.room_for(false) {
                break;
            }
            image = longer;
        }
    }
    let mut stand = Stand::new(&mill)?;
    let time = stand.upload(&image)?.as_secs_f64() * BYTES / image.len() as f64;
    sink(at_most("upload_3k", "s", time, 1.5, 0.8))
}
