//! System and C library that the packed libraries need to be loaded.

use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Marks a version of the GNU C library in the table of symbols that a library imports.
const MARK: &[u8] = b"GLIBC_";

/// Oldest Windows that the standard library of Rust supports (platform support of rustc, x86_64-pc-windows-gnu).
const OLDEST_WINDOWS: &str = "Windows 10, Windows Server 2016";

/// Describes what the libraries, by their paths below `binaries/`, need in a paragraph of HTML: the C library of those that
/// name the GNU C library, the system of those for Windows, nothing of others.
pub fn paragraph(libraries: &BTreeMap<String, Vec<u8>>) -> String {
    let mut lines = String::new();
    for (path, bytes) in libraries {
        let need = if let Some(version) = newest_glibc(bytes) {
            let version: Vec<String> = version.iter().map(u32::to_string).collect();
            let version = version.join(".");
            format!("the GNU C library, version {version} or later (<code>ldd --version</code> shows that of a system)")
        } else if path.starts_with("win64/") {
            format!("{OLDEST_WINDOWS} or later")
        } else {
            continue;
        };
        let _ = write!(lines, "The library <code>binaries/{path}</code> needs {need}. ");
    }
    if lines.is_empty() { lines } else { format!("<p>{}</p>\n", lines.trim_end()) }
}

/// Returns the newest version of the GNU C library that an imported symbol requires.
fn newest_glibc(library: &[u8]) -> Option<Vec<u32>> {
    let marks = library.windows(MARK.len()).enumerate().filter(|(_, bytes)| *bytes == MARK);
    marks.filter_map(|(at, _)| parse_version(&library[at + MARK.len()..])).max()
}

/// Parses a version, such as `2.34`, before a null byte.
fn parse_version(text: &[u8]) -> Option<Vec<u32>> {
    let end = text.iter().position(|byte| *byte == 0)?;
    let text = std::str::from_utf8(&text[..end]).ok()?;
    text.split('.').map(|number| number.parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_version_counts_by_number_and_not_by_letter() {
        let library = b"\0GLIBC_2.9\0abc\0GLIBC_2.34\0GLIBC_2.2.5\0GLIBC_PRIVATE\0GLIBC_3";
        assert_eq!(newest_glibc(library), Some(vec![2, 34]));
        let libraries = BTreeMap::from([("linux64/a.so".to_owned(), library.to_vec())]);
        assert!(
            paragraph(&libraries)
                .contains("binaries/linux64/a.so</code> needs the GNU C library, version 2.34 or later")
        );
    }

    #[test]
    fn a_library_for_windows_names_the_oldest_and_one_of_another_system_says_nothing() {
        let of = |path: &str| paragraph(&BTreeMap::from([(path.to_owned(), b"KERNEL32.dll".to_vec())]));
        assert!(of("win64/a.dll").contains("binaries/win64/a.dll</code> needs Windows 10"), "{}", of("win64/a.dll"));
        assert_eq!(of("darwin64/a.dylib"), "");
    }
}
