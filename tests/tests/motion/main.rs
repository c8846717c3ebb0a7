//! Motion on the shipped images, at the emulated pins: pause and resume at random instants.

mod lab;
mod pause;
