//! Digest of a scene, by which the results of a run know their scene.

use crate::scene::{BodyShape, CouplingSpec, FidelityKind, FidelityLevels, Scene};
use xxhash_rust::xxh3::xxh3_128;

/// Returns the XXH3-128 hash of the values of a scene in 32 hexadecimal digits. Its title changes nothing of a run, nor
/// does the level that gave it its values, but for the reduced model, nor the coupling mode, in whose place `gelfmu run` has its own; an STL file
/// counts by its content, wherever it lies.
pub(super) fn scene_digest(scene: &Scene) -> String {
    let mut scene = scene.clone();
    scene.scene.title.clear();
    scene.coupling = CouplingSpec::default();
    scene.fidelity = FidelityLevels::default();
    if scene.scene.fidelity != FidelityKind::Instant {
        (scene.scene.fidelity, scene.instant) = (FidelityKind::default(), None);
    }
    for body in std::iter::once(&mut scene.projectile).chain(&mut scene.fragment) {
        if let BodyShape::Stl(stl) = &mut body.shape {
            stl.file = stl.content.as_ref().map_or(String::new(), |content| format!("{:032x}", content.digest));
        }
    }
    let text = serde_json::to_string(&scene).expect("a scene consists of tables, numbers and text");
    format!("{:032x}", xxh3_128(text.as_bytes()))
}
