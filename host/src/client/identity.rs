//! Identity of a board: versions, fingerprints, program store.

use std::time::Duration;

use lang::image::crc_in;
use lang::isa::FINGERPRINT;
use lang::part::{G2553, PARTS, Part};
use lang::profile::Profile;
use lang::record::{BoardRecord, MoreRecord, RECORD_VERSION, ThresholdRecord};
use lang::wire;
use serde::Serialize;

use super::{Client, ClientError};
use crate::link::Link;

/// What a board says of itself.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Identity {
    /// Version of the register map.
    pub wire_version: u16,
    /// Version of the firmware, `major.minor`.
    pub firmware: String,
    /// Fingerprint of the instruction set.
    pub instruction_set: u16,
    /// [`lang::record::feature`] bits of what the firmware runs.
    pub features: u16,
    /// Bytes for programs in all.
    pub area_bytes: u16,
    /// Largest image that fits beside the stored program.
    pub free_bytes: u16,
    /// Length of the stored program, 0 for none.
    pub program_bytes: u16,
    /// CRC of the stored program.
    pub program_crc: u16,
    /// Why the board came up, as IFG1 had it: bit 0 watchdog, 2 power on, 3 RST pin, 4 NMI.
    pub reset_cause: u16,
    /// Bytes of stack never used since reset.
    pub stack_free: u16,
    /// Milliseconds that were served late since reset.
    pub missed_deadlines: u16,
}

/// The part whose firmware has these features; of several the last one, which is sold.
pub fn part_of(features: u16) -> &'static Part {
    PARTS.iter().rev().find(|part| part.features == features).unwrap_or(&G2553)
}

/// What `count` late step events mean, a clause; nothing of none.
pub fn late_clause(count: u16) -> Option<String> {
    let events = match count {
        0 => return None,
        1 => "1 step event",
        _ => &format!("{count} step events"),
    };
    Some(format!("{events} came some us late; no step was lost, and no pulse shortened"))
}

impl<L: Link> Client<L> {
    /// Asks who the board is.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn identity(&mut self) -> Result<Identity, ClientError> {
        let words = self.holding(wire::OWN, wire::MISSED_DEADLINES - wire::OWN + 1)?;
        let at = |register: u16| words[usize::from(register - wire::OWN)];
        let firmware = at(wire::FIRMWARE_VERSION);
        // Beside it a part that takes slow points tells of lines that came too late.
        let whole = part_of(at(wire::FEATURES)).course_pool == 0;
        Ok(Identity {
            wire_version: at(wire::VERSION),
            firmware: format!("{}.{}", firmware >> 8, firmware & 0xFF),
            instruction_set: at(wire::ISA_FINGERPRINT),
            features: at(wire::FEATURES),
            area_bytes: at(wire::AREA_BYTES),
            free_bytes: at(wire::FREE_BYTES),
            program_bytes: at(wire::PROGRAM_LENGTH),
            program_crc: at(wire::PROGRAM_CRC),
            reset_cause: at(wire::RESET_CAUSE),
            stack_free: at(wire::STACK_FREE),
            missed_deadlines: at(wire::MISSED_DEADLINES) & if whole { 0xFFFF } else { 0xFF },
        })
    }

    /// Step events that came late since reset, modulo 65536; 0 of a board that cannot have any.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn late_events(&mut self) -> Result<u16, ClientError> {
        Ok(self.holding(wire::LATE_EVENTS, 1)?[0])
    }

    /// What there is to say of step events that came late since `before` was read, a clause; nothing of none.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn late_since(&mut self, before: u16) -> Result<Option<String>, ClientError> {
        Ok(late_clause(self.late_events()?.wrapping_sub(before)))
    }

    /// Hardware revision of its chip, 0 of one that does not tell it.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn chip_revision(&mut self) -> Result<u16, ClientError> {
        Ok(self.holding(wire::CHIP_REVISION, 1)?[0])
    }

    /// Cells of the stored program.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn program_cells(&mut self) -> Result<u16, ClientError> {
        Ok(self.holding(wire::PROGRAM_CELLS, 1)?[0].min(most_cells()))
    }

    /// The board's part of its profile.
    ///
    /// # Errors
    /// [`ClientError::Locked`]; see [`ClientError`].
    pub fn board_record(&mut self) -> Result<BoardRecord, ClientError> {
        let words = self.holding(wire::PROFILE_WINDOW, BoardRecord::SIZE as u16 / 2)?;
        let mut bytes = [0; BoardRecord::SIZE];
        for (pair, word) in bytes.chunks_exact_mut(2).zip(words) {
            pair.copy_from_slice(&word.to_le_bytes());
        }
        let mut record = BoardRecord::from_bytes(&bytes);
        if record.version == 0 {
            return Err(ClientError::Locked);
        }
        if record.more_crc != 0 {
            let words = self.holding(wire::PROFILE_MORE, MoreRecord::SIZE as u16 / 2)?;
            let mut bytes = [0; MoreRecord::SIZE];
            for (pair, word) in bytes.chunks_exact_mut(2).zip(words) {
                pair.copy_from_slice(&word.to_le_bytes());
            }
            record.more = MoreRecord::from_bytes(&bytes);
        }
        Ok(record)
    }

    /// Writes the board's part of a profile; it holds from the next reset on.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn set_board_record(&mut self, record: &BoardRecord) -> Result<(), ClientError> {
        if record.flags & BoardRecord::STEP_LOW != 0 && !self.identity()?.part().shapes_steps {
            return Err(ClientError::NoStepLow);
        }
        // In ascending order, as many at a time as every board takes; the first word erases, the last one makes it
        // valid, with what was written between.
        let words = words_of(&record.to_bytes());
        let (head, last) = words.split_at(if record.more_crc == 0 { 16 } else { words.len() - 1 });
        self.write_words(wire::PROFILE_WINDOW, head)?;
        if record.more_crc != 0 {
            self.write_words(wire::PROFILE_MORE, &words_of(&record.more.to_bytes())).map_err(
                |error| match error {
                    error if error.is_exception(wire::Exception::IllegalAddress) => {
                        ClientError::NoPwm
                    }
                    error => error,
                },
            )?;
        }
        self.write_words(wire::PROFILE_WINDOW + head.len() as u16, last)
    }

    fn write_words(&mut self, first: u16, words: &[u16]) -> Result<(), ClientError> {
        for (i, part) in words.chunks(16).enumerate() {
            self.write_all(first + 16 * i as u16, part)?;
        }
        Ok(())
    }

    /// Resets the board; it answers again after some 200 ms, by its new profile.
    ///
    /// # Errors
    /// The board refuses: a program runs or an axis moves.
    pub fn restart(&mut self) -> Result<(), ClientError> {
        match self.control(wire::Control::Restart) {
            // It may reset before its reply is out.
            Err(error) if !error.may_be_done() => Err(error),
            _ => {
                self.link().pause(Duration::from_millis(400));
                Ok(())
            }
        }
    }
}

