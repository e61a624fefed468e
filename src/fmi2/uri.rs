//! Conversion of the resource location, a percent-encoded `file:` URI, to a path and back.

use std::path::PathBuf;
#[cfg(feature = "cli")]
use std::{fmt::Write as _, path::Path};

/// Returns the folder of a URI; `file:/p`, `file:///p` and `file://localhost/p` are equivalent.
///
/// # Errors
/// A sentence with the found and the expected form.
pub(super) fn to_path(uri: &str) -> Result<PathBuf, String> {
    let refuse = || format!("the resource location {uri:?} is not a file URI such as file:///folder/resources");
    let rest = uri.get(..5).filter(|s| s.eq_ignore_ascii_case("file:")).map(|_| &uri[5..]).ok_or_else(refuse)?;
    let path = match rest.strip_prefix("//") {
        Some(rest) => match rest.split_at_checked(9) {
            Some((host, path)) if host.eq_ignore_ascii_case("localhost") && path.starts_with('/') => path,
            _ if rest.starts_with('/') => rest,
            _ => return Err(refuse()),
        },
        None if rest.starts_with('/') => rest,
        None => return Err(refuse()),
    };
    let bytes = percent_decode(path).ok_or_else(refuse)?;
    let text = String::from_utf8(bytes).map_err(|_| refuse())?;
    Ok(PathBuf::from(without_drive_slash(&text)))
}

/// Returns the `file:` URI of an absolute path.
#[cfg(feature = "cli")]
pub(super) fn from_path(path: &Path) -> String {
    let text = path.to_string_lossy();
    let text = if cfg!(windows) { format!("/{}", text.replace('\\', "/")) } else { text.into_owned() };
    let mut uri = String::from("file://");
    for byte in text.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b':' | b'-' | b'_' | b'.' | b'~' => uri.push(byte.into()),
            other => write!(uri, "%{other:02X}").unwrap_or_default(),
        }
    }
    uri
}

/// Turns `/C:/folder` into `C:/folder` on systems with drives.
fn without_drive_slash(path: &str) -> &str {
    let bytes = path.as_bytes();
    if cfg!(windows) && bytes.len() > 2 && bytes[2] == b':' { &path[1..] } else { path }
}

fn percent_decode(text: &str) -> Option<Vec<u8>> {
    let mut bytes = text.bytes();
    let mut out = Vec::with_capacity(text.len());
    while let Some(byte) = bytes.next() {
        out.push(if byte == b'%' { 16 * hex_digit(bytes.next()?)? + hex_digit(bytes.next()?)? } else { byte });
    }
    (!out.contains(&0)).then_some(out)
}

fn hex_digit(digit: u8) -> Option<u8> {
    (digit as char).to_digit(16).map(|d| d as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_spellings_of_a_file_uri_name_the_same_folder() {
        for uri in ["file:/a%20b/%C3%A9", "file:///a%20b/é", "FILE://localhost/a%20b/%c3%A9", "file:///a b/é"] {
            assert_eq!(to_path(uri), Ok(PathBuf::from("/a b/é")), "{uri}");
        }
        assert_eq!(to_path("file:////a//b"), Ok(PathBuf::from("//a//b")));
    }

    #[test]
    #[cfg(feature = "cli")]
    fn the_uri_of_a_path_names_that_path() {
        for path in ["/a b/é%20#?.fmu", "/tmp/.x_~-1"].map(PathBuf::from) {
            assert_eq!(to_path(&from_path(&path)), Ok(path));
        }
    }

    #[test]
    fn a_uri_of_no_local_folder_is_refused_with_the_uri_in_the_message() {
        for uri in
            ["", "http://a/b", "/a/b", "file:a", "file://server/a", "file:///a%2", "file:///%zz", "file:///%00", "é"]
        {
            assert!(to_path(uri).unwrap_err().contains(&format!("{uri:?}")), "{uri}");
        }
    }
}
