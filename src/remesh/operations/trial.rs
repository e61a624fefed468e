//! Trial of an operation: whether it is legal, and the elements that it would make.

use super::editable_mesh::{EditableMesh, ReferenceConfiguration};
use super::element_model::{ElementModel, ElementState};
use super::operation::{EditedNode, Operation, OperationKind};
use crate::math::Vector;
use crate::mesh::{CORNERS, ElementId, NodeId, is_worse, shape_quality, signed_volume};

/// Least J of a new element, unless the old cavity is more compressed. The prototype's value; assumed, not measured.
const LEAST_JACOBIAN: f64 = 0.05;
/// Least J of a new element in the place of an inverted one. Assumed, not measured.
const POSITIVE_JACOBIAN: f64 = 0.01;
/// Least quality at rest of a new element, unless the old cavity has less. In the prototype the rest quality falls to
/// this limit from 13 m/s on, and that costs nothing: the rest shape weighs with μ, the present one with K.
const LEAST_REST_QUALITY: f64 = 0.06;
/// Least quality at rest of an element that a split makes. In the prototype splits without this limit and that of the
/// half edge at rest made needles at the pole; the value is assumed, not measured.
const LEAST_SPLIT_REST_QUALITY: f64 = 0.1;
/// Least present quality of a new element, unless the old cavity has less. The prototype's value; assumed, not
/// measured.
const LEAST_QUALITY: f64 = 0.02;
/// Factor by which a cavity beyond the limits of J or of present quality must improve. With limits that such a cavity
/// could not pass, 28 170 visits of elements found no operation in the prototype; with relative limits, 5330. The
/// factor itself is assumed, not measured.
const WORSE: f64 = 1.05;
/// Greatest relative change of the volume of a cavity that is filled exactly, by rounding. Assumed, not measured.
const ROUNDING: f64 = 1e-9;
/// Greatest relative change of the volume of a cavity by the push of the middle of a split edge out of a body. Assumed,
/// not measured.
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

impl<const D: usize> EditableMesh<'_, D> {
    /// Tries an operation; `None` if it is not legal, or leaves a hindrance above `limit`, a function of the hindrance
    /// of the cavity before.
    ///
    /// New elements must be positive, in the reference configuration and now, and fill the reference volume of the old
    /// ones. Then they fill the same gel, whatever the shape of the cavity.
    pub(super) fn attempt(
        &self,
        operation: &Operation<D>,
        model: &impl ElementModel<D>,
        limit: impl Fn(f64) -> f64,
    ) -> Option<Trial> {
        if operation.old.iter().any(|element| !self.is_compatible(*element)) {
            return None;
        }
        let old: Vec<ElementState> = operation.old.iter().map(|element| self.state(*element, model)).collect();
        let (before, mut after) = (greatest_hindrance(&old), 0.0_f64);
        let limit = limit(before);
        let most_compressed = old.iter().map(|state| state.jacobian).fold(f64::INFINITY, f64::min);
        let least_jacobian = LEAST_JACOBIAN.min((WORSE * most_compressed).max(POSITIVE_JACOBIAN));
        let (mut states, mut volume) = (Vec::with_capacity(operation.new.len()), 0.0);
        for nodes in &operation.new {
            let [rest, now] = self.places(nodes, operation, true);
            let state = model.state(&rest, &now);
            let is_finite = state.energy.is_finite() && state.hindrance.is_finite();
            let is_legal = state.jacobian >= least_jacobian && is_finite && state.hindrance <= limit;
            if !is_legal || self.is_too_poor(operation, [&rest, &now]) {
                return None;
            }
            volume += signed_volume(&rest, &CORNERS);
            after = after.max(state.hindrance);
            states.push(state);
        }
        let smoothing = || model.smoothing(old.iter().map(|state| state.volume).sum());
        let is_legal = self.fills(operation, volume, smoothing) && self.keeps_topology(operation);
        is_legal.then_some(Trial { states, hindrance: [before, after] })
    }

    /// Returns true if an element with these corners at rest and now has a worse shape than an operation may make.
    fn is_too_poor(&self, operation: &Operation<D>, [rest, now]: [&[Vector<D>; 4]; 2]) -> bool {
        let is_split = operation.kind == OperationKind::Split;
        let least_rest = if is_split { LEAST_SPLIT_REST_QUALITY } else { LEAST_REST_QUALITY };
        let is_poor = |x: &[Vector<D>; 4], least: f64| is_worse(x, &CORNERS, least);
        let before = |side: usize| {
            let quality = |element: &ElementId| {
                shape_quality(&self.places(&self.elements[element.index()], operation, false)[side], &CORNERS)
            };
            operation.old.iter().map(quality).fold(1.0, f64::min)
        };
        is_poor(rest, least_rest) && (is_split || is_poor(rest, before(0)))
            || is_poor(now, LEAST_QUALITY) && is_poor(now, WORSE * before(1))
    }

    /// Returns true if the new elements, of this reference volume, fill the cavity of an operation, as nearly as its
    /// kind and the configuration allow: within the relative change `smoothing` where the operation smooths the
    /// surface.
    fn fills(&self, operation: &Operation<D>, volume: f64, smoothing: impl FnOnce() -> f64) -> bool {
        let rest = |element: &ElementId| {
            signed_volume(&self.places(&self.elements[element.index()], operation, false)[0], &CORNERS)
        };
        let before: f64 = operation.old.iter().map(rest).sum();
        let change = match self.configuration {
            ReferenceConfiguration::Present if !self.changes_surface(operation) => ROUNDING,
            ReferenceConfiguration::Present if operation.kind == OperationKind::Split => CLEARED,
            ReferenceConfiguration::Present => smoothing().max(ROUNDING),
            ReferenceConfiguration::Rest => ROUNDING,
        };
        (volume - before).abs() <= change * before
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
