//! The reserved words: one table for lexer, parser, hints, formatter, editors and the manual.

use std::collections::HashMap;
use std::sync::LazyLock;

/// What a word is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Class {
    /// Declares a name.
    Declaration,
    /// Steers the program.
    Control,
    /// Acts on the machine or the host.
    Machine,
    /// An operator or a constant in expressions.
    Operator,
    /// Stands inside another statement.
    Part,
    /// Stands inside another statement and is an ordinary name elsewhere.
    Soft,
}

/// A row of the table of keywords.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Canonical spelling.
    pub text: &'static str,
    /// What it is for.
    pub class: Class,
    /// How it is used.
    pub usage: &'static str,
    /// One sentence; empty for words that have none of their own.
    pub about: &'static str,
}

macro_rules! keywords {
    ($($id:ident $text:literal $class:ident $usage:literal $about:literal)*) => {
        /// A reserved word that is not a function.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Kw {
            $(#[doc = $usage] $id,)*
        }

        impl Kw {
            /// All of them, in the table's order.
            pub const ALL: &[Self] = &[$(Self::$id),*];

            /// Its row.
            pub const fn entry(self) -> Entry {
                match self {
                    $(Self::$id => Entry { text: $text, class: Class::$class, usage: $usage, about: $about },)*
                }
            }
        }
    };
}

