//! G0 and G1: targets of all axes, and the ways to them.
//!
//! Where the chips differ: on the larger one a line becomes a block of the path, and its statement is done as soon as the
//! path has taken it. The small one plans the line itself, and in a course the next one while it moves.
#![cfg_attr(any(), micro(module = "rules.lines", prefix = "fx_"))]

use super::{Axis, DONE, NOT_YET, Progress};
use lang::fault::Fault;
use lang::isa::Op;
use lang::record::AxisRecord;
use lang::wire::TraceKind;

/// See [`Op::Rapid`]; behind it [`Op::Line`], in front of it the forms with flags.
#[cfg_attr(any(), micro("OP_RAPID"))]
const RAPID: u8 = Op::Rapid as u8;
/// See [`AxisRecord::HOME_POSITIVE`].
#[cfg_attr(any(), micro("AXIS_HOME_POSITIVE"))]
const HOME_POSITIVE: u8 = AxisRecord::HOME_POSITIVE as u8;
/// Bits of axes: X and Y; Z; from there on Z and another.
const XY: u8 = 3;
const Z: u8 = 4;
const Z_AND_ANOTHER: u8 = 5;

/// As [`crate::effect_rows`].
#[macro_export]
macro_rules! line_rows {
    ($consumer:ident) => {
        $consumer! {
            lines {
                Linear Line linear(code first);
            }
        }
    };
}

/// Axes that are commanded together.
pub trait Together {
    /// The statement names the axis.
    #[cfg_attr(any(), micro(has = "FLAGS"))]
    fn is_named(&self, axis: Axis) -> bool;
    /// The new place is commanded; whether there is no way to it.
    #[cfg_attr(any(), micro(code = "DO command", holds = "EQUAL"))]
    fn command_place(&mut self, axis: Axis) -> bool;
    /// Axes that have steps to make.
    #[cfg_attr(any(), micro(place = "RAMPS"))]
    fn going(&self) -> u8;
    /// See [`Together::going`].
    #[cfg_attr(any(), micro(place = "RAMPS"))]
    fn set_going(&mut self, axes: u8);
    /// The axis has steps to make.
    #[cfg_attr(any(), micro(on = "RAMPS"))]
    fn add_going(&mut self, axis: Axis);
    /// It makes them apart.
    #[cfg_attr(any(), micro(off = "RAMPS"))]
    fn remove_going(&mut self, axis: Axis);
}

