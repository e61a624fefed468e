//! Layered gels: waves through an interface, materials that remeshing keeps, and layers of one material.

use ballistic_gel::scene::{self, Override, Scene};
use ballistic_gel::simulation::{CouplingMode, Observation, Simulation};

/// A soft elastic layer of twice the stiffness and a density of 1.2 on `sphere-deep` about an axis.
const STIFF: &str = "[[layer]]\nthickness = 0.02\nshear_modulus = 137931.03448275862\ndensity = 1236.0\n";
/// A layer of half the stiffness and a tenth more density.
const SOFT: &str = "[[layer]]\nthickness = 0.02\nshear_modulus = 34482.75862068966\ndensity = 1133.0\n";
/// A stiffer and heavier layer on a gel of two networks.
const SKIN: &str = "[[layer]]\nthickness = 0.01\nstrength_scale = 2.0\ndensity = 1133.0\nbulk_modulus = 3e9\n";

/// A built-in scene with layers and changes.
fn layered(name: &str, layers: &str, changes: &[&str]) -> Scene {
    let changes: Vec<Override> = changes.iter().map(|change| change.parse().unwrap()).collect();
    let text = scene::resolve(scene::builtin(name).unwrap(), &changes).unwrap();
    scene::read(&format!("{text}\n{layers}")).unwrap_or_else(|error| panic!("{error}"))
}

/// `sphere-deep` about an axis at this speed, m/s.
fn bilayer(speed: f64, layers: &str, more: &[&str]) -> Scene {
    let velocity = format!("projectile.velocity=[0, 0, {}]", -speed);
    let round = [
        "scene.dimension=axisymmetric",
        "gel.shape={ cylinder = { radius = 0.07, height = 0.12 } }",
        "mesh.tree={ coarsest = 4, core = 0.025, slope = 0.2 }",
        "mesh.size=2.5e-3",
        "remesh.smallest=2e-3",
        &velocity,
    ];
    layered("sphere-deep", layers, &[&round[..], more].concat())
}

/// The end of a scene in so many communication steps.
fn run(scene: &Scene, threads: usize, steps: u32) -> Simulation {
    let mut simulation = Simulation::new(scene, CouplingMode::Integrated, threads).unwrap();
    for step in 1..=steps {
        let inputs = simulation.inputs();
        simulation.step(&inputs, scene.scene.end_time * f64::from(step) / f64::from(steps)).unwrap();
    }
    simulation
}

fn check_books(seen: &Observation) {
    assert!(seen.energy.energy_error < 1e-10, "energy: {:e}", seen.energy.energy_error);
    assert!(seen.momentum_error < 1e-11, "momentum: {:e}", seen.momentum_error);
    assert!(seen.angular_momentum_error < 1e-11, "angular momentum: {:e}", seen.angular_momentum_error);
}

