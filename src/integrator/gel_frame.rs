//! Frame of the block: the rigid motion of the whole gel, against which depths are measured.
//!
//! By the momentum theorem the centre of mass of the gel moves by
//!
//!   X(t) = V₀ t + Σ J (t − t_J)/M,
//!
//! with its velocity V₀ at the start, its mass M and the impulses J on it from outside. Eroded gel counts as part of
//! the block that flies on. Where something holds the gel in a direction, its deformation is no motion of the block,
//! and X is 0.

use crate::contact::BodyState;
use crate::math::Vector3;
use crate::state::OutsideImpulse;

/// Frame of the block: constants of its rigid motion. The default does not move.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GelFrame {
    /// V₀, velocity at the start, m/s; 0 in directions in which the gel is held.
    pub initial_velocity: Vector3,
    /// 1/M in free directions, 1/kg, and 0 in directions in which the gel is held.
    pub mobility: Vector3,
}

/// Rigid motion of the block at one time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BlockMotion {
    /// Displacement of the centre of mass since the start by the momentum of the gel, m.
    pub displacement: Vector3,
    /// Velocity of the centre of mass, m/s.
    pub velocity: Vector3,
}

impl GelFrame {
    /// Returns the motion at a time, s, after these impulses.
    #[must_use]
    pub fn motion(&self, outside: &OutsideImpulse, time: f64) -> BlockMotion {
        BlockMotion {
            displacement: self.initial_velocity * time + outside.integral(time).component_mul(&self.mobility),
            velocity: self.initial_velocity + outside.sum.component_mul(&self.mobility),
        }
    }
}

impl BlockMotion {
    /// Returns the state of a body as it is seen from the block, which does not turn.
    #[must_use]
    pub fn seen_from(&self, at: &BodyState) -> BodyState {
        BodyState { position: at.position - self.displacement, velocity: at.velocity - self.velocity, ..*at }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Engine, IntegratorSettings, test_cube};
    use super::*;
    use crate::contact::{BodyMotion, FreeDirections, ImpulseExchange, RigidBody};
    use crate::fem::{Potential, Simplices};
    use crate::geometry::{ShapeGeometry, Sphere};
    use crate::math::Tensor3;
    use crate::mesh::NodeId;

    /// Creates the test cube with this start velocity, damped, and a ball that falls on it aslant.
    fn struck_cube(start: Vector3) -> Engine<3, Simplices<3>> {
        let gel = test_cube::gel(&test_cube::mesh(&[0.0, 0.3, 0.6, 1.0]));
        let (shape, inertia) = (ShapeGeometry::Sphere(Sphere { radius: 0.2 }), Tensor3::identity() * 1e-3);
        let ball = RigidBody::new(shape, BodyMotion::Free, FreeDirections::SPATIAL, 0.1, inertia);
        let at = BodyState::at_start(Vector3::new(0.45, 0.55, 1.21), Vector3::new(0.5, 0.0, -2.0));
        let nodes = gel.potential.rest().iter().map(|x| (*x, start)).collect();
        let mobility = Vector3::repeat(1.0 / gel.mass.iter().sum::<f64>());
        let rules = IntegratorSettings { damping: 0.3, ..test_cube::rules() };
        let mut engine = Engine::new(gel, vec![(ball, at)], rules, nodes);
        engine.set_frame(GelFrame { initial_velocity: start, mobility });
        engine
    }

    #[test]
    fn the_displacement_of_the_block_is_that_of_its_centre_of_mass() {
        let mut engine = struck_cube(Vector3::new(0.2, -0.1, 0.4));
        let centre = |engine: &Engine<3, Simplices<3>>, time: f64| {
            let mass = &engine.gel().mass;
            let weighed = |i: usize| engine.position_at(NodeId(i as u32), time) * mass[i];
            (0..mass.len()).map(weighed).sum::<Vector3>() / mass.iter().sum::<f64>()
        };
        let start = centre(&engine, 0.0);
        for time in [0.004, 0.03, 0.1] {
            engine.advance_to(time, &mut [ImpulseExchange::default()]).expect("the cube only swings");
            let off = centre(&engine, time) - start - engine.block_motion(time).displacement;
            assert!(off.norm() < 1e-13, "{time}: {off}");
        }
        assert!(engine.state().record.contacts[0].impulse.z > 0.1, "the ball has met the cube");
    }

    #[test]
    fn a_block_moves_by_its_start_and_by_each_impulse_since_its_time() {
        let mobility = Vector3::new(0.25, 0.0, 0.25);
        let frame = GelFrame { initial_velocity: Vector3::new(0.5, 0.0, -2.0), mobility };
        let mut outside = OutsideImpulse::default();
        outside.add(&Vector3::new(0.0, 3.0, -8.0), 1.0);
        outside.add(&Vector3::new(2.0, 0.0, 4.0), 2.0);
        let motion = frame.motion(&outside, 4.0);
        assert_eq!(motion.velocity, Vector3::new(1.0, 0.0, -3.0));
        assert_eq!(motion.displacement, Vector3::new(0.5 * 4.0 + 0.5 * 2.0, 0.0, -2.0 * 4.0 - 2.0 * 3.0 + 1.0 * 2.0));
        assert_eq!(GelFrame::default().motion(&outside, 4.0), BlockMotion::default());
    }
}
