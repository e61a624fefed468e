//! Tables of a scene file. The field docs are the descriptions that an editor shows; units are SI.

use super::{FidelityKind, FidelityLevels, GelSpec, LayerSpec, LoadSpec, ProjectileSpec, RemeshSpec};
use crate::reduced::ReducedCoefficients;
use serde::{Deserialize, Serialize};

/// Scene file: one gel, a projectile, optional fragments, and the numerical settings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Scene {
    /// Name, dimension and duration of the run.
    pub scene: SceneHeader,
    /// Gelatin target.
    pub gel: GelSpec,
    /// Layers of another material in front of the gel, each a `[[layer]]` table, from the entry surface on.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub layer: Vec<LayerSpec>,
    /// Rigid body that hits the gel.
    pub projectile: ProjectileSpec,
    /// Further rigid bodies, each a `[[fragment]]` table with the keys of a projectile. Bodies do not touch each
    /// other.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fragment: Vec<ProjectileSpec>,
    /// Pressures on the surface of the gel, each a `[[load]]` table.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub load: Vec<LoadSpec>,
    /// Material points at which the gel is measured, each a `[[sensor]]` table.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sensor: Vec<SensorSpec>,
    /// Size and type of the finite elements.
    pub mesh: MeshSpec,
    /// Criteria and sizes of remeshing; without this table the first mesh is kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remesh: Option<RemeshSpec>,
    /// Time integration.
    #[serde(default)]
    pub integrator: IntegratorSpec,
    /// Contact law between gel and bodies.
    #[serde(default)]
    pub contact: ContactSpec,
    /// Division of work between the FMU and its importer.
    #[serde(default)]
    pub coupling: CouplingSpec,
    /// Result files.
    #[serde(default)]
    pub output: OutputSpec,
    /// Overrides and measured figures of each level of `scene.fidelity`.
    #[serde(default, skip_serializing_if = "FidelityLevels::is_empty")]
    pub fidelity: FidelityLevels,
    /// Coefficients of the reduced model of the level `instant`, as `python -m ballistic_gel reduce` writes them; those
    /// that are shipped for the gel if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instant: Option<ReducedCoefficients>,
}

/// Name, dimension and duration of a scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct SceneHeader {
    /// Short name, used for the output folder: letters, digits, `-` and `_`.
    pub name: String,
    /// Title: one line that says what the scene shows.
    #[serde(default)]
    pub title: String,
    /// Dimension of the gel: plane strain, body of revolution or full space.
    pub dimension: Dimension,
    /// Latest end of the run, s.
    pub end_time: f64,
    /// Time from the exit of the projectile at the back face of a block or cylinder to the end of the run, s, or
    /// "never". From that end on the gel is at rest. The run continues while another body moves in the gel, and while
    /// the cavity opens (`await_cavity`).
    #[serde(default)]
    pub stop_after_exit: StopAfterExit,
    /// Wait of the end after an exit for the cavity: it has turned once its greatest diameter has fallen by 5 %.
    /// Without it `stop_after_exit` alone counts.
    #[serde(default = "default_await_cavity")]
    pub await_cavity: bool,
    /// End of the run when the projectile rests in the gel: for 2 ms it has moved by less than 0.1 mm, and the cavity
    /// has kept its diameter.
    #[serde(default)]
    pub stop_at_rest: bool,
    /// Communication step: interval at which kinematics and impulse are exchanged, s.
    pub communication_step: f64,
    /// Accuracy level, and with it the cost: a level other than `standard` writes the values of its `fidelity` table
    /// over the scene; `instant` is a reduced model, of the shots for which it is identified.
    #[serde(default)]
    pub fidelity: FidelityKind,
}

/// Default of `scene.await_cavity`.
fn default_await_cavity() -> bool {
    true
}

/// Time that a run continues after the projectile has left the gel at its back face.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "a time of 0 or more, s, or \"never\"")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum StopAfterExit {
    /// Finite time, s.
    After(f64),
    /// No end before `scene.end_time`.
    Never(NeverKeyword),
}

/// Keyword `"never"`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum NeverKeyword {
    /// No end before `scene.end_time`.
    Never,
}

impl StopAfterExit {
    /// Time from the exit to the end of the run, s; infinite for `"never"`.
    #[must_use]
    pub fn time(self) -> f64 {
        match self {
            Self::After(time) => time,
            Self::Never(NeverKeyword::Never) => f64::INFINITY,
        }
    }
}

