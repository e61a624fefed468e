//! The FBI calibration shot in space, and about its axis on cells as coarse.

use super::fbi_bb::{Keys, head, row};

/// Scenes and names of the shots, and what is changed in each: in space, and about the axis on cells that grow as fast.
const RUNS: [(&str, &str, &Keys); 5] = [
    ("fbi-bb-3d", "in space, scene unchanged: R/5, growth 0.25", &[]),
    (
        "fbi-bb-3d",
        "in space, R/3.6, growth 0.25",
        &[("mesh.size", "0.6e-3"), ("remesh.smallest", "0.3e-3"), ("remesh.erosion_thickness", "0.21e-3")],
    ),
    (
        "fbi-bb",
        "about the axis: R/3.6, growth 0.25",
        &[("mesh.size", "0.6e-3"), ("remesh.smallest", "0.3e-3"), ("remesh.growth", "0.25")],
    ),
    (
        "fbi-bb",
        "about the axis: R/5, growth 0.25",
        &[("mesh.size", "0.43e-3"), ("remesh.smallest", "0.215e-3"), ("remesh.growth", "0.25")],
    ),
    (
        "fbi-bb",
        "about the axis: R/4, growth 0.25",
        &[("mesh.size", "0.55e-3"), ("remesh.smallest", "0.275e-3"), ("remesh.growth", "0.25")],
    ),
];

/// The columns of the calibration shot.
pub fn study() {
    head();
    for (scene, name, keys) in RUNS {
        row(scene, name, keys);
    }
}
