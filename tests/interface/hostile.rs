//! Hostile use, in short; for as long as wanted it is `cargo run --release --manifest-path studies/Cargo.toml --bin hostile`.

#[path = "../hostile/calls.rs"]
mod calls;
#[path = "../hostile/files.rs"]
mod files;
#[path = "../hostile/found.rs"]
mod found;
#[path = "../hostile/scenes.rs"]
mod scenes;
#[path = "../hostile/states.rs"]
mod states;
#[path = "../hostile/tally.rs"]
#[allow(dead_code, reason = "the command goes on for minutes")]
mod tally;
#[path = "../hostile/written.rs"]
mod written;

use crate::host;
use crate::random;
use std::sync::atomic::Ordering;
use tally::Tally;

#[track_caller]
fn nothing_found(tally: &Tally) {
    assert!(tally.found.is_empty(), "{:#?}", tally.found);
    assert!(tally.taken > 0 && tally.refused > 0, "{tally:?}");
}

#[test]
fn scenes_that_nobody_wrote_are_run_remeshed_and_written_or_refused_in_words() {
    let seeds = scenes::seeds();
    nothing_found(&Tally::of(1, 300, |seed| scenes::attempt(&seeds, seed)));
    let remeshes = scenes::REMESHES.load(Ordering::Relaxed);
    assert!(remeshes >= 20, "{remeshes} new meshes");
}

#[test]
fn damaged_and_forged_states_are_restored_or_refused_in_words() {
    let states = states::States::of(&scenes::seeds());
    nothing_found(&Tally::of(1, 200, |seed| states::attempt(&states, seed)));
}

#[test]
fn calls_in_any_order_with_any_arguments_lose_no_instance() {
    let stage = calls::Stage::of(&scenes::seeds());
    nothing_found(&Tally::of(1, 60, |seed| calls::attempt(&stage, seed)));
}
