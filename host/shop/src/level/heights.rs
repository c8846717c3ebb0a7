//! Heights on a grid, and between its places.

use crate::Wrong;

/// Places of a grid.
const MOST: usize = 40_000;
/// Places that are nearer are on one line of the grid, mm.
const SAME: f64 = 0.02;
/// Heights that differ more are no surface, mm.
const MOST_HEIGHT: f64 = 100.0;

/// A surface: heights at the crossings of columns and rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Heights {
    columns: Vec<f64>,
    rows: Vec<f64>,
    /// Row by row.
    heights: Vec<f64>,
}

impl Heights {
    /// Reads a file: lines `height X Y Z`, as the probing script prints them, among any others; or a table of
    /// X, Y and Z.
    ///
    /// # Errors
    /// What is wrong, by line.
    pub fn parse(text: &str) -> Result<Heights, Wrong> {
        const HINT: &str = "a line is `height X Y Z`, or three numbers in mm; `pasapas level --probe` makes the script that prints them";
        let printed = text.lines().any(|line| numbers(line, true).is_some());
        let mut spots: Vec<([f64; 3], u32)> = Vec::new();
        let mut titled = false;
        for (line, words) in (1..).zip(text.lines()) {
            let words = words.trim();
            if words.is_empty() || words.starts_with(['#', '\'', ';']) {
                continue;
            }
            match numbers(words, printed) {
                Some(spot) => spots.push((spot, line)),
                None if printed => {}
                None if !titled && spots.is_empty() && words.starts_with(char::is_alphabetic) => {
                    titled = true;
                }
                None => {
                    let words: String = words.chars().take(40).collect();
                    return Err(Wrong::new(line, format!("`{words}` is no height"), HINT));
                }
            }
            if spots.len() > MOST {
                return Err(Wrong::new(line, format!("more than {MOST} heights"), "a wider grid"));
            }
        }
        let Some(low) = spots.iter().map(|(spot, _)| spot[2]).min_by(f64::total_cmp) else {
            return Err(Wrong::new(1, "a file without heights", HINT));
        };
        if let Some((spot, line)) = spots.iter().find(|(spot, _)| spot[2] - low > MOST_HEIGHT) {
            let words = format!("a height of {} mm beside one of {low} mm", spot[2]);
            return Err(Wrong::new(*line, words, "is one of them in another unit?"));
        }
        grid(&spots)
    }

    /// Smallest and greatest X and Y.
    pub fn bounds(&self) -> [[f64; 2]; 2] {
        let ends = |list: &[f64]| [list[0], list[list.len() - 1]];
        let ([left, right], [low, high]) = (ends(&self.columns), ends(&self.rows));
        [[left, low], [right, high]]
    }

    /// Lowest and highest.
    pub fn range(&self) -> [f64; 2] {
        let fold = |all: [f64; 2], height: &f64| [all[0].min(*height), all[1].max(*height)];
        self.heights.iter().fold([f64::MAX, f64::MIN], fold)
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.columns.len(), self.rows.len()]
    }

    /// Distance of the nearest lines of the grid.
    pub fn pitch(&self) -> f64 {
        let near =
            |list: &[f64]| list.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::MAX, f64::min);
        near(&self.columns).min(near(&self.rows))
    }

    /// The surface at a place; outside of the grid that of its edge.
    pub fn at(&self, x: f64, y: f64) -> f64 {
        let ((c, u), (r, v)) = (cell(&self.columns, x), cell(&self.rows, y));
        let width = self.columns.len();
        let of = |r: usize, c: usize| self.heights[r * width + c];
        let along = |r: usize| of(r, c) + (of(r, c + 1) - of(r, c)) * u;
        along(r) + (along(r + 1) - along(r)) * v
    }

    /// Whether a place is inside of the grid.
    pub fn covers(&self, x: f64, y: f64) -> bool {
        let [low, high] = self.bounds();
        let inside = |at: f64, n: usize| at >= low[n] - SAME && at <= high[n] + SAME;
        inside(x, 0) && inside(y, 1)
    }
}

/// Which gap of a list a value is in, and the part of it, 0 to 1.
fn cell(list: &[f64], at: f64) -> (usize, f64) {
    let n = list.partition_point(|line| *line <= at).clamp(1, list.len() - 1) - 1;
    (n, ((at - list[n]) / (list[n + 1] - list[n])).clamp(0.0, 1.0))
}

/// Three numbers of a line, behind the word `height` if that is wanted.
fn numbers(line: &str, printed: bool) -> Option<[f64; 3]> {
    let line = match printed {
        true => &line[line.find("height ")? + "height ".len()..],
        false => line,
    };
    let mut words = line.split([',', ';', '\t', ' ']).filter(|word| !word.is_empty());
    let mut next = || {
        let word = words.next()?;
        let mm = word.strip_suffix("mm").unwrap_or(word).parse::<f64>().ok()?;
        Some(mm).filter(|mm| mm.abs() <= 10_000.0)
    };
    let spot = [next()?, next()?, next()?];
    (printed || words.next().is_none()).then_some(spot)
}

/// Sorts places into columns and rows.
fn grid(spots: &[([f64; 3], u32)]) -> Result<Heights, Wrong> {
    let lines = |n: usize| {
        let mut all: Vec<f64> = spots.iter().map(|(spot, _)| spot[n]).collect();
        all.sort_by(f64::total_cmp);
        all.dedup_by(|a, b| *a - *b < SAME);
        all
    };
    let (columns, rows) = (lines(0), lines(1));
    if columns.len() < 2 || rows.len() < 2 {
        let words = format!("{} columns and {} rows are no surface", columns.len(), rows.len());
        return Err(Wrong::new(1, words, "a grid has at least 2 of each"));
    }
    if columns.len() * rows.len() > MOST {
        let words = "the places do not lie in columns and rows";
        return Err(Wrong::new(1, words, "probe at the crossings of a grid"));
    }
    let mut heights = vec![None; columns.len() * rows.len()];
    for ([x, y, z], line) in spots {
        let find = |list: &[f64], at: f64| list.partition_point(|own| *own <= at).max(1) - 1;
        let (c, r) = (find(&columns, *x), find(&rows, *y));
        let own = &mut heights[r * columns.len() + c];
        if own.is_some() {
            let words = format!("a second height at X {x} Y {y}");
            return Err(Wrong::new(*line, words, "leave one of the lines out"));
        }
        *own = Some(*z);
    }
    let missing = heights.iter().position(Option::is_none);
    if let Some(n) = missing {
        let (x, y) = (columns[n % columns.len()], rows[n / columns.len()]);
        let words = format!("the grid has no height at X {x} Y {y}");
        return Err(Wrong::new(
            1,
            words,
            "probe that place, too; columns and rows are those of all places",
        ));
    }
    let heights = heights.into_iter().flatten().collect();
    Ok(Heights { columns, rows, heights })
}
