//! The `pasapas` command.
fn main() {}
