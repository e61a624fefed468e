//! Short forms of the studies of leaks, impacts and extremes: whatever hits the gel wherever, nothing slips through, nothing
//! is lost that is not booked, and what the first touch takes is known before.

#[path = "../../studies/src/rest.rs"]
#[allow(dead_code, reason = "the study prints more")]
mod rest;
#[path = "../../studies/src/run.rs"]
#[allow(dead_code, reason = "the studies tell the time")]
mod run;
#[path = "../../studies/src/shot.rs"]
#[allow(dead_code, reason = "the study lands everywhere")]
mod shot;
#[path = "../../studies/src/touch.rs"]
#[allow(dead_code, reason = "the study prints more")]
mod touch;
#[path = "../../studies/src/whole.rs"]
mod whole;

use crate::deepest;
use ballistic_gel::scene::{self, Scene};
use ballistic_gel::simulation::{CouplingMode, Simulation};
use deepest::deepest;
use rest::Rest;
use run::{Run, run};
use shot::{RADIUS, Space, shot};
use touch::Touch;
use whole::Whole;

/// A body on cells of edge `h`, m, that lands `at` so many cells from the middle, at 5 m/s.
fn slow(name: &str, h: f64, at: [f64; 2]) -> Scene {
    let keys = [
        ("mesh.size", format!("{h:e}")),
        ("mesh.grading", format!("{{core={:e}, growth=1.5, largest=0.01}}", 1.5 * RADIUS)),
        ("scene.end_time", "5e-3".to_owned()),
    ];
    shot((Space::Spatial, name), at.map(|x| x * h), &keys)
}

/// Runs to the end without a leak; the depth of the deepest point of the surface and the defect of energy.
fn shoot(scene: &Scene) -> (f64, f64) {
    let mut surface: f64 = 0.0;
    let Run { last, failure, .. } = run(scene, 20, |now| surface = surface.max(deepest(&now.frame(), scene, 6)));
    assert_eq!(failure, None);
    assert!(last.energy.energy_error < 1e-10 && last.projectile().contact.total_impulse.z > 0.01, "{last:?}");
    (surface, last.energy.energy_defect)
}

/// Held by one facet at a time, a tip in a crease slid down each in turn; the removal of its depth made a quarter of the
/// energy of the impact.
#[test]
fn a_point_that_is_sharper_than_the_mesh_neither_leaks_nor_makes_energy() {
    for (name, ratio) in [("cone", 3.0), ("cone", 1.5), ("ogive, sharp", 1.5)] {
        let h = RADIUS / ratio;
        let (surface, defect) = shoot(&slow(name, h, [0.5, 1.0 / 6.0]));
        assert!(surface < 0.3 * h && defect < 4e-3, "{name}: {} cells deep, {defect:e}", surface / h);
    }
}

/// A meplat into which half of a cell just fits was met neither by nodes nor by the middle of a facet.
#[test]
fn an_end_nearly_as_sharp_as_the_mesh_does_not_leak_wherever_it_lands() {
    for at in [[0.5, 1.0 / 6.0], [0.5, 0.0], [0.2, 0.6]] {
        let (surface, defect) = shoot(&slow("ogive, meplat", 5e-3, at));
        assert!(surface < 0.3 * 5e-3 && defect < 2.5e-3, "{at:?}: {surface} m deep, {defect:e}");
    }
}

#[test]
fn a_ball_as_small_as_a_cell_does_not_slip_between_nodes() {
    for ratio in [1.0, 1.5, 2.0] {
        for at in [[0.0, 0.0], [0.5, 1.0 / 6.0], [0.5, 0.0]] {
            let h = RADIUS / ratio;
            let (surface, _) = shoot(&slow("sphere", h, at));
            // Facets are stopped at 0.3 of their size, 0.7 to 0.8 of a cell.
            assert!(surface < 0.28 * h, "{ratio}, {at:?}: {} cells deep", surface / h);
        }
    }
}

/// Summed afresh from masses and velocities, not read from the books.
#[test]
fn gel_and_body_together_keep_momentum_and_angular_momentum() {
    for body in ["cylinder on its rim, rounded", "ogive, meplat"] {
        let keys = [
            ("gel.supports.z_min", "free".to_owned()),
            ("projectile.velocity", "[3.0, 1.0, -4.0]".to_owned()),
            ("projectile.angular_velocity", "[150.0, -80.0, 600.0]".to_owned()),
            ("contact.friction", "0.3".to_owned()),
            ("scene.end_time", "4e-3".to_owned()),
        ];
        let scene = shot((Space::Spatial, body), [0.011, -0.017], &keys);
        let begun = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
        let whole = Whole::of(&begun, scene.gel.density);
        let start = whole.momenta(&begun.frame());
        let Run { last, failure, .. } = run(&scene, 4, |now| {
            let (linear, angular) = whole.momenta(&now.frame()).drift(&start);
            assert!(linear < 1e-12 && angular < 1e-12, "{body}: {linear:e}, {angular:e}");
        });
        assert_eq!(failure, None);
        assert!(last.momentum_error < 1e-12 && last.angular_momentum_error < 1e-12);
        assert!(last.energy.energy_error < 1e-10 && last.energy.friction < 0.0, "{:?}", last.energy);
    }
}

