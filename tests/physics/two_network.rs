//! Shots into a gel of two networks: what they keep, how far they come, and that no bit depends on how time is sliced.

use ballistic_gel::scene::{self, Override, Scene};
use ballistic_gel::simulation::{CouplingMode, RemeshRefusal, SavedSimulation, Simulation};

/// The first 0.15 ms of the calibration shot on cells of R/4.
const COARSE: [&str; 4] = [
    "scene.end_time=1.5e-4",
    "mesh.size=0.54e-3",
    "remesh.smallest=0.27e-3",
    "gel.shape.cylinder={radius=0.05,height=0.06}",
];

fn shot(changes: &[&str]) -> Scene {
    let changes: Vec<Override> = COARSE.iter().chain(changes).map(|change| change.parse().unwrap()).collect();
    scene::read(&scene::resolve(scene::builtin("fbi-bb").unwrap(), &changes).unwrap()).unwrap()
}

/// The end of a scene in so many communication steps.
fn run(scene: &Scene, steps: u32, threads: usize) -> Simulation {
    let mut simulation = Simulation::new(scene, CouplingMode::Integrated, threads).unwrap();
    for step in 1..=steps {
        let inputs = simulation.inputs();
        simulation.step(&inputs, scene.scene.end_time * f64::from(step) / f64::from(steps)).unwrap();
    }
    simulation
}

/// Depth of the nose of the BB after 0.15 ms, mm, by Poncelet's law m dv/dt = −(½ρ`drag`v² + `resistance`) A, Pa.
fn nose_by_law(drag: f64, resistance: f64) -> f64 {
    let (speed, mass, area, time) = (179.8, 0.343e-3, std::f64::consts::PI * 2.185e-3_f64.powi(2), 1.5e-4);
    let inertia = 0.5 * 1030.0 * drag;
    let (fast, pace) = ((resistance / inertia).sqrt(), (resistance * inertia).sqrt() * area / mass);
    let slowed = fast * ((speed / fast).atan() - pace * time).tan();
    let ratio = (inertia * speed * speed + resistance) / (inertia * slowed * slowed + resistance);
    1e3 * mass / (2.0 * inertia * area) * ratio.ln()
}

/// Resistances, Pa, with which Poncelet's law with this drag stops the recovered bullets to which the gel is fitted where
/// they were found.
fn resistances_of_recovered_bullets(drag: f64) -> Vec<f64> {
    let rows = include_str!("../../python/ballistic_gel/data/measured_shots.csv")
        .lines()
        .map(|row| row.split(',').collect::<Vec<_>>());
    let recovered = rows.filter(|row| row[1].ends_with("-recovered") && row[9] == "true");
    let resistance = |row: Vec<&str>| {
        let projectile = scene::LibraryProjectile::named(row[1]).unwrap();
        let scene::BodyShape::Bullet(bullet) = projectile.shape else { panic!("{} is no bullet", row[1]) };
        let [speed, depth]: [f64; 2] = [2, 6].map(|column| row[column].parse().unwrap());
        let (inertia, area) = (0.5 * 1030.0 * drag, std::f64::consts::PI * bullet.radius.powi(2));
        inertia * speed * speed / (2.0 * inertia * area * depth / projectile.mass).exp_m1()
    };
    recovered.map(resistance).collect()
}

