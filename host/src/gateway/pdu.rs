//! Requests as a gateway needs them: which addresses they touch, whether they write, how long the reply is.
//!
//! A request that no board could answer is refused here and takes no time on the line. Source: Modbus
//! Application Protocol V1.1b3, section 6.

use std::ops::Range;

use lang::wire::{self, Exception, Table};

/// The board's line is not open: no way to it (V1.1b3, section 7).
pub const NO_PATH: u8 = 0x0A;
/// The board does not answer.
pub const NO_ANSWER: u8 = 0x0B;

/// What a well-formed request does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Touch {
    /// In which table.
    pub table: Table,
    /// From which address on.
    pub first: u16,
    /// How many bits or registers, at least 1.
    pub count: u16,
    /// Whether it writes them.
    pub write: bool,
}

/// The reply that refuses a request with an exception.
pub fn refusal(pdu: &[u8], code: u8) -> Vec<u8> {
    vec![pdu.first().copied().unwrap_or_default() | 0x80, code]
}

impl Touch {
    /// Reads a request.
    ///
    /// # Errors
    /// The exception that a board would answer with.
    pub fn of(pdu: &[u8]) -> Result<Touch, Exception> {
        let word = |at: usize| {
            let pair = pdu.get(at..at + 2).ok_or(Exception::IllegalValue)?;
            Ok(u16::from_be_bytes([pair[0], pair[1]]))
        };
        let function = *pdu.first().ok_or(Exception::IllegalFunction)?;
        let (table, write) = match function {
            1 => (Table::Coils, false),
            2 => (Table::Inputs, false),
            3 => (Table::Holding, false),
            4 => (Table::InputRegisters, false),
            5 | 15 => (Table::Coils, true),
            6 | 16 => (Table::Holding, true),
            _ => return Err(Exception::IllegalFunction),
        };
        let first = word(1)?;
        let second = word(3)?;
        let good = match function {
            1 | 2 => (1..=2000).contains(&second) && pdu.len() == 5,
            3 | 4 => (1..=125).contains(&second) && pdu.len() == 5,
            5 => matches!(second, 0 | 0xFF00) && pdu.len() == 5,
            6 => pdu.len() == 5,
            15 => (1..=1968).contains(&second) && has_data(pdu, usize::from(second).div_ceil(8)),
            _ => (1..=123).contains(&second) && has_data(pdu, 2 * usize::from(second)),
        };
        if !good {
            return Err(Exception::IllegalValue);
        }
        let count = if matches!(function, 5 | 6) { 1 } else { second };
        if usize::from(first) + usize::from(count) > 0x1_0000 {
            return Err(Exception::IllegalAddress);
        }
        Ok(Touch { table, first, count, write })
    }

    /// Its addresses.
    pub fn range(&self) -> Range<u32> {
        let first = u32::from(self.first);
        first..first + u32::from(self.count)
    }

    /// Bytes of the reply's function and data without an exception.
    pub fn reply_length(&self) -> usize {
        let count = usize::from(self.count);
        match (self.write, self.table) {
            (true, _) => 5,
            (false, Table::Coils | Table::Inputs) => 2 + count.div_ceil(8),
            (false, Table::Holding | Table::InputRegisters) => 2 + 2 * count,
        }
    }

    /// Whether any address of `others` in holding registers is among what it touches.
    fn meets(&self, others: Range<u16>) -> bool {
        let own = self.range();
        own.start < u32::from(others.end) && u32::from(others.start) < own.end
    }

    /// Whether an answer may be given again a moment later. Reading a trace slot takes an event, the
    /// print ring and a streamed job's registers are a conversation.
    pub fn may_be_kept(&self) -> bool {
        let registers = matches!(self.table, Table::Holding | Table::InputRegisters);
        let talks = [
            wire::STREAM_CALL..wire::STREAM_CALL + 1,
            wire::STREAM_ACCEPTED..wire::STREAM_RESULT + 1,
            wire::TRACE_EVEN..wire::CHAR_IN + 1,
        ];
        !(self.write || registers && talks.into_iter().any(|range| self.meets(range)))
    }

