//! How fine a mesh should be: from the bends of the fields on it, limited in range, and in growth.

use super::Moved;
use super::cell::edges;
use crate::algebra::{Tensor, Vector, cofactor, det, embed};
use crate::mesh::{self, ElementId, Incidence, NodeId, Simplex, neighbours};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::FRAC_PI_2;

/// What target sizes are limited to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Least size, m.
    pub least: f64,
    /// Greatest size, m.
    pub greatest: f64,
}

/// Target sizes of the nodes of which none is more than `growth` × distance above another, over the edges of the mesh.
///
/// # Panics
/// Unless there is one size per node, all positive.
#[must_use]
pub fn graded<const D: usize>(old: &Moved<'_, D>, mut size: Vec<f64>, growth: f64) -> Vec<f64> {
    assert_eq!(size.len(), old.position.len(), "one size per node is needed");
    assert!(size.iter().all(|h| *h > 0.0), "sizes are positive");
    let elements = &old.mesh.elements;
    let limit = |h: f64, a: usize, b: usize| h + growth * (old.position[a] - old.position[b]).norm();
    // Positive numbers have the order of their bits.
    let mut waiting: BinaryHeap<_> = too_great::<D>(elements, &size, limit).into_iter().map(Reverse).collect();
    if waiting.is_empty() {
        return size;
    }
    let around = Incidence::new(size.len(), elements.iter().map(|nodes| &nodes[..=D]));
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

/// The nodes that one at the other end of an edge is too great for, and the bits of their sizes.
fn too_great<const D: usize>(
    elements: &[Simplex],
    size: &[f64],
    limit: impl Fn(f64, usize, usize) -> f64,
) -> Vec<(u64, usize)> {
    let mut found = vec![false; size.len()];
    for nodes in elements {
        for edge in edges::<D>() {
            let [a, b] = edge.map(|corner| nodes[corner].index());
            let [less, more] = if size[a] < size[b] { [a, b] } else { [b, a] };
            if size[less] < size[more] && !found[less] {
                found[less] = limit(size[less], less, more) < size[more];
            }
        }
    }
    let found = found.iter().enumerate().filter(|(_, found)| **found);
    found.map(|(node, _)| (size[node].to_bits(), node)).collect()
}

/// How far nodal fields bend at each element, rad (numerics 4.3).
///
/// Over an element a component f of a field is a plane, in space a hyperplane, with normal (−s ∇f, 1), s = L/range(f), where L is the extent of the
/// body: without units. The bend is the greatest angle between its normal and that of a neighbour, of all components. A component
/// whose range is below 1e-9 of its magnitude is constant.
///
/// # Panics
/// Unless every field has one value per node.
#[must_use]
pub fn bends<const D: usize>(old: &Moved<'_, D>, fields: &[&[Vector<D>]]) -> Vec<f64> {
    bends_within(old, fields, (&neighbours::<D>(&old.mesh.elements), [0.0, FRAC_PI_2]))
}

/// The same with these neighbours, where only so much is asked for: of an element that bends by less than the first angle, rad, some
/// angle below that, and of one by more than the second, some angle above that.
///
/// # Panics
/// Unless every field has one value per node, and the angles are between 0 and π/2.
#[must_use]
pub fn bends_within<const D: usize>(
    old: &Moved<'_, D>,
    fields: &[&[Vector<D>]],
    (across, [least, most]): (&[[Option<ElementId>; 4]], [f64; 2]),
) -> Vec<f64> {
    assert!((0.0..=FRAC_PI_2).contains(&least) && (least..=FRAC_PI_2).contains(&most), "angles are acute");
    let mut bends = vec![Bend { angle: 0.0, tangent: square_of_tangent(least) * (1.0 - CLOSE) }; across.len()];
    let most = if most < FRAC_PI_2 { square_of_tangent(most) * (1.0 + CLOSE) } else { f64::INFINITY };
    for field in fields {
        assert_eq!(field.len(), old.position.len(), "one value per node is needed");
        raise(&mut bends, &slopes(old, field), (across, most));
    }
    bends.into_iter().map(|bend| bend.angle).collect()
}

/// How far an element bends.
#[derive(Clone, Copy)]
struct Bend {
    /// The greatest angle found, rad.
    angle: f64,
    /// tan² of it, or of the least that is asked for; infinite if it is not acute.
    tangent: f64,
}

/// Squares of tangents that are closer than this, as a part, may be those of either angle.
const CLOSE: f64 = 1e-9;

fn square_of_tangent(angle: f64) -> f64 {
    let tangent = libm::tan(angle);
    tangent * tangent
}

/// Target sizes of the nodes from the bends of the elements: h·clamp(θ*/θ, ½, 2), h being the mean edge and θ* = `angle`, rad; a
/// node takes the least of its elements.
///
/// # Panics
/// Unless there is one bend per element.
#[must_use]
pub fn curved<const D: usize>(old: &Moved<'_, D>, bends: &[f64], angle: f64, range: &Range) -> Vec<f64> {
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

/// Raises the bend of each element to the greatest angle between its normals and those of a neighbour, until its tan² is `most`; each
/// pair is seen once.
fn raise<const D: usize>(
    bends: &mut [Bend],
    slopes: &[[Vector<D>; D]],
    (across, most): (&[[Option<ElementId>; 4]], f64),
) {
    let steepest: Vec<f64> =
        slopes.iter().map(|slopes| slopes.iter().map(Vector::<D>::norm_squared).fold(0.0, f64::max)).collect();
    for (e, around) in across.iter().enumerate() {
        for other in around.iter().flatten().map(|other| other.index()).filter(|other| *other > e) {
            if is_flat(steepest[e].max(steepest[other]), bends[e].tangent.min(bends[other].tangent)) {
                continue;
            }
            for (a, b) in slopes[e].iter().zip(&slopes[other]) {
                let known = bends[e].tangent.min(bends[other].tangent);
                let (apart, along) = normals(a, b);
                if known > most || along > 0.0 && apart <= known * (along * along) * (1.0 - CLOSE) {
                    continue;
                }
                let angle = libm::atan2(apart.sqrt(), along);
                let tangent = if along > 0.0 { apart / (along * along) } else { f64::INFINITY };
                for bend in [e, other] {
                    let bend = &mut bends[bend];
                    *bend = Bend { angle: bend.angle.max(angle), tangent: bend.tangent.max(tangent) };
                }
            }
        }
    }
}

/// Whether no normals of graphs with at most this slope, squared, can have an angle whose tan² is more: |a − b|² ≤ 4|a|²,
/// |a × b|² ≤ |a|⁴ and a·b ≥ −|a|², if |a| ≥ |b|.
fn is_flat(steepest: f64, tangent: f64) -> bool {
    let along = 1.0 - steepest;
    along > 0.0 && steepest * (4.0 + steepest) <= tangent * (along * along) * (1.0 - CLOSE)
}

/// Of the normals (−a, 1) and (−b, 1) of two graphs what their angle θ follows from, tan²θ = apart/along²:
/// |a − b|² + |a × b|² and a·b + 1.
fn normals<const D: usize>(a: &Vector<D>, b: &Vector<D>) -> (f64, f64) {
    let apart = (a - b).norm_squared() + embed(a).cross(&embed(b)).norm_squared();
    (apart, a.dot(b) + 1.0)
}

/// s ∇f of the components of a field over each element; none over flat elements and of constant ones.
fn slopes<const D: usize>(old: &Moved<'_, D>, field: &[Vector<D>]) -> Vec<[Vector<D>; D]> {
    let ends = |values: &mut dyn Iterator<Item = f64>| {
        values.fold([f64::MAX, -f64::MAX], |[low, high], v| [low.min(v), high.max(v)])
    };
    let extent =
        (0..D).map(|i| ends(&mut old.position.iter().map(|x| x[i]))).map(|[low, high]| high - low).fold(0.0, f64::max);
    let scales: [f64; D] = std::array::from_fn(|component| {
        let [low, high] = ends(&mut field.iter().map(|v| v[component]));
        let is_constant = high - low <= 1e-9 * low.abs().max(high.abs());
        if is_constant { 0.0 } else { extent / (high - low) }
    });
    let slope = |simplex: &Simplex| {
        let sides: Tensor<D> = mesh::edges(old.position, simplex);
        let (cofactor, det) = (cofactor(&sides), det(&sides));
        let [first, others] = [&simplex[..1], &simplex[1..=D]];
        std::array::from_fn(|component| {
            let first = field[first[0].index()][component];
            let rise = Vector::<D>::from_fn(|i, _| field[others[i].index()][component] - first);
            let slope = cofactor * rise / det * scales[component];
            if slope.norm_squared().is_finite() { slope } else { Vector::zeros() }
        })
    };
    old.mesh.elements.iter().map(slope).collect()
}

#[cfg(test)]
mod tests {
    use super::super::samples;
    use super::super::shape::{Point, distance};
    use super::*;
    use crate::algebra::Vector3;
    use crate::mesh::{Grid, Mesh, NodeId, Split, uniform};

    #[test]
    fn sizes_grow_no_faster_than_asked_and_never_rise() {
        let mesh = samples::square(16);
        let old = Moved { mesh: &mesh, position: &mesh.rest };
        let corner = |x: &Point| if x.norm() < 1e-9 { 0.01 } else { 1.0 };
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
        let far = mesh.rest.iter().position(|x| *x == Point::new(1.0, 0.0)).unwrap();
        assert!((size[far] - 0.21).abs() < 1e-12);
    }

    #[test]
    fn a_bent_field_asks_for_small_elements_where_it_bends_in_any_unit() {
        let mesh = samples::square(16);
        let old = Moved { mesh: &mesh, position: &mesh.rest };
        let range = Range { least: 1e-3, greatest: 1.0 };
        let kink = |unit: f64| -> Vec<Point> {
            mesh.rest.iter().map(|x| Point::new(unit * (x[0] - 0.5).abs(), 0.0)).collect()
        };
        let size = curved(&old, &bends(&old, &[&kink(1.0)]), 0.2, &range);
        let edge = (1.0 + 2.0_f64.sqrt()) / 48.0;
        for (x, h) in mesh.rest.iter().zip(&size) {
            let away = (x[0] - 0.5).abs();
            let expected = if away < 0.04 { Some(0.5 * edge) } else { (away > 0.2).then_some(2.0 * edge) };
            assert!(expected.is_none_or(|expected| (h - expected).abs() < 1e-12), "{h} at {x}");
        }
        assert_eq!(size, curved(&old, &bends(&old, &[&kink(1024.0)]), 0.2, &range));
    }

    #[test]
    fn plane_fields_ask_for_nothing() {
        let mesh = samples::square(8);
        let old = Moved { mesh: &mesh, position: &mesh.rest };
        let field: Vec<Point> = mesh.rest.iter().map(|x| Point::new(3.0 * x[0] + x[1], 7.0)).collect();
        let range = Range { least: 1e-3, greatest: 0.05 };
        assert!(curved(&old, &bends(&old, &[&field]), 0.2, &range).iter().all(|h| *h == 0.05));
    }

    fn cube(n: usize) -> Mesh<3> {
        let axis = || uniform(0.0, 1.0, 1.0 / n as f64);
        let (points, elements) =
            Grid { planes: [axis(), axis(), axis()], filled: Box::new(|_| true) }.split(Split::Kuhn);
        Mesh::new(points, elements)
    }

    #[test]
    fn sizes_in_space_grow_no_faster_than_asked() {
        let mesh = cube(8);
        let old = Moved { mesh: &mesh, position: &mesh.rest };
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
        let old = Moved { mesh: &mesh, position: &mesh.rest };
        let range = Range { least: 1e-3, greatest: 1.0 };
        let field =
            |f: &dyn Fn(&Vector3) -> f64| -> Vec<Vector3> { mesh.rest.iter().map(|x| Vector3::y() * f(x)).collect() };
        let edge = (3.0 + 2.0 * 2.0_f64.sqrt() + 3.0_f64.sqrt()) / 48.0;
        let size = curved(&old, &bends(&old, &[&field(&|x| (x.z - 0.5).abs())]), 0.2, &range);
        for (x, h) in mesh.rest.iter().zip(&size) {
            let away = (x.z - 0.5).abs();
            let expected = if away < 0.07 { Some(0.5 * edge) } else { (away > 0.3).then_some(2.0 * edge) };
            assert!(expected.is_none_or(|expected| (h - expected).abs() < 1e-12), "{h} at {x}");
        }
        let plane = curved(&old, &bends(&old, &[&field(&|x| 3.0 * x.x + x.y - 2.0 * x.z)]), 0.2, &range);
        assert!(plane.iter().all(|h| (h - 2.0 * edge).abs() < 1e-12));
    }

    #[test]
    fn bends_are_the_greatest_angles_of_all_neighbours_however_steep_fields_are() {
        let mesh = cube(4);
        let old = Moved { mesh: &mesh, position: &mesh.rest };
        let across = neighbours::<3>(&mesh.elements);
        for steep in [1e-3, 0.1, 1.0, 20.0] {
            let wavy = |x: &Vector3| Vector3::new((9.0 * x.x).sin(), (7.0 * x.y * x.z).cos() + x.x, x.z * x.z * x.z);
            // One node far away leaves the others a small part of the range.
            let mut field: Vec<Vector3> = mesh.rest.iter().map(wavy).collect();
            field[7] = Vector3::repeat(10.0 / steep);
            let slopes = slopes(&old, &field);
            let angle = |e: usize, other: usize| {
                let angles = slopes[e].iter().zip(&slopes[other]).map(|(a, b)| normals(a, b));
                angles.map(|(apart, along)| libm::atan2(apart.sqrt(), along)).fold(0.0, f64::max)
            };
            let greatest = |(e, around): (usize, &[Option<ElementId>; 4])| {
                around
                    .iter()
                    .flatten()
                    .map(|other| angle(e.min(other.index()), e.max(other.index())))
                    .fold(0.0, f64::max)
            };
            let wanted: Vec<f64> = across.iter().enumerate().map(greatest).collect();
            assert_eq!(bends(&old, &[&field]), wanted);
            let within = bends_within(&old, &[&field], (&across, [0.2, 0.8]));
            for (found, wanted) in within.iter().zip(&wanted) {
                let holds = if *wanted < 0.2 { *found < 0.2 } else { found == wanted || found.min(*wanted) > 0.8 };
                assert!(holds, "{found} for {wanted}");
            }
        }
    }

    #[test]
    fn the_angle_between_graphs_is_that_of_their_normals() {
        let between = |(apart, along): (f64, f64)| libm::atan2(apart.sqrt(), along);
        let (a, b) = (Vector::<2>::new(0.3, -0.8), Vector::<2>::new(-1.1, 0.4));
        let [n, m] = [a, b].map(|a| Vector3::new(-a[0], -a[1], 1.0));
        assert!((between(normals(&a, &b)) - n.angle(&m)).abs() < 1e-14);
        // In space as in the plane, where both slopes lie in one.
        let [a, b] = [a, b].map(|a| Vector3::new(a[0], 0.0, a[1]));
        assert!((between(normals(&a, &b)) - n.angle(&m)).abs() < 1e-14);
    }
}
