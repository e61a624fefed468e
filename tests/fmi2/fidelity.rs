//! The knob of accuracy.

use super::host::{ERROR, Host, OK};
use ballistic_gel::scene;

/// Elements of `sphere-block` at a level, or with none set.
fn elements(level: Option<i32>) -> i32 {
    let mut host = Host::with(scene::builtin("sphere-block").unwrap());
    if let Some(level) = level {
        assert_eq!(host.set_integer("fidelity", level), OK);
    }
    host.start();
    host.integer("cost.elements")
}

#[test]
fn a_level_makes_the_mesh_that_the_scene_says() {
    let [none, draft, standard] = [None, Some(0), Some(2)].map(elements);
    assert!(draft < standard && standard == none, "{draft} {standard} {none}");
}

#[test]
fn there_are_five_levels() {
    let mut host = Host::with(scene::builtin("sphere-block").unwrap());
    for (level, status) in [(-1, ERROR), (0, OK), (4, OK), (5, ERROR)] {
        assert_eq!(host.set_integer("fidelity", level), status, "{level}");
    }
}
