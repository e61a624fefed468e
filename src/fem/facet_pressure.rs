//! Follower pressure on a facet: consistent nodal forces.

use super::Section;
use crate::math::{Vector, embed, restrict};

/// Nodal forces of a pressure of 1 Pa on a facet, and the bound of their stiffness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacetPressure<const D: usize> {
    /// Force on each node, N; zero for the third node of an edge in the plane.
    pub forces: [Vector<D>; 3],
    /// Bound κ of the norm of the force derivative, N/m.
    pub stiffness: f64,
}

/// Computes the forces of a pressure of 1 Pa on an outward oriented facet: f_a = −∫ N_a n dA over the deformed facet.
///
/// The forces are −∂v/∂x_a of the enclosed volume v, up to boundary terms. These cancel between neighbours, on an
/// axis, and where the boundary of a loaded face is held along its normal. There p v is a potential; elsewhere the
/// pressure is a follower load. n dA = (Δz, −Δx) ds in the plane, times the thickness, or times 2πr about an axis,
/// and ½ (x₁ − x₀) × (x₂ − x₀) in space. Hence f_a = −½ t (Δz, −Δx); f_a = −π (Δz, −Δr) (2 r_a + r_b)/3; f_a = −⅙ (x₁
/// − x₀) × (x₂ − x₀).
///
/// κ bounds |δf| ≤ κ |δx| over all nodes of the facet: |(Δz, −Δx)| changes by √2 |δx| at most, the mean radius by
/// √5/3 |δx|, the product by |δx| times the root of the sum of the squared edges.
#[must_use]
pub fn push<const D: usize>(section: Section, corners: &[Vector<D>; 3]) -> FacetPressure<D> {
    match section {
        Section::Planar { thickness } => {
            let side = -edge_normal(corners) * (0.5 * thickness);
            FacetPressure { forces: [side, side, Vector::zeros()], stiffness: thickness }
        }
        Section::Axisymmetric => {
            let (side, [a, b, _]) = (-edge_normal(corners) * std::f64::consts::PI, *corners);
            let radii = [2.0 * a[0] + b[0], a[0] + 2.0 * b[0]].map(|radius| radius / 3.0);
            let (length, most) = ((b - a).norm(), radii[0].abs().max(radii[1].abs()));
            let stiffness = std::f64::consts::PI * (10.0_f64.sqrt() / 3.0 * length + 2.0 * most);
            FacetPressure { forces: [side * radii[0], side * radii[1], Vector::zeros()], stiffness }
        }
        Section::Spatial => {
            let [u, v] = [1, 2].map(|k| embed(&(corners[k] - corners[0])));
            let force = restrict::<D>(&(u.cross(&v) / -6.0));
            let edges = u.norm_squared() + v.norm_squared() + (v - u).norm_squared();
            FacetPressure { forces: [force; 3], stiffness: (3.0 * edges).sqrt() / 6.0 }
        }
    }
}

