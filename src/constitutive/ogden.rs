#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::{Hyperelastic, LogarithmicEnergy, ShearResponse};
use crate::math::{Number, SymmetricTensor, diagonalise, power};

/// Term μ_p, α_p of an [`Ogden`] solid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OgdenTerm {
    /// μ_p, Pa.
    pub modulus: f64,
    /// α_p.
    pub exponent: f64,
}

/// Compressible Ogden solid (Ogden 1972) of one to three terms, with the neo-Hookean volumetric energy.
///
/// ψ = Σ_p μ_p/α_p (λ₁^α_p + λ₂^α_p + λ₃^α_p − 3) + U(J), U = −(Σμ_p) ln J + Λ/2 (ln J)²; hence P = F S + U′(J) cof
/// F, where S has the eigenvectors of C = FᵀF and the eigenvalues Σ μ_p λ_i^(α_p − 2). Small strains give μ = ½ Σ μ_p
/// α_p and K = Λ + 2μ/3. One term of α = 2 is the neo-Hookean solid.
///
/// Below c₀ = J₀² each principal energy continues, in c = λ², as its second-order Taylor polynomial; J₀ is the floor
/// of U. ψ_s is then twice differentiable for every F, inverted elements included, with a bounded curvature.
///
/// **Stable** for μ_p α_p > 0 in every term and Λ ≥ 0. Of the logarithmic strains e_i, ψ is Σ μ_p/α_p exp(α_p e_i) −
/// m Σ e_i + Λ/2 (Σ e_i)², each part convex (Hill's inequality, Drucker's postulate at large strain; Ogden 1984,
/// 6.2). A term of the other sign can be balanced by other terms in a range of strains, but not at all strains: the
/// constructor refuses it.
///
/// **Curvature.** With g(s) the principal energy, F = diag(s_i) without its rotations, d²ψ_s along H is Σ g″(s_i)
/// h_i² and, of each pair, (g′_i − g′_j)/(s_i − s_j) and (g′_i + g′_j)/(s_i + s_j) times ½(H_ij ± H_ji)². The first
/// quotient is a g″ in between, the second a mean of g′/s at both. For one term g″ and g′/s are monotone in c above
/// c₀ and below: the maximum is at an end of the range of stretches, or at c₀. d²ψ_s ≤ a|H|², a being the sum of
/// these maxima over the terms.
///
/// **Powers** are those of [`power`], of exact operations only; eigenvalues come from Jacobi rotations.
///
/// **Domain.** One term fits gelatin up to its fracture (Czerner and others 2013, porcine and bovine). It also fits
/// pig skin, where a higher rate raises μ and not α (Shergold and others 2006). Their constants are not shipped; take
/// them from your own test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ogden {
    terms: [OgdenTerm; Self::MOST_TERMS],
    n_terms: usize,
    lambda: f64,
}

impl Ogden {
    /// Most terms: Ogden's own fit of rubber to sevenfold stretch has three.
    pub const MOST_TERMS: usize = 3;
    /// Valid magnitudes of the exponents: below, λ^α − 1 loses its digits; above, no gel or tissue has been fitted.
    pub const EXPONENTS: std::ops::RangeInclusive<f64> = 0.1..=30.0;
    /// Squared stretch c₀ below which the continuation begins.
    const FLOOR: f64 = LogarithmicEnergy::FLOOR * LogarithmicEnergy::FLOOR;

    /// Creates the solid from its terms and the bulk modulus K, Pa.
    ///
    /// # Panics
    /// Unless there are 1 to [`Self::MOST_TERMS`] terms of μ_p α_p > 0 and |α_p| in [`Self::EXPONENTS`], and K ≥ 2μ/3.
    #[must_use]
    pub fn new(terms: &[OgdenTerm], bulk_modulus: f64) -> Self {
        let n_terms = terms.len();
        let known = (1..=Self::MOST_TERMS).contains(&n_terms);
        let is_valid = |t: &OgdenTerm| t.modulus * t.exponent > 0.0 && Self::EXPONENTS.contains(&t.exponent.abs());
        assert!(known && terms.iter().all(is_valid), "an Ogden solid has 1 to 3 terms of mu alpha > 0");
        let lambda = bulk_modulus - 2.0 / 3.0 * Self::shear_modulus_of(terms);
        assert!(lambda >= 0.0, "a stable solid needs K >= 2/3 mu");
        let mut own = [terms[0]; Self::MOST_TERMS];
        own[..n_terms].copy_from_slice(terms);
        Self { terms: own, n_terms, lambda }
    }

    /// Returns the shear modulus at rest of the terms, Pa: ½ Σ μ_p α_p.
    #[must_use]
    pub fn shear_modulus_of(terms: &[OgdenTerm]) -> f64 {
        0.5 * terms.iter().map(|term| term.modulus * term.exponent).sum::<f64>()
    }

    /// Returns μ at rest, Pa.
    #[must_use]
    pub fn shear_modulus(&self) -> f64 {
        Self::shear_modulus_of(self.terms())
    }

