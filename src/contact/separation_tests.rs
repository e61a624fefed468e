//! Tests of the separation list against a search through all nodes and facets.

use super::batch_travel::TRAVEL_BATCH;
use super::facet::outward_normal;
use super::facet_foot::FacetFoot;
use super::self_contact::{CONTACT_REACH, contact_size};
use super::separation_list::SeparationList;
use super::surface::ContactSurface;
use super::surface_motion::{NodePlaces, SurfaceMotion, SurfaceStars};
use super::test_surface::any;
use crate::math::{Vector, Vector3, embed};
use crate::mesh::{BlockSpec, CellSplit, ElementId, Mesh, NodeId, NodeIncidence, block};

/// Nodes with their places.
struct PlacedNodes<const D: usize>(Vec<Vector<D>>);

impl<const D: usize> NodePlaces<D> for &PlacedNodes<D> {
    fn place(&self, node: NodeId) -> Vector<D> {
        self.0[node.index()]
    }
}

/// Creates a horseshoe, open at the top: a block of cells of edge 1 without the cells between its arms.
fn horseshoe<const D: usize>(arm: f64, gap: f64, height: f64) -> Mesh<D> {
    let count = |length: f64| (0..=length as u32).map(f64::from).collect::<Vec<f64>>();
    let width = 2.0 * arm + gap;
    let planes = std::array::from_fn(|axis| {
        count(if axis == 0 {
            width
        } else if axis == D - 1 {
            height
        } else {
            3.0
        })
    });
    let whole = block(BlockSpec { planes, split: CellSplit::Centred, faces: vec![] });
    let is_kept = |nodes: &[NodeId; 4]| {
        let middle = nodes[..=D].iter().map(|node| whole.rest[node.index()]).sum::<Vector<D>>() / (D + 1) as f64;
        middle[D - 1] < arm || !(arm..arm + gap).contains(&middle[0])
    };
    let elements = whole.elements.iter().copied().filter(is_kept).collect();
    Mesh::new(whole.rest.clone(), elements)
}

/// Returns the nodes and facets within the reach of contact that face each other, by a search through all.
fn facing_pairs<const D: usize>(
    surface: &ContactSurface,
    stars: &SurfaceStars,
    nodes: &PlacedNodes<D>,
) -> Vec<(NodeId, ElementId)> {
    let corners = |facet: ElementId| surface.facets[facet.index()].map(|node| embed(&nodes.0[node.index()]));
    let mut found = vec![];
    for at in &surface.nodes {
        let point = embed(&nodes.0[at.node.index()]);
        let around = surface.around.of(at.node).iter();
        let outward: Vector3 = around.map(|facet| outward_normal::<D>(&corners(*facet))).sum();
        for facet in (0..surface.facets.len() as u32).map(ElementId) {
            let foot = FacetFoot::new::<D>(&corners(facet), &point);
            let is_near = foot.distance <= CONTACT_REACH * contact_size::<D>(surface, at.node, facet);
            if is_near && outward.dot(&foot.normal) < 0.0 && !stars.are_neighbours::<D>(surface, at.node, facet) {
                found.push((at.node, facet));
            }
        }
    }
    found
}

/// Returns the place of a node of the horseshoe in its motion: the arms bend inwards until they cross and outwards again,
/// all of it flies and turns, and all nodes shake.
fn place_at<const D: usize>(rest: &Vector<D>, node: usize, phase: f64) -> Vector<D> {
    let bend = 1.9 * (std::f64::consts::PI * phase).sin() * (rest[D - 1] / 9.0).powi(2);
    let mut x = *rest;
    x[0] += bend * (4.5 - rest[0]).signum();
    (0..D).for_each(|axis| x[axis] += 0.04 * ((60.0 + axis as f64) * phase + any(node) * 7.0).sin());
    let (sine, cosine) = (2.0 * phase).sin_cos();
    let (a, b) = (x[0], x[D - 1]);
    x[0] = cosine * a - sine * b + 50.0 * phase;
    x[D - 1] = sine * a + cosine * b;
    x
}

/// Moves a horseshoe; returns the number of pairs in reach over all steps, and the greatest part of all nodes and facets
/// that was listed.
fn check_list<const D: usize>(steps: u32) -> (usize, f64) {
    let mesh = horseshoe::<D>(3.0, 3.0, 9.0);
    let surface = ContactSurface::new::<D>(mesh.rest.len(), mesh.facets.clone(), |_| (1.0, 1.0));
    let star = NodeIncidence::new(mesh.rest.len(), mesh.elements.iter().map(|nodes| &nodes[..=D]));
    let new_stars =
        || SurfaceStars::new(&surface, |node| star.of(node), |element| &mesh.elements[element.index()][..=D]);
    let stars = new_stars();
    let place = |phase: f64| mesh.rest.iter().enumerate().map(move |(i, x)| place_at(x, i, phase)).collect::<Vec<_>>();
    let mut nodes = PlacedNodes(place(0.0));
    let mut travel = vec![0.0; mesh.rest.len().div_ceil(TRAVEL_BATCH)];
    let at = SurfaceMotion { surface: &surface, travel: &travel, nodes: &nodes };
    let mut list = SeparationList::new(&at, new_stars());
    let (mut in_reach, mut most, mut time) = (0, 0.0_f64, 0.0);
    for step in 0..steps {
        let dt = (1.0 + 0.9 * any(step as usize)) / f64::from(steps);
        let next = place(time + dt);
        for (i, batch) in travel.iter_mut().enumerate() {
            let moved =
                next.iter().zip(&nodes.0).skip(i * TRAVEL_BATCH).take(TRAVEL_BATCH).map(|(next, now)| next - now);
            *batch += moved.map(|moved| moved.norm()).fold(0.0, f64::max) * (1.0 + 1e-9);
        }
        (nodes.0, time) = (next, time + dt);
        list.update(&SurfaceMotion { surface: &surface, travel: &travel, nodes: &nodes });
        let facing = facing_pairs(&surface, &stars, &nodes);
        in_reach += facing.len();
        for (node, facet) in facing {
            let is_listed = list.close().iter().any(|close| close.node == node && close.facet == facet);
            assert!(is_listed, "step {step}: {node:?} and {facet:?} are in reach of each other");
        }
        most = most.max(list.close().len() as f64 / (surface.nodes.len() * surface.facets.len()) as f64);
    }
    (in_reach, most)
}

#[test]
fn every_node_and_facet_that_face_each_other_in_reach_are_listed() {
    for (in_reach, listed) in [check_list::<2>(1000), check_list::<3>(300)] {
        assert!(in_reach > 500, "{in_reach} nodes and facets came into reach");
        assert!(listed < 0.2, "{listed} of all nodes and facets were listed");
    }
}
