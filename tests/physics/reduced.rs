//! Reduced model of the level `instant`: bits, books, couplings and states as of the full model, and refused scenes.

use ballistic_gel::scene::{self, Override, Scene};
use ballistic_gel::simulation::{CouplingMode, SavedSimulation, Simulation};

/// `fbi-bb` at the level `instant` with changes.
fn instant(changes: &[&str]) -> Result<Scene, scene::SceneError> {
    let changes = ["scene.fidelity=instant"].iter().chain(changes).map(|change| change.parse().unwrap());
    scene::read(&scene::resolve(scene::builtin("fbi-bb").unwrap(), &changes.collect::<Vec<Override>>())?)
}

/// The end of a scene in so many communication steps.
fn run(scene: &Scene, steps: u32) -> Simulation {
    let mut simulation = Simulation::new(scene, CouplingMode::Integrated, 1).unwrap();
    advance(&mut simulation, scene.scene.end_time, steps);
    simulation
}

fn advance(simulation: &mut Simulation, end: f64, steps: u32) {
    let start = simulation.time();
    for step in 1..=steps {
        let inputs = simulation.inputs();
        simulation.step(&inputs, start + (end - start) * f64::from(step) / f64::from(steps)).unwrap();
    }
}

/// A heavy ball that leaves a thin gel, which is free.
const THROUGH: [&str; 4] = [
    "gel.shape={ cylinder = { radius = 0.075, height = 0.05 } }",
    "gel.supports={}",
    "projectile.velocity=[0, 0, -400]",
    "projectile.mass=1e-3",
];

#[test]
fn communication_steps_and_restarts_leave_no_trace() {
    for changes in [&[][..], &THROUGH] {
        let scene = instant(changes).unwrap();
        let once = run(&scene, 1);
        assert!([7, 100, 1237].into_iter().all(|steps| run(&scene, steps).digest() == once.digest()));
        let mut restarted = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
        for part in 1..=5 {
            advance(&mut restarted, scene.scene.end_time * f64::from(part) / 5.0, 3);
            let mut bytes = vec![];
            restarted.save().write(&mut |run| bytes.extend_from_slice(run));
            let mut saved = SavedSimulation::empty();
            assert!(saved.read(&bytes) && saved.size() == bytes.len());
            restarted = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
            restarted.restore(&saved).unwrap();
        }
        assert_eq!(restarted.digest(), once.digest());
    }
}

#[test]
fn energy_and_momentum_close_whether_the_gel_is_held_or_free() {
    let moving = ["gel.supports={}", "gel.velocity=[0, 0, -20]", "projectile.velocity=[0, 0, -200]"];
    for changes in [&[][..], &THROUGH, &moving] {
        let scene = instant(changes).unwrap();
        let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
        for end in [1e-5, 1e-4, 5e-4, 5e-3] {
            advance(&mut simulation, end, 1);
            let seen = simulation.observe();
            assert!(seen.energy.energy_error < 1e-13 && seen.momentum_error < 1e-13, "{changes:?}: {:?}", seen.energy);
            let heat = -seen.energy.viscous;
            // After 5 ms all rings behind a ball that has left have closed.
            assert!(heat > 0.0 && (end > 1e-3 || seen.energy.elastic > 0.0), "{changes:?} {end}: {:?}", seen.energy);
        }
    }
}

/// An importer's body under J and S of each step lands where the inner one is.
#[test]
fn an_importer_lands_on_the_predicted_state() {
    let scene = instant(&[]).unwrap();
    let mut simulation = Simulation::new(&scene, CouplingMode::Corrected, 1).unwrap();
    let mass = scene.projectile.mass.unwrap();
    for step in 1..=400 {
        let inputs = simulation.inputs();
        let (before, duration) = (inputs[0].kinematics, 5e-6);
        simulation.step(&inputs, f64::from(step) * duration).unwrap();
        let (exchange, after) = (simulation.exchanges()[0], simulation.kinematics(0));
        let velocity = before.velocity + exchange.impulse / mass;
        let position = before.position + before.velocity * exchange.duration + exchange.impulse_moment / mass;
        assert!((velocity - after.velocity).norm() < 1e-11, "{velocity} {}", after.velocity);
        assert!((position - after.position).norm() < 1e-14, "{position} {}", after.position);
    }
    assert!(simulation.kinematics(0).velocity.z > -100.0, "the ball has been slowed down");
}

