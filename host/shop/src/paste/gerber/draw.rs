//! What the commands of a layer draw: flashes, strokes, regions, blocks, repetitions.

use super::{Aperture, DEEPEST, MOST_CORNERS, Open, Reader, Turn, Way};
use crate::paste::FAR;
use crate::paste::aperture;
use crate::paste::outline::{Piece, Spot, Thing, arc, swept, turned};

impl Reader {
    pub(super) fn block(&mut self, rest: &str) {
        match rest.strip_prefix('D').map(str::parse) {
            Some(Ok(number)) if self.open.len() < DEEPEST => {
                self.open.push(Open::Block(number, Vec::new()));
            }
            None if rest.is_empty() => match self.open.pop() {
                Some(Open::Block(number, things)) => {
                    self.apertures.insert(number, Aperture::Block(things));
                }
                _ => self.error("%AB*% ends nothing", "the file may be cut"),
            },
            _ => self.unreadable(&format!("AB{rest}")),
        }
    }

    /// `X2Y1I5.0J0`; nothing behind it ends the repetition.
    pub(super) fn repeat(&mut self, rest: &str) {
        self.end_repeat();
        if rest.is_empty() {
            return;
        }
        let values = letters(rest, "XYIJ");
        let (Some([x, y, i, j]), Some(mm)) = (values, self.unit) else {
            return self.unreadable(&format!("SR{rest}"));
        };
        let counts = [x, y].map(|n| n.unwrap_or(1.0));
        let good = counts.iter().all(|n| (1.0..=10_000.0).contains(n) && n.fract() == 0.0);
        let steps = [i, j].map(|step| step.unwrap_or(0.0) * mm);
        if !good || steps.iter().any(|step| step.abs() > FAR) || self.open.len() >= DEEPEST {
            return self.unreadable(&format!("SR{rest}"));
        }
        self.open.push(Open::Repeat(counts.map(|n| n as u32), steps, Vec::new()));
    }

    pub(super) fn end_repeat(&mut self) {
        if !matches!(self.open.last(), Some(Open::Repeat(..))) {
            return;
        }
        let Some(Open::Repeat(counts, steps, things)) = self.open.pop() else { return };
        for row in 0..counts[1] {
            for column in 0..counts[0] {
                let shift = [f64::from(column) * steps[0], f64::from(row) * steps[1]];
                for thing in &things {
                    self.put(thing.mapped(|[x, y]| [x + shift[0], y + shift[1]]));
                }
                if self.corners > MOST_CORNERS {
                    return;
                }
            }
        }
    }

    fn put(&mut self, thing: Thing) {
        // A thing of nothing counts as well: a file must not hold endlessly many.
        let whole = self.corners <= MOST_CORNERS;
        self.corners += thing.corners().max(4);
        if self.corners > MOST_CORNERS {
            if whole {
                let words = format!("what is drawn has more than {MOST_CORNERS} corners");
                self.error(words, "cut the panel in pieces");
            }
            return;
        }
        match self.open.last_mut() {
            Some(open) => open.things().push(thing),
            None => self.layer.things.push(thing),
        }
    }

    fn draw(&mut self, pieces: Vec<Piece>) {
        let (dark, name, line) = (self.dark, self.name.clone(), self.line);
        self.put(Thing { dark, pieces, name, line });
    }

    pub(super) fn end_contour(&mut self) {
        let Some(ring) = &mut self.region else { return };
        let ring = std::mem::take(ring);
        if ring.len() > 2 {
            self.regions.push(Piece { add: true, ring });
        }
    }

    pub(super) fn end_region(&mut self) {
        self.end_contour();
        self.region = None;
        let pieces = std::mem::take(&mut self.regions);
        self.draw(pieces);
    }

