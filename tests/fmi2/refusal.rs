//! Bad arguments: the right status, one clear line, and an instance that is as it was.

use super::host::{DISCARD, ERROR, Host, Made, OK, Resources, callbacks, coarse, reference};
use ballistic_gel::fmi2::CallbackFunctions;
use ballistic_gel::fmi2::abi::*;
use std::ffi::c_int;
use std::ptr;

#[test]
fn a_null_component_is_an_error_everywhere() {
    let null = ptr::null_mut();
    unsafe {
        assert_eq!(fmi2DoStep(null, 0.0, 1.0, 0), ERROR);
        assert_eq!(fmi2Reset(null), ERROR);
        assert_eq!(fmi2GetReal(null, ptr::null(), 0, null.cast()), ERROR);
        assert_eq!(fmi2SetFMUstate(null, null), ERROR);
        fmi2FreeInstance(null);
    }
}

#[test]
fn null_arrays_are_named() {
    let mut host = Host::started();
    let (c, vr, mut one) = (host.c, reference("time"), 1.0);
    let (none, real, at) = (ptr::null_mut(), &raw mut one, &raw const vr);
    let calls: [(&str, &dyn Fn() -> c_int); 12] = unsafe {
        [
            ("vr", &|| fmi2GetReal(c, ptr::null(), 1, real)),
            ("value", &|| fmi2GetReal(c, at, 1, ptr::null_mut())),
            ("value", &|| fmi2SetReal(c, at, 1, ptr::null())),
            ("value", &|| fmi2SetString(c, at, 1, &ptr::null())),
            ("categories", &|| fmi2SetDebugLogging(c, 1, 1, ptr::null())),
            ("FMUstate", &|| fmi2GetFMUstate(c, ptr::null_mut())),
            ("FMUstate", &|| fmi2SetFMUstate(c, none)),
            ("FMUstate", &|| fmi2SerializedFMUstateSize(c, none, ptr::null_mut())),
            ("serializedState", &|| fmi2DeSerializeFMUstate(c, ptr::null(), 8, ptr::null_mut())),
            ("vKnown_ref", &|| fmi2GetDirectionalDerivative(c, at, 1, ptr::null(), 1, real, real)),
            ("order", &|| fmi2SetRealInputDerivatives(c, at, 1, ptr::null(), real)),
            ("value", &|| fmi2GetRealStatus(c, 2, ptr::null_mut())),
        ]
    };
    for (k, (argument, call)) in calls.into_iter().enumerate() {
        assert_eq!(call(), ERROR, "call {k}");
        assert!(host.one_line().contains(&format!("argument {argument} is a null pointer")), "call {k}");
    }
}

#[test]
fn unknown_references_and_other_types_are_errors() {
    let mut host = Host::started();
    for unknown in [0, 15, 4_000_000_000, reference("threads"), reference("scene"), reference("contact.active")] {
        let mut value = 7.0;
        assert_eq!(unsafe { fmi2GetReal(host.c, &raw const unknown, 1, &raw mut value) }, ERROR);
        assert!(host.one_line().contains(&format!("value reference {unknown}:")));
        assert_eq!(unsafe { fmi2SetReal(host.c, &raw const unknown, 1, &raw const value) }, ERROR);
        assert_eq!(host.lines().len(), 1);
    }
}

#[test]
fn numbers_that_are_not_finite_are_refused_by_name() {
    let mut host = Host::started();
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(host.set("projectile.external_force[3]", value), ERROR);
        let line = host.one_line();
        assert!(line.starts_with("projectile.external_force[3] = "), "{line}");
    }
    assert_eq!(host.get("projectile.external_force[3]"), 0.0);
}

#[test]
fn bad_steps_are_refused_and_a_good_one_still_works() {
    let mut host = Host::started();
    for (at, h) in [(0.0, 0.0), (0.0, -1e-5), (0.0, f64::NAN), (0.0, f64::INFINITY), (1e-3, 1e-5), (0.0, 0.02)] {
        assert_eq!(unsafe { fmi2DoStep(host.c, at, h, 0) }, ERROR, "step {h} at {at}");
        assert!(host.one_line().contains(" s"), "step {h} at {at}");
    }
    host.steps(0.0, 1e-5, 3);
    assert_eq!(host.get("time"), 2e-5 + 1e-5);
}

