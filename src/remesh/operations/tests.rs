//! Operations on random cavities of deformed blocks, in the plane, about an axis and in space.

use super::editable_mesh::EditableMesh;
use super::element_model::{ElementModel, ElementState};
use super::improvement::edges_of;
use super::nodal_sizes::NodalSizes;
use super::operation::Operation;
use super::{EditLimits, EditScene, EditSource, ReferenceConfiguration, improve};
use crate::math::{Tensor, Vector, det};
use crate::mesh::{
    BlockSpec, CORNERS, CellSplit, ElementId, ElementPatches, FaceConstraint, HeldFace, Mesh, NodeId, NodeIncidence,
    block, boundary, edges, facet_measure, shape_quality, signed_volume, uniform,
};
use crate::remesh::test_bodies::TestRandom;
use crate::remesh::test_meshes::FlowingShapes;
use crate::remesh::{BodySymmetry, ConservedTotals, corner_masses, nodal_masses};

/// Elements of ψ = ½ (|F|² − D − 2 ln J) + 5 (J̄ − 1)², in units of the shear modulus, with J̄ of their patch; the
/// hindrance is the frequency of the least height over a limit.
#[derive(Clone, Copy)]
struct Solid {
    symmetry: BodySymmetry,
    limit: f64,
}

impl<const D: usize> ElementModel<D> for Solid {
    fn state(&self, rest: &[Vector<D>; 4], now: &[Vector<D>; 4]) -> ElementState {
        let [rest_edges, now_edges] = [rest, now].map(|x| edges(x, &CORNERS));
        let inverse = rest_edges.try_inverse().unwrap_or_else(Tensor::<D>::zeros);
        let f = now_edges * inverse;
        let ring = |x: &[Vector<D>; 4]| x[..=D].iter().map(|x| x[0]).sum::<f64>();
        let is_ring = self.symmetry == BodySymmetry::Axisymmetric;
        let hoop = if is_ring { ring(now) / ring(rest) } else { 1.0 };
        let volume = signed_volume(rest, &CORNERS) * if is_ring { ring(rest) } else { 1.0 };
        let jacobian = det(&f) * hoop;
        let strain = f.norm_squared() + hoop * hoop - (D + 1) as f64 - 2.0 * jacobian.abs().ln();
        let energy = volume * 0.5 * strain;
        let frequency = now_edges.norm() / signed_volume(now, &CORNERS);
        let hindrance = frequency / self.limit;
        ElementState { volume, jacobian, density: 1.0, strength: 1.0, energy, hindrance }
    }

    fn common_energy(&self, jacobian: f64) -> f64 {
        5.0 * (jacobian - 1.0).powi(2)
    }

    fn smoothing(&self, _: f64) -> f64 {
        0.0
    }
}

/// A block, strained and moving, held at its first face of the last axis.
struct Body<const D: usize> {
    mesh: Mesh<D>,
    position: Vec<Vector<D>>,
    velocity: Vec<Vector<D>>,
    mass: Vec<f64>,
    corner_mass: Vec<[f64; 4]>,
    incidence: NodeIncidence,
    patches: ElementPatches,
    solid: Solid,
}

