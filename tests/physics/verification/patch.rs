//! Patch tests: an affine deformation of any mesh gives one F, one stress, and no force on inner nodes; asynchronous steps
//! leave inner nodes where they are.

use super::noise::Noise;
use super::row::{Row, below, order, series};
use ballistic_gel::constitutive::{Hyperelastic, NeoHookean, VolumetricEnergy};
use ballistic_gel::contact::{BodyState, ContactSurface, FreeDirections, ImpulseExchange, ImpulseLaw, RigidBody};
use ballistic_gel::fem::{DEPTH, ElementResponse, Potential, Section, Simplices};
use ballistic_gel::geometry::{ShapeGeometry, Sphere};
use ballistic_gel::integrator::{DiscreteGel, Engine, IntegratorSettings, SteppingSchedule};
use ballistic_gel::math::{Tensor, Vector, det};
use ballistic_gel::mesh::{self, BlockSpec, CellSplit, Mesh, NodeId, NodeIncidence, OctreeGrading, edges};
use std::sync::OnceLock;

/// The gel of this part: E = 1, ν = 0.45.
fn gel() -> NeoHookean {
    NeoHookean::new(1.0 / 2.9, 1.0 / 0.3)
}

fn uniform_planes() -> Vec<f64> {
    mesh::uniform(-0.5, 0.5, 0.25)
}

fn graded_planes() -> Vec<f64> {
    mesh::graded(1.0, 0.04, (0.1, 1.6, 0.3))
}

fn blocks<const D: usize>(split: CellSplit) -> [Mesh<D>; 2] {
    [uniform_planes(), graded_planes()]
        .map(|planes| mesh::block(BlockSpec { planes: std::array::from_fn(|_| planes.clone()), split, faces: vec![] }))
}

fn beam<const D: usize>(split: CellSplit) -> Mesh<D> {
    let legs = BlockSpec { planes: std::array::from_fn(|_| mesh::uniform(0.0, 1.0, 0.25)), split, faces: vec![] };
    mesh::l_beam(legs, 0.25, (45.0, Vector::<D>::zeros()))
}

fn all<const D: usize>() -> Vec<Mesh<D>> {
    let each = |split| blocks::<D>(split).into_iter().chain([beam::<D>(split)]);
    [CellSplit::Centred, CellSplit::Kuhn].into_iter().flat_map(each).chain([grown()]).collect()
}

/// A block whose cells double twice away from its middle.
fn grown<const D: usize>() -> Mesh<D> {
    let split = CellSplit::Tree(OctreeGrading { coarsest: 4, core: 0.0, slope: 1e9 });
    mesh::block(BlockSpec { planes: std::array::from_fn(|_| mesh::uniform(-1.0, 1.0, 0.125)), split, faces: vec![] })
}

fn cylinders() -> impl Iterator<Item = Mesh<3>> {
    let square = |split| BlockSpec { planes: std::array::from_fn(|_| uniform_planes()), split, faces: vec![] };
    let tree = CellSplit::Tree(OctreeGrading { coarsest: 2, core: 0.0, slope: 1.0 });
    [CellSplit::Centred, CellSplit::Kuhn, tree].into_iter().map(move |split| mesh::cylinder(0.5, square(split)))
}

/// x = A X + b with a random A near a rotation-free stretch, det A > 0.3.
fn affine<const D: usize>(noise: &mut Noise) -> (Tensor<D>, Vector<D>) {
    loop {
        let a = Tensor::<D>::identity() + Tensor::<D>::from_fn(|_, _| 0.5 * noise.next());
        if det(&a) > 0.3 {
            return (a, Vector::<D>::from_fn(|_, _| noise.next()));
        }
    }
}

/// Which nodes are inside.
fn inner<const D: usize>(mesh: &Mesh<D>) -> Vec<bool> {
    let mut inner = vec![true; mesh.rest.len()];
    for node in mesh.facets.iter().flat_map(|facet| &facet[..D]) {
        inner[node.index()] = false;
    }
    inner
}

