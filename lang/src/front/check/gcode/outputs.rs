//! M62 to M65, M67 and M68: outputs, at once or on the way.

use super::block::Block;
use crate::effect::ActKind;
use crate::front::check::Checker;
use crate::front::check::expr::{number, value_of};
use crate::front::codes::Code;
use crate::front::span::Span;
use crate::hir::{Expr, StmtKind, Sync};
use crate::kind::Kind;
use crate::plain::Plain;

/// Where the next block begins.
fn on_the_way(kind: ActKind, n: Expr, value: Expr, span: Span) -> StmtKind {
    let lead = number(0, Kind::Length, span);
    StmtKind::Sync(Box::new(Sync { n, value, kind, lead }))
}

impl<'a> Checker<'a> {
    /// M62 to M65: P is the number of the output; the first two act on the way.
    pub(super) fn numbered(&mut self, m: i64, block: &Block<'a>, span: Span) -> Option<StmtKind> {
        let Some(word) = block.p.filter(|_| !block.dwell) else {
            let message = format!("M{m} without the number of its output");
            let hint = format!("write `M{m} P1`, a block of its own");
            self.error(Code::GcodeMissing, span, message, hint);
            return None;
        };
        let n = self.number_word(word)?;
        if let Some(known) = value_of(&n)
            && !self.check_port(true, known, word.span)
        {
            return None;
        }
        if !self.settable(&n, word.span) {
            return None;
        }
        let value = number(i32::from(m % 2 == 0), Kind::Truth, span);
        if m >= 64 {
            return Some(StmtKind::Plain(Plain::SetOut, vec![n, value]));
        }
        Some(on_the_way(ActKind::Set, n, value, span))
    }

    /// M67 and M68: E is the number of the analog output, Q its value; the first acts on the way.
    pub(super) fn analog_output(
        &mut self,
        m: i64,
        block: &Block<'a>,
        span: Span,
    ) -> Option<StmtKind> {
        let (Some(e), Some(q)) = (block.e, block.level) else {
            let what =
                if block.e.is_none() { "number of its output" } else { "value of its output" };
            let message = format!("M{m} without the {what}");
            let hint = format!("write `M{m} E1 Q1.5`: output 1, 1.5 V or steps of its share");
            self.error(Code::GcodeMissing, span, message, hint);
            return None;
        };
        let (n, value) = self.aout_words(e, q)?;
        Some(match m {
            67 => on_the_way(ActKind::Analog, n, value, span),
            _ => StmtKind::SetAout(n, value),
        })
    }
}
