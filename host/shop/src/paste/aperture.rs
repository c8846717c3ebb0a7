//! Apertures: standard ones, and macros (The Gerber Layer Format Specification, revision 2024.05,
//! sections 4.4 and 4.5).

use std::collections::BTreeMap;

use super::outline::{Piece, Spot, circle, hull, obround, polygon, rectangle, turned};
use super::sum;

/// Corners of a macro's outline.
const MOST_CORNERS: usize = 10_000;

/// A macro: its words in their order.
pub(super) type Macro = Vec<String>;

fn add(ring: Vec<Spot>) -> Piece {
    Piece { add: true, ring }
}

/// A standard aperture: `C`, `R`, `O`, `P` with its numbers, in the file's unit of `mm` mm.
pub(super) fn standard(kind: &str, numbers: &[f64], mm: f64) -> Result<Vec<Piece>, String> {
    let size = |n: usize| match numbers.get(n) {
        Some(size) if *size >= 0.0 && size * mm <= super::FAR => Ok(size * mm),
        Some(size) => Err(format!("an aperture of size {size}")),
        None => Err(format!("aperture {kind} needs {} numbers", n + 1)),
    };
    let (ring, hole) = match kind {
        "C" => (circle([0.0; 2], size(0)?), 1),
        "R" => (rectangle([0.0; 2], size(0)?, size(1)?), 2),
        "O" => (obround(size(0)?, size(1)?), 2),
        _ => {
            let corners = numbers.get(1).copied().unwrap_or(0.0);
            if !(3.0..=12.0).contains(&corners) {
                return Err("an aperture P has 3 to 12 corners".to_owned());
            }
            let angle = numbers.get(2).copied().unwrap_or(0.0);
            (polygon([0.0; 2], size(0)?, corners as usize, angle), 3)
        }
    };
    let mut pieces = vec![add(ring)];
    if numbers.get(hole).is_some_and(|hole| *hole > 0.0) {
        pieces.push(Piece { add: false, ring: circle([0.0; 2], size(hole)?) });
    }
    Ok(pieces)
}

/// A macro with its numbers, in the file's unit of `mm` mm.
pub(super) fn of_macro(words: &Macro, numbers: &[f64], mm: f64) -> Result<Vec<Piece>, String> {
    let mut variables: BTreeMap<u32, f64> = (1..).zip(numbers.iter().copied()).collect();
    let mut pieces = Vec::new();
    for word in words {
        let word = word.trim();
        if word.is_empty() || word.starts_with('0') {
            continue;
        }
        let bad =
            || format!("`{}` is no line of a macro", word.chars().take(40).collect::<String>());
        if let Some(rest) = word.strip_prefix('$') {
            let (number, text) = rest.split_once('=').ok_or_else(bad)?;
            let number = number.trim().parse().map_err(|_| bad())?;
            variables.insert(number, sum::value(text, &variables).ok_or_else(bad)?);
            continue;
        }
        let values: Option<Vec<f64>> =
            word.split(',').map(|text| sum::value(text, &variables)).collect();
        primitive(&values.ok_or_else(bad)?, mm, &mut pieces)?;
    }
    Ok(pieces)
}