    /// Whether it ends motion and does nothing else: what each client that sees a board may do.
    pub fn only_stops(&self, pdu: &[u8]) -> bool {
        let run = u32::from(wire::RUN_CONTROL);
        let command = u32::from(wire::COMMAND);
        let own = [run..run + 1, command..command + 2];
        let inside = |range: &std::ops::Range<u32>| {
            range.contains(&self.range().start) && self.range().end <= range.end
        };
        self.is_stop(pdu) && own.iter().any(inside)
    }

    /// What it writes to a holding register, if it does.
    fn value(&self, pdu: &[u8], register: u16) -> Option<u16> {
        if !self.write || self.table != Table::Holding {
            return None;
        }
        // Function 6 has its value where function 16 has its count.
        let place = match pdu[0] {
            6 => 3,
            _ => 6 + 2 * usize::from(register.checked_sub(self.first)?),
        };
        let pair = pdu.get(place..place + 2).filter(|_| self.range().contains(&register.into()))?;
        Some(u16::from_be_bytes([pair[0], pair[1]]))
    }

    /// Whether the board checks a program before it replies ([`wire::check_ms`]): at a start, at the end of an
    /// upload, and when a program is selected.
    pub fn checks(&self, pdu: &[u8]) -> bool {
        self.value(pdu, wire::RUN_CONTROL) == Some(wire::Control::Start as u16)
            || self.value(pdu, wire::UPLOAD_CONTROL) == Some(wire::Upload::Commit as u16)
            || self.value(pdu, wire::SELECTED).is_some()
    }

    /// Whether it is one of the writes that end motion: they wait for nobody.
    pub fn is_stop(&self, pdu: &[u8]) -> bool {
        use wire::{Control, Direct, command};
        let value = |register: u16| self.value(pdu, register);
        let ends = [Control::Stop, Control::Pause, Control::EmergencyStop].map(|code| code as u16);
        let direct =
            [Direct::Pause, Direct::StopJog, Direct::Stop].map(|code| u16::from(code as u8));
        match (value(wire::RUN_CONTROL), value(wire::COMMAND)) {
            (Some(code), _) => ends.contains(&code),
            (_, Some(command::STOP_AXIS | command::STOP_AXES)) => true,
            (_, Some(command::DIRECT)) => {
                value(wire::COMMAND + 1).is_some_and(|code| direct.contains(&code))
            }
            _ => false,
        }
    }
}

/// Whether functions 15 and 16 have as many bytes as they say.
fn has_data(pdu: &[u8], bytes: usize) -> bool {
    pdu.get(5).is_some_and(|count| usize::from(*count) == bytes) && pdu.len() == 6 + bytes
}

#[cfg(test)]
mod tests {
    use super::Touch;
    use lang::wire::{self, Control, Exception, Table, command};

    fn write_all(first: u16, values: &[u16]) -> Vec<u8> {
        let mut pdu = vec![16];
        pdu.extend(first.to_be_bytes());
        pdu.extend((values.len() as u16).to_be_bytes());
        pdu.push(2 * values.len() as u8);
        pdu.extend(values.iter().flat_map(|value| value.to_be_bytes()));
        pdu
    }

