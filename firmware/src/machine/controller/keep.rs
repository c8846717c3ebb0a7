//! KEEP values of the running program and in flash.

use crate::machine::chip::Chip;
use core::mem::offset_of;

use super::Controller;
use crate::keep::{self, Kept};
use crate::machine::flash::{Area, Image, Ring};
use crate::store::{Denied, Flash, SEGMENT};
use crate::verify::{Bytes, CODE, MACHINE};
use lang::image::at;
use lang::record::MachineRecord;
use lang::wire::Exception;

/// KEEP values on their way from a program to the one that replaces it.
#[derive(Clone, Copy, Default)]
pub struct Carried {
    count: u8,
    mark: u8,
    values: [i32; keep::KEEPS as usize],
}

/// KEEP values that a program has left behind with RUN: they go to flash when its second is over, with the run's end
/// at the latest. A chain of short programs would wear out its segments in an hour otherwise.
#[derive(Clone, Copy, Default)]
pub struct Left {
    /// Number of the program in the library.
    number: u8,
    /// How many; 0 for none.
    count: u8,
    mark: u8,
    values: [i32; keep::KEEPS as usize],
}

/// So many programs of a chain may have left theirs within a second: one more waits for its end.
pub const LEFT: usize = 4;

/// Milliseconds between two times that a run writes values to flash.
pub const SECOND: u16 = 1024;

impl<C: Chip> Controller<C> {
    /// KEEP values of the stored program.
    pub fn keep_count(&self) -> u16 {
        // A streamed run has no KEEP, whatever is stored; the VM may still stand in its last piece.
        if self.vm.code == 0 || self.vm.is_piece && self.session.is_active() {
            return 0;
        }
        self.image().map_or(0, |image| u16::from(self.image_at(image).byte(at::KEEPS as u16)))
    }

    /// What the stored program keeps.
    fn keep(&self) -> Kept {
        Kept { count: self.keep_count(), mark: self.mark() }
    }

    /// What tells its declarations from others'. The VM may stand in a piece of a streamed job, which has
    /// none.
    fn mark(&self) -> u8 {
        let place = MACHINE + offset_of!(MachineRecord, keeps) as u16;
        self.image().map_or(0, |image| self.image_at(image).byte(place))
    }

    /// Where flash has its values.
    fn ring(&self) -> Ring<C> {
        Ring(self.chip.clone(), self.store.keeps_at(&self.area()))
    }

    /// KEEP value `index`: of the running program its cell.
    pub fn kept(&self, index: u16) -> i32 {
        if self.session.is_active() && index < self.keep_count() {
            return self.vm.cell(self.keep_base() + index);
        }
        keep::read(&self.ring(), self.keep(), index)
    }

    /// Changes a KEEP value.
    pub fn set_kept(&mut self, index: u16, value: i32) -> bool {
        if index >= self.keep_count() {
            return false;
        }
        if self.session.is_active() {
            return self.vm.set_cell(self.keep_base() + index, value);
        }
        let mut values = [0; keep::KEEPS as usize];
        let kept = self.keep();
        for (of, slot) in (0..kept.count).zip(&mut values) {
            *slot = if of == index { value } else { keep::read(&self.ring(), kept, of) };
        }
        self.write_kept(&values);
        true
    }

    /// Cell of the first of them: how many cells AT variables take.
    pub(super) fn keep_base(&self) -> u16 {
        u16::from(self.image_at(self.image().unwrap_or(0)).byte(at::KEEP_BASE as u16))
    }

    /// The stored image, while the VM stands in it and not in a piece of a streamed job.
    fn own_image(&self) -> Option<Image<C>> {
        let image = self.image().filter(|image| image + CODE == self.vm.code);
        image.map(|image| self.image_at(image))
    }

    /// Cells that the link reaches: all while a program runs, then those of AT variables.
    fn open_cells(&self) -> u16 {
        if self.session.is_active() {
            return u16::MAX;
        }
        if self.own_image().is_some() { self.keep_base() } else { 0 }
    }

    /// The value of a cell, 0 of one that the link does not reach.
    pub fn open_cell(&self, n: u16) -> i32 {
        if n < self.open_cells() { self.vm.cell(n) } else { 0 }
    }

    /// Whether the link may give a cell this value.
    ///
    /// # Errors
    /// A failure when the link does not reach it, an illegal value when a running program does not have
    /// it or an AT variable has limits.
    pub fn may_set_cell(&self, n: u16, value: i32) -> Result<(), Exception> {
        if n >= self.open_cells() {
            return Err(Exception::DeviceFailure);
        }
        let allows = |bytes: &[u8]| {
            let limits = lang::image::Image::new(bytes).ok().and_then(|image| image.limits());
            limits.is_none_or(|limits| limits.allow(n, value))
        };
        let allowed = self
            .own_image()
            .is_none_or(|image| self.chip.with_bytes(image.1, image.word(at::LEN as u16), allows));
        if allowed && self.vm.has_cell(n) { Ok(()) } else { Err(Exception::IllegalValue) }
    }

