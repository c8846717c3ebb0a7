//! How late the handlers of a streamed job are.

use lang::hir::{ExprKind, Program, Stmt, StmtKind};

use super::cut::inside;

/// From an event that can be served to the first statement of its handler at most, ms, over a link of
/// `rate` bits a second: a look at the board, what is on its way, and the handler's first piece take some
/// 400 characters, and the input's filter and the board's check are in it (`pasapas bench stream`).
pub fn handler_ms(rate: u32) -> u32 {
    25 + 400 * 10_000 / rate.max(1)
}

/// The first ON EVERY whose ticks come faster than handlers can, its line and its period, ms.
pub fn too_fast(program: &Program, handler_ms: u32) -> Option<(u32, i32)> {
    program
        .routines
        .iter()
        .flat_map(|routine| &routine.body)
        .find_map(|stmt| fast(stmt, handler_ms))
}

/// Blocks nest at most as deep as the parser lets them.
fn fast(stmt: &Stmt, handler_ms: u32) -> Option<(u32, i32)> {
    if let StmtKind::OnEvery { every, .. } = &stmt.kind
        && let ExprKind::Const(ms) = every.node
        && i64::from(ms) < i64::from(handler_ms)
    {
        return Some((stmt.line, ms));
    }
    inside(stmt).into_iter().flatten().find_map(|stmt| fast(stmt, handler_ms))
}

#[cfg(test)]
mod tests {
    use super::{handler_ms, too_fast};
    use lang::front::source::Source;
    use lang::front::{ProfileChoice, compile};

    #[test]
    fn ticks_that_leave_no_time_are_found() {
        assert_eq!([115_200, 9600].map(handler_ms), [59, 441]);
        let text = "Wait 1s\nIF IN(1) THEN\nON EVERY 50ms GOSUB tick\nEND IF\n\
            SUB tick\nSend 65\nEND SUB\n";
        let source = Source::new("a.bas", text.to_owned());
        let program = compile(&source, ProfileChoice::built_in()).0.expect("a program");
        assert_eq!(too_fast(&program, 59), Some((3, 50)));
        assert_eq!(too_fast(&program, 50), None);
    }
}
