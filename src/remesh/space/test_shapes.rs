//! New meshes of random bodies with random sizes: what must hold of each, and of a second one with the same sizes.

use super::super::test_bodies::Random;
use super::super::{Acceptance, Moved, Origin, Proposal, Quality, Rules, graded, judge, rest_positions};
use super::propose;
use crate::math::{Tensor, Vector, det};
use crate::mesh::{
    Block, Face, Hold, Mesh, NodeId, Split, block, boundary, cylinder, facet_measure, shape_quality, uniform,
};
use std::f64::consts::TAU;

/// Seeds of the bodies.
const SEEDS: std::ops::Range<u64> = 1..201;
/// What the volume may change by: half of it is allowed where it cannot be given back.
const CHANGE: f64 = 1e-6;
/// What a round held face may lose of its area: 0.26 % were measured.
const ROUND: f64 = 4e-3;
/// A new mesh is as good as this, or as the old one; a second one as the first, or as the other: of 200 one has
/// 0.451 after 0.453, because an edge that was too short was drawn together.
const FAIR: [f64; 2] = [0.3, 0.45];

/// A box of about the unit cube, or a cylinder in it, and whether it is a box; a face of it is held.
fn body(random: &mut Random) -> (Mesh<3>, bool) {
    let is_box = random.next() < 0.5;
    let count = |random: &mut Random| 4 + (3.0 * random.next()) as usize;
    let hold = if random.next() < 0.5 { Hold::All } else { Hold::Normal };
    let split = if random.next() < 0.7 { Split::Centred } else { Split::Kuhn };
    let axis = |n: usize| uniform(0.0, 1.0, 1.0 / n as f64);
    if is_box {
        let faces = (0..3).filter(|_| random.next() < 0.5).map(|axis| Face { axis, high: false, hold }).collect();
        return (block(Block { planes: [(); 3].map(|()| axis(count(random))), split, faces }), true);
    }
    let across = || uniform(-0.5, 0.5, 0.25);
    let face = Face { axis: if random.next() < 0.5 { 0 } else { 2 }, high: false, hold };
    let square = Block { planes: [across(), across(), axis(count(random))], split, faces: vec![face] };
    (cylinder(0.5, square), false)
}

/// A sum of waves of random direction with a slope of at most one in all.
struct Waves([(Vector<3>, f64, Vector<3>); 3]);

impl Waves {
    fn new(random: &mut Random) -> Self {
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

/// A vector no longer than 1.
fn any(random: &mut Random) -> Vector<3> {
    let x = Vector::<3>::from_fn(|_, _| 2.0 * random.next() - 1.0);
    x / x.norm().max(1.0)
}

/// A map that turns nothing inside out: an affine one of waves of less than a slope of one.
fn map(random: &mut Random) -> impl Fn(&Vector<3>) -> Vector<3> {
    let (waves, steepness) = (Waves::new(random), 0.7 * random.next());
    let turned = loop {
        let a = Tensor::<3>::from_fn(|i, j| f64::from(i == j) + 1.4 * (random.next() - 0.5));
        if det(&a) > 0.3 {
            break a;
        }
    };
    move |x| turned * (x + waves.at(x) * steepness)
}

/// Sizes that differ by up to a factor of three, around the edges of the mesh.
fn sizes(old: &Moved<'_, 3>, random: &mut Random) -> Vec<f64> {
    let volume: f64 = old.mesh.elements.iter().map(|e| crate::mesh::signed_volume(old.position, e)).sum();
    let edge = (6.0 * 2.0_f64.sqrt() * volume / old.mesh.elements.len() as f64).cbrt();
    let (waves, whole) = (Waves::new(random), edge * (0.7 + 0.8 * random.next()));
    let uneven = |x: &Vector<3>| (3.0_f64.ln() * 0.5 * (2.0 * waves.at(x)[0]).sin()).exp();
    graded(old, old.position.iter().map(|x| whole * uneven(x)).collect(), 0.5)
}

/// The sizes of the old nodes that are nearest to the new ones.
fn nearest(old: &Moved<'_, 3>, size: &[f64], new: &[Vector<3>]) -> Vec<f64> {
    let distance = |i: usize, x: &Vector<3>| (old.position[i] - x).norm_squared();
    let of = |x: &Vector<3>| (0..size.len()).min_by(|a, b| distance(*a, x).total_cmp(&distance(*b, x)));
    new.iter().map(|x| size[of(x).expect("a mesh has nodes")]).collect()
}

fn worst(x: &[Vector<3>], mesh: &Mesh<3>) -> f64 {
    mesh.elements.iter().map(|e| shape_quality(x, e)).fold(f64::INFINITY, f64::min)
}

/// The mesh that a proposal makes of another one, at rest on its surface where that was.
fn settled(old: &Moved<'_, 3>, new: &Proposal<3>) -> Mesh<3> {
    let rest = |(origin, x): (&Origin, &Vector<3>)| match origin {
        Origin::Kept(node) => old.mesh.rest[node.index()],
        Origin::Surface(nodes, weights) => nodes.iter().zip(weights).map(|(n, w)| old.mesh.rest[n.index()] * *w).sum(),
        Origin::Inside => *x,
    };
    Mesh {
        rest: new.origin.iter().zip(&new.position).map(rest).collect(),
        held: rest_positions::held(&old.mesh.held, &new.origin),
        facets: boundary::<3>(&new.elements),
        elements: new.elements.clone(),
        marks: vec![],
    }
}

/// Whether every edge of the surface is that of two facets, and the surface a sphere.
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

/// A new mesh, and what it was judged to be; what is wrong with it, if something is.
fn remeshed(old: &Moved<'_, 3>, size: &[f64], quality: f64) -> Result<(Proposal<3>, Quality), String> {
    let new = propose(old, size, &Rules::default(), &|x| *x);
    let judged = judge(old, &new, &Acceptance { measure: CHANGE, quality });
    let moved = |(origin, x): (&Origin, &Vector<3>)| matches!(origin, Origin::Kept(n) if old.position[n.index()] != *x);
    if new.origin.iter().zip(&new.position).any(moved) {
        return Err("a kept node was moved".into());
    }
    if !is_sphere(&settled(old, &new)) {
        return Err("its surface is no sphere".into());
    }
    judged.map(|quality| (new, quality)).map_err(|why| why.to_string())
}

/// Whether the corners of a box, and all of what was held, are there at rest.
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

/// Both meshes of a body; what is wrong with one, if something is.
fn case(seed: u64) -> Result<(), String> {
    let mut random = Random::new(seed);
    let (mesh, is_box) = body(&mut random);
    let map = map(&mut random);
    let position: Vec<Vector<3>> = mesh.rest.iter().map(map).collect();
    let old = Moved { mesh: &mesh, position: &position };
    let (size, first) = (sizes(&old, &mut random), worst(&position, &mesh));
    let (new, quality) = remeshed(&old, &size, first.min(FAIR[0])).map_err(|why| format!("first: {why}"))?;
    let next = settled(&old, &new);
    keeps_its_shape(&mesh, &next, is_box)?;
    let own = nearest(&old, &size, &new.position);
    let once = Moved { mesh: &next, position: &new.position };
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
