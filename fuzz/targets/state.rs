//! Bytes to the state of a simulation: restored and stepped, or refused without a change.

#![no_main]

mod small;

use ballistic_gel::simulation::{SavedSimulation, Simulation};
use libfuzzer_sys::fuzz_target;
use std::cell::RefCell;

/// Communication step after a state was taken, s.
const STEP: f64 = 1e-5;

thread_local! {
    static GEL: RefCell<Simulation> = RefCell::new(small::stepped(1e-4));
}

fuzz_target!(|bytes: &[u8]| {
    GEL.with_borrow_mut(|simulation| {
        let sound = simulation.save();
        let mut saved = SavedSimulation::empty();
        if !saved.read(bytes) {
            assert_eq!(saved, SavedSimulation::empty());
            return;
        }
        // The hash of the scene is right: what comes behind it is to be tried.
        saved.origin = sound.origin;
        let digest = simulation.digest();
        match simulation.restore(&saved) {
            Err(error) => assert!(!error.to_string().is_empty() && simulation.digest() == digest),
            Ok(()) => {
                let inputs = simulation.inputs();
                let end = simulation.time() + STEP;
                if let Err(error) = simulation.step(&inputs, end) {
                    assert!(!error.to_string().is_empty());
                }
                simulation.restore(&sound).expect("a state of its own");
            }
        }
    });
});
