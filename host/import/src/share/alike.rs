//! Which lines of a script are alike, and where the longest group of them repeats.

use super::{Group, Line, MIN_LINES, hash};

/// Longest group: what is looked at for each pair of places stays bounded.
const MAX_LINES: usize = 5000;
/// Places that begin alike of which pairs are compared.
const MAX_PLACES: usize = 32;
/// What of a script's lines may be alike.
pub(super) struct Alike {
    sums: Sums,
    /// What the first line of a group must be alike in; 0 for what begins none.
    heads: Vec<u64>,
    /// Places whose first lines are alike, in ascending order; none stands alone.
    places: Vec<Vec<usize>>,
    shifted: bool,
    /// For each line the first from it on that opens or closes a block or stands elsewhere.
    flat: Vec<usize>,
}

impl Alike {
    pub(super) fn new(lines: &[Line<'_>], used: &[bool], shifted: bool, modes: bool) -> Alike {
        let usable = |i: usize| Some(&lines[i]).filter(|line| line.usable && !used[i]);
        let token = |i: usize| match usable(i) {
            Some(line) if shifted => line.moved,
            Some(line) => line.exact,
            None => 0,
        };
        let head = |i: usize| match usable(i) {
            Some(line) if !shifted && modes => hash((line.exact, line.modes)),
            Some(line) if !shifted => line.exact,
            Some(line) if line.place.iter().all(Option::is_some) => line.shape,
            _ => 0,
        };
        let tokens: Vec<u64> = (0..lines.len()).map(token).collect();
        let heads: Vec<u64> = (0..lines.len()).map(head).collect();
        let mut windows = Vec::with_capacity(lines.len());
        for i in 0..lines.len().saturating_sub(MIN_LINES - 1) {
            let rest = &tokens[i + 1..i + MIN_LINES];
            if heads[i] != 0 && !rest.contains(&0) {
                windows.push((hash((heads[i], rest)), i));
            }
        }
        windows.sort_unstable();
        let places = windows
            .chunk_by(|a, b| a.0 == b.0)
            .filter(|places| places.len() > 1)
            .map(|places| places.iter().map(|place| place.1).collect())
            .collect();
        let mut flat = vec![lines.len(); lines.len()];
        for i in (0..lines.len()).rev() {
            let same = |next: &Line<'_>| next.indent == lines[i].indent;
            flat[i] = match lines.get(i + 1) {
                _ if lines[i].opens != 0 => i,
                Some(next) if same(next) => flat[i + 1],
                _ => i + 1,
            };
        }
        Alike { sums: Sums::new(tokens), heads, places, shifted, flat }
    }

    /// The largest repeated group of lines that are not used yet.
    pub(super) fn find(&self, lines: &[Line<'_>], used: &[bool]) -> Option<Group> {
        // How many lines from each on are not used.
        let mut free = vec![0; lines.len() + 1];
        for i in (0..lines.len()).rev() {
            free[i] = if used[i] { 0 } else { free[i + 1] + 1 };
        }
        let mut best: Option<(usize, usize)> = None;
        for places in &self.places {
            let mut list = places.iter().copied().filter(|place| !used[*place]);
            let Some(first) = list.next() else { continue };
            let mut before = first;
            // Against the first and against the one before: more would only find the same.
            for later in list.take(MAX_PLACES) {
                for earlier in [first, before] {
                    let most = (later - earlier).min(free[earlier]).min(free[later]).min(MAX_LINES);
                    let longest = best.map_or(MIN_LINES - 1, |(_, longest)| longest);
                    if most < longest {
                        continue;
                    }
                    let most = self.sums.alike(earlier + 1, later + 1, most - 1) + 1;
                    if most < longest {
                        continue;
                    }
                    let len = self.balanced(lines, earlier, most);
                    if len > longest || len == longest && best.is_some_and(|(at, _)| earlier < at) {
                        best = Some((earlier, len));
                    }
                }
                before = later;
            }
        }
        let (from, len) = best?;
        let mut starts = vec![from];
        let mut at = from + len;
        while at + len <= lines.len() {
            if self.heads[at] == self.heads[from]
                && free[at] >= len
                && self.sums.alike(from + 1, at + 1, len - 1) == len - 1
            {
                starts.push(at);
                at += len;
            } else {
                at += 1;
            }
        }
        let offsets = self.shifted.then(|| {
            let place = |i: usize| lines[i].place.map(Option::unwrap_or_default);
            let first = place(from);
            starts.iter().map(|start| [0, 1].map(|i: usize| place(*start)[i] - first[i])).collect()
        });
        (starts.len() > 1).then_some(Group { starts, len, offsets })
    }

    /// The longest beginning of `most` lines from `from` in which every block that opens closes.
    fn balanced(&self, lines: &[Line<'_>], from: usize, most: usize) -> usize {
        if from + most <= self.flat[from] {
            return most;
        }
        let (mut depth, mut len) = (0, 0);
        for (i, line) in lines[from..from + most].iter().enumerate() {
            if depth == 0 && line.indent != lines[from].indent {
                break;
            }
            depth += line.opens;
            if depth < 0 {
                break;
            }
            if depth == 0 {
                len = i + 1;
            }
        }
        len
    }
}

/// Sums over all beginnings, by which two stretches are compared at once.
struct Sums {
    sums: Vec<u64>,
    powers: Vec<u64>,
    /// For each line how many from it on match something.
    known: Vec<usize>,
}

impl Sums {
    fn new(tokens: Vec<u64>) -> Sums {
        const BASE: u64 = 0x9E37_79B9_7F4A_7C15;
        let (mut sums, mut powers) = (vec![0_u64], vec![1_u64]);
        for (i, token) in tokens.iter().enumerate() {
            sums.push(sums[i].wrapping_mul(BASE).wrapping_add(*token));
            powers.push(powers[i].wrapping_mul(BASE));
        }
        let mut known = vec![0; tokens.len() + 1];
        for i in (0..tokens.len()).rev() {
            known[i] = if tokens[i] == 0 { 0 } else { known[i + 1] + 1 };
        }
        Sums { sums, powers, known }
    }

    fn sum(&self, from: usize, len: usize) -> u64 {
        self.sums[from + len].wrapping_sub(self.sums[from].wrapping_mul(self.powers[len]))
    }

    /// How many lines from `a` and `b` on are alike, at most `most`; what matches nothing ends it.
    fn alike(&self, a: usize, b: usize, most: usize) -> usize {
        let (mut low, mut high) = (0, most.min(self.known[a]).min(self.known[b]));
        while low < high {
            let middle = (low + high).div_ceil(2);
            if self.sum(a, middle) == self.sum(b, middle) {
                low = middle;
            } else {
                high = middle - 1;
            }
        }
        low
    }
}
