//! Cavity behind the projectile as outputs: nothing before the ball is inside, and the same after a restored state.

use super::host::Host;
use ballistic_gel::scene::{self, Override};

/// The ball of the calibration shot in a small gel, on cells of R/3.
fn shot() -> Host {
    let changes = [
        "scene.end_time=1e-3",
        "gel.shape={cylinder={radius=0.03,height=0.03}}",
        "mesh.size=7e-4",
        "remesh.smallest=3.5e-4",
    ];
    let changes: Vec<Override> = changes.iter().map(|change| change.parse().unwrap()).collect();
    Host::with(&scene::resolve(scene::builtin("fbi-bb").unwrap(), &changes).unwrap())
}

fn cavity(host: &mut Host) -> [f64; 2] {
    ["cavity.diameter", "cavity.depth"].map(|name| host.get(name))
}

#[test]
fn the_cavity_is_told_once_the_ball_is_inside_and_belongs_to_the_state() {
    let mut host = shot();
    host.start();
    assert_eq!(cavity(&mut host), [0.0; 2]);
    host.steps(0.0, 1e-5, 20);
    let depth = host.get("projectile.depth");
    assert!(depth > 0.02, "{depth} m");
    let before = cavity(&mut host);
    // Wider than the ball, below one diameter and above the rear of the ball.
    assert!(before[0] > 4.37e-3 && before[0] < 20e-3, "{before:?}");
    assert!(before[1] > 4.37e-3 && before[1] < depth - 4.37e-3, "{before:?}, {depth} m");
    let bytes = host.bytes();
    host.steps(2e-4, 1e-5, 10);
    assert_ne!(cavity(&mut host), before);
    host.restore(&bytes);
    assert_eq!(cavity(&mut host), before);
}

#[test]
fn a_scene_without_a_cavity_has_none() {
    let mut host = Host::with(&super::host::coarse());
    host.start();
    host.steps(0.0, 1e-4, 20);
    assert_eq!(cavity(&mut host), [0.0; 2]);
}
