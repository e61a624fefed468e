//! A mesh that a run has made for itself.

use super::Tick;
use crate::fem::Reference;
use crate::math::{Vector, det};
use crate::mesh::{ElementId, Mesh, NodeId, Simplex, boundary, signed_volume};

/// A mesh that has replaced another one, as it was when it did.
#[derive(Debug, Clone, PartialEq)]
pub struct Birth<const D: usize> {
    /// When.
    pub tick: Tick,
    /// Where the matter of its nodes was at the start, and who is next to whom.
    pub mesh: Mesh<D>,
    /// Where its nodes were then, m.
    pub position: Vec<Vector<D>>,
    /// Their masses, kg.
    pub mass: Vec<f64>,
    /// The masses of the corners of its elements, kg; 0 of a fourth corner in the plane.
    pub corner_mass: Vec<[f64; 4]>,
    /// Those elements that are at rest not what their nodes say.
    pub references: Vec<(ElementId, Reference<D>)>,
    /// The stable steps of its elements with what they remembered then, s, by which they are ordered; none before it is stepped, or if
    /// it is that of the start.
    pub steps: Vec<f64>,
}

impl<const D: usize> Birth<D> {
    /// From arrays that nobody has looked at yet; `None` if they are no mesh.
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

    /// The held directions of each node: bit i for the i-th.
    pub(super) fn held(&self) -> Vec<u8> {
        self.mesh.held.iter().map(|held| (0..D).map(|i| u8::from(held[i]) << i).sum()).collect()
    }
}

/// The nodes of an element as numbers.
pub(super) fn numbers(simplex: &Simplex) -> [u32; 4] {
    simplex.map(|node| node.0)
}

/// The element of these nodes.
pub(super) fn simplex(numbers: [u32; 4]) -> Simplex {
    numbers.map(NodeId)
}
