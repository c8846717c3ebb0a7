//! The front end: from bytes to a checked program.

pub mod ast;
pub mod check;
pub mod codes;
pub mod diag;
pub mod facts;
pub mod fmt;
pub mod index;
pub mod lexer;
pub mod literal;
pub mod parser;
mod pipeline;
pub mod source;
pub mod span;
pub mod token;
pub mod words;

pub use pipeline::{Analysis, ProfileChoice, analyse, compile};
