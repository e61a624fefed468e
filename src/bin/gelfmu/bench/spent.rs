//! Time that work takes: what the clock on the wall says, and what the process was given.

use cpu_time::ProcessTime;
use std::time::Instant;

/// Time that some work took, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spent {
    /// On the wall.
    pub wall: f64,
    /// Of all threads of the process: not that of others on the same machine.
    pub cpu: f64,
}

/// How long to measure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Repetitions of which the least counts.
    pub repeats: usize,
    /// Least length of one, CPU seconds.
    pub seconds: f64,
}

impl Effort {
    /// A repetition must be far longer than the clock is wrong by.
    pub const QUICK: Self = Self { repeats: 3, seconds: 0.004 };
    /// A neighbour on the machine takes a core for some tenths of a second at a time.
    pub const FULL: Self = Self { repeats: 9, seconds: 0.05 };
}

impl Spent {
    /// What `work` takes, once.
    pub fn on(work: impl FnOnce()) -> Self {
        let (cpu, wall) = (ProcessTime::now(), Instant::now());
        work();
        Self { wall: wall.elapsed().as_secs_f64(), cpu: cpu.elapsed().as_secs_f64() }
    }

    /// What `work` takes, each time the least of many repetitions; each begins with `prepare`, which is not counted.
    pub fn least<T>(effort: Effort, mut prepare: impl FnMut() -> T, mut work: impl FnMut(T)) -> Self {
        let mut least = Self { wall: f64::INFINITY, cpu: f64::INFINITY };
        for _ in 0..effort.repeats {
            let prepared = prepare();
            least = least.or_less(Self::on(|| work(prepared)));
        }
        least
    }

    /// What one turn of `work` takes, in repetitions of so many turns that each is as long as it must be.
    pub fn per_turn(effort: Effort, mut work: impl FnMut()) -> Self {
        let mut turns = 1_u32;
        while Self::on(|| (0..turns).for_each(|_| work())).cpu < effort.seconds {
            turns *= 2;
        }
        let all = Self::least(effort, || (), |()| (0..turns).for_each(|_| work()));
        Self { wall: all.wall / f64::from(turns), cpu: all.cpu / f64::from(turns) }
    }

    /// The lesser of each.
    pub fn or_less(self, other: Self) -> Self {
        Self { wall: self.wall.min(other.wall), cpu: self.cpu.min(other.cpu) }
    }
}