impl<const D: usize> Body<D> {
    fn new(symmetry: BodySymmetry, is_held: bool, random: &mut TestRandom) -> Self {
        let from = if symmetry == BodySymmetry::Axisymmetric { 0.3 } else { 0.0 };
        let planes =
            std::array::from_fn(
                |axis| if axis == 0 { uniform(from, from + 1.0, 0.25) } else { uniform(0.0, 1.0, 0.25) },
            );
        let faces =
            if is_held { vec![HeldFace { axis: D - 1, high: false, hold: FaceConstraint::Normal }] } else { vec![] };
        let mesh = block::<D>(BlockSpec { planes, split: CellSplit::Centred, faces });
        let bent = |x: &Vector<D>, random: &mut TestRandom| {
            let (across, along) = (x[0], x[D - 1]);
            let mut now = *x;
            now[0] += 0.3 * across * along;
            now[D - 1] *= 1.4 - 0.2 * across;
            now + Vector::<D>::from_fn(|_, _| 0.02 * along * (random.next() - 0.5))
        };
        let position: Vec<_> = mesh.rest.iter().map(|x| bent(x, random)).collect();
        let velocity = mesh
            .held
            .iter()
            .map(|held| Vector::<D>::from_fn(|axis, _| if held[axis] { 0.0 } else { random.next() - 0.3 }))
            .collect();
        let solid = Solid { symmetry, limit: 1.0 };
        let volume = |nodes: &[NodeId; 4]| solid.state(&at(&mesh.rest, nodes), &at(&position, nodes)).volume;
        let masses: Vec<f64> = mesh.elements.iter().map(volume).collect();
        let corner_mass = corner_masses(&mesh.rest, &mesh.elements, &masses, symmetry);
        let incidence = NodeIncidence::new(mesh.rest.len(), mesh.elements.iter().map(|nodes| &nodes[..=D]));
        let patches = ElementPatches::grouped(&mesh);
        let mass = nodal_masses::<D>(mesh.rest.len(), &mesh.elements, &corner_mass);
        Self { mesh, position, velocity, mass, corner_mass, incidence, patches, solid }
    }

    /// A body at rest.
    fn at_rest(mesh: Mesh<D>) -> Self {
        let n = mesh.rest.len();
        let solid = Solid { symmetry: BodySymmetry::Spatial, limit: 1.0 };
        let masses: Vec<f64> = mesh.elements.iter().map(|nodes| signed_volume(&mesh.rest, nodes)).collect();
        let corner_mass = corner_masses(&mesh.rest, &mesh.elements, &masses, solid.symmetry);
        Self {
            position: mesh.rest.clone(),
            velocity: vec![Vector::zeros(); n],
            mass: nodal_masses::<D>(n, &mesh.elements, &corner_mass),
            incidence: NodeIncidence::new(n, mesh.elements.iter().map(|nodes| &nodes[..=D])),
            patches: ElementPatches::alone(mesh.elements.len()),
            corner_mass,
            solid,
            mesh,
        }
    }

    fn editable(&self) -> EditableMesh<'_, D> {
        self.editable_in(ReferenceConfiguration::Rest)
    }

    fn editable_in(&self, configuration: ReferenceConfiguration) -> EditableMesh<'_, D> {
        let n = self.mesh.elements.len();
        EditableMesh::new(EditSource {
            mesh: &self.mesh,
            incidence: &self.incidence,
            patches: &self.patches,
            position: &self.position,
            velocity: &self.velocity,
            mass: &self.mass,
            corner_mass: &self.corner_mass,
            step: vec![1.0; n],
            is_compatible: vec![true; n],
            symmetry: self.solid.symmetry,
            configuration,
        })
    }
}

fn at<const D: usize>(x: &[Vector<D>], nodes: &[NodeId; 4]) -> [Vector<D>; 4] {
    std::array::from_fn(|k| x[nodes[k.min(D)].index()])
}

/// Stored energy of a mesh, and its totals.
fn totals<const D: usize>(mesh: &EditableMesh<'_, D>, solid: &Solid) -> (f64, ConservedTotals<D>) {
    let (edited, _) = mesh.clone().finish();
    let state = |nodes: &[NodeId; 4]| solid.state(&at(&edited.rest, nodes), &at(&edited.position, nodes));
    let states: Vec<ElementState> = edited.elements.iter().map(state).collect();
    let volume = |patch: &[ElementId]| {
        let all = || patch.iter().map(|element| states[element.index()]);
        let volume: f64 = all().map(|state| state.volume).sum();
        let mean = all().map(|state| state.volume * state.jacobian).sum::<f64>() / volume;
        volume * ElementModel::<D>::common_energy(solid, mean)
    };
    let stored = states.iter().map(|state| state.energy).chain(edited.patches.iter().map(volume)).sum();
    (stored, ConservedTotals::of(&edited.position, &edited.mass, &edited.velocity))
}

