//! Shape quality of elements, and a bound on how far their nodes may travel before it degrades.

use super::Simplex;
use crate::math::{CLOSE, Vector, Vector3, cube_root, embed};

/// Least angle of a simplex, degrees: between two sides of a triangle, between two faces of a tetrahedron.
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

/// Mean-ratio quality of a simplex: 4√3 A/Σ l² of a triangle, 12 (3V)^⅔/Σ l² of a tetrahedron. An equilateral simplex
/// has 1, an inverted one 0 or less (method 4.1).
#[must_use]
pub fn shape_quality<const D: usize>(x: &[Vector<D>], simplex: &Simplex) -> f64 {
    let (squares, measure) = squares_and_measure(x, simplex);
    if D == 2 {
        return 4.0 * 3.0_f64.sqrt() * measure / squares;
    }
    12.0 * cube_root(3.0 * measure.abs()).powi(2).copysign(measure) / squares
}

/// Returns true if the shape quality of a simplex is less than `than`. A clearly better tetrahedron needs no cube root.
#[must_use]
pub fn is_worse<const D: usize>(x: &[Vector<D>], simplex: &Simplex, than: f64) -> bool {
    !(D == 3 && is_clearly_better(x, simplex, than)) && shape_quality(x, simplex) < than
}

/// Shape quality of a simplex, or infinity if it is clearly better than `fair`.
#[must_use]
pub fn poor_quality<const D: usize>(x: &[Vector<D>], simplex: &Simplex, fair: f64) -> f64 {
    let is_fair = D == 3 && is_clearly_better(x, simplex, fair);
    if is_fair { f64::INFINITY } else { shape_quality(x, simplex) }
}

/// Returns true if the cubed quality of a tetrahedron, 12³ · 9 V|V|/(Σ l²)³, exceeds `than`³ by more than rounding.
fn is_clearly_better<const D: usize>(x: &[Vector<D>], simplex: &Simplex, than: f64) -> bool {
    let (squares, volume) = squares_and_measure(x, simplex);
    let cube = than * than * than;
    15_552.0 * volume * volume.abs() > (cube + CLOSE * cube.abs()) * (squares * squares * squares)
}

/// Travel bound of a simplex: the distance, m, that each node may move before quality or measure can fall below its
/// limit. The limits are the quality `than` and the part `least` of the present measure, both clamped to 0 or more. The
/// measure of a ring includes its mean radius `radius`; elsewhere pass infinity. An inverted simplex has the bound 0.
///
/// Let S² = Σ l² = (D + 1) Σ |x − c|² with the centroid c. If nodes move by δ, S grows by at most (D + 1) δ. In the
/// plane the measure falls by half the sum of the sides, at most S √3/2 δ. In space it falls by a third of the sum of
/// the faces, at most S²/(6√3) δ (Weitzenböck's inequality). With δ limited to S/20, the greatest S reachable makes
/// this bound linear in δ. The measure that a quality requires, c S^D, is convex in δ: its steepest slope bounds it by
/// a line.
#[must_use]
pub fn travel_bound<const D: usize>(x: &[Vector<D>], simplex: &Simplex, (than, least): (f64, f64), radius: f64) -> f64 {
    /// Greatest travel, in S, and the safety factor and absolute rounding allowance, in S, of the result.
    const FARTHEST: f64 = 0.05;
    const SAFE: f64 = 0.999;
    const ROUNDING: f64 = 1e-12;
    let (squares, measure) = squares_and_measure(x, simplex);
    let (than, least) = (than.max(0.0), least.max(0.0));
    let is_upright = measure > 0.0 && radius > 0.0;
    if !is_upright {
        return 0.0;
    }
    let (span, growth) = (squares.sqrt(), (D + 1) as f64);
    let widest = span * (1.0 + FARTHEST * growth);
    let powers = |span: f64| if D == 2 { (span, span * span) } else { (span * span, span * span * span) };
    let fall = powers(widest).0 * if D == 2 { 0.75_f64.sqrt() } else { 1.0 / 108.0_f64.sqrt() };
    let asked = if D == 2 { than / 48.0_f64.sqrt() } else { (than / 12.0) * (than / 12.0).sqrt() / 3.0 };
    let shaped = (measure - asked * powers(span).1) / (fall + asked * growth * D as f64 * powers(widest).0);
    let filled = (1.0 - least) / (fall / measure + 1.0 / radius);
    (SAFE * shaped.min(filled).min(FARTHEST * span) - ROUNDING * span).max(0.0)
}

