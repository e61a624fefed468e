//! Mesh instance: a mesh that a run has made by remeshing.

use super::Tick;
use crate::constitutive::MaterialParts;
use crate::fem::ReferenceShape;
use crate::math::{Vector, det};
use crate::mesh::{ElementId, ElementPatches, Mesh, NodeId, Simplex, boundary, signed_volume};

/// Mesh instance: a remeshed mesh at the tick at which it replaced another one.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshInstance<const D: usize> {
    /// Tick of the remesh.
    pub tick: Tick,
    /// Mesh with the rest positions of its nodes.
    pub mesh: Mesh<D>,
    /// Positions of its nodes at the remesh, m.
    pub position: Vec<Vector<D>>,
    /// Masses of its nodes, kg.
    pub mass: Vec<f64>,
    /// Masses of the corners of its elements, kg; 0 for a fourth corner in the plane.
    pub corner_mass: Vec<[f64; 4]>,
    /// Reference shapes of the elements that are incompatible with their nodes' rest positions.
    pub references: Vec<(ElementId, ReferenceShape<D>)>,
    /// F-bar patches of its elements.
    pub patches: ElementPatches,
    /// Parts of mass of the materials of its elements; empty of a gel of one material.
    pub parts: Vec<MaterialParts>,
    /// Stable steps of its elements with their history variables at the remesh, s, by which they are ordered; empty
    /// until they are known, and of the first mesh.
    pub steps: Vec<f64>,
}

/// Unchecked arrays of a mesh instance, in the order of its binary form.
#[derive(Debug, Default)]
pub(super) struct InstanceArrays<const D: usize> {
    /// Rest positions of the nodes, m.
    pub rest: Vec<Vector<D>>,
    /// Positions of the nodes at the remesh, m.
    pub position: Vec<Vector<D>>,
    /// Masses of the nodes, kg.
    pub mass: Vec<f64>,
    /// Held directions of the nodes: bit i for the i-th.
    pub held: Vec<u8>,
    /// Nodes of the elements.
    pub elements: Vec<Simplex>,
    /// Masses of the corners of the elements, kg.
    pub corner_mass: Vec<[f64; 4]>,
    /// Reference shapes of the incompatible elements.
    pub references: Vec<(ElementId, ReferenceShape<D>)>,
    /// Patch of each element.
    pub patch: Vec<u32>,
    /// Parts of mass of the materials of the elements; empty of a gel of one material.
    pub parts: Vec<MaterialParts>,
    /// Stable steps of the elements, s.
    pub steps: Vec<f64>,
}

impl<const D: usize> MeshInstance<D> {
    /// Creates a mesh instance from unchecked arrays; `None` if they are no valid mesh.
    pub(super) fn from_arrays(tick: Tick, arrays: InstanceArrays<D>, marks: Vec<u8>) -> Option<Self> {
        let InstanceArrays { rest, position, mass, held, elements, corner_mass, references, patch, parts, steps } =
            arrays;
        let n = rest.len();
        let reference_is_valid = |(element, reference): &(ElementId, ReferenceShape<D>)| {
            element.index() < elements.len() && det(&reference.edges) > 0.0 && reference.radius.is_finite()
        };
        let ascending = references.windows(2).all(|pair| pair[0].0 < pair[1].0);
        if elements.is_empty() || !ascending || !references.iter().all(reference_is_valid) {
            return None;
        }
        let patches = ElementPatches::of_elements::<D>(&elements, &patch)?;
        let mut is_compatible = vec![true; elements.len()];
        for (element, _) in &references {
            is_compatible[element.index()] = false;
        }
        let has_known_nodes = |simplex: &Simplex| simplex.iter().all(|node| node.index() < n);
        let is_upright = |simplex: &Simplex, is_compatible: bool| !is_compatible || signed_volume(&rest, simplex) > 0.0;
        let positions_are_finite = rest.iter().chain(&position).all(|x| x.iter().all(|x| x.is_finite()));
        let corner_masses_are_finite = corner_mass.iter().flatten().all(|mass| mass.is_finite());
        let masses_are_positive = mass.iter().all(|mass| *mass > 0.0 && mass.is_finite());
        let lengths_agree = [position.len(), mass.len(), held.len()] == [n; 3]
            && [corner_mass.len(), steps.len()] == [elements.len(); 2];
        let parts_are_valid =
            (parts.is_empty() || parts.len() == elements.len()) && parts.iter().all(are_parts_of_a_whole);
        let steps_are_positive = steps.iter().all(|step| *step > 0.0 && step.is_normal());
        let is_valid = |(simplex, is_compatible): (&Simplex, &bool)| {
            has_known_nodes(simplex) && is_upright(simplex, *is_compatible)
        };
        if !(lengths_agree
            && parts_are_valid
            && steps_are_positive
            && masses_are_positive
            && positions_are_finite
            && corner_masses_are_finite
            && elements.iter().zip(&is_compatible).all(is_valid))
        {
            return None;
        }
        let held = held.iter().map(|held| std::array::from_fn(|i| held >> i & 1 == 1)).collect();
        let facets = boundary::<D>(&elements);
        if !marks.is_empty() && marks.len() != facets.len() {
            return None;
        }
        let mesh = Mesh { rest, elements, facets, held, marks };
        Some(Self { tick, mesh, position, mass, corner_mass, references, patches, parts, steps })
    }

    /// Returns the number of the patch of each element.
    pub(super) fn patch_numbers(&self) -> Vec<u32> {
        self.patches.patch_of_elements().into_iter().map(|patch| patch.0).collect()
    }

    /// Returns the held directions of each node: bit i for the i-th.
    pub(super) fn held(&self) -> Vec<u8> {
        self.mesh.held.iter().map(|held| (0..D).map(|i| u8::from(held[i]) << i).sum()).collect()
    }
}

/// Returns true if these parts are not negative and sum to 1.
fn are_parts_of_a_whole(parts: &MaterialParts) -> bool {
    /// Round-off of the sum over a run with many remeshings.
    const ROUND_OFF: f64 = 1e-9;
    parts.iter().all(|part| *part >= 0.0) && (parts.iter().sum::<f64>() - 1.0).abs() < ROUND_OFF
}

/// Converts the nodes of an element to numbers.
pub(super) fn numbers(simplex: &Simplex) -> [u32; 4] {
    simplex.map(|node| node.0)
}

/// Converts numbers to the nodes of an element.
pub(super) fn simplex(numbers: [u32; 4]) -> Simplex {
    numbers.map(NodeId)
}
