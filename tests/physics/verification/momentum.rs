//! Momentum and angular momentum of a free block, over many asynchronous steps, and its bits over threads and time slices.

use super::noise::Noise;
use super::patch::{no_surface, nowhere, rules};
use super::row::{Row, below};
use ballistic_gel::constitutive::NeoHookean;
use ballistic_gel::contact::{FreeDirections, ImpulseExchange};
use ballistic_gel::fem::{Potential, Section, Simplices};
use ballistic_gel::integrator::{DiscreteGel, Engine, WorkerPool};
use ballistic_gel::math::{Vector, Vector3, embed};
use ballistic_gel::mesh::{self, BlockSpec, CellSplit};
use std::sync::OnceLock;

/// Speed of the nodes at the start; the shear wave has 1, the pressure wave 3.3.
const SPEED: f64 = 0.05;

/// A free block with random velocities, and the threads it may use.
fn block(planes: [Vec<f64>; 3], threads: usize) -> Engine<3, Simplices<3>> {
    let mut noise = Noise::new(2);
    moving(planes, threads, |_| Vector::<3>::from_fn(|_, _| SPEED * noise.next()))
}

/// The same with these velocities.
fn moving(
    planes: [Vec<f64>; 3],
    threads: usize,
    mut velocity: impl FnMut(&Vector<3>) -> Vector<3>,
) -> Engine<3, Simplices<3>> {
    let mesh = mesh::block(BlockSpec { planes, split: CellSplit::Centred, faces: vec![] });
    let simplices = Simplices::new(&mesh, NeoHookean::new(1.0, 29.0 / 3.0), Section::Spatial);
    let mass = simplices.lumped_masses(&mesh, 1.0);
    let gel = DiscreteGel::new(simplices, mass, &mesh.held, no_surface(mesh.rest.len()));
    let nodes = mesh.rest.iter().map(|x| (*x, velocity(x))).collect();
    Engine::new(gel, vec![nowhere(FreeDirections::SPATIAL)], rules(), nodes).with_pool(WorkerPool::new(threads))
}

fn advance(engine: &mut Engine<3, Simplices<3>>, t: f64) {
    engine.advance_to(t, &mut [ImpulseExchange::default()]).expect("small strains do not fail");
}

/// P, L, Σ m|v| and Σ m|x × v|.
fn momenta(engine: &Engine<3, Simplices<3>>) -> (Vector3, Vector3, f64, f64) {
    let (state, mass) = (engine.state(), &engine.gel().mass);
    let mut sums = (Vector3::zeros(), Vector3::zeros(), 0.0, 0.0);
    for (i, m) in mass.iter().enumerate() {
        let (p, x) = (embed(&state.velocity[i]) * *m, embed(&state.position[i]));
        sums.0 += p;
        sums.1 += x.cross(&p);
        sums.2 += p.norm();
        sums.3 += x.cross(&p).norm();
    }
    sums
}

/// A small graded block over a million ticks at which elements fire.
fn conservation() -> [Row; 2] {
    const TICKS: u32 = 1_000_000;
    let axis = || vec![0.0, 0.2, 1.0];
    let mut engine = block([axis(), axis(), axis()], 1);
    let start = momenta(&engine);
    let least = engine.steps().iter().copied().fold(f64::INFINITY, f64::min);
    advance(&mut engine, f64::from(TICKS) * least);
    let end = momenta(&engine);
    let (linear, turning) = ((end.0 - start.0).norm() / start.2, (end.1 - start.1).norm() / start.3);
    let updates = engine.state().record.updates;
    let what = format!(
        "free graded block, random velocities, 1e6 smallest steps, {:.0} million kicks: |ΔP|/Σ m|v|",
        updates as f64 / 1e6
    );
    [
        Row::new(("V2", &what), "0 within 1e-13", below(linear), linear < 1e-13),
        Row::new(("V2", "same: |ΔL|/Σ m|x × v|"), "0 within 1e-12", below(turning), turning < 1e-12),
    ]
}

/// A graded cube that spins and is stretched, over a million of its longest steps: how its energy goes.
fn drift() -> [Row; 2] {
    const STEPS: u32 = 1_000_000;
    const LOOKS: u32 = 1000;
    let axis = || vec![0.0, 0.4, 1.0];
    let middle = Vector::<3>::from([0.5; 3]);
    let spin = Vector::<3>::from([0.1, 0.2, 0.3]);
    let mut engine = moving([axis(), axis(), axis()], 1, |x| {
        let r = x - middle;
        spin.cross(&r) + Vector::<3>::from([0.1 * r.x, -0.05 * r.y, 0.0])
    });
    let longest = engine.steps().iter().copied().fold(0.0, f64::max);
    let look = |i: u32| f64::from(STEPS / LOOKS * i);
    let energy = |i: u32| {
        let t = look(i) * longest;
        advance(&mut engine, t);
        engine.totals(t).energies.discrete()
    };
    let energies: Vec<f64> = (1..=LOOKS).map(energy).collect();
    let mean = energies.iter().sum::<f64>() / f64::from(LOOKS);
    let from_middle = |i: usize| look(i as u32 + 1) - 0.5 * f64::from(STEPS);
    let rise: f64 = energies.iter().enumerate().map(|(i, e)| from_middle(i) * (e - mean)).sum();
    let slope = rise / (0..energies.len()).map(|i| from_middle(i).powi(2)).sum::<f64>() / mean;
    let (low, high) = energies.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), e| (low.min(*e), high.max(*e)));
    let band = (high - low) / mean;
    let what = "graded cube that spins and is stretched, 1e6 longest steps: slope of E* per step/E*";
    [
        Row::new(("V15", what), "0 within 1e-8", format!("{slope:.0e}"), slope.abs() < 1e-8),
        Row::new(("V15", "same: band of E*/E*"), "< 1e-3", format!("{band:.1e}"), band < 1e-3),
    ]
}

/// A block of several thousand elements, so that the threads really share the work.
fn bits() -> Row {
    let run = |threads: usize, slices: u32| {
        let axis = || mesh::graded(1.0, 0.08, (0.2, 1.2, 0.2));
        let mut engine = block([axis(), axis(), axis()], threads);
        for i in 1..=slices {
            advance(&mut engine, 0.5 * f64::from(i) / f64::from(slices));
        }
        (engine.state().digest(), engine.gel().potential.len())
    };
    let (reference, n) = run(1, 1);
    let same = [(1, 7), (1, 333), (2, 1), (2, 100), (16, 1)]
        .into_iter()
        .all(|(threads, slices)| run(threads, slices).0 == reference);
    assert!(n > 4096, "{n} elements are too few to be shared by threads");
    let obtained = if same { "equal" } else { "different" };
    let what = format!("{n} elements, 1, 2 and 16 threads, 1, 7, 100 and 333 communication steps: bits of the state");
    Row::new(("V2", &what), "equal", obtained.into(), same)
}

/// The rows of this part, computed once.
pub fn rows() -> &'static [Row] {
    static ROWS: OnceLock<Vec<Row>> = OnceLock::new();
    ROWS.get_or_init(|| conservation().into_iter().chain([bits()]).chain(drift()).collect())
}

#[test]
fn a_free_block_keeps_its_momenta_and_its_bits() {
    Row::check(rows());
}