/// The laws have the drag of a sphere with an open cavity, 0.30 to 0.37 (May 1975), and resistances of recovered bullets, to
/// whose depths the gel is fitted as well: a check of consistency.
#[test]
fn the_beginning_of_the_calibration_shot_is_within_the_laws_of_other_shots() {
    let scene = shot(&[]);
    let mass = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap().frame().mass;
    let done = run(&scene, 3, 1);
    let seen = done.observe();
    assert!(seen.cost.remeshes > 5, "{} meshes", seen.cost.remeshes);
    assert!(seen.energy.energy_error < 1e-10 && seen.momentum_error < 1e-11, "{:?}", seen.energy);
    let depth = 1e3 * seen.projectile().depth;
    let found = resistances_of_recovered_bullets(0.30);
    let (softest, hardest) = found.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), own| (a.min(*own), b.max(*own)));
    assert_eq!((found.len(), (softest / 1e4).round(), (hardest / 1e4).round()), (7, 132.0, 247.0), "{found:?}");
    let [least, most] = [nose_by_law(0.37, hardest), nose_by_law(0.30, softest)];
    // The laws leave out the slam at the entry, whose drag is up to 1: an estimate is 1 to 2 % of the way.
    assert!((0.98 * least..most).contains(&depth), "{depth} mm, not {least} to {most} mm");
    // As first computed in these cells; a dashpot that bears twice as much takes 0.50 mm.
    assert!((depth - 23.36).abs() < 0.1, "{depth} mm");
    let whole = done.frame().mass + seen.cost.eroded_mass;
    assert!((whole / mass - 1.0).abs() < 1e-12, "mass {:e}", whole / mass - 1.0);
    let lost = seen.energy.viscous + seen.energy.bulk_viscous + seen.energy.damage;
    assert!(
        seen.energy.viscous < -0.2 * seen.energy.initial && seen.energy.viscous < 0.8 * lost,
        "most of what is lost is lost to the dashpots: {:?}",
        seen.energy
    );
}

/// Nine tenths of the defect is gel pushed out of the ball where facets are chords in it, and it scatters with their
/// places: 2.7e-3 to 5.4e-3 on cells of R/4 within 0.05 m/s, mean 4.4e-3; 1e-3 on R/8.
#[test]
fn the_energy_defect_of_the_calibration_shot_is_small() {
    let speeds = [179.79, 179.80, 179.81, 179.82, 179.83];
    let defects = speeds.map(|speed| {
        let scene = shot(&[&format!("projectile.velocity=[0.0, 0.0, -{speed}]")]);
        run(&scene, 3, 1).observe().energy.energy_defect
    });
    let mean = defects.iter().sum::<f64>() / defects.len() as f64;
    assert!(mean < 5e-3, "defects {defects:?}");
}

#[test]
fn bits_of_a_gel_that_is_damaged_do_not_depend_on_communication_steps_threads_or_where_a_shot_is_taken_up_again() {
    let scene = shot(&["scene.end_time=6e-5"]);
    let whole = run(&scene, 1, 1);
    let seen = whole.observe();
    assert!(
        seen.cost.remeshes > 2 && seen.energy.damage < 0.0 && seen.energy.energy_error < 1e-10,
        "{:?}",
        seen.energy
    );
    assert_eq!(run(&scene, 7, 3).digest(), whole.digest());
    let half = {
        let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
        let inputs = simulation.inputs();
        simulation.step(&inputs, 3.3e-5).unwrap();
        let mut bytes = vec![];
        simulation.save().write(&mut |run| bytes.extend_from_slice(run));
        bytes
    };
    let mut other = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
    let mut saved = SavedSimulation::empty();
    assert!(saved.read(&half));
    other.restore(&saved).unwrap();
    let inputs = other.inputs();
    other.step(&inputs, scene.scene.end_time).unwrap();
    assert_eq!(other.digest(), whole.digest());
}

/// A cavity without air that collapses behind a ball of 720 m/s, on coarse cells, remade at set times: distortion alone ends
/// no mesh then on some last digits.
fn collapsing_cavity(speed: f64) -> Scene {
    let projectile = format!("projectile.velocity=[0, 0, {:?}]", -speed);
    let changes = [
        &projectile,
        "gel.cavity={ sealed = { pressure = 0.0 } }",
        "mesh.size=0.85e-3",
        "mesh.tree.slope=0.42",
        "remesh.smallest=0.42e-3",
        "remesh.growth=0.42",
        // A network that draws the cavity together, beside a branch that flows at any rate.
        "gel.shear_modulus=0.12e6",
        "gel.branches=[{ shear_modulus = 4.8e6, power_law = { stress = 600.0, exponent = 0.8 } }]",
        "scene.end_time=3.0e-3",
        "remesh.times=[2.7e-3, 2.8e-3, 2.9e-3]",
    ];
    let changes: Vec<Override> = changes.iter().map(|change| change.parse().unwrap()).collect();
    scene::read(&scene::resolve(scene::builtin("sphere-720").unwrap(), &changes).unwrap()).unwrap()
}