#[test]
fn a_single_node_is_struck_as_two_bodies_are() {
    for e in [0.0, 0.5, 1.0] {
        for body in ["sphere", "capsule, tilted", "ogive, meplat"] {
            let touch = Touch::of(&touch::single_scene(body, e));
            let struck = touch.struck();
            assert_eq!(struck.len(), 1, "{body}");
            let [was, now] = touch.relative(struck[0], &touch::normal(&touch, struck[0]));
            assert!((now / was + e).abs() < 1e-9, "{body}, {e}: {was} to {now} m/s");
            let [before, after] = [&touch.before, &touch.after];
            let lost = touch.whole.kinetic_energy(before) - touch.whole.kinetic_energy(after);
            let wrong = lost - touch::predicted(&touch, struck[0], e);
            assert!(wrong.abs() < 1e-12 * touch.whole.kinetic_energy(before), "{body}, {e}: {wrong:e} J");
        }
    }
}

#[test]
fn a_flat_punch_loses_half_of_its_reduced_mass_times_the_square_of_its_speed() {
    for (ratio, e) in [(0.01, 0.0), (0.01, 0.5), (0.1, 0.0), (1.0, 0.5), (100.0, 0.0), (100.0, 0.5), (1e4, 0.0)] {
        let punch = touch::Punch::of(ratio, e);
        assert!((punch.loss / punch.predicted - 1.0).abs() < 1e-6, "{ratio}, {e}: {} J", punch.loss);
        assert!(punch.nodes > 10 && punch.restitution < 1e-6, "{}, {:e}", punch.nodes, punch.restitution);
    }
}

#[test]
fn bodies_a_hundred_times_lighter_and_a_million_times_heavier_than_a_node_lose_what_is_predicted() {
    let scene = |mass: f64| shot((Space::Spatial, "sphere"), [0.0; 2], &[("projectile.mass", format!("{mass:e}"))]);
    let probe = Touch::of(&scene(1.0));
    let node = probe.whole.nodes[probe.struck()[0]];
    for ratio in [1e-2, 1.0, 1e2, 1e6] {
        let touch = Touch::of(&scene(ratio * node));
        let part = touch.loss / touch.whole.kinetic_energy(&touch.before);
        assert!((part * (1.0 + ratio) - 1.0).abs() < 1e-8, "{ratio}: {part}");
    }
}

#[test]
fn a_crawl_rebounds_and_three_hundred_metres_per_second_end_with_a_diagnosis() {
    let at_speed = |speed: f64, end: f64| {
        let keys = [
            ("projectile.velocity", format!("[0.0, 0.0, {:e}]", -speed)),
            ("scene.end_time", end.to_string()),
            ("mesh.size", "1e-2".to_owned()),
        ];
        run(&shot((Space::Spatial, "sphere"), [0.0; 2], &keys), 1, |_| {})
    };
    let crawl = at_speed(0.01, 0.06);
    assert_eq!(crawl.failure, None);
    assert!((crawl.last.projectile().kinematics.velocity.z / 0.01 - 1.0).abs() < 0.1, "{:?}", crawl.last.projectile());
    let shock = at_speed(300.0, 0.01);
    let message = shock.failure.unwrap();
    assert!(message.contains("is inverted at") && message.contains("mesh.size"), "{message}");
    assert!(shock.last.energy.energy_error < 1e-10 && shock.last.momentum_error < 1e-12);
}

#[test]
fn a_body_that_starts_inside_the_gel_is_refused_with_its_depth() {
    let change = "projectile.position=[0.0, 0.0, 0.008]".parse().unwrap();
    let text = scene::resolve(scene::builtin("sphere-block").unwrap(), &[change]).unwrap();
    let message = scene::read(&text).unwrap_err().to_string();
    assert!(message.contains("projectile.position: found [0.0, 0.0, 0.008]"), "{message}");
    assert!(message.contains("2.000e-3 m deep in the gel") && message.contains("expected"), "{message}");
}

/// A second of rest under a constant force: the noise of the force stays as it is, and so do depth and books. There is no
/// damping: what the growing force has set in motion swings on.
#[test]
fn a_body_at_rest_on_the_gel_does_not_chatter() {
    let Rest { noise, swing, depth, energy: [before, after], .. } = rest::press(&rest::CASES[1]);
    assert!(noise[1] < 1.2 * noise[0] && swing[1] < 1.2 * swing[0] && swing[1] < 0.02, "{noise:?}, {swing:?}");
    assert!((depth[1] / depth[0] - 1.0).abs() < 0.01, "{depth:?} m");
    let drift = [after.contact - before.contact, after.contact_bias, after.integration - before.integration];
    assert!(drift.iter().all(|drift| drift.abs() < 1e-3 * after.elastic), "{drift:?} of {} J", after.elastic);
}
