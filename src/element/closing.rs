//! Elements that close: what a bound of the stiffness where they are does not see (numerics 1.3d).

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices as in the equations")]

use super::Section;
use crate::algebra::{Number, Tensor, Vector};
use crate::mesh::{Simplex, edges};

/// The part of its measure that an element may lose in a step without being taken for stiffer.
///
/// Of 40 speeds of a random scene (191) one gained 60 % of its energy in a step, and two stopped at an element that had turned over
/// between two of its ticks. Of what loses more than this, at most [`MOST`] of it: two stopped with 0.9 for `MOST` (steps fell to
/// nothing), none with 0.75, and the greatest defect was 7.5 % instead of 81, for 8 % more updates.
pub(super) const SLACK: f64 = 0.25;
const MOST: f64 = 0.75;

/// By what κ is to be multiplied of an element whose edges, m, change with these rates, m/s, until a step, s, has passed: (1 − x)⁻²
/// for the part x of its measure beyond [`SLACK`] that it loses then, at most [`MOST`]; 1 where it loses no more. What resists goes as
/// J⁻² or less. Of a ring also Σ r and Σ v_r of its corners, m and m/s.
#[inline(always)]
pub(super) fn stiffer<const D: usize, V: Number>(
    (edges, rates): (&[[V; D]; D], &[[V; D]; D]),
    ring: Option<(V, V)>,
    step: f64,
) -> V {
    let zero = edges[0][0].constant(0.0);
    let (mut measure, mut change) = (zero, zero);
    for i in 0..D {
        for a in 0..D {
            let cofactor = cofactor(edges, (i, a));
            change = change + cofactor * rates[i][a];
            if i == 0 {
                measure = measure + cofactor * edges[i][a];
            }
        }
    }
    let mut rate = change / measure;
    if let Some((radii, outward)) = ring {
        rate = rate + outward / radii;
    }
    // What is turned over, or no element, loses nothing.
    let lost = measure.choose(-rate * step, zero);
    let left = -(lost.at_least(SLACK).at_most(SLACK + MOST) - SLACK) + 1.0;
    zero.constant(1.0) / (left * left)
}

/// The same of one element with its nodes there, so fast.
pub(super) fn of_one<const D: usize>(
    (nodes, section): (&Simplex, Section),
    (x, v): (&[Vector<D>], &[Vector<D>]),
    step: f64,
) -> f64 {
    let rows = |edges: &Tensor<D>| std::array::from_fn(|i| std::array::from_fn(|a| edges[(i, a)]));
    let radial = |of: &[Vector<D>]| nodes[..=D].iter().map(|node| of[node.index()][0]).sum::<f64>();
    let ring = (section == Section::Axisymmetric).then(|| (radial(x), radial(v)));
    stiffer::<D, f64>((&rows(&edges(x, nodes)), &rows(&edges(v, nodes))), ring, step)
}

/// ∂ det E/∂E_ia.
#[inline(always)]
fn cofactor<const D: usize, V: Number>(edges: &[[V; D]; D], (i, a): (usize, usize)) -> V {
    let (k, m) = ((i + 1) % D, (a + 1) % D);
    if D == 2 {
        return if i == a { edges[k][m] } else { -edges[k][m] };
    }
    let (l, n) = ((i + 2) % D, (a + 2) % D);
    edges[k][m] * edges[l][n] - edges[k][n] * edges[l][m]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Edges of a sheared box with a height, and how they change as it closes with a speed and is turned and sheared.
    fn box_of(height: f64, speed: f64) -> ([[f64; 3]; 3], [[f64; 3]; 3]) {
        let edges = [[2.0, 0.3, 0.1], [0.0, 1.0, 0.7], [0.0, 0.0, height]];
        let rates = [[0.0, 5.0, 9.0], [0.0, 0.0, 4.0], [0.0, 0.0, -speed]];
        (edges, rates)
    }

    #[test]
    fn what_closes_is_stiffer_by_the_square_of_what_is_left_and_nothing_else_is() {
        let stiffer = |height: f64, speed: f64| {
            let (edges, rates) = box_of(height, speed);
            stiffer((&edges, &rates), None, 0.1)
        };
        assert_eq!([0.0, -50.0, 0.2, 0.5].map(|speed| stiffer(0.2, speed)), [1.0; 4]);
        // It loses half, three quarters and all of its height; what is turned over already, nothing.
        for (speed, lost) in [(1.0, 0.5), (1.5, 0.75), (2.0, 1.0), (40.0, 1.0)] {
            let expected = (1.0 - (lost - SLACK)).powi(-2);
            assert!((stiffer(0.2, speed) - expected).abs() < 1e-12, "{speed}");
        }
        assert_eq!(stiffer(-0.2, 2.0), 1.0);
        assert_eq!(stiffer(0.0, 2.0), 1.0);
        assert_eq!(stiffer(f64::NAN, 2.0), 1.0);
    }

    #[test]
    fn a_ring_closes_also_by_its_radius() {
        let (edges, rates) = ([[1.0, 0.2], [0.0, 1.0]], [[0.0, 1.0], [0.0, 0.0]]);
        assert_eq!(stiffer((&edges, &rates), Some((3.0, -3.0)), 0.1), 1.0);
        let half: f64 = stiffer((&edges, &rates), Some((3.0, -3.0)), 0.5);
        assert!((half - 0.75_f64.powi(-2)).abs() < 1e-12);
    }

    #[test]
    fn the_plane_is_that_of_a_prism() {
        let plane: f64 = stiffer((&[[1.0, 0.4], [0.1, 0.3]], &[[2.0, 0.5], [0.7, -1.5]]), None, 0.1);
        let space = stiffer(
            (&[[1.0, 0.4, 0.0], [0.1, 0.3, 0.0], [0.0, 0.0, 1.0]], &[[2.0, 0.5, 0.0], [0.7, -1.5, 0.0], [0.0; 3]]),
            None,
            0.1,
        );
        assert!(plane > 1.0 && (plane - space).abs() < 1e-12);
    }
}