/// Greatest |F − A|/|A|, and greatest force on an inner node over |P| h², of one mesh under one deformation; h is the longest
/// edge at the node, h² is h times the thickness in the plane.
fn defects<const D: usize>(mesh: &Mesh<D>, section: Section, (a, b): (Tensor<D>, Vector<D>)) -> (f64, f64) {
    let x: Vec<Vector<D>> = mesh.rest.iter().map(|rest| a * rest + b).collect();
    let simplices = Simplices::new(mesh, gel(), section);
    let mut force = vec![Vector::<D>::zeros(); x.len()];
    let mut scale = vec![0.0_f64; x.len()];
    let mut strain: f64 = 0.0;
    for (e, nodes) in mesh.elements.iter().enumerate() {
        let f = edges(&x, nodes) * edges(&mesh.rest, nodes).try_inverse().expect("an element has a volume");
        strain = strain.max((f - a).norm() / a.norm());
        let mut answers = [ElementResponse::default(); DEPTH];
        simplices.evaluate(e, &x, &[], &mut answers);
        let h = edges(&mesh.rest, nodes).column_iter().map(|edge| edge.norm()).fold(0.0, f64::max);
        let face = if D == 2 { h } else { h * h };
        for (node, push) in nodes[..=D].iter().zip(&answers[0].forces) {
            force[node.index()] += push;
            scale[node.index()] = scale[node.index()].max(stress(&a) * face);
        }
    }
    let inside = inner(mesh);
    let worst = (0..x.len()).filter(|i| inside[*i]).map(|i| force[i].norm() / scale[i]).fold(0.0, f64::max);
    (strain, worst)
}

/// |P| of the gel at F.
fn stress<const D: usize>(f: &Tensor<D>) -> f64 {
    let u = gel().volume().volumetric(det(f));
    (f * gel().shear_modulus() + ballistic_gel::math::cofactor(f) * u.slope).norm()
}

fn static_defects<const D: usize>(meshes: &[Mesh<D>], section: Section) -> (f64, f64) {
    let mut noise = Noise::new(1);
    let each = meshes.iter().flat_map(|mesh| (0..5).map(move |_| mesh));
    each.map(|mesh| defects(mesh, section, affine(&mut noise))).fold((0.0, 0.0), |(f, p), (g, q)| (f.max(g), p.max(q)))
}

/// A sphere that is far away.
pub fn nowhere(freedom: FreeDirections) -> (RigidBody, BodyState) {
    let body = RigidBody::fixed(ShapeGeometry::Sphere(Sphere { radius: 1.0 }), freedom);
    (body, super::bar::below_z(-1e6, 0.0))
}

/// Moreau's law in powers of two at CFL 0.8.
pub fn rules() -> IntegratorSettings {
    IntegratorSettings {
        schedule: SteppingSchedule::Bins,
        cfl: 0.8,
        law: ImpulseLaw::Moreau { restitution: 0.0, bias: 0.1, friction: 0.0 },
        force_window: 1.0,
        damping: 0.0,
    }
}

/// No contact anywhere.
pub fn no_surface(n_nodes: usize) -> ContactSurface {
    let around = NodeIncidence::new(n_nodes, std::iter::empty::<&[NodeId]>());
    ContactSurface { nodes: vec![], of: vec![None; n_nodes], facets: vec![], around }
}

/// A mesh whose boundary is held in a random affine deformation.
fn held_engine<const D: usize>(
    mesh: &Mesh<D>,
    (freedom, section): (FreeDirections, Section),
    cfl: f64,
) -> Engine<D, Simplices<D>> {
    let (a, b) = affine::<D>(&mut Noise::new(11));
    let held: Vec<[bool; D]> = inner(mesh).into_iter().map(|inside| [!inside; D]).collect();
    let simplices = Simplices::new(mesh, gel(), section);
    let mass = simplices.lumped_masses(mesh, 1.0);
    let nodes: Vec<_> = mesh.rest.iter().map(|rest| (a * rest + b, Vector::<D>::zeros())).collect();
    let gel = DiscreteGel::new(simplices, mass, &held, no_surface(mesh.rest.len()));
    Engine::new(gel, vec![nowhere(freedom)], IntegratorSettings { cfl, ..rules() }, nodes)
}

