//! The machine's own operations and those of formulas.
//!
//! A row is `Name "number's name" "NOTATION" [operands] takes gives flags needs sets next "what"`, in the order of the
//! numbers: a row in another place is another number, and another image.

use super::Flags::{Are, Kept};
use super::Operand::{Byte, Jump, Number, Places, Power, Word, Wrapped};
use super::{Flags, Gives, Next, Operand, Row, Takes};

macro_rules! own {
    ($($op:ident $name:literal $notation:literal $label:literal [$($operand:expr),*] $takes:ident $gives:ident $flags:expr,
        $needs:literal $sets:literal $next:ident $means:literal;)*) => {
        /// An operation of the machine's own.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Own { $(#[doc = $means] $op,)* }

        impl Own {
            /// All of them in the order of their numbers.
            pub const ALL: &'static [Own] = &[$(Own::$op,)*];
        }

        /// The machine's own operations, in the order of their numbers.
        pub const OWN: &[Row] = &[$(Row {
            name: $name,
            notation: if $notation.is_empty() { None } else { Some($notation) },
            label: $label,
            operands: &[$($operand),*],
            takes: Takes::$takes,
            gives: Gives::$gives,
            flags: $flags,
            needs: $needs,
            sets: $sets,
            next: Next::$next,
            means: $means,
        },)*];
    };
}

const OFF: Flags = Are("");

