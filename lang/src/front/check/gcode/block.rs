//! One G-code block taken apart: which words it has, before anything is known of its modal state.

use super::super::Checker;
use crate::effect::Plane;
use crate::front::ast::{GValue, GWord};
use crate::front::codes::Code;
use crate::front::diag::Diag;
use crate::front::span::Span;

/// The motion mode: RS274/NGC modal group 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Motion {
    /// G80, and before the first motion word.
    None,
    Rapid,
    Line,
    ArcCw,
    ArcCcw,
    Drill,
    DrillDwell,
    Peck,
}

impl Motion {
    const ALL: [Motion; 8] = [
        Motion::None,
        Motion::Rapid,
        Motion::Line,
        Motion::ArcCw,
        Motion::ArcCcw,
        Motion::Drill,
        Motion::DrillDwell,
        Motion::Peck,
    ];

    pub const fn is_cycle(self) -> bool {
        matches!(self, Motion::Drill | Motion::DrillDwell | Motion::Peck)
    }

    pub const fn is_arc(self) -> bool {
        matches!(self, Motion::ArcCw | Motion::ArcCcw)
    }

    pub const fn word(self) -> &'static str {
        match self {
            Motion::None => "G80",
            Motion::Rapid => "G0",
            Motion::Line => "G1",
            Motion::ArcCw => "G2",
            Motion::ArcCcw => "G3",
            Motion::Drill => "G81",
            Motion::DrillDwell => "G82",
            Motion::Peck => "G83",
        }
    }

    /// By its number in the modal state.
    pub fn from_value(value: i32) -> Motion {
        usize::try_from(value)
            .ok()
            .and_then(|i| Motion::ALL.get(i))
            .copied()
            .unwrap_or(Motion::None)
    }
}

/// What else takes the axis words of a block: modal group 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Special {
    /// G28
    Home,
    /// G92
    Offset,
    /// G38.2, G38.3 (quiet)
    Probe { quiet: bool },
}

/// A block's words.
#[derive(Debug)]
pub(super) struct Block<'a> {
    pub span: Span,
    /// A word of it was wrong: what the others mean is not told.
    pub broken: bool,
    pub motion: Option<Motion>,
    pub plane: Option<Plane>,
    pub inches: Option<bool>,
    pub relative: Option<bool>,
    /// G99, not G98.
    pub retract_r: Option<bool>,
    /// G61, not G64.
    pub exact: Option<bool>,
    pub special: Option<Special>,
    pub dwell: bool,
    /// G53
    pub machine: bool,
    /// G64 stands here: its P is a tolerance.
    pub tolerance: bool,
    /// M words, in the order of execution.
    pub m: Vec<(i64, Span)>,
    pub axes: [Option<&'a GWord>; 3],
    pub offsets: [Option<&'a GWord>; 3],
    pub f: Option<&'a GWord>,
    pub s: Option<&'a GWord>,
    pub t: Option<&'a GWord>,
    pub r: Option<&'a GWord>,
    pub p: Option<&'a GWord>,
    pub q: Option<&'a GWord>,
    pub l: Option<&'a GWord>,
    /// E: an analog output.
    pub e: Option<&'a GWord>,
    /// Q of M67 and M68, which is no word of a cycle then.
    pub level: Option<&'a GWord>,
}

impl<'a> Block<'a> {
    pub fn new(span: Span) -> Block<'a> {
        Block {
            span,
            broken: false,
            motion: None,
            plane: None,
            inches: None,
            relative: None,
            retract_r: None,
            exact: None,
            special: None,
            dwell: false,
            machine: false,
            tolerance: false,
            m: Vec::new(),
            axes: [None; 3],
            offsets: [None; 3],
            f: None,
            s: None,
            t: None,
            r: None,
            p: None,
            q: None,
            l: None,
            e: None,
            level: None,
        }
    }

    /// Whether an axis word stands here.
    pub fn has_axis(&self) -> bool {
        self.axes.iter().any(Option::is_some)
    }

    /// Whether the block asks for a motion of the motion mode, given that mode.
    pub fn moves(&self, motion: Motion) -> bool {
        let centre = motion.is_arc() && self.offsets.iter().any(Option::is_some);
        self.special.is_none() && motion != Motion::None && (self.has_axis() || centre)
    }

    /// M67, M68
    fn sets_aout(&self) -> bool {
        self.m.iter().any(|(m, _)| matches!(m, 67 | 68))
    }

    /// M2, M30
    pub fn ends(&self) -> bool {
        self.m.iter().any(|(m, _)| matches!(m, 2 | 30))
    }
}

