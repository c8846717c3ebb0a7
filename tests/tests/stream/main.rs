//! Streamed jobs with handlers against the simulation: the same script in the same world, fed to the
//! real firmware over its link, leaves the same trace.

mod lab;
mod random;
mod reference;
mod scenes;
