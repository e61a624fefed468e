//! Axial vibration of a free bar: errors of the frequency in space and time.

use super::bar::{Pace, advance, common_step, fixed_wall, unit_bar};
use super::row::{Row, below, order, series};
use ballistic_gel::mesh::NodeId;
use std::f64::consts::PI;
use std::sync::OnceLock;

/// Frequency of the first axial mode, w = πc/L = π, as computed with this many cells and this fraction of the step.
///
/// The lower end moves as A sin(w t) at the instants of the common step, so its positions at T, 2T, 3T give
/// cos(wT) = (x(T) + x(3T))/(2 x(2T)).
fn frequency(cells: usize, cfl: f64) -> f64 {
    let pace = Pace { cfl, restitution: 0.0 };
    let mut engine = unit_bar(cells).engine(pace, &fixed_wall(-1e3), |z| 1e-3 * (PI * z).cos());
    let mut moved = |t: f64| {
        advance(&mut engine, t);
        assert_eq!(common_step(&engine), cfl / cells as f64);
        engine.position_at(NodeId(0), t)[1]
    };
    let period = 0.25;
    let [first, second, third] = [1.0, 2.0, 3.0].map(|n| moved(n * period));
    ((first + third) / (2.0 * second)).acos() / period
}

/// Mesh: −(kh)²/24 (1 − cfl²) remains when the step is small.
fn in_space() -> Row {
    let cfl: f64 = 1.0 / 64.0;
    let points: Vec<(f64, f64)> =
        [8, 16, 32, 64].map(|n| (1.0 / f64::from(n), frequency(n as usize, cfl) / PI - 1.0)).to_vec();
    let slope = order(&points);
    let scaled = points.iter().map(|(h, error)| error / (-(PI * h).powi(2) / 24.0));
    let met = (slope - 2.0).abs() < 0.01 && scaled.clone().all(|s| (s - 1.0).abs() < 0.02);
    let obtained = format!("error/(−(kh)²/24) = {}", series(scaled, 3));
    let name = ("V3", "free bar, frequency of the first axial mode, N = 8/16/32/64 cells, dt → 0");
    Row::new(name, "error −(kh)²/24, slope 2", obtained, met).with_order(slope)
}

/// Step: +(w dt)²/24 against the frequency of the same mesh with exact time, (2/h) sin(kh/2).
fn in_time() -> Row {
    let h: f64 = 1.0 / 32.0;
    let exact = 2.0 / h * (0.5 * PI * h).sin();
    let points: Vec<(f64, f64)> = [0.5, 0.25, 0.125].map(|cfl| (cfl * h, frequency(32, cfl) / exact - 1.0)).to_vec();
    let slope = order(&points);
    let scaled = points.iter().map(|(dt, error)| error / ((exact * dt).powi(2) / 24.0));
    let met = (slope - 2.0).abs() < 0.01 && scaled.clone().all(|s| (s - 1.0).abs() < 0.02);
    let obtained = format!("error/((w dt)²/24) = {}", series(scaled, 3));
    let name = ("V3", "same, N = 32, CFL .5/.25/.125");
    Row::new(name, "error +(w dt)²/24, slope 2", obtained, met).with_order(slope)
}

/// At CFL 1 the two errors cancel.
fn at_one() -> Row {
    let error = (frequency(32, 1.0) / PI - 1.0).abs();
    let name = ("V3", "same, N = 32, CFL 1: the two errors cancel");
    Row::new(name, "relative error < 1e-12", below(error), error < 1e-12)
}

/// The rows of this part, computed once.
pub fn rows() -> &'static [Row] {
    static ROWS: OnceLock<Vec<Row>> = OnceLock::new();
    ROWS.get_or_init(|| vec![in_space(), in_time(), at_one()])
}

#[test]
fn frequencies_converge_with_second_order_in_space_and_time() {
    Row::check(rows());
}