/// A random operation.
fn drawn<const D: usize>(mesh: &EditableMesh<'_, D>, random: &mut TestRandom) -> Option<Operation<D>> {
    let present: Vec<_> = mesh.present().collect();
    let mut pick = |n: usize| ((random.next() * n as f64) as usize).min(n - 1);
    let element = present[pick(present.len())];
    let nodes = mesh.elements[element.index()];
    let (i, kind) = (pick(D + 1), pick(5));
    let (a, b) = (nodes[i], nodes[(i + 1 + pick(D)) % (D + 1)]);
    match kind {
        0 => Some(mesh.split(a, b)),
        1 => mesh.collapse(a, b, 0.5 * pick(2) as f64),
        2 => mesh.flip(element, i),
        3 if D == 3 => {
            let to = *nodes[..=D].iter().find(|node| **node != a && **node != b)?;
            Some(mesh.remove_edge(a, b, to))
        }
        _ => {
            let way = mesh.nodes[b.index()].rest - mesh.nodes[a.index()].rest;
            mesh.moved(a, &(mesh.nodes[a.index()].rest + way * (0.3 * random.next())))
        }
    }
}

fn check_random_operations<const D: usize>(symmetry: BodySymmetry, is_held: bool) {
    let mut random = TestRandom::new(5);
    let body = Body::<D>::new(symmetry, is_held, &mut random);
    let mut mesh = body.editable();
    let measure = |x: &[Vector<D>], elements: &[[NodeId; 4]]| -> f64 {
        elements.iter().map(|nodes| signed_volume(x, nodes)).sum()
    };
    let surface = |x: &[Vector<D>], elements: &[[NodeId; 4]]| -> f64 {
        boundary::<D>(elements).iter().map(|facet| facet_measure(x, facet)).sum()
    };
    let mut done = [0; 4];
    for _ in 0..600 {
        let Some(operation) = drawn(&mesh, &mut random) else { continue };
        let Some(trial) = mesh.attempt(&operation, &body.solid, |_| f64::INFINITY) else { continue };
        let (stored, before) = totals(&mesh, &body.solid);
        let Some(regrouping) = mesh.regroup(&operation, &trial.states, &body.solid) else { continue };
        let kinetic = mesh.commit(&operation, &trial.states, &regrouping);
        let (after_stored, after) = totals(&mesh, &body.solid);
        done[operation.kind as usize] += 1;
        let kind = operation.kind;
        assert!((after_stored - stored - regrouping.energy).abs() < 1e-11, "{kind:?}: {stored} {after_stored}");
        assert!((after.kinetic - before.kinetic - kinetic).abs() < 1e-11);
        assert!((after.mass - before.mass).abs() < 1e-13);
        if !is_held {
            let radial = usize::from(symmetry == BodySymmetry::Axisymmetric);
            let slip = after.momentum - before.momentum;
            assert!((radial..D).all(|axis| slip[axis].abs() < 1e-13), "{kind:?}: {slip}");
            if radial == 0 {
                assert!((after.angular - before.angular).norm() < 1e-12, "{kind:?}");
            }
        }
    }
    assert!(done.iter().all(|n| *n > 8), "{done:?}");
    let (edited, pairing) = mesh.finish();
    let (old, new) = (&body.mesh, &edited);
    assert!((measure(&old.rest, &old.elements) - measure(&new.rest, &new.elements)).abs() < 1e-12);
    assert!((surface(&old.rest, &old.elements) - surface(&new.rest, &new.elements)).abs() < 1e-11);
    for nodes in &new.elements {
        assert!(shape_quality(&new.rest, nodes) > 0.0 && shape_quality(&new.position, nodes) > 0.0);
    }
    let mass = nodal_masses::<D>(new.rest.len(), &new.elements, &new.corner_mass);
    assert!(mass.iter().zip(&new.mass).all(|(a, b)| (a - b).abs() < 1e-15 && *b > 0.0));
    for (same, nodes) in pairing.same.iter().zip(&new.elements) {
        let Some(same) = same else { continue };
        let was = at(&old.rest, &old.elements[same.element.index()]);
        assert!(was == at(&new.rest, nodes));
    }
}

