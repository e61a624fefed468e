//! Mass-proportional damping: each node loses speed as exp(−αt) between its kicks, for equilibrium solutions.

use super::kick_sums::DampingLoss;
use super::system::DiscreteSystem;
use crate::fem::Potential;
use crate::math::Vector;

/// Returns the damping impulse on a node at this tick, N·s.
pub(super) fn damping_impulse<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, a: usize) -> Vector<D> {
    if system.model.settings.damping > 0.0 && system.workspace.active_nodes.has(a) {
        system.workspace.velocities_before[a] * (system.model.gel.mass[a] * system.workspace.decay[a])
    } else {
        Vector::<D>::zeros()
    }
}

/// Damps the active nodes of the reference form.
pub(super) fn apply_damping<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    if system.model.settings.damping <= 0.0 {
        return;
    }
    let (freedom, mut loss) = (system.freedom(), DampingLoss::default());
    for a in system.workspace.active_nodes.reference_nodes().iter().map(|a| *a as usize) {
        system.state.velocity[a] += system.workspace.velocities_before[a] * system.workspace.decay[a];
        loss.add_impulse(freedom, &system.state.position[a], &damping_impulse(system, a));
    }
    let time = system.workspace.bodies_before[0].time;
    loss.post(&mut system.state.ledger, &mut system.state.record.outside, time);
}

/// Posts the work of damping of the reference form, once all velocities of the tick are known.
pub(super) fn post_damping_work<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    let both = |a: usize| system.workspace.velocities_before[a] + system.state.velocity[a];
    let of = |a: usize| 0.5 * damping_impulse(system, a).dot(&both(a));
    if system.model.settings.damping > 0.0 {
        let work: f64 = system.workspace.active_nodes.reference_nodes().iter().map(|a| of(*a as usize)).sum();
        system.state.ledger.energy.damping += work;
    }
}
