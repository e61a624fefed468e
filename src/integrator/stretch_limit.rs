//! Stretch limit: how far the gel surface is stretched over a body, and when the stretch ends a mesh or a run (A11).

use super::StepError;
use super::contact_phase::SurfaceAtTick;
use super::system::DiscreteSystem;
use crate::contact::{BodyState, FacetCandidate, RigidBody, facet_corners, find_deepest_point, find_penetration};
use crate::fem::Potential;
use crate::geometry::SignedDistance as _;
use crate::math::Vector3;
use crate::state::SurfaceStretch;

/// Leak depth: a stopped facet leaks if it is deeper in the body, at its deepest point or where a pole of the body
/// pierces it. It is measured in the smaller of element size and inner radius of the body (A11). A facet stopped at
/// one point still turns about it: the sharp corner of a cube comes 0.6 deep and is held, so half a size would be too
/// little.
const LEAK_DEPTH: f64 = 1.0;
/// Facet depth at which a mesh that can be remeshed counts as distorted, in the same measure: the surface has been
/// stretched over the body.
const DISTORTED_DEPTH: f64 = 0.5;

/// Result of a check of the facets near bodies.
pub(super) struct StretchCheck {
    /// Greatest stretch of the facets.
    stretch: SurfaceStretch,
    /// First leak.
    pub leak: Option<StepError>,
}

/// Records the stretch of the surface for the next tick; a leak ends the mesh there, or the run at once if there
/// is no remeshing.
pub(super) fn check_stretch<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    time: f64,
) -> Result<(), StepError> {
    let StretchCheck { stretch, leak } = find_stretch(system, time);
    system.state.record.stretch = stretch;
    leak.filter(|_| !system.can_be_distorted()).map_or(Ok(()), Err)
}

/// Finds the greatest stretch of the facets between a node and a body, relative to the least size of their nodes,
/// and the first leak.
pub(super) fn find_stretch<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, time: f64) -> StretchCheck {
    let (mut stretch, mut leak) = (SurfaceStretch::Little, None);
    for candidate in &system.contact.facets {
        match check_facet(system, candidate, time) {
            Ok(here) => stretch = stretch.max(here),
            Err(error) => (stretch, leak) = (SurfaceStretch::Leaking, leak.or(Some(error))),
        }
    }
    StretchCheck { stretch, leak }
}

/// Returns the stretch of a facet over a body, or the leak.
fn check_facet<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    candidate: &FacetCandidate,
    time: f64,
) -> Result<SurfaceStretch, StepError> {
    let FacetCandidate { body, facet, least_size: size, .. } = *candidate;
    let surface = SurfaceAtTick::of(system);
    let (corners, (rigid, at)) = (facet_corners(&surface, facet), surface.bodies().get(body));
    let unit = size.min(rigid.shape.inner_radius());
    let threshold = if system.can_be_distorted() { DISTORTED_DEPTH } else { LEAK_DEPTH };
    let deep = find_deepest_point::<D>(&corners, threshold * unit, |p| rigid.gap(at, p)).map(|deep| deep.point);
    let pierced = find_penetration::<D>(&corners, rigid, at).map(|tip| tip.point);
    for point in deep.into_iter().chain(pierced) {
        let depth = -rigid.gap(at, &point).distance;
        if depth > LEAK_DEPTH * unit {
            let element = system.model.gel.behind[facet.index()].index();
            return Err(StepError::Leak { body, element, time, depth, at: point.into() });
        }
    }
    let is_distorted = deep.is_some() || is_long::<D, P>(system, &corners, rigid, at);
    Ok(if is_distorted && system.can_be_distorted() { SurfaceStretch::Distorted } else { SurfaceStretch::Little })
}

/// Returns true if an edge of a facet touches a body and is longer than the mesh allows.
fn is_long<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    corners: &[Vector3; 3],
    rigid: &RigidBody,
    at: &BodyState,
) -> bool {
    let most = system.clock.ends.distortion.as_ref().map_or(f64::INFINITY, |limits| limits.facet_edge);
    let sides = (0..D).map(|i| (corners[i], corners[(i + 1) % D]));
    sides.filter(|(a, b)| (a - b).norm() > most).any(|(a, b)| rigid.gap(at, &((a + b) * 0.5)).distance < 0.0)
}
