//! Overlap of an old tetrahedron and a new one: convex polyhedron clipping with half-edges.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use super::overlap_moments::{OverlapMoments, dot};
use fearless_simd::{Level, dispatch};

/// Vertex of an overlap, as barycentric coordinates in both tetrahedra: every linear field of either is available
/// there. Entries: N of the first three corners of the new one, 1, λ of the last three of the old one, and density
/// times old volume, kg.
type PolyhedronVertex = [f64; 8];

/// Greatest number of vertices. A cut makes one new vertex on each edge from a kept vertex to a removed one, so it at
/// most doubles the number; the first cut of four leaves no more than 6.
const MOST: usize = 48;

/// Half-edge: half-edge 4n + k leaves vertex n by the k-th of its three edges.
type HalfEdge = u8;

/// Polyhedron with three edges at each vertex, ordered about the vertex as seen from outside.
#[derive(Debug, Clone)]
struct OverlapPolyhedron {
    corners: [PolyhedronVertex; MOST],
    /// Twin of each half-edge.
    back: [HalfEdge; 4 * MOST],
    n_corners: usize,
}

/// Clips old tetrahedra against new ones.
#[derive(Debug, Clone)]
pub(super) struct PolyhedronClipper {
    /// Widest vector unit available; results do not depend on it.
    level: Level,
    /// Overlap of the two tetrahedra.
    common: Box<OverlapPolyhedron>,
    /// Polyhedron before the last cut.
    uncut: Box<OverlapPolyhedron>,
}

impl Default for PolyhedronClipper {
    fn default() -> Self {
        Self { level: Level::new(), common: Box::default(), uncut: Box::default() }
    }
}

impl PolyhedronClipper {
    /// Integrals over the overlap of two tetrahedra; none if they do not overlap. Given are the barycentric coordinates
    /// of the new corners in the old tetrahedron, those of the old corners in the new one, and the densities at the old
    /// corners times the old volume, kg.
    ///
    /// The old tetrahedron is clipped along the faces of the new one, N_i = 0, one after the other. An old sliver is
    /// then as accurate as any other tetrahedron.
    pub fn moments(
        &mut self,
        in_old: &[[f64; 4]; 4],
        in_new: &[[f64; 4]; 4],
        heights: &[f64; 4],
    ) -> Option<OverlapMoments> {
        dispatch!(self.level, _simd => self.found(in_old, in_new, heights))
    }

    #[inline(always)]
    fn found(&mut self, in_old: &[[f64; 4]; 4], in_new: &[[f64; 4]; 4], heights: &[f64; 4]) -> Option<OverlapMoments> {
        let mut sums = PolyhedronIntegrals::default();
        if in_old.iter().flatten().all(|weight| *weight >= 0.0) {
            let corners: [PolyhedronVertex; 4] = std::array::from_fn(|i| corner(&unit(i), &in_old[i], heights));
            sums.add(corners.each_ref());
            return Some(sums.moments());
        }
        self.common.become_tetrahedron(&std::array::from_fn(|a| corner(&in_new[a], &unit(a), heights)));
        for face in (0..4).filter(|face| in_new.iter().any(|n| n[*face] < 0.0)) {
            let stays = self.common.before(face);
            if stays.count_ones() as usize == self.common.n_corners {
                continue;
            }
            if stays == 0 {
                return None;
            }
            std::mem::swap(&mut self.common, &mut self.uncut);
            self.uncut.cut((face, stays), &mut self.common);
        }
        self.common.tetrahedra(|corners| sums.add(corners));
        Some(sums.moments())
    }
}

/// Barycentric coordinates of the corner of this index.
#[inline(always)]
fn unit(i: usize) -> [f64; 4] {
    std::array::from_fn(|a| f64::from(u8::from(a == i)))
}

#[inline(always)]
fn corner(new: &[f64; 4], old: &[f64; 4], heights: &[f64; 4]) -> PolyhedronVertex {
    [new[0], new[1], new[2], 1.0, old[1], old[2], old[3], dot(old, heights)]
}

impl Default for OverlapPolyhedron {
    fn default() -> Self {
        Self { corners: [[0.0; 8]; MOST], back: [0; 4 * MOST], n_corners: 0 }
    }
}

/// Vertex that a half-edge leaves.
#[inline(always)]
fn start(way: HalfEdge) -> usize {
    usize::from(way / 4)
}