/// What lines look at and do.
pub trait Lines: Together {
    /// The line has to wait, and begins again then: on the small chip nothing moves, or a course that has room.
    #[cfg_attr(any(), micro(never = 1))]
    fn has_to_wait(&mut self) -> bool;
    /// The statement's next operand byte.
    #[cfg_attr(any(), micro(code = "DO operand_byte"))]
    fn operand(&mut self) -> u8;
    /// The top of the stack, taken.
    #[cfg_attr(any(), micro(code = "DO pop_value"))]
    fn pop(&mut self) -> i32;
    /// The statement's code.
    #[cfg_attr(any(), micro(place = "UNIT"))]
    fn set_code(&mut self, code: u8);
    /// Each word has its own unit and frame.
    #[cfg_attr(any(), micro(is = "UNIT, OP_LINEAR_MIXED"))]
    fn is_mixed(&self) -> bool;
    /// What the flags of a short form would be.
    #[cfg_attr(any(), micro(code = "DO short_flags"))]
    fn short_flags(&self, code: u8) -> u8;
    /// The statement's flags.
    #[cfg_attr(any(), micro(place = "FLAGS"))]
    fn keep_flags(&mut self, flags: u8);
    /// They and an operand say the units and frames of all words.
    #[cfg_attr(any(), micro(code = "CALL linear_mixed"))]
    fn take_frames(&mut self, flags: u8);
    /// The next word's.
    #[cfg_attr(any(), micro(code = "CALL linear_frame; PUT FRAME_OF"))]
    fn next_frame(&mut self);
    /// They say the unit and frame of all words.
    #[cfg_attr(
        any(),
        micro(
            code = "GET FLAGS; DO half; DO half; DO half; ANDI F_STEPS+F_MACHINE+F_RELATIVE; PUT FRAME_OF"
        )
    )]
    fn take_frame_of_all(&mut self);
    /// Where a word's target lies: the new place of the axis.
    ///
    /// # Errors
    /// See [`aim`](super::coords::aim).
    #[cfg_attr(any(), micro(code = "DO aim"))]
    fn aim_word(&mut self, axis: Axis, target: i32) -> Result<(), Fault>;
    /// It is G0.
    #[cfg_attr(any(), micro(any = "FLAGS, FL_RAPID"))]
    fn is_rapid(&self) -> bool;
    /// A host that traces is told, in the end, of a line that begins.
    #[cfg_attr(any(), micro(code = "EVENT {kind}", leaves = 0))]
    fn tell_way(&mut self, kind: TraceKind, value: i32);
    /// These axes set off in a line.
    #[cfg_attr(any(), micro(code = "DO line_begin"))]
    fn begin_line(&mut self, axes: u8);
    /// The same in a rapid move.
    #[cfg_attr(any(), micro(code = "DO line_rapid"))]
    fn begin_rapid(&mut self, axes: u8);
    /// Axes of a rapid move's second line, 0 for none.
    #[cfg_attr(any(), micro(place = "N"))]
    fn second(&self) -> u8;
    /// See [`Lines::second`].
    #[cfg_attr(any(), micro(place = "N"))]
    fn set_second(&mut self, axes: u8);
    /// A rapid move makes two lines of one with Z and another axis.
    #[cfg_attr(
        any(),
        micro(
            code = "F base STORED; FR word PROGRAM_MACHINE+MC_FLAGS, SHORT; TESTI MC_RAPID_Z_APART",
            holds = "NOT_EQUAL"
        )
    )]
    fn wants_z_apart(&self) -> bool;
    /// The axis's switch: [`AxisRecord::HOME_POSITIVE`].
    #[cfg_attr(any(), micro(record = "A_FLAGS"))]
    fn side(&self, axis: Axis) -> u8;
    /// Steps that the axis has to make.
    #[cfg_attr(any(), micro(code = "F load STEPS, AXIS; F sub ACTUAL, AXIS"))]
    fn way_of(&self, axis: Axis) -> i32;
    /// Axes that move.
    #[cfg_attr(any(), micro(place = "MOVING"))]
    fn moving(&self) -> u8;
    /// The statement is done before its line is.
    #[cfg_attr(any(), micro(never = 1))]
    fn is_taken(&self) -> bool;
}

/// A line of a course begins where the one before ends, and is planned while that one moves: small chips have courses,
/// in images that have room for them.
pub trait Courses: Lines {
    /// The line before moves.
    #[cfg_attr(any(), micro(any = "MOVING", when = "HAS_COURSES"))]
    fn is_under_way(&self) -> bool {
        false
    }
    /// The line waits for the last segment of the one before.
    #[cfg_attr(any(), micro(code = "BITS_ON MOTION, M_NEXT"))]
    fn follow(&mut self) {}
    /// Directions that change when it begins.
    #[cfg_attr(any(), micro(place = "NEXT_DIRS"))]
    fn set_next_directions(&mut self, _none: i32) {}
    /// Counts that do.
    #[cfg_attr(any(), micro(place = "NEXT_COUNT+2"))]
    fn set_next_counts(&mut self, _none: i32) {}
    /// The commanded place, steps.
    #[cfg_attr(any(), micro(place = "STEPS"))]
    fn end_of_line(&self, _axis: Axis) -> i32 {
        0
    }
    /// Where the axis is when the line begins.
    #[cfg_attr(any(), micro(place = "ACTUAL"))]
    fn set_start_of_line(&mut self, _axis: Axis, _steps: i32) {}
    /// Events that no segment has taken yet.
    #[cfg_attr(any(), micro(place = "LEFT"))]
    fn left(&self) -> i32 {
        0
    }
    /// See [`Courses::left`].
    #[cfg_attr(any(), micro(place = "LEFT"))]
    fn set_left(&mut self, _events: i32) {}
    /// Segments are made while there is room.
    #[cfg_attr(any(), micro(code = "DO motion_poll", when = "HAS_COURSES"))]
    fn make_segments(&mut self) {}
    /// It ends at speed.
    #[cfg_attr(any(), micro(any = "MOTION, M_THROUGH", when = "HAS_COURSES"))]
    fn ends_at_speed(&self) -> bool {
        false
    }
    /// It waits for its first segment to begin.
    #[cfg_attr(any(), micro(any = "MOTION, M_NEXT"))]
    fn waits_to_begin(&self) -> bool {
        false
    }
}

