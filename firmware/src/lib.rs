//! The hardware-free half of the firmware.
#![no_std]
