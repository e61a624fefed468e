//! Several bodies in one gel, bodies that come and go, and domes that grow.

use ballistic_gel::math::{Vector, Vector3};
use ballistic_gel::scene::{self, Override, Scene};
use ballistic_gel::simulation::{CouplingMode, DomeMotion, Observation, ShapeMotion, Simulation, StepInputs};

/// A ball on a block, and a smaller one that follows beside it.
const TWO: &str = r#"
[scene]
name = "two"
dimension = "spatial"
end_time = 4e-3
communication_step = 1e-4
[gel]
shape.block.size = [0.08, 0.06, 0.03]
material = "neo-hookean"
density = 1030.0
shear_modulus = 69e3
bulk_modulus = 667e3
[projectile]
shape.sphere.radius = 0.015
mass = 0.03
position = [-0.02, 0.0, 0.016]
velocity = [0.0, 0.0, -4.0]
angular_velocity = [0.0, 300.0, 0.0]
[[fragment]]
shape.cylinder = { radius = 8e-3, length = 16e-3, edge_radius = 1e-3 }
mass = 0.01
position = [0.02, 0.005, 0.02]
velocity = [-1.0, 0.0, -5.0]
angular_velocity = [50.0, 0.0, 20.0]
[mesh]
size = 8e-3
"#;

fn with(changes: &[&str]) -> Scene {
    let changes: Vec<Override> = changes.iter().map(|change| change.parse().unwrap()).collect();
    scene::read(&scene::resolve(TWO, &changes).unwrap()).unwrap_or_else(|error| panic!("{error}"))
}

fn made(scene: &Scene, mode: CouplingMode) -> Simulation {
    Simulation::new(scene, mode, 1).unwrap()
}

/// Runs to the end in equal slices under what `inputs` makes of the inputs of each.
fn run(
    simulation: &mut Simulation,
    (end, slices): (f64, u32),
    mut inputs: impl FnMut(f64, &mut [StepInputs]),
) -> Observation {
    let start = simulation.time();
    for slice in 1..=slices {
        let mut given = simulation.inputs();
        inputs(simulation.time(), &mut given);
        simulation.step(&given, start + (end - start) * f64::from(slice) / f64::from(slices)).unwrap();
    }
    simulation.observe()
}

fn closes(seen: &Observation) {
    assert!(seen.energy.energy_error < 1e-10, "{}", seen.energy.energy_error);
    assert!(seen.momentum_error < 1e-12 && seen.angular_momentum_error < 1e-12, "{seen:?}");
}

#[test]
fn two_bodies_close_the_books_and_their_bits_do_not_depend_on_slices_or_threads() {
    let scene = with(&["contact.friction=0.2"]);
    let digests = [(1, 1), (7, 1), (100, 2)].map(|(slices, threads)| {
        let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, threads).unwrap();
        let seen = run(&mut simulation, (4e-3, slices), |_, _| ());
        closes(&seen);
        assert!(seen.bodies.iter().all(|body| body.contact.total_impulse.z > 1e-3), "both are met: {:?}", seen.bodies);
        simulation.digest()
    });
    assert_eq!([digests[0]; 3], digests);
}

#[test]
fn the_momentum_of_gel_and_bodies_is_that_of_the_start() {
    let scene = with(&[]);
    let mut simulation = made(&scene, CouplingMode::Integrated);
    let density = scene.gel.density;
    let total = |simulation: &Simulation| {
        let (seen, frame) = (simulation.observe(), simulation.frame());
        let mut momentum = Vector3::zeros();
        for cell in &frame.cells.nodes {
            let rest = cell.map(|node| frame.points[node as usize] - frame.displacements[node as usize]);
            let volume = (rest[1] - rest[0]).cross(&(rest[2] - rest[0])).dot(&(rest[3] - rest[0])).abs() / 6.0;
            momentum +=
                cell.iter().map(|node| frame.velocities[*node as usize] * density * volume / 4.0).sum::<Vector3>();
        }
        let masses = (0..2).map(|body| simulation.inertia(body).0);
        momentum + masses.zip(&seen.bodies).map(|(mass, body)| body.kinematics.velocity * mass).sum::<Vector3>()
    };
    let before = total(&simulation);
    run(&mut simulation, (4e-3, 1), |_, _| ());
    assert!((total(&simulation) - before).norm() < 1e-14 * before.norm() * 10.0);
}