impl Identity {
    /// Whether the stored program is this image, by its length and CRC.
    pub fn holds(&self, image: &[u8]) -> bool {
        (usize::from(self.program_bytes), self.program_crc) == (image.len(), crc_in(image))
    }

    /// The part whose firmware has these features; of several the last one, which is sold.
    pub fn part(&self) -> &'static Part {
        part_of(self.features)
    }

    /// Whether this tool can talk to the board; otherwise what differs and what to do.
    ///
    /// # Errors
    /// The text names the difference and the remedy.
    pub fn check(&self) -> Result<(), String> {
        if self.wire_version != wire::WIRE_VERSION {
            return Err(format!(
                "the board's register map has version {}, this tool's has {}: `pasapas flash` \
                 brings the board this tool's firmware",
                self.wire_version,
                wire::WIRE_VERSION
            ));
        }
        if self.instruction_set != FINGERPRINT {
            return Err(format!(
                "the board's instruction set is {:04X}, this tool's is {FINGERPRINT:04X}: \
                 `pasapas flash` brings the board this tool's firmware",
                self.instruction_set
            ));
        }
        Ok(())
    }
}

/// Cells that the map of holding registers has room for, two registers each. Input registers count from
/// 0 as well: another block may begin at the same number.
pub fn most_cells() -> u16 {
    let holding = wire::Table::Holding as u8;
    let fits = |block: &&wire::Block| block.table == holding && block.first == wire::CELLS;
    wire::BLOCKS.iter().find(fits).map_or(0, |block| block.count / 2)
}

fn words_of(bytes: &[u8]) -> Vec<u16> {
    bytes.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect()
}

