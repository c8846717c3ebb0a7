//! Habits of other languages that one token does not show: what stands before and after it does.

use super::State;
use crate::front::codes::Code;
use crate::front::diag::Diag;
use crate::front::span::Span;
use crate::front::token::{Sign, Tok};
use crate::front::words::Kw;

/// The hint for `2"`.
pub(super) const INCHES: &str = "inches are written `in`, as in `2in`";

impl State<'_> {
    /// Whether a digit stands directly before a place.
    pub(super) fn digit_before(&self, span: Span) -> bool {
        let before = self.text.as_bytes().get(..span.start as usize);
        before.and_then(<[u8]>::last).is_some_and(u8::is_ascii_digit)
    }

    /// Whether a digit stands directly after a place.
    pub(super) fn digit_after(&self, span: Span) -> bool {
        self.text.as_bytes().get(span.end as usize).is_some_and(u8::is_ascii_digit)
    }

    /// Whether a sign stands beside a text in a PRINT, as `&` does that joins texts elsewhere.
    pub(super) fn joins_texts(&self, rest: &str) -> bool {
        let ends = |tok: &Tok| matches!(tok, Tok::LineEnd | Tok::Label | Tok::Sign(Sign::Colon));
        let statement = self.tokens.rsplit(|token| ends(&token.tok)).next().unwrap_or(&[]);
        let prints = statement.iter().any(|token| token.tok == Tok::Kw(Kw::Print));
        let text = statement.last().is_some_and(|token| token.tok == Tok::Text);
        prints && (text || rest.trim_start().starts_with('"'))
    }

    /// Reports `n += 2` and `n++` as the assignment that they stand for. `false` where no name at the
    /// start of a statement stands before the sign.
    pub(super) fn assigns(&mut self, span: Span, rest: &str) -> bool {
        let (name, before) = match self.tokens[..] {
            [.., before, name] => (name, Some(before.tok)),
            [name] => (name, None),
            [] => return false,
        };
        let begins =
            matches!(before, None | Some(Tok::LineEnd | Tok::Label | Tok::Sign(Sign::Colon)));
        if name.tok != Tok::Name || !begins {
            return false;
        }
        let target = name.span.of(self.text);
        let sign = span.of(self.text);
        let end = rest.find(['\r', '\n', ':', '\'']).unwrap_or(rest.len());
        let line = rest[..end].trim_end();
        let value = line.trim_start();
        let one = value.chars().all(|c| c.is_ascii_alphanumeric() || "_.()".contains(c));
        let value = match sign {
            "++" if value.is_empty() => "1".to_owned(),
            "++" => return false,
            _ if value.is_empty() => return false,
            "+=" => value.to_owned(),
            _ if one => value.to_owned(),
            _ => format!("({value})"),
        };
        let operator = sign.get(..1).unwrap_or("+");
        let instead = format!("{target} = {target} {operator} {value}");
        let whole = Span::new(name.span.start, span.end + line.len() as u32);
        let diag = Diag::new(Code::ForeignOperator, span, format!("`{sign}` is no operator here"))
            .hint(format!("write `{instead}`"))
            .fix(whole, instead);
        self.diags.push(diag);
        self.push(Tok::Bad, span);
        true
    }
}
