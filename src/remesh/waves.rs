//! What a transfer takes from a wave (numerics V14), and how fast it is.

use super::pairing::Pairing;
use super::parts::{Parts, triangles};
use super::tests::{Body, Random};
use super::velocity::Balance;
use super::*;
use crate::mesh::ElementId;

/// Wavelengths in the bar.
const WAVES: usize = 8;
/// Cells across the bar.
const ACROSS: usize = 3;

/// A bar of unit cells along x, with so many nodes per wavelength, and a transverse wave in it.
fn bar(nodes: usize, jitter: f64, random: &mut Random) -> Body {
    let planes = planes(nodes * WAVES, 0.0);
    let wave = std::f64::consts::TAU / nodes as f64;
    Body::new(&planes, (jitter, random), (Symmetry::Planar, &|xi: &Vector<2>| *xi))
        .with_velocity(|x| Vector::<2>::new(0.0, (wave * x[0]).sin()))
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
    let loss = |velocity| {
        let kinetic = Books::of(&body.position[..1], &after.mass[..1], velocity).kinetic;
        kinetic
    };
    let _ = loss;
    let kinetic = |v: &[Vector<2>]| v.iter().zip(&after.mass).map(|(v, m)| 0.5 * m * v.norm_squared()).sum::<f64>();
    [kinetic(&guess), kinetic(&swept), after.defects.after.kinetic].map(|t| 1.0 - t / after.defects.before.kinetic)
}

/// Nodes per wavelength and the losses of interpolation and of `lumped + 3` there, of a periodic row of nodes
/// (numerics 4.5).
const TABLE: [(usize, f64, f64); 7] = [
    (40, 0.41e-2, 0.000e-2),
    (20, 1.63e-2, 0.003e-2),
    (12, 4.47e-2, 0.023e-2),
    (10, 6.37e-2, 0.051e-2),
    (8, 9.78e-2, 0.14e-2),
    (6, 16.7e-2, 0.58e-2),
    (4, 33.4e-2, 5.2e-2),
];

/// Mean losses over shifts of the mesh.
fn shifted(nodes: usize, jitter: f64) -> [f64; 3] {
    const OFFSETS: usize = 6;
    let mut random = Random::new(nodes as u64);
    let mut sum = [0.0; 3];
    for k in 0..OFFSETS {
        let body = bar(nodes, jitter, &mut random);
        let offset = (k as f64 + 0.5) / OFFSETS as f64;
        let (_, new) = body.other(&planes(nodes * WAVES, offset), (jitter, &mut random), &|xi| *xi);
        let found = losses(&body, &new);
        sum = std::array::from_fn(|i| sum[i] + found[i] / OFFSETS as f64);
    }
    sum
}

#[test]
fn a_wave_loses_no_more_than_the_table_says() {
    for jitter in [0.0, 1.0] {
        println!("jitter {jitter}: nodes per wavelength, loss in % by interpolation, lumped + 3, transfer");
        for (nodes, interpolation, lumped) in TABLE {
            let [plain, swept, transferred] = shifted(nodes, jitter);
            println!("{nodes:4} {:9.4} {:9.4} {:9.4}", 100.0 * plain, 100.0 * swept, 100.0 * transferred);
        }
    }
}
