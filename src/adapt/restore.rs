//! Continuation from a saved state, which may have another mesh.

use super::adaptive_gel::AdaptiveGel;
use crate::integrator::UnusableStep;
use crate::mesh::face_neighbours;
use crate::state::DynamicState;
use std::sync::Arc;

/// Saved state that this simulation cannot restore.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RestoreError {
    /// State of another simulation.
    #[error("the state belongs to another scene, another file of the scene, or another coupling mode")]
    Foreign,
    /// State whose arrays or clocks contradict each other.
    #[error("the state is inconsistent: {what}")]
    Inconsistent {
        /// Description of the contradiction.
        what: &'static str,
    },
}

impl<const D: usize> AdaptiveGel<D> {
    /// Continues from a state of this run; returns true if that state has another mesh.
    ///
    /// # Errors
    /// [`RestoreError`] if the state is not one of this run; nothing is changed then.
    pub fn restore(&mut self, state: &DynamicState<D>) -> Result<bool, RestoreError> {
        let inconsistent = |what| RestoreError::Inconsistent { what };
        let own = &self.engine.state().birth;
        let is_current = match (own, &state.birth) {
            (Some(own), Some(its)) => Arc::ptr_eq(own, its) || own == its,
            (own, its) => own.is_none() && its.is_none(),
        };
        if is_current {
            return self.engine.restore(state).map(|()| false).map_err(inconsistent);
        }
        if self.definition.remesh.is_none() {
            return Err(inconsistent("its mesh was remeshed, but this scene has no remeshing"));
        }
        let first_mesh = if own.is_none() { Some(self.current_mesh()) } else { self.first_mesh.clone() };
        let birth = state.birth.as_ref().or(first_mesh.as_ref()).map(Arc::clone).ok_or(RestoreError::Foreign)?;
        if !self.definition.has_materials(&birth.parts) {
            return Err(inconsistent("its materials are not those of this scene"));
        }
        if !self.definition.has_positive_radii(&birth) {
            return Err(inconsistent("an element of its mesh is on the axis or beyond it"));
        }
        let adjacency = face_neighbours::<D>(&birth.mesh.elements);
        let qualities = self.definition.element_qualities(&birth.mesh.elements, &birth.position);
        let other = self.engine.engine_on_mesh(self.gel_on_mesh(&birth), &birth.position, state.birth.clone());
        let mut other = other.map_err(|UnusableStep { .. }| inconsistent("its mesh has no finite stable step"))?;
        let steps = self.definition.steps_when_new(&other);
        other.restore(state).map_err(inconsistent)?;
        self.engine = other.with_pool(self.engine.take_pool());
        self.first_mesh = first_mesh;
        self.adopt_mesh(&birth, &qualities, &steps, adjacency);
        Ok(true)
    }
}
