//! Averages of the elastic left Cauchy–Green tensors b̄ of matter that becomes one element.

use crate::math::{SymmetricTensor, diagonalise, exp, ln};
use serde::{Deserialize, Serialize};

/// Elastic left Cauchy–Green tensor b̄ of determinant 1, with its logarithm.
#[derive(Clone, Copy)]
pub(crate) struct LeftCauchyGreen<const D: usize> {
    /// b̄.
    pub tensor: SymmetricTensor<D, f64>,
    /// ln b̄, of trace 0: twice the Hencky strain.
    pub logarithm: SymmetricTensor<D, f64>,
}

/// Part of an average.
#[derive(Clone, Copy)]
pub(crate) struct WeightedElastic<'a, const D: usize> {
    /// Share of the part: its rest measure, times what is left of its modulus.
    pub weight: f64,
    /// b̄ of the part.
    pub elastic: &'a LeftCauchyGreen<D>,
}

/// Rule by which a new element gets b̄ from the matter that it is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum ElasticAverage {
    /// Mean of ln b̄, whose deviator is scaled until the element stores what its parts stored.
    #[default]
    StoredEnergy,
    /// Mean of b̄ over the cube root of its determinant; loses the energy of the differences between the parts.
    NormalisedMean,
}

/// Greatest factor on the mean of ln b̄: parts that are strained against each other have no common direction.
const MOST_SCALED: f64 = 1.5;
/// Most Newton iterations for the factor.
const MAX_ITERATIONS: usize = 30;

impl<const D: usize> LeftCauchyGreen<D> {
    /// Creates the undistorted state, b̄ = 1.
    pub fn undistorted() -> Self {
        let out = |value: f64| if D == 2 { value } else { 0.0 };
        Self { tensor: SymmetricTensor::diagonal(1.0, out(1.0)), logarithm: SymmetricTensor::diagonal(0.0, 0.0) }
    }

    /// Creates the state of a positive definite tensor, scaled to a determinant of 1; `None` for another one.
    pub fn of(tensor: &SymmetricTensor<D, f64>) -> Option<Self> {
        let determinant = tensor.determinant();
        if !(determinant > 0.0 && determinant.is_finite()) {
            return None;
        }
        let part = exp(ln(determinant) * (-1.0 / 3.0));
        let tensor = tensor.scaled(part, 0.0);
        let (values, vectors) = diagonalise(tensor.rows());
        let is_positive = values.iter().all(|value| *value > 0.0) && (D == 3 || tensor.out > 0.0);
        is_positive.then(|| {
            let out = if D == 2 { ln(tensor.out) } else { 0.0 };
            Self { tensor, logarithm: SymmetricTensor::of_spectrum(values.map(ln), &vectors, out) }
        })
    }

    /// Returns tr b̄ − 3, twice the stored energy over the modulus.
    pub fn distortion(&self) -> f64 {
        self.tensor.trace() - 3.0
    }
}