impl Default for StopAfterExit {
    /// Default of 2 ms, about the time in which a service bullet passes 400 mm.
    ///
    /// By then the cavity has opened along the whole path. It still widens: in `gelatin-10` that of a 9 mm bullet of
    /// 350 m/s for more than 5 ms, 68 mm at the exit and 95 mm after 2 ms. `scene.await_cavity` waits for it.
    fn default() -> Self {
        Self::After(2e-3)
    }
}

/// Dimension of the gel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum Dimension {
    /// Plane strain in the x–z plane.
    Planar,
    /// Body of revolution about z; x is the radius. Totals are those of the full revolution.
    Axisymmetric,
    /// Three dimensions.
    Spatial,
}

/// Greatest number of sensors of a scene: the number of blocks of value references.
pub const MOST_SENSORS: usize = 99;

/// Sensor at a material point of the gel: pressure, displacement and velocity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct SensorSpec {
    /// Position of the material point at rest, m; in `axisymmetric` [radius, 0, z].
    pub position: [f64; 3],
}

/// Size and type of the finite elements.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct MeshSpec {
    /// Edge of the finest cell, m; in a shell the edge at its inner surface. Cells are shortened a little where a
    /// whole number of them would not fit.
    pub size: f64,
    /// Division of a cell into simplices.
    #[serde(default)]
    pub lattice: CellLattice,
    /// Element formulation: independent linear simplices, or F-bar patches that share their change of volume.
    #[serde(default)]
    pub element: ElementKind,
    /// Axis-by-axis coarsening away from the point of entry; uniform if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grading: Option<GradingSpec>,
    /// Quadtree or octree of cubic cells that coarsens away from the point of entry; instead of `grading`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tree: Option<OctreeSpec>,
}

/// Division of a cell into simplices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum CellLattice {
    /// Centred cells with a node in the middle: crossed triangles, or the tetrahedra of the body-centred cubic
    /// lattice.
    #[default]
    Centred,
    /// Cells cut along one diagonal: two triangles, or six Kuhn tetrahedra.
    Kuhn,
}

/// Element formulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum ElementKind {
    /// Linear triangle or tetrahedron: locks (is too stiff) near incompressibility.
    #[default]
    Plain,
    /// F-bar patches of two triangles or up to four tetrahedra with a common change of volume: free of locking.
    Patch,
}

/// Mesh that coarsens away from the point of entry (x = y = 0, z = 0), axis by axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct GradingSpec {
    /// Distance from the point of entry within which cells keep `mesh.size`, m.
    pub core: f64,
    /// Ratio of the lengths of successive cells outside the core; above 1.
    pub growth: f64,
    /// Longest cell edge, m.
    pub largest: f64,
}

/// Quadtree or octree mesh whose cells double with the distance from the point of entry (x = y = 0, z = 0). The edges
/// of cells that touch differ by a factor of two at most (2:1 balance).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct OctreeSpec {
    /// Edge of the largest cells, in edges of the finest: 2, 4, 8 and so on.
    pub coarsest: usize,
    /// Distance from the point of entry within which cells keep `mesh.size`, m.
    pub core: f64,
    /// Growth of the cell edge per distance from the core; from 1 on cells double as fast as the balance allows.
    pub slope: f64,
}

/// Time integration: asynchronous variational integrator.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct IntegratorSpec {
    /// Schedule of the element steps.
    pub schedule: ScheduleKind,
    /// Fraction of its stable step that an element takes, from 1e-6 to 1; by default 0.8, in `queue` 0.4.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cfl: Option<f64>,
    /// Mass-proportional damping rate, 1/s, for static solutions: the velocity of every gel node decays as
    /// exp(-damping t). 0 is none.
    pub damping: f64,
}

impl Default for IntegratorSpec {
    fn default() -> Self {
        Self { schedule: ScheduleKind::Bins, cfl: None, damping: 0.0 }
    }
}

impl IntegratorSpec {
    /// Fraction of its stable step that an element takes.
    ///
    /// In the queue, elements sample the velocity of their common nodes at different instants. The integration
    /// residual then fluctuates eight times as much as in bins: on `l-beam` by 0.4 % of the energy at 0.8, by 0.1 %
    /// at 0.4.
    #[must_use]
    pub fn cfl(&self) -> f64 {
        self.cfl.unwrap_or(match self.schedule {
            ScheduleKind::Bins | ScheduleKind::Global => 0.8,
            ScheduleKind::Queue => 0.4,
        })
    }
}

/// Schedule of the element steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum ScheduleKind {
    /// Element steps of a power of two ticks; elements of equal step are updated together.
    Bins,
    /// Priority queue of the original paper: every element has its own step.
    Queue,
    /// One global step, the stable one of the assembled system: the reference for the gain by asynchrony.
    Global,
}

