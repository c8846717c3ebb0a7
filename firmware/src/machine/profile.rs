//! Writing of the board's profile over the link.

use crate::machine::chip::Chip;
use crate::machine::controller::Controller;
use crate::machine::reset;
use lang::record::BoardRecord;
use lang::wire::{Exception, PROFILE_MORE, PROFILE_WINDOW};

/// The word of the profile at a register; what belongs to the record lies behind it.
pub fn profile_word(address: u16) -> u16 {
    match address {
        PROFILE_MORE.. => address - PROFILE_MORE + BoardRecord::SIZE as u16 / 2,
        _ => address - PROFILE_WINDOW,
    }
}

impl<C: Chip> Controller<C> {
    /// A word of the copy of the profile that is not in use; the last one makes it valid.
    pub fn write_profile(&mut self, index: u16, value: u16) -> Result<(), Exception> {
        self.idle()?;
        if self.lock.closed {
            return self.lock.unlock(self.record.lock, index, value);
        }
        let current = C::address_of(&self.record);
        let [first, second] = C::PART.profiles;
        let copy = if current == first { second } else { first };
        if index == 0 {
            self.chip.erase(copy);
        }
        let address = copy + 2 * index;
        self.chip.write(address, value);
        if self.chip.word(address) != value {
            return Err(Exception::DeviceFailure);
        }
        if index == BoardRecord::SIZE as u16 / 2 - 1 && reset::profile(&self.chip, copy).is_none() {
            return Err(Exception::DeviceFailure);
        }
        Ok(())
    }
}
