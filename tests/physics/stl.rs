//! Scenes with a body from an STL file, and with a plate: they meet the gel as the same bodies described otherwise.

#![allow(dead_code, reason = "the bodies are shared with the tests of their geometry")]

use crate::deepest;
use crate::solid_bodies as bodies;
use ballistic_gel::geometry::SignedDistance as _;
use ballistic_gel::scene::{self, Override, Scene};
use ballistic_gel::simulation::{CouplingMode, Observation, RestoreError, Simulation};
use bodies::{Triangles, ascii, binary, cuboid, cylinder, fork, reversed, sphere, turned};
use deepest::deepest;
use std::io;

const BODY: &str = r#"
[scene]
name = "body"
dimension = "spatial"
end_time = 4e-3
communication_step = 1e-4
[gel]
shape.block.size = [0.1, 0.1, 0.05]
material = "neo-hookean"
density = 1030.0
shear_modulus = 69e3
bulk_modulus = 667e3
supports.z_min = "fixed"
[projectile]
shape.stl = { file = "body.stl", scale = 1e-3 }
mass = 0.033
position = [0.0, 0.0, 0.010]
velocity = [0.0, 0.0, -5.0]
[mesh]
size = 5e-3
"#;

fn changed(changes: &[&str]) -> String {
    let changes: Vec<Override> = changes.iter().map(|change| change.parse().unwrap()).collect();
    scene::resolve(BODY, &changes).unwrap()
}

/// The scene with the only file that there is.
fn read(text: &str, file: &[u8]) -> Result<Scene, scene::SceneError> {
    scene::read_with_files(text, &|name| match name {
        "body.stl" => Ok(file.to_vec()),
        _ => Err(io::Error::new(io::ErrorKind::NotFound, "there is no such file")),
    })
}

fn with(changes: &[&str], file: &[u8]) -> Scene {
    read(&changed(changes), file).unwrap_or_else(|error| panic!("{error}"))
}

/// Runs to the end in equal slices, and shows each to `look`.
fn run(scene: &Scene, slices: u32, mut look: impl FnMut(&Simulation)) -> Simulation {
    let mut simulation = Simulation::new(scene, CouplingMode::Integrated, 1).unwrap();
    for slice in 1..=slices {
        let inputs = simulation.inputs();
        simulation.step(&inputs, scene.scene.end_time * f64::from(slice) / f64::from(slices)).unwrap();
        look(&simulation);
    }
    simulation
}

fn end(scene: &Scene) -> Observation {
    run(scene, 1, |_| {}).observe()
}

/// The greatest difference between depths is that of the ball and the polyhedron inside it, R(1 − cos π/2n).
#[test]
fn a_ball_of_triangles_goes_as_deep_as_a_sphere_within_the_height_of_its_facets() {
    let round = end(&with(&["projectile.shape={sphere={radius=0.01}}"], &[]));
    for n in [8_u32, 16, 32] {
        let found = end(&with(&[], &binary(&sphere(10.0, n as usize))));
        let height = 0.01 * (1.0 - (std::f64::consts::FRAC_PI_2 / f64::from(n)).cos());
        let deeper = found.projectile().contact.peak_depth.0 - round.projectile().contact.peak_depth.0;
        assert!(deeper.abs() < 1.2 * height, "{n}: {deeper} against {height}");
        let ratio = found.projectile().contact.total_impulse.z / round.projectile().contact.total_impulse.z;
        assert!((ratio - 1.0).abs() < height / 0.01, "{n}: {ratio}");
        assert!(found.energy.energy_error < 1e-10 && found.energy.energy_defect < 2e-3, "{:?}", found.energy);
        assert!(found.momentum_error < 1e-12 && found.angular_momentum_error < 1e-12);
    }
}

const ON_EDGE: &str = "projectile.orientation=[0.9238795325112867, 0.0, 0.3826834323650898, 0.0]";
const ON_CORNER: &str =
    "projectile.orientation=[0.8804762392171493, -0.27984814233312133, 0.3647051996310009, -0.11591689595929511]";
const FLAT: &str = "projectile.orientation=[1, 0, 0, 0]";

