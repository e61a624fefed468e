//! Groups of elements, their size and surface, and what they share.

use super::Patches;
use crate::math::{Vector, cofactor};
use crate::mesh::{ElementId, Simplex, edges, signed_volume};
use std::f64::consts::PI;

/// The dual graph of a mesh: a vertex for each group of elements, a link for each two that share facets.
pub(super) struct Dual<const D: usize> {
    /// Area or volume of each group, m² or m³.
    measure: Vec<f64>,
    /// Length or area of its boundary, m or m².
    surface: Vec<f64>,
    /// The links of group g are `links[start[g]..start[g + 1]]`, by ascending neighbour.
    start: Vec<u32>,
    links: Vec<Link>,
}

/// A neighbour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Link {
    /// Which group it is.
    pub to: ElementId,
    /// Length or area of the common boundary, m or m².
    shared: f64,
}

impl<const D: usize> Dual<D> {
    /// Each element a group.
    pub fn new((nodes, elements): (&[Vector<D>], &[Simplex]), across: &[[Option<ElementId>; 4]]) -> Self {
        let n = elements.len();
        let mut dual = Self::with_capacity(n, (D + 1) * n);
        for (simplex, across) in elements.iter().zip(across) {
            let sizes = facet_sizes(&edges(nodes, simplex));
            let links = across.iter().zip(sizes).filter_map(|(to, shared)| to.map(|to| Link { to, shared }));
            dual.push((signed_volume(nodes, simplex), sizes.iter().sum()), links);
        }
        dual
    }

    fn with_capacity(n_groups: usize, n_links: usize) -> Self {
        let mut start = Vec::with_capacity(n_groups + 1);
        start.push(0);
        let (measure, surface) = (Vec::with_capacity(n_groups), Vec::with_capacity(n_groups));
        Self { measure, surface, start, links: Vec::with_capacity(n_links) }
    }

    /// Adds a group; links to the same neighbour become one.
    fn push(&mut self, (measure, surface): (f64, f64), links: impl Iterator<Item = Link>) {
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

    /// The groups of this graph put together in patches; `patch` tells in which one each group is.
    pub fn joined(&self, patches: &Patches, patch: &[ElementId]) -> Self {
        let mut dual = Self::with_capacity(patches.len(), self.links.len());
        for (p, groups) in (0..).map(ElementId).zip(patches.iter()) {
            let links = groups.iter().flat_map(|&g| self.links(g));
            let links = links.map(|link| Link { to: patch[link.to.index()], shared: link.shared });
            let outer = links.filter(|link| link.to != p);
            dual.push(self.extent(groups), outer);
        }
        dual
    }

    /// Every group.
    pub fn groups(&self) -> impl Iterator<Item = ElementId> + use<D> {
        (0..self.measure.len() as u32).map(ElementId)
    }

    /// The neighbours of a group.
    pub fn links(&self, group: ElementId) -> &[Link] {
        &self.links[self.start[group.index()] as usize..self.start[group.index() + 1] as usize]
    }

    /// Measure and boundary of the union of some groups.
    fn extent(&self, groups: &[ElementId]) -> (f64, f64) {
        let inner = |g| self.links(g).iter().filter(|link| groups.contains(&link.to));
        let surface = |g: ElementId| self.surface[g.index()] - inner(g).map(|link| link.shared).sum::<f64>();
        groups.iter().fold((0.0, 0.0), |(m, s), &g| (m + self.measure[g.index()], s + surface(g)))
    }

    /// How compact the union of some groups is, in millionths: its isoperimetric quotient 4πA/l² in the plane, 36πV²/A³ in
    /// space; a million for a ball. The square is the best of quadrilaterals, the regular octahedron the best of its kind.
    ///
    /// Rounded, so that in a lattice equal shapes are equal and round-off does not choose between them.
    pub fn compactness(&self, groups: &[ElementId]) -> u32 {
        let (measure, surface) = self.extent(groups);
        let quotient = match D {
            2 => 4.0 * PI * measure / (surface * surface),
            _ => 36.0 * PI * measure * measure / (surface * surface * surface),
        };
        (1e6 * quotient).round() as u32
    }
}

/// Length or area of the facet opposite each node: |cof(edges) G_a|/(D − 1)!, with G the gradients of the reference simplex.
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
    use crate::mesh::{NodeId, Patches, neighbours};

    fn dual<const D: usize>(points: &[[f64; D]], elements: &[[u32; 4]]) -> Dual<D> {
        let nodes: Vec<_> = points.iter().map(|point| Vector::<D>::from(*point)).collect();
        let elements: Vec<_> = elements.iter().map(|nodes| nodes.map(NodeId)).collect();
        Dual::new((&nodes, &elements), &neighbours::<D>(&elements))
    }

    /// A regular octahedron of four tetrahedra around the z axis.
    fn octahedron(size: f64) -> Dual<3> {
        let points =
            [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
        let elements = [[0, 2, 3, 1], [0, 3, 4, 1], [0, 4, 5, 1], [0, 5, 2, 1]];
        dual(&points.map(|x| x.map(|x| x * size)), &elements)
    }

    #[test]
    fn compactness_is_that_of_square_and_octahedron_in_any_unit() {
        for size in [1.0, 1e-3, 3.7e2] {
            let square = dual(&[[0.0, 0.0], [size, 0.0], [size, size], [0.0, size]], &[[0, 1, 2, 0], [0, 2, 3, 0]]);
            assert_eq!(square.compactness(&[0, 1].map(ElementId)), (1e6 * PI / 4.0).round() as u32);
            let expected = (1e6 * PI / (3.0 * 3.0_f64.sqrt())).round() as u32;
            assert_eq!(octahedron(size).compactness(&[0, 1, 2, 3].map(ElementId)), expected);
        }
    }

    #[test]
    fn joined_groups_keep_their_size_and_share_their_facets() {
        let dual = octahedron(2.0);
        let patches = Patches { start: vec![0, 2, 4], members: (0..4).map(ElementId).collect() };
        let halves = dual.joined(&patches, &[0, 0, 1, 1].map(ElementId));
        let size = |(measure, surface): (f64, f64)| [measure, surface].map(|x| (x * 1e9).round());
        assert_eq!(size(halves.extent(&[0, 1].map(ElementId))), size(dual.extent(&[0, 1, 2, 3].map(ElementId))));
        assert_eq!(halves.links(ElementId(0)).len(), 1);
        assert!((halves.links(ElementId(0))[0].shared - 8.0).abs() < 1e-12, "two triangles of 4 m² each");
    }
}
