//! Slow points of a course: how fast the lines of a path may end, for a chip that knows none ahead.
//!
//! A course is a series of lines that the host knows before the run and between which nothing but F and pure instructions
//! is executed. `course`, in front of the first one, names its record, which stands in the data as a text does: a length
//! byte, 255 where it is longer, then entries of three bytes. Each stands for so many lines that have steps to make; a
//! line without any does not count.
//!
//! | byte | holds |
//! |---|---|
//! | 0 | twice its lines, 1 to 127, and bit 0: [`Entry::holds`]; 0 after the last entry |
//! | 1, 2 | [`Entry::bound`] |
//!
//! Lines too short to be planned one by one are joined: their targets are taken, and the last of them makes the way of
//! all. In front of an entry stand the byte 1 and [`Entry::joins`], negated, where that is another number than before: 0
//! at first. What an entry counts are lines that are made.
//!
//! A line of an entry after its first may end as fast as the one before it, less what its own braking takes of the
//! square, `2 d length`, but no less than 0; of one that holds, as fast as the first. Where that is no more than the square of the start rate, the line ends at rest, as
//! every line does without a course. A record names every line of its course, and the bound of the last one is a rest.
//!
//! A course is over when its last line is planned. `course` is executed anew in each pass of a loop: while lines of a
//! course are left it changes nothing, and after that it begins the course again. Where a host
//! traces, no course begins, nor does one later in that run: each line rests.
//! A program with courses says so in [`MachineRecord::COURSES`], and leaves
//! [`Part::course_pool`](crate::part::Part::course_pool) bytes of its memory to them, which count as stack in its header.
//!
//! [`MachineRecord::COURSES`]: crate::record::MachineRecord::COURSES

/// Bytes of an entry.
const ENTRY: usize = 3;
/// Bit of an entry's first byte: [`Entry::holds`].
const HOLDS: u8 = 1;
/// First byte of a pair: how lines are joined from here on.
const JOIN: u8 = 1;
/// Lines of an entry at most.
pub const MOST: u8 = u8::MAX >> 1;

/// Lines of a course up to the next slow point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// How many, 1..=127.
    pub lines: u8,
    /// The bound is that of each of them.
    pub holds: bool,
    /// Square of the speed at which the first of them may end, (um/s)^2: the upper half of a number with 24 bits of
    /// mantissa and, in its top byte, the power of two plus 128.
    pub bound: u16,
    /// Axes that are named, behind each of its lines, by lines that are joined to the next one: two of three axes each
    /// are 6. A line that is joined names its axes in um, and those of the line that makes its way.
    pub joins: u8,
}

/// The entries of a record, which begins behind its length byte.
pub fn entries(record: &[u8]) -> impl Iterator<Item = Entry> {
    let (mut rest, mut joins) = (record, 0);
    core::iter::from_fn(move || {
        if let [JOIN, negated, more @ ..] = rest {
            (rest, joins) = (more, negated.wrapping_neg());
        }
        let (&[head, low, high], more) = rest.split_first_chunk::<ENTRY>()?;
        let (lines, holds) = (head >> 1, head & HOLDS != 0);
        rest = more;
        (lines != 0).then_some(Entry {
            lines,
            holds,
            bound: u16::from_le_bytes([low, high]),
            joins,
        })
    })
}

/// The record of these entries, without its length byte.
#[cfg(feature = "compiler")]
pub fn record(entries: &[Entry]) -> Vec<u8> {
    let (mut record, mut joins) = (Vec::new(), 0);
    for entry in entries {
        if entry.joins != joins {
            joins = entry.joins;
            record.extend([JOIN, joins.wrapping_neg()]);
        }
        record.push(entry.lines << 1 | if entry.holds { HOLDS } else { 0 });
        record.extend(entry.bound.to_le_bytes());
    }
    record.push(0);
    record
}
