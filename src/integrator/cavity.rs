//! Air in the cavity behind the projectile: its gauge pressure on the wall of the cavity, constant where it is sealed, else
//! that of the air that has flowed in.
//!
//! The wall is the part of the surface that stems from the entry surface and lies below z = 0 in the frame of the
//! block, also where it touches the projectile: there contact carries the stress less the pressure in the cavity, and a
//! uniform pressure all around the projectile has no resultant. The projectile hence feels the air on its rear through
//! the contact at its front, and contact ends where the stress falls to the pressure in the cavity.
//!
//! The cavity begins when the rear of the projectile passes z = 0 in the frame of the block: the pressure rises with
//! the depth of the rear over a ramp length δ, and on the wall with its depth over δ, so that neither an event nor the
//! rim of the entry hole makes a jump. From then on the work is p dV, with the volume V below z = 0.

use super::load_input::LoadInput;
use super::workspace::{FacetLoad, PressureSource};
use super::{CavityAir, LoadedFacet};
use crate::fem::{Potential, push};
use crate::math::Vector;
use crate::state::CavityGas;

/// Cavity at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OpenCavity {
    /// Gauge pressure, Pa.
    gauge: f64,
    /// Ramp length, m.
    ramp: f64,
    /// Height of the entry surface, m: 0 unless the block moves as a whole.
    entry: f64,
}

impl OpenCavity {
    /// Returns the cavity at a tick, with this gas in it, if its air is not vented and the rear of an active projectile is below the entry
    /// surface.
    pub fn at<const D: usize, P: Potential<D>>(input: &LoadInput<'_, D, P>, gas: Option<CavityGas>) -> Option<Self> {
        let LoadInput { model, projectile: last, time, entry, .. } = *input;
        let CavityAir { gauge, ramp, inflow } = model.gel.loads.air?;
        let share = inflow.map_or(1.0, |_| gas.map_or(0.0, |gas| 1.0 - gas.pressure));
        let body = &model.bodies[0];
        let depth = entry - body.rear(&last.at(body, time));
        (last.active && depth > 0.0).then(|| Self { gauge: gauge * share * (depth / ramp).min(1.0), ramp, entry })
    }

    /// Returns the mean weight over a facet, by its corners and its middle, and a bound of its derivative with respect
    /// to depth, 1/m.
    fn mean_weight<const D: usize>(&self, corners: &[Vector<D>]) -> (f64, f64) {
        let heights = || corners.iter().map(|x| x[D - 1] - self.entry);
        let is_in_ramp = heights().any(|z| z > -self.ramp) && heights().any(|z| z < 0.0);
        let mean = mean_over(corners, |x| rise(x[D - 1] - self.entry, self.ramp));
        (mean, if is_in_ramp { 1.0 / self.ramp } else { 0.0 })
    }
}

/// Returns the fraction of the pressure that acts at a height z above the entry surface, m, with this ramp length, m.
pub(super) fn rise(z: f64, ramp: f64) -> f64 {
    (-z / ramp).clamp(0.0, 1.0)
}

/// Returns the mean of a function of the position over a facet, by its corners and its middle.
pub(super) fn mean_over<const D: usize>(corners: &[Vector<D>], of: impl Fn(&Vector<D>) -> f64) -> f64 {
    let n = corners.len() as f64;
    let middle = of(&(corners.iter().sum::<Vector<D>>() / n));
    0.5 * (middle + corners.iter().map(&of).sum::<f64>() / n)
}

/// Finds the load of the air on a facet of the wall, and the stiffness that it adds to the element behind the facet,
/// N/m.
pub(super) fn find_air_load<const D: usize, P: Potential<D>>(
    input: &LoadInput<'_, D, P>,
    cavity: &OpenCavity,
    loaded: &LoadedFacet,
) -> Option<(FacetLoad<D>, f64)> {
    let corners = input.corners(loaded);
    let (weight, steepness) = cavity.mean_weight(&corners[..D]);
    if weight == 0.0 {
        return None;
    }
    // The surface of the gel faces the void: a pressure in the void is one into the gel.
    let (pressure, push) = (cavity.gauge * weight, push(input.model.gel.loads.section, &corners));
    let area = push.forces.iter().sum::<Vector<D>>().norm();
    // As for a load that rises with depth: each corner has at most 1/D of the weight at the middle and of its own.
    let added = pressure.abs() * push.stiffness + cavity.gauge.abs() * steepness * area / (D as f64).sqrt();
    Some((input.load(loaded, push.forces.map(|force| force * pressure), PressureSource::Cavity), added))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weight_rises_below_the_surface_and_is_steep_in_the_ramp_alone() {
        let cavity = OpenCavity { gauge: 1.0, ramp: 0.5, entry: 0.0 };
        let mean = |z: [f64; 2]| cavity.mean_weight(&z.map(|z| Vector::<2>::new(1.0, z)));
        let found = [[0.2, 0.1], [0.0, 0.0], [-0.1, -0.4], [-0.5, -2.0], [0.25, -0.75]].map(mean);
        assert_eq!(found, [(0.0, 0.0), (0.0, 0.0), (0.5, 2.0), (1.0, 0.0), (0.5, 2.0)]);
    }

    #[test]
    fn the_mean_weight_has_at_most_the_derivative_of_its_bound() {
        let cavity = OpenCavity { gauge: 1.0, ramp: 0.5, entry: 0.0 };
        let mut most: f64 = 0.0;
        for (a, b) in (0..40).flat_map(|a| (0..40).map(move |b| (f64::from(a), f64::from(b)))) {
            let at = |step: f64| [0.31 - 0.04 * a - step, 0.33 - 0.04 * b].map(|z| Vector::<2>::new(1.0, z));
            let (before, bound) = cavity.mean_weight(&at(0.0));
            let slope = (cavity.mean_weight(&at(1e-7)).0 - before) / 1e-7;
            // The bound of the whole facet is shared by its two corners.
            assert!(slope <= 0.5 * bound + 1e-6, "{a} {b}: {slope} {bound}");
            most = most.max(slope);
        }
        assert!((most - 1.0).abs() < 1e-6, "{most}");
    }
}
