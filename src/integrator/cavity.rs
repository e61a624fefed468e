//! Air in the cavity behind the projectile: its gauge pressure on the wall of the cavity and on the projectile's rear.
//!
//! The cavity is the void below the undisturbed entry surface z = 0 and above the rear z_r of the projectile. The
//! pressure p has the potential −p V with V = ∫ a(z) A(z) dz: A is the cross-section of the void, and the weight a
//! rises from 0 to 1 over the ramp length δ below z = 0 and above z_r. The force on the wall is −∂(−pV)/∂x, a follower
//! pressure p a; that on the projectile is −∂(−pV)/∂z_r = −p ∫ a A dz/δ over the ramp at its rear: the pressure times
//! the cross-section of the void there.

use super::LoadedFacet;
use super::system::DiscreteSystem;
use super::workspace::{FacetLoad, PressureSource};
use crate::contact::BodyMotion;
use crate::fem::{Potential, push, slab_volume};
use crate::math::{Vector, Vector3};
use crate::state::Tick;

/// Air in a sealed cavity behind the projectile, body 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CavityAir {
    /// Gauge pressure, Pa, scaled by the number of symmetric copies: positive pushes the wall outwards.
    pub gauge: f64,
    /// Length δ over which the pressure rises below z = 0 and above the rear of the projectile, m.
    pub ramp: f64,
}

/// Cavity at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OpenCavity {
    air: CavityAir,
    /// Height of the rear of the projectile, m.
    rear: f64,
}

impl OpenCavity {
    /// Returns the cavity at a time, s, if it is sealed and the rear of an active projectile is below z = 0.
    pub fn at<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, time: f64) -> Option<Self> {
        let air = system.model.gel.loads.air?;
        let (body, last) = (&system.model.bodies[0], &system.state.bodies[0]);
        let rear = body.rear(&last.at(body, time));
        (last.active && rear < 0.0).then_some(Self { air, rear })
    }

    /// Returns the fraction of the pressure that acts at a height z, m.
    fn weight(&self, z: f64) -> f64 {
        let part = |depth: f64| (depth / self.air.ramp).clamp(0.0, 1.0);
        part(-z) * part(z - self.rear)
    }

    /// Returns the mean weight over a facet, by its corners and its middle.
    fn mean_weight<const D: usize>(&self, corners: &[Vector<D>]) -> f64 {
        let middle = corners.iter().map(|x| x[D - 1]).sum::<f64>() / D as f64;
        let ends = corners.iter().map(|x| self.weight(x[D - 1])).sum::<f64>() / D as f64;
        0.5 * (self.weight(middle) + ends)
    }

    /// Returns a bound of |da/dz| over a facet, 1/m: the sum of the slopes of the ramps that it meets.
    fn steepness<const D: usize>(&self, corners: &[Vector<D>]) -> f64 {
        let heights = || corners.iter().map(|x| x[D - 1]);
        let (low, high) = (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
        let meets = |from: f64| f64::from(u8::from(low < from + self.air.ramp && high > from));
        (meets(-self.air.ramp) + meets(self.rear)) / self.air.ramp
    }

    /// Returns the derivative of the weighted volume with respect to the height of the rear, m², that a facet
    /// contributes, negative: the cross-section of the void in the ramp at the rear.
    fn rear_section<const D: usize, P: Potential<D>>(
        &self,
        system: &DiscreteSystem<D, P>,
        corners: &[Vector<D>; 3],
    ) -> f64 {
        let heights = [self.rear, (self.rear + self.air.ramp).min(0.0)];
        let below_surface = (-0.5 * (heights[0] + heights[1]) / self.air.ramp).min(1.0);
        slab_volume(system.model.gel.loads.section, corners, heights) * below_surface / self.air.ramp
    }
}

/// Finds the load of the air on a facet of the wall, and the stiffness that it adds to the element behind the facet,
/// N/m.
pub(super) fn find_air_load<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    cavity: &OpenCavity,
    loaded: &LoadedFacet,
    group: usize,
    tick: Tick,
) -> Option<(FacetLoad<D>, f64)> {
    let time = system.model.grid.time(tick);
    let corners = loaded.facet.map(|node| system.position_at(node, time));
    // A pressure in the void is one into the gel.
    let pressure = cavity.air.gauge * cavity.mean_weight(&corners[..D]);
    let on_body = -cavity.air.gauge * cavity.rear_section(system, &corners);
    if pressure == 0.0 && on_body == 0.0 {
        return None;
    }
    let push = push(system.model.gel.loads.section, &corners);
    let area = push.forces.iter().sum::<Vector<D>>().norm();
    let growth = cavity.air.gauge.abs() * cavity.steepness(&corners[..D]);
    // As for a pressure that rises with depth: |∂a/∂x| ≤ |a′|/√D.
    let added = pressure.abs() * push.stiffness + growth * area / (D as f64).sqrt();
    let (forces, weight) = (push.forces.map(|force| force * pressure), system.trailing_half(group, tick));
    let source = PressureSource::Cavity { on_body };
    Some((FacetLoad { nodes: loaded.facet, forces, group, weight, source }, added))
}

/// Gives the projectile the impulse of the air on its rear, N·s, and books its momentum. The support of a body that is
/// not free takes it up.
pub(super) fn push_projectile<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, along_z: f64) {
    let (body, freedom) = (&system.model.bodies[0], system.freedom());
    let impulse = freedom.translation(&(Vector3::z() * along_z));
    system.workspace.air_impulse = impulse;
    let at = &mut system.workspace.bodies_after[0];
    if body.motion != BodyMotion::Free || impulse == Vector3::zeros() {
        return;
    }
    let centre = at.position;
    body.strike(at, &centre, &impulse);
    let ledger = &mut system.state.ledger;
    ledger.momentum.air += impulse;
    ledger.angular_momentum.air += freedom.rotation(&centre.cross(&impulse));
    system.state.record.pressed += impulse.norm();
}

/// Returns the work of the air on a free projectile, J·(V⁻ + V⁺)/2, J.
pub(super) fn work_on_projectile<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>) -> f64 {
    let workspace = &system.workspace;
    if system.model.bodies[0].motion != BodyMotion::Free {
        return 0.0;
    }
    0.5 * workspace.air_impulse.dot(&(workspace.bodies_before[0].velocity + workspace.bodies_after[0].velocity))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weight_rises_below_the_surface_and_above_the_rear() {
        let cavity = OpenCavity { air: CavityAir { gauge: 1.0, ramp: 0.5 }, rear: -4.0 };
        let found = [0.5, 0.0, -0.25, -0.5, -2.0, -3.5, -3.75, -4.0, -5.0].map(|z| cavity.weight(z));
        assert_eq!(found, [0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 0.5, 0.0, 0.0]);
        let slope = |z: [f64; 2]| cavity.steepness(&z.map(|z| Vector::<2>::new(1.0, z)));
        assert_eq!(
            [[0.2, 0.1], [0.1, -0.1], [-1.0, -2.0], [-3.4, -3.6], [0.1, -4.1]].map(slope),
            [0.0, 2.0, 0.0, 2.0, 4.0]
        );
    }
}
