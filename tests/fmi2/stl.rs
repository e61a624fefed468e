//! An instance whose body is in a file, and its state where that file is another or missing.

use super::host::{ERROR, Host, OK, Resources, coarse};
use super::solids::{binary, sphere};

fn scene() -> String {
    let shape = "shape.stl = { file = \"ball.stl\", scale = 1e-3 }";
    // Finer than the radius of the greatest ball inside the triangles.
    let text = coarse().replace("size = 10e-3", "size = 8e-3").replace("shape.sphere.radius = 0.010", shape);
    assert!(text.contains(shape));
    text
}

/// An instance with the scene and, beside it, a ball of so many rings.
fn with_ball(rings: usize) -> Host {
    Host::of(Resources::packed(&scene(), &[("ball.stl", &binary(&sphere(10.0, rings)))]))
}

#[test]
fn a_state_goes_on_where_the_same_file_is_and_is_refused_where_it_is_another_or_missing() {
    let mut host = with_ball(8);
    host.start();
    host.steps(0.0, 1e-4, 3);
    let bytes = host.bytes();
    let mut same = with_ball(8);
    assert_eq!(same.restore(&bytes), OK, "{:?}", same.lines());
    host.steps(3e-4, 1e-4, 3);
    same.steps(3e-4, 1e-4, 3);
    assert_eq!(same.bytes(), host.bytes());
    let refused = |mut other: Host, reason: &str| {
        assert_eq!(other.restore(&bytes), ERROR);
        let lines = other.lines();
        assert!(lines.iter().any(|(_, _, line)| line.contains(reason)), "{lines:?}");
    };
    refused(with_ball(9), "another file of the scene");
    refused(Host::with(&scene()), "ball.stl: found no entry for it in manifest.json");
}

#[test]
fn the_file_of_another_scene_is_in_the_folder_of_that_scene() {
    let there = with_ball(8);
    let mut host = Host::with(&coarse());
    assert_eq!(host.set_text("scene", &there.path("scene.toml")), OK);
    host.start();
    host.steps(0.0, 1e-4, 3);
    let mut own = with_ball(8);
    own.start();
    own.steps(0.0, 1e-4, 3);
    assert_eq!(host.digest(), own.digest());
    let mut other = Host::with("this is no scene");
    let bytes = host.bytes();
    assert_eq!(other.restore(&bytes), OK, "{:?}", other.lines());
    assert_eq!(other.digest(), host.digest());
}