macro_rules! with_plain {
    ($($plain:ident $plain_text:literal $code:literal $mnemonic:literal $count:literal
       [$($argument:ident)*] $touch:ident $manner:ident $plain_usage:literal $plain_about:literal $doc:literal;)*) => { keywords! {
    Profile "PROFILE" Declaration "PROFILE \"name\"" "Names the machine; first statement of a script."
    Const "CONST" Declaration "CONST name = expression" "A name for a value that never changes."
    Input "INPUT" Declaration "INPUT name = number" "A name for an input, counted from 1."
    Output "OUTPUT" Declaration "OUTPUT name = number" "A name for an output, counted from 1."
    Dim "DIM" Declaration "DIM name[(size)] [AS kind] [= value] [AT address [LABEL \"text\"] [MIN value] [MAX value]] [, ...]" "Variables and arrays, in RAM; 0 at the start of a run, but for those with AT. `= value` is an assignment where the DIM stands."
    Table "TABLE" Declaration "TABLE name[(columns)] = value, ... [; value, ...]" "Constant values in flash, by rows; columns are a number or their names."
    Keep "KEEP" Declaration "KEEP name[(size)] [AS kind] [, ...]" "A value or an array kept through power loss."
    Sub "SUB" Declaration "SUB name[(name [AS kind], ...)]" "Opens a SUB; END SUB closes it."
    Function "FUNCTION" Declaration "FUNCTION name(name [AS kind], ...) [AS kind]" "Opens a FUNCTION; RETURN gives its value, END FUNCTION closes it."

    If "IF" Control "IF condition THEN ... [ELSEIF condition THEN ...] [ELSE ...] END IF" "Chooses; with a statement behind THEN on the same line it is a one-line IF without END IF."
    ElseIf "ELSEIF" Control "ELSEIF condition THEN" "A further branch of an IF."
    Else "ELSE" Control "ELSE" "The last branch of an IF."
    Select "SELECT" Control "SELECT CASE expression ... END SELECT" "Chooses by a value."
    Case "CASE" Control "CASE value [, value TO value, IS < value] or CASE ELSE" "A branch of SELECT CASE."
    For "FOR" Control "FOR name = from TO limit [STEP step] ... NEXT [name]" "Counts."
    Next "NEXT" Control "NEXT [name]" "Closes a FOR."
    While "WHILE" Control "WHILE condition ... WEND" "Repeats as long as the condition holds."
    Wend "WEND" Control "WEND" "Closes a WHILE."
    Do "DO" Control "DO [WHILE|UNTIL condition] ... LOOP [WHILE|UNTIL condition]" "Repeats; without a condition for ever."
    Loop "LOOP" Control "LOOP [WHILE|UNTIL condition]" "Closes a DO."
    Repeat "REPEAT" Control "REPEAT count ... END REPEAT" "Repeats a number of times."
    Exit "EXIT" Control "EXIT FOR|WHILE|DO|REPEAT|SUB|FUNCTION" "Leaves the named block."
    Continue "CONTINUE" Control "CONTINUE FOR|WHILE|DO|REPEAT" "Goes on with the next pass."
    Goto "GOTO" Control "GOTO label" "Goes on at a label; never into a block."
    Gosub "GOSUB" Control "GOSUB label" "Calls the lines behind a label up to RETURN."
    Return "RETURN" Control "RETURN [expression]" "Ends a GOSUB, a SUB, or a FUNCTION with its value."
    Call "CALL" Control "CALL name(argument, ...)" "Calls a SUB; the word may be left out."
    End "END" Control "END" "Ends the run. Outputs take the states that the profile's `end` names, off by default."
    Run "RUN" Control "RUN \"name\"" "Ends the run and begins another program of the library."
    On "ON" Control "ON ERROR GOTO label, ON ERROR STOP, ON IN n RISE|FALL GOSUB sub, ON IN n OFF, ON EVERY time GOSUB sub, ON EVERY OFF" "Says what serves a fault, an edge or a clock tick; as a value it is 1."
    Resume "RESUME" Control "RESUME [NEXT]" "Ends an error handler: runs the failed statement again, or goes on behind it."

    Start "START" Machine "START MoveAxe|MoveRel ..." "Starts a move and does not wait for its end."
    MoveAxe "MoveAxe" Machine "MoveAxe axis, target [, speed [, accel [, decel]]]" "Moves one axis to an absolute position with its own ramp."
    MoveRel "MoveRel" Machine "MoveRel axis, distance [, speed [, accel [, decel]]]" "Moves one axis by a distance."
    WaitMove "WaitMove" Machine "WaitMove [axis]" "Waits until one axis, or all, are at rest."
    MoveSpeed "MoveSpeed" Machine "MoveSpeed axis, speed" "Runs an axis at a speed until it is stopped; the sign is the direction."
    StopAxe "StopAxe" Machine "StopAxe axis" "Stops an axis on its ramp."
    Home "Home" Machine "Home[?] [axis, ...]" "Finds the reference switches; `Home?` sets HOMED instead of raising F10."
    Probe "Probe" Machine "Probe[?] axis, limit, speed [, input [, state]]" "Moves until an input has the state; `Probe?` sets PROBEOK instead of raising F12."
    ProbeMask "ProbeMask" Machine "ProbeMask[?] axis, limit, speed, and, xor" "Moves until ((INPORT() AND and) XOR xor) is not 0."
    SetPos "SetPos" Machine "SetPos axis, value" "Makes the present position the work position `value`; the axis must be at rest."
    $($plain $plain_text Machine $plain_usage $plain_about)*
    Motors "Motors" Machine "Motors ON|OFF [, axis]" "Enables the drivers; OFF clears HOMED."
    WaitIn "WaitIn" Machine "WaitIn[?] n, ON|OFF|RISE|FALL [, timeout]" "Waits for an input; `WaitIn?` sets TIMEDOUT instead of raising F13."
    WaitChar "WaitChar" Machine "WaitChar[?] code [, timeout]" "Waits for a synchronisation character; `WaitChar?` sets TIMEDOUT instead of raising F13."
    Print "PRINT" Machine "PRINT expression [IN unit]; \"text\"; ..." "Writes a line to the host; a quantity in its stored unit, or IN another."
    Plane "PLANE" Machine "PLANE XY|XZ|YZ" "Chooses the interpolation plane."

    And "AND" Operator "a AND b" "Bitwise and; of Truths the logical one."
    Or "OR" Operator "a OR b" "Bitwise or; of Truths the logical one."
    Xor "XOR" Operator "a XOR b" "Bitwise exclusive or; of Truths the logical one."
    Not "NOT" Operator "NOT a" "Logical of a Truth, bitwise of a Number."
    Mod "MOD" Operator "a MOD b" "Remainder, with the sign of a."
    AndAlso "ANDALSO" Operator "a ANDALSO b" "And; b is evaluated only where a is true."
    OrElse "ORELSE" Operator "a ORELSE b" "Or; b is evaluated only where a is false."
    True "TRUE" Operator "TRUE" "1"
    False "FALSE" Operator "FALSE" "0"
    Off "OFF" Operator "OFF" "0"

    Then "THEN" Part "IF condition THEN" ""
    To "TO" Part "FOR name = from TO limit" ""
    Step "STEP" Part "FOR name = from TO limit STEP step" ""
    Until "UNTIL" Part "DO UNTIL condition, LOOP UNTIL condition, WAIT UNTIL condition [, time]" "Ends a loop or a wait when the condition holds; TIMEDOUT tells whether the time of WAIT UNTIL was over first."
    As "AS" Part "name AS kind" ""
    At "AT" Part "DIM name AT address" ""
    Is "IS" Part "CASE IS < value" ""
    Rem "REM" Part "REM comment" ""

    Label "LABEL" Soft "DIM name AT address LABEL \"text\"" "What a panel calls the variable."
    Error "ERROR" Soft "ON ERROR GOTO label" ""
    Stop "STOP" Soft "ON ERROR STOP" ""
    Every "EVERY" Soft "ON EVERY time GOSUB sub" ""
    Rise "RISE" Soft "WaitIn n, RISE, RISE(n)" "A change of an input from off to on; as a function, since the last look at this place."
    Fall "FALL" Soft "WaitIn n, FALL, FALL(n)" "A change of an input from on to off; as a function, since the last look at this place."
    Xy "XY" Soft "PLANE XY" ""
    Xz "XZ" Soft "PLANE XZ" ""
    Yz "YZ" Soft "PLANE YZ" ""
    Number "NUMBER" Soft "AS NUMBER" "A plain whole number."
    Truth "TRUTH" Soft "AS TRUTH" "1 or 0."
    Time "TIME" Soft "AS TIME" "Milliseconds: `500ms`, `1.5s`, `2min`."
    Speed "SPEED" Soft "AS SPEED" "Micrometres per second: `1200mm/min`, `25mm/s`, `40in/min`."
    StepRate "STEPRATE" Soft "AS STEPRATE" "Steps per second: `2000st/s`."
    Accel "ACCEL" Soft "AS ACCEL" "Micrometres per second squared: `250mm/s2`."
    StepAccel "STEPACCEL" Soft "AS STEPACCEL" "Steps per second squared: `25000st/s2`."
    Angle "ANGLE" Soft "AS ANGLE" "Thousandths of a degree: `90deg`, `500mdeg`."
    Voltage "VOLTAGE" Soft "AS VOLTAGE" "Millivolts: `1.2V`, `800mV`."
    Sync "SYNC" Soft "SYNC SetOut n, ON|OFF [, lead], SYNC Pulse n, time [, lead], SYNC SetAout n, v [, lead]" "Sets an output where the next move of a path begins, without stopping it; a lead is a Time or a Length before that place, negative behind it. The MSP430F5529 has it."
    SetAout "SetAout" Soft "SetAout n, v" "Gives an analog output a Voltage, or a share of its range where the profile says so. The MSP430F5529 has one."
    Analog "ANALOG" Soft "ANALOG name = number" "A name for an analog input, counted from 1."
} };
}