#[test]
fn a_bad_experiment_is_refused() {
    let host = Host::with(&coarse());
    unsafe {
        assert_eq!(fmi2SetupExperiment(host.c, 0, 0.0, f64::NAN, 0, 0.0), ERROR);
        assert_eq!(fmi2SetupExperiment(host.c, 0, 0.0, 1.0, 1, 1.0), ERROR);
        assert_eq!(fmi2SetupExperiment(host.c, 0, 0.0, -3.0, 0, 0.0), OK);
    }
}

#[test]
fn a_start_time_that_is_not_zero_changes_no_bit() {
    let mut zero = Host::started();
    let mut late = Host::with(&coarse());
    unsafe {
        assert_eq!(fmi2SetupExperiment(late.c, 0, 0.0, -0.25, 0, 0.0), OK);
        assert_eq!(fmi2EnterInitializationMode(late.c), OK);
        assert_eq!(fmi2ExitInitializationMode(late.c), OK);
    }
    zero.steps(0.0, 0.125 / 128.0, 1);
    late.steps(-0.25, 0.125 / 128.0, 1);
    assert_eq!(zero.digest(), late.digest());
}

#[test]
fn a_step_that_the_start_time_swallows_is_refused_and_a_longer_one_is_taken() {
    let mut host = Host::with(&coarse());
    unsafe {
        assert_eq!(fmi2SetupExperiment(host.c, 0, 0.0, 1e9, 0, 0.0), OK);
        assert_eq!(fmi2EnterInitializationMode(host.c), OK);
        assert_eq!(fmi2ExitInitializationMode(host.c), OK);
        assert_eq!(fmi2DoStep(host.c, 1e9, 1e-8, 0), ERROR);
    }
    let text = host.one_line();
    assert!(text.contains("communicationStepSize") && text.contains("startTime"), "{text}");
    assert_eq!(host.get("time"), 1e9);
}

#[test]
fn instances_that_cannot_be_are_refused_with_a_line() {
    let archive = Resources::packed(&coarse(), &[]);
    let good = archive.arguments();
    let bad = [
        ("fmuGUID", Made { guid: Some(c"{0}"), ..good }),
        ("fmuGUID", Made { guid: None, ..good }),
        ("instanceName", Made { name: Some(c" "), ..good }),
        ("instanceName", Made { name: None, ..good }),
        ("fmuType", Made { fmu_type: 0, ..good }),
        ("fmuResourceLocation: found none", Made { resources: None, ..good }),
        ("not a file URI", Made { resources: Some(c"resources"), ..good }),
        ("/nowhere/manifest.json: found no readable file", Made { resources: Some(c"file:///nowhere"), ..good }),
    ];
    for (word, made) in bad {
        let mut host = Host::made(&made);
        assert!(host.c.is_null(), "{word}");
        let line = host.one_line();
        assert!(line.contains(word), "{word}: {line}");
    }
    let (none, guid): (*const CallbackFunctions, _) = (ptr::null(), archive.guid.as_ptr());
    assert!(unsafe { fmi2Instantiate(c"gel".as_ptr(), 1, guid, archive.uri.as_ptr(), none, 0, 0) }.is_null());
}

#[test]
fn a_scene_that_was_edited_in_the_unpacked_archive_is_refused_with_the_remedy_and_runs_as_another_scene() {
    let archive = Resources::packed(&coarse(), &[]);
    let edited = archive.folder.path().join("scene.toml");
    std::fs::write(&edited, coarse().replace("-5.0]", "-4.0]")).unwrap();
    let mut host = Host::made(&archive.arguments());
    assert!(host.c.is_null());
    let line = host.one_line();
    assert!(line.contains("scene.toml: found content of hash ") && line.contains("gelfmu pack"), "{line}");
    let mut host = Host::with(&coarse());
    assert_eq!(host.set_text("scene", &edited), OK);
    host.start();
    assert_eq!(host.get("projectile.predicted_velocity[3]"), -4.0);
}

#[test]
fn an_archive_is_not_taken_for_another_one() {
    let (one, two) = (Resources::packed(&coarse(), &[]), Resources::packed(&coarse().replace("-5.0]", "-4.0]"), &[]));
    assert_ne!(one.guid, two.guid);
    assert_eq!(one.guid, Resources::packed(&coarse(), &[]).guid);
    let mut host = Host::made(&Made { resources: Some(&two.uri), ..one.arguments() });
    assert!(host.c.is_null());
    let line = host.one_line();
    assert!(line.starts_with("fmuGUID = ") && line.contains("different archives"), "{line}");
}

