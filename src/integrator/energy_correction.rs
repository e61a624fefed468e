//! Energy correction: returns the energy that a remesh has taken to the motion of the new elements (method 4.7).

use super::derived::derive_from_state;
use super::system::DiscreteSystem;
use crate::fem::Potential;
use crate::math::{Vector, ordered_sum};
use crate::mesh::{ElementId, NodeId};

/// Upper bound of the impulses of [`return_energy`], as a fraction of those that would end an element's motion along
/// its edges. The elements around a node then change its velocity by four fifths of its velocity relative to its
/// neighbours. In `fbi-bb-3d` on cells of R/3.6 remeshing takes, net, 1.2 % of E₀ at 0.05, 0.25 % at 0.1, 0.05 % at 0.2
/// and 0.03 % at 0.4. Without correction it takes 3.8 %.
const MAX_FACTOR: f64 = 0.2;

/// Impulses on nodes, N·s, and their work per unit of a small factor, J.
struct NodalImpulses<const D: usize> {
    by_node: Vec<Vector<D>>,
    work: f64,
}

impl<const D: usize> NodalImpulses<D> {
    /// Adds m (ê·v) ê to the second of two nodes and subtracts it from the first, with ê along x and v their relative
    /// velocity.
    fn add(&mut self, a: usize, b: usize, m: f64, x: Vector<D>, v: Vector<D>) {
        if let Some(along) = x.try_normalize(0.0) {
            let relative_speed = v.dot(&along);
            self.by_node[a] -= along * (m * relative_speed);
            self.by_node[b] += along * (m * relative_speed);
            self.work += m * relative_speed * relative_speed;
        }
    }
}

/// Gives an energy, J, to the motion of the free nodes of these elements, each with its mass, kg, and books it as
/// `remesh` and as returned.
///
/// Along each edge ê of an element of mass m, impulses ± ε m (ê·(v_b − v_a)) ê accelerate the relative motion of
/// its ends. Momentum and angular momentum are conserved, and the energy grows by ε Σ m (ê·(v_b − v_a))² + ½ε² Σ
/// p²/m_a, which gives ε. ε is negative where energy is taken.
pub(super) fn return_energy<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    made: &[(ElementId, f64)],
    energy: f64,
) {
    let NodalImpulses { by_node, work } = edge_impulses(system, made);
    let square_over_mass = |a: usize| {
        if system.model.gel.mass[a] > 0.0 { by_node[a].norm_squared() / system.model.gel.mass[a] } else { 0.0 }
    };
    let square = ordered_sum(by_node.len(), 0.0, square_over_mass);
    let factor = solve_factor(energy, work, square);
    for (a, impulse) in by_node.iter().enumerate().filter(|(_, impulse)| **impulse != Vector::<D>::zeros()) {
        system.state.velocity[a] += impulse * (factor / system.model.gel.mass[a]);
    }
    let returned = factor * (work + 0.5 * factor * square);
    system.state.ledger.energy.remesh += returned;
    system.state.ledger.energy.remesh_returned += returned;
    derive_from_state(system);
}

/// Sums m (ê·(v_b − v_a)) ê along the edges of these elements, in ascending order.
fn edge_impulses<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    made: &[(ElementId, f64)],
) -> NodalImpulses<D> {
    let (position, velocity) = (&system.state.position, &system.state.velocity);
    let mut impulses = NodalImpulses { by_node: vec![Vector::zeros(); velocity.len()], work: 0.0 };
    let free =
        |node: &&NodeId| system.model.gel.held(node.index()) == [false; D] && system.model.gel.mass[node.index()] > 0.0;
    for (element, mass) in made {
        let nodes: Vec<usize> =
            system.model.gel.potential.nodes(*element).iter().filter(free).map(|node| node.index()).collect();
        for (i, b) in nodes.iter().copied().enumerate() {
            for a in nodes[..i].iter().copied() {
                // A node that has lost most of its mass gets no large velocity.
                let m = mass.min(system.model.gel.mass[a]).min(system.model.gel.mass[b]).max(0.0);
                impulses.add(a, b, m, position[b] - position[a], velocity[b] - velocity[a]);
            }
        }
    }
    impulses
}

/// Solves ε w + ½ε² s = E for ε, limited to ±[`MAX_FACTOR`].
fn solve_factor(energy: f64, work: f64, square: f64) -> f64 {
    let root = work * work + 2.0 * square * energy;
    // If these impulses cannot take the whole energy, they take the most they can.
    let factor = if root < 0.0 { -work / square } else { 2.0 * energy / (work + root.sqrt()) };
    if factor.is_finite() { factor.clamp(-MAX_FACTOR, MAX_FACTOR) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_impulse_factor_returns_the_energy_within_its_bound() {
        for (energy, work, square) in [(0.1, 1.0, 2.0), (-0.1, 1.0, 2.0), (1e-12, 3.0, 0.5)] {
            let part = solve_factor(energy, work, square);
            assert!((part * work + 0.5 * part * part * square - energy).abs() < 1e-15);
        }
        assert_eq!([5.0, -5.0].map(|energy| solve_factor(energy, 1.0, 1.0)), [MAX_FACTOR, -MAX_FACTOR]);
        // 1/40 is the most that can be taken.
        assert_eq!([-5.0].map(|energy| solve_factor(energy, 1.0, 20.0)), [-0.05]);
        assert_eq!([0.0, 1.0].map(|energy| solve_factor(energy, 0.0, 0.0)), [0.0, 0.0]);
    }
}
