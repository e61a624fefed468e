//! Gel that meets its own image: at a plane that it is mirrored at it is stopped as by a wall at rest.

use ballistic_gel::constitutive::NeoHookean;
use ballistic_gel::contact::{
    BodyMotion, BodyState, ContactSurface, FreeDirections, ImpulseExchange, ImpulseLaw, RigidBody,
};
use ballistic_gel::fem::{Potential, Section, Simplices};
use ballistic_gel::geometry::{ShapeGeometry, Sphere};
use ballistic_gel::integrator::{DiscreteGel, Engine, IntegratorSettings, SteppingSchedule};
use ballistic_gel::math::{Vector, Vector3};
use ballistic_gel::mesh::{self, BlockSpec, CellSplit, FaceConstraint, HeldFace};

/// Of the strip: μ, K, ρ in SI units, its length, what lies between it and the plane, and how fast it comes.
const SHEAR: f64 = 1.0;
const BULK: f64 = 10.0;
const LENGTH: f64 = 1.0;
const GAP: f64 = 0.02;
const SPEED: f64 = 0.01;

/// A body that is never met: an engine has one.
fn bystander() -> (RigidBody, BodyState) {
    let inertia = nalgebra::Matrix3::identity();
    let body = RigidBody::new(
        ShapeGeometry::Sphere(Sphere { radius: 0.3 }),
        BodyMotion::Free,
        FreeDirections::PLANAR,
        1.0,
        inertia,
    );
    (body, BodyState::at_start(Vector3::new(0.0, 0.0, 50.0), Vector3::zeros()))
}

/// A strip between two walls that lets it slide along x, which comes to the plane x = 0.
fn strip(n: usize, rules: (SteppingSchedule, ImpulseLaw)) -> Engine<2, Simplices<2>> {
    thrown(n, (GAP, SPEED), rules)
}

/// The same from so far and so fast.
fn thrown(
    n: usize,
    (gap, speed): (f64, f64),
    (schedule, law): (SteppingSchedule, ImpulseLaw),
) -> Engine<2, Simplices<2>> {
    let h = LENGTH / n as f64;
    let along = (0..=n).map(|i| gap + h * i as f64).collect();
    let across = (0..=4).map(|i| h * f64::from(i)).collect();
    let faces = [false, true].map(|high| HeldFace { axis: 1, high, hold: FaceConstraint::Normal }).to_vec();
    let mesh = mesh::block(BlockSpec { planes: [along, across], split: CellSplit::Centred, faces });
    let simplices = Simplices::new(&mesh, NeoHookean::new(SHEAR, BULK), Section::Planar { thickness: 1.0 });
    let mass = simplices.lumped_masses(&mesh, 1.0);
    let surface = ContactSurface::new::<2>(mesh.rest.len(), mesh.facets.clone(), |_| (h, h));
    let gel = DiscreteGel::new(simplices, mass, &mesh.held, surface).mirrored(&[0]);
    let nodes = gel.potential.rest().iter().map(|x| (*x, Vector::<2>::new(-speed, 0.0))).collect();
    let rules = IntegratorSettings { schedule, cfl: 0.8, law, force_window: 1.0, damping: 0.0 };
    Engine::new(gel, vec![bystander()], rules, nodes)
}

const MOREAU: ImpulseLaw = ImpulseLaw::Moreau { restitution: 0.0, bias: 0.1, friction: 0.0 };

/// Where the node of the surface is that has come the farthest, m.
fn least(engine: &Engine<2, Simplices<2>>) -> f64 {
    let nodes = engine.gel().surface.nodes.iter();
    nodes.map(|at| engine.state().position[at.node.index()].x).fold(f64::INFINITY, f64::min)
}

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
        let mut engine = strip(n, (SteppingSchedule::Bins, MOREAU));
        let mut beyond: f64 = 0.0;
        let mut speed_at = |t: f64| {
            engine.advance_to(t, &mut [ImpulseExchange::default()]).unwrap();
            beyond = beyond.min(least(&engine));
            mean(&engine)
        };
        for i in 1..=200 {
            speed_at(met + 0.005 * f64::from(i) * passage);
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
        assert!(totals.energy_imbalance.1 < 1e-13, "{n}: energy {:e}", totals.energy_imbalance.1);
        assert!(totals.momentum_imbalance.1 < 1e-13, "{n}: momentum {:e}", totals.momentum_imbalance.1);
        errors.push((after / SPEED - 1.0).abs());
    }
    // What is lost is the energy of the first layer, and what rings behind the front.
    assert!(errors[0] < 0.05 && errors[1] < 0.7 * errors[0], "{errors:?}");
}

/// The reference form, the other schedules and the paper's law do the same to it, also taken up again where it touches.
#[test]
fn the_image_is_met_in_every_form_schedule_and_law() {
    let end = GAP / SPEED + 0.7;
    let run = |mut engine: Engine<2, Simplices<2>>| {
        engine.advance_to(end - 0.5, &mut [ImpulseExchange::default()]).unwrap();
        let state = engine.state().clone();
        engine.advance_to(end - 0.3, &mut [ImpulseExchange::default()]).unwrap();
        engine.restore(&state).unwrap();
        engine.advance_to(end, &mut [ImpulseExchange::default()]).unwrap();
        let totals = engine.totals(end);
        assert!(totals.energy_imbalance.1 < 1e-13 && totals.momentum_imbalance.1 < 1e-13, "{totals:?}");
        assert!(least(&engine) > -1e-15, "a node is {:e} m beyond its image", least(&engine));
        (engine.state().ledger.energy.contact, engine.state().position.clone())
    };
    let fast = run(strip(20, (SteppingSchedule::Bins, MOREAU)));
    assert!(fast.0 < 0.0, "the strip has met its image");
    let others = [
        (SteppingSchedule::Bins, ImpulseLaw::Reversal),
        (SteppingSchedule::Queue, MOREAU),
        (SteppingSchedule::Global, MOREAU),
    ]
    .map(|rules| strip(20, rules));
    for (i, other) in
        others.into_iter().chain([strip(20, (SteppingSchedule::Bins, MOREAU)).with_reference_form()]).enumerate()
    {
        let other = run(other);
        let off = fast.1.iter().zip(&other.1).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        // Steps of other schedules are other ones.
        let (most, part) = if [1, 2].contains(&i) { (1e-2 * GAP, 0.1) } else { (1e-12, 1e-9) };
        assert!(off < most, "{i}: {off:e} m apart");
        assert!((fast.0 - other.0).abs() < part * fast.0.abs(), "{i}: {} and {} J", fast.0, other.0);
    }
}

/// A node may go more than its size in a step.
#[test]
fn a_body_faster_than_sound_does_not_pass_its_mirror_image() {
    for (gap, speed) in [(0.051, 14.0), (0.07, 10.0)] {
        let mut engine = thrown(20, (gap, speed), (SteppingSchedule::Bins, MOREAU));
        for i in 1..=40 {
            // It is crushed: what happens to it then is another question.
            let done = engine.advance_to(2.5e-4 * f64::from(i), &mut [ImpulseExchange::default()]);
            assert!(least(&engine) > -1e-15, "a node is {:e} m beyond its image", least(&engine));
            if done.is_err() {
                break;
            }
        }
        assert!(engine.state().ledger.energy.contact < 0.0, "it has met its image");
    }
}
