use super::NeoHookean;
use super::hyperelastic::{Hyperelastic, LogarithmicEnergy, ShearResponse, right_cauchy_green, squared_stretch};
use crate::math::{Tensor, spectral};

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
/// **Powers** come from the crate `libm`, within an ulp and of exact operations only; eigenvalues from Jacobi
/// rotations.
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
    const FLOOR: f64 = NeoHookean::FLOOR * NeoHookean::FLOOR;

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
    fn principal(&self, c: f64) -> (f64, f64) {
        self.terms().iter().map(|term| term.principal(c)).fold((0.0, 0.0), |sum, own| (sum.0 + own.0, sum.1 + own.1))
    }

    /// Returns an upper bound of g″ and g′/s for squared stretches from `low` to `high`, Pa.
    fn max_stiffness(&self, low: f64, high: f64) -> f64 {
        let ends = [low, Self::FLOOR.max(low).min(high), high];
        let greatest = |term: &OgdenTerm| ends.map(|c| term.stiffness(c)).into_iter().fold(f64::MIN, f64::max);
        self.terms().iter().map(greatest).sum()
    }
}

impl OgdenTerm {
    /// Returns c^(α/2) = λ^α, c clamped to c₀, and the distance of c below c₀, at most 0.
    fn power(&self, c: f64) -> (f64, f64, f64) {
        let at = c.max(Ogden::FLOOR);
        (libm::pow(at, 0.5 * self.exponent), at, c - at)
    }

    /// Principal energy and its derivative by c: f = μ/α (c^(α/2) − 1), f′ = μ/2 c^(α/2 − 1), f″ = (α/2 − 1) f′/c;
    /// with s = √c, g′/s = 2f′.
    fn principal(&self, c: f64) -> (f64, f64) {
        let (power, at, below) = self.power(c);
        let pull = self.modulus * power / at;
        let bend = (0.5 * self.exponent - 1.0) * pull / at;
        let energy = self.modulus * (power - 1.0) / self.exponent;
        (energy + 0.5 * below * (pull + 0.5 * below * bend), pull + below * bend)
    }

    /// Returns the greater of g′/s = 2f′ and g″ = 2f′ + 4c f″.
    fn stiffness(&self, c: f64) -> f64 {
        let (power, at, below) = self.power(c);
        let pull = self.modulus * power / at;
        let bend = (0.5 * self.exponent - 1.0) * pull / at;
        let ratio = pull + below * bend;
        ratio.max(ratio + 2.0 * c * bend)
    }
}

impl Hyperelastic for Ogden {
    fn volume(&self) -> LogarithmicEnergy {
        LogarithmicEnergy { rest: self.terms().iter().fold(0.0, |sum, term| sum + term.modulus), lambda: self.lambda }
    }

    fn sheared<const D: usize>(&self, f: &Tensor<D>, out: f64) -> ShearResponse<D> {
        let (squares, directions) = spectral(&right_cauchy_green(f));
        let (mut energy, mut pull) = (0.0, Tensor::<D>::zeros());
        for (square, direction) in squares.iter().zip(directions.column_iter()) {
            let (own, along) = self.principal(square.max(0.0));
            energy += own;
            pull += direction * direction.transpose() * along;
        }
        let mut stiffest = self.max_stiffness(squares.min().max(0.0), squares.max());
        let mut across_pull = 0.0;
        if D == 2 {
            let square = squared_stretch::<D>(out);
            let (own, along) = self.principal(square);
            (energy, across_pull) = (energy + own, out * along);
            stiffest = stiffest.max(self.max_stiffness(square, square));
        }
        ShearResponse { energy, stress: f * pull, out: across_pull, curvature: [stiffest.max(0.0), 0.0] }
    }
}
