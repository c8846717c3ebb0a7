//! The call stack: subroutines, functions, event handlers, error handlers.

use super::{BROKEN, Exit, NO_HANDLER, Stop, Vm, entry, flag};
use crate::fault::Fault;
use crate::isa::Op;
use crate::record::feature;

/// Bytes of an entry.
const ENTRY: usize = crate::part::F5529.call_bytes as usize;
/// Shift of the kind in an entry: the address lies below it.
const KIND: u32 = 24;

impl Vm<'_, '_> {
    fn entry_at(&self, index: u8) -> Option<usize> {
        self.image.header.pool_bytes().checked_sub((usize::from(index) + 1) * ENTRY)
    }

    /// Kind ([`super::entry`]) and address of an open call: where it goes back to, or of an error handler what
    /// failed.
    pub(super) fn call(&self, index: u8) -> Option<(u8, usize)> {
        let bytes = self.pool.get(self.entry_at(index)?..)?;
        let entry = u32::from_le_bytes(*bytes.first_chunk()?);
        let address = usize::try_from(entry & ((1 << KIND) - 1)).ok()?;
        Some(((entry >> KIND) as u8, address))
    }

    /// Kind and address of the newest entry.
    fn top(&self) -> Option<(u8, usize)> {
        self.call(self.state.calls.checked_sub(1)?)
    }

    fn open(&mut self, kind: u8, address: usize) -> Result<(), Fault> {
        if self.state.calls >= self.image.header.calls {
            return Err(Fault::Stack);
        }
        let at = self.entry_at(self.state.calls).ok_or(BROKEN)?;
        let bytes = self.pool.get_mut(at..).ok_or(BROKEN)?;
        let entry = u32::from(kind) << KIND | address as u32;
        *bytes.first_chunk_mut().ok_or(BROKEN)? = entry.to_le_bytes();
        self.state.calls += 1;
        Ok(())
    }

    /// Drops the newest entry; the values below a FUNCTION's frame are its caller's again.
    fn close(&mut self, kind: u8) {
        self.state.calls = self.state.calls.saturating_sub(1);
        if kind & entry::FUNC != 0 {
            self.state.base = self.state.base.saturating_sub(kind & !entry::FUNC);
        }
    }

    /// Calls, returns and what leaves a handler. `next` is the address behind the instruction.
    pub(super) fn transfer(&mut self, op: Op, pc: usize, next: usize) -> Result<usize, Stop> {
        let short = usize::from(self.byte(pc + 1));
        match op {
            Op::Call | Op::CallFar => {
                let target = if op == Op::Call { short } else { self.address(pc + 1)? };
                self.open(entry::SUB, next)?;
                Ok(target)
            }
            Op::Func => {
                let target = self.address(pc + 1)?;
                let depth = self.state.sp - self.state.base;
                let room = self.image.header.stack - self.image.header.frame;
                if self.state.sp > room || depth >= entry::FUNC {
                    return Err(Fault::Stack.into());
                }
                self.open(entry::FUNC | depth, next)?;
                self.state.base = self.state.sp;
                Ok(target)
            }
            Op::Gosub => {
                let target = self.address(pc + 1)?;
                self.open(entry::GOSUB, next)?;
                Ok(target)
            }
            Op::Return => self.go_back(false),
            Op::ExitSub => self.go_back(true),
            Op::Give => self.give(),
            Op::Leave => self.leave(next),
            _ => self.resume(op == Op::Resume),
        }
    }

    /// RETURN, and with `whole` EXIT SUB, which drops open GOSUBs.
    fn go_back(&mut self, whole: bool) -> Result<usize, Stop> {
        loop {
            let (kind, address) = self.top().ok_or(Fault::Stack)?;
            match kind {
                entry::GOSUB if whole => self.close(kind),
                entry::GOSUB | entry::SUB => {
                    self.close(kind);
                    return Ok(address);
                }
                entry::EVENT => {
                    self.close(kind);
                    self.state.flags &= !flag::EVENT;
                    self.state.pc = address;
                    return Err(Stop::Exit(Exit::HandlerEnd));
                }
                _ => return Err(Fault::Stack.into()),
            }
        }
    }

    /// RETURN of a FUNCTION: its value already lies where the caller expects it.
    fn give(&mut self) -> Result<usize, Stop> {
        loop {
            let (kind, address) = self.top().ok_or(Fault::Stack)?;
            if kind != entry::GOSUB && kind & entry::FUNC == 0 {
                return Err(Fault::Stack.into());
            }
            self.close(kind);
            if kind != entry::GOSUB {
                return Ok(address);
            }
        }
    }

