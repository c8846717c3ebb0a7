//! The `pasapas` tool as a library, so that tests and the bench run the same code.
//!
//! [`cmd`] is the command line, one file for each command; the rest knows nothing of it.

pub mod bench;
pub mod board;
pub mod client;
pub mod cmd;
pub mod dap;
pub mod failure;
pub mod fleet;
pub mod gateway;
pub mod helm;
pub mod input;
pub mod interrupt;
pub mod link;
pub mod lsp;
pub mod output;
pub mod plot;
pub mod programmer;
pub mod render;
pub mod sim;
pub mod stream;
pub mod torture;
pub mod usb;
pub mod workbench;
