//! Bullets that expand, as an importer sees them: an opening that it prescribes, and the parameters of the law.

use super::bodies::step;
use super::host::{ERROR, Host, OK};
use ballistic_gel::fmi2::abi::fmi2ExitInitializationMode;

/// A bullet above a thin block of elastic gel, which opens as the importer prescribes.
const PRESCRIBED: &str = r#"
[scene]
name = "opened"
dimension = "axisymmetric"
end_time = 1e-3
communication_step = 1e-4
[gel]
shape.cylinder = { radius = 0.03, height = 0.02 }
material = "neo-hookean"
density = 1030.0
shear_modulus = 69e3
bulk_modulus = 667e3
[projectile]
shape.bullet = { radius = 6e-3, length = 0.02, nose = "round", edge_radius = 1e-3 }
mass = 0.01
position = [0.0, 0.0, 0.0122]
velocity = [0.0, 0.0, -8.0]
[projectile.expansion]
opened = { radius = 9e-3, length = 0.016, head_length = 7e-3, edge_radius = 5e-3, shank_radius = 6e-3 }
[mesh]
size = 2e-3
"#;

/// Scene of a bullet whose law opens it at once.
fn with_law() -> String {
    PRESCRIBED.replace(
        "shank_radius = 6e-3 }\n",
        "shank_radius = 6e-3 }\nopening_speed = 1.0\nfull_speed = 2.0\npath = 8e-3\n",
    )
}

fn open(host: &mut Host, opening: f64, rate: f64) {
    assert_eq!(host.set("projectile.prescribed_expansion", opening), OK);
    assert_eq!(host.set("projectile.prescribed_expansion_rate", rate), OK);
}

#[test]
fn the_opening_follows_its_inputs_in_every_mode_and_its_work_is_that_of_the_impulse_on_it() {
    for mode in 1..=3 {
        let mut host = Host::with(PRESCRIBED);
        assert_eq!(host.set_integer("coupling.mode", mode), OK);
        host.start();
        let mut work = 0.0;
        for k in 0..10 {
            let t = f64::from(k) * 1e-4;
            assert_eq!(host.set("projectile.position[3]", 0.0122 - 8.0 * t), OK);
            assert_eq!(host.set("projectile.velocity[3]", -8.0), OK);
            open(&mut host, 1e3 * t, 1e3);
            host.steps(t, 1e-4, 1);
            work -= 1e3 * host.get("contact.expansion_impulse");
        }
        assert!((host.get("projectile.expansion") - 1.0).abs() < 1e-12);
        let account = host.get("energy.expansion");
        assert!(account != 0.0 && (account - work).abs() < 1e-9 * account.abs(), "mode {mode}: {account} {work}");
        assert!(host.get("contact.total_impulse[3]") > 0.0);
    }
}

#[test]
fn the_opening_of_the_scene_is_the_start_of_the_input() {
    let mut host =
        Host::with(&PRESCRIBED.replace("[projectile.expansion]\n", "[projectile.expansion]\nopening = 0.6\n"));
    host.start();
    assert_eq!((host.get("projectile.expansion"), host.get("projectile.prescribed_expansion")), (0.6, 0.6));
    host.steps(0.0, 1e-4, 1);
    assert_eq!(host.get("projectile.expansion"), 0.6);
}

#[test]
fn an_opening_that_a_law_decides_cannot_be_prescribed() {
    let mut host = Host::with(&with_law());
    host.start();
    assert_eq!(host.set("projectile.prescribed_expansion", 0.5), OK);
    assert_eq!(step(&host, 0.0), ERROR);
    let said = host.one_line();
    assert!(said.contains("expected 0: the importer does not prescribe the opening"), "{said}");
}

#[test]
fn an_opening_stops_at_its_ends_and_one_beyond_them_is_refused() {
    let mut host = Host::with(PRESCRIBED);
    host.start();
    open(&mut host, 0.5, 1e4);
    host.steps(0.0, 1e-4, 1);
    assert_eq!(host.get("projectile.expansion"), 1.0);
    open(&mut host, 0.5, -1e4);
    host.steps(1e-4, 1e-4, 1);
    assert_eq!(host.get("projectile.expansion"), 0.0);
    assert_eq!(host.set("projectile.prescribed_expansion", 1.5), ERROR);
    let said = host.one_line();
    assert!(said.contains("projectile.prescribed_expansion = 1.5: expected at most 1"), "{said}");
}

#[test]
fn the_law_opens_the_bullet_and_its_parameters_change_it() {
    let opened = |path: f64| {
        let mut host = Host::with(&with_law());
        assert_eq!(host.set("projectile.expansion_path", path), OK);
        host.start();
        host.steps(0.0, 1e-4, 8);
        host.get("projectile.expansion")
    };
    let [short, long] = [8e-3, 16e-3].map(opened);
    assert!(long > 0.1 && short > 1.5 * long, "{short} {long}");
    let mut host = Host::with(&with_law());
    assert_eq!(host.set("projectile.expansion_opening_speed", 3.0), OK);
    host.enter();
    // SAFETY: the component lives.
    assert_eq!(unsafe { fmi2ExitInitializationMode(host.c) }, ERROR);
    let said = host.one_line();
    assert!(said.contains("projectile.expansion.full_speed"), "{said}");
}

#[test]
fn an_input_that_the_body_does_not_have_must_stay_zero() {
    let mut host = Host::started();
    assert_eq!(host.set("projectile.prescribed_expansion", 0.5), OK);
    assert_eq!(step(&host, 0.0), ERROR);
    let said = host.one_line();
    assert!(said.contains("projectile.prescribed_expansion = 0.5: expected 0: the importer does not prescribe the opening of this body"), "{said}");
}
