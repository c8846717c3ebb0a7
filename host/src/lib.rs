//! The `pasapas` tool as a library, so that tests and the bench run the same code.
//!
//! [`cmd`] is the command line, one file for each command; the rest does not depend on it. Without the
//! feature `desktop` only what a web page can do remains: check, simulate, draw, edit.

#[cfg(feature = "desktop")]
pub mod bench;
#[cfg(feature = "desktop")]
pub mod board;
pub mod chords;
#[cfg(feature = "desktop")]
pub mod client;
#[cfg(feature = "desktop")]
pub mod cmd;
pub mod course;
#[cfg(feature = "desktop")]
pub mod dap;
#[cfg(feature = "desktop")]
pub mod failure;
#[cfg(feature = "desktop")]
pub mod fleet;
#[cfg(feature = "gateway")]
pub mod gateway;
#[cfg(feature = "desktop")]
pub mod grbl;
#[cfg(feature = "desktop")]
pub mod hall;
#[cfg(feature = "desktop")]
pub mod helm;
pub mod input;
pub mod interrupt;
#[cfg(feature = "desktop")]
pub mod link;
pub mod lsp;
#[cfg(feature = "desktop")]
pub mod output;
#[cfg(feature = "desktop")]
pub mod place;
pub mod plot;
#[cfg(feature = "desktop")]
pub mod programmer;
pub mod render;
pub mod scene;
#[cfg(feature = "desktop")]
pub mod selftest;
pub mod sim;
#[cfg(feature = "desktop")]
pub mod stream;
#[cfg(feature = "desktop")]
pub mod torture;
pub mod track;
pub mod trial;
#[cfg(feature = "desktop")]
pub mod usb;
#[cfg(feature = "desktop")]
pub mod workbench;
