//! Puts the part's memory map where the linker finds it; `link.x` comes from `msp430-rt`.

use std::path::Path;

fn main() {
    println!("cargo:rerun-if-changed=memory");
    println!("cargo:rerun-if-changed=build.rs");
    let large = std::env::var_os("CARGO_FEATURE_G2955").is_some();
    if !large && std::env::var_os("CARGO_FEATURE_G2553").is_none() {
        return;
    }
    let whole = std::env::var_os("CARGO_FEATURE_WHOLE").is_some();
    let part = match (large, whole) {
        (true, _) => "memory/g2955.x",
        (_, true) => "memory/whole.x",
        _ => "memory/g2553.x",
    };
    let out = std::env::var("OUT_DIR").unwrap_or_default();
    if let Err(error) = std::fs::copy(part, Path::new(&out).join("memory.x")) {
        println!("cargo:error=cannot copy {part}: {error}");
    }
    println!("cargo:rustc-link-search={out}");
}
