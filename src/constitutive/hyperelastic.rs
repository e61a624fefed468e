use super::LogarithmicEnergy;
use crate::math::Number;

/// Hyperelastic material, ψ = ψ_s(F) + U(J), written once for one deformation or for eight in vector lanes.
///
/// ψ_s is an isotropic energy of the principal stretches, defined for every F, inverted elements included; U resists
/// inversion.
pub trait Hyperelastic {
    /// Returns the volumetric energy U.
    fn volume(&self) -> LogarithmicEnergy;
    /// Evaluates ψ_s at the rows of F and the out-of-plane stretch `out`: 1 in plane strain, ignored in space.
    fn sheared<const D: usize, V: Number>(&self, f: &[[V; D]; D], out: V) -> ShearResponse<D, V>;
}

/// Energy ψ_s of the principal stretches, its stress and a bound of its curvature at one deformation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShearResponse<const D: usize, V = f64> {
    /// ψ_s, J/m³.
    pub energy: V,
    /// Rows of ∂ψ_s/∂F, Pa.
    pub stress: [[V; D]; D],
    /// Derivative of ψ_s by the out-of-plane stretch λ over λ, Pa; ignored in space.
    pub out: V,
    /// Constants a and b of a curvature bound, Pa: d²ψ_s(F + tH)/dt² ≤ a|H|² + b(F:H)² for every H.
    pub curvature: [V; 2],
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constitutive::{MooneyRivlin, NeoHookean, Ogden, OgdenTerm};
    use fearless_simd::{Level, SimdBase, dispatch, f64x8};

    /// Returns rows of F in a lane: at rest, stretched, sheared, crushed and inverted.
    fn deformation<const D: usize>(lane: usize) -> [[f64; D]; D] {
        let sheared = |i: usize, j: usize| 0.3 * ((1 + 3 * i + 5 * j + 7 * lane) as f64).sin();
        let stretch = [1.0, 1.0, 1.7, 0.4, 0.1, -0.5, 1e-3, 3.0][lane];
        let of = |i: usize, j: usize| if i == j { stretch } else { sheared(i, j) };
        std::array::from_fn(|i| std::array::from_fn(|j| if lane == 0 && i != j { 0.0 } else { of(i, j) }))
    }

    fn check<const D: usize>(gel: &impl Hyperelastic) {
        let out = [1.0, 1.1, 0.9, 1.0, 0.3, -0.2, 0.15, 2.0];
        let eight: [[f64; 8]; 3] = dispatch!(Level::new(), simd => {
            let lanes = |of: &dyn Fn(usize) -> f64| f64x8::from_slice(simd, &std::array::from_fn::<f64, 8, _>(of));
            let f: [[_; D]; D] =
                std::array::from_fn(|i| std::array::from_fn(|j| lanes(&|lane| deformation::<D>(lane)[i][j])));
            let found = gel.sheared(&f, f64x8::from_slice(simd, &out));
            [found.energy, found.stress[D - 1][0], found.curvature[0]].map(Number::store)
        });
        for lane in 0..8 {
            let found = gel.sheared(&deformation::<D>(lane), out[lane]);
            assert_eq!(eight.map(|of| of[lane]), [found.energy, found.stress[D - 1][0], found.curvature[0]], "{lane}");
        }
    }

    /// Compares the stress with differences of the energy.
    fn check_stress<const D: usize>(gel: &impl Hyperelastic) {
        for lane in 0..8 {
            let (f, out, step) = (deformation::<D>(lane), 1.1, 1e-6);
            let found = gel.sheared(&f, out);
            for (i, j) in (0..D).flat_map(|i| (0..D).map(move |j| (i, j))) {
                let energy = |step: f64| {
                    let mut f = f;
                    f[i][j] += step;
                    gel.sheared(&f, out).energy
                };
                let slope = (energy(step) - energy(-step)) / (2.0 * step);
                assert!((slope - found.stress[i][j]).abs() < 1e-6 * (1.0 + slope.abs()), "{lane} {i} {j}");
            }
            let along = |step: f64| gel.sheared(&f, out + step).energy;
            let slope = (along(step) - along(-step)) / (2.0 * step);
            assert!(D == 3 || (slope - found.out * out).abs() < 1e-6 * (1.0 + slope.abs()), "{lane}");
        }
    }

    fn terms() -> [OgdenTerm; 2] {
        [(1.3, 2.7), (-0.4, -3.1)].map(|(modulus, exponent)| OgdenTerm { modulus, exponent })
    }

    #[test]
    fn eight_deformations_have_the_bits_of_one() {
        check::<2>(&NeoHookean::new(3.0, 40.0));
        check::<3>(&MooneyRivlin::new([1.2, 0.3], 40.0));
        check::<2>(&Ogden::new(&terms(), 40.0));
        check::<3>(&Ogden::new(&terms(), 40.0));
    }

    #[test]
    fn stress_is_the_derivative_of_the_energy() {
        check_stress::<2>(&NeoHookean::new(3.0, 40.0));
        check_stress::<2>(&MooneyRivlin::new([1.2, 0.3], 40.0));
        check_stress::<3>(&MooneyRivlin::new([1.2, 0.3], 40.0));
        check_stress::<2>(&Ogden::new(&terms(), 40.0));
        check_stress::<3>(&Ogden::new(&terms(), 40.0));
    }
}
