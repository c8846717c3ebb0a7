//! Harness of the cross-crate suites.
