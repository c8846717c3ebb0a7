//! Feeding a job to a board that runs it from RAM (lang's `wire` module, Streaming).

use lang::fault::Fault;
use lang::record::feature;
use lang::wire::{self, Called, End, Exception, Refusal, RunState, Stream};

use super::{Client, ClientError};
use crate::link::Link;

/// What a board that can stream holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slots {
    /// Pieces, the running one included.
    pub count: u16,
    /// Bytes of code and data in a piece.
    pub bytes: u16,
    /// Registers in one request.
    request: u16,
}

/// How a streamed run stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Standing {
    /// What the board does.
    pub state: Option<RunState>,
    /// Number of the fault, 0 for none.
    pub fault: u16,
    /// Where it happened, in the newest piece.
    pub fault_pc: u16,
    /// Where the newest piece stands.
    pub pc: u16,
    /// How the last run ended.
    pub end: Option<End>,
    /// Runs begun.
    pub runs: u16,
    /// Bit per axis.
    pub homed: u16,
    /// Input that keeps the board from starting, from 1, or 0.
    pub blocking: u16,
    /// Machine positions, steps.
    pub steps: [i32; 3],
    /// Commanded machine positions, steps; of the same instant.
    pub commanded: [i32; 3],
    /// Pieces accepted.
    pub accepted: u16,
    /// Pieces begun.
    pub begun: u16,
    /// The newest piece has ended and no other is there.
    pub dry: bool,
    /// How often motion stood because no piece was there.
    pub starved: u16,
    /// Why the newest piece was refused.
    pub refusal: Option<Refusal>,
    /// The run waits for a handler.
    pub call: Option<Call>,
}

/// A handler that a streamed run waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Call {
    /// Where the run stands.
    pub place: Called,
    /// Slot of the event.
    pub slot: u8,
    /// The fault, where it is no event.
    pub fault: Option<Fault>,
}

impl Call {
    /// What the register says.
    fn of(word: u16) -> Option<Call> {
        Some(Call {
            place: Called::from_number(word & 15)?,
            slot: (word >> 4 & 3) as u8,
            fault: Fault::from_number((word >> 8) as u8),
        })
    }
}

impl<L: Link> Client<L> {
    /// What the board holds of a streamed job; `None` when it cannot stream.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn stream_slots(&mut self) -> Result<Option<Slots>, ClientError> {
        if self.holding(wire::FEATURES, 1)?[0] & feature::STREAM == 0 {
            return Ok(None);
        }
        let words = self.holding(wire::STREAM_SLOTS, 3)?;
        Ok(Some(Slots { count: words[0], bytes: words[1], request: words[2].clamp(1, 123) }))
    }

    /// Forgets all pieces and brings the axes' part of the profile.
    ///
    /// # Errors
    /// See [`ClientError`]; busy while a program runs or an axis moves.
    pub fn stream_open(&mut self, slots: &Slots, machine: &[u8]) -> Result<(), ClientError> {
        self.stream_control(Stream::Open)?;
        self.window(slots, wire::STREAM_MACHINE, machine)
    }

    /// Writes a control code.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn stream_control(&mut self, code: Stream) -> Result<(), ClientError> {
        self.write(wire::STREAM_CONTROL, code as u16)
    }

    /// Brings piece number `number`; `false` when no slot is free.
    ///
    /// # Errors
    /// See [`ClientError`]; device failure when the board refuses the piece.
    pub fn stream_piece(
        &mut self,
        slots: &Slots,
        number: u16,
        bytes: &[u8],
    ) -> Result<bool, ClientError> {
        match self.window(slots, wire::STREAM_PIECE, bytes) {
            Ok(()) => Ok(true),
            // After a lost reply the piece may be there already.
            Err(error) if error.is_exception(Exception::Busy) => {
                Ok(self.holding(wire::STREAM_ACCEPTED, 1)?[0] == number.wrapping_add(1))
            }
            Err(error) => Err(error),
        }
    }

    fn window(&mut self, slots: &Slots, first: u16, bytes: &[u8]) -> Result<(), ClientError> {
        let words: Vec<u16> = bytes
            .chunks(2)
            .map(|pair| u16::from_le_bytes([pair[0], pair.get(1).copied().unwrap_or(0xFF)]))
            .collect();
        // In parts of equal size: short ones are mostly silence between frames.
        let parts = words.len().div_ceil(usize::from(slots.request)).max(1);
        let mut address = first;
        for part in words.chunks(words.len().div_ceil(parts).max(1)) {
            self.write_all(address, part)?;
            address += part.len() as u16;
        }
        Ok(())
    }

    /// How the run stands.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn stream_standing(&mut self) -> Result<Standing, ClientError> {
        // Words are of the instant when they are sent. A run that waits for a handler stands still, so
        // what comes behind that word is true.
        let first = wire::STREAM_CALL;
        let words = self.holding(first, wire::STREAM_RESULT - first + 1)?;
        let at = |register: u16| words[usize::from(register - first)];
        let place = |first: u16| {
            [0, 2, 4].map(|n| super::status::long(at(first + n), at(first + n + 1)))
        };
        Ok(Standing {
            state: RunState::from_number(at(wire::RUN_STATE)),
            fault: at(wire::FAULT),
            fault_pc: at(wire::FAULT_PC),
            pc: at(wire::PROGRAM_COUNTER),
            end: End::from_number(at(wire::LAST_END)),
            runs: at(wire::RUN_COUNT),
            homed: at(wire::HOMED),
            blocking: at(wire::BLOCKING_INPUT),
            steps: place(wire::MACHINE_POSITIONS),
            commanded: place(wire::COMMANDED),
            accepted: at(wire::STREAM_ACCEPTED),
            begun: at(wire::STREAM_BEGUN),
            dry: at(wire::STREAM_DRY) != 0,
            starved: at(wire::STREAM_STARVED),
            refusal: Refusal::from_number(at(wire::STREAM_RESULT)),
            call: Call::of(at(wire::STREAM_CALL)),
        })
    }

    /// The value that a piece left for the host.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn stream_answer(&mut self) -> Result<i32, ClientError> {
        let words = self.holding(wire::CELLS, 2)?;
        Ok(super::status::long(words[0], words[1]))
    }
}
