//! Motion on the shipped images, at the emulated pins: pause and resume at random instants, paths
//! without holes, and times against the simulator's.

mod ahead;
mod emergency;
mod ends;
mod generated;
mod home;
mod judged;
mod lab;
mod limits;
mod pause;
mod profiles;
mod smooth;
mod speed;
mod timing;
