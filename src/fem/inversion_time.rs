//! Time to inversion of an element: a bound of the time step that the stiffness bound does not contain (method 1.3d).

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices as in the equations")]

use super::Section;
use crate::math::{Number, Vector, array};
use crate::mesh::{Simplex, edges};

/// Inversion margin: a step may take J at most this far below 0, by extrapolation of the rate at its start.
///
/// A stiffness bound at the start of the step does not see inversion. A strip of a wall, 0.1 mm thick, whose sides
/// met at 50 m/s, had J = −2.3 and 9000 times its κ after one step. It returned many times the energy of its closing.
/// The margin is half of the J at which the continuation begins, since the resistance grows no further there. Halving
/// J per step is no alternative: J → 0 in ever shorter steps, and `ball-square` at 30 m/s, which reaches J = 0.01 on
/// its fixed mesh, ended there.
pub const TURNED: f64 = 0.1;
/// Look-ahead of the inversion check, in steps of the last length.
///
/// The closing rate is reported if an element would reach the margin [`TURNED`] within the look-ahead: a step may
/// then be doubled without another check.
pub const FORESEEN: f64 = 2.0;

/// Radial sums of the corners of a ring.
pub(super) struct RadialSums<V> {
    /// Σ r, m.
    pub radii: V,
    /// Σ v_r, m/s.
    pub rates: V,
}

/// Returns the closing rate −J′/(J + [`TURNED`]) of an element, 1/s, from its edges, m, and edge rates, m/s.
///
/// The rate is 0 for a growing, inverted or absent element; a ring needs its radial sums.
#[inline(always)]
pub(super) fn closing_rate<const D: usize, V: Number>(
    jacobian: V,
    edges: &[[V; D]; D],
    rates: &[[V; D]; D],
    ring: Option<RadialSums<V>>,
) -> V {
    let zero = edges[0][0].constant(0.0);
    let (mut measure, mut change) = (zero, zero);
    for i in 0..D {
        for a in 0..D {
            let cofactor = array::cofactor(edges, i, a);
            change = change + cofactor * rates[i][a];
            if i == 0 {
                measure = measure + cofactor * edges[i][a];
            }
        }
    }
    let mut rate = change / measure;
    if let Some(ring) = ring {
        rate = rate + ring.rates / ring.radii;
    }
    measure.choose(-rate * (jacobian / (jacobian + jacobian.constant(TURNED))), zero).at_least(0.0)
}

/// Returns the closing rate of one element at nodal positions, m, and velocities, m/s.
pub(super) fn closing_rate_of_element<const D: usize>(
    jacobian: f64,
    nodes: &Simplex,
    section: Section,
    x: &[Vector<D>],
    v: &[Vector<D>],
) -> f64 {
    let radial = |of: &[Vector<D>]| nodes[..=D].iter().map(|node| of[node.index()][0]).sum::<f64>();
    let ring = (section == Section::Axisymmetric).then(|| RadialSums { radii: radial(x), rates: radial(v) });
    closing_rate(jacobian, &array::rows(&edges(x, nodes)), &array::rows(&edges(v, nodes)), ring)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the edges of a sheared box and their rates under closing, rotation and shear.
    fn box_of(height: f64, speed: f64) -> ([[f64; 3]; 3], [[f64; 3]; 3]) {
        let edges = [[2.0, 0.3, 0.1], [0.0, 1.0, 0.7], [0.0, 0.0, height]];
        let rates = [[0.0, 5.0, 9.0], [0.0, 0.0, 4.0], [0.0, 0.0, -speed]];
        (edges, rates)
    }

    #[test]
    fn the_closing_rate_is_speed_over_height() {
        let closes = |jacobian: f64, height: f64, speed: f64| {
            let (edges, rates) = box_of(height, speed);
            closing_rate(jacobian, &edges, &rates, None)
        };
        let rate_at = |height: f64, speed: f64| closes(1.0, height, speed) * (1.0 + TURNED);
        for speed in [0.2, 2.0, 40.0] {
            assert!((rate_at(0.2, speed) - speed / 0.2).abs() < 1e-12 * speed, "{speed}");
        }
        // J extrapolated by its rate reaches the margin.
        for jacobian in [1.5, 0.1, 1e-9] {
            let rate = -jacobian * 2.0 / 0.2;
            assert!((jacobian + rate / closes(jacobian, 0.2, 2.0) + TURNED).abs() < 1e-12);
        }
        assert_eq!(closes(-0.1, 0.2, 2.0), 0.0);
        assert_eq!([0.0, -50.0, f64::NAN].map(|speed| rate_at(0.2, speed)), [0.0; 3]);
        assert_eq!([-0.2, 0.0, f64::NAN].map(|height| rate_at(height, 2.0)), [0.0; 3]);
    }

    #[test]
    fn the_closing_rate_of_a_ring_includes_its_radius() {
        let (edges, rates) = ([[1.0, 0.2], [0.0, 1.0]], [[0.0, 1.0], [0.0, 0.0]]);
        let [out, inwards] = [3.0, -6.0]
            .map(|outward| closing_rate(1.0, &edges, &rates, Some(RadialSums { radii: 3.0, rates: outward })));
        assert!(out == 0.0 && (inwards * (1.0 + TURNED) - 2.0).abs() < 1e-15, "{out} {inwards}");
    }

    #[test]
    fn the_closing_rate_in_the_plane_is_that_of_a_prism() {
        let plane: f64 = closing_rate(1.0, &[[1.0, 0.4], [0.1, 0.3]], &[[2.0, 0.5], [0.7, -1.5]], None);
        let space = closing_rate(
            1.0,
            &[[1.0, 0.4, 0.0], [0.1, 0.3, 0.0], [0.0, 0.0, 1.0]],
            &[[2.0, 0.5, 0.0], [0.7, -1.5, 0.0], [0.0; 3]],
            None,
        );
        assert!(plane > 0.0 && (plane - space).abs() < 1e-12);
    }
}
