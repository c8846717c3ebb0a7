//! Modules that only the MSP430x5xx has; those that both families have are in `crate::periph`.

pub mod adc12;
pub mod crc16;
pub mod dco;
pub mod flash;
pub mod mpy32;
pub mod pmap;
pub mod pmm;
pub mod sys;
pub mod ucs;