#[test]
fn a_fragment_moves_like_a_projectile() {
    let pair = with(&["projectile.active=false"]);
    let lone = pair.alone(1);
    let (mut pair, mut lone) = (made(&pair, CouplingMode::Integrated), made(&lone, CouplingMode::Integrated));
    let beside = run(&mut pair, (4e-3, 3), |_, _| ());
    let alone = run(&mut lone, (4e-3, 3), |_, _| ());
    assert_eq!(beside.bodies[1], alone.bodies[0]);
    assert_eq!(pair.frame().points, lone.frame().points);
    assert_eq!(beside.bodies[0].kinematics.velocity.z, -4.0, "an inactive body stays as it is");
    assert_eq!(beside.bodies[0].kinematics.position.z, 0.016);
    assert_eq!(beside.energy.kinetic, alone.energy.kinetic, "and is in no account");
}

#[test]
fn a_body_that_is_made_active_starts_from_its_inputs_and_is_booked() {
    let scene = with(&["fragment[1].active=false"]);
    let start = Vector3::new(0.02, 0.0, 0.02);
    for mode in [CouplingMode::Integrated, CouplingMode::Corrected, CouplingMode::Prescribed] {
        let mut simulation = made(&scene, mode);
        run(&mut simulation, (1e-3, 4), |_, _| ());
        let before = simulation.observe();
        run(&mut simulation, (1.001e-3, 1), |_, inputs| {
            inputs[1].active = true;
            inputs[1].kinematics.position = start;
            inputs[1].kinematics.velocity = Vector3::new(0.0, 0.0, -6.0);
            inputs[1].kinematics.angular_velocity = Vector3::zeros();
        });
        let seen = simulation.observe();
        let at = seen.bodies[1].kinematics.position;
        assert!((at - start - Vector3::new(0.0, 0.0, -6e-6)).norm() < 1e-15, "{mode:?} {at}");
        let brought = seen.energy.external - before.energy.external;
        assert!((brought - 0.5 * 0.01 * 36.0).abs() < 1e-3, "{mode:?} {brought}");
        assert!(seen.energy.energy_defect < 1e-2, "what comes from outside is no defect: {:?}", seen.energy);
        closes(&seen);
        let end = run(&mut simulation, (3.8e-3, 20), |_, _| ());
        assert!(end.bodies[1].contact.total_impulse.z > 1e-3, "{mode:?}");
        closes(&end);
        let there = simulation.kinematics(1).position;
        run(&mut simulation, (3.801e-3, 1), |_, inputs| {
            inputs[1].active = false;
            inputs[1].kinematics.position = start;
        });
        let gone = simulation.observe();
        assert!(!gone.bodies[1].active && gone.bodies[1].exchange.impulse == Vector3::zeros());
        assert_eq!(gone.bodies[1].kinematics.position, there, "{mode:?}: it stays where it was");
        assert_eq!(gone.bodies[1].contact.area, 0.0);
        closes(&gone);
    }
}

#[test]
fn a_body_cannot_be_made_active_inside_the_gel() {
    let mut simulation = made(&with(&["fragment[1].active=false"]), CouplingMode::Integrated);
    run(&mut simulation, (1e-4, 1), |_, _| ());
    let mut inputs = simulation.inputs()[1];
    inputs.active = true;
    assert_eq!(simulation.overlap(1, &inputs), None);
    inputs.kinematics.velocity = Vector3::zeros();
    inputs.kinematics.angular_velocity = Vector3::zeros();
    inputs.kinematics.position.z = 0.004;
    assert!((simulation.overlap(1, &inputs).unwrap() - 0.004).abs() < 1e-3);
    // Just above, but so fast that the gel, which did not expect it, looks too late.
    inputs.kinematics.position.z = 0.0081;
    assert_eq!(simulation.overlap(1, &inputs), None);
    inputs.kinematics.velocity.z = -300.0;
    assert!(simulation.overlap(1, &inputs).unwrap() > 1e-3, "{:?}", simulation.overlap(1, &inputs));
}

