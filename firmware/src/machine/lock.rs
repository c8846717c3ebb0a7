//! The lock of program and profile (`lang::wire`, Lock).

use lang::wire::{Exception, LOCK_CODE, PROFILE_WINDOW};

/// What is known of the code since reset.
#[derive(Clone, Copy)]
pub struct Lock {
    /// Program and profile are locked.
    pub closed: bool,
    /// The low word was given.
    half: bool,
    /// A word was wrong: no code is taken any more.
    wrong: bool,
}

impl Lock {
    /// At reset, by the profile's code.
    pub fn new(code: [u16; 2]) -> Lock {
        Lock { closed: code[0] != 0, half: false, wrong: false }
    }

    /// A word for register `index` of the locked profile: of its `code`, or refused. The high one opens
    /// the lock when both were right and none before was wrong.
    ///
    /// # Errors
    /// Device failure.
    pub fn unlock(&mut self, code: [u16; 2], index: u16, word: u16) -> Result<(), Exception> {
        let high = match index.wrapping_sub(LOCK_CODE - PROFILE_WINDOW) {
            0 => false,
            1 => true,
            _ => return Err(Exception::DeviceFailure),
        };
        self.wrong |= word != code[usize::from(high)];
        if !high {
            self.half = true;
            return Ok(());
        }
        if self.wrong || !self.half {
            return Err(Exception::DeviceFailure);
        }
        self.closed = false;
        Ok(())
    }
}