/// Sets a value once; a second word of the same modal group is an error.
fn set<T>(checker: &mut Checker<'_>, slot: &mut Option<T>, value: T, word: &GWord) {
    if slot.is_some() {
        let message = "two words of one modal group in a block";
        checker.error(
            Code::GcodeTwice,
            word.span,
            message,
            "write them as two blocks, parted by `:`",
        );
    }
    *slot = Some(value);
}

/// Takes a block apart.
pub(super) fn take_apart<'a>(
    checker: &mut Checker<'a>,
    words: &'a [GWord],
    span: Span,
) -> Block<'a> {
    let mut block = Block::new(span);
    let errors = checker.diags.errors();
    for word in words {
        match word.letter {
            'G' => g_word(checker, &mut block, word),
            'M' => m_word(checker, &mut block, word),
            'N' => {}
            'X' => once(checker, &mut block.axes[0], word),
            'Y' => once(checker, &mut block.axes[1], word),
            'Z' => once(checker, &mut block.axes[2], word),
            'I' => once(checker, &mut block.offsets[0], word),
            'J' => once(checker, &mut block.offsets[1], word),
            'K' => once(checker, &mut block.offsets[2], word),
            'F' => once(checker, &mut block.f, word),
            'S' => once(checker, &mut block.s, word),
            'T' => once(checker, &mut block.t, word),
            'R' => once(checker, &mut block.r, word),
            'P' => once(checker, &mut block.p, word),
            'Q' => once(checker, &mut block.q, word),
            'L' => once(checker, &mut block.l, word),
            'E' => once(checker, &mut block.e, word),
            other => {
                let hint = match other {
                    'A' | 'B' | 'C' | 'U' | 'V' | 'W' => "the axes are X, Y and Z",
                    'D' | 'H' => "there is no tool table: set the work zero by SetPos or G92",
                    _ => "words are G M F S T N X Y Z I J K R P Q L E",
                };
                let message = format!("`{other}` has no meaning here");
                checker.error(Code::GcodeNoMeaning, word.span, message, hint);
            }
        }
    }
    if block.special.is_some()
        && let Some(word) = block.motion.filter(|m| *m != Motion::None)
        && block.has_axis()
    {
        let message = format!("{} and another word want the axis words of this block", word.word());
        checker.error(Code::GcodeTwice, span, message, "write them as two blocks, parted by `:`");
    }
    block.m.sort_by_key(|(m, _)| m_order(*m));
    if block.sets_aout() {
        block.level = block.q.take();
    } else if let Some(e) = block.e {
        let hint = "E is the number of an analog output in M67 and M68";
        checker.error(Code::GcodeNoMeaning, e.span, "E has no meaning in this block", hint);
    }
    block.broken = checker.diags.errors() > errors;
    block
}

fn once<'a>(checker: &mut Checker<'a>, slot: &mut Option<&'a GWord>, word: &'a GWord) {
    if let Some(first) = slot {
        let diag = Diag::new(
            Code::GcodeTwice,
            word.span,
            format!("a second {} in one block", word.letter),
        )
        .label(first.span, "the first")
        .hint("write two blocks, parted by `:`");
        checker.diags.push(diag);
    }
    *slot = Some(word);
}

/// Tenths of a G or M number.
fn number(checker: &mut Checker<'_>, word: &GWord) -> Option<i64> {
    let tenths = match &word.value {
        GValue::Number(number) => number.exact(10).filter(|&n| n >= 0),
        GValue::Expr(_) => None,
    };
    if tenths.is_none() {
        let message = format!("{} needs a plain number", word.letter);
        checker.error(
            Code::GcodeUnknown,
            word.span,
            message,
            "G and M words are not computed: use IF",
        );
    }
    tenths
}