/// Steps until the gel has met itself, 50 µs before the last remeshing at the latest; returns the state before that step.
fn meet_itself(simulation: &mut Simulation) -> Option<SavedSimulation> {
    let inputs = simulation.inputs();
    for step in 1..=57 {
        let before = simulation.save();
        simulation.step(&inputs, f64::from(step) * 5e-5).unwrap();
        if simulation.observe().energy.self_contact < 0.0 {
            return Some(before);
        }
    }
    None
}

/// In one of four such shots the walls of the cavity meet: in which, depends on last digits.
#[test]
fn a_cavity_that_collapses_while_its_mesh_is_remade_meets_itself() {
    let speeds = (0..16).map(|k| 720.0 + 0.01 * f64::from(k));
    let met = speeds.map(collapsing_cavity).find_map(|scene| {
        let mut whole = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
        meet_itself(&mut whole).map(|open| (scene, whole, open))
    });
    let (scene, mut whole, open) = met.expect("a shot whose cavity meets itself");
    let (inputs, n_open) = (whole.inputs(), whole.remeshings().len());
    whole.step(&inputs, scene.scene.end_time).unwrap();
    let seen = whole.observe();
    assert!(seen.energy.self_contact < 0.0 && whole.remeshings().len() > n_open, "{:?}", seen.energy);
    assert!(seen.energy.energy_error < 1e-10 && seen.momentum_error < 1e-11, "{:?}", seen.energy);
    let mut other = Simulation::new(&scene, CouplingMode::Integrated, 2).unwrap();
    other.restore(&open).unwrap();
    other.step(&inputs, 2.95e-3).unwrap();
    other.step(&inputs, scene.scene.end_time).unwrap();
    assert_eq!(other.digest(), whole.digest());
}

/// The first of some shots in which an immersed mesh is refused: in which, depends on last digits. Local operations
/// are refused in none of them.
fn shot_with_a_refusal() -> Scene {
    let speeds = [180, 300, 450, 600, 900, 1200].into_iter();
    let of = |speed: u32| {
        let velocity = format!("projectile.velocity=[0.0,0.0,-{speed}.0]");
        let end = format!("scene.end_time={:e}", 0.0216 / f64::from(speed));
        shot(&[&end, "scene.communication_step=1e-6", "remesh.quality=0.5", "remesh.method=immersed", &velocity])
    };
    speeds
        .map(of)
        .find(|scene| !run(scene, 1, 1).failed_remeshings().is_empty())
        .expect("a shot that makes a rough crater")
}

#[test]
fn a_run_is_taken_up_again_after_a_remeshing_that_was_refused() {
    let scene = shot_with_a_refusal();
    let mut on = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
    let inputs = on.inputs();
    let (mut states, mut kept) = (vec![], vec![]);
    for step in 1..=600 {
        // What an interval without another mesh changes is the doing of the old one, in other patches.
        let before = (on.remeshings().len(), on.failed_remeshings().len(), on.observe().energy.remesh_net());
        on.step(&inputs, scene.scene.end_time * f64::from(step) / 600.0).unwrap();
        let energy = on.observe().energy;
        if on.remeshings().len() == before.0 && on.failed_remeshings().len() > before.1 {
            kept.push((energy.remesh_net() - before.2) / energy.initial);
        }
        // The first state after the old mesh went on, whose dashpots have flowed already.
        if states.is_empty() && !on.failed_remeshings().is_empty() {
            let mut bytes = vec![];
            on.save().write(&mut |run| bytes.extend_from_slice(run));
            states.push(bytes);
        }
    }
    let mut saved = SavedSimulation::empty();
    assert!(saved.read(states.first().expect("a remeshing that is refused")));
    let mut other = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
    other.restore(&saved).unwrap();
    other.step(&inputs, scene.scene.end_time).unwrap();
    assert_eq!(other.digest(), on.digest());
    // Patches that are paired anew must not see how their elements differ: 0.25 and 0.04 % when they did.
    assert!(!kept.is_empty() && kept.iter().all(|part: &f64| part.abs() < 3e-4), "{kept:?}");
}

/// The first 36 µs of the calibration shot in space, in a small block.
const IN_SPACE: [&str; 5] = [
    "scene.end_time=3.6e-5",
    "gel.shape.block.size=[0.0256, 0.0256, 0.0128]",
    "mesh.tree.coarsest=8",
    "mesh.size=0.8e-3",
    "remesh.smallest=0.4e-3",
];

