//! The paths of an SVG drawing as ways of the laser.

use usvg::tiny_skia_path::{PathSegment, Point};
use usvg::{Node, Options, Tree};

use super::{Job, Laser, Step};
use crate::Wrong;

/// How far a chord may lie off its curve, mm.
const CHORD: f64 = 0.02;
/// Places of one drawing.
const MOST: usize = 1_000_000;
/// Lines that are put into a short order.
const MOST_ORDERED: usize = 20_000;
/// Elements in elements.
const DEEPEST: usize = 200;

type Spot = [f64; 2];

/// How a drawing is burnt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wish {
    /// Width of the drawing, mm.
    pub size: f64,
    /// Lower left corner, mm; without it the machine's.
    pub at: Option<Spot>,
    /// S.
    pub power: u32,
}

/// Follows the paths.
///
/// # Errors
/// The drawing is damaged, has no paths, or does not fit the machine.
pub fn trace(bytes: &[u8], wish: &Wish, laser: &Laser) -> Result<Job, Wrong> {
    const HINT: &str = "save it as plain SVG";
    let text = std::str::from_utf8(bytes)
        .map_err(|_| Wrong::whole("the drawing is no UTF-8 text", HINT))?;
    if depth(text) > DEEPEST {
        let words = format!("elements stand more than {DEEPEST} deep in each other");
        return Err(Wrong::whole(words, "ungroup the drawing"));
    }
    let mut options = Options::default();
    // No file of a drawing's choice is read.
    options.image_href_resolver.resolve_string = Box::new(|_, _| None);
    options.image_href_resolver.resolve_data = Box::new(|_, _, _| None);
    let tree = Tree::from_str(text, &options)
        .map_err(|error| Wrong::whole(format!("the SVG cannot be read: {error}"), HINT))?;
    let page = [tree.size().width(), tree.size().height()].map(f64::from);
    let scale = wish.size / page[0];
    let at = wish.at.unwrap_or(laser.travel[0]);
    let place =
        |p: Point| [at[0] + f64::from(p.x) * scale, at[1] + (page[1] - f64::from(p.y)) * scale];
    let lines = ordered(lines(&tree, place)?);
    let all = lines.iter().flatten();
    let low = all.clone().fold([f64::MAX; 2], |low, s| [low[0].min(s[0]), low[1].min(s[1])]);
    let high = all.fold([f64::MIN; 2], |high, s| [high[0].max(s[0]), high[1].max(s[1])]);
    if lines.is_empty() {
        let hint = "text becomes paths by `object to path` of the drawing program; pictures in it are not followed";
        return Err(Wrong::whole("an SVG without paths", hint));
    }
    laser.holds(low, high)?;
    let mut job = Job::default();
    for line in &lines {
        for (n, spot) in line.iter().enumerate() {
            let power = if n == 0 { None } else { Some(wish.power) };
            job.steps.push(Step { to: *spot, power });
        }
    }
    job.head.push(format!("{} lines along the paths of a drawing", lines.len()));
    Ok(job)
}

/// How deep elements stand in each other at most.
fn depth(text: &str) -> usize {
    let (mut now, mut most) = (0_usize, 0);
    for (at, _) in text.match_indices('<') {
        let rest = &text.as_bytes()[at + 1..];
        match rest.first() {
            Some(b'/') => now = now.saturating_sub(1),
            Some(b'!' | b'?') | None => {}
            Some(_) => {
                let end = rest.iter().position(|c| *c == b'>').unwrap_or(0);
                if end == 0 || rest[end - 1] != b'/' {
                    now += 1;
                }
                most = most.max(now);
            }
        }
    }
    most
}

