//! A bar flung at a rigid wall: L = 10, E = 900, ρ = 1, v₀ = 10, gap 5; contact from 0.5 s to 1.1667 s, F = 300, J = 200.

use super::bar::{Bar, Pace, Springs, advance, common_step, fixed_wall};
use super::row::{Row, series};
use ballistic_gel::integrator::Engine;
use std::sync::OnceLock;

/// ½ v⁺·M v⁻ + V, the energy that equal steps keep exactly between impulses; v⁻ = v⁺ − Δt f/m is the velocity before the
/// last kick. (The energy of the ledger has ½(v⁺·M v⁺ + v⁻·M v⁻)/2 instead, which the short waves that contact leaves behind
/// raise by a tenth of the loss that is looked for.)
fn invariant(engine: &Engine<2, Springs>) -> f64 {
    let (state, gel) = (engine.state(), engine.gel());
    let tension = |i: usize| gel.potential.tension(i, &state.position);
    let n = gel.potential.stiffness.len();
    let force = |i: usize| if i < n { tension(i) } else { 0.0 } - if i > 0 { tension(i - 1) } else { 0.0 };
    let step = common_step(engine);
    let kinetic = |i: usize| {
        let v = state.velocity[i][1];
        0.5 * v * (gel.mass[i] * v - step * force(i))
    };
    let stored = |i: usize| 0.5 * tension(i).powi(2) / gel.potential.stiffness[i];
    (0..=n).map(kinetic).sum::<f64>() + (0..n).map(stored).sum::<f64>()
}

/// What a run left: impulse, relative change of energy, first and last impulse.
struct Bounce {
    impulse: f64,
    energy: f64,
    touched: (f64, f64),
    closure: f64,
}

fn bounce(cells: usize, restitution: f64) -> Bounce {
    let bar = Bar { length: 10.0, modulus: 900.0, density: 1.0, cells, held: false };
    let mut engine = bar.engine(Pace { cfl: 0.5, restitution }, &fixed_wall(-5.0), |_| -10.0);
    advance(&mut engine, 0.0);
    let start = invariant(&engine);
    advance(&mut engine, 2.0);
    let (totals, record) = (engine.totals(2.0), engine.state().record.clone());
    Bounce {
        impulse: -record.contacts[0].impulse.z,
        energy: invariant(&engine) / start - 1.0,
        touched: record.contacts[0].touched.expect("the bar reaches the wall"),
        closure: totals.energy_imbalance.1,
    }
}

const CELLS: [usize; 3] = [50, 200, 800];

fn inelastic() -> Vec<Row> {
    let runs = CELLS.map(|n| bounce(n, 0.0));
    let impulse = runs.each_ref().map(|run| 100.0 * (run.impulse / 200.0 - 1.0));
    let met = impulse.iter().zip([1.1, 0.42, 0.17]).all(|(error, limit)| error.abs() <= limit);
    let name = ("V5", "bar on a rigid wall, e = 0, CFL .5, N = 50/200/800: error of the impulse, %");
    let first = Row::new(name, "within −1.1 / −.42 / −.17", series(impulse, 2), met);
    let energy = runs.each_ref().map(|run| run.energy);
    let met = energy.iter().zip(CELLS).all(|(change, n)| (change + 0.5 / n as f64).abs() < 2e-4);
    let name = ("V5", "same: relative change of the energy ½v⁺·Mv⁻ + V");
    let second = Row::new(name, "−1/(2N) ± 2e-4: −.01 / −.0025 / −.00063", series(energy, 5), met);
    let finest = &runs[2];
    let met = (finest.touched.0 - 0.5).abs() < 2e-3 && (finest.touched.1 - 7.0 / 6.0).abs() < 2e-2;
    let name = ("V5", "same, N = 800: first and last impulse, s");
    let third =
        Row::new(name, "0.500 ± .002, 1.167 ± .02", format!("{:.3}, {:.3}", finest.touched.0, finest.touched.1), met);
    assert!(runs.iter().all(|run| run.closure < 1e-10), "the books close");
    vec![first, second, third]
}

fn elastic() -> Row {
    let runs = [200, 800].map(|n| bounce(n, 1.0));
    let energy = runs.each_ref().map(|run| run.energy);
    let met = energy.iter().all(|change| change.abs() < 1e-3);
    assert!(runs.iter().all(|run| run.closure < 1e-10), "the books close");
    let name = ("V5", "same, e = 1, N = 200/800: relative change of the energy ½v⁺·Mv⁻ + V");
    Row::new(name, "|dE| < 1e-3", series(energy, 5), met)
}

/// The rows of this part, computed once.
pub fn rows() -> &'static [Row] {
    static ROWS: OnceLock<Vec<Row>> = OnceLock::new();
    ROWS.get_or_init(|| {
        let mut rows = inelastic();
        rows.push(elastic());
        rows
    })
}

#[test]
fn a_bar_bounces_off_a_wall_with_the_predicted_impulse_and_loss() {
    Row::check(rows());
}
