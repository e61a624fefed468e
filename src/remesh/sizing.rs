//! Target sizes of a mesh: from the curvature of its fields, limited in range and in growth.

use super::DeformedMesh;
use super::barycentric::edges;
use crate::math::{CLOSE, Vector};
use crate::mesh::{NodeId, NodeIncidence, Simplex};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Range of target sizes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SizeRange {
    /// Least size, m.
    pub least: f64,
    /// Greatest size, m.
    pub greatest: f64,
}

/// Limits target sizes in growth: along the edges of the mesh, none exceeds another by more than `growth` × distance.
///
/// # Panics
/// Unless there is one size per node, all positive.
#[must_use]
pub fn graded<const D: usize>(old: &DeformedMesh<'_, D>, mut size: Vec<f64>, growth: f64) -> Vec<f64> {
    assert_eq!(size.len(), old.position.len(), "one size per node is needed");
    assert!(size.iter().all(|h| *h > 0.0), "sizes are positive");
    let elements = &old.mesh.elements;
    let limit = |h: f64, a: usize, b: usize| h + growth * (old.position[a] - old.position[b]).norm();
    // Positive floating-point numbers order like their bits.
    let mut waiting: BinaryHeap<_> = oversized_nodes(old, &size, growth).into_iter().map(Reverse).collect();
    if waiting.is_empty() {
        return size;
    }
    let around = NodeIncidence::new(size.len(), elements.iter().map(|nodes| &nodes[..=D]));
    while let Some(Reverse((bits, node))) = waiting.pop() {
        let h = f64::from_bits(bits);
        if h > size[node] {
            continue;
        }
        let star = around.of(NodeId(node as u32)).iter();
        for other in star.flat_map(|element| &elements[element.index()][..=D]).map(|other| other.index()) {
            if size[other] <= h {
                continue;
            }
            let limit = limit(h, node, other);
            if limit < size[other] {
                size[other] = limit;
                waiting.push(Reverse((limit.to_bits(), other)));
            }
        }
    }
    size
}

/// Nodes whose size an edge neighbour limits, with the bits of the neighbour's size. Clearly admissible edges need no
/// root.
fn oversized_nodes<const D: usize>(old: &DeformedMesh<'_, D>, size: &[f64], growth: f64) -> Vec<(u64, usize)> {
    let mut found = vec![false; size.len()];
    for nodes in &old.mesh.elements {
        for edge in edges::<D>() {
            let [a, b] = edge.map(|corner| nodes[corner].index());
            let [less, more] = if size[a] < size[b] { [a, b] } else { [b, a] };
            let apart = size[more] - size[less];
            if apart <= 0.0 || found[less] {
                continue;
            }
            let edge = old.position[less] - old.position[more];
            let is_clear = growth * growth * edge.norm_squared() > apart * apart * (1.0 + CLOSE);
            found[less] = !is_clear && size[less] + growth * edge.norm() < size[more];
        }
    }
    let found = found.iter().enumerate().filter(|(_, found)| **found);
    found.map(|(node, _)| (size[node].to_bits(), node)).collect()
}

/// Target sizes of the nodes from the bends of the elements: h·clamp(θ*/θ, ½, 2), with the mean edge h and θ* =
/// `angle`, rad. A node takes the least value of its elements.
///
/// # Panics
/// Unless there is one bend per element.
#[must_use]
pub fn sizes_from_curvature<const D: usize>(
    old: &DeformedMesh<'_, D>,
    bends: &[f64],
    angle: f64,
    range: &SizeRange,
) -> Vec<f64> {
    let elements = &old.mesh.elements;
    assert_eq!(bends.len(), elements.len(), "one bend per element is needed");
    let mut size = vec![range.greatest; old.position.len()];
    for (simplex, bend) in elements.iter().zip(bends) {
        let factor = if *bend > 0.0 { (angle / bend).clamp(0.5, 2.0) } else { 2.0 };
        let wanted = mean_edge(old.position, simplex) * factor;
        for node in &simplex[..=D] {
            size[node.index()] = size[node.index()].min(wanted);
        }
    }
    size.into_iter().map(|h| h.clamp(range.least, range.greatest)).collect()
}

fn mean_edge<const D: usize>(x: &[Vector<D>], simplex: &Simplex) -> f64 {
    let length = |[a, b]: &[usize; 2]| (x[simplex[*b].index()] - x[simplex[*a].index()]).norm();
    edges::<D>().iter().map(length).sum::<f64>() / edges::<D>().len() as f64
}

#[cfg(test)]
mod tests {
    use super::super::triangle::{PlanarPoint, distance};
    use super::super::{curvature_angles, test_meshes};
    use super::*;
    use crate::math::Vector3;
    use crate::mesh::{CellSplit, Mesh, NodeId, RectilinearGrid, uniform};

