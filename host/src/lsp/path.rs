//! Documents' names: `file:` URIs and paths.

use lsp_types::Uri;

/// The path that a URI names; of one that is no file its own text.
pub fn of(uri: &Uri) -> String {
    let Some(rest) = uri.as_str().strip_prefix("file://") else { return uri.as_str().to_owned() };
    let path = decoded(rest);
    // `/c:/a.bas` of Windows.
    let drive = path.strip_prefix('/').filter(|rest| {
        let mut chars = rest.chars();
        chars.next().is_some_and(|c| c.is_ascii_alphabetic()) && chars.next() == Some(':')
    });
    drive.map_or_else(|| path.clone(), str::to_owned)
}

/// The URI of an absolute path, for the workbench's own documents.
#[cfg(feature = "desktop")]
pub fn uri(path: &str) -> String {
    let mut uri = String::from(if path.starts_with('/') { "file://" } else { "file:///" });
    for byte in path.replace('\\', "/").bytes() {
        if byte.is_ascii_alphanumeric() || b"/-_.~:".contains(&byte) {
            uri.push(char::from(byte));
        } else {
            uri.push_str(&format!("%{byte:02X}"));
        }
    }
    uri
}

/// `%20` and its like.
fn decoded(text: &str) -> String {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, behind)) = rest.split_first() {
        let digits = behind.get(..2).filter(|_| first == b'%');
        let code = digits.and_then(|d| u8::from_str_radix(std::str::from_utf8(d).ok()?, 16).ok());
        match code {
            Some(byte) => {
                bytes.push(byte);
                rest = &behind[2..];
            }
            None => {
                bytes.push(first);
                rest = behind;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::{of, uri};

    #[test]
    fn uris_become_paths() {
        for (uri, path) in [
            ("file:///a/b%20c.bas", "/a/b c.bas"),
            ("file:///c:/J%C3%BCrgen/x.bas", "c:/J\u{fc}rgen/x.bas"),
            ("file:///C%3A/x.bas", "C:/x.bas"),
            ("untitled:Untitled-1", "untitled:Untitled-1"),
        ] {
            assert_eq!(of(&uri.parse().expect("a URI")), path);
        }
        for path in ["/a/b c.bas", "c:/J\u{fc}rgen/100%.bas", "/a#b?.bas"] {
            assert_eq!(of(&uri(path).parse().expect("a URI")), path);
        }
        assert_eq!(uri("C:\\x.bas"), "file:///C:/x.bas");
    }
}