/// Next half-edge out of the same vertex, in order about it.
#[inline(always)]
fn next(way: HalfEdge) -> HalfEdge {
    if way % 4 == 2 { way - 2 } else { way + 1 }
}

impl OverlapPolyhedron {
    #[inline(always)]
    fn become_tetrahedron(&mut self, corners: &[PolyhedronVertex; 4]) {
        self.corners[..4].copy_from_slice(corners);
        // From 0 to 1, 2, 3; from 1 to 0, 3, 2; from 2 to 0, 1, 3; from 3 to 0, 2, 1.
        for (n, to) in [[4, 8, 12], [0, 14, 9], [1, 6, 13], [2, 10, 5]].into_iter().enumerate() {
            self.back[4 * n..4 * n + 3].copy_from_slice(&to);
        }
        self.n_corners = 4;
    }

    /// Next half-edge around the face on its side.
    #[inline(always)]
    fn around(&self, way: HalfEdge) -> HalfEdge {
        next(self.back[usize::from(way)])
    }

    /// Bit set of the vertices where the weight of this corner of the new tetrahedron is not negative.
    #[inline(always)]
    fn before(&self, face: usize) -> u64 {
        let corners = self.corners[..self.n_corners].iter().enumerate();
        corners.fold(0, |bits, (n, corner)| bits | u64::from(weight(corner, face) >= 0.0) << n)
    }

    /// Writes the part on the inner side of a face, given the vertices that stay.
    ///
    /// The connectivity follows from the kept vertices alone, so that rounding cannot tear the surface.
    #[inline(always)]
    fn cut(&self, (face, stays): (usize, u64), part: &mut Self) {
        // New index of each kept vertex, and of each new vertex by the half-edge that it lies on.
        let (mut number, mut met) = ([0; MOST], [0; 4 * MOST]);
        part.n_corners = 0;
        for n in ones(stays) {
            number[n] = part.push(self.corners[n]);
        }
        for way in ones(stays).flat_map(ways) {
            let end = start(self.back[usize::from(way)]);
            if stays >> end & 1 == 0 {
                met[usize::from(way)] = part.push(towards(&self.corners[start(way)], &self.corners[end], face));
            }
        }
        for way in ones(stays).flat_map(ways) {
            let own = 4 * number[start(way)] + way % 4;
            let back = self.back[usize::from(way)];
            if stays >> start(back) & 1 == 1 {
                part.back[usize::from(own)] = 4 * number[start(back)] + back % 4;
            } else {
                let new = 4 * met[usize::from(way)];
                part.join(own, new);
                part.join(new + 1, 4 * met[usize::from(self.beyond(way, stays))] + 2);
            }
        }
    }

    /// Follows the face on its side from a half-edge that leaves the kept part to the half-edge that returns, reversed.
    #[inline(always)]
    fn beyond(&self, way: HalfEdge, stays: u64) -> HalfEdge {
        let mut on = self.around(way);
        loop {
            let back = self.back[usize::from(on)];
            if stays >> start(back) & 1 == 1 {
                return back;
            }
            on = next(back);
        }
    }

    #[inline(always)]
    fn join(&mut self, way: HalfEdge, back: HalfEdge) {
        self.back[usize::from(way)] = back;
        self.back[usize::from(back)] = way;
    }

    #[inline(always)]
    fn push(&mut self, corner: PolyhedronVertex) -> HalfEdge {
        self.corners[self.n_corners] = corner;
        self.n_corners += 1;
        self.n_corners as HalfEdge - 1
    }

    /// Visits tetrahedra that fill the polyhedron: from its first vertex to the triangles of the faces that do not
    /// contain it.
    #[inline(always)]
    fn tetrahedra(&self, mut visit: impl FnMut([&PolyhedronVertex; 4])) {
        let mut is_seen = [false; 4 * MOST];
        // Faces around the first vertex.
        for first in ways(0) {
            self.walk(first, &mut is_seen, |_| ());
        }
        for first in (1..self.n_corners).flat_map(ways) {
            let mut before = None;
            let own = &self.corners[start(first)];
            self.walk(first, &mut is_seen, |n| {
                let corner = &self.corners[n];
                if let Some(before) = before.replace(corner).filter(|before| !std::ptr::eq(*before, own)) {
                    visit([&self.corners[0], own, before, corner]);
                }
            });
        }
    }

