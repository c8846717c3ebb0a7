//! Files with passwords and keys.

use std::path::Path;

/// Says so where everybody on this computer may read a password.
pub fn warn(path: &Path) {
    if is_open(path) {
        eprintln!(
            "pasapas: everybody on this computer can read {0}: `chmod 640 {0}`",
            path.display()
        );
    }
}

/// Whether everybody may read a file. Elsewhere than on Unix nothing is known of that.
fn is_open(path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        std::fs::metadata(path).is_ok_and(|about| about.permissions().mode() & 0o004 != 0)
    }
    #[cfg(not(unix))]
    {
        let _ = path;
        false
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::is_open;

    #[test]
    fn a_file_that_everybody_may_read_is_open() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        for (mode, open) in [(0o600, false), (0o640, false), (0o644, true), (0o604, true)] {
            let rights = std::fs::Permissions::from_mode(mode);
            std::fs::set_permissions(file.path(), rights).expect("rights");
            assert_eq!(is_open(file.path()), open, "{mode:o}");
        }
        assert!(!is_open(std::path::Path::new("/nowhere/at/all")));
    }
}
