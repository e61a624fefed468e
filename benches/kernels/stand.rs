//! Elements on a stand: the engine's own layout and kernels, without its steps.

use ballistic_gel::constitutive::{
    Branch, BulkViscosity, Dashpot, EquationOfState, Material, NeoHookean, StretchDamage, TwoNetwork,
};
use ballistic_gel::contact::{BodyState, ContactSurface, FreeDirections, ImpulseLaw, RigidBody};
use ballistic_gel::fem::{
    DEPTH, ElementBatches, ElementResponse, GroupKick, GroupKicks, GroupResponse, HistoryLanes, HistoryVariables,
    LANES, NodeAccumulator, NodeCache, NodeMotion, NodeSource, Potential, ReportPower, Section, Simplices,
};
use ballistic_gel::geometry::{ShapeGeometry, Sphere};
use ballistic_gel::integrator::{DiscreteGel, Engine, IntegratorSettings, SteppingSchedule};
use ballistic_gel::math::{Vector, Vector3};
use ballistic_gel::mesh::{self, BlockSpec, CellSplit, ElementPatches, Mesh, NodeId};
use fearless_simd::Level;
use std::ops::Range;

/// Length of a kick, s: any will do.
const KICK: GroupKick = GroupKick { length: 1e-6, elapsed: 1e-6 };

/// Element kernel: kinematics, F-bar patches or none, and constitutive law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kernel {
    /// Plane, revolution or space.
    pub section: Section,
    /// Pairs of triangles or groups of four tetrahedra, or each by itself.
    pub patched: bool,
    /// True for a two-network gel whose branch flows at every update, false for an elastic one.
    pub flows: bool,
}

/// Kernels by the name of their elements.
pub const KERNELS: [(&str, Kernel); 12] = [
    ("tetrahedra", Kernel { section: Section::Spatial, patched: false, flows: false }),
    ("tetrahedra", Kernel { section: Section::Spatial, patched: true, flows: false }),
    ("triangles, planar", Kernel { section: Section::Planar { thickness: 1.0 }, patched: false, flows: false }),
    ("triangles, planar", Kernel { section: Section::Planar { thickness: 1.0 }, patched: true, flows: false }),
    ("triangles, axisymmetric", Kernel { section: Section::Axisymmetric, patched: false, flows: false }),
    ("triangles, axisymmetric", Kernel { section: Section::Axisymmetric, patched: true, flows: false }),
    ("two-network tetrahedra", Kernel { section: Section::Spatial, patched: false, flows: true }),
    ("two-network tetrahedra", Kernel { section: Section::Spatial, patched: true, flows: true }),
    (
        "two-network triangles, planar",
        Kernel { section: Section::Planar { thickness: 1.0 }, patched: false, flows: true },
    ),
    (
        "two-network triangles, planar",
        Kernel { section: Section::Planar { thickness: 1.0 }, patched: true, flows: true },
    ),
    ("two-network triangles, axisymmetric", Kernel { section: Section::Axisymmetric, patched: false, flows: true }),
    ("two-network triangles, axisymmetric", Kernel { section: Section::Axisymmetric, patched: true, flows: true }),
];

/// Test stand of one kernel: elements, positions of their nodes, and buffers for their response.
pub struct Stand<const D: usize> {
    engine: Engine<D, Simplices<D>>,
    runs: Vec<StandBlock>,
    local: NodeCache,
    stiffness: Vec<f64>,
    answers: Vec<GroupResponse>,
    /// History variables in batches, and element by element.
    memory: Vec<HistoryLanes>,
    remembered: Vec<HistoryVariables<D>>,
}

/// Block of the engine with its contributions to its nodes.
struct StandBlock {
    nodes: Vec<NodeId>,
    groups: Range<usize>,
    n_elements: usize,
    part: Vec<NodeAccumulator>,
}

/// The instruction sets of this machine, the widest first.
pub fn levels() -> Vec<(&'static str, Level)> {
    let widest = Level::new();
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    let wide = [
        widest.as_avx512().map(|simd| ("AVX-512", Level::Avx512(simd))),
        widest.as_avx2().map(|simd| ("AVX2", Level::Avx2(simd))),
    ];
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    let wide = [("widest", widest)].map(Some);
    wide.into_iter().flatten().chain([("baseline", Level::baseline())]).collect()
}

