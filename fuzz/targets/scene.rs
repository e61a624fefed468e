//! Text to a checked scene: whatever the text, a scene or an error in words.

#![no_main]

use ballistic_gel::scene;
use libfuzzer_sys::fuzz_target;
use std::io::{Error, ErrorKind};

const STL: &[u8] = include_bytes!("../corpus/stl/tetrahedron.stl");

fuzz_target!(|text: &str| {
    let files = |name: &str| if name.ends_with('l') { Ok(STL.to_vec()) } else { Err(Error::from(ErrorKind::NotFound)) };
    match scene::read_with_files(text, &files) {
        Ok(scene) => {
            assert!(
                !scene::modelled_physics(&scene).is_empty() && !scene::switched_off(&scene).contains(&String::new())
            )
        }
        Err(error) => assert!(!error.to_string().trim().is_empty()),
    }
});
