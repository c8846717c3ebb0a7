//! Entries of the statement table: where each ends, where RESUME NEXT goes on, what is too long for one.

use crate::image::statements::{self, Place};

/// RESUME NEXT goes on behind the statement's own code.
pub const NO_RESUME: usize = usize::MAX;

/// A place ends where the next begins; without a label RESUME NEXT goes on there.
pub fn close(place: &mut Place, end: usize) {
    place.end = end;
    if place.resume == NO_RESUME {
        place.resume = end;
    }
}

/// A place as entries that hold it: a longer one goes on where nothing is on the stack, as the image check demands of
/// an entry's beginning.
pub fn parted(place: Place, parts: &[usize]) -> Vec<Place> {
    let mut out = Vec::new();
    let mut entry = place.start;
    while place.end - entry > statements::LONGEST {
        let inside = |at: &&usize| **at > entry && **at <= entry + statements::LONGEST;
        let Some(&end) = parts.iter().rfind(inside) else { break };
        out.push(Place { entry, end, ..place });
        entry = end;
    }
    out.push(Place { entry, ..place });
    out
}