#[test]
fn operations_keep_mass_momentum_surface_and_what_they_say_of_energy() {
    for is_held in [false, true] {
        check_random_operations::<2>(BodySymmetry::Planar, is_held);
        check_random_operations::<2>(BodySymmetry::Axisymmetric, is_held);
        check_random_operations::<3>(BodySymmetry::Spatial, is_held);
    }
}

/// Two prisms of three tetrahedra each, on both sides of a triangle with corners at this radius: nodes 3, 4 and 5.
fn necked(radius: f64) -> Mesh<3> {
    let corner = |layer: usize, k: usize| {
        let (r, angle) = (if layer == 1 { radius } else { 1.0 }, std::f64::consts::TAU * k as f64 / 3.0);
        Vector::<3>::new(r * libm::cos(angle), r * libm::sin(angle), layer as f64)
    };
    let points: Vec<_> = (0..3).flat_map(|layer| (0..3).map(move |k| corner(layer, k))).collect();
    let prism = |first: u32| [[0, 1, 2, 3], [1, 2, 3, 4], [2, 3, 4, 5]].map(|nodes| nodes.map(|k| NodeId(first + k)));
    let elements = upright(&points, [prism(0), prism(3)].concat());
    Mesh::new(points, elements)
}

/// Elements with their corners in the order of a positive volume.
fn upright(points: &[Vector<3>], mut elements: Vec<[NodeId; 4]>) -> Vec<[NodeId; 4]> {
    for nodes in elements.iter_mut().filter(|nodes| signed_volume(points, nodes) < 0.0) {
        nodes.swap(0, 1);
    }
    elements
}

/// The collapse of an edge of a neck would close it: the triangle of its ends and the third corner is a loop on the
/// surface.
#[test]
fn a_collapse_does_not_close_a_neck() {
    let body = Body::at_rest(necked(0.01));
    let mesh = body.editable_in(ReferenceConfiguration::Present);
    let measure = |all: &[[NodeId; 4]]| all.iter().map(|nodes| signed_volume(&body.mesh.rest, nodes)).sum::<f64>();
    let collapse = mesh.collapse(NodeId(3), NodeId(4), 0.0).unwrap();
    let old: Vec<_> = collapse.old.iter().map(|element| body.mesh.elements[element.index()]).collect();
    assert!((measure(&collapse.new) / measure(&old) - 1.0).abs() < 0.05, "the volume allows it");
    assert!(!mesh.keeps_topology(&collapse));
    // The same of an edge on the face of a block.
    let block = Body::<3>::new(BodySymmetry::Spatial, false, &mut TestRandom::new(15));
    let at = |x: [f64; 3]| block.mesh.rest.iter().position(|p| (p - Vector::<3>::from(x)).norm() < 1e-9).unwrap();
    let [a, b] = [[0.5, 0.5, 1.0], [0.5, 0.75, 1.0]].map(|x| NodeId(at(x) as u32));
    let mesh = block.editable_in(ReferenceConfiguration::Present);
    assert!(mesh.keeps_topology(&mesh.collapse(a, b, 0.0).unwrap()));
}

/// Gel that touches itself along an edge stays so: a collapse of the edge would part it, and a split make one node of
/// two.
#[test]
fn an_edge_along_which_gel_touches_itself_stays() {
    let points =
        [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, -0.3, 0.0], [1.0, 0.3, 0.0], [-1.0, 0.3, 0.0], [-1.0, -0.3, 0.0]];
    let points: Vec<_> = points.into_iter().map(Vector::<3>::from).collect();
    let elements = upright(&points, [[0, 1, 2, 3], [0, 1, 4, 5]].map(|nodes| nodes.map(NodeId)).to_vec());
    let body = Body::at_rest(Mesh::new(points, elements));
    let mesh = body.editable_in(ReferenceConfiguration::Present);
    let [a, b] = [NodeId(0), NodeId(1)];
    assert!(!mesh.keeps_topology(&mesh.collapse(b, a, 0.0).unwrap()));
    assert!(!mesh.keeps_topology(&mesh.split(a, b)));
    assert!(mesh.keeps_topology(&mesh.split(a, NodeId(2))));
}

