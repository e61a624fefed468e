//! Runs of gels beyond neo-Hookean, and scenes that are refused.

use ballistic_gel::scene::{self, Override, Scene};
use ballistic_gel::simulation::{CouplingMode, Observation, Simulation};

const SMALL: &str = r#"
[scene]
name = "hyperelastic"
dimension = "spatial"
end_time = 4e-3
communication_step = 1e-4
[gel]
shape.block.size = [0.06, 0.06, 0.03]
material = "mooney-rivlin"
density = 1030.0
constants = { c1 = 25e3, c2 = 10e3 }
bulk_modulus = 667e3
[projectile]
shape.sphere.radius = 0.03
mass = 0.05
position = [0.0, 0.0, 0.03]
velocity = [0.0, 0.0, -4.0]
[mesh]
size = 0.01
"#;
const PLANAR: [&str; 3] = ["scene.dimension=planar", "gel.shape.block.size=[0.06, 0.03]", "mesh.size=5e-3"];
const AXISYMMETRIC: [&str; 3] =
    ["scene.dimension=axisymmetric", "gel.shape={cylinder={radius=0.04, height=0.03}}", "mesh.size=5e-3"];
const OGDEN: &str = "[{ modulus = 12e3, exponent = 4.0 }, { modulus = -15e3, exponent = -2.0 }]";

fn changed(changes: &[&str]) -> Result<Scene, String> {
    let changes: Vec<Override> = changes.iter().map(|change| change.parse().expect("key=value")).collect();
    let text = scene::resolve(SMALL, &changes).map_err(|error| format!("{error:?}"))?;
    scene::read(&text).map_err(|error| error.to_string())
}

/// The same gel by its terms.
fn ogden(terms: &str) -> Result<Scene, String> {
    let text = SMALL.replace("mooney-rivlin", "ogden").replace("constants = { c1 = 25e3, c2 = 10e3 }", terms);
    scene::read(&text).map_err(|error| error.to_string())
}

/// Scenes of both gels in the plane, about an axis and in space, of plain elements and patches, with these changes.
fn scenes(changes: &[&str]) -> Vec<Scene> {
    let terms = format!("terms = {OGDEN}");
    let texts = [
        SMALL.to_owned(),
        SMALL.replace("mooney-rivlin", "ogden").replace("constants = { c1 = 25e3, c2 = 10e3 }", &terms),
    ];
    let mut made = vec![];
    for (text, space) in
        texts.iter().flat_map(|text| [&[] as &[&str], &PLANAR, &AXISYMMETRIC].map(|space| (text, space)))
    {
        for element in ["mesh.element=plain", "mesh.element=patch"] {
            let all: Vec<Override> = [space, changes, &[element]].concat().iter().map(|c| c.parse().unwrap()).collect();
            made.push(scene::read(&scene::resolve(text, &all).unwrap()).unwrap());
        }
    }
    made
}

fn finished(scene: &Scene, instants: u32) -> (Observation, String) {
    let mut simulation = Simulation::new(scene, CouplingMode::Integrated, 1).expect("the scene is small");
    for i in 1..=instants {
        let inputs = simulation.inputs();
        let instant = scene.scene.end_time * f64::from(i) / f64::from(instants);
        simulation.step(&inputs, instant).expect("a shallow impact");
    }
    (simulation.observe(), format!("{:?}", simulation.digest()))
}

#[test]
fn a_bounce_keeps_energy_and_momentum_and_the_communication_step_leaves_no_trace() {
    for scene in scenes(&[]) {
        let ((seen, digest), (_, other)) = (finished(&scene, 1), finished(&scene, 13));
        let energy = &seen.energy;
        assert!(energy.imbalance.abs() < 1e-10 * energy.initial, "closure {:e}", energy.imbalance);
        assert!(energy.energy_defect < 0.01, "{:?}: defect {:e}", scene.scene.dimension, energy.energy_defect);
        assert!(seen.projectile().kinematics.velocity.z > -4.0 && energy.elastic > 0.01 * energy.initial);
        assert_eq!(digest, other, "{:?}", scene.scene.dimension);
    }
}

#[test]
fn a_new_mesh_takes_over_what_these_gels_store() {
    for scene in scenes(&["remesh.times=[1.5e-3, 2.5e-3]", "remesh.adaptive=false"]) {
        let seen = finished(&scene, 1).0;
        let energy = &seen.energy;
        assert_eq!(seen.cost.remeshes, 2, "{:?}", scene.scene.dimension);
        assert!(energy.imbalance.abs() < 1e-10 * energy.initial, "closure {:e}", energy.imbalance);
        assert!(
            energy.remesh_net().abs() < 0.05 * energy.initial,
            "{:?}: {:e}",
            scene.scene.dimension,
            energy.remesh_net()
        );
    }
}

#[test]
fn an_unstable_gel_is_refused_with_the_constant_that_makes_it_so() {
    for (change, said) in [
        ("gel.constants={c1=0.0, c2=1e3}", "gel.constants.c1: found 0.0, expected a positive constant, Pa"),
        ("gel.constants={c1=1e3, c2=-1.0}", "gel.constants.c2: found -1.0, expected a constant of 0 or more"),
        ("gel.bulk_modulus=80e3", "gel.bulk_modulus: found 80000.0, expected more than 4/3 c1 + 16/3 c2, 86666.6"),
        ("gel.shear_modulus=69e3", "expected nothing: it follows from the constants of the gel and is 70000.0 Pa"),
        ("gel.material=neo-hookean", "only a gel of material \"mooney-rivlin\" has constants"),
        ("gel.terms=[{modulus=1.0, exponent=2.0}]", "only a gel of material \"ogden\" has terms"),
    ] {
        let mut changes = vec![change];
        if change == "gel.material=neo-hookean" {
            changes.push("gel.shear_modulus=1e3");
        }
        let error = changed(&changes).expect_err(change);
        assert!(error.contains(said), "{change}: {error}");
    }
    for (terms, said) in [
        (
            "terms = [{ modulus = 1e3, exponent = -2.0 }]",
            "gel.terms.modulus: found 1000.0, expected a negative modulus, Pa, as",
        ),
        ("terms = [{ modulus = -1e3, exponent = 2.0 }]", "makes the gel unstable at some strain"),
        (
            "terms = [{ modulus = 1e3, exponent = 0.0 }]",
            "gel.terms.exponent: found 0.0, expected a number of a magnitude",
        ),
        ("terms = []", "gel.terms: found 0 of them, expected 1 to 3 tables { modulus, exponent }"),
        ("", "gel.terms: found 0 of them, expected 1 to 3"),
        ("terms = [{ modulus = nan, exponent = 2.0 }]", "gel.terms.modulus: found NaN, expected a finite number"),
    ] {
        let error = ogden(terms).expect_err(terms);
        assert!(error.contains(said), "{terms}: {error}");
    }
}

#[test]
fn the_shear_modulus_follows_from_the_constants_and_a_scene_given_back_reads_as_itself() {
    for scene in scenes(&[]) {
        assert!((scene.gel.shear_modulus / if scene.gel.terms.is_empty() { 70e3 } else { 39e3 } - 1.0).abs() < 1e-14);
        assert_eq!(scene::read(&toml::to_string(&scene).unwrap()).unwrap(), scene);
    }
}
