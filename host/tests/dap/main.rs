//! The debug adapter, as a debugger sees it.

mod boards;
mod client;
mod recorded;
mod simulator;
