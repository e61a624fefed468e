//! CPU time of each thread, on Linux: the critical path of a step if every thread had a core to itself.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::Path;

/// CPU time of this thread and of all other threads of the process, s.
#[derive(Debug, Clone, PartialEq)]
pub struct ThreadTimes {
    own: f64,
    others: BTreeMap<OsString, f64>,
}

impl ThreadTimes {
    /// Reads the current times; only Linux counts them finely enough.
    pub fn now() -> Option<Self> {
        let this = std::fs::read_link("/proc/thread-self").ok()?;
        let own = seconds_on_core(Path::new("/proc/thread-self/schedstat"))?;
        // While threads end, the list may miss one, or one may end before its numbers are read: the path is approximate
        // then.
        let others = std::fs::read_dir("/proc/self/task")
            .ok()?
            .flatten()
            .filter(|task| Some(&*task.file_name()) != this.file_name());
        let others = others
            .filter_map(|task| Some((task.file_name(), seconds_on_core(&task.path().join("schedstat"))?)))
            .collect();
        Some(Self { own, others })
    }

    /// Returns the CPU time of this thread plus the busiest other thread since `before`, s.
    ///
    /// Threads that share work wait for each other, not for a core.
    pub fn path_since(&self, before: &Self) -> f64 {
        let elapsed = |(name, now): (&OsString, &f64)| now - before.others.get(name).copied().unwrap_or(0.0);
        self.own - before.own + self.others.iter().map(elapsed).fold(0.0, f64::max)
    }
}

/// Reads the time on a core from a `schedstat` file: the first number, ns.
fn seconds_on_core(file: &Path) -> Option<f64> {
    Some(1e-9 * std::fs::read_to_string(file).ok()?.split_whitespace().next()?.parse::<f64>().ok()?)
}

#[cfg(test)]
mod tests {
    use super::{OsString, ThreadTimes};

    fn threads(own: f64, others: &[(&str, f64)]) -> ThreadTimes {
        ThreadTimes { own, others: others.iter().map(|(name, seconds)| (OsString::from(name), *seconds)).collect() }
    }

    #[test]
    fn the_path_adds_this_thread_and_the_busiest_other_one() {
        let before = threads(1.0, &[("a", 5.0), ("b", 2.0)]);
        let after = threads(1.5, &[("a", 5.25), ("b", 4.0), ("c", 1.0)]);
        assert_eq!(after.path_since(&before), 2.5);
        assert_eq!(threads(3.0, &[]).path_since(&threads(1.0, &[])), 2.0);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn linux_counts_the_time_of_a_thread() {
        let before = ThreadTimes::now().unwrap();
        let mut sum = 0.0_f64;
        while ThreadTimes::now().unwrap().path_since(&before) < 1e-3 {
            sum += std::hint::black_box(sum).sqrt();
        }
        assert!(sum.is_finite());
    }
}
