//! Random bodies with random target sizes: properties of every new mesh, and of a second one with the same sizes.

use super::super::test_bodies::TestRandom;
use super::super::{
    AcceptanceLimits, DeformedMesh, MeshQuality, NodeOrigin, ProposedMesh, RemeshRules, check_acceptance, graded,
    rest_positions,
};
use super::propose;
use crate::math::{Tensor, Vector, det};
use crate::mesh::{
    BlockSpec, CellSplit, FaceConstraint, HeldFace, Mesh, NodeId, block, boundary, cylinder, facet_measure,
    shape_quality, uniform,
};
use std::f64::consts::TAU;

/// Seeds of the random bodies.
const SEEDS: std::ops::Range<u64> = 1..201;
/// Greatest change of volume: half of it is allowed where it cannot be returned.
const CHANGE: f64 = 1e-6;
/// Greatest loss of area of a round held face: 0.26 % were measured.
const ROUND: f64 = 4e-3;
/// Quality of a new mesh, or that of the old one; a second mesh has that of the first, or the other value. Of 200
/// bodies one has 0.451 after 0.453, because a short edge was collapsed.
const FAIR: [f64; 2] = [0.3, 0.45];

/// Box of about the unit cube, or a cylinder in it, and true for the box; one of its faces is held.
fn body(random: &mut TestRandom) -> (Mesh<3>, bool) {
    let is_box = random.next() < 0.5;
    let count = |random: &mut TestRandom| 4 + (3.0 * random.next()) as usize;
    let hold = if random.next() < 0.5 { FaceConstraint::All } else { FaceConstraint::Normal };
    let split = if random.next() < 0.7 { CellSplit::Centred } else { CellSplit::Kuhn };
    let axis = |n: usize| uniform(0.0, 1.0, 1.0 / n as f64);
    if is_box {
        let faces = (0..3).filter(|_| random.next() < 0.5).map(|axis| HeldFace { axis, high: false, hold }).collect();
        return (block(BlockSpec { planes: [(); 3].map(|()| axis(count(random))), split, faces }), true);
    }
    let across = || uniform(-0.5, 0.5, 0.25);
    let face = HeldFace { axis: if random.next() < 0.5 { 0 } else { 2 }, high: false, hold };
    let square = BlockSpec { planes: [across(), across(), axis(count(random))], split, faces: vec![face] };
    (cylinder(0.5, square), false)
}

/// Sum of waves of random direction with a total slope of at most one.
struct RandomWaves([(Vector<3>, f64, Vector<3>); 3]);

impl RandomWaves {
    fn new(random: &mut TestRandom) -> Self {
        Self([(); 3].map(|()| {
            let wave = any(random) * 0.7 * TAU;
            let phase = TAU * random.next();
            (wave, phase, any(random) / (3.0 * wave.norm()))
        }))
    }

    fn at(&self, x: &Vector<3>) -> Vector<3> {
        self.0.iter().map(|(wave, phase, height)| height * (wave.dot(x) + phase).sin()).sum()
    }
}

/// Random vector no longer than 1.
fn any(random: &mut TestRandom) -> Vector<3> {
    let x = Vector::<3>::from_fn(|_, _| 2.0 * random.next() - 1.0);
    x / x.norm().max(1.0)
}

/// Map without inversion: an affine map of waves of a slope below one.
fn map(random: &mut TestRandom) -> impl Fn(&Vector<3>) -> Vector<3> {
    let (waves, steepness) = (RandomWaves::new(random), 0.7 * random.next());
    let turned = loop {
        let a = Tensor::<3>::from_fn(|i, j| f64::from(i == j) + 1.4 * (random.next() - 0.5));
        if det(&a) > 0.3 {
            break a;
        }
    };
    move |x| turned * (x + waves.at(x) * steepness)
}

/// Sizes that vary by up to a factor of three around the edges of the mesh.
fn sizes(old: &DeformedMesh<'_, 3>, random: &mut TestRandom) -> Vec<f64> {
    let volume: f64 = old.mesh.elements.iter().map(|e| crate::mesh::signed_volume(old.position, e)).sum();
    let edge = (6.0 * 2.0_f64.sqrt() * volume / old.mesh.elements.len() as f64).cbrt();
    let (waves, whole) = (RandomWaves::new(random), edge * (0.7 + 0.8 * random.next()));
    let uneven = |x: &Vector<3>| (3.0_f64.ln() * 0.5 * (2.0 * waves.at(x)[0]).sin()).exp();
    graded(old, old.position.iter().map(|x| whole * uneven(x)).collect(), 0.5)
}

/// Sizes of the old nodes nearest to the new ones.
fn nearest(old: &DeformedMesh<'_, 3>, size: &[f64], new: &[Vector<3>]) -> Vec<f64> {
    let distance = |i: usize, x: &Vector<3>| (old.position[i] - x).norm_squared();
    let of = |x: &Vector<3>| (0..size.len()).min_by(|a, b| distance(*a, x).total_cmp(&distance(*b, x)));
    new.iter().map(|x| size[of(x).expect("a mesh has nodes")]).collect()
}

fn worst(x: &[Vector<3>], mesh: &Mesh<3>) -> f64 {
    mesh.elements.iter().map(|e| shape_quality(x, e)).fold(f64::INFINITY, f64::min)
}

