//! The tables of a scene file. Field docs are the help an editor shows; units are SI.

use super::{
    BranchSpec, ConstantsSpec, Fidelity, Levels, Load, MaterialModel, Preset, Projectile, Remesh, Sensor,
    SofteningSpec, StopAfterExit, StrengthSpec, TermSpec, ViscositySpec, VolumeSpec,
};
use serde::{Deserialize, Serialize};

/// A scene: one gel, a projectile and perhaps fragments beside it, and how to compute their meeting.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Scene {
    /// Name, dimension and duration.
    pub scene: Header,
    /// The gelatin.
    pub gel: Gel,
    /// The rigid body that meets it.
    pub projectile: Projectile,
    /// Further bodies, each a `[[fragment]]` table with the keys of a projectile. Bodies do not touch each other.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fragment: Vec<Projectile>,
    /// Pressures on the surface of the gel, each a `[[load]]` table.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub load: Vec<Load>,
    /// What measures the gel, each a `[[sensor]]` table.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sensor: Vec<Sensor>,
    /// How fine the gel is divided.
    pub mesh: MeshSpec,
    /// When and how the mesh is exchanged; never without this table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remesh: Option<Remesh>,
    /// How time is stepped.
    #[serde(default)]
    pub integrator: Integrator,
    /// What happens where gel and projectile touch.
    #[serde(default)]
    pub contact: Contact,
    /// What the importer of the FMU and the FMU share.
    #[serde(default)]
    pub coupling: Coupling,
    /// What is written.
    #[serde(default)]
    pub output: Output,
    /// What the levels of `scene.fidelity` are.
    #[serde(default, skip_serializing_if = "Levels::is_empty")]
    pub fidelity: Levels,
}

/// Name, dimension and duration of a scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Header {
    /// Short name, used for the output folder: letters, digits, `-` and `_`.
    pub name: String,
    /// One line that says what the scene shows.
    #[serde(default)]
    pub title: String,
    /// The space the gel lives in.
    pub dimension: Dimension,
    /// Latest end of the run, s.
    pub end_time: f64,
    /// Time from the exit of the projectile at the back face of a block or cylinder to the end of the run, s, or "never"; from then on
    /// the gel is at rest. It goes on while another body moves in the gel.
    #[serde(default)]
    pub stop_after_exit: StopAfterExit,
    /// Step at which kinematics and impulse are exchanged, s.
    pub communication_step: f64,
    /// How accurate, and how costly: a level other than `standard` writes the values of its `fidelity` table over the scene.
    #[serde(default)]
    pub fidelity: Fidelity,
}

/// The space the gel lives in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum Dimension {
    /// Plane strain in the x–z plane.
    Planar,
    /// A body of revolution about z; x is the radius; totals are for the full revolution.
    Axisymmetric,
    /// Three dimensions.
    Spatial,
}

/// The gelatin: shape, material, supports and initial motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Gel {
    /// Shape and size; the entry surface of a block or cylinder is z = 0, the gel below.
    pub shape: GelShape,
    /// A gel known by name: what it is known by fills the keys of this table that are not set.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preset: Option<Preset>,
    /// Material model; of a preset `flowing` if it is not set.
    pub material: MaterialModel,
    /// Mass density at rest, kg/m3.
    pub density: f64,
    /// Shear modulus at rest, Pa; in the long run, of a gel with branches. That of `mooney-rivlin` and `ogden` follows from their
    /// constants.
    pub shear_modulus: f64,
    /// Bulk modulus at rest, Pa.
    pub bulk_modulus: f64,
    /// What it bears in shear before it flows (`flowing` only); without it, it never flows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strength: Option<StrengthSpec>,
    /// How gel that has flowed softens (`flowing` only); not at all if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub softening: Option<SofteningSpec>,
    /// How its pressure follows its volume (`flowing` only).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume: Option<VolumeSpec>,
    /// What spreads shocks over elements (`flowing` only); nothing if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub viscosity: Option<ViscositySpec>,
    /// C1 and C2 (`mooney-rivlin` only).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub constants: Option<ConstantsSpec>,
    /// Powers of the stretches (`ogden` only): 1 to 3.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub terms: Vec<TermSpec>,
    /// Maxwell branches, which make it stiffer the faster it is strained (`viscoelastic` only): 1 to 3.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub branches: Vec<BranchSpec>,
    /// Which faces are held; a face that is not named is free.
    #[serde(default)]
    pub supports: Supports,
    /// Which part of it is computed (a spatial block only): its mirror images move alike.
    #[serde(default, skip_serializing_if = "Symmetry::is_none")]
    pub symmetry: Symmetry,
    /// Thickness of a planar gel, m (1 if absent).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thickness: Option<f64>,
    /// Initial velocity of the whole gel, m/s.
    #[serde(default)]
    pub velocity: [f64; 3],
}

