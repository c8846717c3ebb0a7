//! Status of a gateway and of its boards: its unit's registers and files, for the gateway that serves
//! them and for every tool that reads them.

pub mod counters;
pub mod known;
