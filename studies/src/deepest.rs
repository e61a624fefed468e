//! Where the gel is deepest inside the projectile.

use ballistic_gel::geometry::SignedDistance as _;
use ballistic_gel::math::Vector3;
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::MeshFrame;
use nalgebra::{Quaternion, UnitQuaternion};

/// Depth inside the projectile of the deepest of many points all over the surface of the gel, corners and sides
/// included, m: every side of a facet is cut into `n`.
pub fn deepest(frame: &MeshFrame, scene: &Scene, n: u32) -> f64 {
    let [w, x, y, z] = frame.bodies[0].kinematics.orientation;
    let (shape, turn) = (scene.shape(0), UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)));
    let gap =
        |p: &Vector3| shape.gap(&turn.inverse_transform_vector(&(p - frame.bodies[0].kinematics.position))).distance;
    let mut deepest: f64 = 0.0;
    for facet in &frame.cells.facets {
        let corner = |i: usize| frame.points[facet[i.min(frame.dimension - 1)] as usize];
        let [a, b, c] = [0, 1, 2].map(corner);
        if gap(&a) > (b - a).norm().max((c - a).norm()) {
            continue;
        }
        for (i, j) in (0..=n).flat_map(|i| (0..=n - i).map(move |j| (f64::from(i), f64::from(j)))) {
            deepest = deepest.max(-gap(&(a + ((b - a) * i + (c - a) * j) / f64::from(n))));
        }
    }
    deepest
}
