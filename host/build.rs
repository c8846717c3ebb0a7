//! Brings the firmware images, and tells `pasapas --version` their fingerprints and the commit.

use std::path::Path;
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
    if let Err(error) = builds() {
        println!("cargo:error={error}");
    }
}

/// Makes of each part of `lang::part` its build, and a line of its image's sum.
fn builds() -> Result<(), Box<dyn std::error::Error>> {
    let images = Path::new(&std::env::var("CARGO_MANIFEST_DIR")?).join("../firmware/image");
    let (mut builds, mut names, mut sums) = (String::new(), Vec::new(), String::new());
    for (n, part) in lang::part::PARTS.iter().enumerate() {
        let elf = images.join(format!("pasapas-{}.elf", part.name));
        let image = std::fs::read(&elf).map_err(|error| format!("{}: {error}", elf.display()))?;
        let sum = sha1_smol::Sha1::from(image).digest().to_string();
        sums += &format!("\nfirmware {} {}", part.name, &sum[..12]);
        let name = part.name.to_uppercase().replace('-', "_");
        builds += &format!(
            "/// The build of the part {} of the {}.
pub static {name}: Build = Build {{
    part: part::PARTS[{n}],
    chip: chip::emulated(part::PARTS[{n}].chip),
    elf: include_bytes!({elf:?}),
}};
",
            part.name, part.chip.name,
        );
        names.push(format!("&{name}"));
    }
    builds += &format!(
        "/// Every build, in the order in which a program finds its own ([`part::PARTS`]).
pub static BUILDS: [&Build; {}] = [{}];
",
        names.len(),
        names.join(", ")
    );
    let out = std::env::var("OUT_DIR")?;
    std::fs::write(Path::new(&out).join("builds.rs"), builds)?;
    std::fs::write(Path::new(&out).join("sums.txt"), sums)?;
    Ok(())
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
