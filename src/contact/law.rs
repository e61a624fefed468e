//! Impulse laws of a contact point (method 2.3).

/// Contact impulse law between a surface node and a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ImpulseLaw {
    /// Moreau's impact law on half-step velocities, once per node and tick.
    Moreau {
        /// e ∈ [0, 1], coefficient of restitution.
        restitution: f64,
        /// β, fraction of a standing penetration removed in one step of the node.
        bias: f64,
        /// μ, Coulomb's coefficient of friction.
        friction: f64,
    },
    /// The paper's reversal of the approaching momentum, after each element's kick.
    Reversal,
}

/// Returns the normal impulse between a node and a rigid body, N·s; never attractive.
///
/// Moreau's law on half-step velocities (method 2.3, A7): J = max(0, −(u_free + e·u_before − b)/K). `before` and
/// `free` are the relative normal velocities before and after this tick's kicks, m/s. `rebound` = b − e·u_before
/// combines restitution and the bias velocity b ≥ 0. `compliance` is K = 1/m + 1/M + (r×n)·I⁻¹(r×n), 1/kg.
#[must_use]
pub fn impulse(free: f64, rebound: f64, compliance: f64) -> f64 {
    debug_assert!(compliance > 0.0, "compliance must be positive");
    ((rebound - free) / compliance).max(0.0)
}

/// Returns the impulse that reverses an approaching relative normal velocity u, N·s: J = max(0, −2u/K) (the paper,
/// section 3).
#[must_use]
pub fn reversal(approach: f64, compliance: f64) -> f64 {
    impulse(approach, -approach, compliance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impulses_never_attract() {
        assert_eq!(impulse(0.3, 0.0, 2.0), 0.0);
        assert_eq!(reversal(0.3, 2.0), 0.0);
    }

    #[test]
    fn a_touching_node_leaves_with_the_restituted_velocity() {
        for (before, free, e) in [(-2.0, -3.0, 0.0), (-2.0, -3.0, 0.5), (-2.0, -1.0, 1.0)] {
            let compliance = 0.7;
            let after = free + compliance * impulse(free, -e * before, compliance);
            assert!((after + e * before).abs() < 1e-14);
        }
        assert!((-3.0 + 0.7 * reversal(-3.0, 0.7) - 3.0).abs() < 1e-14);
    }
}
