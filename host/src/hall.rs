//! What a gateway tells of itself and of its boards: its unit's registers and files, for the gateway that serves
//! them and for every tool that asks.

pub mod counters;
pub mod known;
