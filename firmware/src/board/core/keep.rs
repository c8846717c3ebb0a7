//! KEEP values of the running program and in flash.

use super::Core;
use crate::flash::{Area, Image};
use crate::vm::vm;
use firmware::keep::KEEPS;
use firmware::verify::Bytes;

impl Core {
    /// KEEP values of the stored program.
    pub(super) fn keep_count(&self) -> u16 {
        // A streamed run has no KEEP, whatever is stored; the VM may still stand in its last piece.
        if vm().code == 0 || crate::streams() && self.session.is_active() {
            return 0;
        }
        self.image().map_or(0, |image| u16::from(Image(image).byte(16) & 15))
    }

    /// KEEP value `index`: of the running program its cell.
    pub fn kept(&self, index: u16) -> i32 {
        if self.session.is_active() && index < self.keep_count() {
            return vm().cell(self.keep_base() + index);
        }
        self.keep.read(&Area, index)
    }

    /// Changes a KEEP value.
    pub fn set_kept(&mut self, index: u16, value: i32) -> bool {
        if index >= self.keep_count() {
            return false;
        }
        if self.session.is_active() {
            return vm().set_cell(self.keep_base() + index, value);
        }
        self.keep.claim(&mut Area, self.keep_count());
        self.keep.write(&mut Area, index, value);
        true
    }

    /// Cell of the first of them.
    pub(super) fn keep_base(&self) -> u16 {
        u16::from(Image(self.image().unwrap_or(0)).byte(17))
    }

    /// Gives the program's KEEP cells what flash holds.
    pub(super) fn load(&mut self) {
        let keeps = self.keep_count();
        if keeps == 0 {
            return;
        }
        self.keep.claim(&mut Area, keeps);
        let mut index = 0;
        while index < keeps.min(KEEPS) {
            vm().set_cell(self.keep_base() + index, self.keep.read(&Area, index));
            index += 1;
        }
    }

    /// Writes changed KEEP values to flash; nothing may move.
    pub(super) fn save(&mut self) {
        let mut index = self.keep_count();
        while index != 0 {
            index -= 1;
            let value = vm().cell(self.keep_base() + index);
            self.keep.write(&mut Area, index, value);
        }
    }
}