    /// Gives the program's KEEP cells what flash holds.
    pub(super) fn load(&mut self) {
        let kept = self.keep();
        if kept.count == 0 {
            return;
        }
        let number = self.store.current();
        let left = self.left.iter().find(|left| {
            left.number == number && (u16::from(left.count), left.mark) == (kept.count, kept.mark)
        });
        let left = left.map(|left| left.values);
        for index in 0..kept.count.min(keep::KEEPS) {
            let value = match left {
                Some(values) => values.get(usize::from(index)).copied().unwrap_or(0),
                None => keep::read(&self.ring(), kept, index),
            };
            self.vm.set_cell(self.keep_base() + index, value);
        }
        if left.is_none() {
            self.write_kept(&self.cells());
        }
    }

    /// The cells of the running program's KEEP values.
    fn cells(&self) -> [i32; keep::KEEPS as usize] {
        let mut values = [0; keep::KEEPS as usize];
        let base = self.keep_base();
        for (of, slot) in (base..).zip(&mut values) {
            *slot = self.vm.cell(of);
        }
        values
    }

    /// Writes changed KEEP values to flash, those first that RUN has left; nothing may move.
    pub(super) fn save(&mut self) {
        let current = self.store.current();
        for slot in 0..LEFT {
            let left = core::mem::take(&mut self.left[slot]);
            // Of the program that runs its cells are newer.
            if left.count != 0 && left.number != current && self.store.choose(left.number) {
                let values = left.values.get(..usize::from(left.count)).unwrap_or_default();
                keep::save(&mut self.ring(), left.mark, values);
            }
        }
        self.store.choose(current);
        self.clock.kept = 0;
        self.write_kept(&self.cells());
    }

    /// RUN leaves the program: its values go to flash when a second is over since the last ones did. `false` while
    /// those of too many others wait for that.
    pub(super) fn leave_kept(&mut self) -> bool {
        if self.clock.kept >= SECOND {
            self.save();
            return true;
        }
        let (count, number) = (self.keep_count() as u8, self.store.current());
        if count == 0 {
            return true;
        }
        let (mark, values) = (self.mark(), self.cells());
        let own = |left: &&mut Left| left.count != 0 && left.number == number;
        let slot = match self.left.iter_mut().find(own) {
            Some(slot) => slot,
            None => match self.left.iter_mut().find(|left| left.count == 0) {
                Some(slot) => slot,
                None => return false,
            },
        };
        *slot = Left { number, count, mark, values };
        true
    }

    /// Flash gets as many of these as the program keeps.
    fn write_kept(&self, values: &[i32]) {
        match values.get(..usize::from(self.keep_count())) {
            Some([]) | None => {}
            Some(values) => keep::save(&mut self.ring(), self.mark(), values),
        }
    }

    /// Remembers the values of the program that an upload is to replace.
    pub fn carry(&mut self, number: u8) {
        let current = self.store.current();
        self.carried = Carried::default();
        if !self.store.choose(number) {
            return;
        }
        let kept = self.keep();
        let ring = self.ring();
        for (index, value) in (0..kept.count).zip(&mut self.carried.values) {
            *value = keep::read(&ring, kept, index);
        }
        self.carried.count = kept.count as u8;
        self.carried.mark = kept.mark;
        self.store.choose(current);
    }

    /// Gives them to the one that replaces it and declares the same; nothing else is in its segments.
    ///
    /// # Errors
    /// There is no room for its values.
    pub fn hand_over(&mut self) -> Result<(), Denied> {
        let Some(image) = self.store.open_image::<Area<C>>() else { return Ok(()) };
        let image = self.image_at(C::AREA + image);
        let keeps = image.byte(at::KEEPS as u16);
        let Some(ring) = self.store.open_keeps(&self.area(), keeps != 0)? else { return Ok(()) };
        let mut ring = Ring(self.chip.clone(), ring);
        ring.erase(0);
        ring.erase(SEGMENT);
        let place = MACHINE + offset_of!(MachineRecord, keeps) as u16;
        let Carried { count, mark, values } = self.carried;
        if image.byte(place) == mark && keeps == count {
            keep::save(&mut ring, mark, values.get(..usize::from(count)).unwrap_or_default());
        }
        Ok(())
    }
}