own! {
    Call "micro_call" "CALL" "micro_call" [Operand::Routine] Nothing Kept OFF, "" "" On "calls a routine that has no number";
    End "micro_end" "END" "micro_end" [] Nothing Kept Kept, "" "" Instructions "instructions go on, at an even place";
    Return "micro_return" "RETURN" "micro_return" [] Nothing Kept Kept, "" "" Returns "the routine ends";
    Done "micro_done" "DONE_" "micro_done" [] Nothing Low Kept, "" "" Returns "r12 = DONE, the routine ends";
    NotYet "micro_not_yet" "NOT_YET_" "micro_not_yet" [] Nothing Low Kept, "" "" Returns "r12 = NOT_YET, the routine ends";
    Fault "micro_fault" "FAULT" "micro_fault" [Number] Nothing Low Kept, "" "" Returns "r12 = FAULTED + n, the routine ends";
    Literal "micro_literal" "" "micro_literal" [Number] Nothing Long OFF, "" "" On "acc = n (LIT, 0 of which is DO zero)";
    Word16 "micro_word" "LIT16" "micro_word" [Word] Nothing Low OFF, "" "" On "r12 = n; r13 is kept";
    Profile "micro_profile" "PROFILE" "micro_profile" [Number] Nothing Low Are("Z"), "" "" On "r12 = this byte of the board's profile, with its flags; r13 is kept";
    AddI "micro_addi" "ADDI" "micro_addi" [Wrapped] Low Low Are("ZNCV"), "" "" On "r12 = its low byte + n, modulo 256";
    AndI "micro_andi" "ANDI" "micro_andi" [Number] Low Low Are("ZNCV"), "" "" On "r12 = its low byte & n";
    TestI "micro_testi" "TESTI" "micro_testi" [Number] Low Kept Are("ZNCV"), "" "" On "flags of r12 & n";
    Goto "micro_goto" "GOTO" "micro_goto" [Jump] Nothing Kept Kept, "" "" Goto "goes on there";
    Switch "micro_switch" "" "micro_switch" [Places] Low Kept Kept, "" "" Goto "on with the r12th of the places that follow, from 0: a byte each as of a jump";
    IfEqual "micro_if_equal" "IF_EQUAL" "micro_if_equal" [Jump] Nothing Kept OFF, "" "" If "if Z is set";
    IfNotEqual "micro_if_not_equal" "IF_NOT_EQUAL" "micro_if_not_equal" [Jump] Nothing Kept OFF, "" "" If "if Z is clear";
    IfCarry "micro_if_carry" "IF_CARRY" "micro_if_carry" [Jump] Nothing Kept OFF, "" "" If "if C is set";
    IfNegative "micro_if_negative" "IF_NEGATIVE" "micro_if_negative" [Jump] Nothing Kept OFF, "" "" If "if N is set";
    IfNotNegative "micro_if_not_negative" "IF_NOT_NEGATIVE" "micro_if_not_negative" [Jump] Nothing Kept OFF, "" "" If "if N is clear";
    IfOverflow "micro_if_overflow" "IF_OVERFLOW" "micro_if_overflow" [Jump] Nothing Kept OFF, "" "" If "if V is set";
    FirstAxis "micro_first_axis" "" "micro_first_axis" [] Nothing Kept OFF, "" "a" On "the next axes are r8 = 8 = 4 * Z down to 0";
    NextAxis "micro_next_axis" "NEXT_AXIS" "micro_next_axis" [Jump] Nothing Kept OFF, "a" "" If "while there is another axis, r8 = 8, 4, 0";
    UpAxis "micro_up_axis" "UP_AXIS" "micro_up_axis" [Jump] Nothing Kept OFF, "a" "" If "the same upward from X";
    OrReturn "or_return" "" "micro_or_return" [] Low Kept Are("Z"), "" "" OnOrReturn "returns a fault in r12, goes on with 0";
    Wanted "micro_wanted" "WANTED" "micro_wanted" [] Nothing Kept OFF, "" "" OnOrReturn "returns EX_ILLEGAL_VALUE unless Z is clear";
    ZeroIfCarry "zero_if_carry" "" "micro_zero_if_carry" [] Long Long OFF, "" "" On "acc = 0 when C is set";
    TestLong "test_long" "" "micro_test_long" [] Long Kept Are("Z"), "" "" On "Z of acc as a whole";
    Half "half" "" "micro_half" [] Low Low Are("ZNC"), "" "" On "r12 = half of it, rounded down; C = the bit that dropped";
    Below "micro_below" "BELOW" "micro_below" [Number] Low Kept OFF, "" "" OnOrReturn "returns EX_ILLEGAL_VALUE unless r12 < n";
    CmpI "micro_cmpi" "CMPI" "micro_cmpi" [Number] Low Kept Are("ZNCV"), "" "" On "flags of r12 - n";
    Case "micro_case" "CASE" "micro_case" [Number, Jump] Low Kept OFF, "" "" If "if r12 is n";
    CaseNot "micro_case_not" "CASE_NOT" "micro_case_not" [Number, Jump] Low Kept OFF, "" "" If "if it is not";
    Shift "micro_shift" "SHIFT" "micro_shift" [Power] Long Long OFF, "" "" On "scaled acc * 2^n";
    Get "micro_get" "GET" "micro_get" [Byte] Nothing Long OFF, "" "" On "acc = v";
    Put "micro_put" "PUT" "micro_put" [Byte] Low Kept OFF, "" "" On "v = r12";
    Let "micro_let" "LET" "micro_let" [Byte, Number] Nothing Kept OFF, "" "" On "v = n";
    BitsOn "micro_bits_on" "BITS_ON" "micro_bits_on" [Byte, Number] Nothing Kept OFF, "" "" On "v |= n";
    BitsOff "micro_bits_off" "BITS_OFF" "micro_bits_off" [Byte, Number] Nothing Kept OFF, "" "" On "v &= ~n";
    Compare "micro_compare" "COMPARE" "micro_compare" [Byte] Low Kept Are("ZNCV"), "" "" On "flags of r12 - v";
    Up "micro_up" "UP" "micro_up" [Byte] Nothing Kept Are("ZNCV"), "" "" On "v += 1";
    IfNotAxis "micro_if_not_axis" "IF_NOT_AXIS" "micro_if_not_axis" [Byte, Jump] Nothing Kept OFF, "a" "" If "if the bit of axis r8 is not set in v";
    AxisOn "micro_axis_on" "AXIS_ON" "micro_axis_on" [Byte] Low Kept OFF, "" "" On "v |= r12";
    AxisOff "micro_axis_off" "AXIS_OFF" "micro_axis_off" [Byte] Low Kept OFF, "" "" On "v &= ~r12";
    IfZero "micro_if_zero" "IF_ZERO" "micro_if_zero" [Byte, Jump] Nothing Kept OFF, "" "" If "if v is 0";
    IfSet "micro_if_set" "IF_SET" "micro_if_set" [Byte, Jump] Nothing Kept OFF, "" "" If "if v is not 0";
    IfAny "micro_if_any" "IF_ANY" "micro_if_any" [Byte, Number, Jump] Nothing Kept OFF, "" "" If "if a bit of n is set in v";
    IfNone "micro_if_none" "IF_NONE" "micro_if_none" [Byte, Number, Jump] Nothing Kept OFF, "" "" If "if none is";
    IfIs "micro_if_is" "IF_IS" "micro_if_is" [Byte, Number, Jump] Nothing Kept OFF, "" "" If "if v is n";
    IfIsNot "micro_if_is_not" "IF_IS_NOT" "micro_if_is_not" [Byte, Number, Jump] Nothing Kept OFF, "" "" If "if v is not n";
}

