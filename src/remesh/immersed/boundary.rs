//! The boundary of a body that is immersed: how far away it is, on which side a point is, and where a segment crosses it.

use super::super::bounds::Bounds;
use super::super::box_tree::Near;
use super::super::triangle::{Point, clearance, cross, do_cross};
use super::super::{Moved, Origin};
use crate::mesh::NodeId;

/// The edges of a boundary where they are, the body on their left.
pub(super) struct Boundary<'a> {
    x: &'a [Point],
    edges: Vec<[usize; 2]>,
    near: Near<2>,
}

/// A place on a boundary.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    pub at: Point,
    pub origin: Origin,
}

impl<'a> Boundary<'a> {
    pub fn of(old: &Moved<'a, 2>) -> Self {
        let edges: Vec<[usize; 2]> = old.mesh.facets.iter().map(|f| [f[0].index(), f[1].index()]).collect();
        Self { x: old.position, near: Near::segments(&edges, old.position), edges }
    }

    fn ends(&self, edge: usize) -> [&'a Point; 2] {
        self.edges[edge].map(|n| &self.x[n])
    }

    /// Distance of a point, m, negative in the body.
    pub fn signed_distance(&self, p: &Point) -> f64 {
        let nearest = self.near.nearest(p, |edge| clearance(self.ends(edge), p));
        let distance = nearest.map_or(f64::INFINITY, |(_, distance)| distance);
        if self.winding(p) > 0 { -distance } else { distance }
    }

    /// How often the boundary goes around a point, against the clock.
    pub fn winding(&self, p: &Point) -> i32 {
        let mut winding = 0;
        let right = Bounds { low: *p, high: Point::new(f64::MAX, p[1]) };
        self.near.any(&right, |edge| {
            let [a, b] = self.ends(edge);
            let is_left = cross(a, b, p);
            winding += i32::from(a[1] <= p[1] && p[1] < b[1] && is_left > 0.0);
            winding -= i32::from(b[1] <= p[1] && p[1] < a[1] && is_left < 0.0);
            false
        });
        winding
    }

    /// The nearest place of the boundary.
    pub fn foot(&self, p: &Point) -> Option<Place> {
        let (edge, _) = self.near.nearest(p, |edge| clearance(self.ends(edge), p))?;
        let [a, b] = self.ends(edge);
        Some(self.place(edge, (p - a).dot(&(b - a)) / (b - a).norm_squared()))
    }

    /// Where a segment crosses the boundary, nearest to this part of its way.
    pub fn crossing(&self, [from, to]: [&Point; 2], way: f64) -> Option<Place> {
        let mut best: Option<(f64, usize, f64)> = None;
        self.near.any(&Bounds::around([from, to]), |edge| {
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

    /// A place on an edge; not a number of a flat one, and what is before or behind it, is at an end.
    fn place(&self, edge: usize, share: f64) -> Place {
        let [a, b] = self.edges[edge];
        let id = |n: usize| NodeId(n as u32);
        if share > 0.0 && share < 1.0 {
            let at = (1.0 - share) * self.x[a] + share * self.x[b];
            return Place { at, origin: Origin::Surface([a, b, b].map(id), [1.0 - share, share, 0.0]) };
        }
        let end = if share >= 1.0 { b } else { a };
        self.node(end)
    }

    /// A node.
    pub fn node(&self, node: usize) -> Place {
        Place { at: self.x[node], origin: Origin::Kept(NodeId(node as u32)) }
    }
}