    /// Visits the vertices of a face, unless it was visited.
    #[inline(always)]
    fn walk(&self, mut way: HalfEdge, is_seen: &mut [bool; 4 * MOST], mut visit: impl FnMut(usize)) {
        while !std::mem::replace(&mut is_seen[usize::from(way)], true) {
            visit(start(way));
            way = self.around(way);
        }
    }
}

/// Positions of the set bits of a number.
#[inline(always)]
fn ones(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lowest = (bits != 0).then(|| bits.trailing_zeros() as usize);
        bits &= bits.wrapping_sub(1);
        lowest
    })
}

/// Half-edges out of a vertex.
#[inline(always)]
fn ways(corner: usize) -> std::ops::Range<HalfEdge> {
    4 * corner as HalfEdge..4 * corner as HalfEdge + 3
}

/// N of a corner of the new tetrahedron at a vertex of the overlap.
#[inline(always)]
fn weight(corner: &PolyhedronVertex, of: usize) -> f64 {
    if of < 3 { corner[of] } else { 1.0 - corner[0] - corner[1] - corner[2] }
}

/// Intersection of a face with the segment to a vertex beyond it.
#[inline(always)]
fn towards(from: &PolyhedronVertex, beyond: &PolyhedronVertex, face: usize) -> PolyhedronVertex {
    let (here, there) = (weight(from, face), weight(beyond, face));
    let t = here / (here - there);
    let mut met: PolyhedronVertex = std::array::from_fn(|i| from[i] + t * (beyond[i] - from[i]));
    if face < 3 {
        met[face] = 0.0;
    }
    met
}

/// Independent integrals; the others follow because the shape functions of a tetrahedron sum to 1.
///
/// Rows: N₀, N₁, N₂ and 1. Columns: N₀, N₁, N₂, 1, λ₁, λ₂, λ₃ and one unused.
#[derive(Default)]
struct PolyhedronIntegrals {
    rows: [[f64; 8]; 4],
    /// ∫λ_a, relative to the volume.
    parts: [f64; 4],
}

impl PolyhedronIntegrals {
    /// Adds the integrals over a tetrahedron with these corners.
    ///
    /// The mean of a cubic function is [9 Σ f((c + S)/6) − 16 f(S/4)]/20 with S = Σc, exactly (Keast quadrature). For a
    /// product of three linear functions it is therefore [Σ f(2c + S)/6 − f(S)]/80.
    #[inline(always)]
    fn add(&mut self, [a, b, c, d]: [&PolyhedronVertex; 4]) {
        let whole = share([a, b, c, d]);
        let share = whole / 80.0;
        let sum: PolyhedronVertex = std::array::from_fn(|i| (a[i] + b[i]) + (c[i] + d[i]));
        let old = [4.0 - sum[4] - sum[5] - sum[6], sum[4], sum[5], sum[6]];
        self.parts.iter_mut().zip(old).for_each(|(part, old)| *part += 0.25 * whole * old);
        let point =
            |corner: &PolyhedronVertex| -> PolyhedronVertex { std::array::from_fn(|i| 2.0 * corner[i] + sum[i]) };
        let points = [sum, point(a), point(b), point(c), point(d)];
        let mut mass = [-share; 5];
        mass[1..].fill(share / 6.0);
        for (mass, point) in mass.iter_mut().zip(&points) {
            *mass *= point[7];
        }
        for (i, row) in self.rows.iter_mut().enumerate() {
            for (mass, point) in mass.iter().zip(&points) {
                let by = mass * point[i];
                for (sum, value) in row.iter_mut().zip(point) {
                    *sum += by * value;
                }
            }
        }
    }

    #[inline(always)]
    fn moments(&self) -> OverlapMoments {
        let rows = &self.rows;
        let one = rows[3];
        let last: [f64; 8] = std::array::from_fn(|i| one[i] - rows[0][i] - rows[1][i] - rows[2][i]);
        let all = [rows[0], rows[1], rows[2], last];
        let mass_matrix = all.map(|row| [row[0], row[1], row[2], row[3] - row[0] - row[1] - row[2]]);
        let parts = |row: [f64; 8]| [row[3] - row[4] - row[5] - row[6], row[4], row[5], row[6]];
        OverlapMoments { mass_matrix, mixed: all.map(parts), corner_mass: parts(one), parts: self.parts }
    }
}