/// The removal of a surface edge of two tetrahedra joins their apexes, unless these are joined elsewhere.
#[test]
fn a_flip_of_the_surface_makes_no_edge_that_is_there() {
    let points = [[0.0, -0.5, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
    let beyond = [[0.0, -0.5, 1.0], [0.0, 0.5, 1.0]];
    let points: Vec<_> = points.into_iter().chain(beyond).map(Vector::<3>::from).collect();
    let [pair, other] = [vec![[0, 1, 2, 3], [0, 1, 2, 4]], vec![[3, 4, 5, 6]]];
    let keeps = |elements: Vec<[u32; 4]>| {
        let elements = upright(&points, elements.iter().map(|nodes| nodes.map(NodeId)).collect());
        let body = Body::at_rest(Mesh::new(points.clone(), elements));
        let mesh = body.editable_in(ReferenceConfiguration::Present);
        mesh.keeps_topology(&mesh.remove_edge(NodeId(0), NodeId(1), NodeId(3)))
    };
    assert_eq!([keeps(pair.clone()), keeps([pair, other].concat())], [true, false]);
}

fn check_split<const D: usize>(symmetry: BodySymmetry) {
    let mut random = TestRandom::new(7);
    let mut body = Body::<D>::new(symmetry, false, &mut random);
    body.patches = ElementPatches::alone(body.mesh.elements.len());
    let mesh = body.editable();
    let nodes = mesh.elements[17];
    let operation = mesh.split(nodes[0], nodes[1]);
    let trial = mesh.attempt(&operation, &body.solid, |_| f64::INFINITY).unwrap();
    let regrouping = mesh.regroup(&operation, &trial.states, &body.solid).unwrap();
    assert!(regrouping.energy.abs() < 1e-14 && operation.new.len() == 2 * operation.old.len());
}

#[test]
fn a_split_stores_no_energy() {
    check_split::<2>(BodySymmetry::Planar);
    check_split::<3>(BodySymmetry::Spatial);
}

/// Corners of the block and the ends of its support are never given up or moved.
#[test]
fn corners_and_supports_stay() {
    let mut random = TestRandom::new(9);
    let body = Body::<2>::new(BodySymmetry::Planar, true, &mut random);
    let mut mesh = body.editable();
    let at = |x: f64, z: f64| body.mesh.rest.iter().position(|p| (p - Vector::<2>::new(x, z)).norm() < 1e-9);
    let node = |x: f64, z: f64| NodeId(at(x, z).unwrap() as u32);
    let legal = |mesh: &mut EditableMesh<'_, 2>, operation: Option<Operation<2>>| {
        operation.is_some_and(|operation| mesh.attempt(&operation, &body.solid, |_| f64::INFINITY).is_some())
    };
    let (corner, beside, above) = (node(1.0, 0.0), node(0.75, 0.0), node(1.0, 0.25));
    for (a, b) in [(corner, beside), (corner, above), (above, corner)] {
        let collapse = mesh.collapse(a, b, 0.0);
        assert!(!legal(&mut mesh, collapse), "{a:?} {b:?}");
    }
    // A node of the held face, and one of a free face, may move within their faces.
    let within = [(beside, Vector::<2>::new(0.7, 0.0)), (above, Vector::<2>::new(1.0, 0.3))];
    let moves = within.map(|(node, rest)| mesh.moved(node, &rest));
    assert_eq!(moves.map(|operation| legal(&mut mesh, operation)), [true; 2]);
    let moved = mesh.moved(corner, &Vector::<2>::new(0.97, 0.0));
    assert!(!legal(&mut mesh, moved));
}

/// A flattened element is remade, at a fraction of its frequency and hardly any energy; nothing is done without need.
#[test]
fn a_flattened_element_is_remade_and_a_good_mesh_is_left_alone() {
    let mut random = TestRandom::new(11);
    let mut body = Body::<2>::new(BodySymmetry::Planar, false, &mut random);
    let nodes = body.mesh.elements[30];
    let middle = (body.position[nodes[0].index()] + body.position[nodes[1].index()]) * 0.5;
    let apex = &mut body.position[nodes[2].index()];
    *apex = middle + (*apex - middle) * 0.08;
    let mut mesh = body.editable();
    let greatest = |mesh: &mut EditableMesh<'_, 2>, solid: &Solid| {
        let all: Vec<_> = mesh.present().collect();
        all.into_iter().map(|e| mesh.state(e, solid).hindrance).fold(0.0, f64::max)
    };
    let worst = greatest(&mut mesh, &body.solid);
    let limited = |part: f64| Solid { limit: part * worst, ..body.solid };
    let far = |_: &Vector<2>| f64::INFINITY;
    let scene = EditScene { gap: &far, cleared: &|x| *x, size: &|_| 0.25, growth: 0.0 };
    let limits = EditLimits { energy: 100.0, usual: 0.25, least: 0.25 };
    let mut mesh = body.editable();
    let idle = improve(&mut mesh, &limited(1.01), &scene, &limits, vec![]);
    assert!(idle.total() == 0 && mesh.finish().1.gone.is_empty());
    let mut mesh = body.editable();
    let bad = mesh.present().collect();
    let counts = improve(&mut mesh, &limited(0.7), &scene, &limits, bad);
    assert!(counts.total() > 0 && counts.stuck == 0, "{counts:?}");
    assert!(greatest(&mut mesh, &limited(0.7)) <= 1.0 && counts.hindrance <= 1.0);
}

