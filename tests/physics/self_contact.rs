//! Contact of the gel with itself: two pieces meet as two bars do, and nothing crosses.

#[path = "../self_contact/pieces.rs"]
mod pieces;

use ballistic_gel::contact::{ImpulseExchange, ImpulseLaw};
use ballistic_gel::fem::{Potential, Section, Simplices};
use ballistic_gel::integrator::{Engine, SteppingSchedule, WorkerPool};
use ballistic_gel::math::Vector;
use ballistic_gel::mesh::NodeId;
use pieces::{BULK, DENSITY, MOREAU, Piece, Pieces, SHEAR};

/// Length of a strip, m, gap between two, m, and the speed of each, m/s.
const LENGTH: f64 = 0.05;
const GAP: f64 = 0.002;
const SPEED: f64 = 3.0;

/// Two strips that slide along x and meet at x = 0; the cells of the second are a little smaller.
fn strips(n: usize) -> Pieces<2> {
    let cell = LENGTH / n as f64;
    let strip = |side: f64, cell: f64| Piece {
        low: [if side < 0.0 { -LENGTH - 0.5 * GAP } else { 0.5 * GAP }, 0.0],
        high: [if side < 0.0 { -0.5 * GAP } else { LENGTH + 0.5 * GAP }, 0.02],
        cell,
        velocity: [-side * SPEED, 0.0],
    };
    Pieces::new(&[strip(-1.0, cell), strip(1.0, cell / 1.3)], Section::Planar { thickness: 1.0 }, &[1])
}

/// Two blocks in space that meet face to face, or askew.
fn blocks(cell: f64, is_askew: bool) -> Pieces<3> {
    let lower = Piece { low: [-0.02, -0.02, -0.04], high: [0.02, 0.02, -0.001], cell, velocity: [0.0, 0.0, SPEED] };
    let (shift, aside) = if is_askew { ([0.009, 0.007], [0.5, -0.3]) } else { ([0.0; 2], [0.0; 2]) };
    let upper = Piece {
        low: [shift[0] - 0.02, shift[1] - 0.02, 0.001],
        high: [shift[0] + 0.02, shift[1] + 0.02, 0.04],
        cell: 0.83 * cell,
        velocity: [aside[0], aside[1], -SPEED],
    };
    Pieces::new(&[lower, upper], Section::Spatial, &[])
}

/// A plane block with a slot from its top face, whose walls move towards each other.
fn slotted(cell: f64, section: Section, at: f64) -> Pieces<2> {
    let block = Piece { low: [at - 0.03, -0.04], high: [at + 0.03, 0.0], cell, velocity: [0.0, 0.0] };
    let whole = Pieces::new(&[block], section, &[]);
    let closing = move |x: &Vector<2>| Vector::<2>::new(-200.0 * (x[0] - at) * (1.0 + x[1] / 0.04), 0.0);
    whole.cut(|x| (x[0] - at).abs() < 0.0025 && x[1] > -0.025, closing)
}

fn advance<const D: usize>(engine: &mut Engine<D, Simplices<D>>, t: f64) {
    engine.advance_to(t, &mut [ImpulseExchange::default()]).unwrap();
}

/// Checks that energy, momentum and angular momentum are in the books.
fn check_books<const D: usize>(engine: &Engine<D, Simplices<D>>, t: f64, what: &str) {
    let totals = engine.totals(t);
    assert!(totals.energy_imbalance.1 < 1e-12, "{what}: energy {:e}", totals.energy_imbalance.1);
    assert!(totals.momentum_imbalance.1 < 1e-12, "{what}: momentum {:e}", totals.momentum_imbalance.1);
    let angular = totals.angular_momentum_imbalance.1;
    assert!(angular < 1e-11, "{what}: angular momentum {angular:e}");
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
            crossing = crossing.max(gel.crossing(&engine, t, 0));
        }
        let energy = 0.5 * DENSITY * 2.0 * LENGTH * 0.02 * SPEED * SPEED;
        let loss = -engine.state().ledger.energy.self_contact / energy;
        let [left, right] = [0, 1].map(|piece| gel.mean_velocity(&engine, piece)[0] / SPEED);
        check_books(&engine, end, "strips");
        assert!(crossing < 0.01, "{n}: {crossing} cells");
        assert!(left < -0.9 && right > 0.9, "{n}: {left}, {right}");
        // Half a cell of each strip is lumped at its face.
        assert!(loss > 0.0 && loss < 1.0 / n as f64, "{n}: {loss}");
        losses.push(loss);
    }
    let halved = |a: f64, b: f64| (0.4..0.6).contains(&(b / a));
    assert!(halved(losses[0], losses[1]) && halved(losses[1], losses[2]), "{losses:?}");
}

