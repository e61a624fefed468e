//! Permanent track of a shot: damaged gel by depth.

use super::shot_line::{CENTIMETRES, ShotLine, depths_per_metre};
use crate::math::Vector3;
use crate::output::files::format_cell;
use crate::scene::{Dimension, Scene};
use crate::simulation::{MeshFrame, signed_area};
use std::f64::consts::PI;
use std::fmt::Write;

/// Number of planes per interval of depth over which the cross-section is averaged.
const PLANES: usize = 4;
/// Relative tolerance of depths for round-off.
const ROUND_OFF: f64 = 1e-9;

/// Permanent track: diameter of the circle with the mean cross-section of the damaged gel, by interval of depth.
///
/// Each element counts with its damage d, between 0 and 1, and with its present cross-section, which differs from the
/// rest volume per depth only by the compression of the gel. In a plane scene the diameter is the damaged width.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::output) struct PermanentTrack {
    /// Number of intervals per metre.
    per_metre: f64,
    /// Diameter in each interval, m, the first below z = 0.
    diameters: Vec<f64>,
}

impl PermanentTrack {
    /// Computes the track from a frame.
    pub(in crate::output) fn of(line: &ShotLine, scene: &Scene, frame: &MeshFrame) -> Self {
        let per_metre = depths_per_metre(line.gel_depth);
        let n = (line.gel_depth * per_metre).ceil() as usize;
        let planes = damaged_sections(scene, frame, per_metre * PLANES as f64, n * PLANES);
        let mean = |areas: &[f64]| areas.iter().sum::<f64>() / PLANES as f64;
        let diameter = |area: f64| match scene.scene.dimension {
            Dimension::Planar => area,
            Dimension::Axisymmetric | Dimension::Spatial => 2.0 * (area / PI).sqrt(),
        };
        Self { per_metre, diameters: planes.chunks(PLANES).map(|areas| diameter(mean(areas))).collect() }
    }

    /// Returns the greatest diameter, m.
    pub(in crate::output) fn greatest_diameter(&self) -> f64 {
        self.diameters.iter().copied().fold(0.0, f64::max)
    }

    /// Returns the depth of the middle of each interval, m, and the diameter, m, down to the end of the track and at
    /// least to `depth`, m.
    pub(in crate::output) fn curve(&self, depth: f64) -> Vec<(f64, f64)> {
        let end = self.diameters.iter().rposition(|diameter| *diameter > 0.0).map_or(0, |last| last + 1);
        let end = end.max((depth * self.per_metre * (1.0 - ROUND_OFF)).ceil() as usize);
        let middle = |i: usize| (i as f64 + 0.5) / self.per_metre;
        self.diameters.iter().take(end).enumerate().map(|(i, diameter)| (middle(i), *diameter)).collect()
    }

    /// Returns the text of `track.csv`: the track and the energy given to the gel in the centimetre of each depth.
    pub(super) fn csv(&self, depth: f64, energies: &[f64]) -> String {
        let mut text = String::from("depth_m,track_diameter_m,energy_in_centimetre_J\n");
        for (depth, diameter) in self.curve(depth) {
            let energy = energies.get((depth * CENTIMETRES) as usize).copied().unwrap_or(f64::NAN);
            writeln!(text, "{}", [depth, diameter, energy].map(format_cell).join(",")).expect("a string grows");
        }
        text
    }
}

/// Returns the cross-section of the gel weighted by damage, m² or in the plane m, at `n` equally spaced depths, the
/// first half an interval below the entry surface of the block.
fn damaged_sections(scene: &Scene, frame: &MeshFrame, per_metre: f64, n: usize) -> Vec<f64> {
    let copies = if frame.dimension == 3 { scene.gel.symmetry.copies() } else { 1.0 };
    let mut sections = vec![0.0; n];
    for (nodes, damage) in frame.cells.nodes.iter().zip(&frame.cells.damage).filter(|(_, damage)| **damage > 0.0) {
        let corner = |node: &u32| frame.points[*node as usize] - frame.gel_displacement;
        let corners = &nodes[..=frame.dimension].iter().map(corner).collect::<Vec<_>>();
        let plane = |corner: &Vector3| -corner.z * per_metre - 0.5;
        let (least, most) = (
            corners.iter().map(plane).fold(f64::INFINITY, f64::min).max(0.0),
            corners.iter().map(plane).fold(f64::NEG_INFINITY, f64::max),
        );
        let first = least.ceil() as usize;
        for (i, section) in sections.iter_mut().enumerate().skip(first).take_while(|(i, _)| *i as f64 <= most) {
            let z = -(i as f64 + 0.5) / per_metre;
            *section += copies * damage * section_measure(scene.scene.dimension, corners, z);
        }
    }
    sections
}

/// Returns the measure of the cross-section of an element at height z: an area, or in the plane a width.
fn section_measure(dimension: Dimension, corners: &[Vector3], z: f64) -> f64 {
    let (upper, lower): (Vec<&Vector3>, Vec<&Vector3>) = corners.iter().partition(|corner| corner.z > z);
    let cut = |a: &Vector3, b: &Vector3| a + (b - a) * ((z - a.z) / (b.z - a.z));
    // Around the polygon: the second of two upper corners meets the lower corners in reverse order.
    let points: Vec<Vector3> = upper
        .iter()
        .enumerate()
        .flat_map(|(i, a)| {
            let mut ends = lower.clone();
            if i == 1 {
                ends.reverse();
            }
            ends.into_iter().map(move |b| cut(a, b))
        })
        .collect();
    match (dimension, &points[..]) {
        (Dimension::Planar, [a, b]) => (b.x - a.x).abs(),
        (Dimension::Axisymmetric, [a, b]) => PI * (b.x * b.x - a.x * a.x).abs(),
        (Dimension::Spatial, points) => signed_area(&points.iter().map(Vector3::xy).collect::<Vec<_>>()).abs(),
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cross_sections_of_an_element_add_up_to_its_volume() {
        let at = |[x, y, z]: [f64; 3]| Vector3::new(x, y, z);
        let integral = |dimension: Dimension, corners: &[Vector3]| {
            let n = 2000;
            let middle = |i: u32| -(f64::from(i) + 0.5) / f64::from(n);
            (0..n).map(|i| section_measure(dimension, corners, middle(i)) / f64::from(n)).sum::<f64>()
        };
        let tetrahedron = [[0.1, 0.2, -0.9], [0.8, 0.1, -0.6], [0.3, 0.9, -0.5], [0.5, 0.4, -0.1]].map(at);
        let edges = [1, 2, 3].map(|i| tetrahedron[i] - tetrahedron[0]);
        let volume = edges[0].cross(&edges[1]).dot(&edges[2]).abs() / 6.0;
        assert!((integral(Dimension::Spatial, &tetrahedron) / volume - 1.0).abs() < 1e-5);
        let triangle = [[0.1, 0.0, -0.9], [0.8, 0.0, -0.5], [0.3, 0.0, -0.1]].map(at);
        let area = 0.5 * (triangle[1] - triangle[0]).cross(&(triangle[2] - triangle[0])).norm();
        assert!((integral(Dimension::Planar, &triangle) / area - 1.0).abs() < 1e-5);
        // Pappus: area times the way of the centroid.
        let revolved = 2.0 * PI * 0.4 * area;
        assert!((integral(Dimension::Axisymmetric, &triangle) / revolved - 1.0).abs() < 1e-5);
    }
}
