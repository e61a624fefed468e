use super::NeoHookean;
use super::hyperelastic::{Hyperelastic, Logarithmic, Sheared, across, right};
use crate::math::{Tensor, spectral};

/// A term of an [`Ogden`] solid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Term {
    /// μ_p, Pa.
    pub modulus: f64,
    /// α_p.
    pub exponent: f64,
}

/// Compressible Ogden solid (Ogden 1972) of one to three terms, with the volumetric energy of the neo-Hookean one.
///
/// ψ = Σ_p μ_p/α_p (λ₁^α_p + λ₂^α_p + λ₃^α_p − 3) + U(J), U = −(Σμ_p) ln J + Λ/2 (ln J)²; hence P = F S + U′(J) cof F, where S has the
/// directions of C = FᵀF and in each of them Σ μ_p λ_i^(α_p − 2). Small strains give μ = ½ Σ μ_p α_p and K = Λ + 2μ/3. One term of α = 2
/// is the neo-Hookean solid.
///
/// In c = λ² each principal energy is continued below c₀ = J₀², J₀ that of the volume, by its second-order Taylor polynomial: ψ_s is
/// then twice differentiable for every F, turned inside out or not, with a bounded curvature.
///
/// **Stable** for μ_p α_p > 0 in every term and Λ ≥ 0. Of the logarithmic strains e_i, ψ is Σ μ_p/α_p exp(α_p e_i) − m Σ e_i +
/// Λ/2 (Σ e_i)², each part convex (Hill's inequality, Drucker's postulate at large strain; Ogden 1984, 6.2). A term of the other sign
/// may be made up for by others in a range of strains, but not at all of them: it is refused.
///
/// **Curvature.** With g(s) the principal energy, F = diag(s_i) without its rotations, d²ψ_s along H is Σ g″(s_i) h_i² and, of each pair,
/// (g′_i − g′_j)/(s_i − s_j) and (g′_i + g′_j)/(s_i + s_j) times ½(H_ij ± H_ji)². The first quotient is a g″ in between, the second a mean of
/// g′/s at both. Of one term g″ and g′/s are monotone in c above c₀ and below: they are greatest at an end of the stretches, or at c₀.
/// d²ψ_s ≤ a|H|² with a = Σ_p of what is the greatest of term p there.
///
/// **Powers** are those of the crate `libm`, within an ulp and of exact operations only; eigenvalues are by Jacobi's rotations.
///
/// **Domain.** One term fits gelatin up to its fracture (Czerner and others 2013, porcine and bovine) and pig skin, of which a rate raises
/// μ and not α (Shergold and others 2006). Their constants are not ours to ship: those of your own test are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ogden {
    terms: [Term; Self::MOST_TERMS],
    n_terms: usize,
    lambda: f64,
}

impl Ogden {
    /// Most terms: Ogden's own fit of rubber to sevenfold stretch has three.
    pub const MOST_TERMS: usize = 3;
    /// Exponents of a magnitude that is understood: below, λ^α − 1 loses its digits; above, no gel or tissue has been fitted.
    pub const EXPONENTS: std::ops::RangeInclusive<f64> = 0.1..=30.0;
    /// c₀.
    const FLOOR: f64 = NeoHookean::FLOOR * NeoHookean::FLOOR;

    /// From its terms and the bulk modulus K, Pa.
    ///
    /// # Panics
    /// Unless there are 1 to [`Self::MOST_TERMS`] terms of μ_p α_p > 0 and |α_p| in [`Self::EXPONENTS`], and K ≥ 2μ/3.
    #[must_use]
    pub fn new(terms: &[Term], bulk_modulus: f64) -> Self {
        let n_terms = terms.len();
        let known = (1..=Self::MOST_TERMS).contains(&n_terms);
        let sound = |t: &Term| t.modulus * t.exponent > 0.0 && Self::EXPONENTS.contains(&t.exponent.abs());
        assert!(known && terms.iter().all(sound), "an Ogden solid has 1 to 3 terms of mu alpha > 0");
        let lambda = bulk_modulus - 2.0 / 3.0 * Self::shear_modulus_of(terms);
        assert!(lambda >= 0.0, "a stable solid needs K >= 2/3 mu");
        let mut own = [terms[0]; Self::MOST_TERMS];
        own[..n_terms].copy_from_slice(terms);
        Self { terms: own, n_terms, lambda }
    }

