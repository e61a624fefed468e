//! Reports of a simulation: read-only, at positions drifted to the report time.

use super::kinematics::BodyKinematics;
use crate::adapt::RemeshTrial;
use crate::contact::{ImpulseExchange, ShapeMotion};
use crate::integrator::{BlockMotion, fixed};
use crate::math::Vector3;

/// Complete report of one instant, for importers, tables and pages.
#[derive(Debug, Clone, PartialEq)]
pub struct Observation {
    /// Time since the start of the simulation, s.
    pub time: f64,
    /// Projectile, then the fragments.
    pub bodies: Vec<BodyReport>,
    /// Sensors.
    pub sensors: Vec<SensorReport>,
    /// Energy by account.
    pub energy: EnergyReport,
    /// Linear momentum that no account explains, N·s (world; zero in directions the dimension does not conserve).
    pub momentum_imbalance: Vector3,
    /// Angular momentum about the origin that no account explains, N·m·s.
    pub angular_momentum_imbalance: Vector3,
    /// Ratio |momentum closure| / momentum throughput.
    pub momentum_error: f64,
    /// Ratio |angular momentum closure| / angular momentum throughput, the latter at least 2.2e-4 μ V t.
    pub angular_momentum_error: f64,
    /// Cost of the run.
    pub cost: CostReport,
    /// Rigid motion of the block: depths are measured against it.
    pub block: BlockMotion,
    /// True if the run is over: the projectile has left the gel, and no other body moves in it, or it rests
    /// ([`Simulation::is_over`](super::Simulation::is_over)).
    pub is_over: bool,
}

/// Energy and momentum balance of one instant; the fields are those of [`Observation`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BalanceReport {
    /// Energy by account.
    pub energy: EnergyReport,
    /// Linear momentum that no account explains, N·s.
    pub momentum_imbalance: Vector3,
    /// Angular momentum about the origin that no account explains, N·m·s.
    pub angular_momentum_imbalance: Vector3,
    /// Ratio |momentum closure| / momentum throughput.
    pub momentum_error: f64,
    /// Ratio |angular momentum closure| / angular momentum throughput, the latter at least 2.2e-4 μ V t.
    pub angular_momentum_error: f64,
}

/// Motion of a body and its interaction with the gel.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyReport {
    /// Position and motion.
    pub kinematics: BodyKinematics,
    /// True if the body takes part.
    pub active: bool,
    /// Shape of a dome or an expanding body.
    pub shape_motion: Option<ShapeMotion>,
    /// Depth of the body's foremost point below the undeformed entry surface, which moves with the block, m (negative
    /// above).
    pub depth: f64,
    /// Contact exchange over the last communication step.
    pub exchange: ImpulseExchange,
    /// Contact since the start.
    pub contact: ContactReport,
    /// Exit at the back face of the gel, if the body has perforated the gel.
    pub exit: Option<ExitReport>,
    /// Energy given to the gel, J, up to the exit if there is one, in the inertial frame in which the gel was at rest
    /// at the start.
    pub energy_deposited: f64,
}

/// Exit of a body: its rear end has passed the undisturbed back face of the gel, which moves with the block. Velocity
/// and energy are those in the inertial frame in which the gel was at rest at the start, as a chronograph measures
/// them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ExitReport {
    /// Time, s.
    pub time: f64,
    /// Velocity at the exit, m/s.
    pub velocity: Vector3,
    /// Kinetic energy at the exit, J.
    pub residual_energy: f64,
}

impl Observation {
    /// Energy and momentum balance.
    #[must_use]
    pub fn books(&self) -> BalanceReport {
        BalanceReport {
            energy: self.energy,
            momentum_imbalance: self.momentum_imbalance,
            angular_momentum_imbalance: self.angular_momentum_imbalance,
            momentum_error: self.momentum_error,
            angular_momentum_error: self.angular_momentum_error,
        }
    }

    /// Report of the projectile.
    #[must_use]
    pub fn projectile(&self) -> &BodyReport {
        &self.bodies[0]
    }
}

/// Measurements of a sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorReport {
    /// Current position of the material point, m.
    pub position: Vector3,
    /// Displacement of the material point from rest, m.
    pub displacement: Vector3,
    /// Velocity of the material point, m/s.
    pub velocity: Vector3,
    /// Pressure p = −tr σ/3, Pa.
    pub pressure: f64,
}

