//! Every default of a scene, written out.

use super::read;
use ballistic_gel::scene;
use serde_json::Value;

/// Scene of the required keys alone, but for a bullet, its expansion and a load, whose own keys have defaults.
const MINIMAL: &str = r#"[scene]
name = "least"
dimension = "spatial"
end_time = 0.01
communication_step = 1e-4
[gel]
shape.block.size = [0.1, 0.1, 0.05]
material = "neo-hookean"
density = 1030.0
shear_modulus = 7e4
bulk_modulus = 7e5
[projectile]
shape.bullet = { radius = 0.01, length = 0.05, nose.ogive.length = 0.03 }
expansion.opened = { radius = 0.012, length = 0.04, head_length = 0.02, edge_radius = 0.01, shank_radius = 0.01 }
mass = 0.033
position = [0.0, 0.0, 0.05]
[mesh]
size = 5e-3
[[load]]
pressure = 1e3
[remesh]
"#;

/// Every key that [`MINIMAL`] leaves out and that has a default, with it.
const DEFAULTS: [&str; 48] = [
    "scene.title=\"\"",
    "scene.fidelity=standard",
    "scene.stop_after_exit=2e-3",
    "scene.await_cavity=true",
    "scene.stop_at_rest=false",
    "gel.strength_scale=1.0",
    "gel.cavity=vented",
    "gel.symmetry=none",
    "gel.self_contact=auto",
    "gel.velocity=[0.0, 0.0, 0.0]",
    "gel.supports.x_min=free",
    "gel.supports.x_max=free",
    "gel.supports.y_min=free",
    "gel.supports.y_max=free",
    "gel.supports.z_min=free",
    "gel.supports.z_max=free",
    "gel.supports.side=free",
    "projectile.velocity=[0.0, 0.0, 0.0]",
    "projectile.orientation=[1.0, 0.0, 0.0, 0.0]",
    "projectile.angular_velocity=[0.0, 0.0, 0.0]",
    "projectile.fixed=false",
    "projectile.active=true",
    "projectile.shape.bullet.edge_radius=0.0",
    "projectile.expansion.opened.rim_radius=0.0",
    "projectile.expansion.opening=0.0",
    "projectile.shape.bullet.nose.ogive.meplat_radius=0.0",
    "load=[{ pressure = 1e3, depth = 0.0, ramp = 0.0 }]",
    "mesh.lattice=centred",
    "mesh.element=plain",
    "integrator.schedule=bins",
    "integrator.damping=0.0",
    "contact.law=moreau",
    "contact.restitution=0.0",
    "contact.bias=0.1",
    "contact.friction=0.0",
    "coupling.mode=integrated",
    "output.frames=41",
    "output.report=true",
    "output.force_window=0.0",
    "output.fields=[]",
    "remesh.method=local",
    "remesh.quality=0.3",
    "remesh.min_volume_ratio=0.1",
    "remesh.times=[]",
    "remesh.adaptive=true",
    "remesh.curvature_angle=15.0",
    "remesh.growth=0.3",
    "remesh.elastic_average=stored-energy",
];

/// Tables of a two-network gel that are empty, and with every default.
const OF_NETWORKS: [[&str; 2]; 2] = [
    ["gel.volume={}", "gel.volume={ hugoniot_slope = 0.0 }"],
    ["gel.viscosity={}", "gel.viscosity={ linear = 0.0, quadratic = 0.0 }"],
];

#[test]
fn every_default_of_a_scene_is_the_promised_one() {
    let least = read(MINIMAL);
    for default in DEFAULTS {
        let written = scene::resolve(MINIMAL, &[default.parse().unwrap()]).unwrap();
        assert_eq!(read(&written), least, "{default}");
    }
    let networks = MINIMAL.replace("neo-hookean", "two-network");
    for tables in OF_NETWORKS {
        let [empty, written] = tables.map(|table| scene::resolve(&networks, &[table.parse().unwrap()]).unwrap());
        assert_eq!(read(&written), read(&empty), "{tables:?}");
    }
    // Values that other keys decide, where they are absent.
    assert_eq!((least.integrator.cfl(), least.thickness(), least.force_window()), (0.8, 1.0, 1e-4));
    let queue =
        scene::resolve(&MINIMAL.replace("[remesh]", ""), &["integrator.schedule=queue".parse().unwrap()]).unwrap();
    assert_eq!(read(&queue).integrator.cfl(), 0.4);
}

/// Keys with a default in the schema of a table, at any depth.
fn keys_with_default(schema: &Value, into: &mut Vec<String>) {
    let Value::Object(object) = schema else { return };
    if let Some(properties) = object.get("properties").and_then(|properties| properties.as_object()) {
        let has_value = |property: &Value| !(property["default"].is_null() || property["default"].is_object());
        into.extend(properties.iter().filter(|(_, property)| has_value(property)).map(|(key, _)| key.clone()));
    }
    let parts = object.values().flat_map(|value| value.as_array().cloned().unwrap_or_else(|| vec![value.clone()]));
    parts.for_each(|part| keys_with_default(&part, into));
}

#[test]
fn no_default_of_the_schema_is_left_out_of_the_promised_ones() {
    let mut keys = vec![];
    keys_with_default(&scene::schema(), &mut keys);
    // The scale of an STL file needs a file, and the levels of `fidelity` are figures of the built-in scenes; the discharge is that of a
    // cavity into which air flows (`tests/cavity.rs`).
    let elsewhere = ["scale", "set", "error", "updates", "cpu_seconds", "discharge"];
    keys.retain(|key| !elsewhere.contains(&key.as_str()));
    assert!(keys.len() > 30, "{keys:?}");
    let written: Vec<&str> = DEFAULTS.into_iter().chain(OF_NETWORKS.map(|[_, written]| written)).collect();
    for key in keys {
        let is_of = |default: &&str| {
            default.split('=').next().is_some_and(|path| path.ends_with(&key)) || default.contains(&format!(" {key} ="))
        };
        assert!(written.iter().any(is_of), "{key}");
    }
}
