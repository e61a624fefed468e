//! Elements that close: what a bound of the stiffness where they are does not see (numerics 1.3d).

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices as in the equations")]

use super::{Section, TURNED};
use crate::math::{Number, Tensor, Vector};
use crate::mesh::{Simplex, edges};

/// How fast an element of this J closes, −J′/(J + [`TURNED`]), of its edges, m, that change with these rates, m/s, 1/s: 0 if it grows, is turned over, or none.
/// Of a ring also Σ r and Σ v_r of its corners, m and m/s.
#[inline(always)]
pub(super) fn closing<const D: usize, V: Number>(
    jacobian: V,
    (edges, rates): (&[[V; D]; D], &[[V; D]; D]),
    ring: Option<(V, V)>,
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
    measure.choose(-rate * (jacobian / (jacobian + jacobian.constant(TURNED))), zero).at_least(0.0)
}

/// The same of one element with its nodes there, so fast.
pub(super) fn of_one<const D: usize>(
    jacobian: f64,
    (nodes, section): (&Simplex, Section),
    (x, v): (&[Vector<D>], &[Vector<D>]),
) -> f64 {
    let rows = |edges: &Tensor<D>| std::array::from_fn(|i| std::array::from_fn(|a| edges[(i, a)]));
    let radial = |of: &[Vector<D>]| nodes[..=D].iter().map(|node| of[node.index()][0]).sum::<f64>();
    let ring = (section == Section::Axisymmetric).then(|| (radial(x), radial(v)));
    closing::<D, f64>(jacobian, (&rows(&edges(x, nodes)), &rows(&edges(v, nodes))), ring)
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
    fn what_closes_does_so_by_its_height_and_nothing_else_closes() {
        let closes = |jacobian: f64, height: f64, speed: f64| {
            let (edges, rates) = box_of(height, speed);
            closing(jacobian, (&edges, &rates), None)
        };
        let closing = |height: f64, speed: f64| closes(1.0, height, speed) * (1.0 + TURNED);
        for speed in [0.2, 2.0, 40.0] {
            assert!((closing(0.2, speed) - speed / 0.2).abs() < 1e-12 * speed, "{speed}");
        }
        // J goes on by its rate, to what it may come to.
        for jacobian in [1.5, 0.1, 1e-9] {
            let rate = -jacobian * 2.0 / 0.2;
            assert!((jacobian + rate / closes(jacobian, 0.2, 2.0) + TURNED).abs() < 1e-12);
        }
        assert_eq!(closes(-0.1, 0.2, 2.0), 0.0);
        assert_eq!([0.0, -50.0, f64::NAN].map(|speed| closing(0.2, speed)), [0.0; 3]);
        assert_eq!([-0.2, 0.0, f64::NAN].map(|height| closing(height, 2.0)), [0.0; 3]);
    }

    #[test]
    fn a_ring_closes_also_by_its_radius() {
        let (edges, rates) = ([[1.0, 0.2], [0.0, 1.0]], [[0.0, 1.0], [0.0, 0.0]]);
        let [out, inwards] = [3.0, -6.0].map(|outward| closing(1.0, (&edges, &rates), Some((3.0, outward))));
        assert!(out == 0.0 && (inwards * (1.0 + TURNED) - 2.0).abs() < 1e-15, "{out} {inwards}");
    }

    #[test]
    fn the_plane_is_that_of_a_prism() {
        let plane: f64 = closing(1.0, (&[[1.0, 0.4], [0.1, 0.3]], &[[2.0, 0.5], [0.7, -1.5]]), None);
        let space = closing(
            1.0,
            (&[[1.0, 0.4, 0.0], [0.1, 0.3, 0.0], [0.0, 0.0, 1.0]], &[[2.0, 0.5, 0.0], [0.7, -1.5, 0.0], [0.0; 3]]),
            None,
        );
        assert!(plane > 0.0 && (plane - space).abs() < 1e-12);
    }
}
