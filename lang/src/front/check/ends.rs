//! Outputs that a script switches on and that the end of the run switches off in the same instant.

use super::expr::value_of;
use super::{Checker, Code, Span};
use crate::hir::StmtKind;
use crate::plain::Plain;
use crate::profile::SafeState;

/// Outputs that were switched on since the last statement that takes time, with their places.
#[derive(Debug, Default)]
pub(super) struct Lit(Vec<(i32, Span)>);

impl Lit {
    /// Follows one more statement of a block.
    fn follow(&mut self, kind: &StmtKind, span: Span) {
        match kind {
            StmtKind::Plain(Plain::SetOut, values) => {
                let [n, on] = &values[..] else { return self.0.clear() };
                match (value_of(n), value_of(on)) {
                    (Some(n), on) => {
                        self.0.retain(|(lit, _)| *lit != n);
                        self.0.extend((on == Some(1)).then_some((n, span)));
                    }
                    // Any output may be the one.
                    (None, _) => self.0.clear(),
                }
            }
            StmtKind::Print(_) | StmtKind::Assign(..) | StmtKind::End => {}
            _ => self.0.clear(),
        }
    }
}

impl Checker<'_> {
    /// Follows a lowered statement, and warns at a written END. The end of the text is none: one may still be writing.
    pub(super) fn follow_outputs(&mut self, lit: &mut Lit, kinds: &[StmtKind], span: Span) {
        for kind in kinds {
            lit.follow(kind, span);
            if matches!(kind, StmtKind::End) {
                self.warn_of_lit(lit);
            }
        }
    }

    /// The run ends here: warns of the outputs that are on for no time.
    fn warn_of_lit(&mut self, lit: &mut Lit) {
        for (n, span) in lit.0.drain(..) {
            let output = self.profile.outputs.iter().find(|output| output.n == n);
            if output.map(|output| output.end).unwrap_or_default() != SafeState::Off {
                continue;
            }
            let name = output.and_then(|output| output.name.as_deref());
            let name =
                name.map_or_else(|| format!("output {n}"), |name| format!("output {n}, `{name}`,"));
            let message = format!(
                "{name} goes off at once: the run ends here, and its state at the end is off"
            );
            let hint = "wait before END, or write `end = \"keep\"` at the output in the profile";
            self.error(Code::OffAtEnd, span, message, hint);
        }
    }
}