    #[test]
    fn requests_of_the_standards_examples_are_read() {
        // V1.1b3, 6.1, 6.3, 6.5, 6.11, 6.12.
        let touch = |table, first, count, write| Touch { table, first, count, write };
        let examples: [(&[u8], Touch, usize); 5] = [
            (&[1, 0, 0x13, 0, 0x13], touch(Table::Coils, 0x13, 0x13, false), 5),
            (&[3, 0, 0x6B, 0, 3], touch(Table::Holding, 0x6B, 3, false), 8),
            (&[5, 0, 0xAC, 0xFF, 0], touch(Table::Coils, 0xAC, 1, true), 5),
            (&[15, 0, 0x13, 0, 0x0A, 2, 0xCD, 1], touch(Table::Coils, 0x13, 10, true), 5),
            (&[16, 0, 1, 0, 2, 4, 0, 0x0A, 1, 2], touch(Table::Holding, 1, 2, true), 5),
        ];
        for (pdu, wanted, reply) in examples {
            let touch = Touch::of(pdu).expect("good");
            assert_eq!(touch, wanted);
            assert_eq!(touch.reply_length(), reply, "{pdu:?}");
        }
    }

    #[test]
    fn what_no_board_could_answer_is_refused() {
        let cases: [(&[u8], Exception); 9] = [
            (&[], Exception::IllegalFunction),
            (&[43, 14, 1, 0], Exception::IllegalFunction),
            (&[3, 0, 0, 0, 0], Exception::IllegalValue),
            (&[3, 0, 0, 0, 126], Exception::IllegalValue),
            (&[3, 0, 0, 0], Exception::IllegalValue),
            (&[3, 0, 0, 0, 1, 0], Exception::IllegalValue),
            (&[5, 0, 0, 1, 0], Exception::IllegalValue),
            (&[16, 0, 1, 0, 2, 4, 0, 0x0A, 1], Exception::IllegalValue),
            (&[3, 0xFF, 0xFF, 0, 2], Exception::IllegalAddress),
        ];
        for (pdu, exception) in cases {
            assert_eq!(Touch::of(pdu), Err(exception), "{pdu:?}");
        }
    }

    #[test]
    fn what_ends_motion_is_known_in_every_form() {
        let [high, low] = wire::RUN_CONTROL.to_be_bytes();
        let one = |value: u8| vec![6, high, low, 0, value];
        let stops = [
            one(Control::Stop as u8),
            one(Control::EmergencyStop as u8),
            write_all(wire::RUN_CONTROL, &[Control::Stop as u16]),
            write_all(wire::COMMAND, &[command::STOP_AXES, 7]),
            write_all(wire::COMMAND, &[command::DIRECT, 255]),
        ];
        for pdu in stops {
            let touch = Touch::of(&pdu).expect("good");
            assert!(touch.is_stop(&pdu) && touch.only_stops(&pdu), "{pdu:?}");
        }
        // These write more than what ends motion.
        for pdu in [
            write_all(wire::RUN_CONTROL, &[Control::Stop as u16, 1]),
            write_all(wire::RUN_CONTROL - 1, &[1, Control::Stop as u16]),
            write_all(wire::COMMAND, &[command::STOP_AXES, 7, 1]),
        ] {
            assert!(!Touch::of(&pdu).expect("good").only_stops(&pdu), "{pdu:?}");
        }
        let others = [
            one(Control::Start as u8),
            write_all(wire::COMMAND, &[command::DIRECT, 129]),
            write_all(wire::COMMAND + 1, &[command::STOP_AXES]),
            write_all(wire::COMMAND, &[command::MOVE_BY, 1]),
            vec![3, high, low, 0, 2],
        ];
        for pdu in others {
            assert!(!Touch::of(&pdu).expect("good").is_stop(&pdu), "{pdu:?}");
        }
    }

    #[test]
    fn conversations_are_never_answered_from_memory() {
        let kept = |first: u16, count: u16| {
            let touch = Touch { table: Table::Holding, first, count, write: false };
            touch.may_be_kept()
        };
        assert!(kept(wire::RUN_STATE, 8));
        assert!(kept(wire::MACHINE_POSITIONS, 6));
        assert!(!kept(wire::TRACE_ODD, 5));
        assert!(!kept(wire::PRINT_COUNT, 2));
        assert!(!kept(wire::OWN, 125));
        assert!(!kept(wire::STREAM_CALL, 10));
    }
}
