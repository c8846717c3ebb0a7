//! The machine that a generated program is for.

use lang::front::ProfileChoice;
use lang::profile::{Aout, Profile};

use super::Case;

impl Case {
    /// The machine that it is for: the built-in one, with an analog output where the program sets one.
    pub fn machine(&self) -> ProfileChoice<'static> {
        let sets = ["SetAout", " E1 Q"].iter().any(|word| self.script.contains(word));
        match Profile::built_in("mill") {
            Ok(mut mill) if sets => {
                mill.aouts.push(Aout { n: 1, ..Aout::default() });
                ProfileChoice::Given(Box::new(mill))
            }
            _ => ProfileChoice::built_in(),
        }
    }
}
