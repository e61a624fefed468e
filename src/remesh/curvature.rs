//! Curvature indicator: the angle by which nodal fields bend from element to element.
//!
//! The components of two fields are processed side by side, eight numbers at a time, in loops for the widest vector
//! unit of the machine.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "numbers side by side, as in the equations")]

use super::DeformedMesh;
use crate::math::{CLOSE, Tensor, Vector, cofactor, det};
use crate::mesh::{self, ElementId, Simplex, face_neighbours};
use fearless_simd::{Level, dispatch};
use std::f64::consts::FRAC_PI_2;

/// Lanes: one number for each component of two fields.
const WIDE: usize = 8;
type ComponentLanes = [f64; WIDE];
/// Scaled gradients s ∇f of the components of two fields over an element: row i holds the i-th component of each
/// gradient; 0 where there is no component.
type ElementSlopes<const D: usize> = [ComponentLanes; D];

/// Computes the bend angle of nodal fields at each element, rad (method 4.3).
///
/// Over an element a field component f is a plane, in space a hyperplane, with normal (−s ∇f, 1). The scale s =
/// L/range(f), with the extent L of the body, makes it dimensionless. The bend is the greatest angle to the normal of a
/// neighbour, over all components. A component whose range is below 1e-9 of its magnitude is constant.
///
/// # Panics
/// Unless every field has one value per node.
#[must_use]
pub fn curvature_angles<const D: usize>(old: &DeformedMesh<'_, D>, fields: &[&[Vector<D>]]) -> Vec<f64> {
    curvature_angles_within(old, fields, (&face_neighbours::<D>(&old.mesh.elements), [0.0, FRAC_PI_2]))
}

/// Computes the bend angles with known neighbours and only within an interval of interest. An element below the first
/// angle, rad, gets some angle below it; an element above the second gets some angle above it.
///
/// # Panics
/// Unless every field has one value per node, and the angles are between 0 and π/2.
#[must_use]
pub fn curvature_angles_within<const D: usize>(
    old: &DeformedMesh<'_, D>,
    fields: &[&[Vector<D>]],
    (across, [least, most]): (&[[Option<ElementId>; 4]], [f64; 2]),
) -> Vec<f64> {
    assert!((0.0..=FRAC_PI_2).contains(&least) && (least..=FRAC_PI_2).contains(&most), "angles are acute");
    let mut bends = vec![ElementBend { angle: 0.0, tangent: square_of_tangent(least) * (1.0 - CLOSE) }; across.len()];
    let most = if most < FRAC_PI_2 { square_of_tangent(most) * (1.0 + CLOSE) } else { f64::INFINITY };
    for pair in fields.chunks(2) {
        assert!(pair.iter().all(|field| field.len() == old.position.len()), "one value per node is needed");
        let slopes = slopes(old, pair);
        dispatch!(Level::new(), _simd => raise(&mut bends, &slopes, (across, most)));
    }
    bends.into_iter().map(|bend| bend.angle).collect()
}

/// Bend of an element found so far.
#[derive(Clone, Copy)]
struct ElementBend {
    /// Greatest angle so far, rad.
    angle: f64,
    /// tan² of the angle, or of the least angle of interest; infinite if the angle is not acute.
    tangent: f64,
}

fn square_of_tangent(angle: f64) -> f64 {
    let tangent = libm::tan(angle);
    tangent * tangent
}

/// Raises the bend of each element to the greatest angle to a neighbour's normals, until its tan² is `most`; each pair
/// is visited once.
#[inline(always)]
fn raise<const D: usize>(
    bends: &mut [ElementBend],
    slopes: &[ElementSlopes<D>],
    (across, most): (&[[Option<ElementId>; 4]], f64),
) {
    let steepest: Vec<f64> = slopes.iter().map(|slopes| squares(slopes).into_iter().fold(0.0, f64::max)).collect();
    for (e, around) in across.iter().enumerate() {
        for other in around.iter().flatten().map(|other| other.index()).filter(|other| *other > e) {
            let known = bends[e].tangent.min(bends[other].tangent);
            if known > most || is_flat(steepest[e].max(steepest[other]), known) {
                continue;
            }
            let (apart, along) = normals(&slopes[e], &slopes[other]);
            if is_known(known, (&apart, &along)) {
                continue;
            }
            for found in apart.into_iter().zip(along) {
                note(bends, [e, other], found);
            }
        }
    }
}

/// Records the angle between the normals of two elements, unless it is clearly below the bends of both.
fn note(bends: &mut [ElementBend], pair: [usize; 2], (apart, along): (f64, f64)) {
    let known = bends[pair[0]].tangent.min(bends[pair[1]].tangent);
    if along > 0.0 && apart <= known * (along * along) * (1.0 - CLOSE) {
        return;
    }
    let angle = libm::atan2(apart.sqrt(), along);
    let tangent = if along > 0.0 { apart / (along * along) } else { f64::INFINITY };
    for element in pair {
        let bend = &mut bends[element];
        *bend = ElementBend { angle: bend.angle.max(angle), tangent: bend.tangent.max(tangent) };
    }
}

