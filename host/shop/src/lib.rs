//! What a workshop's own files become on a machine: paste layers become dots, pictures a laser's jobs;
//! uneven surfaces correct jobs of G-code.
//!
//! Nothing here knows the command line, a board or the simulator: files come in as text or bytes,
//! scripts go out as text. Errors are a [`Wrong`], with its place in the file and a
//! remedy.

pub mod engrave;
pub mod level;
pub mod paste;
pub mod terminal;
mod text;
mod wrong;

pub use wrong::{Wrong, of_toml};
