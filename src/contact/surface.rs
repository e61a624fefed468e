//! Contact surface: nodes and facets of the gel, and the view of their motion that contact has.

use crate::math::Vector;
use crate::mesh::{Facet, NodeId, NodeIncidence};

/// Lumped masses and free directions of the nodes.
pub(crate) trait NodalMasses<const D: usize> {
    /// Returns the mass of a node, kg.
    fn mass(&self, node: NodeId) -> f64;

    /// Returns the projection onto the free directions of a node: 1 in free directions, 0 in held ones.
    fn free(&self, node: NodeId) -> Vector<D>;
}

/// View of the gel surface at a tick: all that contact detection sees of the gel.
pub(crate) trait SurfaceView<const D: usize> {
    /// Type that knows the masses.
    type Masses: NodalMasses<D>;

    /// Returns the masses and free directions of the nodes.
    fn masses(&self) -> &Self::Masses;

    /// Returns the nodes and facets of the surface.
    fn surface(&self) -> &ContactSurface;

    /// Returns the position of an active node, m.
    fn position(&self, node: NodeId) -> Vector<D>;

    /// Returns the position of any node drifted to this tick, m.
    fn drifted(&self, node: NodeId) -> Vector<D>;

    /// Returns the present velocity of a node, m/s.
    fn velocity(&self, node: NodeId) -> Vector<D>;

    /// Returns the velocity of a node before the kicks of this tick, m/s.
    fn velocity_before(&self, node: NodeId) -> Vector<D>;
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

    /// Returns h of a node, m; `None` for a node inside the gel.
    #[inline]
    pub(super) fn size(&self, node: NodeId) -> Option<f64> {
        Some(self.nodes[self.of[node.index()]? as usize].size)
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
