//! Momentum and angular momentum of gel and projectile together, summed afresh from positions and velocities: a check on
//! the books that does not read them.

use ballistic_gel::math::{Tensor3, Vector3};
use ballistic_gel::simulation::{MeshFrame, Simulation};
use nalgebra::{Quaternion, UnitQuaternion};

/// Masses of a spatial simulation at its start.
pub struct Whole {
    /// Of the nodes, kg: a quarter of each tetrahedron.
    pub nodes: Vec<f64>,
    /// Of the body, kg.
    pub body: f64,
    /// Of the body in its own frame, kg·m².
    inertia: Tensor3,
}

/// What is conserved.
#[derive(Debug, Clone, Copy)]
pub struct Momenta {
    /// N·s.
    pub linear: Vector3,
    /// About the origin, N·m·s.
    pub angular: Vector3,
    /// Σ m|v| and Σ |x × mv|, the scales of both.
    pub scale: (f64, f64),
}

impl Whole {
    /// The masses of a gel of this density, kg/m³, and of its body.
    pub fn of(simulation: &Simulation, density: f64) -> Self {
        let frame = simulation.frame();
        assert_eq!(frame.dimension, 3, "a whole is spatial");
        let mut nodes = vec![0.0; frame.points.len()];
        for tetrahedron in &frame.cells.nodes {
            let rest = tetrahedron.map(|node| frame.points[node as usize] - frame.displacements[node as usize]);
            let volume = (rest[1] - rest[0]).cross(&(rest[2] - rest[0])).dot(&(rest[3] - rest[0])).abs() / 6.0;
            for node in tetrahedron {
                nodes[*node as usize] += density * volume / 4.0;
            }
        }
        let (body, [xx, yy, zz, xy, xz, yz]) = simulation.inertia(0);
        Self { nodes, body, inertia: Tensor3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) }
    }

    /// Σ m v and Σ x × m v of nodes and body, the spin of the body included.
    pub fn momenta(&self, frame: &MeshFrame) -> Momenta {
        let (at, v) = (frame.bodies[0].kinematics.position, frame.bodies[0].kinematics.velocity * self.body);
        let (mut linear, mut angular) = (v, at.cross(&v) + self.spin(frame));
        let mut scale = (linear.norm(), angular.norm());
        for ((mass, x), v) in self.nodes.iter().zip(&frame.points).zip(&frame.velocities) {
            let (momentum, moment) = (v * *mass, x.cross(v) * *mass);
            linear += momentum;
            angular += moment;
            scale = (scale.0 + momentum.norm(), scale.1 + moment.norm());
        }
        Momenta { linear, angular, scale }
    }

    /// R I Rᵀ ω.
    fn spin(&self, frame: &MeshFrame) -> Vector3 {
        let turn = turn(frame);
        turn * (self.inertia * turn.inverse_transform_vector(&frame.bodies[0].kinematics.angular_velocity))
    }

    /// 1/M + (r × n)·I⁻¹(r × n), 1/kg.
    pub fn compliance(&self, frame: &MeshFrame, arm: &Vector3, normal: &Vector3) -> f64 {
        let lever = turn(frame).inverse_transform_vector(&arm.cross(normal));
        let inverse = self.inertia.try_inverse().expect("an inertia can be inverted");
        1.0 / self.body + lever.dot(&(inverse * lever))
    }

    /// Kinetic energy of nodes and body, J.
    pub fn kinetic_energy(&self, frame: &MeshFrame) -> f64 {
        let gel: f64 = self.nodes.iter().zip(&frame.velocities).map(|(mass, v)| 0.5 * mass * v.norm_squared()).sum();
        let projectile = &frame.bodies[0].kinematics;
        let turning = projectile.angular_velocity.dot(&self.spin(frame));
        gel + 0.5 * (self.body * projectile.velocity.norm_squared() + turning)
    }
}

impl Momenta {
    /// By how much they differ from those at the start, relative to the greater scale: linear and angular.
    pub fn drift(&self, start: &Self) -> (f64, f64) {
        let scale = (self.scale.0.max(start.scale.0), self.scale.1.max(start.scale.1));
        ((self.linear - start.linear).norm() / scale.0, (self.angular - start.angular).norm() / scale.1)
    }
}

fn turn(frame: &MeshFrame) -> UnitQuaternion<f64> {
    let [w, x, y, z] = frame.bodies[0].kinematics.orientation;
    UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z))
}
