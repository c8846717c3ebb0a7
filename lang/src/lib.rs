//! The Pasapas language.
#![cfg_attr(not(any(test, feature = "compiler")), no_std)]
#![forbid(unsafe_code)]
