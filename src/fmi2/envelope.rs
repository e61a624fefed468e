//! Envelope of a serialised FMU state: header and checksum.
//!
//! Layout, little-endian: magic (8 bytes), version (4), digest of the simulation (16), length of the body (8), body,
//! CRC-32 of the preceding bytes (4).

use super::memory::MemoryShortage;
use crc32fast::Hasher;

const MAGIC: [u8; 8] = *b"GELSTATE";
/// Version of the layout, body included.
pub(super) const VERSION: u32 = 19;
const HEADER: usize = 8 + 4 + 16 + 8;
const TRAILER: usize = 4;

/// Error of an unusable state.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SnapshotError {
    /// Foreign pointer.
    #[error("the pointer is not a state of this FMU, or the state was freed")]
    Foreign,
    /// Wrong length.
    #[error("the serialised state has {found} bytes, expected {expected}: it is cut off or has something appended")]
    Size {
        /// Given bytes.
        found: usize,
        /// Bytes according to the header, or the least possible length.
        expected: usize,
    },
    /// Wrong magic bytes.
    #[error("the bytes are not a serialised state of this FMU")]
    Magic,
    /// Wrong version of the layout.
    #[error("the serialised state has version {found}, expected {expected}: it was written by another release")]
    Version {
        /// Found version.
        found: u32,
        /// Supported version.
        expected: u32,
    },
    /// Wrong checksum.
    #[error("the checksum of the serialised state is wrong: it was damaged")]
    Damaged,
    /// Undecodable body.
    #[error("the serialised state cannot be decoded: it was written by another build")]
    Undecodable,
    /// Wrong size of the buffer.
    #[error("the buffer has {found} bytes, expected {expected} as given by fmi2SerializedFMUstateSize")]
    Buffer {
        /// Size of the buffer.
        found: usize,
        /// Size of the state.
        expected: usize,
    },
    /// Shortage of memory.
    #[error("{0}")]
    Memory(#[from] MemoryShortage),
    /// State of another mesh.
    #[error("the state does not fit the scene that it names: {reason}")]
    Mesh {
        /// Mismatch.
        reason: String,
    },
}

/// Returns the number of bytes of a sealed body.
pub(super) fn sealed_size(body: usize) -> usize {
    HEADER + body + TRAILER
}

/// Writes header, body and checksum over all of `to`. `write_body` writes the body; it returns the digest of the
/// simulation and the checksum of the body.
pub(super) fn seal(to: &mut [u8], write_body: impl FnOnce(&mut [u8]) -> (u128, Hasher)) {
    let (header, rest) = to.split_at_mut(HEADER);
    let (body, trailer) = rest.split_at_mut(rest.len() - TRAILER);
    let (digest, crc_of_body) = write_body(body);
    header[..8].copy_from_slice(&MAGIC);
    header[8..12].copy_from_slice(&VERSION.to_le_bytes());
    header[12..28].copy_from_slice(&digest.to_le_bytes());
    header[28..].copy_from_slice(&(body.len() as u64).to_le_bytes());
    let mut crc = Hasher::new();
    crc.update(header);
    crc.combine(&crc_of_body);
    trailer.copy_from_slice(&crc.finalize().to_le_bytes());
}

/// Returns the body between header and checksum, if both are valid.
pub(super) fn verified_body(bytes: &[u8]) -> Result<&[u8], SnapshotError> {
    let found = bytes.len();
    let header = bytes.get(..HEADER).ok_or(SnapshotError::Size { found, expected: HEADER + TRAILER })?;
    if header[..8] != MAGIC {
        return Err(SnapshotError::Magic);
    }
    let version = u32::from_le_bytes(first_bytes(&header[8..]));
    if version != VERSION {
        return Err(SnapshotError::Version { found: version, expected: VERSION });
    }
    let body = usize::try_from(u64::from_le_bytes(first_bytes(&header[28..]))).unwrap_or(usize::MAX);
    let expected = body.saturating_add(HEADER + TRAILER);
    if found != expected {
        return Err(SnapshotError::Size { found, expected });
    }
    let (sound, crc) = bytes.split_at(found - TRAILER);
    if crc32fast::hash(sound) != u32::from_le_bytes(first_bytes(crc)) {
        return Err(SnapshotError::Damaged);
    }
    Ok(&sound[HEADER..])
}

fn first_bytes<const N: usize>(bytes: &[u8]) -> [u8; N] {
    std::array::from_fn(|i| bytes[i])
}
