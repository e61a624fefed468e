//! A rigid mass hits a bar: exponential slowing, and Saint-Venant's rebound from a bar whose far end is held.

use super::bar::{Bar, Pace, Springs, advance, common_step, striker, unit_bar};
use super::row::{Row, order, series};
use ballistic_gel::contact::BodyMotion;
use ballistic_gel::integrator::Engine;
use std::sync::OnceLock;

const CELLS: [usize; 3] = [50, 200, 800];
/// Speed of the mass, in wave speeds.
const SPEED: f64 = 1e-3;

/// A bar and a mass that touches it after half a step, and that step.
fn struck(bar: Bar, (mass, cfl): (f64, f64)) -> (Engine<2, Springs>, f64) {
    let step = common_step(&touching(bar, (mass, cfl), -0.1));
    (touching(bar, (mass, cfl), -0.5 * step * SPEED), step)
}

/// A bar and a mass whose face is at `z`, after the first tick.
fn touching(bar: Bar, (mass, cfl): (f64, f64), z: f64) -> Engine<2, Springs> {
    let mut engine = bar.engine(Pace { cfl, restitution: 0.0 }, &striker(BodyMotion::Free, mass, (z, SPEED)), |_| 0.0);
    advance(&mut engine, 0.0);
    engine
}

/// Greatest |v − v₀ exp(−ρcAt/M)|/v₀ until 1.96 L/c, M the mass of the bar: the wave returns at 2 L/c, and the grid lets
/// its short components run ahead a little. A velocity of the scheme belongs to the middle of its step.
fn slowing(cells: usize) -> f64 {
    let (mut engine, step) = struck(unit_bar(cells), (1.0, 0.5));
    let error = |i: u32| {
        advance(&mut engine, f64::from(i) * step);
        let exact = (-f64::from(i) * step).exp();
        (engine.state().bodies[0].velocity.z / SPEED - exact).abs()
    };
    (1..(1.96 / step) as u32).map(error).fold(0.0, f64::max)
}

fn semi_infinite() -> Row {
    let points = CELLS.map(|n| (1.0 / n as f64, slowing(n)));
    let slope = order(&points);
    let met =
        points.iter().zip([0.0062, 0.0016, 0.0004]).all(|((_, e), limit)| *e <= limit) && (slope - 1.0).abs() < 0.1;
    let name = ("V6", "mass on a semi-infinite bar, v₀ exp(−ρcAt/M): greatest error of v/v₀, CFL .5, N = 50/200/800");
    Row::new(name, "within .0062 / .0016 / .0004, slope 1", series(points.map(|p| p.1), 4), met).with_order(slope)
}

/// A line of Saint-Venant's table: M/m, time and speed of separation, and errors of the speed to be reached.
struct Line {
    ratio: f64,
    separation: f64,
    speed: f64,
    errors: [f64; 3],
}

const LINES: [Line; 3] = [
    Line { ratio: 0.1, separation: 2.1, speed: -0.73576, errors: [0.1, 0.024, 0.006] },
    Line { ratio: 1.0, separation: 3.0677, speed: -0.68762, errors: [0.0010, 0.0004, 0.0001] },
    Line { ratio: 10.0, separation: 9.5411, speed: -0.94913, errors: [0.0002, 0.00003, 0.00001] },
];

/// Error of v/v₀ at 1.02 of the time of separation, and the time of the last impulse so far.
fn rebound(line: &Line, cells: usize) -> (f64, f64) {
    let bar = Bar { held: true, ..unit_bar(cells) };
    let (mut engine, step) = struck(bar, (line.ratio, 0.9));
    advance(&mut engine, 1.02 * line.separation + 0.5 * step);
    common_step(&engine);
    let last = engine.state().record.contacts[0].touched.map_or(0.0, |touched| touched.1);
    (engine.state().bodies[0].velocity.z / SPEED - line.speed, last - 0.5 * step)
}

fn fixed_bar(line: &Line) -> [Row; 2] {
    let runs = CELLS.map(|n| rebound(line, n));
    let errors = runs.map(|run| run.0);
    let met = errors.iter().zip(line.errors).all(|(error, limit)| error.abs() <= limit);
    let what =
        format!("mass on a held bar, M/m = {}: error of v/v₀ after the rebound, CFL .9, N = 50/200/800", line.ratio);
    let expected = format!("{:.5}, within {}", line.speed, series(line.errors, 5));
    let speed = Row::new(("V7", &what), &expected, series(errors, 5), met);
    let last = runs[2].1;
    let met = (last / line.separation - 1.0).abs() < 0.01;
    let expected = format!("{:.3} ± 1 %", line.separation);
    [speed, Row::new(("V7", "same, N = 800: time of separation, L/c"), &expected, format!("{last:.3}"), met)]
}

/// The rows of this part, computed once.
pub fn rows() -> &'static [Row] {
    static ROWS: OnceLock<Vec<Row>> = OnceLock::new();
    ROWS.get_or_init(|| {
        let mut rows = vec![semi_infinite()];
        rows.extend(LINES.iter().flat_map(fixed_bar));
        rows
    })
}

#[test]
fn a_rigid_mass_is_slowed_and_thrown_back_as_the_closed_forms_say() {
    Row::check(rows());
}

/// A node that rests on the body at a distance of exactly zero must not be lost by rounding.
#[test]
fn a_mass_that_starts_touching_rebounds_alike() {
    for line in &LINES[1..] {
        let bar = Bar { held: true, ..unit_bar(50) };
        let mut engine = touching(bar, (line.ratio, 0.9), 0.0);
        advance(&mut engine, 1.02 * line.separation);
        let error = engine.state().bodies[0].velocity.z / SPEED - line.speed;
        assert!(error.abs() < 1e-3, "M/m = {}: the rebound is {error:.5} off", line.ratio);
    }
}