/// Nodal sizes bound the length of every edge in target lengths, near a body more closely than without a known growth.
#[test]
fn nodal_sizes_bound_the_relative_length_of_each_edge() {
    let body = Body::<3>::new(BodySymmetry::Spatial, false, &mut TestRandom::new(17));
    let mesh = body.editable();
    let size = |x: &Vector<3>| 0.1 + 0.3 * (x - Vector::<3>::new(0.4, 0.5, 0.6)).norm();
    let scene = |growth| EditScene { gap: &|_| 1.0, cleared: &|x| *x, size: &size, growth };
    let (known, unknown) = (scene(0.3), scene(f64::INFINITY));
    let [bounds, none] = [&known, &unknown].map(|scene| NodalSizes::new(scene, mesh.nodes.len()));
    for element in mesh.present() {
        let nodes = mesh.elements[element.index()];
        for [a, b] in edges_of::<3>().map(|(i, j)| [nodes[i], nodes[j]]) {
            let ends = [a, b].map(|node| mesh.nodes[node.index()].position);
            let length = (ends[0] - ends[1]).norm() / size(&((ends[0] + ends[1]) * 0.5));
            let [least, most] = bounds.relative_length(&mesh, a, b);
            assert!(least <= length && length <= most, "{length} outside {least} to {most}");
            assert!(most < 2.0 * least, "{least} to {most}");
            assert!(length <= bounds.greatest_length(&mesh, a, &ends[1]));
            assert_eq!(none.relative_length(&mesh, a, b), [0.0, f64::INFINITY]);
        }
    }
}

