//! Flash: the program store, the KEEP journal, the profile, the last fault.

use crate::consts::constants;

constants! {}

core::arch::global_asm!(include_str!("store/flash.s"), options(raw));
core::arch::global_asm!(include_str!("store/store.s"), options(raw));
core::arch::global_asm!(include_str!("store/keep.s"), options(raw));
core::arch::global_asm!(include_str!("store/profile.s"), options(raw));