/// Contact between gel and a body.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ContactReport {
    /// Impulse on the body since the start, N·s.
    pub total_impulse: Vector3,
    /// True if an impulse acted in the last communication step.
    pub active: bool,
    /// Area of the surface nodes within reach of the body, m².
    pub area: f64,
    /// Deepest penetration of a surface node, m.
    pub penetration: f64,
    /// Contact stiffness k ≈ 2 E* a of a flat punch of the contact area, N/m.
    pub stiffness: f64,
    /// Acoustic impedance Z = ρ c A, N·s/m.
    pub impedance: f64,
    /// Direction of the last impulse on the body; zero before the first.
    pub direction: Vector3,
    /// Time of the first impulse, s.
    pub first: Option<f64>,
    /// Time of the last impulse, s.
    pub last: Option<f64>,
    /// Greatest mean force over a window of `output.force_window`, N.
    pub peak_force: f64,
    /// Greatest depth at an impulse or a report, m, and its time, s.
    pub peak_depth: (f64, f64),
    /// Mean |g| of touching nodes over the run, in element sizes.
    pub mean_standing_penetration: f64,
    /// Greatest |g| of a touching node over the run, in element sizes.
    pub deepest_penetration: f64,
    /// Recommended length of the next communication step, s.
    pub step_advice: f64,
    /// Communication step below which mean forces chatter, s.
    pub step_min: f64,
}

/// Energy by named, signed account, J (method A6).
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct EnergyReport {
    /// Kinetic energy of gel and bodies, half-step velocities.
    pub kinetic: f64,
    /// Kinetic energy of projectile and fragments alone.
    pub projectile: f64,
    /// Stored energy of the gel, each element at its own last tick.
    pub elastic: f64,
    /// Work of the contact law: negative is dissipated.
    pub contact: f64,
    /// Work of the contact of the gel with itself: negative is dissipated.
    pub self_contact: f64,
    /// Work of friction: negative is dissipated.
    pub friction: f64,
    /// Work of the removal of standing penetration.
    pub contact_bias: f64,
    /// Trapezoidal residual of the time integration.
    pub integration: f64,
    /// Work of external force and torque, and of a prescribed motion.
    pub external: f64,
    /// Work of the surface of an expanding body against the gel, and change of its energy of rotation by its inertia.
    pub expansion: f64,
    /// Jumps of the bodies' states made by the importer.
    pub importer: f64,
    /// Change of kinetic and stored energy by new meshes.
    pub remesh: f64,
    /// Change by the correction after each new mesh, which returns that to the motion of the new elements: of the other sign.
    pub remesh_returned: f64,
    /// Work of the pressure loads.
    pub load: f64,
    /// Work of the air in the cavity.
    pub air: f64,
    /// Work of the damping: negative is dissipated.
    pub damping: f64,
    /// Dissipation by bulk viscosity: negative.
    pub bulk_viscous: f64,
    /// Dissipation by the dashpots of the viscous branches: negative.
    pub viscous: f64,
    /// Energy of eroded gel: negative if it has left with energy.
    pub eroded: f64,
    /// Stored energy lost to softening: negative.
    pub damage: f64,
    /// Change of the discrete energy that no account explains.
    pub imbalance: f64,
    /// Energy at the start.
    pub initial: f64,
    /// Ratio |closure| / throughput.
    pub energy_error: f64,
    /// Ratio (|integration| + |contact bias| + |importer| + |remesh + remesh returned|) / (energy at the start + |external| +
    /// |load| + |air| + |expansion|), in the inertial frame in which the gel was at rest at the start.
    pub energy_defect: f64,
    /// Energy provided in that frame: at the start and by the work done since, J.
    #[serde(skip)]
    pub provided: f64,
}

impl EnergyReport {
    /// Fraction of the energy that integration, bias and remeshing may change before a run is doubted.
    const TOLERATED_FRACTION: f64 = 0.05;

    /// Energy that remeshing has left changed, J: what it took, and what was returned.
    #[must_use]
    pub fn remesh_net(&self) -> f64 {
        self.remesh + self.remesh_returned
    }

    /// Reason to doubt the run: the numerical method has changed the energy by more than a twentieth of the energy
    /// provided. `None` if it has not.
    #[must_use]
    pub fn doubt(&self) -> Option<String> {
        let accounts =
            [("integration", self.integration), ("contact_bias", self.contact_bias), ("net remesh", self.remesh_net())];
        let provided = self.provided;
        let part = accounts.iter().map(|(_, value)| value.abs()).sum::<f64>() / provided;
        let is_doubtful = self.energy_defect > Self::TOLERATED_FRACTION && part > Self::TOLERATED_FRACTION;
        let sign = |value: f64| if value < 0.0 { "" } else { "+" };
        let changes = accounts
            .map(|(name, value)| format!("{name} {}{} %", sign(value), fixed(100.0 * value / provided, 1)))
            .join(", ");
        is_doubtful.then(|| {
            format!(
                "the numerical method has changed the energy by {} % of the energy provided ({changes}): figures of \
                 this run may be wrong by as much",
                fixed(100.0 * part, 0)
            )
        })
    }
}

