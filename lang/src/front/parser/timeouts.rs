//! Timeouts without a check of TIMEDOUT, and a TIMEDOUT that nothing sets.

use crate::front::codes::Code;
use crate::front::diag::{Diag, Diags};
use crate::front::token::{Tok, Token};
use crate::front::words::{Func, Kw};

/// What tells a program how a wait ended, beside TIMEDOUT.
const LOOKS: [Func; 3] = [Func::In, Func::InPort, Func::CharIn];

/// Warns of both; `timed_waits`: a WAIT UNTIL sets TIMEDOUT.
pub fn look(tokens: &[Token], timed_waits: bool, diags: &mut Diags) {
    let quiet = tokens.iter().find(|t| matches!(t.tok, Tok::Quiet(Kw::WaitIn | Kw::WaitChar)));
    let read = tokens.iter().find(|t| t.tok == Tok::Func(Func::TimedOut));
    let looked = tokens.iter().any(|t| matches!(t.tok, Tok::Func(func) if LOOKS.contains(&func)));
    match (quiet, read) {
        (None, Some(read)) if !timed_waits => diags.push(
            Diag::new(Code::Unnoticed, read.span, "nothing in this script sets `TIMEDOUT`")
                .hint("`WaitIn` without `?` ends in F13 when its time is up; write `WaitIn?`"),
        ),
        (Some(quiet), None) if !looked => diags.push(
            Diag::new(Code::Unnoticed, quiet.span, "nothing notices that the time is up")
                .hint("test `TIMEDOUT` after it, or leave out the `?`: then F13 tells"),
        ),
        _ => {}
    }
}