/// How far inner nodes move in a tenth of the time that a shear wave takes across, over the smallest edge, and how many
/// lengths of steps there are.
fn motion<const D: usize>(mesh: &Mesh<D>, kind: (FreeDirections, Section), cfl: f64) -> (f64, usize) {
    let mut engine = held_engine(mesh, kind, cfl);
    let start = engine.state().position.clone();
    let mut moved: f64 = 0.0;
    for i in 0..200 {
        engine
            .advance_to(0.1 * f64::from(i) / 200.0, &mut [ImpulseExchange::default()])
            .expect("next to nothing moves");
        let now = engine.state().position.iter().zip(&start).map(|(x, start)| (x - start).norm());
        moved = now.fold(moved, f64::max);
    }
    let mut steps = engine.steps();
    steps.sort_by(f64::total_cmp);
    steps.dedup();
    (moved / 0.04, steps.len())
}

const PLANE: (FreeDirections, Section) = (FreeDirections::PLANAR, Section::Planar { thickness: 1.0 });
const SPACE: (FreeDirections, Section) = (FreeDirections::SPATIAL, Section::Spatial);

/// Equal steps keep the balance of every inner node at every tick.
fn with_equal_steps() -> Row {
    let [flat, _] = blocks::<2>(CellSplit::Kuhn);
    let [solid, _] = blocks::<3>(CellSplit::Kuhn);
    let (flat, solid) = (motion(&flat, PLANE, 0.8), motion(&solid, SPACE, 0.8));
    let worst = flat.0.max(solid.0);
    let name = ("V1", "same in time, boundary held, equal steps: motion of inner nodes/h");
    Row::new(name, "0 within 1e-12", below(worst), worst < 1e-12 && flat.1 == 1 && solid.1 == 1)
}

/// Unequal steps kick a node from its two sides at different times: a balance of forces trembles, with second order in
/// the step.
fn with_unequal_steps() -> Row {
    let [_, mesh] = blocks::<3>(CellSplit::Centred);
    let cfl = [0.8, 0.4, 0.2, 0.1];
    let runs = cfl.map(|cfl| motion(&mesh, SPACE, cfl));
    let slope = order(&[(cfl[0], runs[0].0), (cfl[3], runs[3].0)]);
    let met = runs[0].1 >= 3 && runs[0].0 < 0.02 && (slope - 2.0).abs() < 0.2;
    let what = format!("same, {} lengths of steps, CFL .8/.4/.2/.1: trembling of inner nodes/h", runs[0].1);
    Row::new(("V1", &what), "< .02, slope 2", series(runs.map(|run| run.0), 5), met).with_order(slope)
}

/// The rows of this part, computed once.
pub fn rows() -> &'static [Row] {
    static ROWS: OnceLock<Vec<Row>> = OnceLock::new();
    ROWS.get_or_init(|| {
        let planar = static_defects(&all::<2>(), Section::Planar { thickness: 0.7 });
        let meshes: Vec<Mesh<3>> = all::<3>().into_iter().chain(cylinders()).collect();
        let spatial = static_defects(&meshes, Section::Spatial);
        let (strain, force) = (planar.0.max(spatial.0), planar.1.max(spatial.1));
        let first = (
            "V1",
            "x = A X + b, blocks, L-beams and cylinders, both lattices and trees, uniform and graded: |F − A|/|A|",
        );
        vec![
            Row::new(first, "0 within 1e-13", below(strain), strain < 1e-13),
            Row::new(("V1", "same: force on inner nodes/(|P| h²)"), "0 within 1e-12", below(force), force < 1e-12),
            with_equal_steps(),
            with_unequal_steps(),
        ]
    })
}

#[test]
fn affine_deformations_are_uniform_and_in_balance_on_every_mesh() {
    Row::check(rows());
}
