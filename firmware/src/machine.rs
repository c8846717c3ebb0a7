//! The machine: the controller of a board with everything that is the same on every chip.
//!
//! A [`Controller`] stands on a [`Chip`], which says what the hardware does. The image of the MSP430F5529 gives it that
//! chip (`firmware/f5529`), `pasapas sim` one of the desktop. The main loop is [`Controller::pass`].

mod aout;
mod arcs;
pub mod chip;
mod commands;
pub mod controller;
pub mod core;
mod effects;
pub mod flash;
mod home;
mod init;
mod limits;
pub mod lines;
mod lock;
mod map;
mod motor;
mod moves;
mod pass;
pub mod pool;
mod probe;
mod profile;
pub mod pwm;
pub mod reset;
pub mod stream;
pub mod vm;

pub use chip::Chip;
pub use controller::Controller;
pub use pass::Port;