/// A strip that is pushed at its upper face through a layer: the wave passes with 2 Z₁/(Z₁ + Z₂) of its velocity, as it
/// is reflected with the rest, Z = √(ρ M), and the stress with Z₂/Z₁ times that.
#[test]
fn a_wave_passes_an_interface_as_the_impedances_say() {
    let strip = "[scene]\nname = \"strip\"\nend_time = 1.2e-3\ncommunication_step = 1e-5\ndimension = \"planar\"\n\
         [gel]\nshape.block.size = [0.0025, 0.1]\nmaterial = \"two-network\"\ndensity = 1000.0\nshear_modulus = 20e3\n\
         bulk_modulus = 2e6\nsupports = { x_min = \"roller\", x_max = \"roller\" }\n\
         [[layer]]\nthickness = 0.04\ndensity = 1500.0\nbulk_modulus = 8e6\nstrength_scale = 3.0\n\
         [projectile]\nshape.half-space.normal = [0.0, 0.0, -1.0]\nfixed = true\nactive = false\nposition = [0.0, 0.0, 1.0]\n\
         [mesh]\nsize = 0.5e-3\n[[load]]\non = \"z_max\"\npressure = 100.0\nramp = 1e-4\n\
         [[sensor]]\nposition = [0.0, 0.0, -0.02]\n[[sensor]]\nposition = [0.0, 0.0, -0.06]\n";
    let scene = scene::read(strip).unwrap_or_else(|error| panic!("{error}"));
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
    let mut mean = |sensor: usize, from: f64, to: f64| {
        const SAMPLES: u32 = 40;
        let sum: f64 = (0..=SAMPLES)
            .map(|i| {
                let inputs = simulation.inputs();
                let time = from + (to - from) * f64::from(i) / f64::from(SAMPLES);
                simulation.step(&inputs, time).unwrap();
                simulation.observe().sensors[sensor].velocity.z
            })
            .sum();
        -sum / f64::from(SAMPLES + 1)
    };
    let impedance = |density: f64, bulk: f64, shear: f64| (density * (bulk + 4.0 / 3.0 * shear)).sqrt();
    let [layer, gel] = [impedance(1500.0, 8e6, 60e3), impedance(1000.0, 2e6, 20e3)];
    let found = [mean(0, 0.40e-3, 0.52e-3), mean(0, 0.92e-3, 1.02e-3), mean(1, 1.1e-3, 1.2e-3)];
    let passed = 200.0 / (layer + gel);
    for (found, expected) in found.into_iter().zip([100.0 / layer, passed, passed]) {
        assert!((found / expected - 1.0).abs() < 0.01, "{found:e} m/s for {expected:e}");
    }
}

/// A layer of the gel's own constants changes nothing on a fixed mesh.
#[test]
fn a_layer_of_the_same_material_is_no_layer() {
    let short = ["scene.end_time=1e-3", "mesh.size=5e-3"];
    let [plain, same] =
        ["", "[[layer]]\nthickness = 0.02\n"].map(|layers| run(&layered("sphere-block", layers, &short), 1, 3));
    let [plain, same] = [&plain, &same].map(|run| (run.kinematics(0), run.observe().energy));
    assert_eq!(plain, same);
}

/// A layer, until a wave has reached its end at a plane of the mesh, is a gel of its constants: the same run to round-off,
/// with its tension limit in proportion to the bulk modulus. The elastic layer has the speed of sound of the gel below it: with
/// other steps the tick, chosen for the steps of all elements, would be another one.
#[test]
fn a_layer_is_a_gel_of_its_constants() {
    let flowing =
        "[[layer]]\nthickness = 0.12857142857142856\nstrength_scale = 2.0\ndensity = 1133.0\nbulk_modulus = 2636.8e6\n";
    let elastic = "[[layer]]\nthickness = 0.04\nshear_modulus = 34482.75862068966\ndensity = 515.0\n";
    let short = ["scene.end_time=6e-6", "scene.communication_step=3e-6", "mesh.size=0.7e-3", "remesh.quality=0"];
    let in_proportion = [&short[..], &["gel.volume.tension_limit=0.5e6"]].concat();
    let own = ["gel.strength_scale=2", "gel.density=1133", "gel.bulk_modulus=2636.8e6"];
    let slow = ["scene.end_time=0.2e-3", "mesh.size=5e-3"];
    let half = ["gel.shear_modulus=34482.75862068966", "gel.bulk_modulus=333333.3333333333", "gel.density=515"];
    for [layer, gel] in [
        [layered("fbi-bb", flowing, &in_proportion), layered("fbi-bb", "", &[&short[..], &own].concat())],
        [layered("sphere-block", elastic, &slow), layered("sphere-block", "", &[&slow[..], &half].concat())],
    ] {
        let [layer, gel] = [&layer, &gel].map(|scene| run(scene, 1, 1));
        let [speed, expected] = [&layer, &gel].map(|run| run.kinematics(0).velocity.z);
        let [energy, other] = [&layer, &gel].map(|run| run.observe().energy);
        assert!((speed / expected - 1.0).abs() < 1e-10, "{speed} {expected}");
        assert!(energy.elastic > 1e-4 * energy.initial, "{energy:?}");
        assert!((energy.kinetic / other.kinetic - 1.0).abs() < 1e-9, "{energy:?} {other:?}");
        assert!((energy.elastic / other.elastic - 1.0).abs() < 1e-9, "{energy:?} {other:?}");
    }
}

