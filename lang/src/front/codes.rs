//! The table of diagnostics: every code, its severity, a short title and an explanation.
//! L lexical, P syntax, N names and flow, K kinds, G G-code, M machine, B budget.

/// How bad a diagnostic is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Severity {
    /// The script can not run.
    Error,
    /// The script runs, but probably not as meant.
    Warning,
}

impl Severity {
    /// As it is shown.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Warning => "warning",
        }
    }
}

macro_rules! codes {
    ($($id:ident $code:literal $severity:ident $title:literal $explanation:literal)*) => {
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

            /// Error or warning.
            pub const fn severity(self) -> Severity {
                match self { $(Self::$id => Severity::$severity,)* }
            }

            /// In a few words.
            pub const fn title(self) -> &'static str {
                match self { $(Self::$id => $title,)* }
            }

            /// Why it is wrong and what to do.
            pub const fn explanation(self) -> &'static str {
                match self { $(Self::$id => $explanation,)* }
            }
        }
    };
}

codes! {
    UnknownCharacter "L001" Error "a character that has no meaning" "Only letters of the Latin alphabet without accents, digits and the signs of the language stand outside comments and texts."
    UnclosedText "L002" Error "a text without its closing quote" "A text begins and ends with \" on one line."
    UnclosedComment "L003" Error "a G-code comment without `)`" "A comment in a G-code block begins with ( and ends with ) on the same line."
    BadNumber "L004" Error "a number that can not be read" "Numbers are 42, &H1F, &B1010, 1_000 or decimals with a unit."
    BadUnit "L005" Error "letters behind a number that are no unit" "Units are mm um in st ms s min mm/min mm/s in/min st/s mm/s2 st/s2; they follow the digits without a blank."
    DecimalWithoutUnit "L006" Error "a decimal without a unit" "Plain Numbers are whole; only quantities have decimals."
    InexactNumber "L007" Error "a quantity finer than its stored unit" "Lengths in mm and um are whole micrometres, Times whole milliseconds, Steps whole steps."
    NumberRange "L008" Error "a number beyond 32 bits" "Values are whole numbers from -2147483648 to 2147483647 in their stored unit."
    FileTooLarge "L009" Error "a file too large for a script" "A script has at most 8 MB."
    NotText "L010" Error "a file that is not text" "Scripts are UTF-8 text."
    Latin1 "L011" Warning "a file that is not UTF-8" "It was read as Latin-1; only comments and texts may show it."
    LoneQuestion "L012" Error "`?` alone" "`?` belongs to Probe? ProbeMask? Home? WaitIn? WaitChar?; printing is PRINT."
    ForeignComment "L013" Error "a comment of another language" "Comments begin with ' or REM."
    ForeignOperator "L014" Error "an operator of another language" "Operators are = <> < <= > >= + - * / MOD << >> AND OR XOR NOT ANDALSO ORELSE."
    BadContinuation "L015" Error "`_` that continues no line" "A line goes on with a blank and _ as its last characters."

    UnknownStatement "P001" Error "a statement that does not exist" "A statement begins with a statement word, a variable, a SUB's name, a label or a G-code word."
    Expected "P002" Error "something else should stand here" "The message names what may stand there."
    BadName "P003" Error "a word that can not be a name" "Names are a letter, then letters, digits, _; reserved words, axis letters and what looks like a G-code word are none."
    UnclosedBlock "P004" Error "a block without its end" "IF, SELECT, FOR, WHILE, DO, REPEAT, SUB and FUNCTION need their closing line."
    UnopenedBlock "P005" Error "an end without its block" "The closing line does not match what is open."
    TooDeep "P006" Error "nested too deeply" "Expressions and blocks have a bounded depth; the device's own is less."
    NextName "P007" Error "NEXT names another variable" "NEXT closes the innermost FOR."
    Misplaced "P008" Error "a statement that may not stand here" "PROFILE is first; SUB and FUNCTION stand outside of all blocks."
    UnitApart "P009" Error "a blank before a unit" "A unit follows its digits directly: 5mm."
    ForeignStatement "P010" Error "a statement of another BASIC" "The hint names ours."
    WrongArguments "P011" Error "too many or too few arguments" "The message shows the statement's form."
    NeedsAxis "P012" Error "an axis letter should stand here" "Axes are X, Y, Z."
    BlockInOneLine "P013" Error "a block opens in a one-line IF" "Write the block form: THEN ends the line, END IF closes."
    GcodeWord "P014" Error "a G-code word that can not be read" "A word is a letter directly followed by a number or [expression]."
    ForeignBrackets "P015" Error "brackets of another language" "Parentheses in expressions and calls, [ ] in G-code words, no braces."
    LineNumber "P016" Error "a line number" "Lines have no numbers; a label is name: at the start of a line."
    BlankLabel "P017" Error "a label that is not at the start of a line, or apart from its colon" "A label is name: at the start of a line, the colon directly behind the name."
    LabelIsSub "P018" Error "a label with a SUB's name" "A statement that begins with a SUB's name calls it."
}

#[cfg(test)]
mod tests {
    use super::Code;
    use std::collections::HashSet;

    #[test]
    fn codes_are_a_letter_and_three_digits_and_unique() {
        let mut seen = HashSet::new();
        for code in Code::ALL {
            let id = code.id().as_bytes();
            assert_eq!(id.len(), 4);
            assert!(b"LPNKGMB".contains(&id[0]) && id[1..].iter().all(u8::is_ascii_digit));
            assert!(seen.insert(code.id()), "{} twice", code.id());
            assert!(!code.title().is_empty() && code.explanation().ends_with('.'));
        }
    }
}
