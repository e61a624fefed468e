//! Cutting of the body out of its background mesh along the zero level of the signed distance.

use super::super::triangle::{PlanarPoint, quality};
use super::super::{NodeOrigin, ProposedMesh};
use super::boundary::{BoundaryLocation, ImmersedBoundary};
use super::snap::ImmersedMesh;
use crate::mesh::{NodeId, Simplex};
use std::collections::BTreeMap;

/// New mesh under construction.
struct MeshCutter<'a> {
    boundary: &'a ImmersedBoundary<'a>,
    immersed: &'a ImmersedMesh,
    points: Vec<PlanarPoint>,
    origin: Vec<NodeOrigin>,
    /// Point on each cut edge.
    cuts: BTreeMap<[usize; 2], usize>,
    elements: Vec<[usize; 3]>,
}

/// See [`super::cut_out`].
pub(super) fn cut_out(boundary: &ImmersedBoundary<'_>, immersed: &ImmersedMesh) -> ProposedMesh<2> {
    let (points, origin) = (immersed.points.clone(), immersed.origin.clone());
    let mut cutting = MeshCutter { boundary, immersed, points, origin, cuts: BTreeMap::new(), elements: vec![] };
    for triangle in &immersed.triangles {
        cutting.cut(triangle);
    }
    cutting.mesh()
}

impl MeshCutter<'_> {
    fn is_in(&self, p: usize) -> bool {
        self.immersed.distance[p] < 0.0
    }

    fn is_out(&self, p: usize) -> bool {
        self.immersed.distance[p] > 0.0
    }

    /// Adds the inner part of a triangle.
    fn cut(&mut self, triangle: &[usize; 3]) {
        let count = |is: &dyn Fn(usize) -> bool| triangle.iter().filter(|p| is(**p)).count();
        let (n_in, n_out) = (count(&|p| self.is_in(p)), count(&|p| self.is_out(p)));
        // Rotated so that the corner of the minority side comes first.
        let turned = |first: usize| [first, first + 1, first + 2].map(|k| triangle[k % 3]);
        let first = |is: &dyn Fn(usize) -> bool| triangle.iter().position(|p| is(*p)).map_or(*triangle, turned);
        match (n_in, n_out) {
            (0, 0) if self.boundary.winding(&self.middle(triangle)) > 0 => self.elements.push(*triangle),
            (0, _) => {}
            (_, 0) => self.elements.push(*triangle),
            (1, 2) => {
                let [a, b, c] = first(&|p| self.is_in(p));
                let corners = [a, self.on_edge(a, b), self.on_edge(a, c)];
                self.elements.push(corners);
            }
            (2, _) => {
                let [a, b, c] = first(&|p| self.is_out(p));
                let (to_b, to_c) = (self.on_edge(b, a), self.on_edge(c, a));
                self.divide_quadrilateral([to_b, b, c, to_c]);
            }
            _ => self.halve(first(&|p| !self.is_in(p) && !self.is_out(p))),
        }
    }

    /// Adds the inner half of a triangle whose first corner is on the boundary.
    fn halve(&mut self, [a, b, c]: [usize; 3]) {
        if self.is_in(b) {
            let cut = self.on_edge(b, c);
            self.elements.push([a, b, cut]);
        } else {
            let cut = self.on_edge(c, b);
            self.elements.push([a, cut, c]);
        }
    }

    /// Adds a quadrilateral as two triangles, by the diagonal with the better worst one.
    fn divide_quadrilateral(&mut self, [a, b, c, d]: [usize; 4]) {
        let worst =
            |pair: &[[usize; 3]; 2]| pair.map(|t| quality(t.map(|p| &self.points[p]))).into_iter().fold(1.0, f64::min);
        let [one, other] = [[[a, b, c], [a, c, d]], [[b, c, d], [b, d, a]]];
        self.elements.extend(if worst(&one) >= worst(&other) { one } else { other });
    }

    /// Point where an edge is cut, from the inside to the outside.
    fn on_edge(&mut self, inside: usize, outside: usize) -> usize {
        let key = [inside, outside];
        if let Some(cut) = self.cuts.get(&key) {
            return *cut;
        }
        let ImmersedMesh { points, distance, .. } = self.immersed;
        let way = distance[inside] / (distance[inside] - distance[outside]);
        let zero = || BoundaryLocation {
            at: (1.0 - way) * points[inside] + way * points[outside],
            origin: NodeOrigin::Inside,
        };
        let place = self.boundary.crossing([&points[inside], &points[outside]], way).unwrap_or_else(zero);
        self.points.push(place.at);
        self.origin.push(place.origin);
        self.cuts.insert(key, self.points.len() - 1);
        self.points.len() - 1
    }

    fn middle(&self, triangle: &[usize; 3]) -> PlanarPoint {
        triangle.iter().map(|p| self.points[*p]).sum::<PlanarPoint>() / 3.0
    }

    /// Builds the mesh from the points used, in their order.
    fn mesh(self) -> ProposedMesh<2> {
        let mut number = vec![None; self.points.len()];
        self.elements.iter().flatten().for_each(|p| number[*p] = Some(0));
        let used: Vec<usize> = (0..number.len()).filter(|p| number[*p].is_some()).collect();
        used.iter().zip(0..).for_each(|(p, n)| number[*p] = Some(n));
        let simplex = |nodes: &[usize; 3]| -> Simplex {
            let [a, b, c] = nodes.map(|p| NodeId(number[p].unwrap_or_default()));
            [a, b, c, NodeId::default()]
        };
        ProposedMesh {
            position: used.iter().map(|p| self.points[*p]).collect(),
            origin: used.iter().map(|p| self.origin[*p]).collect(),
            elements: self.elements.iter().map(simplex).collect(),
            over: vec![],
        }
    }
}