impl Own {
    /// The first of those whose byte the machine has taken before it begins them.
    pub const FIRST_WITH_BYTE: &'static str = "micro_below";

    /// The flag that a jump looks at, and whether it wants it set.
    #[must_use]
    pub const fn looks_at(self) -> Option<(char, bool)> {
        Some(match self {
            Own::IfEqual => ('Z', true),
            Own::IfNotEqual | Own::Wanted => ('Z', false),
            Own::IfCarry | Own::ZeroIfCarry => ('C', true),
            Own::IfNegative => ('N', true),
            Own::IfNotNegative => ('N', false),
            Own::IfOverflow => ('V', true),
            _ => return None,
        })
    }
}

macro_rules! formulas {
    ($($op:ident $name:literal $label:literal $takes:ident $gives:ident $flags:literal $sets:literal $means:literal;)*) => {
        /// What a formula does with the word x that its operand names.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Formula { $(#[doc = $means] $op,)* }

        impl Formula {
            /// All of them in the order of their numbers.
            pub const ALL: &'static [Formula] = &[$(Formula::$op,)*];
        }

        /// Formulas in the order of their numbers.
        pub const FORMULAS: &[Row] = &[$(Row {
            name: $name,
            notation: None,
            label: $label,
            operands: &[Number],
            takes: Takes::$takes,
            gives: Gives::$gives,
            flags: Are($flags),
            needs: "",
            sets: $sets,
            next: Next::On,
            means: $means,
        },)*];
    };
}

formulas! {
    Load "load" "formula_load" Nothing Long "N" "" "acc = x";
    Store "store" "formula_store" Long Kept "" "" "x = acc";
    Plus "plus" "pasapas_scaled_plus" Long Long "" "" "scaled acc + x";
    Minus "minus" "pasapas_scaled_minus" Long Long "" "" "scaled acc - x, or 0";
    Times "times" "pasapas_scaled_times" Long Long "" "" "scaled acc * x";
    Over "over" "pasapas_scaled_over" Long Long "" "" "scaled acc / x";
    Least "least" "pasapas_scaled_min" Long Long "" "" "the smaller of acc and x";
    Most "most" "pasapas_scaled_max" Long Long "" "" "the larger of acc and x";
    Add "add" "formula_add" Long Long "NCV" "" "acc + x";
    Sub "sub" "formula_sub" Long Long "NCV" "" "acc - x";
    Word "word" "formula_word" Nothing Low "ZN" "" "r12 = the word x, with its flags";
    Put "put" "formula_put" Low Kept "" "" "the word x = r12";
    Cmp "cmp" "micro_cmpi" Low Kept "ZNCV" "" "flags of r12 - the word x";
    Clear "clear" "formula_clear" Nothing Kept "" "" "the word x = 0";
    Base "base" "formula_base" Nothing Kept "" "r" "r9 = the word x";
    Bound "bound" "formula_bound" Long Long "" "" "x and acc = the smaller scaled one";
}

impl Formula {
    /// Whether it looks at one word of RAM, not at two.
    #[must_use]
    pub const fn is_word(self) -> bool {
        matches!(self, Formula::Word | Formula::Put | Formula::Cmp | Formula::Clear | Formula::Base)
    }

    /// Whether it writes x.
    #[must_use]
    pub const fn writes(self) -> bool {
        matches!(self, Formula::Store | Formula::Put | Formula::Clear | Formula::Bound)
    }

    /// Whether it reads x.
    #[must_use]
    pub const fn reads(self) -> bool {
        !matches!(self, Formula::Store | Formula::Put | Formula::Clear)
    }

    /// Whether x may be an integer that is made a scaled number first.
    #[must_use]
    pub const fn takes_new(self) -> bool {
        !self.is_word() && !self.writes()
    }
}