/// A body whose surface no node of the gel's surface is in, because it is inside the gel.
#[test]
fn a_body_cannot_be_put_into_the_gel_past_its_surface() {
    let small = ["fragment[1].shape.cylinder={radius=5e-3, length=10e-3}", "mesh.size=5e-3"];
    let scene = |more: &[&str]| with(&[&small[..], more].concat());
    let inputs = |simulation: &Simulation, z: f64| {
        let mut inputs = simulation.inputs()[1];
        inputs.active = true;
        inputs.kinematics.velocity = Vector3::zeros();
        inputs.kinematics.position.z = z;
        inputs
    };
    for active in [true, false] {
        let mut simulation = made(&scene(&[&format!("fragment[1].active={active}")]), CouplingMode::Prescribed);
        run(&mut simulation, (1e-5, 1), |_, _| ());
        let inside = inputs(&simulation, -0.015);
        assert_eq!(simulation.overlap(1, &inside), None, "no node of the surface says so");
        assert!(simulation.is_swallowed(1, &inside), "active: {active}");
        assert!(!simulation.is_swallowed(1, &inputs(&simulation, 0.015)));
        // Below the block.
        assert!(!simulation.is_swallowed(1, &inputs(&simulation, -0.05)));
        assert!(!simulation.is_swallowed(1, &StepInputs { active: false, ..inside }));
    }
    let tilted = ["fragment[1].position=[0.02, 0.005, -0.015]", "fragment[1].orientation=[0.8, 0.6, 0.0, 0.0]"];
    let refused = Simulation::new(&scene(&tilted), CouplingMode::Integrated, 1).err().unwrap();
    assert_eq!(
        refused.to_string(),
        "fragment[1].position: at the start the centre of that body is in the gel; move it out"
    );
}

#[test]
fn an_inactive_body_in_the_way_is_not_there() {
    let scene = with(&["fragment[1].active=false", "fragment[1].position=[-0.02, 0, 0.001]", "projectile.active=true"]);
    let (mut pair, mut lone) =
        (made(&scene, CouplingMode::Integrated), made(&scene.alone(0), CouplingMode::Integrated));
    let (beside, alone) = (run(&mut pair, (4e-3, 1), |_, _| ()), run(&mut lone, (4e-3, 1), |_, _| ()));
    assert_eq!(beside.bodies[0], alone.bodies[0]);
    assert_eq!((beside.bodies[1].contact.area, beside.bodies[1].contact.total_impulse.z), (0.0, 0.0));
}

#[test]
fn a_fast_dome_is_followed_within_a_tenth_of_an_element_also_when_it_is_free_or_accelerates() {
    let heavy = ["projectile.fixed=false", "projectile.mass=5.0", "projectile.inertia=[1, 1, 1, 0, 0, 0]"];
    for (more, rate, acceleration) in [(&[][..], 20.0, 0.0), (&[], 0.0, 4e4), (&heavy, 10.0, 0.0)] {
        let scene = dome(&[&["gel.supports.z_min=fixed", "mesh.size=4e-3"], more].concat());
        let mut simulation = made(&scene, CouplingMode::Integrated);
        let seen = run(&mut simulation, (5e-4, 10), |t, inputs| {
            let bulge = bulge_of(&mut inputs[0]);
            bulge.size[0] = t * (rate + 0.5 * acceleration * t);
            bulge.rate[0] = rate + acceleration * t;
            bulge.acceleration[0] = acceleration;
        });
        closes(&seen);
        let contact = &seen.bodies[0].contact;
        assert!(contact.deepest_penetration < 0.1 && contact.total_impulse.z > 0.0, "{contact:?}");
        let height = 5e-4 * (rate + 0.5 * acceleration * 5e-4);
        assert!((bulge_in(&seen).size[0] - height).abs() < 1e-9);
        assert_eq!(seen.bodies[0].kinematics.velocity.z > 0.0, !more.is_empty(), "the gel throws a free plate back");
    }
}

#[test]
#[should_panic(expected = "a height from 0 to the base radius: a cap is at most a hemisphere")]
fn a_dome_must_be_one_at_the_end_of_a_step_too() {
    let mut simulation = made(&dome(&[]), CouplingMode::Integrated);
    let mut inputs = simulation.inputs();
    bulge_of(&mut inputs[0]).rate[0] = 30.0;
    let _ = simulation.step(&inputs, 1e-3);
}

