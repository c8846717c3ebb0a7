//! The front end: data files with snapshots, hostile input, the formatter.

mod data;
mod fix;
mod format;
mod hostile;
mod index;
mod manual;
mod wrong;
