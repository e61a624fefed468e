//! Conditions that end a mesh, or the integration of the gel.

use crate::contact::BodyState;
use crate::state::Tick;

/// End conditions of a mesh.
#[derive(Debug, Clone, Default)]
pub(super) struct EndConditions {
    /// Distortion limits; `None` if the mesh never ends by them.
    pub distortion: Option<DistortionLimits>,
    /// Ticks at or after which the mesh ends, distorted or not, ascending.
    pub at: Vec<Tick>,
    /// Exit rule, which may end the integration of the gel; `None` where its shape has no back face.
    pub exits: Option<ExitRule>,
}

/// Exit rule: the face through which bodies leave a gel, and how long it is integrated after that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExitRule {
    /// Height of the undisturbed back face in the frame of the block, m; negative.
    pub back_face: f64,
    /// Half width of the back face along x and along y, m: a body that passes beside it has left at a side.
    pub half_width: [f64; 2],
    /// Time from the exit of the projectile until the gel is put to rest, s; infinite if it never is.
    pub rest_after: f64,
}

impl ExitRule {
    /// Returns true if a body below the back face is not beside it.
    pub(super) fn is_behind(&self, seen: &BodyState) -> bool {
        seen.position.x.abs() <= self.half_width[0] && seen.position.y.abs() <= self.half_width[1]
    }
}

/// Distortion limits: a mesh is distorted as soon as one of its elements exceeds them.
#[derive(Debug, Clone, PartialEq)]
pub struct DistortionLimits {
    /// Least shape quality of each element, 1 being the best.
    pub quality: Vec<f64>,
    /// Least measure, [`Potential::measure`](crate::fem::Potential::measure), of each element.
    pub least: Vec<f64>,
    /// Least stable step of each element, s; empty if the step does not matter.
    pub step: Vec<f64>,
    /// Greatest of these, s: groups of longer steps need no look.
    pub greatest_step: f64,
    /// Greatest edge of a facet that touches a body, m.
    pub facet_edge: f64,
}

impl DistortionLimits {
    /// Limits of quality and measure alone.
    #[must_use]
    pub fn of_shape(quality: Vec<f64>, least: Vec<f64>) -> Self {
        Self { quality, least, step: vec![], greatest_step: 0.0, facet_edge: f64::INFINITY }
    }

    /// Returns true if the mesh is remade by local operations, often and a little at a time.
    #[must_use]
    pub fn are_of_edits(&self) -> bool {
        self.facet_edge.is_finite()
    }
}