/// The lines of all paths, in the drawing's order.
fn lines(tree: &Tree, place: impl Fn(Point) -> Spot) -> Result<Vec<Vec<Spot>>, Wrong> {
    let mut found: Vec<Vec<Spot>> = Vec::new();
    let mut count = 0;
    let mut open: Vec<&Node> = tree.root().children().iter().rev().collect();
    while let Some(node) = open.pop() {
        match node {
            Node::Group(group) => open.extend(group.children().iter().rev()),
            Node::Path(path) if path.is_visible() => {
                let map = |mut p: Point| {
                    path.abs_transform().map_point(&mut p);
                    place(p)
                };
                let own = flat(path.data().segments(), map);
                count += own.iter().map(Vec::len).sum::<usize>();
                found.extend(own);
            }
            _ => {}
        }
        if count > MOST {
            let words = format!("the drawing has more than {MOST} places");
            return Err(Wrong::whole(words, "simplify its paths, or cut it in pieces"));
        }
    }
    Ok(found)
}

/// Curves as chords.
fn flat(
    segments: impl Iterator<Item = PathSegment>,
    map: impl Fn(Point) -> Spot,
) -> Vec<Vec<Spot>> {
    let mut out: Vec<Vec<Spot>> = Vec::new();
    let mut line: Vec<Spot> = Vec::new();
    let close = |line: &mut Vec<Spot>, out: &mut Vec<Vec<Spot>>| {
        let line = std::mem::take(line);
        if line.len() > 1 && line.iter().flatten().all(|mm| mm.is_finite()) {
            out.push(line);
        }
    };
    for segment in segments {
        let from = line.last().copied().unwrap_or_default();
        match segment {
            PathSegment::MoveTo(p) => {
                close(&mut line, &mut out);
                line.push(map(p));
            }
            PathSegment::LineTo(p) => line.push(map(p)),
            PathSegment::QuadTo(a, p) => {
                let [a, p] = [map(a), map(p)];
                // As a cubic one.
                let toward = |b: Spot| [0, 1].map(|i| b[i] + (a[i] - b[i]) * 2.0 / 3.0);
                curve([from, toward(from), toward(p), p], &mut line);
            }
            PathSegment::CubicTo(a, b, p) => curve([from, map(a), map(b), map(p)], &mut line),
            PathSegment::Close => {
                let first = line.first().copied().unwrap_or_default();
                if first != from {
                    line.push(first);
                }
                close(&mut line, &mut out);
                // What follows without a new beginning goes on there.
                line.push(first);
            }
        }
    }
    close(&mut line, &mut out);
    out
}

/// Chords of a cubic curve, without its first place.
fn curve(spots: [Spot; 4], line: &mut Vec<Spot>) {
    let [a, b, c, d] = spots;
    // The second differences bound how far chords are off.
    let bend =
        |a: Spot, b: Spot, c: Spot| (a[0] - 2.0 * b[0] + c[0]).hypot(a[1] - 2.0 * b[1] + c[1]);
    let most = bend(a, b, c).max(bend(b, c, d));
    let count = (0.75 * most / CHORD).sqrt().ceil().clamp(1.0, 1000.0);
    for n in 1..=count as usize {
        let t = n as f64 / count;
        let s = 1.0 - t;
        let w = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
        line.push([0, 1].map(|i| w[0] * a[i] + w[1] * b[i] + w[2] * c[i] + w[3] * d[i]));
    }
}

/// From each line to the one that begins or ends nearest.
fn ordered(mut lines: Vec<Vec<Spot>>) -> Vec<Vec<Spot>> {
    if lines.len() > MOST_ORDERED {
        return lines;
    }
    let mut at = [0.0; 2];
    let far = |a: Spot, b: Spot| (a[0] - b[0]).hypot(a[1] - b[1]);
    for n in 0..lines.len() {
        let ends = |line: &Vec<Spot>| [line[0], line[line.len() - 1]].map(|end| far(at, end));
        let near = |m: &usize| {
            let [first, last] = ends(&lines[*m]);
            first.min(last)
        };
        let next = (n..lines.len()).min_by(|a, b| near(a).total_cmp(&near(b))).unwrap_or(n);
        lines.swap(n, next);
        let [first, last] = ends(&lines[n]);
        if last < first {
            lines[n].reverse();
        }
        at = lines[n][lines[n].len() - 1];
    }
    lines
}
