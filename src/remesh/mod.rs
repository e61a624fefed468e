//! Remeshing of a deformed gel, and the transfer of its nodal fields: pure functions from a deformed mesh to a new
//! mesh.
//!
//! Makers of a new mesh stand behind one trait, [`Mesher`]: [`LocalMesher`] in the plane and in space, and
//! [`ImmersedMesher`], the method of the paper.
//!
//! Target sizes ([`sizes_from_curvature`], [`graded`]), acceptance of a new mesh ([`check_acceptance`]) and field
//! transfer ([`transfer()`]) are the same in the plane and in space.

mod acceptance;
mod adjacency;
mod barycentric;
mod boundary_loops;
mod boundary_resampling;
mod conservation;
mod correspondence;
mod curvature;
mod delaunay;
mod detached_parts;
mod error;
mod immersed;
mod load_markers;
mod local;
mod mesher;
mod nodal_fields;
pub mod operations;
mod overlap_candidates;
mod overlap_integrals;
mod overlap_moments;
mod plane;
mod point_insertion;
mod point_location;
mod point_set;
mod polygon;
mod polyhedron;
mod proposal;
mod quadtree;
mod rest_positions;
mod retained_region;
mod self_overlap;
mod sizing;
mod space;
#[cfg(test)]
mod space_transfer_tests;
mod supermesh;
#[cfg(test)]
mod test_bodies;
#[cfg(test)]
mod test_meshes;
#[cfg(test)]
mod tests;
mod thin_features;
mod transfer;
mod triangle;
mod untangle;
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
    BackgroundCell, BackgroundMesh, ImmersedMesh, ImmersedMesher, ImmersionSteps, cells, cut_out, distances, immerse,
    rounding, snapped, triangulated,
};
pub use load_markers::{facet_load_markers, facet_load_markers_at_rest, spread_cavity_mark};
pub use local::LocalMesher;
pub use mesher::{MeshRequest, Mesher, RemeshRules, Remeshed};
pub use nodal_fields::{
    BodySymmetry, NodalFields, TransferredFields, corner_masses, least_relative_mass, nodal_masses,
};
pub use point_location::{is_inside, nearest};
pub use proposal::{DeformedMesh, NodeOrigin, ProposedMesh};
pub use self_overlap::self_overlap_mass;
pub use sizing::{SizeRange, graded, sizes_from_curvature};
pub use thin_features::{limit_sheet_sizes, thin_elements};
pub use transfer::{transfer, transfer_paired};
