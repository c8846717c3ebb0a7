//! See `pasapas::torture::host`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use pasapas::torture::host;

fuzz_target!(|data: &[u8]| {
    if let Err(text) = host::profile_file(data) {
        panic!("{text}");
    }
});
