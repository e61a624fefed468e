//! The knob of accuracy.

use super::host::{ERROR, Host, OK};
use ballistic_gel::fmi2::abi::fmi2ExitInitializationMode;
use ballistic_gel::scene;

/// Elements of `sphere-block` at a level, or with none set.
fn elements(level: Option<i32>) -> i32 {
    elements_of(scene::builtin("sphere-block").unwrap(), level)
}

fn elements_of(text: &str, level: Option<i32>) -> i32 {
    let mut host = Host::with(text);
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
fn a_level_takes_effect_in_a_scene_that_was_packed_with_another_mesh() {
    let finer = ["mesh.size=4e-3".parse().unwrap()];
    let text = scene::rebase_scene(scene::builtin("sphere-block").unwrap(), &finer).unwrap();
    let [packed, standard, draft] = [None, Some(2), Some(0)].map(|level| elements_of(&text, level));
    assert!(packed == standard && packed > elements(None) && draft == elements(Some(0)), "{packed} {standard} {draft}");
}

#[test]
fn a_level_that_a_packed_override_left_nothing_of_is_refused_in_words() {
    let finer = ["mesh.size=4e-3".parse().unwrap()];
    let text = scene::resolve(scene::builtin("sphere-block").unwrap(), &finer).unwrap();
    let mut host = Host::with(&text);
    assert_eq!(host.set_integer("fidelity", 0), OK);
    host.enter();
    // SAFETY: a live component.
    assert_eq!(unsafe { fmi2ExitInitializationMode(host.c) }, ERROR);
    let line = host.one_line();
    assert!(line.contains("scene.fidelity: found \"draft\", which sets nothing"), "{line}");
}

#[test]
fn there_are_five_levels_and_the_reduced_model() {
    let mut host = Host::with(scene::builtin("sphere-block").unwrap());
    for (level, status) in [(-1, ERROR), (0, OK), (5, OK), (6, ERROR)] {
        assert_eq!(host.set_integer("fidelity", level), status, "{level}");
    }
}
