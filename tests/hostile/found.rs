//! What the random inputs found, once each.

use super::host::{ERROR, Host, OK, coarse};
use super::scenes;
use ballistic_gel::fmi2::abi::*;
use ballistic_gel::scene;
use ballistic_gel::simulation::{CouplingMode, RestoreError, SavedSimulation, SavedState, Simulation};

/// It went on for ever: ticks of such times are more than there are numbers.
#[test]
fn a_step_beyond_the_ticks_that_are_exact_is_refused() {
    for step in [1e18, 1e300, f64::MAX] {
        let mut host = Host::with(&coarse());
        // SAFETY: a live component.
        let status = unsafe {
            assert_eq!(fmi2SetupExperiment(host.c, 0, 0.0, 0.0, 0, 0.0), OK);
            assert_eq!(fmi2EnterInitializationMode(host.c), OK);
            assert_eq!(fmi2ExitInitializationMode(host.c), OK);
            fmi2DoStep(host.c, 0.0, step, 0)
        };
        assert_eq!(status, ERROR);
        let said = host.one_line();
        assert!(said.starts_with("communicationStepSize = ") && said.contains("ticks"), "{said}");
        assert!(said.len() < 250, "300 digits say less than an exponent: {said}");
        // SAFETY: a live component.
        assert_eq!(unsafe { fmi2DoStep(host.c, 0.0, 1e-6, 0) }, OK);
    }
}

/// A planar simulation after a step, and what comes of restoring its state with something changed.
fn restored(change: impl Fn(&mut SavedSimulation)) -> Result<(), RestoreError> {
    let scene = scene::read(&scenes::seeds()[1]).unwrap();
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
    let inputs = simulation.inputs();
    simulation.step(&inputs, 1e-5).unwrap();
    let mut saved = simulation.save();
    change(&mut saved);
    let digest = simulation.digest();
    let outcome = simulation.restore(&saved);
    assert!(outcome.is_ok() || simulation.digest() == digest, "a refused state changes nothing");
    let inputs = simulation.inputs();
    simulation.step(&inputs, 2e-5).unwrap();
    outcome
}

fn planar(saved: &mut SavedSimulation) -> &mut ballistic_gel::state::DynamicState<2> {
    match &mut saved.state {
        SavedState::Flat(state) => state,
        SavedState::Solid(_) | SavedState::Reduced(_) => panic!("the scene is planar"),
    }
}

/// The next step panicked: its inputs start from where the body is.
#[test]
fn a_state_whose_body_is_out_of_its_plane_or_not_turned_is_refused() {
    assert_eq!(restored(|_| {}), Ok(()));
    let changes: [fn(&mut SavedSimulation); 5] = [
        |saved| planar(saved).bodies[0].position.y = 1e-3,
        |saved| planar(saved).bodies[0].velocity.y = 5e-324,
        |saved| planar(saved).bodies[0].angular_momentum.x = 1.0,
        |saved| planar(saved).bodies[0].wrench.force.y = 1.0,
        |saved| {
            let turned = &mut planar(saved).bodies[0].orientation;
            *turned = nalgebra::Unit::new_unchecked(turned.into_inner() * 1.5);
        },
    ];
    for (i, change) in changes.into_iter().enumerate() {
        assert!(matches!(restored(change), Err(RestoreError::Inconsistent { .. })), "change {i}");
    }
}

/// A step from there went on for ever.
#[test]
fn a_state_whose_times_and_ticks_contradict_each_other_is_refused() {
    let changes: [fn(&mut SavedSimulation); 5] = [
        |saved| saved.time = 1e9,
        |saved| saved.time = f64::NAN,
        |saved| saved.time = -1e300,
        |saved| planar(saved).bodies[0].time = 1e300,
        |saved| planar(saved).bodies[0].time = -1e-6,
    ];
    for (i, change) in changes.into_iter().enumerate() {
        assert!(matches!(restored(change), Err(RestoreError::Inconsistent { .. })), "change {i}");
    }
}

/// A step of twenty element steps took minutes: the gel near a ball that spins at 1e18 rad/s was stepped at every tick.
#[test]
fn a_torque_that_spins_a_body_faster_than_it_can_be_followed_is_named() {
    let scene = scene::read(&coarse()).unwrap();
    for (torque, stops) in [(1e15, true), (1e300, true), (1e-3, false)] {
        let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
        let mut inputs = simulation.inputs();
        inputs[0].wrench.torque.y = torque;
        let ended = simulation.step(&inputs, 1e-3);
        assert_eq!(ended.is_err(), stops, "{torque}: {ended:?}");
        let said = ended.map_or_else(|error| error.to_string(), |()| String::new());
        assert!(!stops || said.contains("projectile.external_torque"), "{said}");
        assert_eq!(simulation.step(&inputs, 2e-3).is_err(), stops);
    }
}
