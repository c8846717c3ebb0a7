//! Lines of a program that have an effect: before these a board halts.

use std::collections::BTreeSet;

use lang::back::{Compiled, disasm};
use lang::image::Image;
use lang::isa::{Class, Op};

/// Lines with an effect, ascending.
pub fn with_effects(compiled: &Compiled) -> Vec<u32> {
    let code = Image::new(&compiled.image).map(|image| disasm::instructions(&image));
    let effects = code.unwrap_or_default().into_iter().filter(|insn| {
        Op::decode(insn.bytes[0]).is_some_and(|(op, _)| op.row().class == Class::Effect)
    });
    let lines: BTreeSet<u32> =
        effects.filter_map(|insn| compiled.sidecar.at(insn.pc).map(|mark| mark.line)).collect();
    lines.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use lang::front::ProfileChoice;

    use super::with_effects;
    use crate::trial::load;

    #[test]
    fn comments_assignments_and_conditions_have_none() {
        let text = "' a comment\nDIM n\nn = 1\nIF n = 1 THEN\n  PRINT n\nEND IF\nMoveAxe X, 1mm\n";
        let loaded = load(text, ProfileChoice::built_in()).expect("it compiles");
        assert_eq!(with_effects(&loaded.compiled), [5, 7]);
    }
}