/// The block of `sphere-block` with about so many tetrahedra.
pub fn block(n_elements: usize) -> Mesh<3> {
    let size = cell_of_block(n_elements);
    let planes = [mesh::uniform(-0.05, 0.05, size), mesh::uniform(-0.05, 0.05, size), mesh::uniform(-0.05, 0.0, size)];
    mesh::block(BlockSpec { planes, split: CellSplit::Centred, faces: vec![] })
}

/// Cells of that block, m: at 5 mm it has 51 200 tetrahedra.
fn cell_of_block(n_elements: usize) -> f64 {
    5e-3 * (51_200.0 / n_elements as f64).cbrt()
}

/// A section of it with about so many triangles, four to a cell.
pub fn section(n_elements: usize) -> Mesh<2> {
    let (width, height) = (0.05, 0.05);
    let size = (4.0 * width * height / n_elements as f64).sqrt();
    let planes = [mesh::uniform(0.0, width, size), mesh::uniform(-height, 0.0, size)];
    mesh::block(BlockSpec { planes, split: CellSplit::Centred, faces: vec![] })
}

impl<const D: usize> Stand<D> {
    /// The elements of a mesh, strained by some per cent.
    pub fn new(mesh: &Mesh<D>, kernel: Kernel) -> Self {
        let engine = engine(mesh, kernel);
        let own = |run: ballistic_gel::integrator::BlockLayout<'_>| StandBlock {
            nodes: run.nodes.to_vec(),
            groups: run.groups,
            n_elements: run.n_elements,
            part: vec![[0.0; 4]; run.nodes.len()],
        };
        let runs: Vec<StandBlock> = engine.block_layouts().into_iter().map(own).collect();
        let n_groups = runs.last().map_or(0, |run| run.groups.end);
        let (stiffness, answers) =
            (vec![0.0; engine.state().stiffness.len()], vec![GroupResponse::default(); n_groups]);
        let (memory, remembered) = (lanes(&engine).memory(), engine.state().memory.clone());
        Self { engine, runs, local: NodeCache::new(0.0), stiffness, answers, memory, remembered }
    }

    /// Elements in all.
    pub fn n_elements(&self) -> usize {
        self.engine.gel().potential.len()
    }

    /// Some run away from the surface; its elements.
    pub fn some_run(&self) -> (usize, usize) {
        let run = self.runs.len() / 2;
        (run, self.runs[run].n_elements)
    }

    /// Puts the nodes of a run where the kernel finds them.
    pub fn load(&mut self, run: usize) {
        let (state, rest) = (self.engine.state(), self.engine.gel().potential.rest());
        self.local.begin();
        let nodes = Nodes { position: &state.position, velocity: &state.velocity, rest };
        self.local.load(Level::new(), &nodes, self.runs[run].nodes.iter().copied().enumerate());
    }

    /// The kernel over one run.
    pub fn sweep(&mut self, level: Level, run: usize) {
        let (lanes, groups) = (lanes(&self.engine), self.runs[run].groups.clone());
        let width = LANES * lanes.depth();
        let slots = groups.start * width..groups.end * width;
        let rows = lanes.depth() * lanes.rows();
        let memory = &mut self.memory[groups.start * rows..groups.end * rows];
        let found = (&mut self.stiffness[slots], &mut self.answers[groups.clone()], memory);
        lanes.sweep(level, (groups, GroupKicks::Same(KICK), ReportPower::Untold), &mut self.local, found);
    }

    /// The element phase: every run loaded, swept, and what it gives kept.
    pub fn sweep_all(&mut self, level: Level) {
        for run in 0..self.runs.len() {
            self.load(run);
            self.sweep(level, run);
            let StandBlock { nodes, part, .. } = &mut self.runs[run];
            part.copy_from_slice(self.local.accumulated(nodes.len()));
        }
    }

    /// The reference form over some patches: one element after the other.
    pub fn evaluate(&mut self, patches: Range<usize>) -> f64 {
        let (potential, x) = (&self.engine.gel().potential, &self.engine.state().position);
        let mut answers = [ElementResponse::default(); DEPTH];
        let mut advance = |patch| potential.advance(patch, x, KICK, &mut self.remembered, &mut answers).energy;
        patches.map(&mut advance).sum()
    }

    /// Patches in all.
    pub fn n_patches(&self) -> usize {
        self.engine.gel().potential.patches().len()
    }

    /// Elements that remember nothing yet.
    pub fn forget(&mut self) {
        self.memory = lanes(&self.engine).memory();
        self.remembered.clone_from(&self.engine.state().memory);
    }

    /// Σ energies that the last sweep found, J.
    pub fn energy(&self) -> f64 {
        self.answers.iter().map(|answer| answer.energy).sum()
    }
}

