//! See `pasapas::torture::registers`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use pasapas::torture::registers;

fuzz_target!(|data: &[u8]| {
    if let Err(text) = registers::storm(data) {
        panic!("{text}");
    }
});
