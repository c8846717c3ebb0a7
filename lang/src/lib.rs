//! The Pasapas language: what a script may say, and everything that host and device must agree on.
//!
//! Shared by host and device (no allocation, no hardware): [`axis`], [`fault`], [`effect`], the
//! opcode table, the image, the verifier, the VM, the wire registers and the profile record.
//! With feature `compiler` (host only): the front end, from text to the checked program
//! [`hir`], and the back end, from there to an image.
#![cfg_attr(not(any(test, feature = "compiler")), no_std)]
#![forbid(unsafe_code)]

pub mod axis;
#[cfg(feature = "compiler")]
pub mod back;
pub mod called;
pub mod effect;
pub mod fault;
#[cfg(feature = "compiler")]
pub mod front;
#[cfg(feature = "compiler")]
pub mod hir;
pub mod image;
pub mod isa;
#[cfg(feature = "compiler")]
pub mod kind;
pub mod part;
pub mod place;
pub mod plain;
#[cfg(feature = "compiler")]
pub mod profile;
pub mod record;
#[cfg(feature = "compiler")]
pub mod show;
pub mod trig;
pub mod verify;
pub mod vm;
pub mod wire;