/// Returns the outward normal of an edge times its length, the body on its left.
fn edge_normal<const D: usize>(corners: &[Vector<D>; 3]) -> Vector<D> {
    let along = corners[1] - corners[0];
    Vector::<D>::from_fn(|i, _| if i == 0 { along[1] } else { -along[0] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vector3;

    const AXIS: [Section; 2] = [Section::Planar { thickness: 0.3 }, Section::Axisymmetric];

    /// Returns a closed polygon in the right half plane, or about the axis.
    fn polygon() -> Vec<Vector<2>> {
        [[0.0, -1.0], [1.1, -0.9], [1.4, 0.2], [0.6, 0.9], [0.0, 0.7]].map(|[r, z]| Vector::<2>::new(r, z)).into()
    }

    /// Returns the area times thickness, or the volume of revolution: Σ ½ t (x₀z₁ − x₁z₀), Σ π Δz (r₀² + r₀r₁ + r₁²)/3.
    fn volume(section: Section, x: &[Vector<2>]) -> f64 {
        let edge = |i: usize| [x[i], x[(i + 1) % x.len()]];
        let part = |[a, b]: [Vector<2>; 2]| match section {
            Section::Planar { thickness } => 0.5 * thickness * (a[0] * b[1] - b[0] * a[1]),
            _ => std::f64::consts::PI * (b[1] - a[1]) * (a[0] * a[0] + a[0] * b[0] + b[0] * b[0]) / 3.0,
        };
        (0..x.len()).map(|i| part(edge(i))).sum()
    }

    #[test]
    fn forces_on_a_closed_line_are_the_derivative_of_its_area() {
        for section in AXIS {
            let x = polygon();
            let mut forces = vec![Vector::<2>::zeros(); x.len()];
            for i in 0..x.len() {
                let j = (i + 1) % x.len();
                let push = push(section, &[x[i], x[j], x[j]]);
                forces[i] += push.forces[0];
                forces[j] += push.forces[1];
            }
            for (node, axis) in (0..x.len()).flat_map(|node| [(node, 0), (node, 1)]) {
                // On the axis nodes stay there.
                if section == Section::Axisymmetric && axis == 0 && x[node][0] == 0.0 {
                    continue;
                }
                let at = |step: f64| {
                    let mut moved = x.clone();
                    moved[node][axis] += step;
                    volume(section, &moved)
                };
                let slope = (at(1e-6) - at(-1e-6)) / 2e-6;
                assert!((forces[node][axis] + slope).abs() < 1e-8, "{section:?} {node} {axis}");
            }
        }
    }

    #[test]
    fn forces_on_a_closed_surface_are_the_derivative_of_its_volume() {
        let x = [[0.1, 0.0, 0.0], [1.0, 0.1, -0.2], [0.2, 1.2, 0.1], [0.0, 0.3, 0.9]].map(Vector3::from);
        let mut forces = [Vector3::zeros(); 4];
        for face in crate::mesh::FACES {
            let push = push(Section::Spatial, &face.map(|corner| x[corner]));
            face.iter().zip(push.forces).for_each(|(corner, force)| forces[*corner] += force);
        }
        for (node, axis) in (0..4).flat_map(|node| (0..3).map(move |axis| (node, axis))) {
            let at = |step: f64| {
                let mut y = x;
                y[node][axis] += step;
                (y[1] - y[0]).cross(&(y[2] - y[0])).dot(&(y[3] - y[0])) / 6.0
            };
            let slope = (at(1e-6) - at(-1e-6)) / 2e-6;
            assert!((forces[node][axis] + slope).abs() < 1e-9, "{node} {axis}");
        }
    }

    #[test]
    fn the_stiffness_bounds_the_change_of_the_forces() {
        fn ratio<const D: usize>(
            section: Section,
            corners: [Vector<D>; 3],
            moved: impl Fn(usize, usize) -> f64,
        ) -> f64 {
            let n = if D == 2 { 2 } else { 3 };
            let mut other = corners;
            (0..n).for_each(|k| other[k] += Vector::<D>::from_fn(|i, _| 1e-7 * moved(k, i)));
            let [before, after] = [&corners, &other].map(|corners| push(section, corners));
            let change = |k: usize| (after.forces[k] - before.forces[k]).norm_squared();
            let way = |k: usize| (other[k] - corners[k]).norm_squared();
            let [change, way]: [f64; 2] = [(0..n).map(change).sum(), (0..n).map(way).sum()];
            (change / way).sqrt() / before.stiffness
        }
        let mut most = [0.0_f64; 3];
        for seed in 0..2000 {
            let wave = |k: usize, i: usize| ((seed * 7 + k * 3 + i) as f64 * 1.7).sin();
            let flat = [[0.4, 0.1], [0.7, 0.5], [0.7, 0.5]].map(|x| Vector::<2>::new(x[0], x[1]));
            most[0] = most[0].max(ratio(AXIS[0], flat, wave));
            most[1] = most[1].max(ratio(AXIS[1], flat, wave));
            let solid = [[0.1, 0.0, 0.0], [1.0, 0.1, -0.2], [0.2, 1.2, 0.1]].map(Vector3::from);
            most[2] = most[2].max(ratio(Section::Spatial, solid, wave));
        }
        assert!(most.iter().all(|ratio| (0.3..1.0).contains(ratio)), "{most:?}");
    }
}
