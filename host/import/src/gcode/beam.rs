//! A laser's beam, where S cannot be its power.

use super::read::{Block, Reader, Value};

impl Reader<'_, '_> {
    /// A laser without power is off: where S is not its power M3 and M5 follow S.
    pub(super) fn beam(&mut self, block: &mut Block<'_>) {
        if self.graded {
            // Before any S a laser has no power, where a script's laser has all of it.
            let starts = block
                .words
                .iter()
                .any(|(letter, value)| *letter == 'M' && matches!(value, Value::Text("3" | "4")));
            self.state.powered |= block.words.iter().any(|(letter, _)| *letter == 'S');
            if starts && !core::mem::replace(&mut self.state.powered, true) {
                block.words.push(('S', Value::Whole(0)));
            }
            return;
        }
        for (letter, value) in &block.words {
            match (letter, value) {
                ('M', Value::Text("3" | "4")) => self.state.armed = true,
                ('M', Value::Text("5" | "2" | "30")) => self.state.armed = false,
                ('S', Value::Whole(power)) => self.state.power = *power,
                _ => {}
            }
        }
        let asked = block
            .words
            .iter()
            .any(|(letter, value)| *letter == 'M' && matches!(value, Value::Text("3" | "4" | "5")));
        block.words.retain(|(letter, value)| {
            *letter != 'M' || !matches!(value, Value::Text("3" | "4" | "5"))
        });
        let on = self.state.armed && self.state.power > 0;
        if on != self.state.beam || (asked && !self.state.armed) {
            block.words.insert(0, ('M', Value::Text(if on { "3" } else { "5" })));
        }
        self.state.beam = on;
    }
}
