//! A cycle-counting MSP430G2553.