#[test]
fn two_blocks_in_space_do_not_cross_and_keep_their_momentum() {
    // Askew, gel that has come up beside the rim of the other block slides under it.
    for (cell, is_askew, most) in [(0.01, false, 0.01), (0.005, false, 0.01), (0.01, true, 0.03), (0.005, true, 0.03)] {
        let gel = blocks(cell, is_askew);
        let (mut engine, end) = (gel.engine(SteppingSchedule::Bins, MOREAU), 6e-3);
        let mut crossing: f64 = 0.0;
        for i in 1..=60 {
            let t = end * f64::from(i) / 60.0;
            advance(&mut engine, t);
            crossing = crossing.max(gel.crossing(&engine, t, 2));
        }
        let [lower, upper] = [0, 1].map(|piece| gel.mean_velocity(&engine, piece)[2]);
        check_books(&engine, end, "blocks");
        assert!(engine.state().ledger.energy.self_contact < 0.0 && lower < -1.0 && upper > 1.0, "{lower}, {upper}");
        assert!(crossing < most, "{cell}, {is_askew}: {crossing} cells");
    }
}

/// Least distance of two nodes of the walls of a slot about x = `at` that are opposite each other at rest, m; negative
/// where they have crossed.
fn opening(engine: &Engine<2, Simplices<2>>, at: f64, t: f64) -> f64 {
    let rest = engine.gel().potential.rest();
    let wall = |side: f64| {
        let is_wall = |node: &NodeId| {
            let x = rest[node.index()];
            (side * (x[0] - at) - 0.0025).abs() < 1e-6 && x[1] > -0.02
        };
        let mut nodes: Vec<NodeId> = engine.gel().surface.nodes.iter().map(|at| at.node).filter(is_wall).collect();
        nodes.sort_by(|a, b| rest[a.index()][1].total_cmp(&rest[b.index()][1]));
        nodes
    };
    let place = |node: &NodeId| engine.position_at(*node, t)[0];
    wall(-1.0).iter().zip(&wall(1.0)).map(|(left, right)| place(right) - place(left)).fold(f64::INFINITY, f64::min)
}

#[test]
fn a_slot_closes_on_itself_and_opens_again() {
    for (section, at) in [(Section::Planar { thickness: 1.0 }, 0.0), (Section::Axisymmetric, 0.1)] {
        let gel = slotted(1.25e-3, section, at);
        let mut engine = gel.engine(SteppingSchedule::Bins, MOREAU);
        let (mut least, mut last) = (f64::INFINITY, 0.0);
        for i in 1..=200 {
            let t = 5e-5 * f64::from(i);
            advance(&mut engine, t);
            last = opening(&engine, at, t);
            least = least.min(last);
        }
        let work = engine.state().ledger.energy.self_contact;
        check_books(&engine, 0.01, "slot");
        assert!(work < 0.0, "{section:?}: the walls have met");
        assert!(least > -0.02 * 1.25e-3, "{section:?}: the walls cross by {least:e} m");
        assert!(last > 1e-3, "{section:?}: the slot is open again by {last:e} m");
    }
}

fn bits(engine: &Engine<3, Simplices<3>>) -> Vec<u64> {
    let numbers = engine.state().position.iter().chain(&engine.state().velocity).flat_map(|x| [x[0], x[1], x[2]]);
    numbers.map(f64::to_bits).collect()
}

#[test]
fn threads_meet_alike() {
    let (gel, end) = (blocks(0.0025, true), 1.2e-3);
    let after = |threads: usize| {
        let mut engine = gel.engine(SteppingSchedule::Bins, MOREAU).with_pool(WorkerPool::new(threads));
        advance(&mut engine, end);
        assert!(engine.state().ledger.energy.self_contact < 0.0, "the blocks have met");
        bits(&engine)
    };
    assert!(after(1) == after(3));
}

