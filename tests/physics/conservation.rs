//! What must hold on any scene: the books close, and the bits depend neither on slices of time, threads nor on a restart.

use ballistic_gel::math::Vector3;
use ballistic_gel::scene::{self, Override, Scene};
use ballistic_gel::simulation::{CouplingMode, SavedSimulation, Simulation, Wrench};
use proptest::prelude::*;

/// Spatial: a small block and a large ball, a few hundred elements.
const SPATIAL: &str = r#"
[scene]
name = "conservation"
dimension = "spatial"
end_time = 4e-3
communication_step = 1e-4
[gel]
shape.block.size = [0.06, 0.06, 0.03]
material = "neo-hookean"
density = 1030.0
shear_modulus = 69e3
bulk_modulus = 667e3
[projectile]
shape.sphere.radius = 0.03
mass = 0.05
position = [0.0, 0.0, 0.03]
velocity = [0.0, 0.0, -2.0]
[mesh]
size = 0.01
"#;

const PLANAR: [&str; 3] = ["scene.dimension=planar", "gel.shape.block.size=[0.06, 0.03]", "mesh.size=5e-3"];
const AXISYMMETRIC: [&str; 3] =
    ["scene.dimension=axisymmetric", "gel.shape={cylinder={radius=0.04, height=0.03}}", "mesh.size=5e-3"];

