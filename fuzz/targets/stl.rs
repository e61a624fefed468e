//! Bytes of an STL file to a body: a closed surface, or an error in words.

#![no_main]

use ballistic_gel::geometry::SignedDistance;
use ballistic_gel::scene;
use libfuzzer_sys::fuzz_target;

/// Triangles that are tried: beyond, a search of all pairs takes longer than it tells.
const MOST_BYTES: usize = 20_000;

fuzz_target!(|bytes: &[u8]| {
    if bytes.len() > MOST_BYTES {
        return;
    }
    let text = include_str!("stl.toml");
    match scene::read_with_files(text, &|_| Ok(bytes.to_vec())) {
        Ok(scene) => assert!(scene.shape(0).volume().is_none_or(|volume| volume > 0.0)),
        Err(error) => assert!(!error.to_string().trim().is_empty()),
    }
});
