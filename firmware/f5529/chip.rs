//! The chip: everything that depends on register addresses. All else of the image is the same on every chip.
//!
//! A chip's module has
//! - `clock`: from reset to the rate of the processor, watchdog, causes of resets;
//! - `ports`: pins of buttons, inputs, outputs, directions and shift registers;
//! - `timer`: the millisecond, the silence of the line, the compare channels of the step engine;
//! - `pwm`: the PWM of a laser, a spindle or a servo;
//! - `line`: the UART of the link;
//! - `rs485`: the UART of the RS-485 line;
//! - `flash`: one operation of the flash controller;
//!
//! and constants with the addresses of the flash areas.

#[cfg(feature = "f5529")]
mod f5529;

#[cfg(feature = "f5529")]
pub use f5529::*;
