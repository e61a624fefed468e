//! Foot of the perpendicular from a point to a facet of the gel, and the distance of the point from the facet.

use super::facet::outward_normal;
use crate::math::Vector3;

/// Foot of the perpendicular from a point to the plane of a facet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FacetFoot {
    /// n, unit normal of the facet out of the gel.
    pub normal: Vector3,
    /// Height of the point over the plane of the facet, m; negative behind it.
    pub height: f64,
    /// w, barycentric coordinates of the foot; one is negative beyond the edge opposite its corner.
    pub weights: [f64; 3],
    /// Distance of the point from the facet, m.
    pub distance: f64,
}

impl FacetFoot {
    /// Finds the foot on a facet with these corners. The numbers of a degenerate facet are not finite.
    pub fn new<const D: usize>(corners: &[Vector3; 3], point: &Vector3) -> Self {
        let across = outward_normal::<D>(corners);
        let (normal, arm) = (across / across.norm(), point - corners[0]);
        let height = normal.dot(&arm);
        let weights = if D == 3 { triangle_weights(corners, &across, &arm) } else { line_weights(corners, &arm) };
        let is_above = weights.iter().all(|w| *w >= 0.0);
        let distance = if is_above { height.abs() } else { edge_distance::<D>(corners, &weights, point) };
        Self { normal, height, weights, distance }
    }
}

/// Returns the barycentric coordinates of the foot on a triangle with this normal, from its first corner.
fn triangle_weights(corners: &[Vector3; 3], across: &Vector3, arm: &Vector3) -> [f64; 3] {
    let part = |v: Vector3| v.dot(across) / across.norm_squared();
    let beta = part(arm.cross(&(corners[2] - corners[0])));
    let gamma = part((corners[1] - corners[0]).cross(arm));
    [1.0 - beta - gamma, beta, gamma]
}

/// Returns the barycentric coordinates of the foot on a line, from its first end.
fn line_weights(corners: &[Vector3; 3], arm: &Vector3) -> [f64; 3] {
    let along = corners[1] - corners[0];
    let beta = arm.dot(&along) / along.norm_squared();
    [1.0 - beta, beta, 0.0]
}

/// Returns the distance of a point whose foot is beyond an edge, m: it is nearest to one of the edges that the foot is
/// beyond.
fn edge_distance<const D: usize>(corners: &[Vector3; 3], weights: &[f64; 3], point: &Vector3) -> f64 {
    let beyond = (0..D).filter(|i| weights[*i] < 0.0);
    let distance = |i: usize| {
        if D == 2 {
            return (point - corners[1 - i]).norm();
        }
        let (from, along) = (corners[(i + 1) % 3], corners[(i + 2) % 3] - corners[(i + 1) % 3]);
        let part = (point - from).dot(&along) / along.norm_squared();
        (point - from - along * part.clamp(0.0, 1.0)).norm()
    };
    // A degenerate facet has no weights: its distance is no number, which is never found to be out of reach.
    beyond.map(distance).reduce(f64::min).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::super::test_surface::any;
    use super::*;

    /// Checks the distance against that of many points of the facet.
    fn check_distance<const D: usize>() {
        const N: usize = 60;
        for i in 1..300 {
            let part = |k: usize| any(k * k + 5 * k);
            let vector =
                |k: usize| Vector3::new(part(i + k), if D == 3 { part(3 * i + k) } else { 0.0 }, part(7 * i + k));
            let (corners, point) = ([vector(1), vector(20), vector(300)], 1.5 * vector(4000));
            let foot = FacetFoot::new::<D>(&corners, &point);
            let (foot_point, above) =
                ((0..D).map(|k| corners[k] * foot.weights[k]).sum::<Vector3>(), foot.normal * foot.height);
            assert!((point - foot_point - above).norm() < 1e-6, "{foot:?}");
            let sampled = (0..=N).flat_map(|j| (0..=if D == 3 { N - j } else { 0 }).map(move |k| [j, k]));
            let nearest = sampled.map(|[j, k]| {
                let [b, c] = [j, k].map(|part| part as f64 / N as f64);
                (corners[0] * (1.0 - b - c) + corners[1] * b + corners[2] * c - point).norm()
            });
            let nearest = nearest.fold(f64::INFINITY, f64::min);
            assert!(foot.distance <= nearest + 1e-12 && nearest < foot.distance + 0.06, "{foot:?}, {nearest}");
        }
    }

    #[test]
    fn the_distance_of_a_facet_is_that_of_its_nearest_point() {
        check_distance::<2>();
        check_distance::<3>();
    }
}
