//! Writes to flash addresses: who waits for them, and what becomes of the cells.

use super::Bus;
use crate::f5::periph::flash::{Action, LOWEST_MCLK, LOWEST_MV, ROW, Refusal};
use crate::periph::flash as cells;
use crate::rng::Rng;
use crate::warn::Kind;

impl Bus {
    /// An instruction wrote `value` under `mask` to the word at `addr`.
    pub(super) fn write_flash(&mut self, addr: u32, value: u16, mask: u16) {
        self.catch_up();
        let from_flash = self.is_flash(self.pc);
        if self.flash_is_busy() {
            // Only code in RAM comes here: in a block it must wait for WAIT.
            if self.flash.row.is_some() {
                self.flash.abort_block();
            } else {
                self.flash.violate();
            }
            self.warn(Kind::FlashBusy, addr);
            return self.update();
        }
        let action = match self.flash.action(&self.part, addr) {
            Ok(action) => action,
            Err(refusal) => {
                if refusal == Refusal::NoMode {
                    self.flash.violate();
                }
                self.warn(Kind::FlashLocked, addr);
                return self.update();
            }
        };
        let mclk = self.part.ticks_per_second / self.cycle.max(1);
        if mclk < LOWEST_MCLK || self.vcc < LOWEST_MV {
            self.warn(Kind::FlashSupply, addr);
        }
        match action {
            Action::LongWord => self.long_word(addr, value, mask, from_flash),
            Action::Block => self.block_write(addr, value, mask, from_flash),
            Action::Bank if from_flash => {
                // Erratum FLASH34: what it erases nobody can tell.
                self.warn(Kind::FlashErratum, addr);
                self.flash.violate();
                self.update();
            }
            _ => self.operate(action, &[(addr, value, mask)], from_flash),
        }
    }

    /// The second word of an aligned long word programs both.
    fn long_word(&mut self, addr: u32, value: u16, mask: u16, from_flash: bool) {
        let long = addr & !3;
        if !self.silicon.long_word_pairs || mask != 0xFFFF {
            self.warn(Kind::FlashErratum, addr);
            self.flash.violate();
            return self.update();
        }
        match self.flash.half.take() {
            Some((other, half, first)) if other == long && half != addr => {
                let words = [(half, first, mask), (addr, value, mask)];
                self.operate(Action::LongWord, &words, from_flash);
            }
            _ => self.flash.half = Some((long, addr, value)),
        }
    }

    /// Long words of one row, one after the other, from RAM.
    fn block_write(&mut self, addr: u32, value: u16, mask: u16, from_flash: bool) {
        let row = addr / ROW;
        let other_row = self.flash.row.is_some_and(|begun| begun != row);
        if from_flash || other_row || mask != 0xFFFF {
            self.warn(Kind::FlashErratum, addr);
            self.flash.abort_block();
            return self.update();
        }
        let long = addr & !3;
        match self.flash.half.take() {
            Some((other, half, first)) if other == long && half != addr => {
                let words = [(half, first, mask), (addr, value, mask)];
                self.operate(Action::Block, &words, false);
                self.flash.row = Some(row);
            }
            _ => self.flash.half = Some((long, addr, value)),
        }
    }

    /// Does what the mode says, and lets the time pass.
    fn operate(&mut self, action: Action, words: &[(u32, u16, u16)], from_flash: bool) {
        let Some((addr, ..)) = words.first().copied() else { return };
        let us = self.flash.microseconds(action, self.flash.row.is_none());
        let mut cut = self.flash.begin();
        let lost = cut.is_some();
        let main = (*self.part.flash.start(), *self.part.flash.end());
        let mut busy = (*self.part.info.start(), main.1);
        match action {
            Action::Program | Action::LongWord | Action::Block => {
                self.program(words, us, cut.as_mut());
            }
            Action::Segment => {
                if let Some((start, len)) = self.part.segment(addr) {
                    self.erase(start, start + (len - 1), &mut cut);
                }
            }
            Action::Bank => {
                let bank = self.part.bank(addr).unwrap_or(main);
                busy = bank;
                self.erase(bank.0, bank.1, &mut cut);
            }
            Action::Mass => self.erase(main.0, main.1, &mut cut),
        }
        self.attention = true;
        if lost {
            self.power_lost = true;
            return;
        }
        self.flash_written = true;
        let time = self.ticks(us.into());
        if from_flash {
            // Code in flash stands still; the peripherals go on.
            self.now += time;
        } else {
            self.flash.busy_until = self.now + time;
            self.flash.busy_range = busy;
            if action.erases() {
                self.flash.erasing = Some(self.part.segment(addr).unwrap_or(main));
            }
            self.update();
        }
    }

    fn program(&mut self, words: &[(u32, u16, u16)], us: u32, mut cut: Option<&mut Rng>) {
        for (addr, value, mask) in words {
            let cells = (*addr, *value, *mask);
            let wear = &mut self.flash.wear;
            let count = cells::program(wear, &mut self.mem[..], cells, cut.as_deref_mut());
            if count > 2 && *mask == 0xFFFF {
                self.warn(Kind::FlashRewritten, *addr);
            }
            self.changed(addr & !1, addr | 1);
        }
        if let Some((addr, ..)) = words.first()
            && self.flash.add_row_time(*addr, us)
        {
            self.warn(Kind::FlashRowTime, *addr);
        }
    }

    fn erase(&mut self, first: u32, last: u32, cut: &mut Option<Rng>) {
        let mut at = first;
        while let Some((start, len)) = self.part.segment(at) {
            cells::erase(&mut self.flash.wear, &mut self.mem[..], (start, len), cut.as_mut());
            at = start + len;
            if at > last {
                break;
            }
        }
        self.flash.forget_rows(first, last);
        self.changed(first, last);
    }

    /// Power fails while an erase that code in RAM started is under way: it is half done.
    pub(super) fn interrupted_erase(&mut self) {
        let erasing = self.flash.erasing.take();
        if let Some(segment) = erasing.filter(|_| self.flash_is_busy()) {
            let mut rng = Rng::new(self.now);
            for at in segment.0..segment.0 + segment.1 {
                if let Some(byte) = self.mem.get_mut(at as usize) {
                    *byte = rng.bits() as u8 | rng.bits() as u8;
                }
            }
            self.changed(segment.0, segment.0 + segment.1 - 1);
        }
        self.flash.busy_until = 0;
    }

    fn changed(&mut self, start: u32, end: u32) {
        self.code_changed = Some(match self.code_changed {
            Some((s, e)) => (s.min(start), e.max(end)),
            None => (start, end),
        });
        self.attention = true;
    }
}
