//! Pieces of the path that are under way.

use std::collections::VecDeque;

use crate::course::LineEnds;
use crate::sim::record::Segment;
use crate::sim::trace::What;

/// See the module.
#[derive(Debug, Default)]
pub struct Pieces {
    /// How fast the lines of the program may end, on a part that takes slow points.
    pub ends: Option<LineEnds>,
    /// One for each block that waits for its beginning, with what is written then.
    pub blocks: VecDeque<(Option<What>, Segment)>,
    /// Line of the block that plays.
    pub line: Option<u32>,
    /// Power of the block that plays.
    pub beam: Option<i32>,
    /// Number in the record of the piece that the path plays.
    pub path: Option<usize>,
    /// The same for each axis on its own.
    pub solo: [Option<usize>; 3],
}
