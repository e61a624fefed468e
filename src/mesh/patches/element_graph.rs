//! Dual graph of a mesh: groups of elements with their size and boundary, and the facets that they share.

use super::ElementPatches;
use crate::math::{Vector, cofactor};
use crate::mesh::{ElementId, Simplex, edges, signed_volume};
use std::f64::consts::PI;

/// Dual graph of a mesh: a vertex for each group of elements, a link for each two groups that share facets.
pub(super) struct ElementGraph<const D: usize> {
    /// Area or volume of each group, m² or m³.
    measure: Vec<f64>,
    /// Length or area of the boundary of each group, m or m².
    surface: Vec<f64>,
    /// Offsets: the links of group g are `links[start[g]..start[g + 1]]`, by ascending neighbour.
    start: Vec<u32>,
    links: Vec<GraphLink>,
}

/// Link to a neighbouring group.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct GraphLink {
    /// Neighbouring group.
    pub to: ElementId,
    /// Length or area of the common boundary, m or m².
    shared: f64,
}

impl<const D: usize> ElementGraph<D> {
    /// Builds the graph with one group per element.
    pub fn new(nodes: &[Vector<D>], elements: &[Simplex], across: &[[Option<ElementId>; 4]]) -> Self {
        let n = elements.len();
        let mut graph = Self::with_capacity(n, (D + 1) * n);
        for (simplex, across) in elements.iter().zip(across) {
            let sizes = facet_sizes(&edges(nodes, simplex));
            let links = across.iter().zip(sizes).filter_map(|(to, shared)| to.map(|to| GraphLink { to, shared }));
            graph.push(signed_volume(nodes, simplex), sizes.iter().sum(), links);
        }
        graph
    }

    fn with_capacity(n_groups: usize, n_links: usize) -> Self {
        let mut start = Vec::with_capacity(n_groups + 1);
        start.push(0);
        let (measure, surface) = (Vec::with_capacity(n_groups), Vec::with_capacity(n_groups));
        Self { measure, surface, start, links: Vec::with_capacity(n_links) }
    }

    /// Adds a group; links to the same neighbour are merged.
    fn push(&mut self, measure: f64, surface: f64, links: impl Iterator<Item = GraphLink>) {
        let first = self.links.len();
        self.links.extend(links);
        self.links[first..].sort_by_key(|link| link.to);
        let mut last = first;
        for i in first..self.links.len() {
            let link = self.links[i];
            if last > first && self.links[last - 1].to == link.to {
                self.links[last - 1].shared += link.shared;
            } else {
                self.links[last] = link;
                last += 1;
            }
        }
        self.links.truncate(last);
        self.start.push(last as u32);
        self.measure.push(measure);
        self.surface.push(surface);
    }

    /// Contracts the graph: the groups of each patch become one. `patch` names the patch of each group.
    pub fn contracted(&self, patches: &ElementPatches, patch: &[ElementId]) -> Self {
        let mut graph = Self::with_capacity(patches.len(), self.links.len());
        for (p, groups) in (0..).map(ElementId).zip(patches.iter()) {
            let links = groups.iter().flat_map(|&g| self.links(g));
            let links = links.map(|link| GraphLink { to: patch[link.to.index()], shared: link.shared });
            let outer = links.filter(|link| link.to != p);
            let (measure, surface) = self.measure_and_boundary(groups);
            graph.push(measure, surface, outer);
        }
        graph
    }

    /// Iterates over the groups.
    pub fn groups(&self) -> impl Iterator<Item = ElementId> + use<D> {
        (0..self.measure.len() as u32).map(ElementId)
    }

    /// Links of a group to its neighbours.
    pub fn links(&self, group: ElementId) -> &[GraphLink] {
        &self.links[self.start[group.index()] as usize..self.start[group.index() + 1] as usize]
    }

