//! Immersed remeshing (figure 6 of the paper): the body is embedded in a triangulation of the surrounding square and
//! cut out of it.
//!
//! Each step is a function whose result can be drawn: [`cells`], [`triangulated`], [`distances`], [`snapped`],
//! [`cut_out`].

mod background;
mod boundary;
mod cut;
mod delaunay;
mod quadtree;
mod request;
mod size_field;
mod snap;
mod steps;
#[cfg(test)]
mod tests;

pub use background::{BackgroundCell, BackgroundMesh, cells, triangulated};
pub use snap::{ImmersedMesh, snapped};
pub use steps::{ImmersionSteps, cut_out, distances, immerse, rounding};