/// At this place no node meets a ridge, where two normals are as good.
#[test]
fn a_cube_of_triangles_meets_the_gel_like_a_plate_and_does_not_leak() {
    let file = binary(&cuboid([20.0; 3]));
    for (turn, z) in [(FLAT, 0.01), (ON_EDGE, 0.01415), (ON_CORNER, 0.01733)] {
        let place = format!("projectile.position=[1.3e-3, 7e-4, {z}]");
        let scene = |shape: &str| with(&[&format!("projectile.shape={shape}"), &place, turn], &file);
        let plate = end(&scene("{plate={size=[0.02, 0.02, 0.02]}}"));
        let scene = scene("{stl={file='body.stl', scale=1e-3}}");
        let mut most: f64 = 0.0;
        let found = run(&scene, 20, |now| most = most.max(deepest(&now.frame(), &scene, 8))).observe();
        assert!(
            (found.projectile().contact.total_impulse - plate.projectile().contact.total_impulse).norm() < 1e-9,
            "{turn}"
        );
        assert!(
            (found.projectile().contact.peak_depth.0 - plate.projectile().contact.peak_depth.0).abs() < 1e-9,
            "{turn}"
        );
        assert!(most < 0.4 * scene.mesh.size, "{turn}: {} cells deep", most / scene.mesh.size);
        assert!(found.energy.energy_defect < 2e-3 && found.angular_momentum_error < 1e-12, "{:?}", found.energy);
    }
}

#[test]
fn the_edge_of_a_cylinder_of_triangles_does_not_leak() {
    let file = binary(&cylinder(10.0, 20.0, 48));
    for size in ["8e-3", "5e-3"] {
        let mesh = format!("mesh.size={size}");
        let scene = |shape: &str| {
            with(
                &[&format!("projectile.shape={shape}"), "projectile.position=[1.3e-3, 0, 0.01415]", ON_EDGE, &mesh],
                &file,
            )
        };
        let round = end(&scene("{cylinder={radius=0.01, length=0.02}}"));
        let scene = scene("{stl={file='body.stl', scale=1e-3}}");
        let mut most: f64 = 0.0;
        let found = run(&scene, 40, |now| most = most.max(deepest(&now.frame(), &scene, 8))).observe();
        assert!(most < 0.4 * scene.mesh.size, "{size}: {} cells deep", most / scene.mesh.size);
        let ratio = found.projectile().contact.total_impulse.norm() / round.projectile().contact.total_impulse.norm();
        assert!((ratio - 1.0).abs() < 0.02, "{size}: {ratio}");
        assert!(found.energy.energy_defect < 3e-3, "{:?}", found.energy);
    }
}

/// Point, tangent ogive, mantle and boat-tail, mm.
fn bullet() -> Triangles {
    let ogive = |z: f64| (2500.0 - (30.0 - z).powi(2)).sqrt() - 40.0;
    let nose = (1..=24).map(|k| 30.0 * f64::from(k) / 24.0).map(|z| (ogive(z), z));
    let profile: Vec<_> =
        [(0.0, 0.0)].into_iter().chain(nose).chain([(10.0, 50.0), (8.0, 60.0), (0.0, 60.0)]).collect();
    turned(&profile, 32)
}

/// Without contact of facets with its tip, the bullet slips through a facet.
#[test]
fn a_pointed_bullet_of_triangles_does_not_slip_through_the_surface() {
    let shot = ["projectile.mass=0.12", "projectile.velocity=[0, 0, -8]", "projectile.position=[1e-3, 0, 0.041]"];
    let profile = "projectile.shape={bullet={radius=0.01, length=0.06, nose={ogive={length=0.03}}, tail={length=0.01, radius=0.008}}}";
    let round = end(&with(&[&shot[..], &[profile]].concat(), &[]));
    let scene = with(&shot, &binary(&bullet()));
    let mut most: f64 = 0.0;
    let found = run(&scene, 40, |now| most = most.max(deepest(&now.frame(), &scene, 8))).observe();
    assert!(most < 0.35 * scene.mesh.size, "{} cells deep", most / scene.mesh.size);
    let ratio = found.projectile().contact.total_impulse.norm() / round.projectile().contact.total_impulse.norm();
    assert!((ratio - 1.0).abs() < 0.03 && found.energy.energy_defect < 0.04, "{ratio} {:?}", found.energy);
}

