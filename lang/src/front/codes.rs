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
    BadUnit "L005" Error "letters behind a number that are no unit" "Units are mm um in st ms s min mm/min mm/s in/min st/s mm/s2 st/s2 deg mdeg; they follow the digits without a blank."
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

    UnknownName "N001" Error "a name that nothing declares" "Variables are declared by DIM, KEEP or as parameters, other names by CONST, INPUT, OUTPUT, TABLE, SUB, FUNCTION or the profile."
    DeclaredTwice "N002" Error "a name that is declared twice" "A name stands for one thing in its SUB or outside; locals may hide outer names."
    Unused "N003" Warning "a name that nothing uses" "What is declared and never mentioned may be a slip."
    WrongUse "N004" Error "a name used as something that it is not" "Arrays and tables take an index, SUBs have no value, constants are not assigned."
    WrongCount "N005" Error "too many or too few arguments or indexes" "The hint shows the form."
    UnknownLabel "N006" Error "a label that does not exist" "Labels belong to their SUB; handlers begin at labels outside of SUBs."
    JumpIntoBlock "N007" Error "a jump into a block" "GOTO may leave a block, never enter one; handlers begin outside all blocks."
    Recursion "N008" Error "a SUB, FUNCTION or GOSUB that calls itself" "Without recursion the worst-case stack is known, and is checked against the device before upload."
    SharedCells "N009" Error "a SUB with cells of its own that a handler shares" "What the main program, event handlers and the error handler share may interrupt itself: it has no parameters, locals, FOR, REPEAT or SELECT."
    Unreachable "N010" Warning "a statement that nothing reaches" "It stands behind GOTO, RETURN, END, EXIT or an endless loop, without a label."
    NotInside "N011" Error "EXIT, CONTINUE or RETURN outside of what it leaves" "EXIT and CONTINUE name a loop that is open; RETURN has a value in a FUNCTION only."
    TooManyEvents "N012" Error "too many event handlers" "Up to 4 ON IN and ON EVERY lines."
    BadTarget "N013" Error "a target that is no handler" "GOSUB, ON IN and ON EVERY go to a label or a SUB without parameters."
    NotConstant "N014" Error "a value that is not known beforehand" "CONST, TABLE, sizes, numbers of inputs and outputs and AT take literals, CONSTs, COUNT, STEPS and LENGTH."
    ConstantFault "N015" Error "a constant expression that always faults" "Overflow, division by zero and bad shifts are faults; here they are certain."
    ArraySize "N016" Error "an array of an impossible size" "DIM a(8) has the values a(0) to a(7)."
    IndexRange "N017" Error "an index outside its array or table" "Indexes count from 0 to the size less one."
    BadAt "N018" Error "an address that can not be" "AT stands outside SUBs, with an even register from 3000 on; one variable to a register."
    BadKeep "N019" Error "a KEEP that can not be" "Up to 8 values, outside SUBs."
    TableShape "N020" Error "a table whose rows do not fit" "TABLE name(columns) = value, ...; rows are parted by `;`."
    TooTangled "N021" Error "GOSUBs that run into one another" "Lines behind a GOSUB's label should end with RETURN."
    BadProgram "N022" Error "a name that no program can have" "A program of a library is called by up to 16 characters of ASCII without quotes; a number alone is no name."
    Unnoticed "N023" Warning "a time that is up and that nothing notices" "`WaitIn?` and `WaitChar?` set TIMEDOUT when their time is up; without `?` they end in F13 and never set it."

    KindMismatch "K001" Error "operands whose kinds do not go together" "Same kinds add, subtract and compare; a kind times or over a Number keeps it; a kind over itself is a Number."
    AssignKind "K002" Error "a value of another kind than its variable" "The first assignment decides a variable's kind, or AS."
    ArgumentKind "K003" Error "an argument of the wrong kind" "The message names what is needed and what stands there."
    ConditionKind "K004" Error "a condition that is not one" "Conditions and ON/OFF arguments are a Truth or a Number; NOT of a Number and AND of a Truth with a Number work on bits."
    StepNeeded "K005" Error "FOR over a quantity without STEP" "What one step is must be written: STEP 0.5mm."
    TableKinds "K006" Error "values of several kinds in a table's column" "A column has one kind; a column index that is not constant needs columns of one kind."
    EmptyRange "K007" Warning "a range without values" "CASE low TO high needs low not above high; FOR counts from its start toward its limit."

    GcodeUnknown "G001" Error "a G or M word that is not supported" "The hint says what to write instead."
    GcodeNoMeaning "G002" Error "a word without meaning here" "No word is dropped in silence."
    GcodeTwice "G003" Error "words that exclude each other" "A block has one word of a modal group, and one use for its axis words."
    GcodeMissing "G004" Error "a word that is missing" "The hint shows the form."
    GcodeConflict "G005" Error "modal state that differs between the ways to a block" "The state is followed along control flow and into SUBs; write the word in the block that depends on it."
    GcodeHandler "G006" Error "modal state missing in a handler" "Handlers start with no G-code modal state and no F."
    GcodeFeed "G007" Error "a feed move that no F reaches" "Write F once before, or give the profile a default feed."
    GcodeDefaultFeed "G008" Warning "the profile's default feed is used" "No F reaches this block."
    GcodeInexact "G009" Warning "a relative number that is rounded" "Under G91 the rounding of many blocks adds up."
    GcodeRange "G010" Error "a value that a word can not have" "The hint says what it may be."
    GcodeTolerance "G011" Warning "a tolerance that changes nothing" "The profile says how far a path may round a corner."

    NoAxis "M001" Error "an axis that the machine does not have" "The profile says which axes there are."
    NoPort "M002" Error "an input or output that the wiring does not have" "Inputs and outputs count from 1."
    ReservedOutput "M003" Error "an output that the controller itself drives" "Lamp and enable are not set by scripts."
    AlwaysFaults "M004" Warning "a statement that always faults" "Its constant arguments lie outside what the machine takes."
    AboveTop "M005" Warning "a speed, acceleration or feed above what the axes reach" "The axis runs at its top, a path as fast as its axes can."
    OutsideTravel "M006" Warning "a target outside the travel" "Soft limits hold for axes that are homed."
    ProbeTooFast "M007" Warning "a probe speed that a shift register can not follow" "It is sampled each ms, exact up to 1000 st/s."
    UnknownProfile "M008" Error "a profile that does not exist" "Built in are mill, charly, thesis, laser, picker; a file is given by --profile."
    OffAtEnd "M009" Warning "an output that the end of the run switches off at once" "At END each output takes the state that the profile's `end` names: off, if it names none."
    CycleDownward "M010" Warning "a canned cycle on a machine whose Z counts downward" "A cycle takes a greater Z for a higher place: it would lift into the work, and peck once."
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