/// Names of what differs between the board's part of a profile and what the board holds.
pub fn differences(board: &BoardRecord, wanted: &BoardRecord) -> Vec<&'static str> {
    let mut names = Vec::new();
    let mut compare = |name, same: bool| {
        if !same {
            names.push(name);
        }
    };
    compare("version", board.version == RECORD_VERSION);
    let knows = board.flags & BoardRecord::UNWIRED == 0;
    compare("its wiring, which the board was never told", knows);
    compare("wiring or autorun", !knows || board.flags == wanted.flags);
    compare("link", (board.address, board.rate) == (wanted.address, wanted.rate));
    compare("pulse width", (board.pulse, board.setup) == (wanted.pulse, wanted.setup));
    compare("filter time", board.filter == wanted.filter);
    let step = |record: &BoardRecord| record.flags & BoardRecord::STEP_LOW;
    compare("polarity of STEP", step(board) == step(wanted));
    compare(
        "polarity of inputs",
        (board.input_invert, board.input_invert_high)
            == (wanted.input_invert, wanted.input_invert_high),
    );
    let roles = |record: &BoardRecord| {
        let BoardRecord { probe, reference, emergency, start, stop, hold, door, .. } = *record;
        (probe, reference, emergency, start, stop, hold, door)
    };
    compare("roles of inputs", roles(board) == roles(wanted));
    compare("polarity of outputs", board.output_invert == wanted.output_invert);
    let states = |record: &BoardRecord| {
        let BoardRecord { reset_on, pause, fault, end, spin_up, .. } = *record;
        (reset_on, pause, fault, end, spin_up)
    };
    compare("states of outputs", states(board) == states(wanted));
    let roles = |record: &BoardRecord| {
        let BoardRecord { laser, lamp, enable, spindle, .. } = *record;
        (laser, lamp, enable, spindle)
    };
    compare("roles of outputs", roles(board) == roles(wanted));
    let rs485 = |record: &BoardRecord| {
        let more = record.more();
        (more.rs485_address, more.rs485_rate)
    };
    compare("RS-485", rs485(board) == rs485(wanted));
    let pwm = |record: &BoardRecord| {
        let more = record.more();
        let pulses = (more.servo_low, more.servo_high);
        (more.pwm_hz, more.pwm_range, more.pwm_minimum, pulses, more.pwm_output, more.pwm_kind)
    };
    compare("PWM", pwm(board) == pwm(wanted));
    let analog = |record: &BoardRecord| {
        let mut levels = record.more().thresholds;
        levels[3].on &= !ThresholdRecord::SPARE;
        levels
    };
    compare("analog inputs", analog(board) == analog(wanted));
    let aout = |record: &BoardRecord| {
        let more = record.more();
        (more.aout_hz, more.aout_full, more.aout_safe)
    };
    compare("analog output", aout(board) == aout(wanted));
    names
}

/// Whether a board's part of its profile is that of a machine.
///
/// # Errors
/// In what it differs, and what to do.
pub fn must_match(held: &BoardRecord, profile: &Profile) -> Result<(), String> {
    let mut differ = differences(held, &BoardRecord::of(profile, held.sequence));
    // Where the board hangs on the line is no matter of the program.
    differ.retain(|what| !["link", "RS-485"].contains(what));
    if differ.is_empty() {
        return Ok(());
    }
    Err(format!(
        "the board's profile is not `{name}`, it differs in {}: `pasapas profile set {name}` \
         brings it (a file's name for a profile of your own)",
        differ.join(", "),
        name = profile.name
    ))
}

#[cfg(test)]
mod tests {
    use super::{differences, most_cells, must_match};
    use lang::profile::Profile;
    use lang::record::BoardRecord;

    #[test]
    fn all_cells_of_the_map_are_read() {
        // Another table has a block of 5 at the same number.
        assert_eq!(most_cells(), 36);
    }

    #[test]
    fn a_record_differs_from_another_machines_in_what_the_machines_differ_in() {
        let record = |name| BoardRecord::of(&Profile::built_in(name).expect("built in"), 3);
        let mill = record("mill");
        assert!(differences(&mill, &BoardRecord { sequence: 9, crc: 1, ..mill }).is_empty());
        assert_eq!(differences(&mill, &record("laser")), ["states of outputs", "roles of outputs"]);
        assert_eq!(differences(&mill, &record("charly")), ["pulse width"]);
    }

    #[test]
    fn a_board_that_was_never_told_its_wiring_is_no_machine() {
        for name in ["mill", "thesis"] {
            let profile = Profile::built_in(name).expect("built in");
            let refused = must_match(&BoardRecord::UNKNOWN, &profile).expect_err("it has none");
            let remedy = format!("`pasapas profile set {name}` brings it");
            assert!(refused.contains("its wiring, which the board was never told"), "{refused}");
            assert!(refused.contains(&remedy), "{refused}");
        }
    }
}
