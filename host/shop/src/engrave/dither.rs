//! From greys to dots that are burnt or not, or to powers.

use super::picture::Picture;

/// How greys are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dither {
    /// Darker than the middle is burnt.
    None,
    /// Floyd and Steinberg, 1976: what a pixel lacks goes to four of its neighbours.
    FloydSteinberg,
    /// Atkinson: to six of them, and a quarter is lost, which leaves light parts white.
    Atkinson,
    /// A pattern of 8 x 8.
    Bayer,
    /// Power by the grey.
    Power,
}

/// Powers that differ with [`Dither::Power`]: neighbours of the same are one line.
pub const LEVELS: u32 = 16;

/// Where a pixel's rest goes: columns, rows, parts; and of how many.
type Spread = (&'static [(isize, usize, i32)], i32);

const FLOYD: Spread = (&[(1, 0, 7), (-1, 1, 3), (0, 1, 5), (1, 1, 1)], 16);
const ATKINSON: Spread = (&[(1, 0, 1), (2, 0, 1), (-1, 1, 1), (0, 1, 1), (1, 1, 1), (0, 2, 1)], 8);

impl Picture {
    /// The part of the full power of each pixel, in [`LEVELS`]ths; rows from the top.
    #[must_use]
    pub fn levels(&self, dither: Dither) -> Vec<u8> {
        let black = |dark: bool| if dark { LEVELS as u8 } else { 0 };
        match dither {
            Dither::None => self.greys.iter().map(|grey| black(*grey < 128)).collect(),
            Dither::Power => self
                .greys
                .iter()
                .map(|grey| ((u32::from(255 - grey) * LEVELS + 127) / 255) as u8)
                .collect(),
            Dither::Bayer => {
                let at = |n: usize| (n % self.width, n / self.width);
                let dark = |(n, grey): (usize, &u8)| {
                    let (x, y) = at(n);
                    // The middle of each of 64 steps.
                    black(u32::from(*grey) * 128 < (2 * bayer(x, y) + 1) * 255)
                };
                self.greys.iter().enumerate().map(dark).collect()
            }
            Dither::FloydSteinberg => self.diffused(FLOYD).into_iter().map(black).collect(),
            Dither::Atkinson => self.diffused(ATKINSON).into_iter().map(black).collect(),
        }
    }

    fn diffused(&self, (parts, of): Spread) -> Vec<bool> {
        let mut left: Vec<i32> = self.greys.iter().map(|grey| i32::from(*grey) * of).collect();
        let mut out = Vec::with_capacity(left.len());
        for n in 0..left.len() {
            let (x, y) = (n % self.width, n / self.width);
            let dark = left[n] < 128 * of;
            out.push(dark);
            let rest = left[n] - if dark { 0 } else { 255 * of };
            for (dx, dy, part) in parts {
                let column = x.checked_add_signed(*dx).filter(|x| *x < self.width);
                if let Some(column) = column.filter(|_| y + dy < self.height) {
                    left[(y + dy) * self.width + column] += rest * part / of;
                }
            }
        }
        out
    }
}

/// Entry of the matrix of 8 x 8, 0 to 63.
fn bayer(x: usize, y: usize) -> u32 {
    (0..3).fold(0, |sum, bit| {
        let (x, y) = ((x >> bit) & 1, (y >> bit) & 1);
        (sum << 2) | ((((x ^ y) << 1) | y) as u32)
    })
}
