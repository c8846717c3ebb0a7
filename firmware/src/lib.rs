//! The hardware-free half of the firmware: everything that host tests can run.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

pub mod motion;
pub mod modbus;
