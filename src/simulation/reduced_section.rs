//! Section of the gel of a reduced model, for frames: a grid of triangles that the rings of the cavity push outwards.
//!
//! Every slice of the gel keeps its volume: a point at the radius r₀ at rest is at √(r₀² + R²) beside a cavity of the
//! radius R.

use super::observe::{BodyPose, FrameCells, MeshFrame};
use crate::math::Vector3;
use crate::reduced::ReducedTarget;

/// Rows of the grid along the axis, and columns across it.
const ROWS: usize = 160;
const COLUMNS: usize = 10;

/// Triangles of the grid.
pub(super) const REDUCED_ELEMENTS: usize = 2 * ROWS * COLUMNS;

/// Grid of a section at rest, rows from the entry surface down, each from the axis outwards.
pub(super) struct SectionGrid {
    radii: Vec<f64>,
    depths: Vec<f64>,
}

impl SectionGrid {
    /// Creates the grid of a gel; columns are narrow at the axis.
    pub fn of(target: &ReducedTarget) -> Self {
        let part = |i: usize, n: usize| i as f64 / n as f64;
        Self {
            radii: (0..=COLUMNS).map(|i| target.block.radius * part(i, COLUMNS).powi(2)).collect(),
            depths: (0..=ROWS).map(|i| target.block.thickness * part(i, ROWS)).collect(),
        }
    }

    /// Returns the number of nodes.
    pub fn n_nodes(&self) -> usize {
        self.radii.len() * self.depths.len()
    }

    /// Returns the node in a row and a column.
    fn node(&self, row: usize, column: usize) -> u32 {
        (row * self.radii.len() + column) as u32
    }

    /// Returns the frame at a time, s.
    pub fn frame(&self, target: &ReducedTarget, time: f64, bodies: Vec<BodyPose>) -> MeshFrame {
        let block = target.block_motion(time);
        let openings: Vec<_> = self.depths.iter().map(|depth| target.opening(*depth, time)).collect();
        let (mut points, mut velocities, mut displacements) = (vec![], vec![], vec![]);
        for (depth, opening) in self.depths.iter().zip(&openings) {
            for rest in &self.radii {
                let radius = (rest * rest + opening.squared_radius).sqrt();
                let at = Vector3::new(radius, 0.0, -depth) + block.displacement;
                displacements.push(at - Vector3::new(*rest, 0.0, -depth));
                let flow = if radius > 0.0 { opening.radial_flow / radius } else { 0.0 };
                velocities.push(Vector3::new(flow, 0.0, 0.0) + block.velocity);
                points.push(at);
            }
        }
        let is_open = |row: usize| openings[row].squared_radius > 0.0;
        MeshFrame {
            time,
            dimension: 2,
            mass: target.gel_mass(),
            points,
            velocities,
            displacements,
            cells: self.cells(is_open),
            fields: vec![],
            bodies,
            block,
            gel_displacement: block.displacement,
        }
    }

    /// Returns the triangles, with the rows at which the axis is open as a surface.
    fn cells(&self, is_open: impl Fn(usize) -> bool) -> FrameCells {
        let corners = |row: usize, column: usize| {
            [(row + 1, column), (row + 1, column + 1), (row, column + 1), (row, column)].map(|(r, c)| self.node(r, c))
        };
        let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c, 0], [a, c, d, 0]];
        let squares = (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| corners(row, column)));
        let nodes: Vec<[u32; 4]> = squares.flat_map(halves).collect();
        let side = |a: u32, b: u32| [a, b, 0];
        let mut facets: Vec<[u32; 3]> = vec![];
        facets.extend((0..COLUMNS).map(|column| side(self.node(ROWS, column), self.node(ROWS, column + 1))));
        facets.extend((0..ROWS).map(|row| side(self.node(row + 1, COLUMNS), self.node(row, COLUMNS))));
        facets.extend((0..COLUMNS).map(|column| side(self.node(0, column + 1), self.node(0, column))));
        let open = (0..ROWS).filter(|row| is_open(*row) || is_open(row + 1));
        facets.extend(open.map(|row| side(self.node(row, 0), self.node(row + 1, 0))));
        let n = nodes.len();
        FrameCells {
            nodes,
            step: vec![0.0; n],
            jacobian: vec![1.0; n],
            energy_density: vec![0.0; n],
            damage: vec![0.0; n],
            facets,
        }
    }
}
