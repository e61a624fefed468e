//! Boundary of an immersed body: signed distance, winding number and segment crossings.

use super::super::triangle::{PlanarPoint, clearance, cross, do_cross};
use super::super::{DeformedMesh, NodeOrigin};
use crate::geometry::{BoundingBox, Bvh};
use crate::mesh::NodeId;

/// Edges of the deformed boundary, the body on their left.
pub(super) struct ImmersedBoundary<'a> {
    x: &'a [PlanarPoint],
    edges: Vec<[usize; 2]>,
    near: Bvh<2>,
}

/// Location on the boundary.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BoundaryLocation {
    pub at: PlanarPoint,
    pub origin: NodeOrigin,
}

impl<'a> ImmersedBoundary<'a> {
    pub fn of(old: &DeformedMesh<'a, 2>) -> Self {
        let edges: Vec<[usize; 2]> = old.mesh.facets.iter().map(|f| [f[0].index(), f[1].index()]).collect();
        Self { x: old.position, near: Bvh::segments(&edges, old.position), edges }
    }

    fn ends(&self, edge: usize) -> [&'a PlanarPoint; 2] {
        self.edges[edge].map(|n| &self.x[n])
    }

    /// Signed distance of a point, m, negative in the body.
    pub fn signed_distance(&self, p: &PlanarPoint) -> f64 {
        let nearest = self.near.nearest(p, |edge| clearance(self.ends(edge), p));
        let distance = nearest.map_or(f64::INFINITY, |(_, distance)| distance);
        if self.winding(p) > 0 { -distance } else { distance }
    }

    /// Winding number of the boundary around a point, counter-clockwise.
    pub fn winding(&self, p: &PlanarPoint) -> i32 {
        let mut winding = 0;
        let right = BoundingBox { low: *p, high: PlanarPoint::new(f64::MAX, p[1]) };
        self.near.any(&right, |edge| {
            let [a, b] = self.ends(edge);
            let is_left = cross(a, b, p);
            winding += i32::from(a[1] <= p[1] && p[1] < b[1] && is_left > 0.0);
            winding -= i32::from(b[1] <= p[1] && p[1] < a[1] && is_left < 0.0);
            false
        });
        winding
    }

    /// Nearest location on the boundary.
    pub fn nearest_location(&self, p: &PlanarPoint) -> Option<BoundaryLocation> {
        let (edge, _) = self.near.nearest(p, |edge| clearance(self.ends(edge), p))?;
        let [a, b] = self.ends(edge);
        Some(self.place(edge, (p - a).dot(&(b - a)) / (b - a).norm_squared()))
    }

    /// Location where a segment crosses the boundary, nearest to the fraction `way` of the segment.
    pub fn crossing(&self, [from, to]: [&PlanarPoint; 2], way: f64) -> Option<BoundaryLocation> {
        let mut best: Option<(f64, usize, f64)> = None;
        self.near.any(&BoundingBox::around([from, to]), |edge| {
            let [a, b] = self.ends(edge);
            if do_cross([from, to], [a, b]) || cross(from, to, a) == 0.0 {
                let (before, after) = (cross(a, b, from), cross(a, b, to));
                let (at, share) =
                    (before / (before - after), cross(from, to, a) / (cross(from, to, a) - cross(from, to, b)));
                let away = (at - way).abs();
                let is_on = (0.0..=1.0).contains(&at) && (0.0..=1.0).contains(&share);
                if is_on && best.is_none_or(|(least, ..)| away < least) {
                    best = Some((away, edge, share));
                }
            }
            false
        });
        best.map(|(_, edge, share)| self.place(edge, share))
    }

    /// Location on an edge; a fraction beyond an end, or not a number on a degenerate edge, is clamped to an end.
    fn place(&self, edge: usize, share: f64) -> BoundaryLocation {
        let [a, b] = self.edges[edge];
        let id = |n: usize| NodeId(n as u32);
        if share > 0.0 && share < 1.0 {
            let at = (1.0 - share) * self.x[a] + share * self.x[b];
            return BoundaryLocation { at, origin: NodeOrigin::Surface([a, b, b].map(id), [1.0 - share, share, 0.0]) };
        }
        let end = if share >= 1.0 { b } else { a };
        self.node(end)
    }

    /// Location of a node.
    pub fn node(&self, node: usize) -> BoundaryLocation {
        BoundaryLocation { at: self.x[node], origin: NodeOrigin::Kept(NodeId(node as u32)) }
    }
}