    /// μ at rest of such terms, Pa: ½ Σ μ_p α_p.
    #[must_use]
    pub fn shear_modulus_of(terms: &[Term]) -> f64 {
        0.5 * terms.iter().map(|term| term.modulus * term.exponent).sum::<f64>()
    }

    /// μ at rest, Pa.
    #[must_use]
    pub fn shear_modulus(&self) -> f64 {
        Self::shear_modulus_of(self.terms())
    }

    /// K at rest, Pa.
    #[must_use]
    pub fn bulk_modulus(&self) -> f64 {
        self.lambda + 2.0 / 3.0 * self.shear_modulus()
    }

    fn terms(&self) -> &[Term] {
        &self.terms[..self.n_terms]
    }

    /// Energy of a stretch, J/m³, and g′/s, Pa, by its square.
    fn principal(&self, c: f64) -> (f64, f64) {
        self.terms().iter().map(|term| term.principal(c)).fold((0.0, 0.0), |sum, own| (sum.0 + own.0, sum.1 + own.1))
    }

    /// The greatest that g″, or g′/s, can be between two squares of stretches, Pa.
    fn stiffest(&self, low: f64, high: f64) -> f64 {
        let ends = [low, Self::FLOOR.max(low).min(high), high];
        let greatest = |term: &Term| ends.map(|c| term.stiffness(c)).into_iter().fold(f64::MIN, f64::max);
        self.terms().iter().map(greatest).sum()
    }
}

impl Term {
    /// λ^α, which is c^(α/2), where the law holds; c there, and how far below that it is.
    fn power(&self, c: f64) -> (f64, f64, f64) {
        let at = c.max(Ogden::FLOOR);
        (libm::pow(at, 0.5 * self.exponent), at, c - at)
    }

    /// By c: f = μ/α (c^(α/2) − 1), f′ = μ/2 c^(α/2 − 1), f″ = (α/2 − 1) f′/c. Of s = √c, g′/s = 2f′.
    fn principal(&self, c: f64) -> (f64, f64) {
        let (power, at, below) = self.power(c);
        let pull = self.modulus * power / at;
        let bend = (0.5 * self.exponent - 1.0) * pull / at;
        let energy = self.modulus * (power - 1.0) / self.exponent;
        (energy + 0.5 * below * (pull + 0.5 * below * bend), pull + below * bend)
    }

    /// The greater of g′/s = 2f′ and g″ = 2f′ + 4c f″.
    fn stiffness(&self, c: f64) -> f64 {
        let (power, at, below) = self.power(c);
        let pull = self.modulus * power / at;
        let bend = (0.5 * self.exponent - 1.0) * pull / at;
        let ratio = pull + below * bend;
        ratio.max(ratio + 2.0 * c * bend)
    }
}

impl Hyperelastic for Ogden {
    fn volume(&self) -> Logarithmic {
        Logarithmic { rest: self.terms().iter().fold(0.0, |sum, term| sum + term.modulus), lambda: self.lambda }
    }

    fn sheared<const D: usize>(&self, f: &Tensor<D>, out: f64) -> Sheared<D> {
        let (squares, directions) = spectral(&right(f));
        let (mut energy, mut pull) = (0.0, Tensor::<D>::zeros());
        for (square, direction) in squares.iter().zip(directions.column_iter()) {
            let (own, along) = self.principal(square.max(0.0));
            energy += own;
            pull += direction * direction.transpose() * along;
        }
        let mut stiffest = self.stiffest(squares.min().max(0.0), squares.max());
        let mut across_pull = 0.0;
        if D == 2 {
            let square = across::<D>(out);
            let (own, along) = self.principal(square);
            (energy, across_pull) = (energy + own, out * along);
            stiffest = stiffest.max(self.stiffest(square, square));
        }
        Sheared { energy, stress: f * pull, out: across_pull, curvature: [stiffest.max(0.0), 0.0] }
    }
}
