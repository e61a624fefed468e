//! Energy loss of a wave by a transfer (method 4.5), and the speed of a transfer.

use super::correspondence::MeshCorrespondence;
use super::overlap_candidates::{self, OverlapCandidates};
use super::supermesh::SupermeshIntegrals;
use super::test_bodies::{TestBody, TestRandom, even};
use super::velocity::MomentumProjection;
use super::*;
use crate::math::Vector;

/// Number of wavelengths in the bar.
const WAVES: usize = 12;
/// Number of cells across the bar, in the plane and in space.
const ACROSS: [usize; 2] = [6, 4];

/// Bar of unit cells along x, with `nodes` nodes per wavelength, and a transverse wave in it.
fn bar<const D: usize>(nodes: usize, jitter: f64, random: &mut TestRandom) -> TestBody<D> {
    let planes = planes(nodes * WAVES, 0.0);
    let wave = std::f64::consts::TAU / nodes as f64;
    TestBody::new(&planes, (jitter, random), (symmetry::<D>(), &|xi: &Vector<D>| *xi)).with_velocity(|x| {
        let height = (wave * x[0]).sin() * (wave * x[0] / (2 * WAVES) as f64).sin().powi(2);
        Vector::<D>::from_fn(|axis, _| if axis == 1 { height } else { 0.0 })
    })
}

fn symmetry<const D: usize>() -> BodySymmetry {
    if D == 2 { BodySymmetry::Planar } else { BodySymmetry::Spatial }
}

/// Planes of `n` unit cells along x, the inner ones displaced by a fraction of a cell.
fn planes<const D: usize>(n: usize, offset: f64) -> [Vec<f64>; D] {
    let along = |i: usize| if i == 0 || i == n { i as f64 } else { i as f64 + offset };
    let across = || (0..=ACROSS[D - 2]).map(|j| j as f64).collect();
    std::array::from_fn(|axis| if axis == 0 { (0..=n).map(along).collect() } else { across() })
}

/// Scheme that transfers a body to another mesh.
type TransferScheme<const D: usize> = dyn Fn(&TestBody<D>, &ProposedMesh<D>) -> TransferredFields<D>;

fn transferred<const D: usize>(body: &TestBody<D>, new: &ProposedMesh<D>) -> TransferredFields<D> {
    transfer(&body.moved(), &body.carried(), new)
}

/// Interpolation of the velocities.
fn interpolated<const D: usize>(body: &TestBody<D>, new: &ProposedMesh<D>) -> TransferredFields<D> {
    let pairing = MeshCorrespondence::of(&body.mesh, new);
    assert_eq!(pairing.gone.len(), body.mesh.elements.len(), "every element changes");
    let gone = overlap_candidates::gone(&body.moved(), &pairing);
    let under = OverlapCandidates::new(&body.moved(), new, (&pairing, &gone));
    let traces = rest_positions::RestLocations::of(&body.moved(), new, (&pairing.gone, &under));
    let velocity = traces.values(&body.velocity).into_iter().map(Option::unwrap).collect();
    TransferredFields { velocity, ..transferred(body, new) }
}

/// Four sweeps from zero: the lumped projection and three corrections.
fn lumped<const D: usize>(body: &TestBody<D>, new: &ProposedMesh<D>) -> TransferredFields<D> {
    let after = transferred(body, new);
    let (carried, pairing) = (body.carried(), MeshCorrespondence::of(&body.mesh, new));
    let gone = overlap_candidates::gone(&body.moved(), &pairing);
    let under = OverlapCandidates::new(&body.moved(), new, (&pairing, &gone));
    let parts = SupermeshIntegrals::of((&body.moved(), &carried), (new, &pairing), &under).all;
    assert_eq!(parts.len(), new.elements.len(), "every element changes");
    let mut velocity = vec![Vector::zeros(); new.position.len()];
    let (old, origin) = ((&body.mesh.elements[..], &carried), &new.origin);
    let new = (&new.elements[..], &pairing);
    MomentumProjection { origin, old, new, parts: &parts, mass: &after.mass, held: &after.held }
        .project_momentum(&mut velocity);
    TransferredFields { velocity, ..after }
}

/// Mean relative loss of kinetic energy per transfer to a shifted mesh and back: one way alone, the wave energies on
/// two irregular meshes differ by a similar amount.
fn loss<const D: usize>(way: &TransferScheme<D>, (nodes, jitter): (usize, f64), n_shifts: usize) -> f64 {
    let round_trip = |k: usize| {
        let offset = (k as f64 + 0.5) / n_shifts as f64;
        let seed = (100 * nodes + k) as u64;
        let mut body = bar::<D>(nodes, jitter, &mut TestRandom::new(seed));
        let before = body.books().kinetic;
        for (offset, seed) in [(offset, seed + 50), (0.0, seed)] {
            let (xi, new) = body.other(&planes(nodes * WAVES, offset), (jitter, &mut TestRandom::new(seed)), &|xi| *xi);
            let after = way(&body, &new);
            body = body.after(xi, new, after);
        }
        1.0 - (body.books().kinetic / before).sqrt()
    };
    (0..n_shifts).map(round_trip).sum::<f64>() / n_shifts as f64
}

/// Loss of interpolation in a row of nodes, (1 − cos kh)/3 (method 4.5).
fn interpolation_loss(nodes: usize) -> f64 {
    (1.0 - (std::f64::consts::TAU / nodes as f64).cos()) / 3.0
}

