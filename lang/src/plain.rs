//! Plain statements: arguments, then an opcode. A row here is all that the language knows of one.
//!
//! A row is `Name "keyword" code "mnemonic" count [Argument ...] Touch once|waits "usage" "about" "what it does";`, count
//! being the number of arguments. From it come the keyword with its help, the parser, the checks of the
//! arguments, the opcode with its encoding, the effect, and what follows a program without running it knows of that. What
//! the effect does stands where the machines are: `host/src/sim/machine/perform.rs`, and the chips' (firmware/README.md).
//!
//! Effects have codes 0xA0 to 0xFE, of which 0xFE alone is free (`isa/tests.rs` holds that): the statement after the next
//! one wants a code with a second byte.

/// Hands all rows to a macro, behind what else it gets.
#[macro_export]
macro_rules! plain_rows {
    ([$($then:tt)+] $($more:tt)*) => {
        $($then)+! { $($more)*
            StopAll "StopAll" 0xCB "stopall" 0 [] Axes once
                "StopAll" "Stops every axis on its ramp." "StopAll";
            WaitStart "WaitStart" 0xE0 "waitstart" 0 [] Nothing waits
                "WaitStart" "Waits for a press of the Start button." "WaitStart";
            SetOut "SetOut" 0xE1 "setout" 2 [Output State] Output once
                "SetOut n, ON|OFF" "Switches an output." "SetOut n, on";
            Pulse "Pulse" 0xE2 "pulse" 2 [Output Time] Off waits
                "Pulse n, time" "Switches an output on for a time." "Pulse n, ms";
            Wait "Wait" 0xE6 "wait" 1 [Time] Nothing waits
                "Wait time" "Waits for a time." "Wait ms";
            Send "Send" 0xE7 "send" 1 [Character] Nothing once
                "Send code" "Sends a synchronisation character, 33 to 125." "Send";
            SetPort "SetPort" 0xE8 "setport" 1 [Number] Port once
                "SetPort value" "Sets outputs 1 to 8 from the bits of a Number." "SetPort";
        }
    };
}

/// What an argument is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Argument {
    /// Number of an output that a script may set.
    Output,
    /// ON or OFF: a Truth or a Number.
    State,
    /// A Time that is not negative.
    Time,
    /// A Number.
    Number,
    /// A synchronisation character.
    Character,
}

/// What a statement leaves changed, as those see it who follow a program without a machine: a stream that goes on from a
/// line (`host/src/track.rs`), pieces of a job (`host/src/stream/cut.rs`), chords (`host/src/chords/known.rs`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Touch {
    /// Nothing that they look at.
    Nothing,
    /// Axes: where they are hangs on the machine.
    Axes,
    /// The output of the first argument is as the second one says.
    Output,
    /// That output is off behind it.
    Off,
    /// Outputs 1 to 8 are as the bits of the first argument say, but for those with a role of their own.
    Port,
}

/// Arguments that a plain statement has at most.
pub const MOST: usize = 2;

macro_rules! manner {
    (once) => {
        false
    };
    (waits) => {
        true
    };
}

macro_rules! plain {
    ($($name:ident $text:literal $code:literal $mnemonic:literal $count:literal [$($argument:ident)*]
       $touch:ident $manner:ident $usage:literal $about:literal $doc:literal;)*) => {
        /// A plain statement.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Plain {
            $(#[doc = $usage] $name,)*
        }

        impl Plain {
            /// Its arguments, in order.
            pub const fn arguments(self) -> &'static [Argument] {
                match self {
                    $(Plain::$name => &[$(Argument::$argument),*],)*
                }
            }

            /// What it leaves changed.
            pub const fn touches(self) -> Touch {
                match self {
                    $(Plain::$name => Touch::$touch,)*
                }
            }

            /// Whether an event handler may run before it is done.
            pub const fn waits(self) -> bool {
                match self {
                    $(Plain::$name => manner!($manner),)*
                }
            }

            /// Its instruction.
            pub const fn op(self) -> $crate::isa::Op {
                match self {
                    $(Plain::$name => $crate::isa::Op::$name,)*
                }
            }

            /// The statement of an instruction.
            pub const fn of(op: $crate::isa::Op) -> Option<Plain> {
                match op {
                    $($crate::isa::Op::$name => Some(Plain::$name),)*
                    _ => None,
                }
            }

            /// The statement that begins with a keyword.
            #[cfg(feature = "compiler")]
            pub const fn of_word(word: $crate::front::words::Kw) -> Option<Plain> {
                match word {
                    $($crate::front::words::Kw::$name => Some(Plain::$name),)*
                    _ => None,
                }
            }

            /// Its keyword.
            #[cfg(feature = "compiler")]
            pub const fn word(self) -> $crate::front::words::Kw {
                match self {
                    $(Plain::$name => $crate::front::words::Kw::$name,)*
                }
            }
        }
    };
}

crate::plain_rows!([plain]);
