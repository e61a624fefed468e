//! The FBI calibration shot in space, and about its axis on cells as coarse.

use super::fbi_bb::{Keys, head, row};

/// The strength of the scene in space. About the axis cells of R/2.7 with sheets as thick end at an inverted element.
const ABOUT_THE_AXIS: &Keys = &[
    ("gel.strength", "{ yield_stress = 0.138e6, reference_rate = 1.0, rate_exponent = 0.23, cap = 1.6e6 }"),
    ("mesh.size", "0.43e-3"),
    ("remesh.smallest", "0.2e-3"),
    ("remesh.growth", "0.25"),
];

/// The columns of the calibration shot.
pub fn study() {
    head();
    row("fbi-bb-3d", "in space, as it comes: R/2.7, growth 0.25", &[]);
    row("fbi-bb", "about the axis: R/5, growth 0.25", ABOUT_THE_AXIS);
}
