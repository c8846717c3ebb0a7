//! Values of G-code words, and the modal state that they ask for.

use super::modal::{self, Group, State};
use crate::axis::Axis;
use crate::effect::Frame;
use crate::front::ast::{GValue, GWord};
use crate::front::check::expr::{number, value_of};
use crate::front::check::{Checker, kinds, range};
use crate::front::codes::Code;
use crate::front::diag::Diag;
use crate::front::span::Span;
use crate::hir::{self, BinOp, Word};
use crate::kind::Kind;

/// um of a millimetre and of an inch.
const UM: [u32; 2] = [1000, 25_400];

/// A block with the state that holds in it.
pub(super) struct Context {
    /// What reaches the block, with the block's own words applied.
    pub state: State,
    /// The block.
    pub span: Span,
    /// Its line.
    pub line: u32,
}

impl<'a> Checker<'a> {
    /// The value of a group, where the block depends on it; an error where that is not one value.
    pub(super) fn modal(&mut self, context: &Context, group: Group) -> Option<i32> {
        let value = context.state.get(group);
        match value.single() {
            Some(value) if value >= 0 => return Some(value),
            _ => {}
        }
        let (what, words) = modal::describe(group);
        let Some([low, high]) = value.written else { return Some(0) };
        let mut diag = if low.0 == modal::UNSET && high.0 == modal::UNSET {
            let message =
                format!("no word says {what} here: a handler starts with no G-code state");
            Diag::new(Code::GcodeHandler, context.span, message)
                .hint(format!("write {words} in this block"))
        } else {
            let message = format!("{what} is not the same on all ways to this block");
            Diag::new(Code::GcodeConflict, context.span, message)
                .hint(format!("write {words} here"))
        };
        let places = if low == high { &[low][..] } else { &[low, high] };
        for &(value, place) in places {
            let word = modal::word(group, value);
            if place == Span::default() {
                diag = diag.label(Span::point(0), format!("{word} from the start of the script"));
            } else if value == modal::UNSET {
                diag = diag.label(place, "a handler begins from here, without any state");
            } else {
                diag = diag.label(place, format!("{word} comes from here"));
            }
        }
        self.diags.push(diag);
        None
    }

    fn units(&mut self, context: &Context) -> Option<u32> {
        let units = self.modal(context, Group::Units)?;
        Some(UM[usize::from(units == 1)])
    }

    /// A coordinate or distance: a Length, or Steps.
    pub(super) fn distance_word(
        &mut self,
        word: &'a GWord,
        context: &Context,
        relative: bool,
    ) -> Option<hir::Expr> {
        match &word.value {
            GValue::Number(decimal) if decimal.sign() == 0 => {
                Some(number(0, Kind::Length, word.span))
            }
            GValue::Number(decimal) => {
                let um = self.units(context)?;
                let Some((value, exact)) = decimal.scaled(um, 1) else {
                    return self.too_large(word);
                };
                let Ok(value) = i32::try_from(value) else { return self.too_large(word) };
                if relative && !exact {
                    let message = format!("{value}um is not exactly what stands here");
                    let hint =
                        "relative words add up their rounding: write G90, or whole micrometres";
                    self.error(Code::GcodeInexact, word.span, message, hint);
                }
                Some(number(value, Kind::Length, word.span))
            }
            GValue::Expr(e) => {
                let value = self.expr(e)?;
                match value.kind {
                    Kind::Length | Kind::Steps => Some(value),
                    kind if kinds::is_plain(kind) => {
                        let um = self.units(context)?;
                        let factor = number(um as i32, Kind::Length, word.span);
                        self.make_binary(BinOp::Mul, Kind::Length, value, factor, word.span)
                    }
                    kind => {
                        let message = format!(
                            "{} needs a Length, Steps or a Number, this is {}",
                            word.letter,
                            kinds::a(kind)
                        );
                        self.error(
                            Code::ArgumentKind,
                            e.span,
                            message,
                            "write a value like `[5mm]`",
                        );
                        None
                    }
                }
            }
        }
    }

    pub(in crate::front::check) fn too_large<T>(&mut self, word: &GWord) -> Option<T> {
        let message = "this value does not fit in 32 bits";
        self.error(Code::GcodeRange, word.span, message, "the greatest length is 2147mm");
        None
    }

    /// An axis word with its frame.
    pub(super) fn axis_word(
        &mut self,
        axis: Axis,
        word: &'a GWord,
        context: &Context,
        machine: bool,
    ) -> Option<Word> {
        if !self.has_axis(axis, word.span) {
            return None;
        }
        let frame = if machine { Some(Frame::Machine) } else { self.frame(context) };
        let value = self.distance_word(word, context, frame == Some(Frame::Relative))?;
        let frame = frame?;
        self.note_target(axis, &value, frame, word.span);
        Some(Word { value, frame })
    }