/// Volume of a tetrahedron relative to the old one.
#[inline(always)]
fn share([a, b, c, d]: [&PolyhedronVertex; 4]) -> f64 {
    let [u, v, w] = [b, c, d].map(|other| [other[4] - a[4], other[5] - a[5], other[6] - a[6]]);
    u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0])
}

#[cfg(test)]
mod tests {
    use super::super::barycentric::DeformedElement;
    use super::super::overlap_integrals::OverlapIntegrator;
    use super::super::overlap_moments::{dot, mass_matrix};
    use super::super::test_bodies::TestRandom;
    use super::*;
    use crate::math::{Vector3, det};
    use crate::mesh::{CellSplit, NodeId, RectilinearGrid, Simplex, edges};

    const IDS: Simplex = [NodeId(0), NodeId(1), NodeId(2), NodeId(3)];
    const HEIGHTS: [f64; 4] = [1.0, 3.0, 0.5, 2.0];

    fn tetrahedron(corners: [[f64; 3]; 4]) -> DeformedElement<3> {
        DeformedElement::of(&corners.map(Vector3::from), &IDS)
    }

    fn old() -> DeformedElement<3> {
        tetrahedron([[0.0, 0.0, 0.0], [2.0, 0.1, 0.0], [0.4, 1.9, 0.2], [0.3, 0.2, 1.8]])
    }

    /// Integrals by summation over the cells of a fine grid.
    fn summed(old: &DeformedElement<3>, new: &DeformedElement<3>) -> [[[f64; 4]; 4]; 2] {
        const N: usize = 150;
        let step = 2.0 / N as f64;
        let volume = det(&edges(&old.corners, &IDS)) / 6.0;
        let mut sums = [[[0.0; 4]; 4]; 2];
        for [i, j, k] in (0..N * N * N).map(|n| [n % N, n / N % N, n / N / N]) {
            let p = Vector3::new(i as f64 + 0.5, j as f64 + 0.5, k as f64 + 0.5) * step;
            let [lambda, n] = [old.weights(&p), new.weights(&p)];
            if lambda.iter().chain(&n).all(|w| *w > 0.0) {
                let mass = dot(&lambda, &HEIGHTS) * step.powi(3) / volume;
                for (a, b) in (0..16).map(|k| (k / 4, k % 4)) {
                    sums[0][a][b] += mass * n[a] * n[b];
                    sums[1][a][b] += mass * n[a] * lambda[b];
                }
            }
        }
        sums
    }

    #[test]
    fn moments_of_overlaps_are_those_of_a_fine_grid() {
        for new in [
            [[0.3, 0.3, 0.1], [0.9, 0.4, 0.2], [0.5, 0.8, 0.2], [0.4, 0.4, 0.7]],
            [[-2.9, -2.8, -2.5], [7.9, -2.7, -2.0], [-1.3, 8.9, -2.2], [-1.5, -1.4, 9.0]],
            [[-0.5, 1.1, 0.4], [1.2, -0.7, 0.1], [1.9, 1.7, 0.3], [0.7, 0.6, 1.9]],
            [[1.5, 0.5, -0.4], [0.2, 1.0, 0.3], [-0.5, 0.5, -0.2], [0.8, -0.2, 1.1]],
        ] {
            let (old, new) = (old(), tetrahedron(new));
            assert!(new.is_upright);
            let found = OverlapIntegrator::default().moments(&old, &HEIGHTS, &new).unwrap();
            let [mass_matrix, mixed] = summed(&old, &new);
            for (a, b) in (0..16).map(|k| (k / 4, k % 4)) {
                assert!((found.mass_matrix[a][b] - mass_matrix[a][b]).abs() < 5e-4, "{found:?} {mass_matrix:?}");
                assert!((found.mixed[a][b] - mixed[a][b]).abs() < 5e-4, "{found:?} {mixed:?}");
            }
        }
        let apart = tetrahedron([[2.0, 2.0, 2.0], [2.5, 2.0, 2.0], [2.0, 2.5, 2.0], [2.0, 2.0, 2.5]]);
        assert!(OverlapIntegrator::default().moments(&old(), &HEIGHTS, &apart).is_none());
    }