/// A gel that flows follows the target lengths, finer and coarser; each new element lies over the old ones that it
/// names, and each node where its origin says.
fn check_target_lengths<const D: usize>(symmetry: BodySymmetry, size: f64) {
    let mut random = TestRandom::new(13);
    let body = Body::<D>::new(symmetry, false, &mut random);
    let mut mesh = body.editable_in(ReferenceConfiguration::Present);
    let scene = EditScene { gap: &|_| 1.0, cleared: &|x| *x, size: &|_| size, growth: 0.0 };
    let limits = EditLimits { energy: 1.0, usual: size, least: size };
    let counts = improve(&mut mesh, &FlowingShapes, &scene, &limits, vec![]);
    let (new, pairing) = mesh.finish();
    let is_finer = size < 0.2;
    assert!(counts.operations[usize::from(!is_finer)] > 10, "{counts:?}");
    let measure = |x: &[Vector<D>], all: &[[NodeId; 4]]| all.iter().map(|nodes| signed_volume(x, nodes)).sum::<f64>();
    let (before, after) = (measure(&body.position, &body.mesh.elements), measure(&new.position, &new.elements));
    assert!((after / before - 1.0).abs() < if is_finer { 1e-4 } else { 0.02 }, "{before} {after}");
    let lies_over = |x: &Vector<D>, old: &ElementId| {
        let (nodes, mut moved) = (&body.mesh.elements[old.index()], body.position.clone());
        nodes[..=D].iter().all(|node| {
            let kept = std::mem::replace(&mut moved[node.index()], *x);
            let part = signed_volume(&moved, nodes);
            moved[node.index()] = kept;
            part > -1e-12
        })
    };
    let mut n_made = 0;
    for ((nodes, over), same) in new.elements.iter().zip(&new.over).zip(&pairing.same) {
        let middle = nodes[..=D].iter().map(|node| new.position[node.index()]).sum::<Vector<D>>() / (D + 1) as f64;
        assert_eq!(over.is_empty(), same.is_some());
        n_made += usize::from(same.is_none() && over.iter().any(|old| lies_over(&middle, old)));
    }
    let made = pairing.same.iter().filter(|same| same.is_none()).count();
    assert!(n_made * 10 > made * 9, "{n_made} of {made}");
    for (x, origin) in new.position.iter().zip(&new.origin) {
        let Some(parents) = origin.parents() else { continue };
        let interpolated: Vector<D> = parents.iter().map(|(node, weight)| body.position[node.index()] * *weight).sum();
        assert!((interpolated - x).norm() < 1e-12, "{origin:?}");
    }
}

#[test]
fn a_gel_that_flows_follows_the_target_lengths() {
    for size in [0.12, 0.6] {
        check_target_lengths::<2>(BodySymmetry::Planar, size);
        check_target_lengths::<2>(BodySymmetry::Axisymmetric, size);
    }
    check_target_lengths::<3>(BodySymmetry::Spatial, 0.12);
}

/// Elements of a gel that flows that a node has inverted are remade, into the best shapes that one operation can give.
#[test]
fn inverted_elements_of_a_gel_that_flows_are_remade() {
    let planes = [uniform(0.0, 1.0, 0.25), uniform(0.0, 1.0, 0.25)];
    let mesh = block::<2>(BlockSpec { planes, split: CellSplit::Centred, faces: vec![] });
    let mut body = Body::<2> { position: vec![], ..Body::new(BodySymmetry::Planar, false, &mut TestRandom::new(17)) };
    let centre = Vector::<2>::new(0.375, 0.375);
    body.position = mesh
        .rest
        .iter()
        .map(|x| if (x - centre).norm() < 1e-9 { x + Vector::<2>::new(0.15, 0.01) } else { *x })
        .collect();
    let is_inverted = |x: &[Vector<2>], nodes: &&[NodeId; 4]| signed_volume(x, nodes) <= 0.0;
    assert_eq!(body.mesh.elements.iter().filter(|nodes| is_inverted(&body.position, nodes)).count(), 1);
    let mut edited = body.editable_in(ReferenceConfiguration::Present);
    let scene = EditScene { gap: &|_| 1.0, cleared: &|x| *x, size: &|_| 0.25, growth: 0.0 };
    let limits = EditLimits { energy: 1.0, usual: 0.25, least: 0.25 };
    let bad = edited.present().collect();
    let counts = improve(&mut edited, &FlowingShapes, &scene, &limits, bad);
    let (new, _) = edited.finish();
    assert!(counts.hindrance.is_finite(), "{counts:?}");
    assert_eq!(new.elements.iter().filter(|nodes| is_inverted(&new.position, nodes)).count(), 0);
    let least = new.elements.iter().map(|nodes| shape_quality(&new.position, nodes)).fold(1.0, f64::min);
    assert!(least > 0.3, "{least}");
}