/// As long as a fixed mesh follows, on a stiff layer to 13 m/s, on a soft one to 6, a mesh that is remade turns the ball at the
/// same depth.
#[test]
fn remeshing_is_neutral_on_an_elastic_bilayer() {
    for (speed, layers, least_remeshes) in [(13.0, STIFF, 1), (6.0, SOFT, 5)] {
        let end = ["scene.end_time=8e-3"];
        let fixed = ["scene.end_time=8e-3", "remesh.quality=0"];
        let [remade, kept] = [&end[..], &fixed[..]].map(|more| run(&bilayer(speed, layers, more), 1, 1));
        let [seen, reference] = [&remade, &kept].map(Simulation::observe);
        assert!(seen.cost.remeshes >= least_remeshes && reference.cost.remeshes == 0, "{:?}", seen.cost);
        check_books(&seen);
        let [depth, expected] = [&seen, &reference].map(|seen| seen.projectile().contact.peak_depth.0);
        assert!((depth / expected - 1.0).abs() < 0.02, "{depth} m for {expected}");
        let alone = run(&bilayer(speed, "", &end), 1, 1).observe().projectile().contact.peak_depth.0;
        assert!((depth / alone - 1.0).abs() > 0.05, "{depth} m, {alone} without the layer");
    }
}

/// The mass of each material is kept but for the gel that is eroded.
fn check_masses(scene: &Scene, least_remeshes: u64) {
    let before = Simulation::new(scene, CouplingMode::Integrated, 1).unwrap().material_masses();
    let done = run(scene, 1, 10);
    let (seen, after) = (done.observe(), done.material_masses());
    check_books(&seen);
    assert!(seen.cost.remeshes >= least_remeshes, "{} meshes", seen.cost.remeshes);
    assert!(seen.energy.energy_defect < 0.02, "defect {}", seen.energy.energy_defect);
    let (whole, eroded) = (before.iter().sum::<f64>(), seen.cost.eroded_mass);
    let round_off = 1e-12 * whole;
    let lost: Vec<f64> = before.iter().zip(&after).map(|(before, after)| before - after).collect();
    assert!((lost.iter().sum::<f64>() - eroded).abs() < round_off, "{lost:?} of {before:?}, {eroded} eroded");
    assert!(lost.iter().all(|lost| *lost > -round_off), "{lost:?}");
}

#[test]
fn materials_keep_their_mass_through_all_remeshings() {
    check_masses(&bilayer(20.0, STIFF, &["scene.end_time=8e-3"]), 40);
    check_masses(&layered("fbi-bb", SKIN, &["scene.end_time=2e-3", "scene.fidelity=coarse"]), 90);
    let small = ["scene.end_time=0.1e-3", "mesh.size=1.2e-3", "remesh.smallest=0.6e-3"];
    check_masses(&layered("fbi-bb-3d", SKIN, &small), 10);
}

/// Neither slices, threads nor states that are saved and restored change a bit of a layered gel.
#[test]
fn layers_leave_no_trace_of_steps_threads_or_restarts() {
    let scene = layered("fbi-bb", SKIN, &["scene.end_time=0.15e-3", "scene.fidelity=draft"]);
    let whole = run(&scene, 1, 1);
    assert!(whole.observe().cost.remeshes > 3);
    let mut again = Simulation::new(&scene, CouplingMode::Integrated, 2).unwrap();
    for step in 1..=20 {
        let mut other = Simulation::new(&scene, CouplingMode::Integrated, 2).unwrap();
        other.restore(&again.save()).expect("a state of the same scene");
        again = other;
        let inputs = again.inputs();
        again.step(&inputs, scene.scene.end_time * f64::from(step) / 20.0).unwrap();
    }
    assert_eq!(again.digest(), whole.digest());
    let mut plain =
        Simulation::new(&layered("fbi-bb", "", &["scene.fidelity=draft"]), CouplingMode::Integrated, 1).unwrap();
    assert!(plain.restore(&whole.save()).is_err(), "a state of a layered gel");
}
