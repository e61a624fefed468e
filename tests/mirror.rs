//! Gel that meets its own image: at a plane that it is mirrored at it is stopped as by a wall at rest.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use ballistic_gel::algebra::{Vector, Vector3};
use ballistic_gel::avi::{Engine, Gel, Kind, Rules, Surface};
use ballistic_gel::contact::{Body, BodyState, Exchange, Freedom, Law, Motion, Wrench};
use ballistic_gel::element::{Potential, Section, Simplices};
use ballistic_gel::geometry::{Shape, Sphere};
use ballistic_gel::material::NeoHookean;
use ballistic_gel::mesh::{self, Block, Face, Hold, Split};
use nalgebra::UnitQuaternion;

/// Of the strip: μ, K, ρ in SI units, its length, what lies between it and the plane, and how fast it comes.
const SHEAR: f64 = 1.0;
const BULK: f64 = 10.0;
const LENGTH: f64 = 1.0;
const GAP: f64 = 0.02;
const SPEED: f64 = 0.01;

/// A body that is never met: an engine has one.
fn bystander() -> (Body, BodyState) {
    let inertia = nalgebra::Matrix3::identity();
    let body = Body::new(Shape::Sphere(Sphere { radius: 0.3 }), Motion::Free, Freedom::PLANAR, (1.0, inertia));
    let state = BodyState {
        time: 0.0,
        position: Vector3::new(0.0, 0.0, 50.0),
        velocity: Vector3::zeros(),
        orientation: UnitQuaternion::identity(),
        angular_momentum: Vector3::zeros(),
        wrench: Wrench::default(),
        bulge: None,
        active: true,
    };
    (body, state)
}

/// A strip between two walls that lets it slide along x, which comes to the plane x = 0.
fn strip(n: usize, law: Law) -> Engine<2, Simplices<2>> {
    let h = LENGTH / n as f64;
    let along = (0..=n).map(|i| GAP + h * i as f64).collect();
    let across = (0..=4).map(|i| h * f64::from(i)).collect();
    let faces = [false, true].map(|high| Face { axis: 1, high, hold: Hold::Normal }).to_vec();
    let mesh = mesh::block(Block { planes: [along, across], split: Split::Centred, faces });
    let simplices = Simplices::new(&mesh, NeoHookean::new(SHEAR, BULK), Section::Planar { thickness: 1.0 });
    let mass = simplices.lumped_masses(&mesh, 1.0);
    let surface = Surface::new::<2>(mesh.rest.len(), mesh.facets.clone(), |_| (h, h));
    let gel = Gel::new(simplices, mass, &mesh.held, surface).mirrored(&[0]);
    let nodes = gel.potential.rest().iter().map(|x| (*x, Vector::<2>::new(-SPEED, 0.0))).collect();
    let rules = Rules { schedule: Kind::Bins, cfl: 0.8, law, force_window: 1.0, damping: 0.0 };
    Engine::new(gel, vec![bystander()], rules, nodes)
}

const MOREAU: Law = Law::Moreau { restitution: 0.0, bias: 0.1, friction: 0.0 };

/// Its mean velocity along x.
fn mean(engine: &Engine<2, Simplices<2>>) -> f64 {
    let mass = &engine.gel().mass;
    let momentum: f64 = engine.state().velocity.iter().zip(mass).map(|(v, m)| m * v.x).sum();
    momentum / mass.iter().sum::<f64>()
}

/// A wave runs from the plane through the strip and back: it stands still half-way, and leaves as fast as it came.
#[test]
fn a_strip_leaves_its_image_as_a_bar_leaves_a_wall() {
    let wave = (BULK + 4.0 / 3.0 * SHEAR).sqrt();
    let (met, passage) = (GAP / SPEED, LENGTH / wave);
    let mut errors = vec![];
    for n in [20, 40] {
        let mut engine = strip(n, MOREAU);
        let mut beyond: f64 = 0.0;
        let mut speed_at = |t: f64| {
            engine.advance_to(t, &mut [Exchange::default()]).unwrap();
            let least = engine.state().position.iter().map(|x| x.x).fold(f64::INFINITY, f64::min);
            beyond = beyond.min(least);
            mean(&engine)
        };
        for i in 1..=10 {
            speed_at(met + 0.1 * f64::from(i) * passage);
        }
        let halfway = speed_at(met + passage);
        let after = speed_at(met + 4.0 * passage);
        let contact = engine.state().ledger.energy.contact;
        let totals = engine.totals(met + 4.0 * passage);
        let energy = 0.5 * LENGTH * 4.0 * (LENGTH / n as f64) * SPEED * SPEED;
        assert!(halfway.abs() < 0.06 * SPEED, "{n}: {halfway} when the wave has passed");
        assert!(beyond > -1e-15, "{n}: a node is {beyond:e} m beyond its image");
        assert!(
            contact < 0.0 && contact > -1.1 * energy / n as f64,
            "{n}: the contact takes {contact:e} of {energy:e} J"
        );
        assert!(totals.energy_closure.1 < 1e-13, "{n}: energy {:e}", totals.energy_closure.1);
        assert!(totals.momentum_closure.1 < 1e-13, "{n}: momentum {:e}", totals.momentum_closure.1);
        errors.push((after / SPEED - 1.0).abs());
    }
    // What is lost is the energy of the first layer, and what rings behind the front.
    assert!(errors[0] < 0.05 && errors[1] < 0.7 * errors[0], "{errors:?}");
}

/// The reference form and the paper's law do the same to it.
#[test]
fn the_image_is_met_in_either_form_and_by_either_law() {
    let end = GAP / SPEED + 0.7;
    let run = |mut engine: Engine<2, Simplices<2>>| {
        engine.advance_to(end, &mut [Exchange::default()]).unwrap();
        (engine.state().ledger.energy.contact, engine.state().position.clone())
    };
    let fast = run(strip(20, MOREAU));
    assert!(fast.0 < 0.0, "the strip has met its image");
    for other in [run(strip(20, MOREAU).by_reference()), run(strip(20, Law::Reversal))] {
        let off = fast.1.iter().zip(&other.1).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(off < 1e-12, "{off:e} m apart");
        assert!((fast.0 - other.0).abs() < 1e-9 * fast.0.abs(), "{} and {} J", fast.0, other.0);
    }
}