/// The targets of the axes that the statement names are commanded; those that have steps to make are left.
#[cfg_attr(any(), micro(label = "command_axes"))]
pub fn command_axes(m: &mut impl Together) {
    m.set_going(0);
    for axis in Axis::DOWN {
        if m.is_named(axis) && !m.command_place(axis) {
            m.add_going(axis);
        }
    }
}

/// G0 and G1. A rapid move with Z apart is two lines.
///
/// # Errors
/// Those of the targets: of all axes before any is commanded.
#[cfg_attr(any(), micro(bytes = "FLAGS"))]
pub fn linear(m: &mut impl Courses, code: u8, first: bool) -> Progress {
    if first {
        if m.has_to_wait() {
            return NOT_YET;
        }
        m.set_code(code);
        let flags = if code < RAPID { m.operand() } else { m.short_flags(code) };
        m.keep_flags(flags);
        if m.is_mixed() {
            m.take_frames(flags);
        }
        if m.is_under_way() {
            // From where the line before ends.
            m.follow();
            m.set_next_directions(0);
            m.set_next_counts(0);
            for axis in Axis::DOWN {
                m.set_start_of_line(axis, m.end_of_line(axis));
            }
        }
        m.take_frame_of_all();
        for axis in Axis::DOWN {
            if m.is_mixed() {
                m.next_frame();
            }
            if m.is_named(axis) {
                let target = m.pop();
                m.aim_word(axis, target)?;
            }
        }
        command_axes(m);
        // Targets lie there until here: of a line of a course without a step nothing is left.
        m.set_left(0);
        if m.going() == 0 {
            return DONE;
        }
        if m.is_rapid() {
            m.tell_way(TraceKind::Rapid, 0);
            return rapid(m);
        }
        m.tell_way(TraceKind::Line, 0);
        m.begin_line(m.going());
        m.make_segments();
        return goes_on(m);
    }
    if m.moving() != 0 {
        return goes_on(m);
    }
    let axes = m.second();
    if axes == 0 {
        return DONE;
    }
    m.set_second(0);
    m.begin_rapid(axes);
    NOT_YET
}

/// A line moves: whether its statement is done.
fn goes_on(m: &mut impl Courses) -> Progress {
    if m.is_taken() {
        return DONE;
    }
    // The next line may be planned: all segments are made, and the first one plays.
    if m.ends_at_speed() && !m.waits_to_begin() && m.left() == 0 {
        return DONE;
    }
    NOT_YET
}

/// A rapid move begins: with Z apart Z goes first when it lifts, that is toward its switch, else last.
#[cfg_attr(any(), micro(bytes = "UNIT"))]
fn rapid(m: &mut impl Courses) -> Progress {
    if m.wants_z_apart() && m.going() >= Z_AND_ANOTHER {
        let z = Axis::new(2);
        let side = m.side(z);
        let mut way = m.way_of(z);
        if side & HOME_POSITIVE != 0 {
            way = way.wrapping_neg();
        }
        if way < 0 {
            m.set_second(m.going() & XY);
            m.begin_rapid(Z);
            return NOT_YET;
        }
        m.set_second(Z);
        m.remove_going(z);
    }
    m.begin_rapid(m.going());
    NOT_YET
}
