//! Surface in motion, as its separation list sees it, and the nodes that are neighbours through an element.

use super::surface::ContactSurface;
use crate::math::Vector;
use crate::mesh::{ElementId, NodeId};

/// Places of the nodes of a surface.
pub(crate) trait NodePlaces<const D: usize> {
    /// Returns the place of a node, m.
    fn place(&self, node: NodeId) -> Vector<D>;
}

/// Surface in motion.
pub(crate) struct SurfaceMotion<'a, N> {
    pub surface: &'a ContactSurface,
    /// Travel of each batch of nodes so far, m.
    pub travel: &'a [f64],
    pub nodes: N,
}

/// Stars of the surface nodes: the surface nodes that share an element with each, itself among them.
#[derive(Debug)]
pub(crate) struct SurfaceStars {
    start: Vec<u32>,
    members: Vec<NodeId>,
}

impl SurfaceStars {
    /// Collects the stars from the elements at each node and the nodes of each element.
    pub fn new<'a>(
        surface: &ContactSurface,
        elements: impl Fn(NodeId) -> &'a [ElementId],
        nodes: impl Fn(ElementId) -> &'a [NodeId],
    ) -> Self {
        let (mut start, mut members) = (vec![0], vec![]);
        let mut last_star = vec![u32::MAX; surface.of.len()];
        for (star, at) in (0..).zip(&surface.nodes) {
            let all = elements(at.node).iter().flat_map(|element| nodes(*element));
            for node in all.filter(|node| surface.of[node.index()].is_some()) {
                if std::mem::replace(&mut last_star[node.index()], star) != star {
                    members.push(*node);
                }
            }
            start.push(members.len() as u32);
        }
        Self { start, members }
    }

    /// Returns true if a facet has a node in the star of a node: the facets around them are neighbours at rest.
    pub fn are_neighbours<const D: usize>(&self, surface: &ContactSurface, node: NodeId, facet: ElementId) -> bool {
        let Some(at) = surface.of[node.index()] else { return true };
        let star = &self.members[self.start[at as usize] as usize..self.start[at as usize + 1] as usize];
        surface.facets[facet.index()][..D].iter().any(|corner| star.contains(corner))
    }
}