/// Mesh of a proposal, with the rest positions of its surface interpolated.
fn settled(old: &DeformedMesh<'_, 3>, new: &ProposedMesh<3>) -> Mesh<3> {
    let rest = |(origin, x): (&NodeOrigin, &Vector<3>)| match origin {
        NodeOrigin::Kept(node) => old.mesh.rest[node.index()],
        NodeOrigin::Surface(nodes, weights) => {
            nodes.iter().zip(weights).map(|(n, w)| old.mesh.rest[n.index()] * *w).sum()
        }
        NodeOrigin::Inside => *x,
    };
    Mesh {
        rest: new.origin.iter().zip(&new.position).map(rest).collect(),
        held: rest_positions::held(&old.mesh.held, &new.origin),
        facets: boundary::<3>(&new.elements),
        elements: new.elements.clone(),
        marks: vec![],
    }
}

/// Returns true if every surface edge has two facets, and the surface is a sphere.
fn is_sphere(mesh: &Mesh<3>) -> bool {
    let ends = |f: &[NodeId; 3]| [[f[0], f[1]], [f[1], f[2]], [f[2], f[0]]].map(|[a, b]| [a.min(b), a.max(b)]);
    let mut edges: Vec<[NodeId; 2]> = mesh.facets.iter().flat_map(ends).collect();
    edges.sort_unstable();
    let closed = edges.chunk_by(|a, b| a == b).all(|same| same.len() == 2);
    edges.dedup();
    let mut nodes: Vec<NodeId> = mesh.facets.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    closed && nodes.len() + mesh.facets.len() == edges.len() + 2
}

/// Area at rest of the facets whose nodes are all held in one direction, m².
fn held_area(mesh: &Mesh<3>) -> f64 {
    let is_held = |f: &&[NodeId; 3]| (0..3).any(|axis| f.iter().all(|n| mesh.held[n.index()][axis]));
    mesh.facets.iter().filter(is_held).map(|f| facet_measure(&mesh.rest, f)).sum()
}

/// New mesh and its accepted quality, or a description of the failure.
fn remeshed(old: &DeformedMesh<'_, 3>, size: &[f64], quality: f64) -> Result<(ProposedMesh<3>, MeshQuality), String> {
    let new = propose(old, size, &RemeshRules::default(), &|x| *x).unwrap();
    let judged = check_acceptance(old, &new, &AcceptanceLimits { measure: CHANGE, quality });
    let moved =
        |(origin, x): (&NodeOrigin, &Vector<3>)| matches!(origin, NodeOrigin::Kept(n) if old.position[n.index()] != *x);
    if new.origin.iter().zip(&new.position).any(moved) {
        return Err("a kept node was moved".into());
    }
    if !is_sphere(&settled(old, &new)) {
        return Err("its surface is no sphere".into());
    }
    judged.map(|quality| (new, quality)).map_err(|why| why.to_string())
}

/// Checks that the corners of a box, and all held faces, exist at rest.
fn keeps_its_shape(old: &Mesh<3>, new: &Mesh<3>, is_box: bool) -> Result<(), String> {
    let corner = |k: usize| Vector::<3>::from_fn(|axis, _| f64::from(u8::from(k >> axis & 1 == 1)));
    if let Some(lost) = (0..8).map(corner).find(|corner| is_box && !new.rest.contains(corner)) {
        return Err(format!("the corner {lost:?} was lost"));
    }
    let [before, after] = [held_area(old), held_area(new)];
    // A cylinder may lose corners of its rim and edges of its mantle.
    let tolerance = if is_box { 1e-12 } else { ROUND };
    if (after - before).abs() <= tolerance * before {
        Ok(())
    } else {
        Err(format!("held: {before} m², then {after} m²"))
    }
}

/// Tests both meshes of a body.
fn case(seed: u64) -> Result<(), String> {
    let mut random = TestRandom::new(seed);
    let (mesh, is_box) = body(&mut random);
    let map = map(&mut random);
    let position: Vec<Vector<3>> = mesh.rest.iter().map(map).collect();
    let old = DeformedMesh { mesh: &mesh, position: &position };
    let (size, first) = (sizes(&old, &mut random), worst(&position, &mesh));
    let (new, quality) = remeshed(&old, &size, first.min(FAIR[0])).map_err(|why| format!("first: {why}"))?;
    let next = settled(&old, &new);
    keeps_its_shape(&mesh, &next, is_box)?;
    let own = nearest(&old, &size, &new.position);
    let once = DeformedMesh { mesh: &next, position: &new.position };
    let twice = remeshed(&once, &own, quality.least.min(FAIR[1])).map_err(|why| format!("second: {why}"))?;
    keeps_its_shape(&next, &settled(&once, &twice.0), is_box)?;
    let count = |elements: &[crate::mesh::Simplex]| elements.len();
    println!(
        "seed {seed}, box {is_box}: tetrahedra {} -> {} -> {}, worst {first:.3} -> {:.3} -> {:.3}, volume {:.1e}, {:.1e}",
        count(&mesh.elements),
        count(&new.elements),
        count(&twice.0.elements),
        quality.least,
        twice.1.least,
        quality.change,
        twice.1.change
    );
    Ok(())
}

#[test]
fn random_bodies_keep_shape_and_volume_and_a_second_mesh_with_the_same_sizes_changes_little() {
    let wrong: Vec<String> =
        SEEDS.filter_map(|seed| case(seed).err().map(|why| format!("seed {seed}: {why}"))).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