/// Shape of the gel at rest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum GelShape {
    /// A block, centred on the z axis below z = 0.
    Block {
        /// Edge lengths, m: [x, y, z] in `spatial`, [x, z] in `planar`.
        size: Vec<f64>,
    },
    /// A cylinder about the z axis below z = 0.
    Cylinder {
        /// Radius, m.
        radius: f64,
        /// Height, m.
        height: f64,
        /// Radius of a bore along the axis, m (`axisymmetric` only); none if absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        bore: Option<f64>,
    },
    /// The lower half of a hollow sphere about the origin, its flat face at z = 0 (`axisymmetric` only): with rollers at `z_max` it
    /// stands for all of it. Cells grow with the distance from the middle.
    Shell {
        /// Radius of the inner surface, m.
        inner: f64,
        /// Radius of the outer surface, m.
        outer: f64,
    },
    /// Two legs of equal length at a right angle, the outer corner pointing down, standing at `corner`.
    LBeam {
        /// Length of each leg along its outer edge, m.
        leg: f64,
        /// Thickness of each leg in its plane, m.
        thickness: f64,
        /// Width across the plane, m (`spatial` only; `planar` uses `gel.thickness`).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        width: Option<f64>,
        /// Angle of the first leg from the x axis towards z, degrees: 45 stands on its corner.
        angle: f64,
        /// Where the outer corner is, m.
        corner: [f64; 3],
    },
}

/// Which part of a gel is computed; masses, forces and energies are those of all of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum Symmetry {
    /// All of it.
    #[default]
    None,
    /// What is on the side y ≥ 0: bodies move in the plane y = 0.
    Half,
    /// What is on the sides x ≥ 0 and y ≥ 0: bodies move along z.
    Quarter,
}

impl Symmetry {
    /// Whether all of the gel is computed.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::None
    }

    /// How many parts like the one that is computed make all of the gel.
    #[must_use]
    pub fn copies(self) -> f64 {
        f64::from(1 << self.mirrored().len())
    }

    /// The axes across the planes that it is mirrored at.
    #[must_use]
    pub fn mirrored(self) -> &'static [usize] {
        match self {
            Self::None => &[],
            Self::Half => &[1],
            Self::Quarter => &[0, 1],
        }
    }
}

/// How one face of the gel is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum Support {
    /// Not held.
    #[default]
    Free,
    /// Held normal to the face, free to slide along it.
    Roller,
    /// Held in every direction.
    Fixed,
}

/// Which faces of a block or cylinder are held.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Supports {
    /// The face of least x of a block.
    pub x_min: Support,
    /// The face of greatest x of a block.
    pub x_max: Support,
    /// The face of least y of a spatial block.
    pub y_min: Support,
    /// The face of greatest y of a spatial block.
    pub y_max: Support,
    /// The bottom of a block or cylinder.
    pub z_min: Support,
    /// The entry surface of a block or cylinder, the flat face of a shell.
    pub z_max: Support,
    /// The mantle of a cylinder (`roller` in `axisymmetric` only), the outer surface of a shell (`fixed` only).
    pub side: Support,
}

/// How fine the gel is divided.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct MeshSpec {
    /// Edge of the finest cell, m, in a shell that at its inner surface; cells are made a little shorter where a whole number of them would not fit.
    pub size: f64,
    /// Which simplices fill a cell.
    #[serde(default)]
    pub lattice: Lattice,
    /// What keeps its volume: each simplex, or a patch of neighbours.
    #[serde(default)]
    pub element: ElementKind,
    /// Coarser away from the point of entry; uniform if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grading: Option<Grading>,
    /// Larger cells away from the point of entry, all of them cubes; instead of `grading`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tree: Option<Tree>,
}

/// Which simplices fill a cell of the mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum Lattice {
    /// A node in the middle of each cell: crossed triangles, or the tetrahedra of the body-centred cubic lattice.
    #[default]
    Centred,
    /// Cells cut along one diagonal: two triangles, or six Kuhn tetrahedra.
    Kuhn,
}

