//! The MSP430x5xx: MSP430X core and the modules of the F5529 (SLAU208, SLAS590).

pub mod bus;
pub mod cpu;
mod periph;
pub mod silicon;
