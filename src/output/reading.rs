//! Bounded reading of every file that a user names or that stands in a user's folder: no devices, no pipes, no more
//! bytes than the limit of its kind.

use crate::scene::MOST_BYTES;
use std::fs::{self, File, Metadata};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// Limit of a file named by a scene, bytes: ASCII STL with the greatest number of triangles takes 260 bytes for each.
pub(crate) const MOST_FILE_BYTES: u64 = 1 << 27;
/// Limit of a table that a user has written, and of `summary.json`, bytes.
pub const MOST_TABLE_BYTES: u64 = 1 << 24;
/// Limit of a table or a frame of a run, bytes, of a frame also inflated: that of 700 000 rows of a history without
/// fragments, and of 10 million elements.
pub const MOST_RESULT_BYTES: u64 = 1 << 30;

/// Returns a reader of the files named by a scene, relative to a folder. A name with the backslashes of Windows is
/// found on every system.
pub fn scene_file_reader(folder: &Path) -> impl Fn(&str) -> io::Result<Vec<u8>> + use<> {
    let folder = folder.to_path_buf();
    move |name| {
        let path = folder.join(name);
        let read = match read_limited(&path, MOST_FILE_BYTES) {
            Err(error) if error.kind() == ErrorKind::NotFound && name.contains('\\') => {
                read_limited(&folder.join(name.replace('\\', "/")), MOST_FILE_BYTES).map_err(|_| error)
            }
            read => read,
        };
        read.map_err(|e| io::Error::new(e.kind(), format!("cannot read {}: {e}", path.display())))
    }
}

/// Reads the text of a scene file.
///
/// # Errors
/// Error of the system, or the finding instead of a regular file of UTF-8 text within the limit.
pub fn read_scene_text(path: &Path) -> io::Result<String> {
    read_limited_text(path, MOST_BYTES as u64)
}

/// Reads a text file of at most `most` bytes.
///
/// # Errors
/// Error of the system, or the finding instead of a regular file of UTF-8 text within the limit.
pub fn read_limited_text(path: &Path, most: u64) -> io::Result<String> {
    let no_text = |_| invalid("found bytes that are no UTF-8 text".to_owned());
    String::from_utf8(read_limited(path, most)?).map_err(no_text)
}

/// Reads a regular file of at most `most` bytes.
///
/// # Errors
/// Error of the system, or the finding instead of a regular file: a device or a pipe could give bytes without end, or
/// block the reader for ever.
pub(crate) fn read_limited(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let there = fs::metadata(path)?;
    expect_regular(&there)?;
    let too_long = |length: String| Err(invalid(format!("found {length} bytes, expected at most {most}")));
    if there.len() > most {
        return too_long(there.len().to_string());
    }
    let mut bytes = Vec::new();
    // Files of some systems report no length, and files grow.
    File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most { too_long(format!("more than {most}")) } else { Ok(bytes) }
}

/// Refuses a folder, a device and a pipe. To open a pipe would wait for its writer.
pub(super) fn expect_regular(found: &Metadata) -> io::Result<()> {
    match found {
        folder if folder.is_dir() => Err(ErrorKind::IsADirectory.into()),
        file if file.is_file() => Ok(()),
        _ => Err(invalid("found a device or a pipe, expected a regular file".to_owned())),
    }
}

fn invalid(found: String) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_file_that_is_too_long_is_refused_before_it_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("long");
        File::create(&path).unwrap().set_len(1 << 40).unwrap();
        let refused = read_scene_text(&path).unwrap_err().to_string();
        assert_eq!(refused, "found 1099511627776 bytes, expected at most 1048576");
        fs::write(&path, [0xff]).unwrap();
        assert!(read_scene_text(&path).unwrap_err().to_string().contains("no UTF-8 text"));
        fs::write(&path, "[scene]").unwrap();
        assert_eq!(read_scene_text(&path).unwrap(), "[scene]");
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_refused() {
        for device in ["/dev/zero", "/dev/tty", "/dev/null"] {
            let refused = read_limited(Path::new(device), 10).unwrap_err().to_string();
            assert!(refused.contains("a device or a pipe") || device == "/dev/tty", "{refused}");
        }
        assert!(read_limited(Path::new("/dev"), 10).is_err());
    }
}
