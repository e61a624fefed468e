//! Binary tree of clusters of neighbouring facets of the contact surface.

use super::surface::ContactSurface;
use super::surface_motion::{NodePlaces, SurfaceMotion};
use crate::geometry::BoundingBox;
use crate::math::Vector;
use crate::mesh::{ElementId, Facet, NodeId};
use std::ops::Range;

/// Cluster of neighbouring facets.
#[derive(Debug)]
pub(super) struct FacetCluster {
    /// Range of its facets.
    pub facets: Range<usize>,
    /// Range of the corners of its facets; a corner on the border of two leaves is a corner of both.
    pub corners: Range<usize>,
    /// Range of the nodes that belong to it and to no other leaf.
    pub nodes: Range<usize>,
    /// Range of the facets of a leaf and those around its nodes.
    around: Range<usize>,
    /// Range of the corners of these.
    rim: Range<usize>,
    /// Halves of the cluster; none for a leaf.
    pub halves: Option<[usize; 2]>,
    /// Greatest h of its corners, m.
    pub size: f64,
}

/// Tree of clusters; the root is the first.
#[derive(Debug, Default)]
pub(super) struct ClusterTree {
    pub clusters: Vec<FacetCluster>,
    /// Facets, leaf by leaf.
    pub facets: Vec<ElementId>,
    /// Corners of the facets, leaf by leaf, each once in a leaf.
    pub corners: Vec<NodeId>,
    /// Nodes of the surface, leaf by leaf.
    pub nodes: Vec<NodeId>,
    /// Corners of each of `facets` by their places in the corners of its leaf.
    pub facet_corners: Vec<[u16; 3]>,
    /// Least h of the corners of each of `facets`, m.
    pub facet_sizes: Vec<f64>,
    /// h of each of `nodes`, m.
    pub node_sizes: Vec<f64>,
    /// Facets of each leaf and those around its nodes, by the places of their corners in the rim of the leaf.
    around: Vec<[u16; 3]>,
    /// Corners of these facets, leaf by leaf, each once in a leaf.
    rims: Vec<NodeId>,
}

/// Most facets of a leaf in the plane and in space.
const LEAF_FACETS: [usize; 2] = [6, 16];

/// Facet and its centroid, m.
#[derive(Debug, Clone, Copy)]
struct FacetCentre<const D: usize> {
    facet: ElementId,
    centre: Vector<D>,
}

impl ClusterTree {
    /// Builds the tree of a surface.
    pub fn new<const D: usize>(at: &SurfaceMotion<'_, impl NodePlaces<D>>) -> Self {
        let surface = at.surface;
        let centre = |(facet, i): (&Facet, u32)| FacetCentre {
            facet: ElementId(i),
            centre: facet[..D].iter().map(|node| at.nodes.place(*node)).sum::<Vector<D>>() / D as f64,
        };
        let mut centres: Vec<FacetCentre<D>> = surface.facets.iter().zip(0..).map(centre).collect();
        let mut tree = Self::default();
        if !centres.is_empty() {
            let mut is_placed = vec![false; surface.nodes.len()];
            tree.divide(surface, &mut centres, &mut is_placed);
        }
        tree
    }

