//! Rows of nodes to vectors of eight elements, and back.
#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::MAX_NODES;
use super::batch::LANES;
use super::node_cache::{Rows, row, row_mut};
use fearless_simd::{Simd, SimdBase, SimdSplit, f64x4, f64x8};

/// The rows of the nodes of eight elements, turned: component by component, eight lanes each.
#[inline(always)]
pub(super) fn gather<const D: usize, S: Simd>(
    simd: S,
    nodes: &[[u16; LANES]; MAX_NODES],
    rows: &Rows,
) -> [[f64x8<S>; 4]; MAX_NODES] {
    // Written out: what a loop fills would be set to zero before.
    let first = turned(simd, &nodes[0], rows);
    let last = if D == 3 { turned(simd, &nodes[3], rows) } else { first };
    [first, turned(simd, &nodes[1], rows), turned(simd, &nodes[2], rows), last]
}

/// The rows of one node of each of eight elements, turned.
#[inline(always)]
fn turned<S: Simd>(simd: S, nodes: &[u16; LANES], rows: &Rows) -> [f64x8<S>; 4] {
    let mut four = [f64x8::splat(simd, 0.0); 4];
    for r in 0..4 {
        let low = f64x4::from_slice(simd, row(rows, nodes[lane(r, 0)]));
        four[r] = simd.combine_f64x4(low, f64x4::from_slice(simd, row(rows, nodes[lane(r, 1)])));
    }
    columns(simd, four)
}

/// Adds what eight elements give to their nodes: node by node, one lane after the other.
#[inline(always)]
pub(super) fn scatter<const D: usize, S: Simd>(
    nodes: &[[u16; LANES]; MAX_NODES],
    kicks: &[[f64x8<S>; 4]; MAX_NODES],
    accumulated: &mut Rows,
) {
    let simd = kicks[0][0].simd;
    for a in 0..=D {
        let four = rows_of(simd, kicks[a]);
        for l in 0..LANES {
            // Lane l = 4 r₀ + 2 r₁ + h.
            let (low, high) = four[(l & 2) + (l >> 2)].split();
            add(simd, row_mut(accumulated, nodes[a][l]), if l & 1 == 0 { low } else { high });
        }
    }
}

#[inline(always)]
fn add<S: Simd>(simd: S, sum: &mut [f64], part: f64x4<S>) {
    (f64x4::from_slice(simd, sum) + part).store_slice(sum);
}

/// Which lane comes to stand in half h of the r-th of four vectors.
#[inline(always)]
fn lane(r: usize, h: usize) -> usize {
    4 * (r & 1) + 2 * (r >> 1) + h
}

/// From four vectors, each with the rows of two lanes, to the four columns, lane by lane: where a number stands, bits (r₁ r₀) of the
/// vector and (h c₁ c₀) in it, each round takes the last bit off and puts one of the vector's in front: (c₁ c₀) and (r₀ r₁ h).
#[inline(always)]
fn columns<S: Simd>(simd: S, r: [f64x8<S>; 4]) -> [f64x8<S>; 4] {
    let even = [simd.unzip_low_f64x8(r[0], r[2]), simd.unzip_low_f64x8(r[1], r[3])];
    let odd = [simd.unzip_high_f64x8(r[0], r[2]), simd.unzip_high_f64x8(r[1], r[3])];
    [
        simd.unzip_low_f64x8(even[0], even[1]),
        simd.unzip_low_f64x8(odd[0], odd[1]),
        simd.unzip_high_f64x8(even[0], even[1]),
        simd.unzip_high_f64x8(odd[0], odd[1]),
    ]
}

/// The way back of [`columns`].
#[inline(always)]
fn rows_of<S: Simd>(simd: S, c: [f64x8<S>; 4]) -> [f64x8<S>; 4] {
    let even = [simd.zip_low_f64x8(c[0], c[2]), simd.zip_high_f64x8(c[0], c[2])];
    let odd = [simd.zip_low_f64x8(c[1], c[3]), simd.zip_high_f64x8(c[1], c[3])];
    [
        simd.zip_low_f64x8(even[0], odd[0]),
        simd.zip_low_f64x8(even[1], odd[1]),
        simd.zip_high_f64x8(even[0], odd[0]),
        simd.zip_high_f64x8(even[1], odd[1]),
    ]
}