/// Bulge of the dome in its inputs.
fn bulge_of(inputs: &mut StepInputs) -> &mut DomeMotion {
    match &mut inputs.shape_motion {
        Some(ShapeMotion::Bulge(bulge)) => bulge,
        other => panic!("a dome has a bulge, not {other:?}"),
    }
}

/// Bulge of an observed dome.
fn bulge_in(seen: &Observation) -> DomeMotion {
    *seen.bodies[0].shape_motion.as_ref().and_then(ShapeMotion::bulge).unwrap()
}

/// A dome that stands on the gel and bulges into it.
fn dome(more: &[&str]) -> Scene {
    let shape = "projectile.shape={dome={height=0.0, radius=0.02}}";
    let held = ["projectile.fixed=true", "projectile.position=[0, 0, 0]", "projectile.active=true", shape];
    let text = TWO.split("[[fragment]]").next().unwrap().to_owned() + "[mesh]\nsize = 8e-3\n";
    let text = text.replace("mass = 0.03\n", "").replace("velocity = [0.0, 0.0, -4.0]\n", "");
    let text = text.replace("angular_velocity = [0.0, 300.0, 0.0]\n", "").replace("angular_", "");
    let changes: Vec<Override> = held.iter().chain(more).map(|change| change.parse().unwrap()).collect();
    scene::read(&scene::resolve(&text, &changes).unwrap()).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn a_growing_dome_pushes_the_gel_down_and_its_owner_pays() {
    let rate = Vector::<2>::new(4.0, 3.0);
    for (dimension, gel) in [
        ("spatial", "{block={size=[0.08, 0.06, 0.03]}}"),
        ("planar", "{block={size=[0.08, 0.03]}}"),
        ("axisymmetric", "{cylinder={radius=0.04, height=0.03}}"),
    ] {
        let scene = dome(&[
            &format!("scene.dimension={dimension}"),
            &format!("gel.shape={gel}"),
            "gel.supports.z_min=fixed",
            "mesh.size=4e-3",
        ]);
        let mut simulation = made(&scene, CouplingMode::Integrated);
        let mut work = 0.0;
        for step in 0..20 {
            let mut inputs = simulation.inputs();
            bulge_of(&mut inputs[0]).rate = rate;
            simulation.step(&inputs, 1e-4 * f64::from(step + 1)).unwrap();
            // Impulses on the dome are against its growth: its owner gives what the gel takes.
            work -= simulation.exchanges()[0].shape_impulse.dot(&rate);
        }
        let seen = simulation.observe();
        let bulge = bulge_in(&seen);
        assert!((bulge.size - Vector::<2>::new(8e-3, 26e-3)).norm() < 1e-12, "{bulge:?}");
        assert!((seen.bodies[0].depth - 8e-3).abs() < 1e-12);
        closes(&seen);
        assert!((seen.energy.external - work).abs() < 1e-12 * work && work > 0.0, "{} {work}", seen.energy.external);
        let lowest =
            simulation.frame().points.iter().filter(|p| p.x.hypot(p.y) < 3e-3).map(|p| p.z).fold(f64::MIN, f64::max);
        assert!((lowest + 8e-3).abs() < 0.4e-3, "the gel under the apex is at {lowest}");
        assert!(seen.bodies[0].contact.deepest_penetration < 0.1, "{}", seen.bodies[0].contact.deepest_penetration);
    }
}

#[test]
fn an_accelerated_dome_gives_the_same_in_any_slices() {
    let scene = dome(&["gel.supports.z_min=fixed"]);
    let height = |t: f64| 1e3 * t * t;
    let ends = [4, 40].map(|slices| {
        let mut simulation = made(&scene, CouplingMode::Integrated);
        let seen = run(&mut simulation, (2e-3, slices), |t, inputs| {
            let bulge = bulge_of(&mut inputs[0]);
            bulge.size[0] = height(t);
            bulge.rate[0] = 2e3 * t;
            bulge.acceleration[0] = 2e3;
        });
        closes(&seen);
        seen.bodies[0].contact.total_impulse.z
    });
    assert!((ends[0] / ends[1] - 1.0).abs() < 1e-9, "{ends:?}");
}
