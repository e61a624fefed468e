//! How well shaped elements are.

use super::Simplex;
use crate::algebra::{Vector, Vector3, cube_root, embed};

/// The least angle of a simplex, degrees: between two sides of a triangle, between two faces of a tetrahedron.
#[must_use]
pub fn least_angle<const D: usize>(x: &[Vector<D>], simplex: &Simplex) -> f64 {
    let corners: [Vector3; 4] = std::array::from_fn(|i| embed(&x[simplex[i % (D + 1)].index()]));
    let normals: [Vector3; 4] = std::array::from_fn(|i| outward::<D>(&corners, i));
    let pairs = (0..=D).flat_map(|i| (0..i).map(move |j| (i, j)));
    let angle = |(i, j): (usize, usize)| {
        let (n, m): (Vector3, Vector3) = (normals[i], normals[j]);
        n.cross(&m).norm().atan2(-n.dot(&m)).to_degrees()
    };
    pairs.map(angle).fold(180.0, f64::min)
}

/// How well shaped a simplex is: 4√3 A/Σ l² of a triangle, 12 (3V)^⅔/Σ l² of a tetrahedron; 1 of an equilateral one, and no more
/// than 0 of one that is inverted (numerics 4.1).
#[must_use]
pub fn shape_quality<const D: usize>(x: &[Vector<D>], simplex: &Simplex) -> f64 {
    let pairs = (0..=D).flat_map(|i| (0..i).map(move |j| (i, j)));
    let squares: f64 = pairs.map(|(i, j)| (x[simplex[i].index()] - x[simplex[j].index()]).norm_squared()).sum();
    let measure = super::signed_volume(x, simplex);
    if D == 2 {
        return 4.0 * 3.0_f64.sqrt() * measure / squares;
    }
    12.0 * cube_root(3.0 * measure.abs()).powi(2).copysign(measure) / squares
}

/// Outward normal of the side opposite corner `i`.
fn outward<const D: usize>(corners: &[Vector3; 4], i: usize) -> Vector3 {
    let [a, b, c] = [1, 2, 3].map(|k| corners[(i + k) % (D + 1)]);
    let across = if D == 2 { Vector3::y() } else { c - a };
    let normal = (b - a).cross(&across);
    if normal.dot(&(corners[i] - a)) > 0.0 { -normal } else { normal }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::NodeId;

    #[test]
    fn least_angles_of_known_simplices() {
        let ids = [0, 1, 2, 3].map(NodeId);
        let half = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(Vector::<2>::from);
        assert!((least_angle(&half, &ids) - 45.0).abs() < 1e-12);
        let regular = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]].map(Vector::<3>::from);
        assert!((least_angle(&regular, &ids) - (1.0_f64 / 3.0).acos().to_degrees()).abs() < 1e-12);
        let low = 1.0_f64.to_radians().tan() / 3.0_f64.sqrt();
        // The inscribed circle of the base has radius 1/√6; the apex stands over its middle.
        let apex = [1.0 / 3.0 + low / 6.0_f64.sqrt(); 3];
        let cap = [apex, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vector::<3>::from);
        assert!((least_angle(&cap, &ids) - 1.0).abs() < 1e-9);
    }
}
