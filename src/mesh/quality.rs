//! How well shaped elements are.

use super::Simplex;
use crate::algebra::{CLOSE, Vector, Vector3, cube_root, embed};

/// The least angle of a simplex, degrees: between two sides of a triangle, between two faces of a tetrahedron.
#[must_use]
pub fn least_angle<const D: usize>(x: &[Vector<D>], simplex: &Simplex) -> f64 {
    let normals = normals(x, simplex);
    let pairs = (0..=D).flat_map(|i| (0..i).map(move |j| (i, j)));
    let angle = |(i, j): (usize, usize)| {
        let (n, m): (Vector3, Vector3) = (normals[i], normals[j]);
        n.cross(&m).norm().atan2(-n.dot(&m)).to_degrees()
    };
    pairs.map(angle).fold(180.0, f64::min)
}

/// The least angle of all these simplices, degrees; 180 of none. An angle is looked at closely where its tangent may be less than
/// that of the least so far.
#[must_use]
pub fn least_of<const D: usize>(x: &[Vector<D>], simplices: &[Simplex]) -> f64 {
    let (mut least, mut tangent) = (180.0_f64, f64::INFINITY);
    for simplex in simplices {
        let normals = normals(x, simplex);
        let squares = normals.map(|normal| normal.norm_squared());
        for (i, j) in (0..=D).flat_map(|i| (0..i).map(move |j| (i, j))) {
            let along = -normals[i].dot(&normals[j]);
            // |n × m|² = |n|²|m|² − (n·m)², where rounding leaves so much of it.
            let (both, bound) = (squares[i] * squares[j], along * along * (1.0 + tangent * (1.0 + CLOSE)));
            if both * (1.0 - CLOSE) > bound || along <= 0.0 && tangent < f64::INFINITY {
                continue;
            }
            let across = normals[i].cross(&normals[j]);
            let square = across.norm_squared();
            least = least.min(across.norm().atan2(along).to_degrees());
            if along > 0.0 {
                tangent = tangent.min(square / (along * along));
            }
        }
    }
    least
}

/// How well shaped a simplex is: 4√3 A/Σ l² of a triangle, 12 (3V)^⅔/Σ l² of a tetrahedron; 1 of an equilateral one, and no more
/// than 0 of one that is inverted (numerics 4.1).
#[must_use]
pub fn shape_quality<const D: usize>(x: &[Vector<D>], simplex: &Simplex) -> f64 {
    let (squares, measure) = extent(x, simplex);
    if D == 2 {
        return 4.0 * 3.0_f64.sqrt() * measure / squares;
    }
    12.0 * cube_root(3.0 * measure.abs()).powi(2).copysign(measure) / squares
}

/// Whether the quality of a simplex is less than that. What is clearly better is known without a root.
#[must_use]
pub fn is_worse<const D: usize>(x: &[Vector<D>], simplex: &Simplex, than: f64) -> bool {
    !(D == 3 && is_clearly_better(x, simplex, than)) && shape_quality(x, simplex) < than
}

/// The quality of a simplex, or if it is clearly better than `fair`, infinity.
#[must_use]
pub fn poor_quality<const D: usize>(x: &[Vector<D>], simplex: &Simplex, fair: f64) -> f64 {
    let is_fair = D == 3 && is_clearly_better(x, simplex, fair);
    if is_fair { f64::INFINITY } else { shape_quality(x, simplex) }
}

/// Whether the cube of the quality of a tetrahedron, 12³ · 9 V|V|/(Σ l²)³, is above that of another quality by more than rounding.
fn is_clearly_better<const D: usize>(x: &[Vector<D>], simplex: &Simplex, than: f64) -> bool {
    let (squares, volume) = extent(x, simplex);
    let cube = than * than * than;
    15_552.0 * volume * volume.abs() > (cube + CLOSE * cube.abs()) * (squares * squares * squares)
}

/// Σ l² and area or volume of a simplex.
fn extent<const D: usize>(x: &[Vector<D>], simplex: &Simplex) -> (f64, f64) {
    let pairs = (0..=D).flat_map(|i| (0..i).map(move |j| (i, j)));
    let squares = pairs.map(|(i, j)| (x[simplex[i].index()] - x[simplex[j].index()]).norm_squared()).sum();
    (squares, super::signed_volume(x, simplex))
}

/// Outward normals of the sides opposite each corner.
fn normals<const D: usize>(x: &[Vector<D>], simplex: &Simplex) -> [Vector3; 4] {
    let corners: [Vector3; 4] = std::array::from_fn(|i| embed(&x[simplex[i % (D + 1)].index()]));
    std::array::from_fn(|i| outward::<D>(&corners, i))
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
