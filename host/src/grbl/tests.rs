//! Sessions against a small machine and a small model of Grbl's states.

mod machine;
mod readers;
mod sessions;
mod talks;
