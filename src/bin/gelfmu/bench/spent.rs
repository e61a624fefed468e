//! Time measurement: wall-clock time and CPU time of the process.

use cpu_time::ProcessTime;
use std::time::Instant;

/// Time of a measured task, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredTime {
    /// Wall-clock time.
    pub wall: f64,
    /// CPU time of all threads of this process; other processes do not count.
    pub cpu: f64,
}

/// Repetition policy of a measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RepeatPolicy {
    /// Number of repetitions; the least time counts.
    pub repeats: usize,
    /// Least CPU time of a repetition, s.
    pub seconds: f64,
}

impl RepeatPolicy {
    /// Quick policy: a repetition is far longer than the error of the clock.
    pub const QUICK: Self = Self { repeats: 3, seconds: 0.004 };
    /// Full policy: another process on the machine may take a core for some tenths of a second at a time.
    pub const FULL: Self = Self { repeats: 9, seconds: 0.05 };
}

impl MeasuredTime {
    /// Measures one call of `work`.
    pub fn measure(work: impl FnOnce()) -> Self {
        let (cpu, wall) = (ProcessTime::now(), Instant::now());
        work();
        Self { wall: wall.elapsed().as_secs_f64(), cpu: cpu.elapsed().as_secs_f64() }
    }

    /// Returns the least time of many calls of `work`; the time of `prepare` is not counted.
    pub fn least<T>(policy: RepeatPolicy, mut prepare: impl FnMut() -> T, mut work: impl FnMut(T)) -> Self {
        let mut least = Self { wall: f64::INFINITY, cpu: f64::INFINITY };
        for _ in 0..policy.repeats {
            let prepared = prepare();
            least = least.minimum(Self::measure(|| work(prepared)));
        }
        least
    }

    /// Returns the time of one call of `work`; each repetition has enough calls for the least CPU time.
    pub fn per_turn(policy: RepeatPolicy, mut work: impl FnMut()) -> Self {
        let mut turns = 1_u32;
        while Self::measure(|| (0..turns).for_each(|_| work())).cpu < policy.seconds {
            turns *= 2;
        }
        let all = Self::least(policy, || (), |()| (0..turns).for_each(|_| work()));
        Self { wall: all.wall / f64::from(turns), cpu: all.cpu / f64::from(turns) }
    }

    /// Returns the lesser of each time.
    pub fn minimum(self, other: Self) -> Self {
        Self { wall: self.wall.min(other.wall), cpu: self.cpu.min(other.cpu) }
    }
}
