//! The hardware-free half of the firmware: everything that host tests can run.
#![cfg_attr(not(any(test, feature = "physics")), no_std)]
#![deny(unsafe_code)]

pub mod inputs;
pub mod keep;
pub mod modbus;
pub mod motion;
pub mod print;
pub mod session;
pub mod store;
pub mod verify;
