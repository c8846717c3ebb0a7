//! A picture in lines: each row is burnt at one speed, with a run-up before and after it.

use super::dither::{Dither, LEVELS};
use super::picture::Picture;
use super::{Job, Laser, Step};
use crate::Wrong;

/// Pixels of what is burnt.
const MOST: f64 = 20e6;

/// How a picture is burnt. Lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wish {
    /// Width of the picture.
    pub size: f64,
    /// Lines, and pixels of a line, of a mm.
    pub lines: f64,
    /// How greys are shown.
    pub dither: Dither,
    /// Lower left corner; without it as near to the machine's as the run-up allows.
    pub at: Option<[f64; 2]>,
    /// Run-up; without it what the ramp needs.
    pub overscan: Option<f64>,
    /// mm/s.
    pub speed: f64,
    /// S of black.
    pub power: u32,
    /// Every line begins at the left.
    pub one_way: bool,
    /// By how much lines to the left are moved in X, for a belt's play.
    pub offset: f64,
}

impl Wish {
    /// The run-up: half a millimetre more than the ramp.
    pub fn run_up(&self, laser: &Laser) -> f64 {
        self.overscan.unwrap_or_else(|| (laser.ramp * self.speed * self.speed + 0.5).ceil())
    }
}

/// Makes the lines.
///
/// # Errors
/// The picture does not fit the machine, or has too many lines.
pub fn raster(picture: &Picture, wish: &Wish, laser: &Laser) -> Result<Job, Wrong> {
    let pitch = 1.0 / wish.lines;
    let height = wish.size * picture.height as f64 / picture.width as f64;
    let [columns, rows] = [wish.size, height].map(|mm| (mm * wish.lines).round().max(1.0));
    if columns * rows > MOST {
        let words = format!("{columns} x {rows} dots are to be burnt; at most {MOST} are");
        return Err(Wrong::whole(words, "fewer --lines, or a smaller --size"));
    }
    let run_up = wish.run_up(laser);
    let play = wish.offset.abs();
    let at = wish.at.unwrap_or([laser.travel[0][0] + run_up + play, laser.travel[0][1]]);
    let low = [at[0] - run_up - play, at[1]];
    let high = [at[0] + columns * pitch + run_up + play, at[1] + rows * pitch];
    laser.holds(low, high)?;
    let (columns, rows) = (columns as usize, rows as usize);
    let levels = picture.scaled(columns, rows).levels(wish.dither);
    let mut job = Job::default();
    let mut back = false;
    for (n, row) in levels.chunks_exact(columns).rev().enumerate() {
        let runs = runs(row);
        let (Some(first), Some(last)) = (runs.first(), runs.last()) else { continue };
        // The middle of its line.
        let y = at[1] + (n as f64 + 0.5) * pitch;
        let ends = [first.0, last.1];
        let shift = if back { wish.offset } else { 0.0 };
        let x = |column: usize| at[0] + column as f64 * pitch + shift;
        let mut go = |x: f64, power: Option<u32>| job.steps.push(Step { to: [x, y], power });
        let power = |level: u8| Some((wish.power * u32::from(level) + LEVELS / 2) / LEVELS);
        if back {
            go(x(ends[1]) + run_up, None);
            let mut at = ends[1];
            go(x(at), Some(0));
            for (from, to, level) in runs.iter().rev() {
                if *to < at {
                    go(x(*to), Some(0));
                }
                go(x(*from), power(*level));
                at = *from;
            }
            go(x(ends[0]) - run_up, Some(0));
        } else {
            go(x(ends[0]) - run_up, None);
            let mut at = ends[0];
            go(x(at), Some(0));
            for (from, to, level) in &runs {
                if *from > at {
                    go(x(*from), Some(0));
                }
                go(x(*to), power(*level));
                at = *to;
            }
            go(x(ends[1]) + run_up, Some(0));
        }
        back = !back && !wish.one_way;
    }
    if job.steps.is_empty() {
        let words = "nothing of the picture is dark enough to be burnt";
        return Err(Wrong::whole(
            words,
            "--dither floyd-steinberg shows greys; a white picture has none",
        ));
    }
    job.head.push(format!(
        "{columns} x {rows} dots of {} mm, run-up {} mm",
        crate::text::plain(pitch),
        crate::text::plain(run_up)
    ));
    Ok(job)
}

/// Runs of one level that is burnt: first column, the one behind it, level.
fn runs(row: &[u8]) -> Vec<(usize, usize, u8)> {
    let mut out: Vec<(usize, usize, u8)> = Vec::new();
    for (n, level) in row.iter().enumerate().filter(|(_, level)| **level > 0) {
        match out.last_mut() {
            Some((_, to, own)) if *to == n && own == level => *to = n + 1,
            _ => out.push((n, n + 1, *level)),
        }
    }
    out
}
