//! The fault codes: one table for the VM, the firmware, the host and the manual.

// A row is `Name = number, whether ON ERROR can handle it, InterpCNC's alarm code, text, cause, remedy`.
macro_rules! faults {
    ($($name:ident = $n:literal, $handled:literal, $alarm:literal, $text:literal, $cause:literal, $remedy:literal;)*) => {
        /// Why a run stopped. The discriminant is the number that `ERR` gives and the link reports.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(u8)]
        pub enum Fault { $(#[doc = $text] $name = $n,)* }

        impl Fault {
            /// Every fault in numeric order.
            pub const ALL: &'static [Fault] = &[$(Fault::$name),*];

            /// The fault with this number, if there is one.
            pub const fn from_number(n: u8) -> Option<Fault> {
                match n { $($n => Some(Fault::$name),)* _ => None }
            }

            /// Whether `ON ERROR GOTO` can handle it (lang/README.md, Errors and events).
            pub const fn can_be_handled(self) -> bool {
                match self { $(Fault::$name => $handled,)* }
            }

            /// InterpCNC's alarm code of a fault's number (its input register 3004); 3, "other", for
            /// those that InterpCNC does not have.
            pub const fn alarm_of(n: u8) -> u8 {
                match n { $($n => $alarm,)* _ => 3 }
            }
        }

        #[cfg(feature = "compiler")]
        impl Fault {
            /// What happened, a few words.
            pub const fn text(self) -> &'static str {
                match self { $(Fault::$name => $text,)* }
            }

            /// Where it usually comes from.
            pub const fn cause(self) -> &'static str {
                match self { $(Fault::$name => $cause,)* }
            }

            /// What to do about it.
            pub const fn remedy(self) -> &'static str {
                match self { $(Fault::$name => $remedy,)* }
            }
        }
    };
}

faults! {
    Overflow = 1, true, 3, "overflow",
        "A result, or the place of an axis, does not fit into 32 bits.",
        "Divide before you multiply, or work in a larger unit; where an axis only feeds on, write SetPos X, 0mm between two feeds.";
    DivisionByZero = 2, true, 3, "division by zero",
        "The right side of / or MOD was 0.",
        "Test the divisor first.";
    ArrayIndex = 3, true, 3, "array index out of range",
        "An index was below 0 or not below the size of the array or table.",
        "Loop to COUNT(table) - 1, or to the size that DIM names less one.";
    BadShift = 4, true, 3, "bad shift",
        "A shift count was below 0 or above 31.",
        "Keep the count within 0..31.";
    SoftLimit = 5, true, 2, "soft limit",
        "The target lies outside the travel of a homed axis, or MoveSpeed has run it to the end of that travel.",
        "Check the target and the work offset against the profile's travel; a belt that runs on for ever is an axis without homing.";
    LimitSwitch = 6, false, 1, "limit switch",
        "A reference switch closed outside homing.",
        "Move the axis off its switch and home it again.";
    NotHomed = 7, true, 11, "not homed",
        "The profile demands homing before an absolute move.",
        "Write Home before the first move, or set the place with SetPos.";
    SpeedRange = 8, true, 3, "speed or acceleration out of range",
        "A speed or an acceleration was zero or negative.",
        "Give a positive speed; a negative one only to MoveSpeed.";
    Arc = 9, true, 3, "arc cannot be drawn",
        "The end misses the circle by more than 0.005 mm and 0.1 % of the radius, or no circle fits.",
        "Check I, J, K or R against the end point.";
    HomeNotFound = 10, true, 9, "homing: switch not found",
        "The reference switch did not close within the stroke.",
        "Check the switch, its wiring and the homing direction of the profile.";
    HomeStaysClosed = 11, true, 8, "homing: switch stays closed",
        "The reference switch did not open again.",
        "Check the switch and its polarity in the profile.";
    ProbeMissed = 12, true, 5, "probe missed",
        "The probe input did not answer before the limit.",
        "Check the limit and the probe, or write Probe? and test PROBEOK.";
    TimedOut = 13, true, 18, "wait timed out",
        "The input or character did not come in time.",
        "Raise the timeout, or write WaitIn? and test TIMEDOUT.";
    EmergencyStop = 14, false, 10, "emergency stop",
        "The emergency stop was pressed or sent. On the G2553, when no input is named, a line of a path may have come too late.",
        "Release it, press Start to acknowledge, and home again.";
    ImageRefused = 15, false, 3, "image refused",
        "The stored program failed its check.",
        "Upload it again with a matching version of the tool.";
    Stack = 16, false, 3, "stack",
        "RETURN without GOSUB, RESUME NEXT without a fault, or too many calls left open by GOTO.",
        "Leave subroutines by RETURN.";
    Watchdog = 17, false, 3, "watchdog",
        "The controller did not come round in time and was reset.",
        "Report it with the program that showed it.";
    LinkLost = 18, false, 3, "link lost while streaming",
        "The host stopped feeding the job.",
        "Check the cable and stream again from the last line.";
    InputActive = 19, true, 4, "input already active before probing",
        "The probe input had the wanted state before the move began.",
        "Move away from the work before probing.";
    ValueRange = 20, true, 3, "value out of range",
        "An argument lies outside what the statement accepts, SetPos or G92 names an axis that is moving, WaitMove one that MoveSpeed runs, or SYNC finds six actions that all lie after the path's end.",
        "Check the value against the manual; let the axis come to rest first: WaitMove after START, StopAxe after MoveSpeed; a shorter lag for SYNC.";
    NoProgram = 21, true, 3, "no such program",
        "The library holds no program of that name or number.",
        "Upload it (`pasapas upload FILE --as NAME`), or choose one of those that `pasapas list` shows.";
}

/// Text, cause and remedy of [`Fault::EmergencyStop`] where no stop was pressed or sent: a part that takes slow points had not
/// planned the next line of a path when the one before ended at speed.
#[cfg(feature = "compiler")]
pub const LATE_LINE: [&str; 3] = [
    "a line of a path came too late",
    "The next line was not planned when the one before ended at speed, so steps ceased at once and no axis knows where it is. No emergency stop was pressed or sent.",
    "Press Start to acknowledge and home again; a lower F, longer lines or a Wait 0ms before the path leave more time. Report it with the program that showed it.",
];

impl Fault {
    /// The number, 1..=21.
    pub const fn number(self) -> u8 {
        self as u8
    }
}

#[cfg(feature = "compiler")]
impl core::fmt::Display for Fault {
    /// `F05`.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "F{:02}", self.number())
    }
}

#[cfg(test)]
mod tests {
    use super::Fault;

    #[test]
    fn numbers_are_dense_and_round_trip() {
        for (i, &fault) in Fault::ALL.iter().enumerate() {
            assert_eq!(usize::from(fault.number()), i + 1);
            assert_eq!(Fault::from_number(fault.number()), Some(fault));
        }
        assert_eq!(Fault::from_number(0), None);
        assert_eq!(Fault::from_number(22), None);
    }
}