crate::plain_rows!([with_plain]);

impl Kw {
    /// Canonical spelling.
    pub const fn text(self) -> &'static str {
        self.entry().text
    }

    /// May be followed by `?`: the form that reports instead of raising a fault.
    pub const fn has_quiet_form(self) -> bool {
        matches!(self, Self::Probe | Self::ProbeMask | Self::Home | Self::WaitIn | Self::WaitChar)
    }

    /// Is an ordinary name outside of its statement.
    pub fn is_soft(self) -> bool {
        self.entry().class == Class::Soft
    }

    /// May be a name of a script that declares it (`lexer/own.rs`): a statement of the machine, and LOOP. MoveAxe and MoveRel
    /// stand inside START, too.
    pub const fn may_be_name(self) -> bool {
        match self {
            Self::MoveAxe | Self::MoveRel => false,
            Self::Loop => true,
            _ => matches!(self.entry().class, Class::Machine),
        }
    }

    /// May begin a statement.
    pub const fn begins_statement(self) -> bool {
        matches!(self.entry().class, Class::Declaration | Class::Control | Class::Machine)
    }
}

/// What an argument of a built-in function is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArgKind {
    /// An expression.
    Value,
    /// An axis letter.
    Axis,
    /// The name of a TABLE.
    Table,
}

