//! Remeshing of a deformed gel, and the transfer of its nodal fields: pure functions from a deformed mesh to a new
//! mesh.
//!
//! There are two methods: [`operations`] on the elements of the old mesh, in the plane and in space, and the immersed
//! method of the paper, [`immerse`], in the plane.
//!
//! Target sizes ([`sizes_from_curvature`], [`graded`]), acceptance of a new mesh ([`check_acceptance`]) and field
//! transfer ([`transfer()`]) are the same in the plane and in space.

mod acceptance;
mod adjacency;
mod barycentric;
mod boundary_loops;
mod conservation;
mod correspondence;
mod curvature;
mod detached_parts;
mod error;
mod immersed;
mod load_markers;
mod nodal_fields;
pub mod operations;
mod overlap_candidates;
mod overlap_integrals;
mod overlap_moments;
mod point_location;
mod polygon;
mod polyhedron;
mod proposal;
mod rest_positions;
mod self_overlap;
mod sizing;
#[cfg(test)]
mod space_transfer_tests;
mod supermesh;
#[cfg(test)]
mod test_bodies;
#[cfg(test)]
pub(crate) mod test_meshes;
mod thin_features;
mod transfer;
mod triangle;
mod velocity;
#[cfg(test)]
mod wave_tests;

pub use acceptance::{
    AcceptanceLimits, KnownQuality, MeshQuality, MeshRejected, check_acceptance, check_acceptance_known,
};
pub use adjacency::{ElementNeighbours, neighbours_after};
pub use conservation::{ConservationDefects, ConservedTotals};
pub use correspondence::{MeshCorrespondence, OverlapSource, UnchangedElement};
pub use curvature::{curvature_angles, curvature_angles_within};
pub use detached_parts::with_detached_parts;
pub use error::RemeshError;
pub use immersed::{
    BackgroundCell, BackgroundMesh, ImmersedMesh, ImmersionSteps, cells, cut_out, distances, immerse, rounding,
    snapped, triangulated,
};
pub use load_markers::{facet_load_markers, facet_load_markers_at_rest, spread_cavity_mark};
pub use nodal_fields::{
    BodySymmetry, NodalFields, TransferredFields, corner_masses, least_relative_mass, nodal_masses,
};
pub use point_location::{is_inside, nearest};
pub use proposal::{DeformedMesh, NodeOrigin, ProposedMesh};
pub use self_overlap::self_overlap_mass;
pub use sizing::{SizeRange, graded, sizes_from_curvature};
pub use thin_features::{limit_sheet_sizes, thin_elements};
pub use transfer::{transfer, transfer_paired};
