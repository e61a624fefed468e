//! The fitter on an analytic model of shots with scatter.

use super::*;

/// Scatter of a computed value, relative: a hash of the point, uniform within ± `size`.
fn scatter(point: &DVector<f64>, shot: usize, size: f64) -> f64 {
    let mixed = point
        .iter()
        .fold(shot as u64, |hash, x| (hash ^ x.to_bits()).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29));
    size * (2.0 * (mixed.wrapping_mul(0xD6E8_FEB8_6659_FD93) >> 11) as f64 / (1u64 << 53) as f64 - 1.0)
}

/// Depth, its growth with the speed, and cavity, as powers of stress, exponent and modulus near those of gelatin.
fn shots(point: &DVector<f64>, size: f64) -> DVector<f64> {
    let [stress, exponent, modulus] = [point[0], point[1], point[2]];
    let depth = 0.085 * (-0.35 * stress - 0.08 * exponent - 0.05 * modulus + 0.03 * stress * stress).exp();
    let slope = 0.51e-3 * (-0.3 * stress - 0.2 * exponent).exp();
    let cavity = 0.058 * (-0.2 * stress + 0.3 * exponent - 0.25 * modulus).exp();
    DVector::from_vec(
        [depth, slope, cavity].iter().enumerate().map(|(i, x)| x * (1.0 + scatter(point, i, size))).collect(),
    )
}

const DEPTH: FitTarget = FitTarget { value: 0.085, band: 0.5e-3, window: 0.0 };
const SLOPE: FitTarget = FitTarget { value: 0.51e-3, band: 0.02e-3, window: 0.05e-3 };
const CAVITY: FitTarget = FitTarget { value: 0.058, band: 8e-3, window: 0.0 };

fn unbounded() -> DVector<f64> {
    DVector::from_element(3, f64::INFINITY)
}

/// Fits the analytic shots with a scatter; returns the result and the number of points.
fn fit_shots(targets: &[FitTarget], upper: &DVector<f64>, start: [f64; 3], size: f64) -> (FitResult, usize) {
    let mut n = 0;
    let mut model = |_: &str, points: &[DVector<f64>]| {
        n += points.len();
        Ok(points.iter().map(|point| Ok(shots(point, size))).collect())
    };
    let result = fit(targets, upper, DVector::from_row_slice(&start), &mut model).unwrap();
    (result, n)
}

#[test]
fn scattered_shots_are_met_within_their_scatter() {
    for (k, size) in [0.0, 1e-3, 3e-3].into_iter().enumerate() {
        for start in [[0.6, -0.1, 0.5], [-0.7, 0.05, -0.9], [1.5, -0.2, 0.0], [0.05, 0.0, -0.02]] {
            let (result, n) = fit_shots(&[DEPTH, SLOPE, CAVITY], &unbounded(), start, size);
            let computed = result.computed.as_ref().unwrap();
            // A scatter of 0.3 % of the depth is half of its band.
            let limit = [0.1, 0.35, 0.75][k];
            let worst = [DEPTH, SLOPE, CAVITY].iter().zip(computed.iter()).map(|(t, c)| t.residual(*c).abs());
            let worst = worst.fold(0.0, f64::max);
            assert!(worst <= limit, "{start:?} with {size}: {worst}, {result:?}");
            assert!(n <= 30, "{start:?} with {size}: {n} points, {result:?}");
        }
    }
}