#[test]
fn a_shot_that_no_mesh_can_follow_says_why_none_was_taken() {
    // Many times the speed of the wave, into gel that is hardly thicker than the ball: the run ends within two microseconds. Whether a mesh is
    // taken to the last, and something else ends the run, depends on last digits.
    let is_told = |height: &str| {
        let gel = format!("gel.shape.cylinder={{radius=0.005,height={height}}}");
        let velocity = "projectile.velocity=[0.0,0.0,-10000.0]";
        let scene = shot(&[&gel, velocity, "mesh.tree.coarsest=4", "remesh.method=immersed", "gel.self_contact=off"]);
        let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
        assert_eq!(simulation.diagnosis(), None);
        let failure = simulation.step(&simulation.inputs(), scene.scene.end_time).unwrap_err();
        let diagnosis = simulation.diagnosis().unwrap();
        let why = diagnosis.strip_prefix(&failure.to_string()).unwrap();
        if why.is_empty() {
            return false;
        }
        let reasons = &simulation.failed_remeshings().last().unwrap().why;
        let named = reasons.iter().all(|reason| why.contains(&reason.to_string()));
        assert!(why.starts_with(". No new mesh was accepted at ") && !reasons.is_empty() && named, "{why}");
        true
    };
    assert!(["0.005", "0.006", "0.004", "0.010"].into_iter().any(is_told), "in one of these gels no mesh is taken");
}

/// Where facets smaller than all others about the axis leaked, the first of these runs stopped at 18 us and the second, the calibration shot
/// as a draft, at 1.1 ms.
#[test]
fn a_facet_that_leaks_ends_its_mesh_and_not_the_run() {
    let graded = ["scene.end_time=3e-5", "mesh.tree.slope=0.225", "remesh.growth=0.15"];
    let draft = ["mesh.size=1.08e-3", "mesh.tree.slope=0.6", "remesh.smallest=0.54e-3", "remesh.growth=0.4"];
    for changes in [&graded[..], &draft[..]] {
        let changes: Vec<Override> = changes.iter().map(|change| change.parse().unwrap()).collect();
        let scene = scene::read(&scene::resolve(scene::builtin("fbi-bb").unwrap(), &changes).unwrap()).unwrap();
        let (whole, mut again) = (run(&scene, 1, 1), Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap());
        let seen = whole.observe();
        assert!(seen.energy.energy_error < 1e-10 && seen.momentum_error < 1e-11, "{:?}", seen.energy);
        assert!(seen.energy.energy_defect < 0.12, "{:?}", seen.energy);
        for step in 1..=300 {
            let mut other = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
            other.restore(&again.save()).unwrap();
            again = other;
            again.step(&again.inputs(), scene.scene.end_time * f64::from(step) / 300.0).unwrap();
        }
        assert_eq!(again.digest(), whole.digest());
    }
}

/// This run stopped, at a step that collapsed in a young mesh.
#[test]
fn erosion_of_a_two_network_gel_conserves_mass_momentum_and_energy() {
    let scene = shot(&["projectile.velocity=[0.0,0.0,-2000.0]"]);
    let mass = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap().frame().mass;
    let done = run(&scene, 3, 2);
    let seen = done.observe();
    assert!(seen.energy.energy_error < 1e-10 && seen.momentum_error < 1e-11, "{:?}", seen.energy);
    let kept = (done.frame().mass + seen.cost.eroded_mass) / mass;
    assert!((kept - 1.0).abs() < 1e-12, "mass {:e}", kept - 1.0);
    assert_eq!(run(&scene, 1, 1).digest(), done.digest());
}

