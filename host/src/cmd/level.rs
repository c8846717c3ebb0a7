//! `pasapas level`: corrects a job of G-code by a map of heights, or makes the script that probes one.

use std::path::Path;

use clap::Args;
use serde_json::json;
use shop::level::{Corrected, Heights, Probe, correct, probe};

use super::console::{Console, Options};
use super::paste::note;
use crate::failure::Failure;
use crate::input;
use crate::output;

/// Longest job that is read, bytes.
const MAX_BYTES: usize = 64 << 20;
/// Heights that differ by more are worth a word, mm.
const UNEVEN: f64 = 5.0;

/// `pasapas level`
#[derive(Debug, Args)]
pub struct Level {
    /// The heights that the probing script printed, or a table of X, Y and Z
    #[arg(required_unless_present = "probe")]
    heights: Option<String>,
    /// The job, G-code
    #[arg(required_unless_present = "probe")]
    job: Option<String>,
    /// Lines are cut into pieces of at most so many mm; without it a quarter of the grid's pitch
    #[arg(long, value_name = "MM", value_parser = split)]
    split: Option<f64>,
    /// Make the script that probes a surface between two corners, mm: 0,0,100,80
    #[arg(long, value_name = "X,Y,X,Y", conflicts_with_all = ["heights", "job", "split"], allow_hyphen_values = true, value_parser = corners)]
    probe: Option<[f64; 4]>,
    /// With --probe: columns and rows
    #[arg(long, value_name = "NxN", default_value = "5x5", value_parser = grid)]
    grid: [u32; 2],
    /// With --probe: Z between the places, mm
    #[arg(long, value_name = "Z", default_value_t = 2.0, allow_hyphen_values = true, value_parser = mm)]
    lift: f64,
    /// With --probe: Z down to which is probed, mm
    #[arg(long, value_name = "Z", default_value_t = -2.0, allow_hyphen_values = true, value_parser = mm)]
    deepest: f64,
    /// The corrected job, or the script; without it standard output
    #[arg(short, long, value_name = "OUT")]
    output: Option<String>,
}

fn mm(text: &str) -> Result<f64, String> {
    let value = text.trim().trim_end_matches("mm").parse::<f64>().ok();
    value.filter(|mm| mm.abs() <= 10_000.0).ok_or_else(|| format!("`{text}` is no length in mm"))
}

fn split(text: &str) -> Result<f64, String> {
    mm(text).ok().filter(|mm| *mm >= 0.1).ok_or_else(|| "a piece is 0.1 mm or longer".to_owned())
}

fn corners(text: &str) -> Result<[f64; 4], String> {
    let all: Result<Vec<f64>, String> = text.split(',').map(mm).collect();
    all?.try_into().map_err(|_| "write two corners, X,Y,X,Y in mm: 0,0,100,80".to_owned())
}

fn grid(text: &str) -> Result<[u32; 2], String> {
    let pair = text.split_once('x').and_then(|(a, b)| Some([a.parse().ok()?, b.parse().ok()?]));
    pair.ok_or_else(|| "write columns and rows, such as 5x4".to_owned())
}

impl Level {
    /// Corrects the job, or makes the script.
    ///
    /// # Errors
    /// A file is wrong, or the heights do not cover the job; that was written.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let Self { heights, job, .. } = self;
        let inputs = [heights, job].map(|file| file.as_ref().map(Path::new));
        output::keep_inputs(&[("-o", self.output.as_ref())], &inputs)?;
        if let Some([left, low, right, high]) = self.probe {
            let profile = options.machine(console)?;
            let wish = Probe {
                low: [left, low],
                high: [right, high],
                count: self.grid,
                lift: self.lift,
                deepest: self.deepest,
            };
            let text = probe(&wish, &profile).map_err(Failure::Usage)?;
            return self.write(&text, console);
        }
        // clap has seen to it that both are there.
        let (Some(heights), Some(job)) = (heights, job) else { return Ok(()) };
        let text = read(job, console)?;
        let (corrected, map) = levelled(heights, job, &text, self.split, console)?;
        self.write(&corrected.text, console)?;
        let [low, high] = map.range();
        let [columns, rows] = map.size();
        let [before, after] = corrected.moves;
        if console.json() {
            return match &self.output {
                Some(_) => console.json_line(&json!({
                    "moves": before, "pieces": after, "lowest_mm": low, "highest_mm": high,
                })),
                None => Ok(()),
            };
        }
        console.complain(&format!(
            "{before} moves became {after}; {columns} x {rows} heights from {low:.3} to {high:.3} mm"
        ));
        Ok(())
    }

    fn write(&self, text: &str, console: &Console) -> Result<(), Failure> {
        match &self.output {
            Some(path) => output::write(path, text.as_bytes()),
            None => console.result(text),
        }
    }
}

/// Reads a text of any encoding.
fn read(file: &str, console: &Console) -> Result<String, Failure> {
    let bytes = input::read_bytes(file, MAX_BYTES).map_err(|note| console.refuse(&note))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// A job on the heights of a file.
///
/// # Errors
/// One of both is wrong; that was written.
pub fn levelled(
    heights: &str,
    job: &str,
    text: &str,
    split: Option<f64>,
    console: &Console,
) -> Result<(Corrected, Heights), Failure> {
    let read = read(heights, console)?;
    let map =
        Heights::parse(&read).map_err(|wrong| console.refuse(&note(heights, "X037", &wrong)))?;
    let [low, high] = map.range();
    if high - low > UNEVEN {
        console.complain(&format!("{heights}: the heights differ by {:.1} mm", high - low));
    }
    let split = split.unwrap_or_else(|| (map.pitch() / 4.0).max(0.1));
    match correct(text, &map, split) {
        Ok(corrected) => Ok((corrected, map)),
        Err(wrong) => {
            wrong.iter().try_for_each(|wrong| console.note(&note(job, "X038", wrong)))?;
            Err(Failure::Input)
        }
    }
}
