//! `gelfmu check`.

use super::{folder, gelfmu, gelfmu_in, json};
use crate::lines::joined;
use crate::terminal::assert_narrow;
use ballistic_gel::scene;
use serde_json::Value;

#[test]
fn check_says_what_a_scene_models_and_what_is_switched_off() {
    for (name, text) in scene::builtins() {
        let scene = scene::read(text).unwrap();
        let said = gelfmu(&["check", name]);
        assert_eq!((said.status, said.err.as_str()), (Some(0), ""), "{name}");
        assert_narrow(&said.out);
        let told = joined(&said.out);
        for line in scene::modelled_physics(&scene).iter().chain(&scene::switched_off(&scene)) {
            assert!(told.contains(line), "{name}: {line}");
        }
        let value = json(&gelfmu(&["check", name, "--json"]).out);
        assert_eq!((&value["scene"], &value["valid"]), (&Value::from(name), &Value::from(true)));
        assert_eq!(value["switched_off"].as_array().map(Vec::len), Some(scene::switched_off(&scene).len()));
    }
}

#[test]
fn check_takes_overrides_and_refuses_what_cannot_be_built() {
    let size = "--set=mesh.size=4e-4";
    let said = gelfmu(&["check", "ball-square", size]);
    assert_narrow(&said.out);
    assert!(said.out.ends_with("Run it with:\n    gelfmu run ball-square --set mesh.size=4e-4\n"), "{}", said.out);
    let elements = |more: &[&str]| {
        let value = json(&gelfmu(&[&["check", "ball-square", "--json"], more].concat()).out);
        value["elements"].as_u64().expect("a number of elements")
    };
    assert!(elements(&[size]) > elements(&[]));
    for command in [&["check"][..], &["run", "--direct"]] {
        let folder = folder();
        let said = gelfmu_in(folder.path(), &[command, &["sphere-block", "--set", "mesh.size=1e-5"]].concat());
        assert_eq!(said.status, Some(2), "{}", said.err);
        assert!(said.err.contains("mesh.size: the mesh would have about "), "{}", said.err);
        let left = folder.path().join("gelfmu-out/sphere-block");
        assert!(!left.exists(), "a run that has not begun leaves nothing");
    }
}

#[test]
fn check_describes_each_body_with_its_inertia_and_extent() {
    let set = "--set=projectile.orientation=[0.8, 0.6, 0.0, 0.0]";
    let capsule = "--set=projectile.shape={ capsule = { radius = 0.008, length = 0.032 } }";
    let value = json(&gelfmu(&["check", "sphere-block", "--json", capsule, set]).out);
    let body = &value["bodies"][0];
    assert_eq!((value["bodies"].as_array().map(Vec::len), &body["fixed"]), (Some(1), &Value::from(false)));
    assert!(body["mass"].as_f64() > Some(0.0) && body["inertia"][0].as_f64() > body["inertia"][2].as_f64(), "{body}");
    // Turned about x by 2 acos(0.8): the axis has the cosine 0.28 to the vertical and 0.96 to y.
    for (end, sign) in [("min", -1.0), ("max", 1.0)] {
        for (axis, reach) in [1.0, 1.96, 1.28].into_iter().enumerate() {
            let found = body["extent"][end][axis].as_f64().expect("a number");
            assert!((found - sign * 0.008 * reach).abs() < 1e-15, "{end} {axis}: {found}");
        }
    }
}
