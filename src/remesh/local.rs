//! Local remeshing: the old mesh stays where it is good and of the target sizes.

use super::{MeshRequest, Mesher, RemeshError, Remeshed, plane, space};

/// Maker of a mesh by local operations on the old one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LocalMesher;

impl Mesher<2> for LocalMesher {
    fn remesh(&self, request: &MeshRequest<'_, 2>) -> Result<Remeshed<2>, RemeshError> {
        let proposal = plane::propose(&request.old, request.size, &request.rules, request.cleared)?;
        Ok(Remeshed { proposal, rounding: 0.0 })
    }
}

impl Mesher<3> for LocalMesher {
    fn remesh(&self, request: &MeshRequest<'_, 3>) -> Result<Remeshed<3>, RemeshError> {
        let proposal = space::propose(&request.old, request.size, &request.rules, request.cleared)?;
        Ok(Remeshed { proposal, rounding: 0.0 })
    }
}