/// One line of a macro.
fn primitive(values: &[f64], mm: f64, pieces: &mut Vec<Piece>) -> Result<(), String> {
    let code = values[0];
    let at = |n: usize| match values.get(n) {
        Some(value) if (value * mm).abs() <= super::FAR => Ok(value * mm),
        Some(_) => Err("a macro draws beyond 10 m".to_owned()),
        None => Err(format!("primitive {code} of a macro needs {} numbers", n + 1)),
    };
    let angle = |n: usize| values.get(n).copied().unwrap_or(0.0);
    let turn = |ring: Vec<Spot>, n: usize| -> Vec<Spot> {
        ring.into_iter().map(|spot| turned(spot, angle(n))).collect()
    };
    let ring = match code as i64 {
        1 => turn(circle([at(3)?, at(4)?], at(2)?.abs()), 5),
        2 | 20 => turn(line([at(3)?, at(4)?], [at(5)?, at(6)?], at(2)?), 7),
        21 => turn(rectangle([at(4)?, at(5)?], at(2)?, at(3)?), 6),
        22 => {
            let (w, h) = (at(2)?, at(3)?);
            turn(rectangle([at(4)? + w / 2.0, at(5)? + h / 2.0], w, h), 6)
        }
        4 => {
            let corners = values.get(2).copied().unwrap_or(0.0);
            if !(2.0..=MOST_CORNERS as f64).contains(&corners) {
                return Err(format!("an outline of {corners} corners in a macro"));
            }
            let corners = corners as usize;
            let spot = |n: usize| Ok([at(3 + 2 * n)?, at(4 + 2 * n)?]);
            let ring = (0..=corners).map(spot).collect::<Result<_, String>>()?;
            turn(ring, 5 + 2 * corners)
        }
        5 => {
            let corners = values.get(2).copied().unwrap_or(0.0);
            if !(3.0..=12.0).contains(&corners) {
                return Err("a polygon of a macro has 3 to 12 corners".to_owned());
            }
            turn(polygon([at(3)?, at(4)?], at(5)?, corners as usize, 0.0), 6)
        }
        7 => {
            thermal([at(1)?, at(2)?], [at(3)?, at(4)?], at(5)?, angle(6), pieces);
            return Ok(());
        }
        _ => return Err(format!("primitive {code} of a macro is not known")),
    };
    let exposed = values.get(1).copied().unwrap_or(0.0) != 0.0;
    pieces.push(Piece { add: exposed, ring });
    Ok(())
}

/// A stroke with square ends.
fn line(from: Spot, to: Spot, width: f64) -> Vec<Spot> {
    let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    let length = dx.hypot(dy);
    if length == 0.0 {
        return Vec::new();
    }
    let [x, y] = [-dy / length * width / 2.0, dx / length * width / 2.0];
    vec![
        [from[0] + x, from[1] + y],
        [to[0] + x, to[1] + y],
        [to[0] - x, to[1] - y],
        [from[0] - x, from[1] - y],
    ]
}

/// A ring of an outer and an inner diameter with four gaps: its quarters, each a piece.
fn thermal(middle: Spot, sizes: [f64; 2], gap: f64, angle: f64, pieces: &mut Vec<Piece>) {
    /// Corners of a quarter's arc.
    const STEPS: usize = 16;
    let [outer, inner] = sizes.map(|size| size / 2.0);
    let half = gap / 2.0;
    if gap < 0.0 || outer <= half {
        return;
    }
    let arc = |radius: f64| {
        let first = (half / radius).min(1.0).asin();
        let last = std::f64::consts::FRAC_PI_2 - first;
        (0..=STEPS).map(move |n| {
            let (sin, cos) = (first + (last - first) * n as f64 / STEPS as f64).sin_cos();
            [radius * cos, radius * sin]
        })
    };
    let mut quarter: Vec<Spot> = arc(outer).collect();
    match inner > half {
        true => quarter.extend(arc(inner).collect::<Vec<_>>().into_iter().rev()),
        false => quarter.push([half, half]),
    }
    for n in 0..4 {
        let place = |spot: &Spot| {
            let spot = turned(*spot, 90.0 * f64::from(n));
            turned([spot[0] + middle[0], spot[1] + middle[1]], angle)
        };
        pieces.push(add(quarter.iter().map(place).collect()));
    }
}

/// The convex outline that a stroke is drawn with.
pub(super) fn pen(pieces: &[Piece]) -> Vec<Spot> {
    let added = pieces.iter().filter(|piece| piece.add);
    hull(added.flat_map(|piece| piece.ring.iter().copied()).collect())
}