/// Contact law between gel and bodies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct ContactSpec {
    /// Impulse law.
    pub law: ContactLaw,
    /// Coefficient of restitution of a surface node, 0 to 1 (`moreau` only). The elastic rebound of the gel does not
    /// depend on it.
    pub restitution: f64,
    /// Fraction of a standing penetration removed in one step of a node, 0 to 0.5 (`moreau` only).
    pub bias: f64,
    /// Coulomb's coefficient of friction between gel and projectile, 0 to 10; off by default (`moreau` only).
    pub friction: f64,
}

impl Default for ContactSpec {
    fn default() -> Self {
        Self { law: ContactLaw::Moreau, restitution: 0.0, bias: 0.1, friction: 0.0 }
    }
}

/// Impulse law of a surface node against a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum ContactLaw {
    /// Moreau's impact law on half-step velocities, once per node and tick.
    Moreau,
    /// Reversal of the approaching momentum after each element's kick, as in the original paper.
    Reversal,
}

/// Division of work between the FMU and its importer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct CouplingSpec {
    /// Integrator of the motion of the bodies; `gelfmu run` always integrates the motion itself.
    pub mode: CouplingMode,
}

/// Integrator of the motion of the bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum CouplingMode {
    /// The kinematic inputs are the motion.
    Prescribed,
    /// The component integrates the motion; kinematic inputs are read only when a body is made active.
    #[default]
    Integrated,
    /// The component integrates the motion, but at each communication step the kinematic inputs replace the bodies'
    /// states.
    Corrected,
}

/// Result files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct OutputSpec {
    /// Number of mesh frames over the run, the first one included; with 0 there are no pictures in the report.
    pub frames: usize,
    /// True to write `report.html`.
    pub report: bool,
    /// Width of the window over which the peak force is averaged, s; with 0 a hundredth of the end time.
    pub force_window: f64,
    /// Fields to write with each frame, as values of its elements and of its nodes; without frames there are none.
    pub fields: Vec<OutputField>,
}

impl Default for OutputSpec {
    fn default() -> Self {
        Self { frames: 41, report: true, force_window: 0.0, fields: vec![] }
    }
}

/// Field of the gel in the frames of a run. Stresses are without bulk viscosity, which only spreads shocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum OutputField {
    /// Pressure, the mean of the Cauchy stress with its sign changed, Pa: positive in compression.
    Pressure,
    /// Von Mises equivalent of the Cauchy stress, Pa.
    VonMises,
    /// Equivalent rate of deformation sqrt(2/3 d':d') in the present shape, d' the deviator of the rate, 1/s.
    StrainRate,
    /// Equivalent viscous strain sqrt(2/3 e:e), e the logarithmic strain of the dashpots; the mean over the branches by
    /// shear modulus.
    ViscousStrain,
    /// Damage of the elastic network, 0 to 1.
    Damage,
    /// Number of the layer, 0 at the entry surface, the gel last; of an element of several the mean by mass.
    Layer,
}

impl OutputField {
    /// All fields.
    pub const ALL: [Self; 6] =
        [Self::Pressure, Self::VonMises, Self::StrainRate, Self::ViscousStrain, Self::Damage, Self::Layer];

    /// Name of the field in a scene and in the files of frames.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Pressure => "pressure",
            Self::VonMises => "von_mises",
            Self::StrainRate => "strain_rate",
            Self::ViscousStrain => "viscous_strain",
            Self::Damage => "damage",
            Self::Layer => "layer",
        }
    }

    /// Title in the report.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Pressure => "Pressure",
            Self::VonMises => "Von Mises stress",
            Self::StrainRate => "Strain rate",
            Self::ViscousStrain => "Viscous strain",
            Self::Damage => "Damage",
            Self::Layer => "Layer",
        }
    }

    /// Unit; "-" for a number without one.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Pressure | Self::VonMises => "Pa",
            Self::StrainRate => "1/s",
            Self::ViscousStrain | Self::Damage | Self::Layer => "-",
        }
    }
}

impl Scene {
    /// Thickness to which planar masses and impulses refer, m; 1 in the other dimensions.
    #[must_use]
    pub fn thickness(&self) -> f64 {
        self.gel.thickness.unwrap_or(1.0)
    }

    /// Width of the window over which the peak force is averaged, s.
    #[must_use]
    pub fn force_window(&self) -> f64 {
        if self.output.force_window > 0.0 { self.output.force_window } else { self.scene.end_time / 100.0 }
    }
}