    /// Measure and boundary of the union of groups.
    fn measure_and_boundary(&self, groups: &[ElementId]) -> (f64, f64) {
        let inner = |g| self.links(g).iter().filter(|link| groups.contains(&link.to));
        let surface = |g: ElementId| self.surface[g.index()] - inner(g).map(|link| link.shared).sum::<f64>();
        groups.iter().fold((0.0, 0.0), |(m, s), &g| (m + self.measure[g.index()], s + surface(g)))
    }

    /// Compactness of the union of groups in millionths: the isoperimetric quotient 4πA/l² in the plane, 36πV²/A³ in
    /// space. A ball has a million. The square is the best quadrilateral, the regular octahedron the best union of four
    /// tetrahedra.
    ///
    /// The value is rounded: congruent shapes of a lattice are equal, and round-off does not choose between them.
    pub fn compactness(&self, groups: &[ElementId]) -> u32 {
        let (measure, surface) = self.measure_and_boundary(groups);
        let quotient = match D {
            2 => 4.0 * PI * measure / (surface * surface),
            _ => 36.0 * PI * measure * measure / (surface * surface * surface),
        };
        (1e6 * quotient).round() as u32
    }
}

/// Length or area of the facet opposite each node: |cof(edges) G_a|/(D − 1)!, with the gradients G of the reference
/// simplex.
fn facet_sizes<const D: usize>(edges: &crate::math::Tensor<D>) -> [f64; 4] {
    let normals = cofactor(edges);
    let factorial = (D - 1) as f64;
    let first: Vector<D> = -normals.column_sum();
    std::array::from_fn(|a| match a {
        0 => first.norm() / factorial,
        a if a <= D => normals.column(a - 1).norm() / factorial,
        _ => 0.0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{ElementPatches, NodeId, face_neighbours};

    fn graph_of<const D: usize>(points: &[[f64; D]], elements: &[[u32; 4]]) -> ElementGraph<D> {
        let nodes: Vec<_> = points.iter().map(|point| Vector::<D>::from(*point)).collect();
        let elements: Vec<_> = elements.iter().map(|nodes| nodes.map(NodeId)).collect();
        ElementGraph::new(&nodes, &elements, &face_neighbours::<D>(&elements))
    }

    /// A regular octahedron of four tetrahedra around the z axis.
    fn octahedron(size: f64) -> ElementGraph<3> {
        let points =
            [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
        let elements = [[0, 2, 3, 1], [0, 3, 4, 1], [0, 4, 5, 1], [0, 5, 2, 1]];
        graph_of(&points.map(|x| x.map(|x| x * size)), &elements)
    }

    #[test]
    fn compactness_is_that_of_square_and_octahedron_in_any_unit() {
        for size in [1.0, 1e-3, 3.7e2] {
            let square = graph_of(&[[0.0, 0.0], [size, 0.0], [size, size], [0.0, size]], &[[0, 1, 2, 0], [0, 2, 3, 0]]);
            assert_eq!(square.compactness(&[0, 1].map(ElementId)), (1e6 * PI / 4.0).round() as u32);
            let expected = (1e6 * PI / (3.0 * 3.0_f64.sqrt())).round() as u32;
            assert_eq!(octahedron(size).compactness(&[0, 1, 2, 3].map(ElementId)), expected);
        }
    }

    #[test]
    fn contracted_groups_keep_their_size_and_share_their_facets() {
        let graph = octahedron(2.0);
        let patches = ElementPatches { start: vec![0, 2, 4], members: (0..4).map(ElementId).collect() };
        let halves = graph.contracted(&patches, &[0, 0, 1, 1].map(ElementId));
        let size = |(measure, surface): (f64, f64)| [measure, surface].map(|x| (x * 1e9).round());
        assert_eq!(
            size(halves.measure_and_boundary(&[0, 1].map(ElementId))),
            size(graph.measure_and_boundary(&[0, 1, 2, 3].map(ElementId)))
        );
        assert_eq!(halves.links(ElementId(0)).len(), 1);
        assert!((halves.links(ElementId(0))[0].shared - 8.0).abs() < 1e-12, "two triangles of 4 m² each");
    }
}
