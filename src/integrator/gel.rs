use super::PressureLoads;
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
}

/// Contact surface: nodes and facets.
#[derive(Debug)]
pub struct ContactSurface {
    /// Nodes in ascending order.
    pub nodes: Vec<SurfaceNode>,
    /// Index in `nodes` of each node of the gel, or `None`.
    pub of: Vec<Option<u32>>,
    /// Facets of the surface.
    pub facets: Vec<Facet>,
    /// Facets at each node.
    pub around: NodeIncidence,
}

/// Node of the contact surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceNode {
    /// Number of the node.
    pub node: NodeId,
    /// h, local size of the facets, m.
    pub size: f64,
    /// Tributary area at rest, m².
    pub area: f64,
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
        Self { potential, mass, held, star, surface, behind, loads: PressureLoads::none(), mirrored: &[] }
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

impl ContactSurface {
    /// Builds the surface from facets of `D` nodes each; `measure` gives the area of a facet at rest, m², and its
    /// size, m in the plane, m² in space.
    #[must_use]
    pub fn new<const D: usize>(n_nodes: usize, facets: Vec<Facet>, measure: impl Fn(&Facet) -> (f64, f64)) -> Self {
        let mut share = vec![(0.0, 0.0); n_nodes];
        for facet in &facets {
            let (area, extent) = measure(facet);
            for node in &facet[..D] {
                share[node.index()].0 += area / D as f64;
                share[node.index()].1 += extent / D as f64;
            }
        }
        let on_surface = share.iter().enumerate().filter(|(_, (_, extent))| *extent > 0.0);
        let size = |extent: f64| if D == 2 { extent } else { extent.sqrt() };
        let nodes: Vec<SurfaceNode> = on_surface
            .map(|(i, (area, extent))| SurfaceNode { node: NodeId(i as u32), size: size(*extent), area: *area })
            .collect();
        let mut of = vec![None; n_nodes];
        for (i, surface) in nodes.iter().enumerate() {
            of[surface.node.index()] = Some(i as u32);
        }
        let around = NodeIncidence::new(n_nodes, facets.iter().map(|facet| &facet[..D]));
        Self { nodes, of, facets, around }
    }

    /// Corrects the sizes of nodes on planes of symmetry in space. Each plane shows half of the facets of a node,
    /// so h grows by √2 for each of its `planes`.
    #[must_use]
    pub fn mirrored(mut self, planes: impl Fn(NodeId) -> usize) -> Self {
        for at in &mut self.nodes {
            (0..planes(at.node)).for_each(|_| at.size *= std::f64::consts::SQRT_2);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mirrored_surface_has_the_sizes_of_the_whole() {
        let facet = |nodes: [u32; 3]| nodes.map(NodeId);
        let size = |facets: Vec<Facet>, planes: usize| {
            let on_plane = |node: NodeId| if node.0 == 0 { planes } else { 0 };
            ContactSurface::new::<3>(5, facets, |_| (0.25, 0.25)).mirrored(on_plane).nodes[0].size
        };
        // A square about its middle, cut along its diagonals into four, and along these into a half and a quarter.
        let whole = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]].map(facet);
        let all = size(whole.to_vec(), 0);
        assert!((all - (1.0_f64 / 3.0).sqrt()).abs() < 1e-15);
        assert!((size(whole[..2].to_vec(), 1) - all).abs() < 1e-15);
        assert!((size(whole[..1].to_vec(), 2) - all).abs() < 1e-15);
    }
}