/// Nodes as a state has them.
#[derive(Clone, Copy)]
struct Nodes<'a, const D: usize> {
    position: &'a [Vector<D>],
    velocity: &'a [Vector<D>],
    rest: &'a [Vector<D>],
}

impl<const D: usize> NodeSource<D> for Nodes<'_, D> {
    #[inline]
    fn of(&self, node: NodeId) -> NodeMotion<'_, D> {
        let a = node.index();
        NodeMotion { position: &self.position[a], velocity: &self.velocity[a], rest: &self.rest[a], passed: 0.0 }
    }
}

fn lanes<const D: usize>(engine: &Engine<D, Simplices<D>>) -> &ElementBatches<D> {
    engine.lanes().expect("simplices in bins have lanes")
}

fn engine<const D: usize>(mesh: &Mesh<D>, kernel: Kernel) -> Engine<D, Simplices<D>> {
    let n = mesh.elements.len();
    let patches = if kernel.patched { ElementPatches::grouped(mesh) } else { ElementPatches::alone(n) };
    let simplices = Simplices::in_patches(mesh, patches, (material(kernel), kernel.section));
    let mass = simplices.lumped_masses(mesh, 1030.0);
    let surface = ContactSurface::new::<D>(mesh.rest.len(), mesh.facets.clone(), |_| (1.0, 1.0));
    let law = ImpulseLaw::Moreau { restitution: 0.0, bias: 0.0, friction: 0.0 };
    let rules = IntegratorSettings { schedule: SteppingSchedule::Bins, cfl: 0.8, law, force_window: 1.0, damping: 0.0 };
    let shear = |x: &Vector<D>| Vector::<D>::from_fn(|i, _| 0.02 * x[(i + 1) % D]);
    let nodes = mesh.rest.iter().map(|x| (x + shear(x), shear(x))).collect();
    Engine::new(DiscreteGel::new(simplices, mass, &mesh.held, surface), vec![nobody()], rules, nodes)
}

/// Constitutive law of a kernel. The branch of the two-network gel relaxes so slowly that it flows at each of any number
/// of updates; its damage is checked, and not reached.
fn material(kernel: Kernel) -> Material {
    let (shear_modulus, bulk_modulus) = (68_966.0, 666_667.0);
    if !kernel.flows {
        return NeoHookean::new(shear_modulus, bulk_modulus).into();
    }
    let branch = Branch::new(0.5 * shear_modulus, Dashpot::power_law(190.0, 0.8));
    let state = EquationOfState::new(bulk_modulus, 0.0, 2e6);
    TwoNetwork::new(0.5 * shear_modulus, &[branch], state, 1030.0)
        .with_damage(StretchDamage::new(3.0, 1e-5))
        .with_viscosity(BulkViscosity { linear: 0.06, quadratic: 0.0 })
        .into()
}

/// A body that is not there.
fn nobody() -> (RigidBody, BodyState) {
    let state = BodyState { active: false, ..BodyState::at_start(Vector3::zeros(), Vector3::zeros()) };
    (RigidBody::fixed(ShapeGeometry::Sphere(Sphere { radius: 1.0 }), FreeDirections::SPATIAL), state)
}
