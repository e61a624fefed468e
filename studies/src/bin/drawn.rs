//! Two hundred random scenes of which none may stop: `cargo run --release --manifest-path studies/Cargo.toml --bin drawn -- --jobs 2` prints the table of the studies,
//! `… -- --seeds 17` one of them again, `… -- text 17` its scene.
//!
//! Rows are kept, so that a run that was ended goes on where it was; those of another program are made again.

#![allow(clippy::unwrap_used, reason = "shared with the tests")]

#[path = "../../../tests/hostile/random.rs"]
#[allow(dead_code, reason = "hostile use draws more")]
mod random;
#[path = "../../../tests/drawn/ranges.rs"]
mod ranges;
#[path = "../../../tests/drawn/ride.rs"]
mod ride;
#[path = "../../../tests/drawn/table.rs"]
mod table;

use ride::Ride;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use std::time::Instant;

const USAGE: &str = "usage: drawn [--jobs N] [--seeds A-B,C,...] [--folder FOLDER], or drawn text SEED";

/// What was asked for.
struct Asked {
    jobs: usize,
    seeds: Vec<u64>,
    folder: PathBuf,
    text: bool,
}

fn main() -> ExitCode {
    let Some(asked) = asked() else {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    };
    if asked.text {
        asked.seeds.iter().for_each(|seed| println!("{}", ranges::text(*seed)));
        return ExitCode::SUCCESS;
    }
    let rides = match all(&asked) {
        Ok(rides) => rides,
        Err(error) => {
            eprintln!("rows cannot be kept in {}: {error}", asked.folder.display());
            return ExitCode::FAILURE;
        }
    };
    table::print(&rides);
    ExitCode::from(u8::from(rides.iter().any(|(_, ride)| ride.stop.is_some())))
}

fn asked() -> Option<Asked> {
    let mut asked =
        Asked { jobs: 1, seeds: ranges::SEEDS.collect(), folder: PathBuf::from("gelfmu-out/drawn"), text: false };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--jobs" => asked.jobs = words.next()?.parse().ok().filter(|jobs| *jobs > 0)?,
            "--seeds" => asked.seeds = words.next()?.split(',').map(seeds).collect::<Option<Vec<_>>>()?.concat(),
            "--folder" => asked.folder = PathBuf::from(words.next()?),
            "text" => (asked.seeds, asked.text) = (seeds(&words.next()?)?, true),
            _ => return None,
        }
    }
    Some(asked)
}

/// `A` or `A-B`.
fn seeds(range: &str) -> Option<Vec<u64>> {
    let (from, to) = range.split_once('-').unwrap_or((range, range));
    Some((from.parse().ok()?..=to.parse().ok()?).collect())
}

/// Rows of all seeds, those that are kept and those that are made now, on so many threads.
fn all(asked: &Asked) -> std::io::Result<Vec<(u64, Ride)>> {
    std::fs::create_dir_all(&asked.folder)?;
    let program = xxhash_rust::xxh3::xxh3_64(&std::fs::read(std::env::current_exe()?)?);
    let file = |seed: u64| asked.folder.join(format!("{program:016x}-{seed}.json"));
    let mut rides: Vec<(u64, Ride)> =
        asked.seeds.iter().filter_map(|seed| Some((*seed, kept(&file(*seed))?))).collect();
    let waiting: Vec<u64> =
        asked.seeds.iter().copied().filter(|seed| rides.iter().all(|(made, _)| made != seed)).collect();
    let (total, begun) = (waiting.len(), Instant::now());
    let (queue, made) = (Mutex::new(waiting.into_iter()), Mutex::new(vec![]));
    std::thread::scope(|scope| {
        let work = || -> std::io::Result<()> {
            loop {
                let Some(seed) = queue.lock().unwrap().next() else { return Ok(()) };
                let ride = ridden(seed);
                keep(&file(seed), &ride)?;
                let mut made = made.lock().unwrap();
                made.push((seed, ride));
                told(made.last().unwrap(), (made.len(), total), begun);
            }
        };
        let workers: Vec<_> = (0..asked.jobs).map(|_| scope.spawn(work)).collect();
        workers.into_iter().try_for_each(|worker| worker.join().expect("a worker that tells its errors"))
    })?;
    rides.extend(made.into_inner().unwrap());
    rides.sort_by_key(|(seed, _)| *seed);
    Ok(rides)
}

/// A run that panics is one that stops.
fn ridden(seed: u64) -> Ride {
    let text = ranges::text(seed);
    std::panic::catch_unwind(|| ride::ride(&text)).unwrap_or_else(|_| Ride::lost("it panicked"))
}

/// The row of a run that was made before; one that was cut off is made again.
fn kept(file: &Path) -> Option<Ride> {
    serde_json::from_str(&std::fs::read_to_string(file).ok()?).ok()
}

/// Written beside and moved to its name when it is whole.
fn keep(file: &Path, ride: &Ride) -> std::io::Result<()> {
    let beside = file.with_extension("part");
    std::fs::write(&beside, serde_json::to_string(ride)?)?;
    std::fs::rename(beside, file)
}

/// Progress and the time left.
fn told((seed, ride): &(u64, Ride), (done, total): (usize, usize), begun: Instant) {
    let left = begun.elapsed().as_secs_f64() / done as f64 * (total - done) as f64;
    let end = ride.stop.as_deref().unwrap_or("done");
    eprintln!("{done}/{total}, {:.0} min left: seed {seed}, {:.1} s, {end}", left / 60.0, ride.seconds);
}