#[test]
fn a_window_accepts_what_an_exact_value_does_not() {
    let start = [0.3, -0.02, 0.4];
    let (windowed, _) = fit_shots(&[DEPTH, SLOPE, CAVITY], &unbounded(), start, 0.0);
    let computed = windowed.computed.as_ref().unwrap();
    let residuals = [DEPTH, SLOPE, CAVITY].iter().zip(computed.iter()).map(|(target, value)| target.residual(*value));
    assert!(residuals.into_iter().all(|residual| residual.abs() <= 0.1), "{windowed:?}");
    assert!((computed[1] / 0.51e-3 - 1.0).abs() > 5e-3, "the middle of the window does not draw: {windowed:?}");
    let exact = FitTarget { value: 0.47e-3, window: 0.0, ..SLOPE };
    let (bound, _) = fit_shots(&[DEPTH, exact, CAVITY], &unbounded(), start, 0.0);
    assert!((bound.computed.as_ref().unwrap()[1] / 0.47e-3 - 1.0).abs() < 5e-3, "{bound:?}");
    assert!(bound.point[1] > 0.1, "{bound:?}");
    let (held, _) = fit_shots(&[DEPTH, exact, CAVITY], &DVector::from_vec(vec![f64::INFINITY, 0.0, 9.0]), start, 0.0);
    assert_eq!(held.point[1], 0.0, "the exponent stays at its bound: {held:?}");
    assert!((held.computed.as_ref().unwrap()[0] / 0.085 - 1.0).abs() < 3e-3, "{held:?}");
}

#[test]
fn a_compromise_between_contradicting_shots_is_a_minimum_of_the_squares() {
    let other = FitTarget { value: 0.087, band: 1e-3, window: 0.0 };
    let targets = [DEPTH, other, CAVITY];
    let mut model = |_: &str, points: &[DVector<f64>]| {
        let both = |point: &DVector<f64>| shots(&DVector::from_vec(vec![point[0], 0.0, point[1]]), 0.0);
        Ok(points
            .iter()
            .map(|point| Ok(DVector::from_vec(vec![both(point)[0], both(point)[0], both(point)[2]])))
            .collect())
    };
    let upper = DVector::from_element(2, f64::INFINITY);
    let result = fit(&targets, &upper, DVector::from_vec(vec![0.4, 0.3]), &mut model).unwrap();
    assert_eq!(result.end, FitEnd::Converged);
    let depth = result.computed.unwrap()[0];
    // Weights 4 and 1 of 85 and 87 mm.
    assert!((depth - 0.0854).abs() < 5e-5, "{depth}");
}

#[test]
fn a_step_to_a_shot_without_a_value_is_shortened() {
    let mut model = |_: &str, points: &[DVector<f64>]| {
        let outcome = |point: &DVector<f64>| {
            if point[0] < -0.2 {
                Err("perforated".to_owned())
            } else {
                Ok(DVector::from_vec(vec![0.08 * (-point[0]).exp()]))
            }
        };
        Ok(points.iter().map(outcome).collect())
    };
    let upper = DVector::from_element(1, f64::INFINITY);
    let target = [FitTarget { value: 0.096, ..DEPTH }];
    let result = fit(&target, &upper, DVector::from_vec(vec![1.2]), &mut model).unwrap();
    assert_eq!(result.end, FitEnd::Converged, "{result:?}");
    let refused = fit(&target, &upper, DVector::from_vec(vec![-0.3]), &mut model).unwrap_err();
    assert_eq!(refused.to_string(), "perforated");
}

#[test]
fn an_interrupted_fit_keeps_its_best_point() {
    let mut calls = 0;
    let mut model = |_: &str, points: &[DVector<f64>]| {
        calls += 1;
        if calls > 3 {
            Err(FitBreak::Interrupted)
        } else {
            Ok(points.iter().map(|point| Ok(shots(point, 0.0))).collect())
        }
    };
    let targets = [DEPTH, SLOPE, CAVITY];
    let start = DVector::from_vec(vec![1.9, 0.0, 1.5]);
    let result = fit(&targets, &unbounded(), start.clone(), &mut model).unwrap();
    assert_eq!((result.end, result.iterations), (FitEnd::Interrupted, 2));
    let [before, after] =
        [shots(&start, 0.0), result.computed.unwrap()].map(|computed| DEPTH.residual(computed[0]).abs());
    assert!(after < 0.8 * before && result.point != start, "{before}, {after}");
}
