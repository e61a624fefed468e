//! Discretised gel: masses, elements, held directions and surface; what does not change while a mesh lasts.

use super::PressureLoads;
use crate::contact::{ContactSurface, NodalMasses};
use crate::fem::{ElementStates, HistoryVariables, Potential};
use crate::math::Vector;
use crate::mesh::{ElementId, Facet, NodeId, NodeIncidence};

/// Discretised gel: the constant part of the model, with energy, masses, held directions and surface.
#[derive(Debug)]
pub struct DiscreteGel<const D: usize, P> {
    /// Stored energy of the elements.
    pub potential: P,
    /// Lumped masses, kg.
    pub mass: Vec<f64>,
    /// Held directions of each node: bit i for direction i.
    held: Vec<u8>,
    /// Elements at each node.
    pub star: NodeIncidence,
    /// Surface on which contact is detected.
    pub surface: ContactSurface,
    /// Element behind each facet of the surface.
    pub behind: Vec<ElementId>,
    /// Pressure loads on the surface.
    pub loads: PressureLoads,
    /// Axes normal to the planes of symmetry, ascending, in the coordinates of the gel; 0 for a gel about an axis.
    pub mirrored: &'static [usize],
    /// True if contact of the gel with itself is detected.
    pub meets_itself: bool,
}

impl<const D: usize, P: Potential<D>> DiscreteGel<D, P> {
    /// Builds the gel from an energy, the masses, the held directions and the surface.
    ///
    /// # Panics
    /// If the lengths differ or a mass is not positive.
    #[must_use]
    pub fn new(potential: P, mass: Vec<f64>, held: &[[bool; D]], surface: ContactSurface) -> Self {
        assert_eq!(mass.len(), held.len(), "every node has a mass and its held directions");
        assert!(mass.iter().all(|m| *m > 0.0), "every node needs a positive mass");
        let elements = (0..potential.len() as u32).map(|element| potential.nodes(ElementId(element)));
        let star = NodeIncidence::new(mass.len(), elements);
        let held = held.iter().map(|held| (0..D).map(|i| u8::from(held[i]) << i).sum()).collect();
        let owner = |facet: &Facet| {
            let has_all =
                |element: &&ElementId| facet[..D].iter().all(|node| potential.nodes(**element).contains(node));
            star.of(facet[0]).iter().find(has_all).copied().expect("a facet bounds an element")
        };
        let behind = surface.facets.iter().map(owner).collect();
        Self {
            potential,
            mass,
            held,
            star,
            surface,
            behind,
            loads: PressureLoads::none(),
            mirrored: &[],
            meets_itself: false,
        }
    }

    /// Sets the pressure loads.
    #[must_use]
    pub fn with_loads(mut self, loads: PressureLoads) -> Self {
        self.loads = loads;
        self
    }

    /// Sets the planes of symmetry through the origin, given by their normal axes, or the axis of rotation: no
    /// surface node passes them.
    ///
    /// # Panics
    /// If the axes do not ascend.
    #[must_use]
    pub fn mirrored(mut self, axes: &'static [usize]) -> Self {
        assert!(axes.is_sorted(), "planes of symmetry stand in the order of their axes");
        self.mirrored = axes;
        self
    }

    /// Sets whether contact of the gel with itself is detected.
    #[must_use]
    pub fn with_self_contact(mut self, meets_itself: bool) -> Self {
        self.meets_itself = meets_itself;
        self
    }

    /// Returns the projection P_a onto the free directions of a node: 1 in free directions, 0 in held ones.
    #[inline]
    #[must_use]
    pub fn free(&self, node: usize) -> Vector<D> {
        Vector::<D>::from_fn(|i, _| if self.held[node] >> i & 1 == 1 { 0.0 } else { 1.0 })
    }

    /// Returns the held directions of `N` nodes from a first one on: bit k for direction k.
    #[inline]
    pub(super) fn held_from<const N: usize>(&self, first: usize) -> &[u8; N] {
        self.held[first..].first_chunk().expect("there are so many nodes")
    }

    /// Returns the held directions of a node.
    #[must_use]
    pub fn held(&self, node: usize) -> [bool; D] {
        std::array::from_fn(|i| self.held[node] >> i & 1 == 1)
    }

    /// Returns true if a node is held in no direction.
    #[inline]
    #[must_use]
    pub fn is_free(&self, node: usize) -> bool {
        self.held[node] == 0
    }

    /// Returns the stored energy for nodes at these positions, J.
    #[must_use]
    pub fn stored_energy(&self, x: &[Vector<D>], memory: &[HistoryVariables<D>]) -> f64 {
        let energy = self.measure(x, memory).energy;
        crate::math::ordered_sum(energy.len(), 0.0, |patch| energy[patch])
    }

    /// Returns the history variables of undeformed elements.
    #[must_use]
    pub fn fresh_memory(&self) -> Vec<HistoryVariables<D>> {
        vec![HistoryVariables::default(); self.n_memories()]
    }

    /// Returns the number of history variables of all elements.
    #[must_use]
    pub fn n_memories(&self) -> usize {
        self.potential.memories() * self.potential.len()
    }

    /// Measures all elements at these positions: energies, stiffnesses and volume ratios.
    pub(super) fn measure(&self, x: &[Vector<D>], memory: &[HistoryVariables<D>]) -> ElementStates {
        self.potential.measure_all(x, memory)
    }
}

impl<const D: usize, P: Potential<D>> NodalMasses<D> for DiscreteGel<D, P> {
    #[inline]
    fn mass(&self, node: NodeId) -> f64 {
        self.mass[node.index()]
    }

    #[inline]
    fn free(&self, node: NodeId) -> Vector<D> {
        self.free(node.index())
    }
}
