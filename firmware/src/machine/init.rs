//! Builds the controller in place, in zeroed memory.
//!
//! Built as a value it would be made on the stack and copied: 650 bytes of RAM and 400 of flash. Most of it is 0 at
//! reset; the rest is written here.
#![allow(unsafe_code)]

use crate::machine::chip::Chip;
use crate::machine::controller::Controller;
use crate::machine::lock::Lock;
use crate::machine::reset;
use crate::machine::stream::Stream;
use crate::machine::vm::Vm;
use crate::session::Session;
use crate::store::Store;
use core::ptr::addr_of_mut;

impl<C: Chip> Controller<C> {
    /// The controller at reset.
    ///
    /// # Safety
    /// `controller` points to zeroed memory that nothing else refers to, and that lives as long as `'a`.
    pub unsafe fn init<'a>(controller: *mut Controller<C>, chip: C) -> &'a mut Controller<C> {
        // SAFETY: the caller's; what is not written is integers and booleans, of which zeroes are a value.
        unsafe {
            addr_of_mut!((*controller).session).write(Session::new());
            addr_of_mut!((*controller).store).write(Store::new());
            addr_of_mut!((*controller).stream).write(Stream::new());
            addr_of_mut!((*controller).vm).write(Vm::new(chip.clone()));
            super::motor::init(addr_of_mut!((*controller).motor), chip.clone());
            super::controller::init(addr_of_mut!((*controller).program));
            addr_of_mut!((*controller).lines.rests).write(true);
            let record = reset::newest_profile(&chip);
            addr_of_mut!((*controller).lock).write(Lock::new(record.lock));
            addr_of_mut!((*controller).record).write(record);
            addr_of_mut!((*controller).chip).write(chip);
            &mut *controller
        }
    }

    /// The same in memory of its own.
    #[cfg(any(test, feature = "physics"))]
    pub fn boxed(chip: C) -> Box<Controller<C>> {
        let mut memory = Box::<Controller<C>>::new_zeroed();
        // SAFETY: the memory is zeroed and nobody else's; afterwards it is a controller.
        unsafe {
            Controller::init(memory.as_mut_ptr(), chip);
            memory.assume_init()
        }
    }
}
