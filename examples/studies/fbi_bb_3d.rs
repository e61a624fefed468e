//! The FBI calibration shot in space, and about its axis on cells as coarse.

use super::fbi_bb::{Keys, head, row};

/// Cells that grow as fast as those of the scene in space, as large, and smaller.
const ABOUT_THE_AXIS: [(&str, &Keys); 3] = [
    (
        "about the axis: R/3.6, growth 0.25",
        &[("mesh.size", "0.6e-3"), ("remesh.smallest", "0.3e-3"), ("remesh.growth", "0.25")],
    ),
    (
        "about the axis: R/5, growth 0.25",
        &[("mesh.size", "0.43e-3"), ("remesh.smallest", "0.215e-3"), ("remesh.growth", "0.25")],
    ),
    (
        "about the axis: R/4, growth 0.25",
        &[("mesh.size", "0.55e-3"), ("remesh.smallest", "0.275e-3"), ("remesh.growth", "0.25")],
    ),
];

/// The columns of the calibration shot.
pub fn study() {
    head();
    row("fbi-bb-3d", "in space, as it comes: R/3.6, growth 0.25", &[]);
    let finer = [("mesh.size", "0.43e-3"), ("remesh.smallest", "0.215e-3"), ("remesh.thinnest", "0.15e-3")];
    row("fbi-bb-3d", "in space, R/5, growth 0.25", &finer);
    for (name, keys) in ABOUT_THE_AXIS {
        row("fbi-bb", name, keys);
    }
}