/// Sum of squared edge lengths Σ l², and area or volume of a simplex.
fn squares_and_measure<const D: usize>(x: &[Vector<D>], simplex: &Simplex) -> (f64, f64) {
    let pairs = (0..=D).flat_map(|i| (0..i).map(move |j| (i, j)));
    let squares = pairs.map(|(i, j)| (x[simplex[i].index()] - x[simplex[j].index()]).norm_squared()).sum();
    (squares, super::signed_volume(x, simplex))
}

/// Outward normals of the sides opposite the corners.
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
    use crate::mesh::{NodeId, signed_volume};

    /// Moves each position by `way` along the direction in which `value` falls fastest.
    fn moved<const D: usize>(x: &[Vector<D>], way: f64, value: impl Fn(&[Vector<D>]) -> f64) -> Vec<Vector<D>> {
        let slope = |a: usize, axis: usize| {
            let at = |step: f64| {
                let mut there = x.to_vec();
                there[a][axis] += step;
                value(&there)
            };
            at(1e-6) - at(-1e-6)
        };
        let step = |a: usize| {
            let slope = Vector::<D>::from_fn(|axis, _| slope(a, axis));
            x[a] - slope * (way / slope.norm().max(f64::MIN_POSITIVE))
        };
        (0..x.len()).map(step).collect()
    }

    fn check_leeway<const D: usize>() {
        let ids = [0, 1, 2, 3].map(NodeId);
        let mut seed = 0.37;
        let mut random = || {
            seed = (seed * 9301.0 + 0.492_97) % 1.0;
            2.0 * seed - 1.0
        };
        let mut n = 0;
        for _ in 0..2000 {
            let out = Vector::<D>::from_fn(|axis, _| if axis == 0 { 3.0 } else { 0.0 });
            let x: Vec<Vector<D>> = (0..=D).map(|_| Vector::<D>::from_fn(|_, _| random()) + out).collect();
            let (quality, measure) = (shape_quality(&x, &ids), signed_volume(&x, &ids));
            if quality <= 0.02 {
                continue;
            }
            let radius = |x: &[Vector<D>]| x.iter().map(|x| x[0]).sum::<f64>() / (D + 1) as f64;
            let ring = |x: &[Vector<D>]| signed_volume(x, &ids) * radius(x);
            let part = 1.0 - 0.2 * random().abs();
            let way = travel_bound(&x, &ids, (part * quality, 0.0), radius(&x));
            let flattened = moved(&x, way, |x| shape_quality(x, &ids));
            assert!(way > 0.0 && !is_worse(&flattened, &ids, part * quality), "{way} m of {x:?}");
            let way = travel_bound(&x, &ids, (-0.1, part), radius(&x));
            let pressed = moved(&x, way, ring);
            assert!(way > 0.0 && ring(&pressed) >= part * measure * radius(&x), "{way} m of {x:?}");
            n += 1;
        }
        assert!(n > 300, "{n} simplices");
    }

    #[test]
    fn nodes_that_stay_within_their_leeway_wear_nothing() {
        check_leeway::<2>();
        check_leeway::<3>();
        let ids = [0, 1, 2, 3].map(NodeId);
        let regular = [[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0], [-1.0, -1.0, 1.0]].map(Vector::<3>::from);
        let way = travel_bound(&regular, &ids, (0.0, 0.95), f64::INFINITY);
        let shrunk = |way: f64| signed_volume(&regular.map(|x| x * (1.0 - way / x.norm())), &ids) * 0.375;
        assert!(shrunk(way) > 0.95 && shrunk(1.6 * way) < 0.95, "two thirds of what may be lost are used");
        let half = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(Vector::<2>::from);
        let turned = [half[0], half[2], half[1]];
        assert_eq!(travel_bound(&turned, &ids, (0.0, 0.5), f64::INFINITY), 0.0);
        assert_eq!(travel_bound(&half, &ids, (0.9, 0.5), f64::INFINITY), 0.0);
    }

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
