//! The manuals of worlds, cells and machine profiles are what the tool does: their tables are those of the
//! code, their examples run, and each range, default and choice that they name is tried.
//! `UPDATE_README=1 cargo test -p tests --test manuals` rewrites the tables that are made.

mod cells;
mod profiles;
mod worlds;
