//! Target sizes of a new mesh: fine where the fields are curved and near bodies.

use super::adaptive_gel::AdaptiveGel;
use super::settings::AdaptSettings;
use crate::contact::{BodyState, RigidBody};
use crate::geometry::SharpEnd;
use crate::math::{Vector, Vector3, embed};
use crate::remesh::{self, DeformedMesh, ElementNeighbours, SizeRange};
use std::f64::consts::FRAC_PI_2;

/// Target sizes of the nodes: fine where displacement and velocity are curved and near bodies; uniform without
/// adaptivity.
pub(super) fn target_sizes<const D: usize>(
    gel: &AdaptiveGel<D>,
    moved: &DeformedMesh<'_, D>,
    settings: &AdaptSettings,
    adjacency: &ElementNeighbours,
) -> Vec<f64> {
    if !settings.adaptive {
        return vec![settings.usual; moved.position.len()];
    }
    let range = SizeRange { least: settings.least, greatest: settings.longest };
    // Sizes change by a factor of two at most.
    let angle = settings.curvature_angle;
    let asked = [0.5 * angle, 2.0 * angle].map(|angle| angle.min(FRAC_PI_2));
    let displacement = displacement(moved);
    let bends =
        remesh::curvature_angles_within(moved, &[&displacement, &gel.engine.state().velocity], (adjacency, asked));
    let mut size = remesh::sizes_from_curvature(moved, &bends, angle, &range);
    let active = gel.active_bodies();
    let bodies = BodySizes::new(&active, settings);
    for (size, x) in size.iter_mut().zip(moved.position) {
        *size = size.min(bodies.by_gap(x));
    }
    let mut size =
        remesh::limit_sheet_sizes(moved, (&gel.engine.gel().surface.facets, adjacency), size, settings.least);
    for (size, x) in size.iter_mut().zip(moved.position) {
        *size = size.min(bodies.by_tip(x));
    }
    remesh::graded(moved, size, settings.growth)
}

/// Target sizes by the distance from the bodies.
pub(super) struct BodySizes<'a> {
    bodies: &'a [(&'a RigidBody, BodyState)],
    axial_ends: Vec<Vector3>,
    settings: &'a AdaptSettings,
}

impl<'a> BodySizes<'a> {
    /// Sizes near these bodies.
    pub fn new(bodies: &'a [(&'a RigidBody, BodyState)], settings: &'a AdaptSettings) -> Self {
        Self { bodies, axial_ends: axial_ends(bodies), settings }
    }

    /// Distance from the nearest body, negative inside, m.
    pub fn gap<const D: usize>(&self, x: &Vector<D>) -> f64 {
        self.bodies.iter().map(|(body, at)| body.gap(at, &embed(x)).distance).fold(f64::INFINITY, f64::min)
    }

    /// Target size at a point, m.
    pub fn of<const D: usize>(&self, x: &Vector<D>) -> f64 {
        if !self.settings.adaptive {
            return self.settings.usual;
        }
        self.by_gap(x).min(self.by_tip(x)).min(self.settings.longest)
    }

    /// Target size by the distance from the surface of a body, m.
    fn by_gap<const D: usize>(&self, x: &Vector<D>) -> f64 {
        self.settings.usual + self.settings.growth * self.gap(x).max(0.0)
    }

    /// Target size by the distance from the axial ends and corners of bodies, m.
    fn by_tip<const D: usize>(&self, x: &Vector<D>) -> f64 {
        let near = |end: &Vector3| (embed(x) - end).norm();
        let nearest = || self.axial_ends.iter().map(near).fold(f64::INFINITY, f64::min);
        self.settings.tip_size.map_or(f64::INFINITY, |tip| tip + self.settings.growth * nearest())
    }
}

/// Curvature indicator of displacement and velocity at each element, rad.
pub(super) fn curvatures<const D: usize>(gel: &AdaptiveGel<D>, moved: &DeformedMesh<'_, D>) -> Vec<f64> {
    remesh::curvature_angles(moved, &[&displacement(moved), &gel.engine.state().velocity])
}

fn displacement<const D: usize>(moved: &DeformedMesh<'_, D>) -> Vec<Vector<D>> {
    moved.position.iter().zip(&moved.mesh.rest).map(|(x, rest)| x - rest).collect()
}

/// Axial ends and corners of the bodies, m.
fn axial_ends(bodies: &[(&RigidBody, BodyState)]) -> Vec<Vector3> {
    let of = |(body, at): &(&RigidBody, BodyState)| -> Vec<Vector3> {
        let place = |pole: &SharpEnd| at.position + at.orientation.transform_vector(&pole.end);
        body.poles(at).iter().map(place).collect()
    };
    bodies.iter().flat_map(of).collect()
}