    #[test]
    fn the_inertia_of_a_whole_tetrahedron_is_that_of_its_overlap_with_itself() {
        let found = OverlapIntegrator::default().moments(&old(), &HEIGHTS, &old()).unwrap();
        for (a, b) in (0..16).map(|k| (k / 4, k % 4)) {
            assert!((found.mass_matrix[a][b] - mass_matrix::<3>(&HEIGHTS)[a][b]).abs() < 1e-15);
            assert!((found.mixed[a][b] - found.mass_matrix[a][b]).abs() < 1e-15);
        }
        assert!((found.corner_mass.iter().sum::<f64>() - 6.5 / 4.0).abs() < 1e-15);
    }

    /// Parts of a tetrahedron in the elements of a grid over the cube of ±2.
    fn given(cutter: &mut OverlapIntegrator, old: &DeformedElement<3>, new: &[DeformedElement<3>]) -> [f64; 4] {
        let mut sum = [0.0; 4];
        for moments in new.iter().filter_map(|new| cutter.moments(old, &HEIGHTS, new)) {
            let rows = moments.mass_matrix.map(|row| row.iter().sum::<f64>());
            let whole: f64 = moments.corner_mass.iter().sum();
            assert!((rows.iter().sum::<f64>() - whole).abs() < 1e-15 && whole > -1e-16);
            (0..4).for_each(|a| sum[a] += moments.corner_mass[a]);
        }
        sum
    }

    fn cover(planes: &[f64], split: CellSplit) -> Vec<DeformedElement<3>> {
        let planes = [planes.to_vec(), planes.to_vec(), planes.to_vec()];
        let (points, elements) = RectilinearGrid { planes, filled: Box::new(|_| true) }.split(split);
        elements.iter().map(|nodes| DeformedElement::of(&points, nodes)).collect()
    }

    #[test]
    fn the_parts_of_a_tetrahedron_add_up_to_it_wherever_it_touches_and_however_flat_it_is() {
        let mut random = TestRandom::new(1);
        let mut cutter = OverlapIntegrator::default();
        let whole = mass_matrix::<3>(&HEIGHTS).map(|row| row.iter().sum::<f64>());
        // Residuals of regular and of degenerate elements; a residual above 1e-10 is deposited.
        let mut worst = [0.0_f64; 2];
        for (planes, split) in [
            (&[-2.0, -1.0, 0.0, 1.0, 2.0][..], CellSplit::Kuhn),
            (&[-2.0, -1.0, 0.0, 1.0, 2.0], CellSplit::Centred),
            (&[-2.0, -0.5, -1e-6, 1e-6, 2.0], CellSplit::Kuhn),
            (&[-2.0, 2.0], CellSplit::Centred),
        ] {
            let new = cover(planes, split);
            for n in 0..300 {
                // Corners on grid points, halfway between them, or anywhere; some tetrahedra are nearly flat.
                let mut coordinate = || match n % 3 {
                    0 => (5.0 * random.next()).floor() - 2.0,
                    1 => 0.5 * (9.0 * random.next()).floor() - 2.0,
                    _ => 4.0 * random.next() - 2.0,
                };
                let mut corners = [[0.0; 3]; 4].map(|corner| corner.map(|_| coordinate()));
                if n % 4 == 0 {
                    corners = corners.map(|[x, y, z]| [x, y, 1e-6 * z]);
                }
                let old = tetrahedron(corners);
                if old.is_upright {
                    let sum = given(&mut cutter, &old, &new);
                    let worst = &mut worst[usize::from(n % 4 == 0)];
                    (0..4).for_each(|a| *worst = worst.max((sum[a] - whole[a]).abs()));
                }
            }
        }
        assert!(worst[0] < 1e-14 && worst[1] < 1e-10, "{worst:?}");
    }

    #[test]
    fn cuts_keep_the_surface_closed_whatever_the_signs_are() {
        let mut random = TestRandom::new(2);
        let (mut from, mut to) = (OverlapPolyhedron::default(), OverlapPolyhedron::default());
        for _ in 0..2000 {
            from.become_tetrahedron(&[[0.0; 8]; 4]);
            for _ in 0..4 {
                for n in 0..from.n_corners {
                    from.corners[n][0] = random.next() - 0.5;
                }
                from.cut((0, from.before(0)), &mut to);
                for way in (0..to.n_corners).flat_map(ways) {
                    let back = to.back[usize::from(way)];
                    assert!(back % 4 < 3 && start(back) < to.n_corners && to.back[usize::from(back)] == way);
                }
                std::mem::swap(&mut from, &mut to);
            }
            from.tetrahedra(|_| ());
        }
    }
}
