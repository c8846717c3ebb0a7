//! Pieces of the path that are under way.

use std::collections::VecDeque;

use lang::place::Place;

use crate::course::LineEnds;
use crate::sim::record::Segment;
use crate::sim::trace::What;

/// See the module.
#[derive(Debug, Default)]
pub struct Pieces {
    /// How fast the lines of the program may end, on a part that takes slow points.
    pub ends: Option<LineEnds>,
    /// Lines that are joined to the next one: where the first of them begins, and what is written of them.
    pub joined: Option<Joined>,
    /// One for each block that waits for its beginning, with what is written then.
    pub blocks: VecDeque<(Vec<What>, Segment)>,
    /// Line of the block that plays.
    pub line: Option<u32>,
    /// Power of the block that plays.
    pub beam: Option<i32>,
    /// Number in the record of the piece that the path plays.
    pub path: Option<usize>,
    /// The same for each axis on its own.
    pub solo: [Option<usize>; 3],
}

/// Lines of which the next one makes the way.
#[derive(Debug)]
pub struct Joined {
    /// Where they begin, steps and um.
    pub from: [Place; 3],
    /// What is written of them.
    pub what: Vec<What>,
}
