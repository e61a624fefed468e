//! Grid of signed distances: a cheap lower bound of the distance far from the surface.

use crate::geometry::Gap;
use crate::math::Vector3;

/// Signed distances at the nodes of a grid of cubes around a body.
#[derive(Debug, Clone)]
pub(super) struct DistanceGrid {
    /// Bounding box of the body, m.
    lower: Vector3,
    upper: Vector3,
    /// Position of the first node, m.
    first: Vector3,
    /// Edge of a cell, m.
    cell: f64,
    /// Number of nodes along each axis.
    nodes: [usize; 3],
    /// φ, m, x fastest.
    distance: Vec<f64>,
}

/// Cells along the longest side of the body. A ball of 16 000 triangles takes 0.1 s to set up with 16 cells, 0.3 s with
/// 24, and 0.7 s with 32; the run is equally fast.
const CELLS: f64 = 16.0;
/// Margin around the bounding box of the body, in cells.
const MARGIN: f64 = 1.0;
/// Distance from the surface, in cells, beyond which the bound replaces the exact distance. With it a ball of 16 000
/// triangles meets a coarse block in 1.1 times the time of a sphere, without it in 7 times.
const FAR: f64 = 2.0;

impl DistanceGrid {
    /// Builds the grid around a box and fills it with the exact distance.
    pub fn new((lower, upper): (Vector3, Vector3), exact: impl Fn(&Vector3) -> f64) -> Self {
        let extent = upper - lower;
        let cell = extent.max() / CELLS;
        let nodes: [usize; 3] = std::array::from_fn(|i| (extent[i] / cell + 2.0 * MARGIN).ceil() as usize + 1);
        let spread = Vector3::from_fn(|i, _| 0.5 * (nodes[i] - 1) as f64 * cell);
        let first = (lower + upper) / 2.0 - spread;
        let mut field = Self { lower, upper, first, cell, nodes, distance: vec![] };
        field.distance = (0..nodes.iter().product()).map(|node| exact(&field.position(node))).collect();
        field
    }

    /// Position of a node, m.
    pub fn position(&self, node: usize) -> Vector3 {
        let [x, y, _] = self.nodes;
        let steps = [node % x, node / x % y, node / (x * y)].map(|n| n as f64);
        self.first + Vector3::from(steps) * self.cell
    }

    /// Edge of a cell, m.
    pub fn cell(&self) -> f64 {
        self.cell
    }

    /// Position of the deepest node, m.
    pub fn deepest(&self) -> Vector3 {
        let nodes = 0..self.distance.len();
        self.position(nodes.min_by(|a, b| self.distance[*a].total_cmp(&self.distance[*b])).unwrap_or(0))
    }

    /// Side lengths of the bounding box of the body, m.
    pub fn extent(&self) -> Vector3 {
        self.upper - self.lower
    }

    /// Iterates over the grid lines along an axis; each item is the first node of a line.
    pub fn lines(&self, axis: usize) -> impl Iterator<Item = usize> {
        let (stride, nodes) = (self.stride(axis), self.nodes[axis]);
        (0..self.distance.len()).filter(move |node| node / stride % nodes == 0)
    }

    /// Iterates over the nodes of a grid line from its first one: positions and φ.
    pub fn line(&self, axis: usize, first: usize) -> impl Iterator<Item = (Vector3, f64)> + '_ {
        let stride = self.stride(axis);
        (0..self.nodes[axis]).map(move |i| first + i * stride).map(|node| (self.position(node), self.distance[node]))
    }

    fn stride(&self, axis: usize) -> usize {
        self.nodes[..axis].iter().product()
    }

    /// Lower bound of the distance, and its gradient, at a point at least two cells outside the body.
    ///
    /// Outside the grid the bound is the distance to the bounding box. Inside, it is the trilinear interpolant less
    /// √3/2 cells. φ is 1-Lipschitz, so the interpolant exceeds the distance by at most the weighted mean distance of
    /// the eight nodes, and their root mean square is at most √3/2 cells. `None` where the surface may be nearer.
    pub fn far_bound(&self, p: &Vector3) -> Option<Gap> {
        let local = (p - self.first) / self.cell;
        let inside = (0..3).all(|i| local[i] >= 0.0 && local[i] <= (self.nodes[i] - 1) as f64);
        if !inside {
            let beyond = p - p.sup(&self.lower).inf(&self.upper);
            let distance = beyond.norm();
            return (distance >= FAR * self.cell).then(|| Gap { distance, normal: beyond / distance });
        }
        let (value, slope) = self.interpolate(&local);
        let distance = value - 0.75_f64.sqrt() * self.cell;
        let normal = slope.try_normalize(0.0).filter(|_| distance >= FAR * self.cell)?;
        Some(Gap { distance, normal })
    }

    /// Trilinear interpolant, and its gradient times the cell, at a point given in cells from the first node.
    fn interpolate(&self, local: &Vector3) -> (f64, Vector3) {
        let base: [usize; 3] = std::array::from_fn(|i| (local[i] as usize).min(self.nodes[i] - 2));
        let t = Vector3::from_fn(|i, _| local[i] - base[i] as f64);
        let (mut value, mut slope) = (0.0, Vector3::zeros());
        for corner in 0..8 {
            let upper = [corner & 1, corner >> 1 & 1, corner >> 2];
            let node =
                (base[0] + upper[0]) + self.nodes[0] * ((base[1] + upper[1]) + self.nodes[1] * (base[2] + upper[2]));
            let weight = Vector3::from_fn(|i, _| if upper[i] == 1 { t[i] } else { 1.0 - t[i] });
            let sign = Vector3::from_fn(|i, _| if upper[i] == 1 { 1.0 } else { -1.0 });
            let across = Vector3::new(weight.y * weight.z, weight.z * weight.x, weight.x * weight.y);
            value += weight.product() * self.distance[node];
            slope += sign.component_mul(&across) * self.distance[node];
        }
        (value, slope)
    }
}