#[test]
fn the_logger_may_be_absent() {
    let mut callbacks = callbacks(&mut Vec::new());
    callbacks.logger = None;
    let archive = Resources::packed(&coarse(), &[]);
    let (guid, uri) = (archive.guid.as_ptr(), archive.uri.as_ptr());
    unsafe {
        let c = fmi2Instantiate(c"gel".as_ptr(), 1, guid, uri, &raw const callbacks, 0, 1);
        assert!(!c.is_null());
        assert_eq!(fmi2DoStep(c, 0.0, 1.0, 0), ERROR);
        fmi2FreeInstance(c);
    }
}

#[test]
fn a_broken_scene_is_named_by_key_and_line_and_can_be_put_right() {
    let broken = coarse().replace("density = 1030.0", "density = -1.0");
    let line = 1 + broken.lines().position(|l| l.contains("density = -1")).unwrap();
    let mut host = Host::with(&broken);
    host.enter();
    assert_eq!(unsafe { fmi2ExitInitializationMode(host.c) }, ERROR);
    let text = host.one_line();
    assert!(text.contains("gel.density") && text.contains(&format!("line {line}")), "{text}");
    let good = host.path("good.toml");
    std::fs::write(&good, coarse()).unwrap();
    assert_eq!(host.set_text("scene", &good), OK);
    assert_eq!(unsafe { fmi2ExitInitializationMode(host.c) }, OK, "{:?}", host.lines());
}

#[test]
fn a_parameter_that_breaks_the_scene_is_named_and_no_line_is() {
    let mut host = Host::with(&coarse());
    assert_eq!(host.set("gel.density", 0.0), OK);
    assert_eq!(host.set("projectile.mass", 0.04), OK);
    host.enter();
    assert_eq!(unsafe { fmi2ExitInitializationMode(host.c) }, ERROR);
    let text = host.one_line();
    let start = "scene resources/scene.toml with the parameters gel.density = 0.0: gel.density: found 0.0";
    assert!(text.starts_with(start) && !text.contains("line"), "{text}");
    assert_eq!(host.set("gel.density", 1030.0), OK);
    assert_eq!(host.set("projectile.radius", 0.0), OK);
    assert_eq!(unsafe { fmi2ExitInitializationMode(host.c) }, ERROR);
    let text = host.one_line();
    assert!(text.contains("with the parameters projectile.radius = 0.0: ") && !text.contains("line"), "{text}");
}

#[test]
fn a_scene_that_is_not_there_is_named() {
    let mut host = Host::with(&coarse());
    let missing = host.path("100% missing.toml");
    assert_eq!(host.set_text("scene", &missing), OK);
    host.enter();
    let mut value = 0.0;
    let name = reference("projectile.depth");
    assert_eq!(unsafe { fmi2GetReal(host.c, &raw const name, 1, &raw mut value) }, ERROR);
    let text = host.one_line();
    assert!(text.contains("100%% missing.toml") && text.contains("parameter `scene`"), "{text}");
    assert_eq!(host.set_text("scene", std::path::Path::new("relative.toml")), ERROR);
}

#[test]
fn an_output_directory_that_cannot_be_written_is_an_error_before_the_run() {
    let mut host = Host::with(&coarse());
    let file = host.path("scene.toml");
    assert_eq!(host.set_text("output_directory", &file), OK);
    host.enter();
    assert_eq!(unsafe { fmi2ExitInitializationMode(host.c) }, ERROR);
    let text = host.one_line();
    assert!(text.contains("output_directory") && text.contains("scene.toml"), "{text}");
}

#[test]
fn status_questions_are_answered_or_discarded() {
    let mut host = Host::started();
    host.steps(0.0, 1e-5, 1);
    let (mut time, mut flag, mut text) = (0.0, 7, ptr::null());
    unsafe {
        assert_eq!(fmi2GetRealStatus(host.c, 2, &raw mut time), OK);
        assert_eq!(fmi2GetBooleanStatus(host.c, 3, &raw mut flag), OK);
        assert_eq!((time, flag), (1e-5, 0));
        assert_eq!(fmi2GetStatus(host.c, 0, &raw mut flag), DISCARD);
        assert_eq!(fmi2GetIntegerStatus(host.c, 0, &raw mut flag), DISCARD);
        assert_eq!(fmi2GetStringStatus(host.c, 1, &raw mut text), DISCARD);
        assert_eq!(fmi2GetRealStatus(host.c, 0, &raw mut time), DISCARD);
    }
    assert_eq!(host.lines().len(), 4);
}
