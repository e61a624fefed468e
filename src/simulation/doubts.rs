//! Warnings about a run by its results.

use super::observe::Observation;
use crate::geometry::SignedDistance;
use crate::math::Vector3;
use crate::scene::{FaceSupport, MaterialModel, Scene};

/// Depth in radii of the projectile down to which an elastic gel keeps its energy where its mesh is made anew, with
/// private rest shapes (`docs/studies.md`, deep). The greatest depths with and without remeshing agree within 0.2 % up
/// to 3 radii, and differ by 3 to 40 % from 4 radii on.
const FAITHFUL_DEPTH: f64 = 3.0;

/// Reasons to doubt the figures of a run so far, one sentence each; those of [`crate::scene::doubts`] are not
/// included.
#[must_use]
pub fn doubts(scene: &Scene, seen: &Observation) -> Vec<String> {
    [seen.energy.doubt(), lost_elasticity(scene, seen), held_back(scene, seen)].into_iter().flatten().collect()
}

/// Doubt about an elastic gel that has lost energy to remeshing.
fn lost_elasticity(scene: &Scene, seen: &Observation) -> Option<String> {
    use MaterialModel::{MooneyRivlin, NeoHookean, Ogden};
    let is_elastic = matches!(scene.gel.material, NeoHookean | MooneyRivlin | Ogden);
    let radius = radius(scene);
    let (depth, _) = seen.projectile().contact.peak_depth;
    (is_elastic && seen.cost.incompatible_fraction > 0.0 && depth > FAITHFUL_DEPTH * radius).then(|| {
        format!(
            "{:.1e} of the mass of an elastic gel has rest shapes that do not fit together, and the projectile went \
             {:.1} radii deep: beyond {FAITHFUL_DEPTH} radii these act like plastic flow; depth, time and rebound are \
             not those of an elastic gel",
            seen.cost.incompatible_fraction,
            depth / radius
        )
    })
}

/// Doubt about a shot that reaches a supported back face.
fn held_back(scene: &Scene, seen: &Observation) -> Option<String> {
    let (support, thickness) = (scene.gel.supports.z_min, scene.gel.shape.thickness()?);
    let contact = &seen.projectile().contact;
    let (depth, _) = contact.peak_depth;
    // An unbounded body has no width.
    let is_near = depth > thickness - 2.0 * Some(radius(scene)).filter(|radius| radius.is_finite())?;
    let is_deep = contact.first.is_some() && depth > 0.5 * thickness;
    (support != FaceSupport::Free && is_near && is_deep).then(|| {
        let held = if support == FaceSupport::Roller { "roller" } else { "fixed" };
        format!(
            "the projectile came within its width of a supported back face (gel.supports.z_min = \"{held}\"): from \
             there on force, depth and exit speed are those of a gel against a wall; use \"free\" for a free back face"
        )
    })
}

/// Radius of the greatest section of the projectile, m.
fn radius(scene: &Scene) -> f64 {
    let shape = scene.shape(0);
    shape.reach(&Vector3::x()).max(shape.reach(&Vector3::y()))
}
