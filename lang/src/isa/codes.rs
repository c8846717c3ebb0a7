//! First and last code of each instruction by its name, as patterns of a `match` want them.

macro_rules! codes {
    ($($code:literal x $count:literal $name:ident $text:literal
       $operands:ident $pops:literal $pushes:literal $class:ident $doc:literal;)*) => {
        /// First code of each.
        #[expect(non_upper_case_globals, reason = "named as the instructions are")]
        pub mod first {
            $(#[doc = $doc] pub const $name: u8 = $code;)*
        }

        /// Last code of each.
        #[expect(non_upper_case_globals, reason = "named as the instructions are")]
        pub mod last {
            $(#[doc = $doc] pub const $name: u8 = $code + ($count - 1);)*
        }
    };
}

crate::opcode_rows!(codes);
