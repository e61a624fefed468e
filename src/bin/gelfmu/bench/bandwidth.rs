//! What memory gives: a(i) = b(i) + s c(i) over arrays that no cache holds, 24 bytes for each i (McCalpin's STREAM triad).

use super::Measurement;
use super::settings::Settings;
use super::spent::{Effort, Spent};
use super::table::Row;
use crate::options::SectionName;
use std::hint::black_box;

/// Numbers of an array: 128 MiB, four times the largest cache of a desktop processor; quick, 32 MiB.
const LENGTH: usize = 1 << 24;
const QUICK_LENGTH: usize = 1 << 22;
/// Bytes read and written for one i.
const BYTES: usize = 24;

pub fn plan(settings: &Settings) -> Vec<Measurement> {
    let length = if settings.quick { QUICK_LENGTH } else { LENGTH };
    let effort = settings.effort;
    let of = |threads: usize| Measurement {
        section: SectionName::Bandwidth,
        what: format!("{threads} threads"),
        cost: if settings.quick { 0.1 } else { 1.0 },
        go: Box::new(move || Ok(vec![row(length, threads, effort)])),
    };
    settings.thread_counts().into_iter().map(of).collect()
}

fn row(length: usize, threads: usize, effort: Effort) -> Row {
    let (mut a, b, c) = (vec![0.0; length], vec![1.0; length], vec![2.0; length]);
    let spent = Spent::least(effort, || (), |()| triad(&mut a, (&b, &c), threads));
    assert!(a.iter().all(|a| *a == 7.0), "the triad was computed");
    Row::default()
        .with("threads", threads)
        .with("gigabytes_per_s", (length * BYTES) as f64 / spent.wall / 1e9)
        .and("bytes_of_an_array", length * size_of::<f64>())
        .and("wall_s", spent.wall)
        .and("cpu_s", spent.cpu)
}

fn triad(a: &mut [f64], (b, c): (&[f64], &[f64]), threads: usize) {
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
