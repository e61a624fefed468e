//! Settings of the benchmark: sizes, kinds of elements, threads and repetitions.

use super::n_threads;
use super::options::{BenchOptions, ElementName, SectionName};
use super::spent::RepeatPolicy;
use fearless_simd::Level;
use serde_json::{Value, json};

/// Settings from the command line.
#[derive(Debug, Clone)]
pub struct BenchSettings {
    /// True for a short benchmark.
    pub quick: bool,
    /// Number of threads to compare with one thread.
    pub threads: usize,
    /// Approximate numbers of elements of the meshes.
    pub elements: Vec<usize>,
    /// Repetitions of each measurement.
    pub policy: RepeatPolicy,
    /// Kinds of elements.
    pub kinds: Vec<ElementName>,
    only: Vec<SectionName>,
}

/// Mesh to measure.
#[derive(Debug, Clone, Copy)]
pub struct BenchMesh {
    /// Approximate number of elements.
    pub n_elements: usize,
    /// Kind of elements.
    pub kind: ElementName,
}

impl BenchMesh {
    /// Describes the mesh for the progress display.
    pub fn describe(&self) -> String {
        format!("{} elements, {}", self.n_elements, self.kind.as_str())
    }
}

/// Default numbers of elements: the block of six codes in `benches/peers`, the largest block for most of them, and a
/// block beyond every cache.
const SIZES: [usize; 3] = [26_000, 165_000, 1_000_000];
const QUICK_SIZES: [usize; 1] = [7_000];

impl BenchSettings {
    /// Fills in the defaults of the options.
    pub fn of(options: &BenchOptions) -> Self {
        let sizes = if options.quick { QUICK_SIZES.to_vec() } else { SIZES.to_vec() };
        Self {
            quick: options.quick,
            threads: n_threads(options.threads),
            elements: if options.elements.is_empty() { sizes } else { options.elements.clone() },
            policy: if options.quick { RepeatPolicy::QUICK } else { RepeatPolicy::FULL },
            kinds: options.element.map_or(vec![ElementName::Plain, ElementName::Patch], |kind| vec![kind]),
            only: options.only.clone(),
        }
    }

    /// Returns true if a section is measured.
    pub fn wants(&self, section: SectionName) -> bool {
        self.only.is_empty() || self.only.contains(&section)
    }

    /// Returns true if the user has named the section.
    pub fn is_named(&self, section: SectionName) -> bool {
        self.only.contains(&section)
    }

    /// Returns the numbers of threads to compare.
    pub fn thread_counts(&self) -> Vec<usize> {
        if self.threads > 1 { vec![1, self.threads] } else { vec![1] }
    }

    /// Returns every size with every kind of element.
    pub fn meshes(&self) -> Vec<BenchMesh> {
        let of_size =
            |n: &usize| self.kinds.iter().map(|kind| BenchMesh { n_elements: *n, kind: *kind }).collect::<Vec<_>>();
        self.elements.iter().flat_map(of_size).collect()
    }

    /// Returns the largest number of elements.
    pub fn largest(&self) -> usize {
        self.elements.iter().copied().max().unwrap_or(SIZES[0])
    }

    /// Returns the settings and the machine as JSON.
    pub fn to_json(&self) -> Value {
        json!({
            "version": env!("CARGO_PKG_VERSION"),
            "system": std::env::consts::OS,
            "architecture": std::env::consts::ARCH,
            "cores": n_threads(0),
            "instructions": instructions(),
            "load": load_average(),
            "quick": self.quick,
            "threads": self.threads,
            "elements": self.elements,
            "kinds": self.kinds.iter().map(|kind| kind.as_str()).collect::<Vec<_>>(),
            "repetitions": self.policy.repeats,
            "least_cpu_s_of_a_repetition": self.policy.seconds,
        })
    }

    /// Describes the settings and the machine in a sentence.
    pub fn describe(&self) -> String {
        let busy = load_average().map(|load| format!(", load {load:.1} at the end")).unwrap_or_default();
        format!(
            "{} {}, {} cores, {}{busy}. Each time is the least of {} repetitions, the spread that of the greatest above it; CPU \
             seconds are those of all threads of this process, so others on the machine disturb them little, seconds much.",
            std::env::consts::OS,
            std::env::consts::ARCH,
            n_threads(0),
            instructions(),
            self.policy.repeats
        )
    }
}

/// Returns the widest instruction set of this machine.
fn instructions() -> &'static str {
    let widest = Level::new();
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    let name = match widest {
        level if level.as_avx512().is_some() => "AVX-512",
        level if level.as_avx2().is_some() => "AVX2",
        _ => "baseline",
    };
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    let name = if widest.is_fallback() { "baseline" } else { "widest" };
    name
}

/// Returns the load average of the last minute, where the system reports it.
fn load_average() -> Option<f64> {
    std::fs::read_to_string("/proc/loadavg").ok()?.split_whitespace().next()?.parse().ok()
}
