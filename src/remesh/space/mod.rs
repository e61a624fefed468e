//! Local remeshing of a body in space by mesh operations: long edges are split, short edges collapsed, and poor
//! tetrahedra reconnected, smoothed or collapsed.
//!
//! Every operation preserves the topology of the body, so that nothing is welded or torn and the boundary stays known.
//! Good elements are untouched and keep their bits. The surface changes only where it is flat, now and at rest, to
//! within [`RemeshRules::sag`](super::RemeshRules::sag) of a target length.

mod collapse;
mod edge_star;
mod improver;
mod limits;
mod slide;
mod sliver_removal;
mod smooth;
mod split;
mod surface_criteria;
mod swap;
#[cfg(test)]
mod test_shapes;
#[cfg(test)]
mod tests;
mod tet_mesh;
mod volume_correction;

pub(super) use improver::propose;
