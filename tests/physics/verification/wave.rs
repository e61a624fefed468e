//! A step wave in a bar whose end is pushed at a constant speed: front, stress, and reflection at the free end.

use super::bar::{Pace, Springs, advance, common_step, striker, unit_bar};
use super::row::{Row, below};
use ballistic_gel::contact::BodyMotion;
use ballistic_gel::integrator::Engine;
use std::sync::OnceLock;

/// Speed of the push, in wave speeds: the bar is linear, and a power of two rounds least.
const PUSH: f64 = 0.125;

fn pushed(cells: usize, cfl: f64, t: f64) -> Engine<2, Springs> {
    let pace = Pace { cfl, restitution: 0.0 };
    let mut engine = unit_bar(cells).engine(pace, &striker(BodyMotion::Prescribed, 1.0, (0.0, PUSH)), |_| 0.0);
    advance(&mut engine, t);
    common_step(&engine);
    engine
}

/// Compressive stress over ρ c v in the springs whose middles lie between two heights: worst deviation from `expected`,
/// and mean.
fn stress(engine: &Engine<2, Springs>, (from, to): (f64, f64), expected: f64) -> (f64, f64) {
    let (springs, state) = (&engine.gel().potential, engine.state());
    let n = springs.stiffness.len();
    let inside = (0..n).filter(|i| ((*i as f64 + 0.5) / n as f64 - from) * ((*i as f64 + 0.5) / n as f64 - to) < 0.0);
    let values: Vec<f64> = inside.map(|i| -springs.tension(i, &state.position) / PUSH).collect();
    let worst = values.iter().map(|s| (s - expected).abs()).fold(0.0, f64::max);
    (worst, values.iter().sum::<f64>() / values.len() as f64)
}

/// At CFL 1 the scheme carries a wave without dispersion: the front stands at c t to the cell, the stress behind it is
/// ρ c v and before it zero, and the free end moves at 2 v.
fn without_dispersion() -> Row {
    let half = pushed(64, 1.0, 0.5);
    let error = stress(&half, (0.0, 0.5), 1.0).0.max(stress(&half, (0.5, 1.0), 0.0).0);
    let past = pushed(64, 1.0, 1.5);
    let doubling = (past.state().velocity[64][1] / PUSH - 2.0).abs();
    let relieved = stress(&past, (0.5, 1.0), 0.0).0;
    let worst = error.max(doubling).max(relieved);
    let name = ("V4", "step wave, N = 64, CFL 1: front at c t, stress ρcv, free end 2v, relief behind it");
    Row::new(name, "worst error < 1e-11", below(worst), worst < 1e-11)
}

/// At CFL 0.5 the front rings; behind it the mean is ρ c v, and the free end moves at 2 v in the mean.
fn with_dispersion() -> Row {
    let half = pushed(800, 0.5, 0.5);
    let mean = stress(&half, (0.05, 0.4), 1.0).1;
    let velocities = &half.state().velocity;
    let front = velocities.iter().rposition(|v| v[1] > 0.5 * PUSH).unwrap_or(0) as f64 / 800.0 / 0.5;
    let (early, late) = (pushed(800, 0.5, 1.2), pushed(800, 0.5, 1.6));
    let end = |engine: &Engine<2, Springs>, t: f64| engine.position_at(ballistic_gel::mesh::NodeId(800), t)[1];
    let doubled = (end(&late, 1.6) - end(&early, 1.2)) / (0.4 * PUSH);
    let met = (mean - 1.0).abs() < 2e-3 && (front - 1.0).abs() < 0.01 && (doubled - 2.0).abs() < 0.01;
    let obtained = format!("{mean:.4}, {front:.3}, {doubled:.3}");
    let name = ("V4", "same, N = 800, CFL .5: mean stress/ρcv, front speed/c, speed of the free end/v");
    Row::new(name, "1 ± .002, 1 ± .01, 2 ± .01", obtained, met)
}

/// The rows of this part, computed once.
pub fn rows() -> &'static [Row] {
    static ROWS: OnceLock<Vec<Row>> = OnceLock::new();
    ROWS.get_or_init(|| vec![without_dispersion(), with_dispersion()])
}

#[test]
fn a_step_wave_has_its_speed_its_stress_and_its_reflection() {
    Row::check(rows());
}