macro_rules! functions {
    ($($id:ident $text:literal [$($arg:ident),*] $usage:literal $about:literal)*) => {
        /// A built-in function.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Func {
            $(#[doc = $about] $id,)*
        }

        impl Func {
            /// All of them, in the table's order.
            pub const ALL: &[Self] = &[$(Self::$id),*];

            /// Canonical spelling.
            pub const fn text(self) -> &'static str {
                match self { $(Self::$id => $text,)* }
            }

            /// Its arguments; empty parentheses are written where the usage line has them.
            pub const fn args(self) -> &'static [ArgKind] {
                match self { $(Self::$id => &[$(ArgKind::$arg),*],)* }
            }

            /// How it is used.
            pub const fn usage(self) -> &'static str {
                match self { $(Self::$id => $usage,)* }
            }

            /// What it gives.
            pub const fn about(self) -> &'static str {
                match self { $(Self::$id => $about,)* }
            }
        }
    };
}

functions! {
    Abs "ABS" [Value] "ABS(e)" "The value without its sign; keeps the kind."
    Min "MIN" [Value, Value] "MIN(a, b)" "The lesser of two values of one kind."
    Max "MAX" [Value, Value] "MAX(a, b)" "The greater of two values of one kind."
    Sgn "SGN" [Value] "SGN(e)" "-1, 0 or 1."
    Sqr "SQR" [Value] "SQR(n)" "Integer square root of a Number; of a negative one F20."
    CharIn "CHARIN" [] "CHARIN()" "Takes the last character received; 0 for none."
    In "IN" [Value] "IN(n)" "State of an input, counted from 1."
    InPort "INPORT" [] "INPORT()" "All inputs as bits, input 1 lowest."
    Ain "AIN" [Value] "AIN(n)" "Voltage at an analog input, counted from 1; n is a constant."
    Out "OUT" [Value] "OUT(n)" "State of an output, counted from 1."
    Pos "POS" [Axis] "POS(axis)" "Work position, that of the steps made, a Length."
    PosSt "POSST" [Axis] "POSST(axis)" "Machine position in Steps."
    Probed "PROBED" [Axis] "PROBED(axis)" "Work position of the last probe contact, a Length."
    ProbedSt "PROBEDST" [Axis] "PROBEDST(axis)" "Machine position of the last probe contact in Steps."
    ProbeOk "PROBEOK" [Axis] "PROBEOK(axis)" "Whether the last probe met something."
    Moving "MOVING" [Axis] "MOVING(axis)" "Whether the axis moves."
    Homed "HOMED" [Axis] "HOMED(axis)" "Whether the axis knows its reference."
    Timer "TIMER" [] "TIMER()" "Time since the run began; `DIM t AS TIMER` makes one that `t = 0s` restarts."
    Count "COUNT" [Table] "COUNT(table)" "Number of rows of a TABLE."
    Steps "STEPS" [Axis, Value] "STEPS(axis, length)" "A Length in Steps of the axis, rounded half away from zero."
    Length "LENGTH" [Axis, Value] "LENGTH(axis, steps)" "Steps of the axis as a Length, rounded half away from zero."
    Sin "SIN" [Value] "SIN(angle)" "Sine of an Angle in 1/10000: SIN(30deg) is 5000. The MSP430F5529 has it."
    Cos "COS" [Value] "COS(angle)" "Cosine of an Angle in 1/10000. The MSP430F5529 has it."
    Atan2 "ATAN2" [Value, Value] "ATAN2(y, x)" "Angle of the direction (x, y), -180deg to 180deg; 0deg of (0, 0). The MSP430F5529 has it."
    Scale "SCALE" [Value, Value, Value, Value, Value] "SCALE(v, a, b, c, d)" "What v is between c and d if it is the same between a and b; beyond them it goes on. The MSP430F5529 has it."
    Err "ERR" [] "ERR" "In an error handler the fault's number: 1 for F01."
    Erl "ERL" [] "ERL" "In an error handler the line that failed."
    TimedOut "TIMEDOUT" [] "TIMEDOUT" "Whether the last WaitIn?, WaitChar? or WAIT UNTIL with a time timed out."
}

