//! Resonance of a node between a slow and a fast spring, and how the nodal rule keeps out of it.
//!
//! Unit mass, slow spring w₁ = 1 kicked once per step, fast spring w₂ in exact motion between: one step multiplies the
//! state by a matrix of determinant 1 and half trace c = cos θ − θ/(2r²) sin θ with θ = w₂Δt, r = w₂/w₁. It is unstable
//! where |c| > 1, just below θ = π.

use super::bar::{Pace, Springs, advance, end_surface, fixed_wall, rules};
use super::row::{Row, series};
use ballistic_gel::contact::ContactSurface;
use ballistic_gel::integrator::{DiscreteGel, Engine};
use ballistic_gel::math::Vector;
use ballistic_gel::mesh::{NodeId, NodeIncidence};
use std::f64::consts::PI;
use std::sync::OnceLock;

const RATIOS: [f64; 5] = [2.0, 4.0, 8.0, 16.0, 32.0];
const WIDTHS: [f64; 5] = [0.194, 0.0584, 0.0152, 0.0037, 0.0008];
const GROWTHS: [f64; 5] = [1.414, 1.100, 1.0247, 1.0062, 1.0015];

/// Half trace of one step of length `dt`, from its two columns: a kick by the slow spring, then the fast motion.
fn half_trace(ratio: f64, dt: f64) -> f64 {
    let (cos, sin) = ((ratio * dt).cos(), (ratio * dt).sin());
    let step = |x: f64, v: f64| {
        let v = v - dt * x;
        (x * cos + v / ratio * sin, v * cos - x * ratio * sin)
    };
    0.5 * (step(1.0, 0.0).0 + step(0.0, 1.0).1)
}

/// Width of the window of unstable steps just below π/w₂, relative to π/w₂, and the greatest growth per step in it.
fn window(ratio: f64) -> (f64, f64) {
    const SAMPLES: u32 = 200_000;
    let steps = (1..=SAMPLES).map(|i| PI / ratio * (0.6 + 0.4 * f64::from(i) / f64::from(SAMPLES)));
    let unstable: Vec<f64> = steps.map(|dt| half_trace(ratio, dt).abs()).filter(|c| *c > 1.0 + 1e-12).collect();
    let greatest = unstable.iter().copied().fold(1.0, f64::max);
    (0.4 * unstable.len() as f64 / f64::from(SAMPLES), greatest + (greatest * greatest - 1.0).sqrt())
}

/// A free node of unit mass between a slow and a fast spring whose far ends are held, displaced and let go.
fn two_springs(ratio: f64) -> Engine<2, Springs> {
    let springs = Springs::new(vec![1.0, ratio * ratio], vec![1.0, 1.0]);
    let held = [[true, true], [true, false], [true, true]];
    let surface = ContactSurface {
        nodes: vec![],
        of: vec![None; 3],
        around: NodeIncidence::new(3, std::iter::empty::<&[NodeId]>()),
        ..end_surface(3, 1.0)
    };
    let gel = DiscreteGel::new(springs, vec![1.0; 3], &held, surface);
    let nodes = [0.0, 1.001, 2.0].map(|z| (Vector::<2>::new(0.0, z), Vector::<2>::zeros())).to_vec();
    Engine::new(gel, vec![fixed_wall(-10.0)], rules(Pace { cfl: 1.0, restitution: 0.0 }), nodes)
}

fn longest_step(engine: &Engine<2, Springs>) -> f64 {
    engine.steps().into_iter().fold(0.0, f64::max)
}

/// Longest step that the engine takes at CFL 1, over π/w₂, and the greatest energy of 1e5 steps over the first.
fn engine(ratio: f64) -> (f64, f64) {
    let mut engine = two_springs(ratio);
    advance(&mut engine, 0.0);
    let longest = longest_step(&engine);
    let energy = |engine: &Engine<2, Springs>, t: f64| engine.totals(t).energies.discrete();
    let start = energy(&engine, 0.0);
    let times = (1..=100).map(|i| 1000.0 * f64::from(i) * longest);
    let greatest = times.map(|t| {
        advance(&mut engine, t);
        energy(&engine, t) / start
    });
    let greatest = greatest.fold(0.0, f64::max);
    assert_eq!(longest_step(&engine), longest, "linear springs keep their steps");
    (longest * ratio / PI, greatest)
}

fn table() -> [Row; 2] {
    let windows = RATIOS.map(window);
    let (widths, growths) = (windows.map(|w| w.0), windows.map(|w| w.1));
    let agree = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-3 * b.max(1.0));
    let first =
        ("V11", "slow and fast spring on a node, w₂/w₁ = 2/4/8/16/32: relative width of the unstable steps below π/w₂");
    let second = ("V11", "same: greatest growth per step");
    [
        Row::new(first, &format!("{} ± .001", series(WIDTHS, 4)), series(widths, 4), agree(&widths, &WIDTHS)),
        Row::new(second, &format!("{} ± .1 %", series(GROWTHS, 4)), series(growths, 4), agree(&growths, &GROWTHS)),
    ]
}

fn refusal() -> Row {
    let runs = RATIOS.map(engine);
    let (steps, energies) = (runs.map(|r| r.0), runs.map(|r| r.1));
    let met = steps.iter().all(|s| *s < 2.0 / PI) && energies.iter().all(|e| *e < 2.0);
    let obtained = format!("{}; ≤ {:.2}", series(steps, 2), energies.iter().copied().fold(0.0, f64::max));
    let name =
        ("V11", "same two springs in the engine at CFL 1: longest step/(π/w₂); greatest energy in 1e5 steps/first");
    Row::new(name, "< 2/π = .64, out of the window; < 2", obtained, met)
}

/// The rows of this part, computed once.
pub fn rows() -> &'static [Row] {
    static ROWS: OnceLock<Vec<Row>> = OnceLock::new();
    ROWS.get_or_init(|| table().into_iter().chain([refusal()]).collect())
}

#[test]
fn the_nodal_rule_steps_below_every_resonance() {
    Row::check(rows());
}
