//! A mass against a spring, M = k = v₀ = 1, driven by masters of the co-simulation that differ in how they move it.
//!
//! The spring is one element whose free node weighs a millionth of the mass. In the modes A the master prescribes the motion
//! x + v s within a step of H and gets the impulse J back, v′ = v + J/M; A1 moves on to x + H v, A3 to x + H (v + v′)/2.
//! In B the body is integrated inside and the master only looks on.

use super::bar::{Bar, Pace, Springs, advance, striker};
use super::row::{Row, series};
use ballistic_gel::contact::{BodyMotion, BodyState};
use ballistic_gel::integrator::Engine;
use std::sync::OnceLock;

/// Relative mass of the free node.
const LIGHT: f64 = 1e-6;

/// Fraction of the stable step. Where A3 draws the body back, the free node has to catch up and comes to rest as deep in
/// the body as it runs in one step: at 0.5 that would be half of the compression of the spring.
const CFL: f64 = 0.005;

/// Longer than the contact, π.
const END: f64 = 4.0;

/// Where the master moves the body after a step, as weights of the old and the new velocity.
#[derive(Clone, Copy)]
struct Master(f64, f64);

const A1: Master = Master(1.0, 0.0);
const A3: Master = Master(0.5, 0.5);

fn spring(motion: BodyMotion) -> Engine<2, Springs> {
    let bar = Bar { length: 10.0, modulus: 10.0, density: 2.0 * LIGHT / 10.0, cells: 1, held: true };
    bar.engine(Pace { cfl: CFL, restitution: 0.0 }, &striker(motion, 1.0, (0.0, 1.0)), |_| 0.0)
}

/// Error of the energy of the mass after the rebound, by a master of the prescribed modes in the engine.
fn prescribed(master: Master, step: f64) -> f64 {
    let mut engine = spring(BodyMotion::Prescribed);
    let n = (END / step) as u32;
    for i in 0..n {
        let (body, start) = (engine.bodies()[0].clone(), engine.state().bodies[0]);
        let end = f64::from(i + 1) * step;
        let was = start.at(&body, f64::from(i) * step);
        let after = was.velocity + advance(&mut engine, end).impulse;
        let position = was.position + step * (was.velocity * master.0 + after * master.1);
        engine.set_body(0, &BodyState { time: end, position, velocity: after, ..was });
    }
    engine.state().bodies[0].velocity.z.powi(2) - 1.0
}

/// The same against a spring without mass, in closed form: J = −k ∫ max(0, x + v s) ds.
fn massless(master: Master, step: f64) -> f64 {
    let (mut x, mut v) = (0.0_f64, 1.0_f64);
    for _ in 0..(END / step) as u32 {
        let (from, to) = (x, x + step * v);
        let area = match (from > 0.0, to > 0.0) {
            (true, true) => 0.5 * (from + to) * step,
            (false, false) => 0.0,
            _ => 0.5 * from.max(to).powi(2) / v.abs(),
        };
        let after = v - area;
        x += step * (v * master.0 + after * master.1);
        v = after;
    }
    v * v - 1.0
}

/// Error of the energy and the bits of the state after the rebound, integrated inside, with this many communication steps.
fn integrated(steps: u32) -> (f64, u128) {
    let mut engine = spring(BodyMotion::Free);
    for i in 1..=steps {
        advance(&mut engine, END * f64::from(i) / f64::from(steps));
    }
    (engine.state().bodies[0].velocity.z.powi(2) - 1.0, engine.state().digest())
}

fn frozen_kinematics() -> [Row; 3] {
    let h = 1.0 / 32.0;
    let (reference, obtained) = (massless(A1, h), prescribed(A1, h));
    let a1 =
        ("V10", "mass on a spring, M = k = v₀ = 1, H = 1/32, master A1 (x + H v): change of energy, massless spring");
    let engine = ("V10", "same in the engine, free node 1e-6 M");
    let energies = [1.0 / 16.0, h, 0.5 * h].map(|h| prescribed(A3, h));
    let a3 = ("V10", "same, master A3 (x + H (v + v′)/2), H = 1/16, 1/32, 1/64");
    [
        Row::new(a1, "+.0503 ± .0001", format!("{reference:+.4}"), (reference - 0.0503).abs() < 1e-4),
        Row::new(engine, "+.0503 ± .0005", format!("{obtained:+.4}"), (obtained - 0.0503).abs() < 5e-4),
        Row::new(a3, "→ 0, below 1e-3", series(energies, 5), energies.iter().all(|e| e.abs() < 1e-3)),
    ]
}

fn inside() -> [Row; 2] {
    let runs = [1, 7, 100, 12_345].map(integrated);
    let energy = runs[0].0;
    let same = runs.iter().all(|run| run.1 == runs[0].1);
    let first = ("V10", "same, body integrated inside (B): change of energy");
    let second = ("V10", "same, 1, 7, 100 and 12 345 communication steps: bits of the state");
    let verdict = if same { "equal" } else { "different" };
    [
        Row::new(first, "0 ± 1e-5", format!("{energy:+.6}"), energy.abs() < 1e-5),
        Row::new(second, "equal", verdict.into(), same),
    ]
}

/// The rows of this part, computed once.
pub fn rows() -> &'static [Row] {
    static ROWS: OnceLock<Vec<Row>> = OnceLock::new();
    ROWS.get_or_init(|| frozen_kinematics().into_iter().chain(inside()).collect())
}

#[test]
fn masters_gain_and_keep_energy_as_the_analysis_says() {
    Row::check(rows());
}