    /// G90 or G91.
    pub(super) fn frame(&mut self, context: &Context) -> Option<Frame> {
        let relative = self.modal(context, Group::Distance)?;
        Some(if relative == 1 { Frame::Relative } else { Frame::Work })
    }

    /// F: a Number per minute in the active unit, a Speed or a StepRate.
    pub(super) fn feed_word(&mut self, word: &'a GWord, context: &Context) -> Option<hir::Expr> {
        const MINUTE: u32 = 60;
        match &word.value {
            GValue::Number(decimal) => {
                let um = self.units(context)?;
                let Some((value, _)) = decimal.scaled(um, MINUTE) else {
                    return self.too_large(word);
                };
                let value = if value == 0 { i64::from(decimal.sign()) } else { value };
                let Ok(value) = i32::try_from(value) else { return self.too_large(word) };
                Some(number(value, Kind::Speed, word.span))
            }
            GValue::Expr(e) => {
                let value = self.expr(e)?;
                match value.kind {
                    Kind::Speed | Kind::StepRate => Some(value),
                    kind if kinds::is_plain(kind) => {
                        // n * um / 60 rounded half away from zero: (n * um / 10 + 3) / 6. A feed
                        // that is not positive faults either way.
                        let um = self.units(context)?;
                        let span = word.span;
                        let factor = number((um / 10) as i32, Kind::Number, span);
                        let value =
                            self.make_binary(BinOp::Mul, Kind::Number, value, factor, span)?;
                        let half = number(3, Kind::Number, span);
                        let value =
                            self.make_binary(BinOp::Add, Kind::Number, value, half, span)?;
                        let six = number(6, Kind::Number, span);
                        self.make_binary(BinOp::Div, Kind::Speed, value, six, span)
                    }
                    kind => {
                        let message = format!(
                            "F needs a Number, a Speed or a StepRate, this is {}",
                            kinds::a(kind)
                        );
                        self.error(
                            Code::ArgumentKind,
                            e.span,
                            message,
                            "write `F300` or `F[25mm/s]`",
                        );
                        None
                    }
                }
            }
        }
    }

    /// P of G4 and G82: seconds, or a Time.
    pub(super) fn seconds_word(&mut self, word: &'a GWord) -> Option<hir::Expr> {
        const MS: u32 = 1000;
        let value = match &word.value {
            GValue::Number(decimal) => {
                let ms = decimal.scaled(MS, 1).and_then(|(ms, _)| i32::try_from(ms).ok());
                let Some(ms) = ms else { return self.too_large(word) };
                number(ms, Kind::Time, word.span)
            }
            GValue::Expr(e) => {
                let value = self.expr(e)?;
                match value.kind {
                    Kind::Time => value,
                    kind if kinds::is_plain(kind) => {
                        let factor = number(MS as i32, Kind::Time, word.span);
                        self.make_binary(BinOp::Mul, Kind::Time, value, factor, word.span)?
                    }
                    kind => {
                        let message =
                            format!("P needs seconds or a Time, this is {}", kinds::a(kind));
                        self.error(
                            Code::ArgumentKind,
                            e.span,
                            message,
                            "write `P0.5` or `P[500ms]`",
                        );
                        return None;
                    }
                }
            }
        };
        self.check_time(&value, word.span, 0);
        Some(value)
    }

    /// S, L: a whole Number.
    pub(in crate::front::check) fn number_word(&mut self, word: &'a GWord) -> Option<hir::Expr> {
        match &word.value {
            GValue::Number(decimal) => {
                let value = decimal.scaled(1, 1).and_then(|(v, _)| i32::try_from(v).ok());
                let Some(value) = value else { return self.too_large(word) };
                Some(number(value, Kind::Number, word.span))
            }
            GValue::Expr(e) => self.plain(e, &word.letter.to_string()),
        }
    }

    /// A variable as a value.
    pub(super) fn variable(&self, var: hir::VarId, span: Span) -> hir::Expr {
        let kind = self.vars[var.0 as usize].kind;
        hir::Expr { kind, span: range(span), node: hir::ExprKind::Var(var) }
    }

    /// A constant that is not above 0 where only such make sense.
    pub(super) fn positive(&mut self, value: &hir::Expr, word: &GWord) -> Option<()> {
        if value_of(value).is_none_or(|v| v > 0) {
            return Some(());
        }
        let message = format!("{} must be above 0", word.letter);
        self.error(Code::GcodeRange, word.span, message, "give a positive value");
        None
    }
}