/// Returns true if two normals of graphs with at most this squared slope cannot enclose an angle of greater tan². For
/// |a| ≥ |b|: |a − b|² ≤ 4|a|², |a × b|² ≤ |a|⁴ and a·b ≥ −|a|².
#[inline(always)]
fn is_flat(steepest: f64, tangent: f64) -> bool {
    let along = 1.0 - steepest;
    along > 0.0 && steepest * (4.0 + steepest) <= tangent * (along * along) * (1.0 - CLOSE)
}

/// Returns true if no angle has a tan² above `tangent`.
#[inline(always)]
fn is_known(tangent: f64, (apart, along): (&ComponentLanes, &ComponentLanes)) -> bool {
    let mut known = true;
    for k in 0..WIDE {
        known &= along[k] > 0.0 && apart[k] <= tangent * (along[k] * along[k]) * (1.0 - CLOSE);
    }
    known
}

/// Terms of the angle θ between the normals (−a, 1) and (−b, 1) of two graphs, tan²θ = apart/along²: |a − b|² + |a ×
/// b|² and a·b + 1, for each component.
#[inline(always)]
fn normals<const D: usize>(a: &ElementSlopes<D>, b: &ElementSlopes<D>) -> (ComponentLanes, ComponentLanes) {
    let mut away = [[0.0; WIDE]; D];
    let mut along = [0.0; WIDE];
    for i in 0..D {
        for k in 0..WIDE {
            away[i][k] = a[i][k] - b[i][k];
            along[k] += a[i][k] * b[i][k];
        }
    }
    let mut apart = squares(&away);
    let mut turned = [0.0; WIDE];
    let pairs: &[(usize, usize)] = if D == 3 { &[(1, 2), (2, 0), (0, 1)] } else { &[(1, 0)] };
    for (i, j) in pairs {
        for k in 0..WIDE {
            let cross = a[*i][k] * b[*j][k] - a[*j][k] * b[*i][k];
            turned[k] += cross * cross;
        }
    }
    for k in 0..WIDE {
        apart[k] += turned[k];
        along[k] += 1.0;
    }
    (apart, along)
}

/// Sum over the rows of their squares.
#[inline(always)]
fn squares<const D: usize>(rows: &ElementSlopes<D>) -> ComponentLanes {
    let mut sums = [0.0; WIDE];
    for row in rows {
        for k in 0..WIDE {
            sums[k] += row[k] * row[k];
        }
    }
    sums
}

/// Scaled gradients s ∇f of the components of one or two fields over each element; zero for degenerate elements and
/// constant components.
fn slopes<const D: usize>(old: &DeformedMesh<'_, D>, fields: &[&[Vector<D>]]) -> Vec<ElementSlopes<D>> {
    let ends = |values: &mut dyn Iterator<Item = f64>| {
        values.fold([f64::MAX, -f64::MAX], |[low, high], v| [low.min(v), high.max(v)])
    };
    let extent =
        (0..D).map(|i| ends(&mut old.position.iter().map(|x| x[i]))).map(|[low, high]| high - low).fold(0.0, f64::max);
    let mut scales = [0.0; WIDE];
    for (k, scale) in scales[..fields.len() * D].iter_mut().enumerate() {
        let [low, high] = ends(&mut fields[k / D].iter().map(|v| v[k % D]));
        let is_constant = high - low <= 1e-9 * low.abs().max(high.abs());
        *scale = if is_constant { 0.0 } else { extent / (high - low) };
    }
    let mut values = vec![[0.0; WIDE]; old.position.len()];
    for (field, first) in fields.iter().zip([0, D]) {
        for (all, own) in values.iter_mut().zip(*field) {
            all[first..first + D].copy_from_slice(own.as_slice());
        }
    }
    dispatch!(Level::new(), _simd => sloped(old, &values, &scales))
}

/// Scaled gradients from nodal values and the scale of each component.
#[inline(always)]
fn sloped<const D: usize>(
    old: &DeformedMesh<'_, D>,
    values: &[ComponentLanes],
    scales: &ComponentLanes,
) -> Vec<ElementSlopes<D>> {
    let mut all = Vec::with_capacity(old.mesh.elements.len());
    for nodes in &old.mesh.elements {
        all.push(slope((&mesh::edges(old.position, nodes), nodes), values, scales));
    }
    all
}

