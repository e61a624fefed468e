//! Memory bandwidth: STREAM triad a(i) = b(i) + s c(i) (McCalpin) on arrays beyond every cache, 24 bytes per item.

use super::Measurement;
use super::settings::BenchSettings;
use super::spent::{MeasuredTime, RepeatPolicy};
use super::table::BenchRow;
use crate::options::SectionName;
use std::hint::black_box;

/// Length of an array: 128 MiB, four times the largest cache of a desktop processor; quick, 32 MiB.
const LENGTH: usize = 1 << 24;
const QUICK_LENGTH: usize = 1 << 22;
/// Bytes read and written for one i.
const BYTES_PER_ITEM: usize = 24;

/// Plans one measurement for each number of threads.
pub fn plan(settings: &BenchSettings) -> Vec<Measurement> {
    let length = if settings.quick { QUICK_LENGTH } else { LENGTH };
    let policy = settings.policy;
    let measurement = |threads: usize| Measurement {
        section: SectionName::Bandwidth,
        what: format!("{threads} threads"),
        cost: if settings.quick { 0.1 } else { 1.0 },
        go: Box::new(move || Ok(vec![measure(length, threads, policy)])),
    };
    settings.thread_counts().into_iter().map(measurement).collect()
}

fn measure(length: usize, threads: usize, policy: RepeatPolicy) -> BenchRow {
    let (mut a, b, c) = (vec![0.0; length], vec![1.0; length], vec![2.0; length]);
    let spent = MeasuredTime::least(policy, || (), |()| triad(&mut a, &b, &c, threads));
    assert!(a.iter().all(|a| *a == 7.0), "the triad was computed");
    BenchRow::default()
        .with("threads", threads)
        .with("gigabytes_per_s", (length * BYTES_PER_ITEM) as f64 / spent.wall / 1e9)
        .and("bytes_of_an_array", length * size_of::<f64>())
        .and("wall_s", spent.wall)
        .and("cpu_s", spent.cpu)
}

/// Computes the triad, divided among threads.
fn triad(a: &mut [f64], b: &[f64], c: &[f64], threads: usize) {
    let s = black_box(3.0);
    let share = a.len().div_ceil(threads);
    let part = |a: &mut [f64], b: &[f64], c: &[f64]| {
        for ((a, b), c) in a.iter_mut().zip(b).zip(c) {
            *a = b + s * c;
        }
    };
    std::thread::scope(|scope| {
        for ((a, b), c) in a.chunks_mut(share).zip(b.chunks(share)).zip(c.chunks(share)) {
            scope.spawn(move || part(a, b, c));
        }
    });
}