/// The prongs go past a narrow block on both sides: lines from their tips to the centre of mass go through it.
#[test]
fn a_fork_does_not_push_gel_between_its_prongs() {
    let shot = ["gel.shape.block.size=[0.0398, 0.04, 0.05]", "projectile.position=[0, 0, 0.038]"];
    let scene = with(&[&shot[..], &["projectile.shape.stl.scale=1e-2"]].concat(), &binary(&fork()));
    let found = end(&scene);
    assert!(found.projectile().kinematics.position.z < 0.0181, "the tips are 20 mm below the surface");
    assert_eq!(found.projectile().contact.total_impulse.norm(), 0.0);
}

/// Without their tips the prongs slip through the surface.
#[test]
fn a_fork_is_held_by_its_tips() {
    let shot = ["projectile.position=[1.3e-3, 7e-4, 0.038]", "projectile.velocity=[0, 0, -4]", "mesh.size=4e-3"];
    let scene = with(&[&shot[..], &["projectile.shape.stl.scale=1e-2"]].concat(), &binary(&fork()));
    let mut most: f64 = 0.0;
    let found = run(&scene, 40, |now| most = most.max(deepest(&now.frame(), &scene, 8))).observe();
    assert!(most < 0.4 * scene.mesh.size, "{} cells deep", most / scene.mesh.size);
    assert!(found.projectile().contact.total_impulse.z > 0.02, "{}", found.projectile().contact.total_impulse);
}

#[test]
fn a_rounded_plate_in_the_plane_meets_the_gel_like_a_disc_and_does_not_need_its_breadth() {
    let planar = ["scene.dimension=planar", "gel.shape.block.size=[0.1, 0.05]", "projectile.mass=3.3"];
    let end = |shape: &str| end(&with(&[&planar[..], &[&format!("projectile.shape={shape}")]].concat(), &[]));
    let disc = end("{sphere={radius=0.01}}");
    for breadth in ["1e-3", "1.0"] {
        let plate = end(&format!("{{plate={{size=[0.02, {breadth}, 0.02], edge_radius=0.01}}}}"));
        assert!(
            (plate.projectile().contact.total_impulse.z / disc.projectile().contact.total_impulse.z - 1.0).abs() < 1e-9
        );
    }
}

#[test]
fn a_state_of_another_file_is_refused_and_of_the_same_file_taken() {
    let scene = |n: usize| with(&[], &binary(&sphere(10.0, n)));
    let build = |scene: &Scene| Simulation::new(scene, CouplingMode::Integrated, 1).unwrap();
    let saved = run(&scene(8), 1, |_| {}).save();
    let mut same = build(&scene(8));
    same.restore(&saved).unwrap();
    assert_eq!(same.digest(), saved.digest());
    assert_eq!(build(&scene(9)).restore(&saved), Err(RestoreError::Foreign));
    // The same body, but other bytes.
    let header = [b"another header".to_vec(), binary(&sphere(10.0, 8))[14..].to_vec()].concat();
    assert_eq!(build(&with(&[], &header)).restore(&saved), Err(RestoreError::Foreign));
}

#[test]
fn both_formats_make_the_same_body() {
    let [one, other] =
        [binary(&bullet()), ascii(&bullet())].map(|file| with(&["projectile.position=[0, 0, 0.05]"], &file));
    let [one, other] = [one, other].map(|scene| scene.shape(0));
    let [one, other] = [one, other].map(|shape| shape.specific_inertia().unwrap());
    assert!((one - other).norm() < 1e-6 * one.norm(), "single and double precision: {one} {other}");
}

#[track_caller]
fn refused(text: &str, file: &[u8], message: &str) {
    let line = 1 + text.lines().position(|line| line.contains("shape.stl")).unwrap_or(0);
    let message = format!("line {line}: projectile.shape.stl{message}");
    let found = read(text, file).map(|_| ()).unwrap_err().to_string();
    assert!(found.starts_with(&message), "{found}\nnot\n{message}");
}