/// Scaled gradient of one element with these edges.
#[inline(always)]
fn slope<const D: usize>(
    (sides, nodes): (&Tensor<D>, &Simplex),
    values: &[ComponentLanes],
    scales: &ComponentLanes,
) -> ElementSlopes<D> {
    let (cofactor, det) = (cofactor(sides), det(sides));
    let first = &values[nodes[0].index()];
    let mut slopes = [[0.0; WIDE]; D];
    for j in 0..D {
        let other = &values[nodes[j + 1].index()];
        for i in 0..D {
            for k in 0..WIDE {
                slopes[i][k] += cofactor[(i, j)] * (other[k] - first[k]);
            }
        }
    }
    for row in &mut slopes {
        for k in 0..WIDE {
            row[k] = row[k] / det * scales[k];
        }
    }
    let squares = squares(&slopes);
    for row in &mut slopes {
        for k in 0..WIDE {
            row[k] = if squares[k].is_finite() { row[k] } else { 0.0 };
        }
    }
    slopes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Vector3, embed};
    use crate::mesh::{CellSplit, Mesh, RectilinearGrid, uniform};

    /// Angle between the normals of each component, rad.
    fn between<const D: usize>(a: &ElementSlopes<D>, b: &ElementSlopes<D>) -> [f64; WIDE] {
        let (apart, along) = normals(a, b);
        std::array::from_fn(|k| libm::atan2(apart[k].sqrt(), along[k]))
    }

    #[test]
    fn bends_are_the_greatest_angles_of_all_neighbours_however_steep_fields_are() {
        let axis = || uniform(0.0, 1.0, 0.25);
        let (points, elements) =
            RectilinearGrid { planes: [axis(), axis(), axis()], filled: Box::new(|_| true) }.split(CellSplit::Kuhn);
        let mesh = Mesh::new(points, elements);
        let old = DeformedMesh { mesh: &mesh, position: &mesh.rest };
        let across = face_neighbours::<3>(&mesh.elements);
        for steep in [1e-3, 0.1, 1.0, 20.0] {
            let wavy = |x: &Vector3| Vector3::new((9.0 * x.x).sin(), (7.0 * x.y * x.z).cos() + x.x, x.z * x.z * x.z);
            // One distant node reduces the others to a small part of the range.
            let mut field: Vec<Vector3> = mesh.rest.iter().map(wavy).collect();
            field[7] = Vector3::repeat(10.0 / steep);
            let slopes = slopes(&old, &[&field]);
            let angle = |e: usize, other: usize| between(&slopes[e], &slopes[other]).into_iter().fold(0.0, f64::max);
            let greatest = |(e, around): (usize, &[Option<ElementId>; 4])| {
                around
                    .iter()
                    .flatten()
                    .map(|other| angle(e.min(other.index()), e.max(other.index())))
                    .fold(0.0, f64::max)
            };
            let wanted: Vec<f64> = across.iter().enumerate().map(greatest).collect();
            assert_eq!(curvature_angles(&old, &[&field]), wanted);
            let within = curvature_angles_within(&old, &[&field], (&across, [0.2, 0.8]));
            for (found, wanted) in within.iter().zip(&wanted) {
                let holds = if *wanted < 0.2 { *found < 0.2 } else { found == wanted || found.min(*wanted) > 0.8 };
                assert!(holds, "{found} for {wanted}");
            }
        }
    }

    #[test]
    fn the_angle_between_graphs_is_that_of_their_normals() {
        let (a, b) = (Vector::<2>::new(0.3, -0.8), Vector::<2>::new(-1.1, 0.4));
        let [n, m] = [a, b].map(|a| Vector3::new(-a[0], -a[1], 1.0));
        let [flat, other] = [a, b].map(|a| [[a[0]; WIDE], [a[1]; WIDE]]);
        assert!((between(&flat, &other)[0] - n.angle(&m)).abs() < 1e-14);
        // In space the angle is the same if both slopes lie in one plane.
        let [a, b] = [a, b].map(|a| embed(&a)).map(|a| [[a.x; WIDE], [a.y; WIDE], [a.z; WIDE]]);
        assert!((between(&a, &b)[3] - n.angle(&m)).abs() < 1e-14);
    }

    #[test]
    fn two_fields_bend_as_far_as_the_one_that_bends_more() {
        let axis = || uniform(0.0, 1.0, 0.25);
        let (points, elements) =
            RectilinearGrid { planes: [axis(), axis(), axis()], filled: Box::new(|_| true) }.split(CellSplit::Centred);
        let mesh = Mesh::new(points, elements);
        let old = DeformedMesh { mesh: &mesh, position: &mesh.rest };
        let field =
            |f: &dyn Fn(&Vector3) -> f64| -> Vec<Vector3> { mesh.rest.iter().map(|x| Vector3::y() * f(x)).collect() };
        let (one, other) = (field(&|x| (3.0 * x.x).sin() * x.z), field(&|x| (5.0 * x.y).cos() + x.x));
        let [alone, beside, both] =
            [&[&one[..]][..], &[&other], &[&one, &other]].map(|fields| curvature_angles(&old, fields));
        let greater: Vec<f64> = alone.iter().zip(&beside).map(|(a, b)| a.max(*b)).collect();
        assert_eq!(both, greater);
    }
}
