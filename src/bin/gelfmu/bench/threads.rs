//! CPU time by thread, where the system tells: what a step would take if every thread had a core of its own.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::Path;

/// CPU seconds of each thread of the process so far.
#[derive(Debug, Clone, PartialEq)]
pub struct Threads {
    own: f64,
    others: BTreeMap<OsString, f64>,
}

impl Threads {
    /// Now; only Linux counts this finely.
    pub fn now() -> Option<Self> {
        let this = std::fs::read_link("/proc/thread-self").ok()?;
        let own = on_core(Path::new("/proc/thread-self/schedstat"))?;
        // A thread may end between its name and its numbers, and while threads end the list may miss others: it does not tell of this one.
        let others = std::fs::read_dir("/proc/self/task")
            .ok()?
            .flatten()
            .filter(|task| Some(&*task.file_name()) != this.file_name());
        let others =
            others.filter_map(|task| Some((task.file_name(), on_core(&task.path().join("schedstat"))?))).collect();
        Some(Self { own, others })
    }

    /// What this thread and the busiest other one have done since, s: threads that share work wait for no core, only for each
    /// other.
    pub fn path_since(&self, before: &Self) -> f64 {
        let done = |(name, now): (&OsString, &f64)| now - before.others.get(name).copied().unwrap_or(0.0);
        self.own - before.own + self.others.iter().map(done).fold(0.0, f64::max)
    }
}

/// The first number is nanoseconds on a core.
fn on_core(file: &Path) -> Option<f64> {
    Some(1e-9 * std::fs::read_to_string(file).ok()?.split_whitespace().next()?.parse::<f64>().ok()?)
}

#[cfg(test)]
mod tests {
    use super::{OsString, Threads};

    fn threads(own: f64, others: &[(&str, f64)]) -> Threads {
        Threads { own, others: others.iter().map(|(name, seconds)| (OsString::from(name), *seconds)).collect() }
    }

    #[test]
    fn the_path_is_that_of_this_thread_and_the_busiest_other() {
        let before = threads(1.0, &[("a", 5.0), ("b", 2.0)]);
        let after = threads(1.5, &[("a", 5.25), ("b", 4.0), ("c", 1.0)]);
        assert_eq!(after.path_since(&before), 2.5);
        assert_eq!(threads(3.0, &[]).path_since(&threads(1.0, &[])), 2.0);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn linux_tells_what_a_thread_has_done() {
        let before = Threads::now().unwrap();
        let mut sum = 0.0_f64;
        while Threads::now().unwrap().path_since(&before) < 1e-3 {
            sum += std::hint::black_box(sum).sqrt();
        }
        assert!(sum.is_finite());
    }
}
