//! Writes to flash addresses.

use super::Bus;
use crate::periph::flash::{self, Action, Refusal};
use crate::warn::Kind;

/// Bytes of information segment A, which LOCKA protects from mass erases.
const SEGMENT_A: u32 = 64;

impl Bus {
    /// An instruction wrote `value` under `mask` to the word at `addr`.
    pub(super) fn write_flash(&mut self, addr: u16, value: u16, mask: u16) {
        self.catch_up_flash();
        let at = u32::from(addr);
        let action = match self.flash.action(&self.part, at) {
            Ok(action) => action,
            Err(refusal) => {
                if refusal == Refusal::NoMode {
                    self.flash.violate();
                }
                self.warn(Kind::FlashLocked, addr);
                self.update();
                return;
            }
        };
        let (time, allowed) = self.flash.duration(action, &self.clock.rates);
        if !allowed {
            self.warn(Kind::FlashClock, addr);
        }
        self.check_flash_supply(addr);
        let mut cut = self.flash.begin();
        let lost = cut.is_some();
        match action {
            Action::Program => {
                let wear = &mut self.flash.wear;
                let count =
                    flash::program(wear, &mut self.mem[..], (at, value, mask), cut.as_mut());
                if count > 2 && mask == 0xFFFF {
                    self.warn(Kind::FlashRewritten, addr);
                }
                self.changed(at & !1, at | 1);
            }
            Action::Segment => {
                if let Some((start, len)) = self.part.segment(at) {
                    flash::erase(
                        &mut self.flash.wear,
                        &mut self.mem[..],
                        (start, len),
                        cut.as_mut(),
                    );
                    self.changed(start, start + (len - 1));
                }
            }
            Action::Mass(info) => {
                self.erase_range(*self.part.flash.start(), *self.part.flash.end(), &mut cut);
                if info {
                    let end = *self.part.info.end();
                    let end = if self.flash.a_locked() { end - SEGMENT_A } else { end };
                    self.erase_range(*self.part.info.start(), end, &mut cut);
                }
            }
        }
        if lost {
            self.power_lost = true;
            self.attention = true;
            return;
        }
        self.flash_written = true;
        if self.is_flash(self.pc) {
            // Code in flash stands still; the peripherals go on.
            self.now += time;
        } else {
            self.flash.busy_until = self.now + time;
        }
        self.attention = true;
    }

    fn catch_up_flash(&mut self) {
        if self.next_event <= self.now {
            self.service();
        }
    }

    fn erase_range(&mut self, first: u32, last: u32, cut: &mut Option<crate::rng::Rng>) {
        let mut at = first;
        while let Some((start, len)) = self.part.segment(at) {
            flash::erase(&mut self.flash.wear, &mut self.mem[..], (start, len), cut.as_mut());
            match start.checked_add(len) {
                Some(next) if next <= last => at = next,
                _ => break,
            }
        }
        self.changed(first, last);
    }

    fn changed(&mut self, start: u32, end: u32) {
        let (start, end) = (start as u16, end as u16);
        self.code_changed = Some(match self.code_changed {
            Some((s, e)) => (s.min(start), e.max(end)),
            None => (start, end),
        });
        self.attention = true;
    }
}