impl Func {
    /// Is written without parentheses.
    pub const fn is_bare(self) -> bool {
        matches!(self, Self::Err | Self::Erl | Self::TimedOut)
    }

    /// Is a name wherever the script has one like it, of any sort.
    pub const fn is_soft(self) -> bool {
        matches!(self, Self::Sin | Self::Cos | Self::Atan2 | Self::Scale | Self::Ain)
    }

    /// The soft function of a name in any case.
    pub fn soft(name: &str) -> Option<Func> {
        let named = |func: &&Func| func.is_soft() && func.text().eq_ignore_ascii_case(name);
        Func::ALL.iter().find(named).copied()
    }

    /// May be a name of a script that declares it (`lexer/own.rs`). The others stand in declarations or statements, too.
    pub const fn may_be_name(self) -> bool {
        !self.is_bare() && !matches!(self, Self::In | Self::Min | Self::Max | Self::Timer)
    }
}

/// What a word means that is not an ordinary name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reserved {
    /// A keyword.
    Kw(Kw),
    /// A built-in function.
    Func(Func),
}

static WORDS: LazyLock<HashMap<&'static str, Reserved>> = LazyLock::new(|| {
    let keywords = Kw::ALL.iter().map(|&k| (k.text(), Reserved::Kw(k)));
    let functions =
        Func::ALL.iter().filter(|f| !f.is_soft()).map(|&f| (f.text(), Reserved::Func(f)));
    keywords
        .chain(functions)
        .map(|(text, r)| (&*Box::leak(text.to_ascii_uppercase().into_boxed_str()), r))
        .collect()
});

/// The longest reserved word has fewer characters than this.
const LONGEST: usize = 12;

/// Looks a word up, in any case; soft words are found too.
pub fn lookup(word: &str) -> Option<Reserved> {
    if word.len() >= LONGEST {
        return None;
    }
    let mut upper = [0u8; LONGEST];
    let upper = upper.get_mut(..word.len())?;
    upper.copy_from_slice(word.as_bytes());
    upper.make_ascii_uppercase();
    WORDS.get(core::str::from_utf8(upper).ok()?).copied()
}

/// Functions of other BASICs, and what does here what they do there.
const FOREIGN_FUNCTIONS: [(&str, &str); 35] = [
    ("asc", "a character is a number: A is 65"),
    ("atan", "write `ATAN2(y, x)`"),
    ("atn", "write `ATAN2(y, x)`"),
    ("bit", "bit 3 of n is on where `(n AND 8) <> 0`"),
    ("chr", "a character is a number: A is 65"),
    ("cint", "values are whole numbers: leave it out"),
    ("cos", "write `COS(30deg)`: there are no fractions, so it is in 1/10000"),
    ("day", "there is no clock of the day; `TIMER()` is the Time since the run began"),
    ("disable", "write `OFF`"),
    ("disabled", "write `OFF`"),
    ("enable", "write `ON`"),
    ("enabled", "write `ON`"),
    ("exp", "there are no fractions: put the values into a TABLE"),
    ("fix", "values are whole numbers: leave it out"),
    ("getpos", "write `POS(X)`"),
    ("high", "write `ON`"),
    ("hour", "there is no clock of the day; `TIMER()` is the Time since the run began"),
    ("inkey", "write `CHARIN()`"),
    ("input", "write `IN(n)`"),
    ("int", "values are whole numbers: leave it out; `/` truncates toward zero"),
    ("log", "there are no fractions: put the values into a TABLE"),
    ("low", "write `OFF`"),
    ("map", "write `SCALE(x, a, b, c, d)`"),
    ("millis", "write `TIMER()`"),
    ("minute", "there is no clock of the day; `TIMER()` is the Time since the run began"),
    ("now", "write `TIMER()`: the Time since the run began"),
    ("pi", "there are no fractions: `355 / 113` of a value is near it"),
    ("rnd", "there are no random numbers"),
    ("round", "values are whole numbers: leave it out"),
    ("second", "there is no clock of the day; `TIMER()` is the Time since the run began"),
    ("sin", "write `SIN(30deg)`: there are no fractions, so it is in 1/10000"),
    ("sqrt", "write `SQR(n)`"),
    ("tan", "write `1000 * SIN(a) / COS(a)`: there are no fractions, so it is in 1/1000"),
    ("time", "write `TIMER()`: the Time since the run began"),
    ("val", "there are no text variables"),
];

