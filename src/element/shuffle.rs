//! Rows of nodes to vectors of eight elements, and back.
#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::MAX_NODES;
use super::lanes::{Accumulated, LANES, MOST_LOCAL_NODES, Row};
use fearless_simd::{Simd, SimdBase, SimdSplit, f64x4, f64x8};

/// The rows of the nodes of eight elements, turned: component by component, eight lanes each.
#[inline(always)]
pub(super) fn gather<const D: usize, S: Simd>(
    numbers: &[[u16; LANES]; MAX_NODES],
    rows: &[Row; MOST_LOCAL_NODES],
    gathered: &mut [[f64x8<S>; 8]; MAX_NODES],
) {
    let simd = gathered[0][0].simd;
    for a in 0..=D {
        // By itself, not in place: these eight stay in registers.
        let mut eight = gathered[0];
        for l in 0..LANES {
            eight[l] = f64x8::from_slice(simd, &rows[place(numbers[a][l])]);
        }
        transpose(simd, &mut eight);
        gathered[a] = eight;
    }
}

/// Adds what eight elements give to their nodes, one lane after the other.
#[inline(always)]
pub(super) fn scatter<const D: usize, S: Simd>(
    numbers: &[[u16; LANES]; MAX_NODES],
    kicks: &[[f64x8<S>; 4]; MAX_NODES],
    accumulated: &mut [Accumulated; MOST_LOCAL_NODES],
) {
    let simd = kicks[0][0].simd;
    for pair in 0..MAX_NODES / 2 {
        let (a, b) = (2 * pair, 2 * pair + 1);
        let mut both =
            [kicks[a][0], kicks[a][1], kicks[a][2], kicks[a][3], kicks[b][0], kicks[b][1], kicks[b][2], kicks[b][3]];
        transpose(simd, &mut both);
        for l in 0..LANES {
            let (first, second) = both[l].split();
            add(simd, &mut accumulated[place(numbers[a][l])], first);
            if b <= D {
                add(simd, &mut accumulated[place(numbers[b][l])], second);
            }
        }
    }
}

#[inline(always)]
fn add<S: Simd>(simd: S, sum: &mut Accumulated, part: f64x4<S>) {
    (f64x4::from_slice(simd, sum) + part).store_slice(sum);
}

/// A number within the block; the mask tells the compiler that it is in bounds.
#[inline(always)]
fn place(node: u16) -> usize {
    usize::from(node) & (MOST_LOCAL_NODES - 1)
}

/// Rows and columns of eight times eight numbers exchanged: three rounds of shuffling, as three bits of an index turn.
#[inline(always)]
fn transpose<S: Simd>(simd: S, r: &mut [f64x8<S>; 8]) {
    for _ in 0..3 {
        let last = *r;
        for i in 0..4 {
            r[2 * i] = simd.zip_low_f64x8(last[i], last[i + 4]);
            r[2 * i + 1] = simd.zip_high_f64x8(last[i], last[i + 4]);
        }
    }
}