fn g_word(checker: &mut Checker<'_>, block: &mut Block<'_>, word: &GWord) {
    let Some(tenths) = number(checker, word) else { return };
    let motion = |checker: &mut Checker<'_>, block: &mut Block<'_>, motion| {
        set(checker, &mut block.motion, motion, word);
    };
    match tenths {
        0 => motion(checker, block, Motion::Rapid),
        10 => motion(checker, block, Motion::Line),
        20 => motion(checker, block, Motion::ArcCw),
        30 => motion(checker, block, Motion::ArcCcw),
        800 => motion(checker, block, Motion::None),
        810 => motion(checker, block, Motion::Drill),
        820 => motion(checker, block, Motion::DrillDwell),
        830 => motion(checker, block, Motion::Peck),
        40 => block.dwell = true,
        170 => set(checker, &mut block.plane, Plane::Xy, word),
        180 => set(checker, &mut block.plane, Plane::Zx, word),
        190 => set(checker, &mut block.plane, Plane::Yz, word),
        200 => set(checker, &mut block.inches, true, word),
        210 => set(checker, &mut block.inches, false, word),
        280 => set(checker, &mut block.special, Special::Home, word),
        382 => set(checker, &mut block.special, Special::Probe { quiet: false }, word),
        383 => set(checker, &mut block.special, Special::Probe { quiet: true }, word),
        530 => block.machine = true,
        // Harmless: what they ask for always holds.
        540 | 400 | 490 | 940 | 911 => {}
        610 => set(checker, &mut block.exact, true, word),
        640 => {
            set(checker, &mut block.exact, false, word);
            block.tolerance = true;
        }
        900 => set(checker, &mut block.relative, false, word),
        910 => set(checker, &mut block.relative, true, word),
        920 => set(checker, &mut block.special, Special::Offset, word),
        980 => set(checker, &mut block.retract_r, false, word),
        990 => set(checker, &mut block.retract_r, true, word),
        _ => {
            let hint = match tenths {
                50..=59 => "draw curves as arcs or short lines",
                410..=429 => "there is no tool radius compensation: offset the path beforehand",
                430..=439 => "there is no tool table: set the tool's length by SetPos Z or G92",
                550..=599 => "G54 is the only work offset; SetPos and G92 set it",
                100 => "work offsets are set by SetPos and G92",
                901 => "I J K are offsets from the start point (G91.1)",
                921..=923 => "write `SetPos X, ...` or home the axis",
                730 | 840..=899 => "the canned cycles are G81, G82 and G83",
                930 | 950 | 960 | 970 => "feeds are per minute (G94)",
                300 => "write `G53 G0 X... Y...`",
                _ => {
                    "known are G0-G4 G17-G21 G28 G38.2 G38.3 G40 G49 G53 G54 G61 G64 G80-G83 G90-G92 G94 G98 G99"
                }
            };
            let text = word.span.of(checker.text).to_owned();
            checker.error(
                Code::GcodeUnknown,
                word.span,
                format!("`{text}` is not supported"),
                hint,
            );
        }
    }
}

/// Order of execution (RS274/NGC 3.8): tool, spindle, coolant, then stops.
fn m_order(m: i64) -> u8 {
    match m {
        6 => 0,
        3..=5 => 1,
        7..=9 => 2,
        62..=65 | 67 | 68 => 3,
        _ => 4,
    }
}

fn m_word(checker: &mut Checker<'_>, block: &mut Block<'_>, word: &GWord) {
    let Some(tenths) = number(checker, word) else { return };
    let m = tenths / 10;
    if tenths % 10 != 0 || !matches!(m, 0..=9 | 30 | 62..=65 | 67 | 68) {
        let hint = match m {
            98 | 99 => "subprograms are SUBs: `SUB name ... END SUB`, called by name",
            48 | 49 => "the override is set over the link",
            _ => "known are M0-M9, M30, M62-M65, M67 and M68",
        };
        let text = word.span.of(checker.text).to_owned();
        let message = format!("`{text}` is not supported");
        checker.error(Code::GcodeUnknown, word.span, message, hint);
        return;
    }
    // M7 and M8 may stand together; otherwise one word of each group.
    let group = |m: i64| match m {
        7 => 7,
        8 => 8,
        _ => 10 + i64::from(m_order(m)),
    };
    if block.m.iter().any(|(other, _)| group(*other) == group(m)) {
        let message = "two words of one modal group in a block";
        checker.error(
            Code::GcodeTwice,
            word.span,
            message,
            "write them as two blocks, parted by `:`",
        );
    }
    block.m.push((m, word.span));
}