#[test]
fn a_faulty_stl_file_is_refused_with_the_place_and_the_remedy() {
    let cube = cuboid([20.0; 3]);
    let open = binary(&cube[1..].to_vec());
    refused(
        BODY,
        &open,
        ".file: found \"body.stl\" with 3 open edges, one at [-10.000000, 0.000000, 10.000000], \
         expected a closed surface, every edge shared by two triangles: close the holes and join double corners",
    );
    let mut twisted = cube.clone();
    twisted[0].swap(0, 1);
    refused(
        BODY,
        &binary(&twisted),
        ".file: found \"body.stl\" with 3 edges between triangles that face to different sides",
    );
    refused(BODY, b"solid\nendsolid\n", ".file: found \"body.stl\" with 0 triangles, expected a closed surface");
    refused(BODY, b"hello", ".file: found \"body.stl\" with 5 bytes that are no STL");
    refused(
        BODY,
        b"solid\nvertex 1 2\n",
        ".file: found \"body.stl\" with `vertex 1 2` on line 2, expected three numbers",
    );
    let other = BODY.replace("body.stl", "other.stl");
    refused(
        &other,
        &[],
        ".file: found \"other.stl\": there is no such file, expected the path of an STL file, relative",
    );
    refused(&BODY.replace("1e-3 }", "0.0 }"), &[], ".scale: found 0.0, expected a length from 1e-9 to 1e9");
    let alone = scene::read(BODY).unwrap_err().to_string();
    assert!(alone.contains("this scene is read without the folder that it is in"), "{alone}");
}

#[test]
fn an_stl_body_is_for_space_and_no_plate_is_round() {
    let file = binary(&sphere(10.0, 8));
    let planar = changed(&["scene.dimension=planar", "gel.shape.block.size=[0.1, 0.05]"]);
    let round = changed(&["scene.dimension=axisymmetric", "gel.shape={cylinder={radius=0.05, height=0.05}}"]);
    for text in [&planar, &round] {
        refused(
            text,
            &file,
            ": found \"body.stl\", a body in space, expected another shape: only a scene with dimension",
        );
    }
    let plate =
        round.replace("shape.stl = { file = \"body.stl\", scale = 1e-3 }", "shape.plate.size = [1.0, 1.0, 1.0]");
    let found = read(&plate, &[]).unwrap_err().to_string();
    assert!(found.contains("projectile.shape.plate: found size = [1.0, 1.0, 1.0], expected another shape"), "{found}");
}

#[test]
fn a_mesh_coarser_than_the_body_is_refused() {
    let found = read(BODY, &binary(&cuboid([20.0, 20.0, 8.0]))).unwrap_err().to_string();
    assert!(
        found.contains("mesh.size: found 0.005, expected at most the radius of the greatest ball inside"),
        "{found}"
    );
}

#[test]
fn a_check_says_what_is_in_the_file() {
    let lines = scene::modelled_physics(&with(&[], &binary(&reversed(&cuboid([20.0, 10.0, 12.0])))));
    let expected = "projectile: volume 2.4000e-6 m3, mass 3.3000e-2 kg, 13750 kg/m3, \
        a closed surface of 12 triangles whose normals pointed inwards and were reversed, 0.020000 x 0.010000 x \
        0.012000 m, centre of mass at [0.000000, 0.000000, 0.000000] m of its file";
    assert!(lines.iter().any(|line| line == expected), "{lines:?}");
}

#[test]
fn fragments_have_files_of_their_own() {
    let fragment =
        "[[fragment]]\nshape.stl = { file = \"NAME\", scale = 1e-3 }\nmass = 0.01\nposition = [0.0, 0.0, 0.05]\n";
    let text = |name: &str| BODY.to_owned() + &fragment.replace("NAME", name);
    let scene = read(&text("body.stl"), &binary(&sphere(10.0, 8))).unwrap();
    let names =
        [("projectile.shape.stl.file".to_owned(), "body.stl"), ("fragment[1].shape.stl.file".to_owned(), "body.stl")];
    assert_eq!(scene.files(), names);
    assert_eq!(scene.shape(1), scene.shape(0));
    let found = read(&text("other.stl"), &binary(&sphere(10.0, 8))).unwrap_err();
    assert_eq!((found.key.as_str(), found.line), ("fragment[1].shape.stl.file", Some(22)), "{found}");
}
