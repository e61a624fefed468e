//! Bounded reading of files named by a user: no devices, no pipes, no more bytes than a limit.

use crate::scene::MOST_BYTES;
use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// Limit of a file named by a scene, bytes: ASCII STL with the greatest number of triangles takes 260 bytes for each.
pub(super) const MOST_FILE_BYTES: u64 = 1 << 27;

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
    let no_text = |_| io::Error::new(ErrorKind::InvalidData, "found bytes that are no UTF-8 text");
    String::from_utf8(read_limited(path, most)?).map_err(no_text)
}

/// Reads a regular file of at most `most` bytes.
///
/// # Errors
/// Error of the system, or the finding instead of a regular file: a device or a pipe could give bytes without end, or
/// block the reader for ever.
pub fn read_limited(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let refuse = |found: String| Err(io::Error::new(ErrorKind::InvalidData, found));
    let there = fs::metadata(path)?;
    if there.is_dir() {
        return Err(ErrorKind::IsADirectory.into());
    }
    if !there.is_file() {
        return refuse("found a device or a pipe, expected a regular file".to_owned());
    }
    let too_long = |length: String| refuse(format!("found {length} bytes, expected at most {most}"));
    if there.len() > most {
        return too_long(there.len().to_string());
    }
    let mut bytes = Vec::new();
    // Files of some systems report no length, and files grow.
    File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most { too_long(format!("more than {most}")) } else { Ok(bytes) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_long_is_refused_before_it_is_read() {
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
