//! The script that probes a surface.

use lang::profile::Profile;

use crate::text::mm;

/// What is probed. Lengths in mm, work positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Probe {
    /// One corner.
    pub low: [f64; 2],
    /// The other one.
    pub high: [f64; 2],
    /// Columns and rows.
    pub count: [u32; 2],
    /// Z between the places.
    pub lift: f64,
    /// Z down to which is probed.
    pub deepest: f64,
}

/// Writes the script: it prints a line `height X Y Z` for each place.
///
/// # Errors
/// What is wrong, in words.
pub fn probe(wish: &Probe, profile: &Profile) -> Result<String, String> {
    let Probe { low, high, count, lift, deepest } = *wish;
    let Some(z) = &profile.z else {
        return Err(format!("the machine {} has no Z", profile.name));
    };
    if low[0] >= high[0] || low[1] >= high[1] {
        return Err("the second corner lies right of and above the first".to_owned());
    }
    if count.iter().any(|n| !(2..=200).contains(n)) {
        return Err("a grid has 2 to 200 columns and rows".to_owned());
    }
    if f64::from(z.upward()) * (lift - deepest) <= 0.0 {
        let down = if z.counts_down() { ", and Z of this machine counts downward" } else { "" };
        return Err(format!("it is probed from the lift downward{down}"));
    }
    let [columns, rows] = count;
    Ok(format!(
        "' Probes a surface at {columns} x {rows} places, for pasapas level.\n\
         ' The Z of the work is 0 on the surface near its first place. What it prints is the file of heights.\n\
         PROFILE \"{name}\"\n\
         CONST LIFT = {lift}\n\
         CONST DEEPEST = {deepest}\n\
         DIM column, row, n, px AS LENGTH, py AS LENGTH\n\
         G0 Z[LIFT]\n\
         FOR row = 0 TO {last_row}\n\
         \x20 FOR n = 0 TO {last_column}\n\
         \x20   column = n\n\
         \x20   IF row MOD 2 = 1 THEN column = {last_column} - n\n\
         \x20   px = {x} + {width} * column / {last_column}\n\
         \x20   py = {y} + {height} * row / {last_row}\n\
         \x20   G0 X[px] Y[py]\n\
         \x20   Probe Z, DEEPEST, 2mm/s\n\
         \x20   PRINT \"height \"; px; \" \"; py; \" \"; PROBED(Z)\n\
         \x20   G0 Z[LIFT]\n\
         \x20 NEXT\n\
         NEXT\n\
         G0 X[{x}] Y[{y}]\n",
        name = profile.name,
        lift = mm(lift),
        deepest = mm(deepest),
        last_row = rows - 1,
        last_column = columns - 1,
        x = mm(low[0]),
        y = mm(low[1]),
        width = mm(high[0] - low[0]),
        height = mm(high[1] - low[1]),
    ))
}
