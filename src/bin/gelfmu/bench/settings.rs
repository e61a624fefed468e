//! How much to measure, and on what.

use super::spent::Effort;
use super::{n_threads, stand};
use crate::options::{BenchOptions, ElementName, SectionName};
use serde_json::{Value, json};

/// What the user asked for.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Whether seconds are enough.
    pub quick: bool,
    /// Threads to compare with one.
    pub threads: usize,
    /// Sizes of meshes, about so many elements.
    pub elements: Vec<usize>,
    /// How long to measure.
    pub effort: Effort,
    /// Kinds of elements.
    pub kinds: Vec<ElementName>,
    only: Vec<SectionName>,
}

/// The block of six codes in `benches/peers`, the largest that most of them can run, and one beyond every cache.
const SIZES: [usize; 3] = [26_000, 165_000, 1_000_000];
const QUICK_SIZES: [usize; 1] = [7_000];

impl Settings {
    pub fn of(options: &BenchOptions) -> Self {
        let sizes = if options.quick { QUICK_SIZES.to_vec() } else { SIZES.to_vec() };
        Self {
            quick: options.quick,
            threads: n_threads(options.threads),
            elements: if options.elements.is_empty() { sizes } else { options.elements.clone() },
            effort: if options.quick { Effort::QUICK } else { Effort::FULL },
            kinds: options.element.map_or(vec![ElementName::Plain, ElementName::Patch], |kind| vec![kind]),
            only: options.only.clone(),
        }
    }

    /// Whether a section is to be measured.
    pub fn wants(&self, section: SectionName) -> bool {
        self.only.is_empty() || self.only.contains(&section)
    }

    /// Whether a section is one of a few that the user has named.
    pub fn is_chosen(&self, section: SectionName) -> bool {
        self.only.contains(&section)
    }

    /// One thread, and those to compare with it.
    pub fn thread_counts(&self) -> Vec<usize> {
        if self.threads > 1 { vec![1, self.threads] } else { vec![1] }
    }

    /// Every size with every kind of element.
    pub fn subjects(&self) -> Vec<(usize, ElementName)> {
        self.elements.iter().flat_map(|n| self.kinds.iter().map(|kind| (*n, *kind))).collect()
    }

    /// The largest mesh.
    pub fn largest(&self) -> usize {
        self.elements.iter().copied().max().unwrap_or(SIZES[0])
    }

    pub fn to_json(&self) -> Value {
        json!({
            "version": env!("CARGO_PKG_VERSION"),
            "system": std::env::consts::OS,
            "architecture": std::env::consts::ARCH,
            "cores": n_threads(0),
            "instructions": stand::levels().iter().map(|(name, _)| *name).collect::<Vec<_>>(),
            "load": load(),
            "quick": self.quick,
            "threads": self.threads,
            "elements": self.elements,
            "kinds": self.kinds.iter().map(|kind| kind.as_str()).collect::<Vec<_>>(),
            "repetitions": self.effort.repeats,
            "least_cpu_s_of_a_repetition": self.effort.seconds,
        })
    }

    /// The same as a paragraph.
    pub fn describe(&self) -> String {
        let instructions: Vec<&str> = stand::levels().iter().map(|(name, _)| *name).collect();
        let busy = load().map(|load| format!(", load {load:.1} at the end")).unwrap_or_default();
        format!(
            "{} {}, {} cores, {}{busy}. Each number is the least of {} repetitions; CPU seconds are those of all threads of \
             this process, so others on the machine disturb them little, wall seconds much.",
            std::env::consts::OS,
            std::env::consts::ARCH,
            n_threads(0),
            instructions.join(", "),
            self.effort.repeats
        )
    }
}

/// Processes that wanted a core in the last minute, where the system tells.
fn load() -> Option<f64> {
    std::fs::read_to_string("/proc/loadavg").ok()?.split_whitespace().next()?.parse().ok()
}
