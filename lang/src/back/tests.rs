//! Tests of the back end on programs built by hand.
