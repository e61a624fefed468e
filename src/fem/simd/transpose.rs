//! Gather of nodal rows into element vectors, and scatter back, by 4 × 4 transposes.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::batch::LANES;
use super::node_cache::{NodeRows, row, row_mut};
use crate::fem::MAX_NODES;
use fearless_simd::{Simd, SimdBase, SimdSplit, f64x4, f64x8};

/// Gathers the rows of the nodes of eight elements, transposed: one vector of eight lanes per component.
#[inline(always)]
pub(super) fn gather<const D: usize, S: Simd>(
    simd: S,
    nodes: &[[u16; LANES]; MAX_NODES],
    rows: &NodeRows,
) -> [[f64x8<S>; 4]; MAX_NODES] {
    // Unrolled: an array filled by a loop would be zeroed first.
    let first = gather_node(simd, &nodes[0], rows);
    let last = if D == 3 { gather_node(simd, &nodes[3], rows) } else { first };
    [first, gather_node(simd, &nodes[1], rows), gather_node(simd, &nodes[2], rows), last]
}

/// Gathers the rows of one node of each of eight elements, transposed.
#[inline(always)]
fn gather_node<S: Simd>(simd: S, nodes: &[u16; LANES], rows: &NodeRows) -> [f64x8<S>; 4] {
    let mut four = [f64x8::splat(simd, 0.0); 4];
    for r in 0..4 {
        let low = f64x4::from_slice(simd, row(rows, nodes[lane(r, 0)]));
        four[r] = simd.combine_f64x4(low, f64x4::from_slice(simd, row(rows, nodes[lane(r, 1)])));
    }
    transpose_to_components(simd, four)
}

/// Scatters the contributions of eight elements to their nodes: node by node, lane after lane.
#[inline(always)]
pub(super) fn scatter<const D: usize, S: Simd>(
    nodes: &[[u16; LANES]; MAX_NODES],
    kicks: &[[f64x8<S>; 4]; MAX_NODES],
    accumulated: &mut NodeRows,
) {
    let simd = kicks[0][0].simd;
    for a in 0..=D {
        let four = transpose_to_rows(simd, kicks[a]);
        for l in 0..LANES {
            // Lane l = 4 r₀ + 2 r₁ + h.
            let (low, high) = four[(l & 2) + (l >> 2)].split();
            add_row(simd, row_mut(accumulated, nodes[a][l]), if l & 1 == 0 { low } else { high });
        }
    }
}

/// Adds four numbers to a row.
#[inline(always)]
fn add_row<S: Simd>(simd: S, sum: &mut [f64], part: f64x4<S>) {
    (f64x4::from_slice(simd, sum) + part).store_slice(sum);
}

/// Returns the lane in half h of the r-th of four vectors.
#[inline(always)]
fn lane(r: usize, h: usize) -> usize {
    4 * (r & 1) + 2 * (r >> 1) + h
}

/// Transposes four vectors, each with the rows of two lanes, to four components, lane by lane.
///
/// A number has the index bits (r₁ r₀) of its vector and (h c₁ c₀) within the vector. Each round removes the last bit
/// and prepends a bit of the vector, with the result (c₁ c₀) and (r₀ r₁ h).
#[inline(always)]
fn transpose_to_components<S: Simd>(simd: S, r: [f64x8<S>; 4]) -> [f64x8<S>; 4] {
    let even = [simd.unzip_low_f64x8(r[0], r[2]), simd.unzip_low_f64x8(r[1], r[3])];
    let odd = [simd.unzip_high_f64x8(r[0], r[2]), simd.unzip_high_f64x8(r[1], r[3])];
    [
        simd.unzip_low_f64x8(even[0], even[1]),
        simd.unzip_low_f64x8(odd[0], odd[1]),
        simd.unzip_high_f64x8(even[0], even[1]),
        simd.unzip_high_f64x8(odd[0], odd[1]),
    ]
}

/// Inverse of [`transpose_to_components`].
#[inline(always)]
fn transpose_to_rows<S: Simd>(simd: S, c: [f64x8<S>; 4]) -> [f64x8<S>; 4] {
    let even = [simd.zip_low_f64x8(c[0], c[2]), simd.zip_high_f64x8(c[0], c[2])];
    let odd = [simd.zip_low_f64x8(c[1], c[3]), simd.zip_high_f64x8(c[1], c[3])];
    [
        simd.zip_low_f64x8(even[0], odd[0]),
        simd.zip_low_f64x8(even[1], odd[1]),
        simd.zip_high_f64x8(even[0], odd[0]),
        simd.zip_high_f64x8(even[1], odd[1]),
    ]
}
