//! Contact of the gel with itself: two pieces meet as two bars do, and nothing crosses.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

#[path = "self_contact/pieces.rs"]
mod pieces;

use ballistic_gel::contact::ImpulseExchange;
use ballistic_gel::fem::{Section, Simplices};
use ballistic_gel::integrator::{Engine, SteppingSchedule};
use pieces::{BULK, DENSITY, MOREAU, Piece, Pieces, SHEAR};

/// Length of a strip, m, gap between two, m, and the speed of each, m/s.
const LENGTH: f64 = 0.05;
const GAP: f64 = 0.002;
const SPEED: f64 = 3.0;

/// Two strips that slide along x and meet at x = 0.
fn strips(n: usize) -> Pieces<2> {
    let cell = LENGTH / n as f64;
    let strip = |side: f64| Piece {
        low: [if side < 0.0 { -LENGTH - 0.5 * GAP } else { 0.5 * GAP }, 0.0],
        high: [if side < 0.0 { -0.5 * GAP } else { LENGTH + 0.5 * GAP }, 4.0 * cell],
        cell,
        velocity: [-side * SPEED, 0.0],
    };
    Pieces::new(&[strip(-1.0), strip(1.0)], Section::Planar { thickness: 1.0 }, &[1])
}

fn advance<const D: usize>(engine: &mut Engine<D, Simplices<D>>, t: f64) {
    engine.advance_to(t, &mut [ImpulseExchange::default()]).unwrap();
}

/// A wave runs through each strip and back: they part as fast as they met, less the energy of the layers in contact.
#[test]
fn two_strips_rebound_and_lose_the_energy_of_their_first_layers() {
    let wave = ((BULK + 4.0 / 3.0 * SHEAR) / DENSITY).sqrt();
    let (met, passage) = (0.5 * GAP / SPEED, LENGTH / wave);
    let mut losses = vec![];
    for n in [10, 20, 40] {
        let (gel, end) = (strips(n), met + 4.0 * passage);
        let mut engine = gel.engine(SteppingSchedule::Bins, MOREAU);
        let mut crossing: f64 = 0.0;
        for i in 1..=400 {
            let t = end * f64::from(i) / 400.0;
            advance(&mut engine, t);
            crossing = crossing.max(gel.crossing(&engine, t));
        }
        let totals = engine.totals(end);
        let energy = DENSITY * LENGTH * 4.0 * LENGTH / n as f64 * SPEED * SPEED;
        let loss = -totals.ledger.energy.self_contact / energy;
        let [left, right] = [0, 1].map(|piece| gel.mean_velocity(&engine, piece).x / SPEED);
        println!("{n}: loss {loss:.4} ({:.3} of a layer), crossing {crossing:.2e} h, speeds {left:.4} {right:.4}, books {:e} {:e}", loss * n as f64, totals.energy_imbalance.1, totals.momentum_imbalance.1);
        losses.push(loss);
    }
}
