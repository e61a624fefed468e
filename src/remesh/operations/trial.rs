//! Trial of an operation: whether it is legal, and the elements that it would make.

use super::editable_mesh::{EditableMesh, RestMap};
use super::element_model::{ElementModel, ElementState};
use super::operation::{EditedNode, Operation, OperationKind};
use crate::math::Vector;
use crate::mesh::{CORNERS, NodeId, shape_quality, signed_volume};

/// Limits of the shape of the elements that an operation makes; a cavity that is worse already may stay as it is.
const LEAST_JACOBIAN: f64 = 0.05;
/// J that also an element in the place of an inverted one must have.
const POSITIVE_JACOBIAN: f64 = 0.01;
const LEAST_REST_QUALITY: f64 = 0.06;
const LEAST_SPLIT_REST_QUALITY: f64 = 0.1;
const LEAST_QUALITY: f64 = 0.02;
/// Quality, relative to that of the old cavity, that a worse cavity must have.
const WORSE: f64 = 1.05;
/// Relative change of the rest volume of a cavity by rounding.
const ROUNDING: f64 = 1e-9;
/// Relative change of the volume of a cavity by which a surface without a rest map may be smoothed.
const SMOOTHING: f64 = 5e-3;
/// Relative change of the volume of a cavity by the push of the middle of a split edge out of a body.
const CLEARED: f64 = 0.3;

/// Cavity after an operation.
#[derive(Debug, Clone)]
pub struct Trial {
    /// States of the new elements.
    pub states: Vec<ElementState>,
    /// Greatest hindrance in the cavity before and after.
    pub hindrance: [f64; 2],
}

fn greatest_hindrance(states: &[ElementState]) -> f64 {
    states.iter().map(|state| state.hindrance).fold(0.0, f64::max)
}

/// Shapes of the elements of a cavity.
struct CavityShape {
    /// Area or volume at rest.
    rest: f64,
    /// Least quality at rest and now.
    quality: [f64; 2],
}

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
        let old: Vec<ElementState> = operation.old.iter().map(|element| self.state(*element, model)).collect();
        let most_compressed = old.iter().map(|state| state.jacobian).fold(f64::INFINITY, f64::min);
        let least_jacobian = LEAST_JACOBIAN.min((WORSE * most_compressed).max(POSITIVE_JACOBIAN));
        let (mut states, mut volume) = (Vec::with_capacity(operation.new.len()), 0.0);
        for nodes in &operation.new {
            let [rest, now] = self.places(nodes, operation, true);
            volume += signed_volume(&rest, &CORNERS);
            if shape_quality(&rest, &CORNERS) < least_rest || shape_quality(&now, &CORNERS) < least_now {
                return None;
            }
            let state = model.state(&rest, &now);
            if !(state.jacobian >= least_jacobian && state.energy.is_finite()) {
                return None;
            }
            states.push(state);
        }
        let change = match self.rest_map {
            RestMap::Present if is_split => CLEARED,
            RestMap::Present => SMOOTHING,
            RestMap::Nodes => ROUNDING,
        };
        if (volume - before.rest).abs() > change * before.rest {
            return None;
        }
        let hindrance = [greatest_hindrance(&old), greatest_hindrance(&states)];
        Some(Trial { states, hindrance })
    }

    /// State of a node after an operation.
    pub(super) fn after(&self, operation: &Operation<D>, node: NodeId) -> EditedNode<D> {
        match operation.node {
            Some((moved, state)) if moved == node => state,
            _ => self.nodes[node.index()],
        }
    }

    /// Rest positions and positions of the corners of a simplex, before or after an operation.
    fn places(&self, nodes: &[NodeId; 4], operation: &Operation<D>, is_after: bool) -> [[Vector<D>; 4]; 2] {
        let of = |k: usize| {
            let node = nodes[k.min(D)];
            if is_after { self.after(operation, node) } else { self.nodes[node.index()] }
        };
        [std::array::from_fn(|k| of(k).rest), std::array::from_fn(|k| of(k).position)]
    }
}
