//! Grid of ticks: the length of a tick, and times as whole numbers of it (method A3).

use crate::state::Tick;

/// Grid of ticks: τ = q 2⁻ᵏ s with q in 16..=31, so that every time T τ with T q < 2⁵³ is exact (method A3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TickGrid {
    /// Length τ of a tick, s.
    tau: f64,
}

/// Ticks per smallest initial step, at least: a step shorter than a tick, a thousandth of that step, is a collapse
/// (A11).
const HEADROOM: f64 = 1024.0;

/// Fraction of a tick by which a communication point may miss a tick and still include it (A3).
const TICK_TOLERANCE: f64 = 1e-3;

/// Fraction of the elements whose steps are assumed to shrink by [`SHRINKAGE`] once the gel moves. At 0 a bin was
/// placed 1.6 % below the steps of four fifths of a million tetrahedra under a ball, though one 7 % below was as
/// good at rest: a twentieth of the steps fell out of the bin, and the run took 12 % longer. From 0.05 on a bin no
/// longer fits equal steps tightly.
const SHRINKING_FRACTION: f64 = 0.02;
/// Ratio of a shrunk step to the step at rest.
const SHRINKAGE: f64 = 0.95;

impl TickGrid {
    /// Builds the grid for these stable steps at rest, s, with τ at most a 1024th of the smallest. Of the sixteen
    /// lengths in an octave it takes the one with which power-of-two bins cost least, min_q Σ_K 1/dt_K (method
    /// 1.5), with some steps shrunk.
    ///
    /// # Panics
    /// If there is no step, or one is not positive.
    #[must_use]
    pub fn new(steps: &[f64]) -> Self {
        let smallest = steps.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(smallest > 0.0 && smallest.is_finite(), "stable steps must be positive");
        let bin = |step: f64, tau: f64| tau * floor_power_of_two(step / tau);
        let rate_of = |step: f64, tau: f64| {
            (1.0 - SHRINKING_FRACTION) / bin(step, tau) + SHRINKING_FRACTION / bin(SHRINKAGE * step, tau)
        };
        let rate = |tau: f64| crate::math::ordered_sum(steps.len(), 0.0, |i| rate_of(steps[i], tau));
        let candidates = (16..=31).map(|q| longest_fitting(f64::from(q), smallest / HEADROOM));
        let tau = candidates.map(|tau| (rate(tau), tau)).min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |best| best.1);
        Self { tau }
    }

    /// Returns the least stable step of the first mesh at rest, s, rounded down to a length of ticks.
    #[must_use]
    pub fn first_step(&self) -> f64 {
        self.length(HEADROOM)
    }

    /// Returns the time of a tick, s.
    #[must_use]
    #[inline]
    pub fn time(&self, tick: Tick) -> f64 {
        // The value is below 2⁵³ (A3); SIMD units before AVX-512 convert only signed integers.
        tick.cast_signed() as f64 * self.tau
    }

    /// Returns the length of a number of ticks, whole or not, s.
    #[must_use]
    #[inline]
    pub fn length(&self, ticks: f64) -> f64 {
        ticks * self.tau
    }

    /// Converts a duration, s, to ticks.
    #[must_use]
    pub fn ticks(&self, duration: f64) -> f64 {
        duration / self.tau
    }

    /// Returns the first tick at or after time `t`, s: ⌈t/τ − 10⁻³⌉.
    #[must_use]
    pub fn first_tick(&self, t: f64) -> Tick {
        (t / self.tau - TICK_TOLERANCE).ceil().max(0.0) as Tick
    }

    /// Returns the last tick that belongs to a step ending at time `t`, s: ⌊t/τ + 10⁻³⌋.
    #[must_use]
    pub fn last_tick(&self, t: f64) -> Tick {
        (t / self.tau + TICK_TOLERANCE).floor().max(0.0) as Tick
    }
}

/// Returns q 2⁻ᵏ for the k with q 2⁻ᵏ ≤ `longest` < q 2¹⁻ᵏ.
fn longest_fitting(q: f64, longest: f64) -> f64 {
    q * floor_power_of_two(longest / q)
}

/// Returns the power of two 2ⁿ ≤ x < 2ⁿ⁺¹ of a positive normal number, by clearing its mantissa.
#[must_use]
pub fn floor_power_of_two(x: f64) -> f64 {
    debug_assert!(x.is_normal() && x > 0.0, "no power of two below {x}");
    f64::from_bits(x.to_bits() & 0x7FF0_0000_0000_0000)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::SQRT_2;

    #[test]
    fn ticks_are_exact_and_fine_enough() {
        for smallest in [1.0, 3.3e-6, 7.7e-9, 0.61] {
            let grid = TickGrid::new(&[smallest, 1.7 * smallest, 11.0 * smallest]);
            let tau = grid.time(1);
            assert!(tau <= smallest / 1024.0 && tau > smallest / 2048.0);
            let q = tau / floor_power_of_two(tau) * 16.0;
            assert_eq!(q, q.floor());
            assert_eq!(grid.time(123_456_789) - grid.time(123_456_788), tau);
        }
    }

    #[test]
    fn a_communication_point_includes_a_tick_it_misses_by_rounding() {
        let grid = TickGrid::new(&[1e-3]);
        let t = grid.time(1000);
        assert_eq!(grid.last_tick(t * (1.0 - 1e-15)), 1000);
        assert_eq!(grid.last_tick(t - 0.5 * grid.time(1)), 999);
        assert_eq!([t * (1.0 + 1e-15), t - 0.5 * grid.time(1)].map(|t| grid.first_tick(t)), [1000; 2]);
    }

    #[test]
    fn the_grid_is_chosen_so_that_bins_lose_least() {
        let above_its_bin = |steps: &[f64], step: f64| {
            let ticks = TickGrid::new(steps).ticks(step);
            ticks / floor_power_of_two(ticks)
        };
        // Equal steps: a bin fits them tightly.
        let above = above_its_bin(&[1.37e-3; 10], 1.37e-3);
        assert!((1.0..1.06).contains(&above), "{above}");
        // Steps of 968 112 tetrahedra on a centred lattice: of two bins equal at rest, the grid takes the one that
        // tolerates shrinkage.
        let classes = [(47, 1.0), (1, 1.095), (66, 1.225), (1, 1.291), (63, 1.354), (790, SQRT_2)];
        let steps = classes.iter().flat_map(|(n, step)| vec![1.2342e-5 * step; *n]).collect::<Vec<_>>();
        let above = above_its_bin(&steps, 1.2342e-5 * SQRT_2);
        assert!((1.0 / SHRINKAGE..1.1 / SHRINKAGE).contains(&above), "{above}");
    }
}
