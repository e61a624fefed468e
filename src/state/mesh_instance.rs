//! Mesh instance: a mesh that a run has made by remeshing.

use super::Tick;
use crate::fem::Reference;
use crate::math::{Vector, det};
use crate::mesh::{ElementId, Mesh, NodeId, Simplex, boundary, signed_volume};

/// Mesh instance: a remeshed mesh at the tick at which it replaced another one.
#[derive(Debug, Clone, PartialEq)]
pub struct Birth<const D: usize> {
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
    pub references: Vec<(ElementId, Reference<D>)>,
    /// Stable steps of its elements with their history variables at the remesh, s, by which they are ordered; empty
    /// before it is stepped, or if it is the first mesh.
    pub steps: Vec<f64>,
}

impl<const D: usize> Birth<D> {
    /// Creates a mesh instance from unchecked arrays; `None` if they are no valid mesh.
    pub(super) fn of(
        tick: Tick,
        (rest, position): (Vec<Vector<D>>, Vec<Vector<D>>),
        (mass, held): (Vec<f64>, &[u8]),
        (elements, corner_mass): (Vec<Simplex>, Vec<[f64; 4]>),
        (references, steps, marks): (Vec<(ElementId, Reference<D>)>, Vec<f64>, Vec<u8>),
    ) -> Option<Self> {
        let n = rest.len();
        let whole = |(element, reference): &(ElementId, Reference<D>)| {
            element.index() < elements.len() && det(&reference.edges) > 0.0 && reference.radius.is_finite()
        };
        let ascending = references.windows(2).all(|pair| pair[0].0 < pair[1].0);
        if elements.is_empty() || !ascending || !references.iter().all(whole) {
            return None;
        }
        let mut told = vec![true; elements.len()];
        for (element, _) in &references {
            told[element.index()] = false;
        }
        let known = |simplex: &Simplex| simplex.iter().all(|node| node.index() < n);
        let upright = |simplex: &Simplex, told: bool| !told || signed_volume(&rest, simplex) > 0.0;
        let placed = rest.iter().chain(&position).all(|x| x.iter().all(|x| x.is_finite()));
        let weighed = corner_mass.iter().flatten().all(|mass| mass.is_finite());
        let heavy = mass.iter().all(|mass| *mass > 0.0 && mass.is_finite());
        let counted = [position.len(), mass.len(), held.len()] == [n; 3]
            && [corner_mass.len(), steps.len()] == [elements.len(); 2];
        let stepped = steps.iter().all(|step| *step > 0.0 && step.is_normal());
        let sound = |(simplex, told): (&Simplex, &bool)| known(simplex) && upright(simplex, *told);
        if !(counted && stepped && heavy && placed && weighed && elements.iter().zip(&told).all(sound)) {
            return None;
        }
        let held = held.iter().map(|held| std::array::from_fn(|i| held >> i & 1 == 1)).collect();
        let facets = boundary::<D>(&elements);
        if !marks.is_empty() && marks.len() != facets.len() {
            return None;
        }
        let mesh = Mesh { rest, elements, facets, held, marks };
        Some(Self { tick, mesh, position, mass, corner_mass, references, steps })
    }

    /// Returns the held directions of each node: bit i for the i-th.
    pub(super) fn held(&self) -> Vec<u8> {
        self.mesh.held.iter().map(|held| (0..D).map(|i| u8::from(held[i]) << i).sum()).collect()
    }
}

/// Converts the nodes of an element to numbers.
pub(super) fn numbers(simplex: &Simplex) -> [u32; 4] {
    simplex.map(|node| node.0)
}

/// Converts numbers to the nodes of an element.
pub(super) fn simplex(numbers: [u32; 4]) -> Simplex {
    numbers.map(NodeId)
}