    /// Before a GOTO: one that stands in the error handler itself leaves everything.
    fn leave(&mut self, next: usize) -> Result<usize, Stop> {
        match self.top() {
            Some((entry::ERROR | entry::ERROR_BETWEEN, _)) => {
                self.state.calls = 0;
                self.state.sp = 0;
                self.state.base = 0;
                self.state.flags &= !(flag::EVENT | flag::ERROR);
                self.state.pc = next;
                Err(Stop::Exit(Exit::HandlerEnd))
            }
            _ => Ok(next),
        }
    }

    /// RESUME NEXT, or with `again` RESUME.
    fn resume(&mut self, again: bool) -> Result<usize, Stop> {
        if self.state.flags & flag::ERROR == 0 {
            return Err(Fault::Stack.into());
        }
        loop {
            let (kind, address) = self.top().ok_or(BROKEN)?;
            self.close(kind);
            let next = match kind {
                entry::ERROR => {
                    // Code that no statement owns cannot fail, but an image may claim so.
                    let place = self.image.statements().and_then(|table| table.at(address));
                    let place = place.ok_or(Fault::Stack)?;
                    if again { place.start } else { place.resume }
                }
                entry::ERROR_BETWEEN => address,
                _ => continue,
            };
            self.state.sp = self.state.base;
            self.state.flags &= !flag::ERROR;
            self.state.pc = next;
            return Err(Stop::Exit(Exit::HandlerEnd));
        }
    }

    /// Whether an event handler may begin here. The caller also sees to it that `pc` is where a
    /// statement begins; behind an effect it is.
    pub const fn can_interrupt(&self) -> bool {
        let busy = flag::EVENT | flag::ERROR | flag::MORE | flag::WITHIN;
        self.state.flags & busy == 0 && self.state.sp == self.state.base
    }

    /// Begins the handler of event slot `slot`; [`Exit::HandlerEnd`] comes when it is over.
    ///
    /// # Errors
    /// F16 when the call stack is full.
    pub fn interrupt(&mut self, slot: u8) -> Result<(), Fault> {
        let target = self.image.event_target(slot).ok_or(BROKEN)?;
        self.open(entry::EVENT, self.state.pc)?;
        self.state.flags |= flag::EVENT;
        self.state.pc = target;
        Ok(())
    }

    /// A fault at `pc`: ERR and ERL take it, and the error handler begins if there is one.
    ///
    /// # Errors
    /// The run ends with this fault: no handler may take it.
    pub fn fault(&mut self, fault: Fault) -> Result<(), Fault> {
        let pc = self.state.pc;
        self.raise(fault, entry::ERROR, pc)
    }

    /// A fault that comes as an event does, while `pc` stands before a statement or in one that
    /// waits: RESUME NEXT goes on with that statement.
    ///
    /// # Errors
    /// The run ends with this fault: no handler may take it.
    pub fn fault_between(&mut self, fault: Fault) -> Result<(), Fault> {
        let pc = self.state.pc;
        let place = self.image.statements().and_then(|table| table.at(pc));
        self.raise(fault, entry::ERROR_BETWEEN, place.map_or(pc, |place| place.start))
    }

    fn raise(&mut self, fault: Fault, kind: u8, address: usize) -> Result<(), Fault> {
        self.state.fault = fault.number();
        self.state.fault_pc = self.state.pc;
        self.state.flags &= !(flag::MORE | flag::WITHIN);
        let handler = self.state.handler;
        if !fault.can_be_handled() || handler == NO_HANDLER || self.state.flags & flag::ERROR != 0 {
            return Err(fault);
        }
        // Without its table of statements nothing says where RESUME NEXT goes on.
        if !self.image.header.has(feature::LINES) {
            return Err(fault);
        }
        self.open(kind, address)?;
        self.state.sp = self.state.base;
        self.state.flags |= flag::ERROR;
        self.state.pc = handler;
        Ok(())
    }

    /// ERL.
    pub(super) fn fault_line(&self) -> i32 {
        if self.state.fault == 0 {
            return 0;
        }
        let place = self.image.statements().and_then(|table| table.at(self.state.fault_pc));
        place.map_or(0, |place| i32::try_from(place.line).unwrap_or(i32::MAX))
    }
}
