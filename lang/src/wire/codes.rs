//! The codes that registers hold and take, and the exceptions.

macro_rules! codes {
    (
        $(#[doc = $about:literal])+
        $name:ident { $($(#[doc = $doc:literal])+ $code:ident = $value:literal,)* }
    ) => {
        $(#[doc = $about])+
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u8)]
        pub enum $name { $($(#[doc = $doc])+ $code = $value,)* }

        impl $name {
            /// Every code.
            pub const ALL: &'static [$name] = &[$($name::$code),*];

            /// What they are, and number, name and meaning of each, for documents.
            #[cfg(any(test, feature = "compiler"))]
            pub const TABLE: Codes = (
                concat!($($about),+),
                &[$(($value, stringify!($code), concat!($($doc),+)),)*],
            );

            /// The code with this number, if there is one.
            pub const fn from_number(n: u16) -> Option<$name> {
                match n { $($value => Some($name::$code),)* _ => None }
            }
        }
    };
}

/// What the codes of a table are, and number, name and meaning of each.
#[cfg(any(test, feature = "compiler"))]
pub type Codes = (&'static str, &'static [(u16, &'static str, &'static str)]);

codes! {
    /// What [`RUN_CONTROL`](super::RUN_CONTROL) takes.
    Control {
        /// As the Start button.
        Start = 1,
        /// End the run on a ramp; without one, what commands move comes to rest.
        Stop = 2,
        /// As the Stop button: ramp down and pause; without a run as Stop.
        Pause = 3,
        /// Go on after a pause.
        Resume = 4,
        /// Steps cease at once, F14 is latched.
        EmergencyStop = 5,
        /// Acknowledge a latched fault without starting.
        Acknowledge = 6,
        /// Reset the chip; exception 6 while a program runs or an axis moves.
        Restart = 7,
    }
}

codes! {
    /// What [`RUN_STATE`](super::RUN_STATE) shows.
    RunState {
        /// No program is stored.
        Empty = 0,
        /// A program is stored.
        Ready = 1,
        /// The program runs.
        Running = 2,
        /// The program is paused and every axis rests.
        Paused = 3,
        /// A fault is latched; Start acknowledges.
        Fault = 4,
        /// The program runs and waits for Start.
        WaitStart = 5,
        /// Ramping down to a pause or to the end.
        Stopping = 6,
    }
}

codes! {
    /// What an observer of the chip sees beside the events of the trace.
    Seen {
        /// A byte of a printed line.
        Byte = 0,
        /// A run begins.
        Begun = 1,
        /// What was printed of a line comes to nothing: its statement failed.
        Abandoned = 2,
    }
}

codes! {
    /// How the last run ended ([`LAST_END`](super::LAST_END)).
    End {
        /// None has ended since reset.
        None = 0,
        /// By END.
        Done = 1,
        /// By a stop.
        Stopped = 2,
        /// By a fault.
        Fault = 3,
    }
}

codes! {
    /// What [`UPLOAD_CONTROL`](super::UPLOAD_CONTROL) takes.
    Upload {
        /// Take an image beside the stored program.
        Begin = 1,
        /// Take an image in place of the stored program.
        Replace = 2,
        /// Check it and make it the stored program.
        Commit = 3,
        /// Erase the stored program.
        Erase = 4,
    }
}

codes! {
    /// What [`STREAM_CONTROL`](super::STREAM_CONTROL) takes.
    Stream {
        /// Forget all pieces; the next one has number 0.
        Open = 1,
        /// Run the pieces that are there.
        Run = 2,
        /// The last piece is there.
        Finish = 3,
    }
}

codes! {
    /// Where a streamed run stands that waits for a handler ([`STREAM_CALL`](super::STREAM_CALL)).
    Called {
        /// Behind the statement at [`PROGRAM_COUNTER`](super::PROGRAM_COUNTER) of the newest piece. FFFF there is in front of
        /// the piece's first statement.
        Behind = 1,
        /// In that statement: it waits.
        Within = 2,
        /// Behind it, and no piece was there.
        Idle = 3,
        /// The statement at [`FAULT_PC`](super::FAULT_PC) failed.
        Failed = 4,
    }
}

codes! {
    /// Why an image is not accepted ([`UPLOAD_RESULT`](super::UPLOAD_RESULT)); 0 is accepted.
    Refusal {
        /// It was accepted.
        None = 0,
        /// No upload was begun, or the length is none.
        NotBegun = 1,
        /// It does not fit.
        TooLong = 2,
        /// The words that arrived are not the length that was announced.
        Incomplete = 3,
        /// Its CRC is wrong.
        Crc = 4,
        /// Its format or instruction set is not this firmware's.
        Version = 5,
        /// It uses a feature that this firmware lacks.
        Feature = 6,
        /// It wants more cells, stack or calls than there are.
        Memory = 7,
        /// The code does not pass the check.
        Code = 8,
        /// The flash does not hold what was written.
        Flash = 9,
    }
}

codes! {
    /// What a trace event is; its argument and value are named with each.
    TraceKind {
        /// No event.
        None = 0,
        /// Argument: axis, bit 7 ok. Value: position in steps.
        Home = 1,
        /// MoveAxe, MoveRel. Targets are in [`COMMANDED`](super::COMMANDED).
        Axe = 2,
        /// G0.
        Rapid = 3,
        /// G1.
        Line = 4,
        /// G2, G3.
        Arc = 5,
        /// Argument: output. Value: 0 or 1.
        Out = 6,
        /// Value: ms.
        Wait = 7,
        /// Argument: input, bit 7 ok. Value: wanted state or edge's new state.
        WaitIn = 8,
        /// Argument: axis, bit 7 ok. Value: position in steps.
        Probe = 9,
        /// The line stands in the print ring up to its LF.
        Print = 10,
        /// Value: character.
        Send = 11,
        /// Argument: bit 7 ok. Value: character.
        WaitChar = 12,
        /// Argument: bit 7 ok.
        WaitStart = 13,
        /// MoveSpeed. Argument: axis. Value: steps/s, signed.
        Speed = 14,
        /// StopAxe. Argument: axis.
        Stop = 15,
        /// Argument: [`End`]. Value: fault number; positions are in [`COMMANDED`](super::COMMANDED).
        End = 16,
        /// RUN. Argument: number of the program that begins; what follows stands in its code.
        Run = 17,
        /// SetAout. Argument: analog output, bit 6 a share, bit 7 on the way of a path. Value: mV, or steps of the share.
        Aout = 18,
    }
}

codes! {
    /// What the board answers a request with that it refuses (Modbus Application Protocol V1.1b3, 7).
    Exception {
        /// The function is not one of 1 to 6, 15, 16.
        IllegalFunction = 1,
        /// There is no such block, or the request leaves it.
        IllegalAddress = 2,
        /// A value or count lies outside its range.
        IllegalValue = 3,
        /// Refused: no program, or an image or a profile that failed its check.
        DeviceFailure = 4,
        /// Not now: a program runs, or an axis moves.
        Busy = 6,
    }
}

codes! {
    /// What command 1200 does.
    Direct {
        /// Acknowledge a latched fault.
        Acknowledge = 88,
        /// Go on after a pause.
        Resume = 129,
        /// Ramp down and pause.
        Pause = 130,
        /// End what command 1111 or 102 moves, on a ramp.
        StopJog = 133,
        /// End the run, or every move by command, on a ramp.
        Stop = 255,
    }
}