    /// Returns K at rest, Pa.
    #[must_use]
    pub fn bulk_modulus(&self) -> f64 {
        self.lambda + 2.0 / 3.0 * self.shear_modulus()
    }

    fn terms(&self) -> &[OgdenTerm] {
        &self.terms[..self.n_terms]
    }

    /// Returns the energy of a principal stretch, J/m³, and g′/s, Pa, as functions of its square c.
    #[inline(always)]
    fn principal<V: Number>(&self, c: V) -> PrincipalResponse<V> {
        let mut sum = PrincipalResponse { energy: c.constant(0.0), pull: c.constant(0.0) };
        for term in self.terms() {
            let own = term.principal(c);
            sum = PrincipalResponse { energy: sum.energy + own.energy, pull: sum.pull + own.pull };
        }
        sum
    }

    /// Returns an upper bound of g″ and g′/s for squared stretches from `low` to `high`, Pa.
    #[inline(always)]
    fn max_stiffness<V: Number>(&self, low: V, high: V) -> V {
        let floor = lesser(low.at_least(Self::FLOOR), high);
        let mut sum = low.constant(0.0);
        for term in self.terms() {
            sum = sum + term.stiffness(low).or_greater(term.stiffness(floor)).or_greater(term.stiffness(high));
        }
        sum
    }
}

/// Energy of a principal stretch s, J/m³, and its derivative over s, Pa.
struct PrincipalResponse<V> {
    energy: V,
    pull: V,
}

/// Power c^(α/2) = λ^α with c clamped to c₀, and its Taylor coefficients there.
struct PrincipalPower<V> {
    power: V,
    /// Distance of c below c₀, at most 0.
    below: V,
    /// 2f′, Pa.
    pull: V,
    /// 2f″, Pa.
    bend: V,
}

impl OgdenTerm {
    /// Returns the principal energy f = μ/α (c^(α/2) − 1) by its power: f′ = μ/2 c^(α/2 − 1), f″ = (α/2 − 1) f′/c.
    #[inline(always)]
    fn power<V: Number>(&self, c: V) -> PrincipalPower<V> {
        let at = c.at_least(Ogden::FLOOR);
        let power = power(at, 0.5 * self.exponent);
        let pull = power * self.modulus / at;
        PrincipalPower { power, below: c - at, pull, bend: pull * (0.5 * self.exponent - 1.0) / at }
    }

    /// Returns the principal energy, and g′/s = 2f′ with s = √c.
    #[inline(always)]
    fn principal<V: Number>(&self, c: V) -> PrincipalResponse<V> {
        let PrincipalPower { power, below, pull, bend } = self.power(c);
        let energy = (power - 1.0) * (self.modulus / self.exponent);
        let half = below * 0.5;
        PrincipalResponse { energy: energy + half * (pull + half * bend), pull: pull + below * bend }
    }

    /// Returns the greater of g′/s = 2f′ and g″ = 2f′ + 4c f″.
    #[inline(always)]
    fn stiffness<V: Number>(&self, c: V) -> V {
        let PrincipalPower { below, pull, bend, .. } = self.power(c);
        let ratio = pull + below * bend;
        ratio.or_greater(ratio + c * 2.0 * bend)
    }
}

/// Returns the minimum of two numbers.
#[inline(always)]
fn lesser<V: Number>(a: V, b: V) -> V {
    -(-a).or_greater(-b)
}

impl Hyperelastic for Ogden {
    fn volume(&self) -> LogarithmicEnergy {
        LogarithmicEnergy { rest: self.terms().iter().fold(0.0, |sum, term| sum + term.modulus), lambda: self.lambda }
    }

    #[inline(always)]
    fn sheared<const D: usize, V: Number>(&self, f: &[[V; D]; D], out: V) -> ShearResponse<D, V> {
        let c = SymmetricTensor::right_cauchy_green(f, out);
        let (squares, directions) = diagonalise(c.rows());
        let zero = out.constant(0.0);
        let mut response = ShearResponse { energy: zero, stress: [[zero; D]; D], out: zero, curvature: [zero; 2] };
        let (mut least, mut greatest) = (squares[0], squares[0]);
        for a in 0..D {
            (least, greatest) = (lesser(least, squares[a]), greatest.or_greater(squares[a]));
            let own = self.principal(squares[a].at_least(0.0));
            response.energy = response.energy + own.energy;
            for i in 0..D {
                let mut turned = f[i][0] * directions[0][a];
                for k in 1..D {
                    turned = turned + f[i][k] * directions[k][a];
                }
                for j in 0..D {
                    response.stress[i][j] = response.stress[i][j] + turned * own.pull * directions[j][a];
                }
            }
        }
        let mut stiffest = self.max_stiffness(least.at_least(0.0), greatest);
        if D == 2 {
            let own = self.principal(c.out);
            (response.energy, response.out) = (response.energy + own.energy, own.pull);
            stiffest = stiffest.or_greater(self.max_stiffness(c.out, c.out));
        }
        response.curvature[0] = stiffest.at_least(0.0);
        response
    }
}
