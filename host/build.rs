//! Tells `pasapas --version` the commit and the fingerprints of the firmware images.

use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed=PASAPAS_COMMIT");
    println!("cargo:rerun-if-changed=../firmware/image");
    let given = std::env::var("PASAPAS_COMMIT").ok().filter(|commit| !commit.is_empty());
    // While the tool is worked on it would be compiled anew for each commit.
    let released = std::env::var("PROFILE").is_ok_and(|profile| profile == "release");
    let commit = given.or_else(|| commit().filter(|_| released));
    println!("cargo:rustc-env=PASAPAS_COMMIT={}", commit.as_deref().unwrap_or("unknown"));
    for name in ["g2553", "g2553-handlers", "f5529"] {
        let path = format!("../firmware/image/pasapas-{name}.elf");
        match std::fs::read(&path) {
            Ok(image) => {
                let sum = sha1_smol::Sha1::from(image).digest().to_string();
                let variable = name.to_uppercase().replace('-', "_");
                println!("cargo:rustc-env=PASAPAS_IMAGE_{variable}={}", &sum[..12]);
            }
            Err(error) => println!("cargo:error={path}: {error}"),
        }
    }
}

/// The commit of this checkout, with a `+` where files differ from it; nothing in another's.
fn commit() -> Option<String> {
    let git = |arguments: &[&str]| {
        let told = Command::new("git").args(arguments).output().ok()?;
        let text = String::from_utf8(told.stdout).ok()?;
        told.status.success().then(|| text.trim().to_owned())
    };
    if git(&["rev-parse", "--show-prefix"])? != "host/" {
        return None;
    }
    for changed in [&git(&["rev-parse", "--git-path", "logs/HEAD"])?, "src", "../lang/src"] {
        println!("cargo:rerun-if-changed={changed}");
    }
    git(&["describe", "--always", "--dirty=+", "--abbrev=12", "--exclude=*"])
}
