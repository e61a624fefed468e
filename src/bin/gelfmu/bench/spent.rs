//! Time measurement: wall-clock time and CPU time of the process.

use cpu_time::ProcessTime;
use std::time::Instant;

/// Least and greatest of some measured times, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeRange {
    /// Least time: the one that counts.
    pub least: f64,
    /// Greatest time.
    pub greatest: f64,
}

/// Times of a measured task.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredTime {
    /// Wall-clock time.
    pub wall: TimeRange,
    /// CPU time of all threads of this process; other processes do not count.
    pub cpu: TimeRange,
}

impl TimeRange {
    fn once(seconds: f64) -> Self {
        Self { least: seconds, greatest: seconds }
    }

    /// Returns the range of both.
    fn union(self, other: Self) -> Self {
        Self { least: self.least.min(other.least), greatest: self.greatest.max(other.greatest) }
    }

    fn divided(self, parts: f64) -> Self {
        Self { least: self.least / parts, greatest: self.greatest / parts }
    }

    /// Returns the excess of the greatest time over the least, relative to the least.
    pub fn spread(self) -> f64 {
        self.greatest / self.least - 1.0
    }
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
        Self { wall: TimeRange::once(wall.elapsed().as_secs_f64()), cpu: TimeRange::once(cpu.elapsed().as_secs_f64()) }
    }

    /// Returns the time of one call of `work`; each repetition has enough calls for the least CPU time.
    pub fn per_turn(policy: RepeatPolicy, mut work: impl FnMut()) -> Self {
        let mut turns = 1_u32;
        while Self::measure(|| (0..turns).for_each(|_| work())).cpu.least < policy.seconds {
            turns *= 2;
        }
        let mut measure = || Self::measure(|| (0..turns).for_each(|_| work()));
        let first = measure();
        let all = (1..policy.repeats).fold(first, |all, _| all.union(measure()));
        Self { wall: all.wall.divided(f64::from(turns)), cpu: all.cpu.divided(f64::from(turns)) }
    }

    /// Returns the range of both.
    pub fn union(self, other: Self) -> Self {
        Self { wall: self.wall.union(other.wall), cpu: self.cpu.union(other.cpu) }
    }
}