#[test]
fn schedules_forms_slices_and_restarts_meet_alike() {
    let end = 6e-3;
    let gel = blocks(0.01, true);
    let mut whole = gel.engine(SteppingSchedule::Bins, MOREAU);
    advance(&mut whole, end);
    let expected = bits(&whole);
    for slices in [7, 100] {
        let mut engine = gel.engine(SteppingSchedule::Bins, MOREAU);
        (1..=slices).for_each(|i| advance(&mut engine, end * f64::from(i) / f64::from(slices)));
        assert!(bits(&engine) == expected, "{slices} slices");
    }
    for part in [0.1, 0.31, 0.5, 0.77] {
        let mut engine = gel.engine(SteppingSchedule::Bins, MOREAU);
        advance(&mut engine, part * end);
        let mut other = gel.engine(SteppingSchedule::Bins, MOREAU);
        other.restore(engine.state()).unwrap();
        advance(&mut other, end);
        assert!(bits(&other) == expected, "a restart at {part} of the time");
    }
    let mut swept = gel.engine(SteppingSchedule::Bins, MOREAU).with_sweeps_at_rest();
    advance(&mut swept, end);
    assert!(bits(&swept) == expected, "nothing at rest");
    let work = whole.state().ledger.energy.self_contact;
    let others: Vec<Engine<3, Simplices<3>>> = vec![
        gel.engine(SteppingSchedule::Bins, MOREAU).with_reference_form(),
        gel.engine(SteppingSchedule::Queue, MOREAU),
        gel.engine(SteppingSchedule::Global, MOREAU),
        gel.engine(SteppingSchedule::Queue, ImpulseLaw::Reversal),
    ];
    for (i, mut other) in others.into_iter().enumerate() {
        advance(&mut other, end);
        check_books(&other, end, "other forms");
        let theirs = other.state().ledger.energy.self_contact;
        // Where the two sides have ticks of their own, they part and meet again between them.
        let most = if i == 0 { 1.0 + 1e-6 } else { 4.0 };
        assert!(theirs / work > 0.5 && theirs / work < most, "{i}: {theirs} and {work} J");
        let crossing = gel.crossing(&other, end, 2);
        assert!(crossing < 0.01, "{i}: {crossing} cells");
    }
}

/// Two bars that lie across each other and meet with their ridges, edge against edge.
fn crossed_bars(cell: f64, speed: f64) -> Pieces<3> {
    let (half, root) = (0.01, std::f64::consts::FRAC_1_SQRT_2);
    let lower = Piece { low: [-0.03, -half, -half], high: [0.03, half, half], cell, velocity: [0.0, 0.0, speed] };
    let upper = Piece { low: [-half, -0.03, -half], high: [half, 0.03, half], cell, velocity: [0.0, 0.0, -speed] };
    // Ridges at z = ∓1 mm, shifted so that they cross between nodes.
    let map = move |piece: usize, x: &Vector<3>| {
        let across = piece;
        let (a, z) = (x[1 - across], x[2]);
        let turned = [root * (a - z), root * (a + z)];
        let mut y = *x;
        y[1 - across] = turned[0];
        y[2] = turned[1] + if piece == 0 { -1.0 } else { 1.0 } * (half / root + 0.001);
        y[across] += 0.5 * cell;
        y
    };
    Pieces::new(&[lower, upper], Section::Spatial, &[]).mapped(map)
}

/// Height of a ridge over the place where the ridges cross at rest, m.
fn ridge(gel: &Pieces<3>, engine: &Engine<3, Simplices<3>>, piece: usize, t: f64) -> f64 {
    let rest = engine.gel().potential.rest();
    let extreme = if piece == 0 { -0.001 } else { 0.001 };
    let on_ridge = (0..rest.len()).filter(|i| gel.piece[*i] == piece && (rest[*i][2] - extreme).abs() < 1e-9);
    let mut nodes: Vec<[f64; 2]> = on_ridge
        .map(|i| {
            let x = engine.position_at(NodeId(i as u32), t);
            [x[piece], x[2]]
        })
        .collect();
    nodes.sort_by(|a, b| a[0].abs().total_cmp(&b[0].abs()));
    let [a, b] = [nodes[0], nodes[1]];
    (a[1] * b[0] - b[1] * a[0]) / (b[0] - a[0])
}

/// Edges across each other are stopped only once a node is behind a facet.
#[test]
fn edges_across_each_other_cross_by_less_than_a_cell() {
    for speed in [1.0, 3.0] {
        let cell = 0.0025;
        let (gel, end) = (crossed_bars(cell, speed), 0.02 / speed);
        let mut engine = gel.engine(SteppingSchedule::Bins, MOREAU);
        let mut crossing = f64::NEG_INFINITY;
        for i in 1..=100 {
            let t = end * f64::from(i) / 100.0;
            advance(&mut engine, t);
            crossing = crossing.max(ridge(&gel, &engine, 0, t) - ridge(&gel, &engine, 1, t));
        }
        let work = engine.state().ledger.energy.self_contact;
        check_books(&engine, end, "bars");
        assert!(work < 0.0 && crossing < 0.5 * cell, "{speed} m/s: edges cross by {} cells", crossing / cell);
    }
}
