//! The front end: data files with snapshots, hostile input, the formatter.

mod data;
mod format;
mod hostile;
mod manual;
mod wrong;
