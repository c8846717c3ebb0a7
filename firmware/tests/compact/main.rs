//! The G2553's assembly, routine by routine, in the emulator against its Rust twins.
//!
//! The image is the shipped one: run `firmware/build.sh` after a change of its sources.

mod area;
mod boot;
mod chip;
mod live;
mod machine;
mod rig;

mod check;
mod commands;
mod coords;
mod courses;
mod effects;
mod events;
mod force;
mod home;
mod io;
mod jog;
mod keep;
mod line;
mod link;
mod lockstep;
mod micro;
mod moves;
mod numbers;
mod ramp;
mod rules;
mod session;
mod step;
mod store;
mod upload;
mod verify;