/// Nodes per wavelength, jitter, and the loss as first measured: the mean over shifts of one, three, five and seven
/// eighths of a cell.
const MEASURED: [(usize, f64, f64); 4] =
    [(10, 0.0, 5.495e-4), (10, 1.0, 7.826e-4), (6, 0.0, 5.088e-3), (4, 0.0, 3.616e-2)];

#[test]
fn a_wave_loses_what_was_measured_and_less_than_a_thousandth_with_ten_nodes() {
    for (nodes, jitter, measured) in MEASURED {
        let found = loss::<2>(&transferred, (nodes, jitter), 4);
        assert!((found / measured - 1.0).abs() < 0.01, "{nodes} nodes, jitter {jitter}: {found}");
        assert!(nodes < 10 || found < 1e-3);
    }
}

/// Loss in space with ten nodes and jitter: the mean over shifts of one and three quarters of a cell.
const IN_SPACE: f64 = 7.217e-4;

#[test]
fn a_wave_in_space_loses_what_was_measured_and_less_than_a_thousandth_with_ten_nodes() {
    let found = loss::<3>(&transferred, (10, 1.0), 2);
    assert!((found / IN_SPACE - 1.0).abs() < 0.01 && found < 1e-3, "{found:e}");
}

#[test]
fn a_guess_and_four_sweeps_lose_less_than_four_sweeps_from_nothing_and_those_less_than_interpolation() {
    for jitter in [0.0, 1.0] {
        let [plain, lumped, found] =
            [&interpolated as &TransferScheme<2>, &lumped, &transferred].map(|way| loss(way, (8, jitter), 2));
        assert!(found < 0.7 * lumped && lumped < 0.1 * plain, "{plain} {lumped} {found}");
    }
}

#[test]
#[ignore = "a table to print: V14"]
fn losses_of_waves() {
    for jitter in [0.0, 1.0] {
        println!("plane, {HEAD}, jitter {jitter}");
        print_losses::<2>(&[40, 20, 12, 10, 8, 6, 4], (jitter, 12));
        println!("space, {HEAD}, jitter {jitter}");
        print_losses::<3>(&[20, 12, 10, 8, 6, 4], (jitter, 4));
    }
}

const HEAD: &str = "nodes per wavelength, loss in % of (1 - cos kh)/3, interpolation, lumped + 3, transfer";

fn print_losses<const D: usize>(nodes: &[usize], (jitter, n_shifts): (f64, usize)) {
    for nodes in nodes {
        let [plain, lumped, found] = [&interpolated as &TransferScheme<D>, &lumped, &transferred]
            .map(|way| 100.0 * loss(way, (*nodes, jitter), n_shifts));
        println!("{nodes:4} {:9.4} {plain:9.4} {lumped:9.4} {found:9.4}", 100.0 * interpolation_loss(*nodes));
    }
}

/// Body of `n` cells along each axis in a wavy velocity field.
fn large<const D: usize>(n: usize, random: &mut TestRandom) -> TestBody<D> {
    let planes = std::array::from_fn(|_| even(n));
    TestBody::new(&planes, (1.0, random), (symmetry::<D>(), &|xi: &Vector<D>| *xi)).with_velocity(|x| {
        Vector::<D>::from_fn(|axis, _| if axis == 0 { (9.0 * x[0]).sin() } else { (7.0 * x[1]).cos() })
    })
}

fn time<const D: usize>(name: &str, body: &TestBody<D>, new: &ProposedMesh<D>) {
    let mut pairs = 0;
    let mut once = || {
        let start = std::time::Instant::now();
        let after = transfer(&body.moved(), &body.carried(), new);
        assert_eq!((after.defects.misses, after.defects.stray_mass), (0, 0.0));
        pairs = after.sources.len();
        start.elapsed().as_secs_f64()
    };
    let seconds = (0..5).map(|_| once()).fold(f64::INFINITY, f64::min);
    let n = new.elements.len();
    let per_second = |n: usize| n as f64 / seconds;
    println!(
        "{name}: {n} elements in {seconds:.4} s, {:.0} elements/s, {pairs} overlaps, {:.0} overlaps/s",
        per_second(n),
        per_second(pairs)
    );
}

#[test]
#[ignore = "a speed to print: meant for --release"]
fn speed_of_a_transfer() {
    println!("plane");
    print_speed(224, &[even(223), even(225)]);
    println!("space");
    print_speed(26, &[even(25), even(27), even(26)]);
}

fn print_speed<const D: usize>(n: usize, other: &[Vec<f64>; D]) {
    let mut random = TestRandom::new(1);
    let body = large::<D>(n, &mut random);
    time("all changed", &body, &body.other(other, (1.0, &mut random), &|xi| *xi).1);
    let mut new = body.again();
    let reach = if D == 2 { 0.11 } else { 0.17 };
    for (i, xi) in body.xi.iter().enumerate() {
        if (xi - Vector::<D>::repeat(0.5)).amax() < reach {
            new.origin[i] = NodeOrigin::Inside;
            new.position[i] += Vector::<D>::from_fn(|_, _| random.next() - 0.5) * 1e-3;
        }
    }
    time("one in twenty changed", &body, &new);
    time("nothing changed", &body, &body.again());
}
