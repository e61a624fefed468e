//! Conforming simplicial meshes: rest positions, elements, boundary facets and displacement constraints.

mod axis;
mod builder;
mod octree;
mod octree_templates;
mod patches;
mod quality;
mod shapes;
mod structured;
mod topology;

use crate::math::Vector;

pub use axis::{graded, uniform, uniform_divisible};
pub use octree::OctreeGrading;
pub use patches::ElementPatches;
pub use quality::{is_worse, least_angle, poor_quality, shape_quality, travel_bound};
pub use shapes::{BlockSpec, FaceConstraint, HeldFace, block, cylinder, l_beam, shell, shell_planes};
pub use structured::{CellSplit, RectilinearGrid};
pub use topology::{FACES, NodeIncidence, boundary, boundary_from_neighbours, face_neighbours};
pub(crate) use topology::{facet, sorted};

/// Index of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct NodeId(pub u32);

/// Index of an element or patch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct ElementId(pub u32);

impl NodeId {
    /// Index into the arrays of nodes.
    #[must_use]
    #[inline]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl ElementId {
    /// Index into the arrays of elements.
    #[must_use]
    #[inline]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// Triangle or tetrahedron: its first `D + 1` nodes count, positively oriented.
pub type Simplex = [NodeId; 4];

/// Corners of a simplex by itself, whose nodes are its own.
pub(crate) const CORNERS: Simplex = [NodeId(0), NodeId(1), NodeId(2), NodeId(3)];
/// Boundary edge or triangle: its first `D` nodes count, outward oriented.
pub type Facet = [NodeId; 3];

/// Load marker of the facets that stem from the entry surface of a gel whose cavity is not vented.
pub const CAVITY_MARK: u8 = 1 << 7;

/// Conforming mesh at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh<const D: usize> {
    /// Rest positions of the nodes, m.
    pub rest: Vec<Vector<D>>,
    /// Elements.
    pub elements: Vec<Simplex>,
    /// Boundary facets.
    pub facets: Vec<Facet>,
    /// Held directions of each node.
    pub held: Vec<[bool; D]>,
    /// Loads on each boundary facet: bit i is set if the i-th load acts, [`CAVITY_MARK`] on the wall of
    /// a cavity; empty where there are none.
    pub marks: Vec<u8>,
}

impl<const D: usize> Mesh<D> {
    /// Builds a mesh with free nodes; the boundary follows from the elements.
    ///
    /// # Panics
    /// If an element names a node that does not exist, or is not positively oriented.
    #[must_use]
    pub fn new(rest: Vec<Vector<D>>, elements: Vec<Simplex>) -> Self {
        for (e, nodes) in elements.iter().enumerate() {
            assert!(nodes[..=D].iter().all(|n| n.index() < rest.len()), "element {e} names a node that does not exist");
            assert!(signed_volume(&rest, nodes) > 0.0, "element {e} must be positively oriented");
        }
        let facets = boundary::<D>(&elements);
        let held = vec![[false; D]; rest.len()];
        Self { rest, elements, facets, held, marks: vec![] }
    }

    /// Area or volume of an element at rest, m² or m³.
    #[must_use]
    pub fn measure(&self, element: &Simplex) -> f64 {
        signed_volume(&self.rest, element)
    }

    /// Permutes the elements: element i of the result is element `order[i]`. Nodes and facets stay.
    ///
    /// # Panics
    /// If `order` does not name every element once.
    #[must_use]
    pub fn reordered(mut self, order: &[ElementId]) -> Self {
        let mut named = vec![false; self.elements.len()];
        for element in order {
            let twice = std::mem::replace(&mut named[element.index()], true);
            assert!(!twice, "element {} stands twice in the new order", element.0);
        }
        assert!(named.iter().all(|&named| named), "the new order leaves out elements");
        self.elements = order.iter().map(|element| self.elements[element.index()]).collect();
        self
    }

    /// Permutes the nodes: node i of the result is node `order[i]`. The elements keep their order.
    ///
    /// # Panics
    /// If `order` does not name every node once.
    #[must_use]
    pub fn renumbered(mut self, order: &[NodeId]) -> Self {
        const UNNAMED: NodeId = NodeId(u32::MAX);
        assert_eq!(order.len(), self.rest.len(), "the new order names every node");
        let mut new = vec![UNNAMED; order.len()];
        for (number, node) in (0..).map(NodeId).zip(order) {
            let previous = std::mem::replace(&mut new[node.index()], number);
            assert_eq!(previous, UNNAMED, "node {} stands twice in the new order", node.0);
        }
        self.rest = order.iter().map(|node| self.rest[node.index()]).collect();
        self.held = order.iter().map(|node| self.held[node.index()]).collect();
        // Entries of an element beyond its corners name no node; a facet of the plane repeats its last node.
        let corners = self.elements.iter_mut().flat_map(|element| &mut element[..=D]);
        corners.chain(self.facets.iter_mut().flatten()).for_each(|node| *node = new[node.index()]);
        self
    }
}

/// Signed area or volume of a simplex: det(x₁ − x₀, …)/D!.
#[must_use]
pub fn signed_volume<const D: usize>(x: &[Vector<D>], nodes: &Simplex) -> f64 {
    let factorial = if D == 2 { 2.0 } else { 6.0 };
    crate::math::det(&edges(x, nodes)) / factorial
}

/// Length of a boundary edge, m, or area of a boundary triangle, m².
#[must_use]
pub fn facet_measure<const D: usize>(x: &[Vector<D>], facet: &Facet) -> f64 {
    let [edge, across] = [1, 2].map(|k| crate::math::embed(&(x[facet[k].index()] - x[facet[0].index()])));
    if D == 2 { edge.norm() } else { 0.5 * edge.cross(&across).norm() }
}

/// Edge vectors from the first node of a simplex, as columns.
#[must_use]
pub fn edges<const D: usize>(x: &[Vector<D>], nodes: &Simplex) -> crate::math::Tensor<D> {
    let origin = x[nodes[0].index()];
    crate::math::Tensor::<D>::from_fn(|i, j| x[nodes[j + 1].index()][i] - origin[i])
}