/// The spatial scene with these values instead.
fn with<'a>(changes: impl IntoIterator<Item = &'a str>) -> Scene {
    let changes: Vec<Override> =
        changes.into_iter().map(|change| change.parse().expect("a change is key=value")).collect();
    let text = scene::resolve(SPATIAL, &changes).expect("the scene is TOML");
    scene::read(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn simulation(scene: &Scene, threads: usize) -> Simulation {
    Simulation::new(scene, CouplingMode::Integrated, threads).expect("the scene is small")
}

/// Steps through these instants under a wrench. A run that fails (a sharp edge may leak through a coarse surface) ends at
/// its last consistent tick, where everything must hold as well.
fn run(simulation: &mut Simulation, instants: impl IntoIterator<Item = f64>, wrench: Wrench) {
    for instant in instants {
        let mut inputs = simulation.inputs();
        inputs[0].wrench = wrench;
        if simulation.step(&inputs, instant).is_err() {
            return;
        }
    }
}

/// `n` equal slices up to the end.
fn slices(scene: &Scene, n: u32) -> impl Iterator<Item = f64> + use<> {
    let end = scene.scene.end_time;
    (1..=n).map(move |i| end * f64::from(i) / f64::from(n))
}

/// The simulation after `n` equal slices, or where it has failed.
fn sliced(scene: &Scene, n: u32) -> Simulation {
    let mut simulation = simulation(scene, 1);
    run(&mut simulation, slices(scene, n), Wrench::default());
    simulation
}

/// The digest at the end of a run that does not fail: two runs that fail at once are alike, whatever is wrong with
/// them.
fn digest(scene: &Scene, n: u32) -> u128 {
    let simulation = sliced(scene, n);
    assert!(simulation.failure().is_none(), "{:?}", simulation.failure());
    simulation.digest()
}

/// Returns true if the ball has met the gel: before, runs that fail or stand still are alike.
fn has_met(simulation: &Simulation) -> bool {
    simulation.observe().projectile().contact.total_impulse.z > 0.0
}

prop_compose! {
    /// How the gel is divided and stepped, and how it meets the ball.
    fn numerics()(
        queue in any::<bool>(),
        kuhn in any::<bool>(),
        graded in any::<bool>(),
        reversal in any::<bool>(),
        cfl in 0.3..0.9,
        restitution in 0.0..1.0,
        bias in 0.0..0.4,
        friction in prop::sample::select(vec![0.0, 0.3, 2.0]),
    ) -> Vec<String> {
        let mut changes = vec![
            format!("integrator.schedule={}", if queue { "queue" } else { "bins" }),
            format!("mesh.lattice={}", if kuhn { "kuhn" } else { "centred" }),
            format!("integrator.cfl={cfl}"),
        ];
        if graded {
            changes.push("mesh.grading={core=0.01, growth=1.3, largest=0.02}".into());
        }
        if reversal {
            changes.push("contact.law=reversal".into());
        } else {
            changes.push(format!("contact.restitution={restitution}"));
            changes.push(format!("contact.bias={bias}"));
            changes.push(format!("contact.friction={friction}"));
        }
        changes
    }
}

/// Half of the length of the rod.
const REACH: f64 = 0.025;

prop_compose! {
    /// What starts just above the gel: the ball, or a tilted rod, whose impulses turn it.
    fn body()(rod in any::<bool>(), tilt in -0.5..0.5) -> (Vec<String>, f64) {
        let (sin, cos) = f64::sin_cos(0.5 * tilt);
        let across = f64::sin(tilt).abs() * 0.02 + f64::cos(tilt) * REACH;
        let shape = format!("projectile.shape={{cylinder={{radius=0.02, length={}}}}}", 2.0 * REACH);
        let turn = format!("projectile.orientation=[{cos:e}, 0.0, {sin:e}, 0.0]");
        if rod { (vec![shape, turn], across + 5e-4) } else { (vec![], 0.0305) }
    }
}

prop_compose! {
    /// Where the body starts, how it moves and turns, and how the gel is held and moves.
    fn motion()(
        dimension in 0..3,
        (shape, height) in body(),
        (x, y) in (-0.01..0.01, -0.01..0.01),
        (vx, vy, vz) in (-1.0..1.0, -1.0..1.0, -3.0..-0.5),
        spin in -50.0..50.0,
        mass in 0.005..0.2,
        support in prop::sample::select(vec!["free", "roller", "fixed"]),
    ) -> Vec<String> {
        let own: &[&str] = match dimension { 0 => &PLANAR, 1 => &AXISYMMETRIC, _ => &[] };
        let mut changes: Vec<String> = own.iter().map(|&change| change.to_owned()).collect();
        changes.push(format!("gel.supports.z_min={support}"));
        changes.push(format!("projectile.mass={mass:e}"));
        if dimension == 1 {
            changes.push(format!("projectile.velocity=[0.0, 0.0, {vz:e}]"));
            return changes;
        }
        let (y, vy) = if dimension == 2 { (y, vy) } else { (0.0, 0.0) };
        changes.extend(shape);
        changes.push(format!("projectile.position=[{x:e}, {y:e}, {height:e}]"));
        changes.push(format!("projectile.velocity=[{vx:e}, {vy:e}, {vz:e}]"));
        changes.push(format!("projectile.angular_velocity=[0.0, {spin:e}, 0.0]"));
        if support == "free" {
            changes.push(format!("gel.velocity=[{:e}, 0.0, {:e}]", 0.3 * vy, 0.1 * vx));
        }
        changes
    }
}

proptest! {
    #[test]
    fn the_books_close(numerics in numerics(), motion in motion(), pull in -20.0..20.0) {
        let scene = with(numerics.iter().chain(&motion).map(String::as_str));
        let mut simulation = simulation(&scene, 1);
        let wrench = Wrench { force: Vector3::new(0.0, 0.0, pull), ..Wrench::default() };
        for instant in slices(&scene, 5) {
            run(&mut simulation, [instant], wrench);
            let seen = simulation.observe();
            prop_assert!(seen.momentum_error <= 1e-12, "momentum: {:e}", seen.momentum_error);
            prop_assert!(seen.angular_momentum_error <= 1e-12, "angular momentum: {:e}", seen.angular_momentum_error);
            prop_assert!(seen.energy.energy_error <= 1e-10, "energy: {:e}", seen.energy.energy_error);
        }
        // The edge of a rod may miss every node: such a case shows nothing.
        prop_assume!(has_met(&simulation));
    }

    #[test]
    fn slices_of_time_leave_no_trace(numerics in numerics(), motion in motion(), mut cuts in prop::collection::vec(0.0..4e-3, 0..20)) {
        let scene = with(numerics.iter().chain(&motion).map(String::as_str));
        cuts.sort_by(f64::total_cmp);
        let (whole, mut cut) = (sliced(&scene, 1), simulation(&scene, 1));
        run(&mut cut, cuts.into_iter().chain([scene.scene.end_time]), Wrench::default());
        prop_assert_eq!(cut.digest(), whole.digest());
        prop_assume!(has_met(&whole));
    }

    #[test]
    fn a_restart_leaves_no_trace(numerics in numerics(), motion in motion(), part in 0.0..1.0) {
        let scene = with(numerics.iter().chain(&motion).map(String::as_str));
        let end = scene.scene.end_time;
        let mut whole = simulation(&scene, 1);
        run(&mut whole, [part * end], Wrench::default());
        // A saved state says where a run is, not that it has failed.
        prop_assume!(whole.failure().is_none());
        let mut bytes = Vec::new();
        whole.save().write(&mut |run| bytes.extend_from_slice(run));
        run(&mut whole, [end], Wrench::default());
        let mut saved = SavedSimulation::empty();
        prop_assert!(saved.read(&bytes));
        let mut restarted = simulation(&scene, 1);
        restarted.restore(&saved).unwrap();
        prop_assert_eq!(restarted.digest(), saved.digest());
        run(&mut restarted, [end], Wrench::default());
        prop_assert_eq!(restarted.digest(), whole.digest());
        whole.restore(&saved).unwrap();
        run(&mut whole, [end], Wrench::default());
        prop_assert_eq!(restarted.digest(), whole.digest());
        prop_assume!(has_met(&whole));
    }
}

#[test]
fn any_number_of_communication_steps_gives_the_same_bits() {
    for scene in [with([]), with(PLANAR), with(AXISYMMETRIC), with(["integrator.schedule=queue"])] {
        let whole = digest(&scene, 1);
        for n in [7, 100, 12_345] {
            assert_eq!(digest(&scene, n), whole, "{n} communication steps, {:?}", scene.scene.dimension);
        }
    }
}

/// What is known of gaps and facets is forgotten at a restart: it may spare work, and no bit may depend on it.
#[test]
fn a_restart_at_every_step_gives_the_same_bits() {
    let fine = ["mesh.size=4e-3", "projectile.velocity=[0.2, 0.1, -3.0]"];
    let shapes: [&[&str]; 3] = [
        &[],
        &[
            "projectile.shape={plate={size=[0.02, 0.02, 0.02], edge_radius=2e-3}}",
            "projectile.position=[0.0, 0.0, 0.01]",
        ],
        &["projectile.shape={capsule={radius=5e-3, length=0.03}}", "projectile.position=[0.0, 0.0, 0.015]"],
    ];
    for shape in shapes {
        let scene = with(fine.iter().chain(shape).copied());
        let mut again = simulation(&scene, 1);
        for instant in slices(&scene, 80) {
            let saved = again.save();
            again.restore(&saved).expect("its own state");
            run(&mut again, [instant], Wrench::default());
        }
        assert!(again.observe().energy.contact < 0.0, "{shape:?}: it has not touched");
        assert_eq!(again.digest(), digest(&scene, 80), "{shape:?}");
    }
}

/// The element phase shares its work only when more than a thousand elements fire together.
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let fine = [
        with(["mesh.size=4e-3", "scene.end_time=1e-3"]),
        with([PLANAR[0], PLANAR[1], "mesh.size=1e-3", "scene.end_time=1e-3"]),
    ];
    for scene in fine {
        let end = scene.scene.end_time;
        let digests = [1, 2, 8].map(|threads| {
            let mut simulation = simulation(&scene, threads);
            run(&mut simulation, [end], Wrench::default());
            assert!(simulation.failure().is_none() && has_met(&simulation), "{:?}", simulation.failure());
            assert!(simulation.observe().cost.elements > 4096, "too few elements to be shared");
            simulation.digest()
        });
        assert!(digests.iter().all(|digest| *digest == digests[0]), "1, 2 and 8 threads, {:?}", scene.scene.dimension);
    }
}

#[test]
fn the_digest_sees_every_change_of_the_scene() {
    let changes = [
        "projectile.mass=0.0500001",
        "projectile.velocity=[0.0, 0.0, -2.000001]",
        "projectile.position=[1e-9, 0.0, 0.03]",
        "projectile.angular_velocity=[0.0, 1e-6, 0.0]",
        "projectile.shape.sphere.radius=0.0300001",
        "gel.density=1030.001",
        "gel.shear_modulus=69000.1",
        "gel.bulk_modulus=667000.1",
        "gel.velocity=[0.0, 0.0, 1e-6]",
        "gel.supports.z_min=fixed",
        "mesh.lattice=kuhn",
        "integrator.cfl=0.7",
        "integrator.schedule=queue",
        "contact.restitution=0.01",
        "contact.friction=0.01",
        "contact.law=reversal",
    ];
    let same = digest(&with([]), 1);
    let mut seen = vec![same];
    for change in changes {
        let digest = digest(&with([change]), 1);
        assert!(!seen.contains(&digest), "{change} left the digest as it was");
        seen.push(digest);
    }
    assert_eq!(digest(&with([]), 1), same);
}

#[test]
fn light_bodies_leave_the_books_closed() {
    for exponent in -9..=0 {
        let mass = 10f64.powi(exponent);
        let set = format!("projectile.mass={mass:e}");
        let scene = with([set.as_str(), "projectile.velocity=[1.0, 0.5, -2.0]", "contact.friction=0.3"]);
        let mut simulation = simulation(&scene, 1);
        run(&mut simulation, slices(&scene, 4), Wrench::default());
        let seen = simulation.observe();
        assert!(seen.projectile().contact.first.is_some(), "{mass} kg");
        let errors = [seen.energy.energy_error, seen.momentum_error, seen.angular_momentum_error];
        println!("{mass:e} kg: {errors:?}, angular {:e} N·m·s", seen.angular_momentum_imbalance.norm());
        assert!(errors[0] <= 1e-10 && errors[1] <= 1e-12 && errors[2] <= 1e-12, "{mass:e} kg: {errors:?}");
        // What a body of a gram and more brings is told from round-off by itself.
        let brought = 0.1 * mass * seen.projectile().kinematics.velocity.norm();
        assert!(exponent < -3 || seen.angular_momentum_imbalance.norm() < 1e-12 * brought, "{mass:e} kg");
    }
}
