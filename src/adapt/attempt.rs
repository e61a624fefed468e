//! Attempts of a remeshing method, and the generators of their meshes.

use super::settings::RemeshMethod;
use crate::math::Vector;
use crate::remesh::{
    DeformedMesh, ImmersedMesher, LocalMesher, MeshRequest, Mesher, ProposedMesh, RemeshError, RemeshRules, Remeshed,
};

/// Attempt to generate a mesh; a method has several, tried in order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum RemeshAttempt {
    /// Local remeshing.
    ///
    /// A boundary node is removed where the boundary stays within `sag` chords of the chord without it. In space a
    /// node may also slide along the boundary, off it by at most `slide` target lengths. `rests` is true if the gel
    /// has a surface at rest.
    Retained { sag: f64, slide: f64, rests: bool },
    /// Immersed mesh with target sizes scaled by `size_factor`.
    Immersed { size_factor: f64 },
}

/// Mesh generator of a dimension: returns a proposal and its tolerance for the change of area or volume.
pub(super) type MeshGenerator<const D: usize> = fn(
    RemeshAttempt,
    &DeformedMesh<'_, D>,
    &[f64],
    BodyClearance<'_, D>,
) -> Result<(ProposedMesh<D>, f64), RemeshError>;
/// Function that returns the point nearest to a given one that is in no body.
pub(super) type BodyClearance<'a, const D: usize> = &'a dyn Fn(&Vector<D>) -> Vector<D>;

/// Tolerance for the relative change of area or volume when boundary nodes are removed.
const MEASURE_TOLERANCE: f64 = 1e-5;
/// Quality that an immersed mesh must reach if the old mesh did. Cutting stays above it except in corners that the
/// sizes do not resolve (`smooth_bodies_of_any_size_and_place_are_cut_out_whole`).
const IMMERSED_QUALITY: f64 = 0.1;
/// Quality that a local mesh in the plane must reach if the old mesh did: that of a needle of 10°.
const PLANE_QUALITY: f64 = 0.3;
/// Quality that a local mesh in space must reach if the old mesh did: splitting long edges may leave worse elements.
const SPACE_QUALITY: f64 = 0.2;

impl RemeshAttempt {
    /// Attempts in this dimension; `has_networks` for a two-network gel. In space there is the local method alone.
    pub fn all<const D: usize>(method: RemeshMethod, has_networks: bool) -> [Self; 3] {
        match D {
            3 if has_networks => Self::NETWORKS,
            3 => Self::ELASTIC,
            _ => Self::in_plane(method, has_networks),
        }
    }

    /// Attempts of a method in the plane.
    pub fn in_plane(method: RemeshMethod, has_networks: bool) -> [Self; 3] {
        match method {
            RemeshMethod::Local => {
                [0.06, 0.02, 0.0].map(|sag| Self::Retained { sag, slide: 0.0, rests: !has_networks })
            }
            RemeshMethod::Immersed => [1.0, 0.7, 0.5].map(|size_factor| Self::Immersed { size_factor }),
        }
    }

    /// Attempts in space for an elastic gel: nodes slide along the surface only where no other mesh is accepted.
    const ELASTIC: [Self; 3] = [
        Self::Retained { sag: 0.06, slide: 0.0, rests: true },
        Self::Retained { sag: 0.02, slide: 0.05, rests: true },
        Self::Retained { sag: 0.2, slide: 0.1, rests: true },
    ];

    /// Attempts in space for a two-network gel.
    ///
    /// Its surface has no rest shape that tells how flat it was. A cavity in cells of a quarter of the ball's radius
    /// is flat to no more than 0.13 of a cell. Without sliding, an element of the calibration shot inverts after 11
    /// µs.
    const NETWORKS: [Self; 3] = [
        Self::Retained { sag: 0.2, slide: 0.1, rests: false },
        Self::Retained { sag: 0.06, slide: 0.05, rests: false },
        Self::Retained { sag: 0.0, slide: 0.0, rests: false },
    ];

    /// Least quality required of a new mesh, if `old` is that of the old one.
    pub fn least_quality<const D: usize>(self, old: f64) -> f64 {
        match self {
            Self::Retained { .. } => old.min(if D == 3 { SPACE_QUALITY } else { PLANE_QUALITY }),
            Self::Immersed { .. } => old.min(IMMERSED_QUALITY),
        }
    }
}

/// Generates a mesh by the maker of an attempt.
pub(super) fn generate_mesh<const D: usize>(
    attempt: RemeshAttempt,
    moved: &DeformedMesh<'_, D>,
    size: &[f64],
    cleared: BodyClearance<'_, D>,
) -> Result<(ProposedMesh<D>, f64), RemeshError>
where
    LocalMesher: Mesher<D>,
    ImmersedMesher: Mesher<D>,
{
    let request = |rules| MeshRequest { old: *moved, size, rules, cleared };
    let Remeshed { proposal, rounding } = match attempt {
        RemeshAttempt::Retained { sag, slide, rests } => {
            LocalMesher.remesh(&request(RemeshRules { sag, slide, rests, ..RemeshRules::default() }))
        }
        RemeshAttempt::Immersed { size_factor } => {
            ImmersedMesher { size_factor }.remesh(&request(RemeshRules::default()))
        }
    }?;
    Ok((proposal, MEASURE_TOLERANCE + rounding))
}