/// What keeps its volume in the gel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum ElementKind {
    /// Each triangle or tetrahedron: too stiff near incompressibility.
    #[default]
    Plain,
    /// Pairs of triangles, groups of four tetrahedra: free of locking.
    Patch,
}

/// A mesh that coarsens away from the point of entry (x = y = 0, z = 0), axis by axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Grading {
    /// Distance from the point of entry within which cells keep `mesh.size`, m.
    pub core: f64,
    /// Each further cell is so many times longer than the one before it; above 1.
    pub growth: f64,
    /// Longest cell edge, m.
    pub largest: f64,
}

/// A mesh of cells that double with the distance from the point of entry (x = y = 0, z = 0): a quadtree or octree in which
/// the edges of cells that touch differ by a factor of two at most.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Tree {
    /// Edge of the largest cells, in edges of the finest: 2, 4, 8 and so on.
    pub coarsest: usize,
    /// Distance from the point of entry within which cells keep `mesh.size`, m.
    pub core: f64,
    /// An edge may be longer than `mesh.size` by so much per length of distance from the core; from 1 on they double as fast as
    /// they may.
    pub slope: f64,
}

/// How time is stepped.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Integrator {
    /// Which elements step together.
    pub schedule: ScheduleKind,
    /// Fraction of the stable step that an element takes, from 1e-6 to 1; by default 0.8, in `queue` 0.4.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cfl: Option<f64>,
    /// Every node of the gel loses speed as exp(-damping t), 1/s, for answers at rest; 0 is none.
    pub damping: f64,
}

impl Default for Integrator {
    fn default() -> Self {
        Self { schedule: ScheduleKind::Bins, cfl: None, damping: 0.0 }
    }
}

impl Integrator {
    /// Fraction of the stable step that an element takes.
    ///
    /// In the queue, elements sample the velocity of their common nodes at different instants, and the integration
    /// residual swings eight times as far as in bins: on `l-beam` by 0.4 % of the energy at 0.8, by 0.1 % at 0.4.
    #[must_use]
    pub fn cfl(&self) -> f64 {
        self.cfl.unwrap_or(match self.schedule {
            ScheduleKind::Bins | ScheduleKind::Global => 0.8,
            ScheduleKind::Queue => 0.4,
        })
    }
}

/// Which elements step together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum ScheduleKind {
    /// Steps are powers of two of the tick; elements of a step fire together.
    Bins,
    /// The paper's priority queue: every element has its own step.
    Queue,
    /// One step for all: the stable one of the assembled system, what asynchrony is measured against.
    Global,
}

/// What happens where gel and projectile touch.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Contact {
    /// Impulse law.
    pub law: ContactLaw,
    /// Restitution of a surface node, 0 to 1 (`moreau` only). The gel's own rebound does not come from it.
    pub restitution: f64,
    /// Fraction of a standing penetration removed in one step of a node, 0 to 0.5 (`moreau` only).
    pub bias: f64,
    /// Coulomb's coefficient of friction between gel and projectile, 0 to 10; off by default (`moreau` only).
    pub friction: f64,
}

impl Default for Contact {
    fn default() -> Self {
        Self { law: ContactLaw::Moreau, restitution: 0.0, bias: 0.1, friction: 0.0 }
    }
}

/// Impulse law of a surface node against the projectile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum ContactLaw {
    /// Moreau's law on half-step velocities, once per node and tick.
    Moreau,
    /// The paper's literal reversal of the approaching momentum, after each element's kick.
    Reversal,
}

/// What the importer of the FMU and the FMU share.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Coupling {
    /// Who integrates the motion of the bodies; `gelfmu run` always does.
    pub mode: CouplingMode,
}

/// Who integrates the motion of the bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum CouplingMode {
    /// The kinematic inputs are the motion.
    Prescribed,
    /// The component integrates them; kinematic inputs are read only when a body is made active.
    #[default]
    Integrated,
    /// As `integrated`, but at each communication step the kinematic inputs replace the bodies' states.
    Corrected,
}

/// What is written.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Output {
    /// Number of mesh frames over the run, the first one included; without frames, 0, there are no pictures in the report.
    pub frames: usize,
    /// Whether `report.html` is written.
    pub report: bool,
    /// Width of the window over which the peak force is averaged, s; a hundredth of the end time if 0.
    pub force_window: f64,
}

impl Default for Output {
    fn default() -> Self {
        Self { frames: 41, report: true, force_window: 0.0 }
    }
}

impl Scene {
    /// Thickness that planar masses and impulses are for, m; 1 in the other dimensions.
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
