//! Volume of a void between two heights, by its facets.

use super::Section;
use crate::math::{Vector, Vector3, embed};
use std::f64::consts::PI;

/// Computes the part of the volume, m³, between two ascending heights of a void that a facet of its wall contributes;
/// the facet is oriented outwards from the body, into the void.
///
/// By the divergence theorem it is the flux −∫ (x, y, 0)·n/2 dA of the part of the facet between these heights, in the
/// plane −∫ (x, 0)·n dA. Horizontal lids and planes of symmetry through the origin contribute nothing. The sum over the
/// wall is hence the whole volume, also where the void is open at these heights.
#[must_use]
pub fn slab_volume<const D: usize>(section: Section, corners: &[Vector<D>; 3], heights: [f64; 2]) -> f64 {
    let z = || corners[..D].iter().map(|x| x[D - 1]);
    if z().all(|z| z <= heights[0]) || z().all(|z| z >= heights[1]) {
        return 0.0;
    }
    match section {
        Section::Planar { thickness } => {
            let [a, b] = clip_edge(corners, heights);
            -0.5 * thickness * (a[0] + b[0]) * (b[D - 1] - a[D - 1])
        }
        Section::Axisymmetric => {
            let [a, b] = clip_edge(corners, heights);
            -PI / 3.0 * (a[0] * a[0] + a[0] * b[0] + b[0] * b[0]) * (b[D - 1] - a[D - 1])
        }
        Section::Spatial => {
            let above = clip_polygon(&corners.map(|x| embed(&x)), heights[0], 1.0);
            let polygon = clip_polygon(&above, heights[1], -1.0);
            let triangles = (2..polygon.len()).map(|i| [polygon[0], polygon[i - 1], polygon[i]]);
            triangles.map(|triangle| -flux_of_triangle(&triangle)).sum()
        }
    }
}

/// Returns the part of an edge that is not horizontal between two heights.
fn clip_edge<const D: usize>(corners: &[Vector<D>; 3], heights: [f64; 2]) -> [Vector<D>; 2] {
    let [a, b, _] = *corners;
    let rise = b[D - 1] - a[D - 1];
    let at = |z: f64| a + (b - a) * ((z - a[D - 1]) / rise).clamp(0.0, 1.0);
    let [low, high] = heights.map(at);
    if rise > 0.0 { [low, high] } else { [high, low] }
}

/// Clips a convex polygon at a height (Sutherland–Hodgman): keeps what is above for `side` = 1, below for −1.
fn clip_polygon(polygon: &[Vector3], height: f64, side: f64) -> Vec<Vector3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, b) in polygon.iter().enumerate() {
        let a = &polygon[(i + polygon.len() - 1) % polygon.len()];
        let [from, to] = [a, b].map(|x| side * (x.z - height));
        if (from < 0.0) != (to < 0.0) {
            kept.push(a + (b - a) * (from / (from - to)));
        }
        if to >= 0.0 {
            kept.push(*b);
        }
    }
    kept
}

/// Returns the flux ∫ (x, y, 0)·n/2 dA through a triangle, m³.
fn flux_of_triangle(corners: &[Vector3; 3]) -> f64 {
    let [a, b, c] = corners;
    let (area, middle) = ((b - a).cross(&(c - a)) / 2.0, (a + b + c) / 3.0);
    0.5 * middle.xy().dot(&area.xy())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{BlockSpec, CellSplit, block, uniform};

    #[test]
    fn a_cone_about_the_axis_and_a_wedge_in_the_plane_have_their_volume_between_two_heights() {
        // A pit with its tip at (0, −2) that opens to 1 at z = 0; the body lies on the left of each edge.
        let wall: Vec<_> = (0..7).map(|i| f64::from(i) / 6.0).map(|s| Vector::<2>::new(s, -2.0 + 2.0 * s)).collect();
        let volume = |section: Section, heights: [f64; 2]| -> f64 {
            wall.windows(2).map(|edge| slab_volume(section, &[edge[1], edge[0], edge[0]], heights)).sum()
        };
        let cone = |z: f64| PI / 3.0 * (1.0 + 0.5 * z).powi(3) * 2.0;
        for heights in [[-3.0, 1.0], [-1.3, -0.2], [-1.1, -1.05], [-2.5, -1.9]] {
            let [low, high] = heights.map(|z: f64| z.clamp(-2.0, 0.0));
            let found = volume(Section::Axisymmetric, heights);
            assert!((found - (cone(high) - cone(low))).abs() < 1e-14, "{heights:?}: {found}");
            // The half at x ≥ 0 of the wedge.
            let half = |z: f64| 0.3 * (1.0 + 0.5 * z).powi(2);
            let found = volume(Section::Planar { thickness: 0.3 }, heights);
            assert!((found - (half(high) - half(low))).abs() < 1e-14, "{heights:?}: {found}");
        }
    }

    #[test]
    fn the_slab_of_a_block_is_its_area_times_the_height_wherever_it_stands() {
        for shift in [0.0, 0.7] {
            let planes = std::array::from_fn(|i| uniform(0.0, [0.5, 0.8, 1.0][i], 0.25));
            let mesh = block::<3>(BlockSpec { planes, split: CellSplit::Centred, faces: vec![] });
            let at = |n: usize| mesh.rest[n] + Vector3::new(shift, -shift, 0.0);
            let part = |facet: &crate::mesh::Facet| {
                // The outward normal of the block is that into the void of its complement.
                slab_volume(Section::Spatial, &facet.map(|node| at(node.index())), [0.31, 0.77])
            };
            let volume: f64 = mesh.facets.iter().map(part).sum();
            assert!((volume + 0.5 * 0.8 * 0.46).abs() < 1e-14, "{volume}");
        }
    }
}
