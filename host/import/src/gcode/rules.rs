//! What becomes of each G and M word.

/// The fate of a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fate {
    /// The language has it.
    Keep,
    /// Left out with a note: it asks for what always holds.
    Idle(&'static str),
    /// Left out with a warning, which the text explains.
    LeaveOut(&'static str),
    /// Written as another word, with a note.
    As(&'static str, &'static str),
    /// Refused: the reason, and what to do.
    Refuse(&'static str, &'static str),
}

use Fate::{As, Idle, Keep, LeaveOut, Refuse};

/// A G word by ten times its number.
pub(super) fn g(tenths: i64) -> Fate {
    match tenths {
        0 | 10 | 20 | 30 | 40 | 170 | 180 | 190 | 200 | 210 | 280 | 382 | 383 | 530 | 610 | 640
        | 400 | 490 | 540 | 911 | 940 | 800 | 810 | 820 | 830 | 900 | 910 | 920 | 980 | 990 => Keep,
        970 => Idle("G97: the spindle's speed is always in turns a minute"),
        611 => As("G61", "G61.1 stops as exactly as G61"),
        410..=429 => Refuse("cutter radius compensation", "let the CAM tool offset the path"),
        430 => {
            LeaveOut("G43: there is no tool table; set Z by SetPos or G92 after each tool change")
        }
        431..=439 => Refuse("a tool length offset from the program", "set Z by SetPos or G92"),
        50..=59 => Refuse("splines", "let the CAM tool draw arcs or short lines"),
        100 => Refuse("G10 sets work offsets", "write SetPos or G92 at the place"),
        300 | 281 | 301 => Refuse("stored positions", "write `G53 G0 X... Y...`"),
        330 => Refuse("spindle-synchronised motion", "there is no spindle encoder"),
        384 | 385 => Refuse("probing away from the work", "G38.2 and G38.3 probe towards it"),
        550..=599 => Refuse("a second work offset", "G54 is the only one; SetPos and G92 set it"),
        730 => As(
            "G83",
            "G73 lifts the drill a little after each peck: written as G83, which lifts it to R",
        ),
        840..=899 => Refuse(
            "this canned cycle",
            "G81, G82 and G83 are known; let the CAM tool write the moves",
        ),
        901 => Refuse(
            "absolute arc centres",
            "let the CAM tool write I and J from the start point (G91.1)",
        ),
        921..=923 => Refuse("this form of G92", "write `SetPos X, ...` or home the axis"),
        930 | 950 => Refuse("this feed mode", "feeds are per minute (G94)"),
        960 => Refuse("constant surface speed", "there is no lathe spindle"),
        _ => Refuse(
            "no such word",
            "known are G0-G4 G17-G21 G28 G38.2 G38.3 G40 G49 G53 G54 G61 G64 G80-G83 G90-G92 G94 G98 G99",
        ),
    }
}

/// Whether a G word, by ten times its number, is of the group of motions: what follows without
/// another of them moves as it says.
pub(super) const fn is_motion(tenths: i64) -> bool {
    matches!(tenths, 0..=30 | 50..=59 | 330 | 380..=389 | 730 | 760 | 800..=899)
}

/// What becomes of M7, M8 and M9 on a machine without an output for them.
pub(super) const NO_COOLANT: Fate = LeaveOut(
    "M7, M8 and M9 switch coolant or air assist, and no output of this machine has the role coolant",
);

/// An M word by its number.
pub(super) fn m(number: i64) -> Fate {
    match number {
        0..=9 | 30 | 62..=65 => Keep,
        48 | 49 => LeaveOut("M48, M49: the speed override is set over the link"),
        60 => As("M0", "M60 changes a pallet: it waits for Start"),
        10 | 11 => LeaveOut("M10, M11: clamps; write SetOut where they are wired"),
        19 => LeaveOut("M19: the spindle cannot be turned to an angle"),
        67 | 68 => Refuse(
            "an analog output",
            "there is none yet: an output that is on or off is M62 or M64",
        ),
        66 => Refuse("waiting for an input of another controller", "write `WaitIn n, ON`"),
        82 | 84 | 104..=107 | 109 | 140 | 190 => {
            Refuse("a 3D printer's word", "there is no extruder here")
        }
        97..=99 => Refuse("subprograms", "unroll them, or write a SUB"),
        _ => Refuse("no such word", "known are M0-M9, M30 and M62-M65"),
    }
}

/// A word that is neither G nor M and that the language has.
pub(super) const fn is_value(letter: char) -> bool {
    matches!(letter, 'X' | 'Y' | 'Z' | 'I' | 'J' | 'K' | 'R' | 'P' | 'Q' | 'L' | 'F' | 'S' | 'T')
}

/// The letter of an axis that other machines have.
pub(super) const fn is_other_axis(letter: char) -> bool {
    matches!(letter, 'A' | 'B' | 'C' | 'U' | 'V' | 'W')
}

/// Why another letter has no meaning.
pub(super) const fn other(letter: char) -> Fate {
    match letter {
        'N' => Idle("line numbers N are left out"),
        _ if is_other_axis(letter) => {
            Refuse("an axis that is not there", "the axes are X, Y and Z")
        }
        'E' => Refuse("a 3D printer's extruder", "there is none here"),
        'D' | 'H' => LeaveOut("D and H name a tool table, which is not here"),
        _ => Refuse("a letter without meaning", "words are G M F S T N X Y Z I J K R P Q L"),
    }
}