/// Averages b̄ over its parts; knows no mesh.
///
/// b̄ of different elements may be averaged because it lives in the present configuration; a tensor of the reference
/// may not, since the references of remade elements are not comparable. `distortion` is tr b̄ − 3 of an element that
/// stores what the parts stored. By [`ElasticAverage::StoredEnergy`], b̄ = exp(s H) with H the mean of ln b̄: its
/// determinant is 1 for every s, and its trace grows with s, at s = 1 at most to the mean of the traces (the trace of
/// the exponential is convex).
pub(crate) fn average_elastic<const D: usize>(
    parts: &[WeightedElastic<'_, D>],
    distortion: f64,
    rule: ElasticAverage,
) -> LeftCauchyGreen<D> {
    let whole: f64 = parts.iter().map(|part| part.weight).sum();
    if whole <= 0.0 {
        return LeftCauchyGreen::undistorted();
    }
    let mean = |of: fn(&LeftCauchyGreen<D>) -> &SymmetricTensor<D, f64>| {
        parts.iter().fold(SymmetricTensor::diagonal(0.0, 0.0), |sum: SymmetricTensor<D, f64>, part| {
            sum.combined(1.0, of(part.elastic), part.weight / whole)
        })
    };
    match rule {
        ElasticAverage::NormalisedMean => {
            LeftCauchyGreen::of(&mean(|own| &own.tensor)).unwrap_or_else(LeftCauchyGreen::undistorted)
        }
        ElasticAverage::StoredEnergy => {
            let direction = mean(|own| &own.logarithm).deviator();
            let logarithm = direction.scaled(scale_to_distortion(&direction, distortion), 0.0);
            LeftCauchyGreen { tensor: logarithm.mapped(exp), logarithm }
        }
    }
}

/// Returns s ≤ [`MOST_SCALED`] with tr exp(s H) − 3 = `distortion`; Newton's iteration falls to it, since the trace is
/// convex in s.
fn scale_to_distortion<const D: usize>(direction: &SymmetricTensor<D, f64>, distortion: f64) -> f64 {
    let (values, _) = diagonalise(direction.rows());
    let all = values.into_iter().chain((D == 2).then_some(direction.out));
    let (mut scale, wanted) = (MOST_SCALED, distortion.max(0.0));
    for _ in 0..MAX_ITERATIONS {
        let (excess, slope) = all.clone().fold((-3.0 - wanted, 0.0), |(sum, slope), value| {
            let grown = exp(scale * value);
            (sum + grown, slope + value * grown)
        });
        if excess <= 0.0 || slope <= 0.0 {
            break;
        }
        let next = (scale - excess / slope).max(0.0);
        if next >= scale * (1.0 - f64::EPSILON) {
            break;
        }
        scale = next;
    }
    scale
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Tensor, array};

    /// b̄ of a stretch along a turned axis.
    fn stretched<const D: usize>(stretch: f64, angle: f64) -> LeftCauchyGreen<D> {
        let (c, s) = (angle.cos(), angle.sin());
        let turn = Tensor::<D>::from_fn(|i, j| match (i, j) {
            (0, 0) | (1, 1) => c,
            (0, 1) => -s,
            (1, 0) => s,
            _ => f64::from(u8::from(i == j)),
        });
        let square = stretch * stretch;
        let own = Tensor::<D>::from_fn(|i, j| {
            if i != j {
                0.0
            } else if i == 0 {
                square
            } else {
                1.0 / stretch
            }
        });
        let b = turn * own * turn.transpose();
        let tensor = SymmetricTensor { inner: array::rows(&b), out: if D == 2 { 1.0 / stretch } else { 0.0 } };
        LeftCauchyGreen::of(&tensor).expect("it is positive definite")
    }

    fn check<const D: usize>() {
        for (angle, stretch) in [(0.0, 1.3), (0.4, 2.0), (1.2, 1.01), (0.0, 4.0)] {
            let states = [stretched::<D>(stretch, 0.3), stretched::<D>(1.1 * stretch, 0.3 + angle)];
            let parts =
                [2.0, 1.0].iter().zip(&states).map(|(weight, elastic)| WeightedElastic { weight: *weight, elastic });
            let parts: Vec<_> = parts.collect();
            let stored = (2.0 * states[0].distortion() + states[1].distortion()) / 3.0;
            let kept = average_elastic(&parts, stored, ElasticAverage::StoredEnergy);
            let plain = average_elastic(&parts, stored, ElasticAverage::NormalisedMean);
            for found in [&kept, &plain] {
                assert!((found.tensor.determinant() - 1.0).abs() < 1e-12, "{angle}");
            }
            let is_common = angle < 1.0;
            assert!(!is_common || (kept.distortion() / stored - 1.0).abs() < 1e-9, "{angle}: {}", kept.distortion());
            assert!(kept.distortion() <= stored * (1.0 + 1e-9), "{angle}");
            assert!(plain.distortion() <= stored * (1.0 + 1e-9), "{angle}");
        }
        let alone = stretched::<D>(1.7, 0.5);
        let part = WeightedElastic { weight: 0.4, elastic: &alone };
        let same = average_elastic(&[part], alone.distortion(), ElasticAverage::StoredEnergy);
        let off = same.tensor.combined(1.0, &alone.tensor, -1.0);
        assert!(off.dot(&off).sqrt() < 1e-9, "one part is its own average");
        let nothing = average_elastic::<D>(&[], 0.0, ElasticAverage::StoredEnergy);
        assert_eq!(nothing.distortion(), 0.0);
    }

    #[test]
    fn an_average_has_determinant_one_and_stores_what_its_parts_stored() {
        check::<2>();
        check::<3>();
    }

    #[test]
    fn stretches_at_right_angles_have_no_common_direction() {
        let across = std::f64::consts::FRAC_PI_2;
        let states = [stretched::<3>(1.5, 0.0), stretched::<3>(1.5, across)];
        let parts = states.each_ref().map(|elastic| WeightedElastic { weight: 1.0, elastic });
        let found = average_elastic(&parts, states[0].distortion(), ElasticAverage::StoredEnergy);
        // Compressed along the third axis alone, by s = 1.5 of its mean.
        let third = (-1.5 * (1.5_f64).ln()).exp();
        assert!((found.tensor.inner[2][2] - third).abs() < 1e-12 && found.distortion() < states[0].distortion());
    }
}
