//! Hostile use of the component, for as long as wanted: `cargo run --release --manifest-path studies/Cargo.toml --bin hostile -- --minutes 20 scene|state|calls`,
//! `… -- --cycles 100000 memory`, and `… -- --seed N --inputs 1 scene` for one input again.
//!
//! What it finds is printed with the seed; in short it runs with the tests.

#![allow(
    clippy::unwrap_used,
    clippy::wildcard_imports,
    unsafe_code,
    reason = "shared with the tests, which call the C interface"
)]

#[path = "../../../tests/hostile/calls.rs"]
mod calls;
#[path = "../../../tests/fmi2/host.rs"]
#[allow(dead_code, reason = "the tests of the interface use more of it")]
mod host;
#[path = "../../../tests/hostile/memory.rs"]
mod memory;
#[path = "../../../tests/hostile/random.rs"]
mod random;
#[path = "../../../tests/hostile/scenes.rs"]
mod scenes;
#[path = "../../../tests/hostile/states.rs"]
mod states;
#[path = "../../../tests/hostile/tally.rs"]
mod tally;
#[path = "../../../tests/hostile/written.rs"]
mod written;

use std::process::ExitCode;
use std::time::{Duration, Instant};
use tally::{Fate, Tally};

const USAGE: &str =
    "usage: hostile [--seed N] [--minutes M | --inputs N] scene|state|calls|text, or hostile --cycles N memory";

/// What was asked for.
struct Asked {
    what: String,
    seed: u64,
    minutes: f64,
    inputs: Option<u64>,
    cycles: u32,
}

fn main() -> ExitCode {
    let Some(asked) = asked() else {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    };
    let seeds = scenes::seeds();
    let begun = Instant::now();
    let tally = match asked.what.as_str() {
        "scene" => tried(&asked, |seed| scenes::attempt(&seeds, seed)),
        "state" => {
            let states = states::States::of(&seeds);
            tried(&asked, |seed| states::attempt(&states, seed))
        }
        "calls" => {
            let stage = calls::Stage::of(&seeds);
            tried(&asked, |seed| calls::attempt(&stage, seed))
        }
        "memory" => return memory(&seeds[0], asked.cycles),
        "text" => {
            println!("{}", scenes::text(&seeds, asked.seed));
            return ExitCode::SUCCESS;
        }
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    let Tally { taken, refused, found } = &tally;
    println!("| fuzzed | inputs | taken | refused | minutes | found |");
    println!("|---|---|---|---|---|---|");
    let minutes = begun.elapsed().as_secs_f64() / 60.0;
    println!("| {} | {} | {taken} | {refused} | {minutes:.1} | {} |", asked.what, tally.inputs(), found.len());
    let remeshes = scenes::REMESHES.load(std::sync::atomic::Ordering::Relaxed);
    if remeshes > 0 {
        println!("{remeshes} new meshes");
    }
    for (seed, story) in found {
        println!("seed {seed}: {story}");
    }
    ExitCode::from(u8::from(!found.is_empty()))
}

fn tried(asked: &Asked, input: impl FnMut(u64) -> Result<Fate, String>) -> Tally {
    match asked.inputs {
        Some(inputs) => Tally::of(asked.seed, inputs, input),
        None => Tally::lasting(asked.seed, Duration::from_secs_f64(60.0 * asked.minutes), input),
    }
}

fn memory(scene: &str, cycles: u32) -> ExitCode {
    let Some([settled, most, last]) = memory::cycles(scene, cycles) else {
        eprintln!("this system does not tell how much memory a process holds");
        return ExitCode::from(2);
    };
    let mb = |bytes: u64| bytes as f64 / 1e6;
    println!("| cycles | MB after a tenth | most since | at the end |\n|---|---|---|---|");
    println!("| {cycles} | {:.1} | {:.1} | {:.1} |", mb(settled), mb(most), mb(last));
    ExitCode::SUCCESS
}

fn asked() -> Option<Asked> {
    let mut asked = Asked { what: String::new(), seed: 1, minutes: 1.0, inputs: None, cycles: 100_000 };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--seed" => asked.seed = words.next()?.parse().ok()?,
            "--minutes" => asked.minutes = words.next()?.parse().ok()?,
            "--inputs" => asked.inputs = Some(words.next()?.parse().ok()?),
            "--cycles" => asked.cycles = words.next()?.parse().ok()?,
            _ => asked.what = word,
        }
    }
    Some(asked)
}