    /// The places of a way from here, without the first.
    fn places(&self, to: Spot, offset: Spot) -> Option<Vec<Spot>> {
        if self.way == Way::Line {
            return Some(vec![to]);
        }
        let clockwise = self.way == Way::Clockwise;
        let middle = |sign: [f64; 2]| [0, 1].map(|n| self.at[n] + sign[n] * offset[n]);
        if !self.quarter {
            return Some(arc(self.at, to, middle([1.0; 2]), clockwise));
        }
        // Of the four middles it is the one that lies as far from both ends, and turns least.
        let from = self.at;
        let good = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]].map(middle).into_iter();
        let fits = |middle: &Spot| {
            let [a, b] = [from, to].map(|s| (s[0] - middle[0]).hypot(s[1] - middle[1]));
            let cross = (from[0] - middle[0]) * (to[1] - middle[1])
                - (from[1] - middle[1]) * (to[0] - middle[0]);
            let dot = (from[0] - middle[0]) * (to[0] - middle[0])
                + (from[1] - middle[1]) * (to[1] - middle[1]);
            let way = if clockwise { -cross } else { cross };
            (a - b).abs() <= 0.01 + a * 0.01 && way >= -1e-9 && dot >= -0.01 * a * a
        };
        let middle = good.into_iter().find(fits)?;
        match from == to {
            true => Some(vec![to]),
            false => Some(arc(from, to, middle, clockwise)),
        }
    }

    pub(super) fn stroke(&mut self, to: Spot, offset: Spot) {
        let Some(places) = self.places(to, offset) else {
            return self.error("an arc of at most a quarter has no middle", "%FS may be wrong");
        };
        let from = self.at;
        if let Some(ring) = &mut self.region {
            if ring.is_empty() {
                ring.push(from);
            }
            self.corners += places.len();
            if self.corners <= MOST_CORNERS {
                ring.extend(places);
            }
            return;
        }
        let pen = match self.aperture.and_then(|number| self.apertures.get(&number)) {
            Some(Aperture::Pieces(pieces)) => aperture::pen(pieces),
            Some(Aperture::Block(_)) => {
                return self.error("a stroke with a block", "known are flashes of blocks");
            }
            None => return self.error("a stroke before an aperture", "the file may be cut"),
        };
        let pen = self.flashed(&pen, [0.0; 2]);
        let mut pieces = Vec::with_capacity(places.len());
        let mut last = from;
        for place in places {
            pieces.push(Piece { add: true, ring: swept(&pen, last, place) });
            last = place;
        }
        self.draw(pieces);
    }

    /// A ring as it is flashed at a place.
    fn flashed(&self, ring: &[Spot], at: Spot) -> Vec<Spot> {
        let Turn { mirror, degrees, scale } = self.turn;
        let sign = mirror.map(|mirror| if mirror { -scale } else { scale });
        let spot = |[x, y]: Spot| {
            let [x, y] = turned([x * sign[0], y * sign[1]], degrees);
            [x + at[0], y + at[1]]
        };
        ring.iter().map(|place| spot(*place)).collect()
    }

    pub(super) fn flash(&mut self, at: Spot) {
        if self.region.is_some() {
            return self.error("a flash inside of a region", "the file may be cut");
        }
        let found = self.aperture.and_then(|number| self.apertures.get(&number));
        let things: Vec<(bool, Vec<Piece>)> = match found {
            Some(Aperture::Pieces(pieces)) => vec![(true, pieces.clone())],
            Some(Aperture::Block(things)) => {
                things.iter().map(|thing| (thing.dark, thing.pieces.clone())).collect()
            }
            None => return self.error("a flash before an aperture", "the file may be cut"),
        };
        let dark = self.dark;
        for (own, mut pieces) in things {
            for piece in &mut pieces {
                piece.ring = self.flashed(&piece.ring, at);
            }
            self.dark = own == dark;
            self.draw(pieces);
        }
        self.dark = dark;
    }
}

/// Numbers behind letters, each at most once.
fn letters(text: &str, known: &str) -> Option<[Option<f64>; 4]> {
    let mut out = [None; 4];
    let mut rest = text;
    while let Some(letter) = rest.chars().next() {
        let n = known.find(letter)?;
        let end = rest[1..].find(|c: char| c.is_ascii_alphabetic()).map_or(rest.len(), |n| n + 1);
        out[n] = Some(rest[1..end].parse::<f64>().ok().filter(|n| n.is_finite())?);
        rest = &rest[end..];
    }
    Some(out)
}
