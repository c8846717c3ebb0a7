//! The table of importers' diagnostics. `X` stands for exchange; the letters of the language's own
//! table are not used.

macro_rules! codes {
    ($($id:ident $code:literal $title:literal)*) => {
        /// A diagnostic's identity.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum Code {
            $(#[doc = $title] $id,)*
        }

        impl Code {
            /// All of them, in the table's order.
            pub const ALL: &[Self] = &[$(Self::$id),*];

            /// A capital letter and three digits; stable.
            pub const fn id(self) -> &'static str {
                match self { $(Self::$id => $code,)* }
            }

            /// In a few words.
            pub const fn title(self) -> &'static str {
                match self { $(Self::$id => $title,)* }
            }
        }
    };
}

codes! {
    NotText "X001" "a file that is not text"
    TooLarge "X002" "a file too large to be read"
    UnknownFormat "X003" "a file of no known system"
    TooLong "X004" "a file that makes too long a script"
    Encoding "X005" "characters that are not UTF-8"
    Unreadable "X010" "a line that cannot be read"
    WrongCount "X011" "too many or too few values"
    OutOfRange "X012" "a value out of range"
    NoAxes "X013" "a move before the axes are named"
    WrongAxis "X014" "an axis that is not there"
    BadJump "X015" "a jump or loop that leads outside"
    Unsupported "X020" "something that has no meaning on this machine"
    LeftOut "X021" "something that is left out"
    Changed "X022" "something that is done in another way"
    Inconsistent "X023" "a source that contradicts itself"
    NoProgram "X024" "a file without a statement"
    Said "X030" "a remark on what was made of the file"
}

#[cfg(test)]
mod tests {
    use super::Code;

    #[test]
    fn codes_are_a_letter_and_three_digits_and_unique() {
        let ids: std::collections::HashSet<_> = Code::ALL.iter().map(|code| code.id()).collect();
        assert_eq!(ids.len(), Code::ALL.len());
        assert!(ids.iter().all(|id| id.len() == 4 && id.starts_with('X')));
        assert!(Code::ALL.iter().all(|code| !code.title().is_empty()));
    }
}
