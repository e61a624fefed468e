//! The body of a serialised state of the FMU, in a frame with the right length and checksum: through the C interface.

#![no_main]
#![allow(clippy::wildcard_imports, reason = "shared with the tests, which call the C interface")]

#[path = "../../tests/fmi2/host.rs"]
#[allow(dead_code, reason = "the tests of the interface use more of it")]
mod host;
mod small;

use ballistic_gel::fmi2::abi::*;
use host::{ERROR, Host, OK};
use libfuzzer_sys::fuzz_target;
use std::cell::RefCell;

/// A panic was caught inside.
const FATAL: i32 = 4;
/// Bytes before the body: magic, version, digest, length.
const HEADER: usize = 36;

thread_local! {
    static GEL: RefCell<(Host, Vec<u8>)> = RefCell::new(started());
}

/// An instance and its state.
fn started() -> (Host, Vec<u8>) {
    let mut host = Host::with(small::TEXT);
    host.start();
    let bytes = host.bytes();
    (host, bytes)
}

/// A state with another body.
fn framed(sound: &[u8], body: &[u8]) -> Vec<u8> {
    let mut bytes = sound[..HEADER].to_vec();
    bytes[28..].copy_from_slice(&(body.len() as u64).to_le_bytes());
    bytes.extend_from_slice(body);
    let checksum = crc32fast::hash(&bytes).to_le_bytes();
    bytes.extend(checksum);
    bytes
}

fuzz_target!(|body: &[u8]| {
    // Another scene is another gel, of any size: `scene` is the target for that.
    if !body.windows(small::TEXT.len()).any(|part| part == small::TEXT.as_bytes()) {
        return;
    }
    GEL.with_borrow_mut(|(host, sound)| {
        let status = host.restore(&framed(sound, body));
        let lines = host.lines();
        assert!(status != FATAL && (status != ERROR || !lines.is_empty()), "{status}: {lines:?}");
        if status == OK {
            let mut now = 0.0;
            // SAFETY: a live component, and one value.
            let status = unsafe { fmi2GetRealStatus(host.c, 2, &raw mut now).max(fmi2DoStep(host.c, now, 1e-5, 0)) };
            let lines = host.lines();
            assert!(status != FATAL && (status == OK || !lines.is_empty()), "{status}: {lines:?}");
        }
        assert_eq!(host.restore(sound), OK, "{:?}", host.lines());
    });
});