#[test]
fn a_gel_of_two_networks_in_space_keeps_its_books_over_remeshings_and_its_bits_on_more_threads() {
    let changes: Vec<Override> = IN_SPACE.iter().map(|change| change.parse().unwrap()).collect();
    let scene = scene::read(&scene::resolve(scene::builtin("fbi-bb-3d").unwrap(), &changes).unwrap()).unwrap();
    let mass = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap().frame().mass;
    let whole = 1030.0 * 0.0256 * 0.0256 * 0.0128;
    assert!((mass / whole - 1.0).abs() < 1e-12, "a quarter stands for all of the block: {mass} kg");
    let done = run(&scene, 3, 1);
    let seen = done.observe();
    assert!(seen.cost.remeshes > 3 && done.failed_remeshings().is_empty(), "{} meshes", seen.cost.remeshes);
    assert!(seen.energy.energy_error < 1e-10 && seen.momentum_error < 1e-12, "{:?}", seen.energy);
    assert!(seen.energy.energy_defect < 0.01, "defect {}", seen.energy.energy_defect);
    let taken = seen.energy.remesh_net() / seen.energy.initial;
    assert!(taken.abs() < 1e-4, "{taken}");
    assert!(seen.energy.viscous < 0.0 && seen.energy.damage < 0.0, "{:?}", seen.energy);
    let kept = done.frame().mass + seen.cost.eroded_mass;
    assert!((kept / mass - 1.0).abs() < 1e-12, "mass {:e}", kept / mass - 1.0);
    assert_eq!(run(&scene, 1, 3).digest(), done.digest());
}

#[test]
fn a_shot_into_coarse_cells_that_grow_slowly_leaves_no_node_without_mass() {
    // An element weighed less than nothing after 105 µs: 4 µs later a node had no others beside it, no mesh was taken, and the old one was
    // turned inside out.
    let changes = ["mesh.size=0.55e-3", "remesh.smallest=0.275e-3", "remesh.growth=0.25", "scene.end_time=1.2e-4"];
    let changes: Vec<Override> = changes.iter().map(|change| change.parse().unwrap()).collect();
    let scene = scene::read(&scene::resolve(scene::builtin("fbi-bb").unwrap(), &changes).unwrap()).unwrap();
    let done = run(&scene, 1, 1);
    let is_massless = |why: &RemeshRefusal| matches!(why, RemeshRefusal::Massless { .. });
    assert!(
        !done.failed_remeshings().iter().flat_map(|refusal| &refusal.why).any(is_massless),
        "{:?}",
        done.failed_remeshings()
    );
    assert!(done.observe().cost.remeshes > 16);
}

#[test]
fn a_ball_is_not_pushed_on_by_what_is_made_inside_of_it() {
    let later = ["scene.end_time=3e-5"];
    let changes: Vec<Override> = IN_SPACE[1..].iter().chain(&later).map(|change| change.parse().unwrap()).collect();
    let scene = scene::read(&scene::resolve(scene::builtin("fbi-bb-3d").unwrap(), &changes).unwrap()).unwrap();
    let done = run(&scene, 1, 1);
    let energy = done.observe().energy;
    let pumped = energy.contact_bias / energy.initial;
    // 0.0067 with facets that are held no sooner than 0.3 of a size deep.
    assert!(pumped < 0.002, "{pumped}");
}

/// How deep the ball of `sphere-block` goes, m, with so much of the block computed.
fn deepest(symmetry: &str) -> f64 {
    let keys = ["scene.end_time=5e-3".to_owned(), format!("gel.symmetry={symmetry}")];
    let changes: Vec<Override> = keys.iter().map(|key| key.parse().unwrap()).collect();
    let scene = scene::read(&scene::resolve(scene::builtin("sphere-block").unwrap(), &changes).unwrap()).unwrap();
    let done = run(&scene, 1, 1);
    let seen = done.observe();
    assert!(seen.energy.energy_error < 1e-10 && seen.momentum_error < 1e-12, "{symmetry}: {:?}", seen.energy);
    let across = seen.projectile().kinematics.velocity;
    assert!(symmetry == "none" || across.y == 0.0, "{symmetry}");
    assert!(symmetry != "quarter" || across.x == 0.0, "{symmetry}");
    seen.projectile().contact.peak_depth.0
}

#[test]
fn a_half_and_a_quarter_of_a_block_stop_a_ball_as_all_of_it() {
    let [whole, half, quarter] = ["none", "half", "quarter"].map(deepest);
    println!("{whole} {half} {quarter}");
    // Tetrahedra of a centred lattice reach across a plane of symmetry, or end at it: 14.17 and 14.38 mm on cells of 5 mm, 14.41 and
    // 14.47 mm on those of 2.5 mm.
    assert!((half - whole).abs() < 0.02 * whole, "{half} {whole}");
    assert!((quarter - whole).abs() < 0.02 * whole, "{quarter} {whole}");
}
