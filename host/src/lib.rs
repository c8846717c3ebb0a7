//! The `pasapas` tool as a library, for the tests.

pub mod sim;
