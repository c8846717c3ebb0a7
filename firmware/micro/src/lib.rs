//! Micro-code: the byte code in which the 16 KB chip does what is in no hurry.
//!
//! [`isa`] is its instruction set as one table. All that knows the code is made of that:
//!
//! - [`asm`]: numbers, notation and jump tables of the assembler,
//! - [`decode`]: operations from bytes, and [`show`]: their notation again,
//! - [`run`]: an interpreter for tests on the host,
//! - [`image`]: the routines of an image, and [`verify`]: what each of them must keep to.
//!
//! The machine itself is `firmware/g2553/micro/machine.s`; the test `compact` of `firmware` runs both in lock step.

pub mod asm;
pub mod decode;
pub mod image;
pub mod isa;
pub mod run;
pub mod show;
pub mod verify;