    #[test]
    fn sizes_grow_no_faster_than_asked_and_never_rise() {
        let mesh = test_meshes::square(16);
        let old = DeformedMesh { mesh: &mesh, position: &mesh.rest };
        let corner = |x: &PlanarPoint| if x.norm() < 1e-9 { 0.01 } else { 1.0 };
        let asked: Vec<f64> = mesh.rest.iter().map(corner).collect();
        let size = graded(&old, asked.clone(), 0.2);
        assert!(size.iter().zip(&asked).all(|(h, asked)| h <= asked));
        for e in &mesh.elements {
            for [a, b] in [[e[0], e[1]], [e[1], e[2]], [e[2], e[0]]].map(|side| side.map(NodeId::index)) {
                let most = 0.2 * distance(&mesh.rest[a], &mesh.rest[b]);
                assert!((size[a] - size[b]).abs() <= most * (1.0 + 1e-12));
            }
        }
        // Along the lower side the way over the edges is straight.
        let far = mesh.rest.iter().position(|x| *x == PlanarPoint::new(1.0, 0.0)).unwrap();
        assert!((size[far] - 0.21).abs() < 1e-12);
    }

    #[test]
    fn a_bent_field_asks_for_small_elements_where_it_bends_in_any_unit() {
        let mesh = test_meshes::square(16);
        let old = DeformedMesh { mesh: &mesh, position: &mesh.rest };
        let range = SizeRange { least: 1e-3, greatest: 1.0 };
        let kink = |unit: f64| -> Vec<PlanarPoint> {
            mesh.rest.iter().map(|x| PlanarPoint::new(unit * (x[0] - 0.5).abs(), 0.0)).collect()
        };
        let size = sizes_from_curvature(&old, &curvature_angles(&old, &[&kink(1.0)]), 0.2, &range);
        let edge = (1.0 + 2.0_f64.sqrt()) / 48.0;
        for (x, h) in mesh.rest.iter().zip(&size) {
            let away = (x[0] - 0.5).abs();
            let expected = if away < 0.04 { Some(0.5 * edge) } else { (away > 0.2).then_some(2.0 * edge) };
            assert!(expected.is_none_or(|expected| (h - expected).abs() < 1e-12), "{h} at {x}");
        }
        assert_eq!(size, sizes_from_curvature(&old, &curvature_angles(&old, &[&kink(1024.0)]), 0.2, &range));
    }

    #[test]
    fn plane_fields_ask_for_nothing() {
        let mesh = test_meshes::square(8);
        let old = DeformedMesh { mesh: &mesh, position: &mesh.rest };
        let field: Vec<PlanarPoint> = mesh.rest.iter().map(|x| PlanarPoint::new(3.0 * x[0] + x[1], 7.0)).collect();
        let range = SizeRange { least: 1e-3, greatest: 0.05 };
        assert!(sizes_from_curvature(&old, &curvature_angles(&old, &[&field]), 0.2, &range).iter().all(|h| *h == 0.05));
    }

    fn cube(n: usize) -> Mesh<3> {
        let axis = || uniform(0.0, 1.0, 1.0 / n as f64);
        let (points, elements) =
            RectilinearGrid { planes: [axis(), axis(), axis()], filled: Box::new(|_| true) }.split(CellSplit::Kuhn);
        Mesh::new(points, elements)
    }

    #[test]
    fn sizes_in_space_grow_no_faster_than_asked() {
        let mesh = cube(8);
        let old = DeformedMesh { mesh: &mesh, position: &mesh.rest };
        let asked = mesh.rest.iter().map(|x| if x.norm() < 1e-9 { 0.01 } else { 1.0 }).collect();
        let size = graded(&old, asked, 0.2);
        for (e, [a, b]) in mesh.elements.iter().flat_map(|e| edges::<3>().iter().map(move |edge| (e, edge))) {
            let [a, b] = [a, b].map(|corner| e[*corner].index());
            let most = 0.2 * (mesh.rest[a] - mesh.rest[b]).norm();
            assert!((size[a] - size[b]).abs() <= most * (1.0 + 1e-12));
        }
        // Along the edges and the diagonals of Kuhn the way is straight.
        for far in [Vector3::x(), Vector3::new(0.0, 1.0, 1.0), Vector3::repeat(1.0)] {
            let node = mesh.rest.iter().position(|x| *x == far).unwrap();
            assert!((size[node] - 0.01 - 0.2 * far.norm()).abs() < 1e-12);
        }
    }

    #[test]
    fn a_bent_field_of_space_asks_for_small_elements_where_it_bends_and_a_plane_one_for_nothing() {
        let mesh = cube(8);
        let old = DeformedMesh { mesh: &mesh, position: &mesh.rest };
        let range = SizeRange { least: 1e-3, greatest: 1.0 };
        let field =
            |f: &dyn Fn(&Vector3) -> f64| -> Vec<Vector3> { mesh.rest.iter().map(|x| Vector3::y() * f(x)).collect() };
        let edge = (3.0 + 2.0 * 2.0_f64.sqrt() + 3.0_f64.sqrt()) / 48.0;
        let size = sizes_from_curvature(&old, &curvature_angles(&old, &[&field(&|x| (x.z - 0.5).abs())]), 0.2, &range);
        for (x, h) in mesh.rest.iter().zip(&size) {
            let away = (x.z - 0.5).abs();
            let expected = if away < 0.07 { Some(0.5 * edge) } else { (away > 0.3).then_some(2.0 * edge) };
            assert!(expected.is_none_or(|expected| (h - expected).abs() < 1e-12), "{h} at {x}");
        }
        let plane = sizes_from_curvature(
            &old,
            &curvature_angles(&old, &[&field(&|x| 3.0 * x.x + x.y - 2.0 * x.z)]),
            0.2,
            &range,
        );
        assert!(plane.iter().all(|h| (h - 2.0 * edge).abs() < 1e-12));
    }
}