    /// Adds the cluster of some facets with its halves; returns its index.
    fn divide<const D: usize>(
        &mut self,
        surface: &ContactSurface,
        centres: &mut [FacetCentre<D>],
        is_placed: &mut [bool],
    ) -> usize {
        let index = self.clusters.len();
        let (facets, corners, nodes) = (self.facets.len(), self.corners.len(), self.nodes.len());
        self.clusters.push(FacetCluster {
            facets: 0..0,
            corners: 0..0,
            nodes: 0..0,
            around: 0..0,
            rim: 0..0,
            halves: None,
            size: 0.0,
        });
        let halves = if centres.len() <= LEAF_FACETS[D - 2] {
            self.add_leaf::<D>(surface, centres, is_placed);
            None
        } else {
            let span = BoundingBox::around(centres.iter().map(|of| &of.centre));
            let (axis, half) = ((span.high - span.low).imax(), centres.len() / 2);
            centres.select_nth_unstable_by(half, |a, b| {
                a.centre[axis].total_cmp(&b.centre[axis]).then(a.facet.cmp(&b.facet))
            });
            let (low, high) = centres.split_at_mut(half);
            Some([self.divide(surface, low, is_placed), self.divide(surface, high, is_placed)])
        };
        let (around, rim) = (self.around.len(), self.rims.len());
        if halves.is_none() {
            self.add_facets_around::<D>(surface, facets, nodes);
        }
        let size = |node: &NodeId| surface.size(*node).unwrap_or(0.0);
        self.clusters[index] = FacetCluster {
            facets: facets..self.facets.len(),
            corners: corners..self.corners.len(),
            nodes: nodes..self.nodes.len(),
            around: around..self.around.len(),
            rim: rim..self.rims.len(),
            halves,
            size: match halves {
                None => self.corners[corners..].iter().map(size).fold(0.0, f64::max),
                Some(halves) => halves.map(|half| self.clusters[half].size).into_iter().fold(0.0, f64::max),
            },
        };
        index
    }

    /// Adds the facets, corners and nodes of a leaf.
    fn add_leaf<const D: usize>(
        &mut self,
        surface: &ContactSurface,
        centres: &[FacetCentre<D>],
        is_placed: &mut [bool],
    ) {
        let first = self.corners.len();
        for FacetCentre { facet, .. } in centres {
            let nodes = &surface.facets[facet.index()][..D];
            self.facets.push(*facet);
            self.facet_sizes.push(nodes.iter().filter_map(|node| surface.size(*node)).fold(f64::INFINITY, f64::min));
            self.corners.extend_from_slice(nodes);
        }
        let mut corners = self.corners.split_off(first);
        corners.sort_unstable();
        corners.dedup();
        for FacetCentre { facet, .. } in centres {
            self.facet_corners.push(surface.facets[facet.index()].map(|node| place_in(&corners, node)));
        }
        for node in &corners {
            let is_placed = surface.of[node.index()].map(|at| &mut is_placed[at as usize]);
            if is_placed.is_some_and(|is_placed| !std::mem::replace(is_placed, true)) {
                self.nodes.push(*node);
                self.node_sizes.extend(surface.size(*node));
            }
        }
        self.corners.append(&mut corners);
    }

    /// Adds the facets of a leaf and those around its nodes, both from an index on.
    fn add_facets_around<const D: usize>(&mut self, surface: &ContactSurface, facets: usize, nodes: usize) {
        let around = self.nodes[nodes..].iter().flat_map(|node| surface.around.of(*node));
        let mut all: Vec<ElementId> = self.facets[facets..].iter().chain(around).copied().collect();
        all.sort_unstable();
        all.dedup();
        let corners = all.iter().flat_map(|facet| &surface.facets[facet.index()][..D]);
        let mut rim: Vec<NodeId> = corners.copied().collect();
        rim.sort_unstable();
        rim.dedup();
        self.around.extend(all.iter().map(|facet| surface.facets[facet.index()].map(|node| place_in(&rim, node))));
        self.rims.append(&mut rim);
    }

    /// Returns the corners of the facets of a cluster; one on the border of two leaves stands twice.
    pub fn corners_of(&self, cluster: usize) -> &[NodeId] {
        &self.corners[self.clusters[cluster].corners.clone()]
    }

    /// Returns the corners of the facets of a leaf and of those around its nodes; none for another cluster.
    pub fn rim(&self, leaf: usize) -> &[NodeId] {
        &self.rims[self.clusters[leaf].rim.clone()]
    }

    /// Returns the facets of a leaf and those around its nodes, by the places of their corners in its rim.
    pub fn around(&self, leaf: usize) -> &[[u16; 3]] {
        &self.around[self.clusters[leaf].around.clone()]
    }
}

/// Returns the place of a node in an ascending list; 0 for the meaningless corner of a facet in the plane.
fn place_in(nodes: &[NodeId], node: NodeId) -> u16 {
    nodes.binary_search(&node).map_or(0, |place| place as u16)
}
