//! C library that the packed library needs on the system that loads it.

/// Marks a version of the GNU C library in the table of symbols that a library imports.
const MARK: &[u8] = b"GLIBC_";

/// Describes the requirement in a paragraph of HTML; empty for a library that does not name the GNU C library.
pub fn paragraph(library: &[u8]) -> String {
    newest_glibc(library).map_or(String::new(), |version| {
        let version: Vec<String> = version.iter().map(u32::to_string).collect();
        format!(
            "<p>The library in <code>binaries/</code> needs the GNU C library, version {} or later \
             (<code>ldd --version</code> shows that of a system).</p>\n",
            version.join(".")
        )
    })
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
        assert!(paragraph(library).contains("version 2.34 or later"));
    }

    #[test]
    fn a_library_of_another_system_says_nothing() {
        assert_eq!(paragraph(b"KERNEL32.dll"), "");
    }
}