/// Cost of a run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CostReport {
    /// Element updates since the start.
    pub element_updates: f64,
    /// Updates that one global stable step of the assembled system would have cost so far.
    pub synchronous_updates: f64,
    /// Smallest element step now, s.
    pub smallest_step: f64,
    /// Largest element step now, s.
    pub largest_step: f64,
    /// Elements.
    pub elements: usize,
    /// Nodes.
    pub nodes: usize,
    /// Smallest J = det F since the start.
    pub min_jacobian: f64,
    /// Elements whose J is now below the start of the continuation.
    pub crushed_elements: usize,
    /// Remeshings since the start.
    pub remeshes: u64,
    /// Ticks at which the sweeps of the contact solver ended by their number, not by their residual.
    pub unconverged_solves: u64,
    /// Mass of eroded gel, kg.
    pub eroded_mass: f64,
    /// Fraction of the elements whose rest shape is not that of their nodes' rest positions.
    pub incompatible_fraction: f64,
}

/// Mesh at one instant, in the world frame, for files and pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshFrame {
    /// Time, s.
    pub time: f64,
    /// Dimension of the gel: 2 or 3.
    pub dimension: usize,
    /// Mass of the gel, kg.
    pub mass: f64,
    /// Nodal positions, m; y = 0 in two dimensions.
    pub points: Vec<Vector3>,
    /// Nodal velocities, m/s.
    pub velocities: Vec<Vector3>,
    /// Nodal displacements, m.
    pub displacements: Vec<Vector3>,
    /// Elements.
    pub cells: FrameCells,
    /// Fields of `output.fields`, in the order of the scene.
    pub fields: Vec<FrameField>,
    /// Projectile, then the fragments.
    pub bodies: Vec<BodyPose>,
    /// Rigid motion of the block at `time`.
    pub block: BlockMotion,
    /// Displacement of the block at the time of the points, m: in a gel at rest that of its last tick.
    pub gel_displacement: Vector3,
}

impl MeshFrame {
    /// Returns the corners of the boundary facets as they are seen from the block, outward oriented; in two dimensions
    /// the third one has no meaning.
    pub fn facet_corners(&self) -> impl Iterator<Item = [Vector3; 3]> + '_ {
        let corner = |node: u32| self.points[node as usize] - self.gel_displacement;
        self.cells.facets.iter().map(move |nodes| nodes.map(corner))
    }
}

/// Field of the gel in a [`MeshFrame`], by element and by node.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameField {
    /// Name, a key word of `output.fields`.
    pub name: &'static str,
    /// Unit; "-" for a number without one.
    pub unit: &'static str,
    /// Values of the elements.
    pub cells: Vec<f64>,
    /// Values of the nodes: the mean of the elements around a node by rest volume, like the pressure of a sensor.
    pub points: Vec<f64>,
}

impl BodyReport {
    /// Returns the opening of an expanding body, from 0, unopened, to 1, opened; 0 for any other body.
    #[must_use]
    pub fn expansion(&self) -> f64 {
        ShapeMotion::opening_of(self.shape_motion.as_ref())
    }
}

/// Position and motion of a body in a [`MeshFrame`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyPose {
    /// Position and motion.
    pub kinematics: BodyKinematics,
    /// Shape of a dome or an expanding body.
    pub shape_motion: Option<ShapeMotion>,
    /// True if the body takes part.
    pub active: bool,
}

/// Elements of a [`MeshFrame`], one entry each.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameCells {
    /// Node indices, `dimension + 1` used.
    pub nodes: Vec<[u32; 4]>,
    /// Step, s.
    pub step: Vec<f64>,
    /// Volume ratio J = det F.
    pub jacobian: Vec<f64>,
    /// Stored energy density, J/m³ of rest volume.
    pub energy_density: Vec<f64>,
    /// Damage, 0 to 1; 0 in a gel without damage.
    pub damage: Vec<f64>,
    /// Boundary facets by node index, `dimension` used, outward oriented.
    pub facets: Vec<[u32; 3]>,
}

/// Mesh that is about to be replaced, and its replacement by each method.
#[derive(Debug, Clone, PartialEq)]
pub struct RemeshPreview {
    /// Mesh to be replaced.
    pub frame: MeshFrame,
    /// Remeshing with all its steps.
    pub trial: RemeshTrial,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_run_whose_method_changes_the_energy_is_doubted() {
        let report = |remesh: f64, importer: f64, initial: f64| {
            let energy_defect = (0.01 + remesh.abs() + importer.abs()) / if initial > 1e-12 { initial } else { 1.0 };
            let provided = initial + importer.abs();
            EnergyReport {
                remesh,
                importer,
                initial,
                integration: -0.01,
                energy_defect,
                provided,
                ..EnergyReport::default()
            }
        };
        let doubt = report(-0.5, 0.0, 2.0).doubt().expect("a quarter of it is gone");
        assert!(
            doubt.contains("by 26 %") && doubt.contains("integration -0.5 %") && doubt.contains("remesh -25.0 %"),
            "{doubt}"
        );
        // Energy from the importer is no error of the method; without energy there is no ratio.
        for sound in [report(0.08, 0.0, 2.0), report(0.0, 1.0, 2.0), report(0.0, 1.0, 0.0), report(0.001, 0.0, 1e-13)] {
            assert_eq!(sound.doubt(), None, "{sound:?}");
        }
    }
}
