//! What a transfer takes from a wave (numerics V14), and how fast it is.

use super::bodies::{Body, Random};
use super::pairing::Pairing;
use super::pieces::{Parts, triangles};
use super::velocity::Balance;
use super::*;
use crate::mesh::ElementId;

/// Wavelengths in the bar.
const WAVES: usize = 12;
/// Cells across the bar.
const ACROSS: usize = 6;

/// A bar of unit cells along x, with so many nodes per wavelength, and a transverse wave in it.
fn bar(nodes: usize, jitter: f64, random: &mut Random) -> Body {
    let planes = planes(nodes * WAVES, 0.0);
    let wave = std::f64::consts::TAU / nodes as f64;
    Body::new(&planes, (jitter, random), (Symmetry::Planar, &|xi: &Vector<2>| *xi)).with_velocity(|x| {
        Vector::<2>::new(0.0, (wave * x[0]).sin() * (wave * x[0] / (2 * WAVES) as f64).sin().powi(2))
    })
}

/// Planes of `n` unit cells along x, those inside moved by a part of a cell.
fn planes(n: usize, offset: f64) -> [Vec<f64>; 2] {
    let along = |i: usize| if i == 0 || i == n { i as f64 } else { i as f64 + offset };
    [(0..=n).map(along).collect(), (0..=ACROSS).map(|j| j as f64).collect()]
}

/// Part of the kinetic energy that is lost without sweeps, with four from nothing (lumped + 3), and in the transfer.
fn losses(body: &Body, new: &Proposal<2>) -> [f64; 3] {
    let after = transfer(&body.moved(), &body.carried(), new);
    let carried = body.carried();
    let pairing = Pairing::of(&body.mesh, new);
    let gone = triangles(&body.position, body.mesh.elements.iter());
    let all: Vec<ElementId> = (0..gone.len() as u32).map(ElementId).collect();
    assert_eq!(pairing.gone, all, "every element changes");
    let locator = locate::Locator::new(&gone);
    let parts = Parts::of((&body.moved(), &carried), (new, &pairing), &locator).parts;
    let guess = trace::Traces::of(&body.moved(), new, (&all, &locator)).values(&body.velocity);
    let guess: Vec<Vector<2>> = guess.into_iter().map(Option::unwrap).collect();
    let mut swept = vec![Vector::zeros(); guess.len()];
    let (old, new) = ((&body.mesh.elements[..], &carried), (&new.elements[..], &pairing));
    Balance { old, new, parts: &parts, mass: &after.mass, held: &after.held }.sweep(&mut swept);
    let kinetic = |v: &[Vector<2>]| v.iter().zip(&after.mass).map(|(v, m)| 0.5 * m * v.norm_squared()).sum::<f64>();
    [kinetic(&guess), kinetic(&swept), after.defects.after.kinetic].map(|t| 1.0 - t / after.defects.before.kinetic)
}

/// Mean losses over shifts of the mesh along the bar by a part of a cell.
fn shifted(nodes: usize, jitter: f64, offsets: usize) -> [f64; 3] {
    let mut random = Random::new(nodes as u64);
    let mut sum = [0.0; 3];
    for k in 0..offsets {
        let body = bar(nodes, jitter, &mut random);
        let offset = (k as f64 + 0.5) / offsets as f64;
        let (_, new) = body.other(&planes(nodes * WAVES, offset), (jitter, &mut random), &|xi| *xi);
        let found = losses(&body, &new);
        sum = std::array::from_fn(|i| sum[i] + found[i] / offsets as f64);
    }
    sum
}

/// (1 − cos kh)/3, the loss of interpolation (numerics 4.5).
fn interpolated(nodes: usize) -> f64 {
    (1.0 - (std::f64::consts::TAU / nodes as f64).cos()) / 3.0
}

#[test]
fn a_wave_of_ten_nodes_loses_less_than_a_thousandth() {
    for (jitter, measured) in [(0.0, 0.0), (1.0, 0.0)] {
        let [plain, lumped, transferred] = shifted(10, jitter, 4);
        println!("{jitter} {plain} {lumped} {transferred} {} {measured}", interpolated(10));
    }
}

#[test]
#[ignore = "a table to print: V14"]
fn losses_of_waves() {
    for jitter in [0.0, 1.0] {
        println!(
            "jitter {jitter}: nodes per wavelength, loss in % of (1 - cos kh)/3, interpolation, lumped + 3, transfer"
        );
        for nodes in [40, 20, 12, 10, 8, 6, 4] {
            let [plain, lumped, transferred] = shifted(nodes, jitter, 8).map(|loss| 100.0 * loss);
            println!("{nodes:4} {:9.4} {plain:9.4} {lumped:9.4} {transferred:9.4}", 100.0 * interpolated(nodes));
        }
    }
}

/// A body of 100 352 triangles in a wavy velocity.
fn large(random: &mut Random) -> Body {
    let planes = [super::bodies::even(224), super::bodies::even(224)];
    Body::new(&planes, (1.0, random), (Symmetry::Planar, &|xi: &Vector<2>| *xi))
        .with_velocity(|x| Vector::<2>::new((9.0 * x[0]).sin(), (7.0 * x[1]).cos()))
}

fn time(name: &str, body: &Body, new: &Proposal<2>) {
    let seconds = (0..7)
        .map(|_| {
            let start = std::time::Instant::now();
            let after = transfer(&body.moved(), &body.carried(), new);
            assert_eq!((after.defects.misses, after.defects.stray_mass), (0, 0.0));
            start.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min);
    let n = new.elements.len();
    println!("{name}: {n} triangles in {seconds:.4} s, {:.0} triangles/s", n as f64 / seconds);
}

#[test]
#[ignore = "a speed to print: meant for --release"]
fn speed_of_a_transfer() {
    let mut random = Random::new(1);
    let body = large(&mut random);
    let planes = [super::bodies::even(223), super::bodies::even(225)];
    time("all changed", &body, &body.other(&planes, (1.0, &mut random), &|xi| *xi).1);
    let mut new = body.again();
    for (i, xi) in body.xi.iter().enumerate() {
        if (xi - Vector::<2>::new(0.5, 0.5)).amax() < 0.11 {
            new.origin[i] = Origin::Inside;
            new.position[i] += Vector::<2>::new(random.next() - 0.5, random.next() - 0.5) * 1e-3;
        }
    }
    time("one in twenty changed", &body, &new);
    time("nothing changed", &body, &body.again());
}
