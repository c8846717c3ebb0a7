//! `pasapas --version`: which commit this tool is, and which firmware it brings.

/// The first digits of the commit and of each image's SHA-1: those that `sha1sum firmware/image/*.elf`
/// shows at that commit.
pub const LONG: &str = concat!(
    env!("CARGO_PKG_VERSION"),
    "\ncommit ",
    env!("PASAPAS_COMMIT"),
    include_str!(concat!(env!("OUT_DIR"), "/sums.txt")),
);

#[cfg(test)]
mod tests {
    use super::LONG;
    use crate::board::BUILDS;

    #[test]
    fn every_image_stands_there_with_its_sum() {
        for build in BUILDS {
            let sum = sha1_smol::Sha1::from(build.elf).digest().to_string();
            let line = format!("\nfirmware {} {}", build.part.name, &sum[..12]);
            assert!(LONG.contains(&line), "{line} is not in\n{LONG}");
        }
        assert_eq!(LONG.lines().count(), 2 + BUILDS.len());
    }
}