/// A prescribed motion meets the resistance at its speed, and the work of the importer is booked.
#[test]
fn a_prescribed_body_is_resisted_and_its_work_is_external() {
    let scene = instant(&[]).unwrap();
    let mut simulation = Simulation::new(&scene, CouplingMode::Prescribed, 1).unwrap();
    let mut impulse = 0.0;
    for step in 1..=40 {
        let inputs = simulation.inputs();
        simulation.step(&inputs, f64::from(step) * 5e-6).unwrap();
        impulse += simulation.exchanges()[0].impulse.z;
    }
    let seen = simulation.observe();
    assert_eq!(simulation.kinematics(0).velocity.z, -179.8);
    assert!((seen.energy.external / (179.8 * impulse) - 1.0).abs() < 1e-12 && seen.energy.energy_error < 1e-13);
}

#[test]
fn a_ball_leaves_a_thin_gel_slower_and_one_that_stops_is_pushed_back() {
    let through = run(&instant(&THROUGH).unwrap(), 20);
    let exit = through.exit(0).expect("the ball leaves");
    assert!((-390.0..-100.0).contains(&exit.velocity.z), "{exit:?}");
    let stopped = run(&instant(&[]).unwrap(), 20).observe();
    let (peak, end) = (stopped.projectile().contact.peak_depth.0, stopped.projectile().depth);
    assert!((0.07..0.1).contains(&peak) && peak - end > 2e-3 && peak - end < 0.012, "{peak} {end}");
    assert!(stopped.projectile().kinematics.velocity.norm() < 0.5);
}

/// The cavity of the frames, cut as that of finite elements, is the one of the rings.
#[test]
fn frames_show_the_rings() {
    let scene = instant(&[]).unwrap();
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
    advance(&mut simulation, 4e-4, 4);
    let frame = simulation.frame();
    let corner = |[a, b, c]: [usize; 3]| {
        let [p, q, r] = [a, b, c].map(|node| frame.points[node]);
        (q - p).cross(&(r - p)).y
    };
    let mut areas = frame.cells.nodes.iter().map(|nodes| corner([nodes[0], nodes[1], nodes[2]].map(|n| n as usize)));
    assert!(areas.all(|area| area < 0.0), "no triangle is turned over");
    let axis: Vec<_> = frame.cells.facets.iter().filter(|facet| facet[0] % 11 == 0 && facet[1] % 11 == 0).collect();
    assert!(axis.len() > 10, "{} rows are open", axis.len());
}

#[test]
fn shots_that_are_not_identified_are_refused_with_a_remedy() {
    for (change, key) in [
        ("projectile.velocity=[0, 0, -20]", "projectile.velocity"),
        ("projectile.velocity=[0, 0, -1500]", "projectile.velocity"),
        ("projectile.mass=5e-3", "projectile.mass"),
        ("projectile.shape={ cylinder = { radius = 2e-3, length = 4e-3 } }", "projectile.shape"),
        ("gel.strength_scale=1.2", "gel"),
        ("gel.shape={ cylinder = { radius = 0.012, height = 0.1 } }", "gel.shape.cylinder.radius"),
        ("sensor=[{ position = [0.0, 0.0, -0.02] }]", "sensor"),
        ("contact.friction=0.2", "contact.friction"),
    ] {
        let error = instant(&[change]).expect_err(change);
        assert_eq!(error.key, key, "{error}");
        assert!(error.to_string().contains("--fidelity draft"), "{error}");
    }
    assert!(instant(&[]).unwrap().instant_error().is_some_and(|error| error > 0.088), "that of coarse, and more");
}