/// A hint for a name, in lower case, that is a function elsewhere.
pub fn foreign_function(key: &str) -> Option<&'static str> {
    FOREIGN_FUNCTIONS.iter().find(|(name, _)| *name == key).map(|(_, hint)| *hint)
}

/// A hint for a name, in lower case, that one writes to elsewhere to set an output.
pub fn foreign_target(key: &str) -> Option<&'static str> {
    let port = key.strip_prefix("port").or_else(|| key.strip_prefix("pin"))?;
    let bit = port.len() <= 2 && port.bytes().all(|b| b.is_ascii_alphanumeric());
    bit.then_some("to set an output write `SetOut n, ON`, eight of them `SetPort value`")
}

/// The candidate nearest to `word` by edit distance (a swap of neighbours counts 1), if it is near
/// enough that a typing slip explains the difference: 1 for up to four letters, 2 beyond.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    const LONGEST_WORD: usize = 40;
    let folded = |s: &str| s.bytes().map(|b| b.to_ascii_lowercase()).collect::<Vec<u8>>();
    if word.len() < 2 || word.len() > LONGEST_WORD {
        return None;
    }
    let word = folded(word);
    let allowed = if word.len() <= 4 { 1 } else { 2 };
    candidates
        .into_iter()
        .filter(|c| c.len() >= 2 && c.len().abs_diff(word.len()) <= allowed)
        .map(|c| (distance(&word, &folded(c)), c))
        .filter(|&(d, _)| d <= allowed)
        .min_by_key(|&(d, _)| d)
        .map(|(_, c)| c)
}

/// Optimal string alignment distance.
fn distance(a: &[u8], b: &[u8]) -> usize {
    let mut before: Vec<usize> = vec![0; b.len() + 1];
    let mut above: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.iter().enumerate() {
        let mut row = vec![i + 1; b.len() + 1];
        for (j, cb) in b.iter().enumerate() {
            let replaced = above[j] + usize::from(ca != cb);
            row[j + 1] = replaced.min(above[j + 1] + 1).min(row[j] + 1);
            if i > 0 && j > 0 && a[i - 1] == *cb && b[j - 1] == *ca {
                row[j + 1] = row[j + 1].min(before[j - 1] + 1);
            }
        }
        before = above;
        above = row;
    }
    above[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_found_in_any_case() {
        assert_eq!(lookup("moveaxe"), Some(Reserved::Kw(Kw::MoveAxe)));
        assert_eq!(lookup("PosSt"), Some(Reserved::Func(Func::PosSt)));
        assert_eq!(lookup("pump"), None);
        assert_eq!(lookup("averylongnameindeed"), None);
        for k in Kw::ALL {
            assert_eq!(lookup(k.text()), Some(Reserved::Kw(*k)), "{}", k.text());
        }
        for f in Func::ALL {
            if f.is_soft() {
                assert_eq!((Func::soft(f.text()), lookup(f.text())), (Some(*f), None));
                continue;
            }
            assert_eq!(lookup(f.text()), Some(Reserved::Func(*f)), "{}", f.text());
        }
    }

    #[test]
    fn slips_are_near_and_other_words_are_not() {
        let words = || Kw::ALL.iter().map(|k| k.text());
        assert_eq!(nearest("MoveAx", words()), Some("MoveAxe"));
        assert_eq!(nearest("SetOtu", words()), Some("SetOut"));
        assert_eq!(nearest("WHIEL", words()), Some("WHILE"));
        assert_eq!(nearest("DELAY", words()), None);
        assert_eq!(nearest("q", words()), None);
    }
}
