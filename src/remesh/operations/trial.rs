//! Trial of an operation: whether it is legal, and what it would change.

use super::editable_mesh::EditableMesh;
use super::element_model::{ElementModel, ElementState};
use super::operation::{Operation, OperationKind};
use crate::math::Vector;
use crate::mesh::{NodeId, shape_quality, signed_volume};

/// Limits of the shape of the elements that an operation makes; a cavity that is worse already may stay as it is.
const LEAST_JACOBIAN: f64 = 0.05;
const LEAST_REST_QUALITY: f64 = 0.06;
const LEAST_SPLIT_REST_QUALITY: f64 = 0.1;
const LEAST_QUALITY: f64 = 0.02;
/// Quality, relative to that of the old cavity, that a worse cavity must have.
const WORSE: f64 = 1.05;
/// Relative change of the rest volume of a cavity by rounding.
const ROUNDING: f64 = 1e-9;

/// Trial of an operation: what it would change.
#[derive(Debug, Clone)]
pub struct Trial {
    /// States of the new elements.
    pub states: Vec<ElementState>,
    /// Greatest frequency in the cavity before and after, 1/s.
    pub frequency: [f64; 2],
    /// Change of stored energy, J.
    pub energy: f64,
}

/// Stored energy of a cavity, J.
fn energy_of<const D: usize>(states: &[ElementState], model: &impl ElementModel<D>) -> f64 {
    let volume = states.iter().map(|state| state.volume).sum::<f64>();
    let mean = states.iter().map(|state| state.volume * state.jacobian).sum::<f64>() / volume;
    states.iter().map(|state| state.energy).sum::<f64>() + volume * model.common_energy(mean)
}

fn most_frequent(states: &[ElementState]) -> f64 {
    states.iter().map(|state| state.frequency).fold(0.0, f64::max)
}

/// Shapes of the elements of a cavity.
struct CavityShape {
    /// Area or volume at rest.
    rest: f64,
    /// Least quality at rest and now.
    quality: [f64; 2],
}

/// Corners of a simplex.
const CORNERS: [NodeId; 4] = [NodeId(0), NodeId(1), NodeId(2), NodeId(3)];

impl<const D: usize> EditableMesh<'_, D> {
    /// Tries an operation; `None` if it is not legal.
    ///
    /// The elements after it must be positive in both spaces and fill the same volume at rest: then they fill the same
    /// gel, whatever the shape of the cavity. A move may leave its elements at their places.
    pub(super) fn attempt(&mut self, operation: &Operation<D>, model: &impl ElementModel<D>) -> Option<Trial> {
        if operation.old.iter().any(|element| !self.is_compatible(*element)) {
            return None;
        }
        let mut before = CavityShape { rest: 0.0, quality: [1.0; 2] };
        for element in &operation.old {
            let [rest, now] = self.places(&self.elements[element.index()], operation, false);
            before.rest += signed_volume(&rest, &CORNERS);
            before.quality[0] = before.quality[0].min(shape_quality(&rest, &CORNERS));
            before.quality[1] = before.quality[1].min(shape_quality(&now, &CORNERS));
        }
        let is_split = operation.kind == OperationKind::Split;
        let least_rest = if is_split { LEAST_SPLIT_REST_QUALITY } else { LEAST_REST_QUALITY.min(before.quality[0]) };
        let least_now = LEAST_QUALITY.min(WORSE * before.quality[1]);
        let (mut states, mut volume) = (Vec::with_capacity(operation.new.len()), 0.0);
        for nodes in &operation.new {
            let [rest, now] = self.places(nodes, operation, true);
            volume += signed_volume(&rest, &CORNERS);
            if shape_quality(&rest, &CORNERS) < least_rest || shape_quality(&now, &CORNERS) < least_now {
                return None;
            }
            let state = model.state(&rest, &now);
            if !(state.jacobian >= LEAST_JACOBIAN && state.energy.is_finite()) {
                return None;
            }
            states.push(state);
        }
        if (volume - before.rest).abs() > ROUNDING * before.rest {
            return None;
        }
        let old: Vec<ElementState> = operation.old.iter().map(|element| self.state(*element, model)).collect();
        let frequency = [most_frequent(&old), most_frequent(&states)];
        let energy = energy_of(&states, model) - energy_of(&old, model);
        energy.is_finite().then_some(Trial { states, frequency, energy })
    }

    /// Rest positions and positions of the corners of a simplex, before or after an operation.
    fn places(&self, nodes: &[NodeId; 4], operation: &Operation<D>, is_after: bool) -> [[Vector<D>; 4]; 2] {
        let of = |k: usize| {
            let node = nodes[k.min(D)];
            match operation.node {
                Some((moved, state)) if is_after && moved == node => state,
                _ => self.nodes[node.index()],
            }
        };
        [std::array::from_fn(|k| of(k).rest), std::array::from_fn(|k| of(k).position)]
    }
}
