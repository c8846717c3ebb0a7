//! What the checker found out about each declared name, for editors.

use std::collections::HashMap;

use crate::hir::Storage;
use crate::kind::Kind;

/// What is known of a declared name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fact {
    /// Its kind: of a variable, a CONST, a FUNCTION's result, or of each column of a TABLE; empty
    /// for a SUB, an INPUT or an OUTPUT.
    pub kinds: Vec<Kind>,
    /// The script does not say the kind.
    pub inferred: bool,
    /// Value of a CONST, number of an INPUT or OUTPUT, size of an array, rows of a TABLE.
    pub value: Option<i32>,
    /// Where a variable lives.
    pub storage: Option<Storage>,
}

/// Facts by the offset at which the name stands in its declaration.
pub type Facts = HashMap<u32, Fact>;
