//! Every way in which a scene can be wrong has its own message: key, line, what was found, what was expected.

use ballistic_gel::scene::{self, Override, Scene};

const SPATIAL: &str = r#"[scene]
name = "test"
dimension = "spatial"
end_time = 0.01
communication_step = 1e-4
[gel]
shape.block.size = [0.1, 0.1, 0.05]
material = "neo-hookean"
density = 1030.0
shear_modulus = 7e4
bulk_modulus = 7e5
supports.z_min = "fixed"
[projectile]
shape.sphere.radius = 0.01
mass = 0.033
position = [0.0, 0.0, 0.01]
velocity = [0.0, 0.0, -5.0]
[mesh]
size = 5e-3
"#;

const BLOCK: &str = "shape.block.size = [0.1, 0.1, 0.05]";
const CYLINDER: &str = "shape.cylinder = { radius = 0.1, height = 0.05 }";
const SPHERE: &str = "shape.sphere.radius = 0.01";
const MASS: &str = "mass = 0.033";
const POSITION: &str = "position = [0.0, 0.0, 0.01]";
const VELOCITY: &str = "velocity = [0.0, 0.0, -5.0]";
const SIZE: &str = "size = 5e-3";

fn planar() -> String {
    SPATIAL.replace("spatial", "planar").replace("[0.1, 0.1, 0.05]", "[0.1, 0.05]")
}

fn axisymmetric() -> String {
    SPATIAL.replace("spatial", "axisymmetric").replace(BLOCK, CYLINDER)
}

fn l_beam() -> String {
    let beam = "shape.l-beam = { leg = 0.2, thickness = 0.05, width = 0.05, angle = 45.0, corner = [0.0, 0.0, 0.1] }";
    SPATIAL.replace(BLOCK, beam).replace("supports.z_min = \"fixed\"\n", "")
}

/// A scene whose projectile is held.
fn held(base: &str) -> String {
    base.replace(MASS, "fixed = true").replace(VELOCITY, "velocity = [0.0, 0.0, 0.0]")
}

/// A scene with a wall instead of a sphere.
fn wall(base: &str) -> String {
    held(base).replace(SPHERE, "shape.half-space.normal = [0.0, 0.0, 1.0]")
}

#[track_caller]
fn read(text: &str) -> Scene {
    match scene::read(text) {
        Ok(scene) => scene,
        Err(error) => panic!("{error}\n{text}"),
    }
}

#[track_caller]
fn not_a_scene(text: &str, message: &str) {
    match scene::read(text) {
        Ok(_) => panic!("accepted\n{text}"),
        Err(error) => assert_eq!(error.to_string(), message),
    }
}

/// `base` reads, but not with `from` replaced by `to`.
#[track_caller]
fn refused(base: &str, from: &str, to: &str, message: &str) {
    read(base);
    assert!(base.contains(from), "the scene has no {from:?}");
    not_a_scene(&base.replacen(from, to, 1), message);
}

/// `base` reads, but not with one more line after the key `after`.
#[track_caller]
fn refused_with(base: &str, after: &str, line: &str, message: &str) {
    refused(base, after, &format!("{after}\n{line}"), message);
}

/// The spatial scene reads, but not with one more table.
#[track_caller]
fn refused_table(table: &str, message: &str) {
    refused_with(SPATIAL, SIZE, table, message);
}

#[test]
fn broken_toml() {
    refused(SPATIAL, SIZE, "size = 12e", "X");
    refused(SPATIAL, "[mesh]", "[mesh", "X");
    refused(SPATIAL, SIZE, "size = 1\nsize = 2", "X");
}

#[test]
fn unknown_keys() {
    refused(SPATIAL, "[mesh]", "[mesch]", "X");
    refused(SPATIAL, SIZE, "sizes = 5e-3", "X");
    refused(SPATIAL, SPHERE, "shape.sphere.r = 0.01", "X");
}

#[test]
fn missing_keys() {
    refused(SPATIAL, SIZE, "", "X");
    refused(SPATIAL, "[mesh]\nsize = 5e-3\n", "", "X");
    refused(SPATIAL, BLOCK, "shape.block = {}", "X");
}

#[test]
fn wrong_types() {
    refused(SPATIAL, SIZE, "size = \"fine\"", "X");
    refused(SPATIAL, SIZE, "size = 5e-3\nlattice = 3", "X");
    refused(SPATIAL, SPHERE, "shape = \"sphere\"", "X");
    refused(SPATIAL, SPHERE, "shape.sphere = 0.01", "X");
    refused(SPATIAL, MASS, "fixed = 1", "X");
    refused(SPATIAL, VELOCITY, "velocity = -5.0", "X");
    refused_table("[output]\nframes = -1", "X");
}

#[test]
fn lists_of_wrong_length() {
    refused(SPATIAL, VELOCITY, "velocity = [0.0, -5.0]", "X");
    refused(SPATIAL, VELOCITY, "velocity = [0.0, 0.0, -5.0, 1.0]", "X");
    refused(SPATIAL, SIZE, "size = 5e-3\ngrading = [0.01, 1.2, 0.01]", "X");
}

#[test]
fn unknown_alternatives() {
    refused(SPATIAL, "\"spatial\"", "\"cubic\"", "X");
    refused(SPATIAL, SPHERE, "shape.ball.radius = 0.01", "X");
    refused(SPATIAL, SPHERE, "shape.sphere.radius = 0.01\nshape.cylinder.radius = 1.0", "X");
}

#[test]
fn a_name_is_letters_digits_and_dashes() {
    refused(SPATIAL, "\"test\"", "\"a b\"", "X");
    refused(SPATIAL, "\"test\"", "\"\"", "X");
}

#[test]
fn times_are_positive_and_in_order() {
    refused(SPATIAL, "end_time = 0.01", "end_time = nan", "X");
    refused(SPATIAL, "end_time = 0.01", "end_time = inf", "X");
    refused(SPATIAL, "end_time = 0.01", "end_time = 0", "X");
    refused(SPATIAL, "communication_step = 1e-4", "communication_step = -1e-4", "X");
    refused(SPATIAL, "communication_step = 1e-4", "communication_step = 0.02", "X");
}

#[test]
fn a_block_has_as_many_edges_as_its_scene_has_axes() {
    refused(SPATIAL, "[0.1, 0.1, 0.05]", "[0.1, 0.05]", "X");
    refused(&planar(), "[0.1, 0.05]", "[0.1, 0.1, 0.05]", "X");
    refused(SPATIAL, "[0.1, 0.1, 0.05]", "[0.1, 0.0, 0.05]", "X");
}

#[test]
fn a_shape_fits_its_dimension() {
    refused(&planar(), "shape.block.size = [0.1, 0.05]", CYLINDER, "X");
    refused(&axisymmetric(), CYLINDER, BLOCK, "X");
    refused(&l_beam(), "\"spatial\"", "\"axisymmetric\"", "X");
    refused(&l_beam(), "\"spatial\"", "\"planar\"", "X");
    refused(&l_beam(), "width = 0.05, ", "", "X");
}

#[test]
fn lengths_of_the_gel_are_positive() {
    refused(&axisymmetric(), "radius = 0.1", "radius = 0.0", "X");
    refused(&axisymmetric(), "height = 0.05", "height = -1.0", "X");
    refused(&l_beam(), "leg = 0.2", "leg = inf", "X");
    refused(&l_beam(), "thickness = 0.05", "thickness = 0.2", "X");
    refused(&l_beam(), "thickness = 0.05", "thickness = 0.0", "X");
    refused(&l_beam(), "width = 0.05", "width = -0.05", "X");
    refused(&l_beam(), "angle = 45.0", "angle = nan", "X");
    refused(&l_beam(), "corner = [0.0, 0.0, 0.1]", "corner = [0.0, 0.0, inf]", "X");
}

#[test]
fn the_material_is_stable() {
    refused(SPATIAL, "density = 1030.0", "density = 0.0", "X");
    refused(SPATIAL, "shear_modulus = 7e4", "shear_modulus = -1.0", "X");
    refused(SPATIAL, "bulk_modulus = 7e5", "bulk_modulus = inf", "X");
    refused(SPATIAL, "bulk_modulus = 7e5", "bulk_modulus = 4e4", "X");
}

#[test]
fn only_faces_that_exist_are_held() {
    refused(SPATIAL, "supports.z_min", "supports.side", "X");
    refused(&planar(), "supports.z_min = \"fixed\"", "supports.y_min = \"roller\"", "X");
    refused(&axisymmetric(), "supports.z_min", "supports.x_max", "X");
    refused_with(&l_beam(), "bulk_modulus = 7e5", "supports.z_min = \"fixed\"", "X");
    let slides = axisymmetric().replace("supports.z_min = \"fixed\"", "supports.side = \"roller\"");
    refused(&slides, "axisymmetric", "spatial", "X");
}

#[test]
fn only_a_planar_gel_has_a_thickness() {
    refused_with(SPATIAL, "bulk_modulus = 7e5", "thickness = 1.0", "X");
    refused_with(&planar(), "bulk_modulus = 7e5", "thickness = 0.0", "X");
}

#[test]
fn lengths_of_the_projectile_are_positive() {
    refused(SPATIAL, SPHERE, "shape.sphere.radius = 0.0", "X");
    refused(SPATIAL, SPHERE, "shape.cylinder = { radius = -0.01, length = 0.01 }", "X");
    refused(SPATIAL, SPHERE, "shape.cylinder = { radius = 0.01, length = 0.0 }", "X");
    refused(&wall(&l_beam()), "[0.0, 0.0, 1.0]", "[0.0, 0.0, 0.0]", "X");
}

#[test]
fn motion_is_finite() {
    refused_with(SPATIAL, "bulk_modulus = 7e5", "velocity = [nan, 0, 0]", "X");
    refused(SPATIAL, POSITION, "position = [0.0, inf, 0.01]", "X");
    refused(SPATIAL, VELOCITY, "velocity = [0.0, 0.0, nan]", "X");
    refused_with(SPATIAL, MASS, "angular_velocity = [0, inf, 0]", "X");
}

#[test]
fn what_moves_has_a_mass() {
    refused(SPATIAL, MASS, "", "X");
    refused(SPATIAL, MASS, "mass = 0.0", "X");
}

#[test]
fn what_is_fixed_has_no_mass_and_no_motion() {
    let held = held(SPATIAL);
    refused_with(&held, "fixed = true", "mass = 1.0", "X");
    refused_with(&held, "fixed = true", "inertia = [1, 1, 1, 0, 0, 0]", "X");
    refused_with(&held, "fixed = true", "angular_velocity = [0, 0, 1]", "X");
    refused(&held, "velocity = [0.0, 0.0, 0.0]", "velocity = [1.0, 0.0, 0.0]", "X");
}

#[test]
fn inertia_is_that_of_some_body() {
    refused_with(SPATIAL, MASS, "inertia = [1, 1, 1, 1, 1, 2]", "X");
    refused_with(SPATIAL, MASS, "inertia = [1, 1, 3, 0, 0, 0]", "X");
    refused_with(SPATIAL, MASS, "inertia = [1, 1, nan, 0, 0, 0]", "X");
    read(&SPATIAL.replace(MASS, "mass = 1.0\ninertia = [1, 1, 2, 0, 0, 0]"));
}

#[test]
fn a_moving_half_space_needs_an_inertia() {
    let moving = wall(&l_beam()).replace("fixed = true", "mass = 1.0\ninertia = [1, 1, 1, 0, 0, 0]");
    refused(&moving, "inertia = [1, 1, 1, 0, 0, 0]", "", "X");
}

#[test]
fn a_quaternion_has_norm_one() {
    refused_with(SPATIAL, MASS, "orientation = [1, 1, 0, 0]", "X");
    refused_with(SPATIAL, MASS, "orientation = [1, 0, 0, nan]", "X");
    read(&SPATIAL.replace(MASS, "mass = 1.0\norientation = [1.0009, 0, 0, 0]"));
}

#[test]
fn the_projectile_starts_outside_the_gel() {
    refused(SPATIAL, POSITION, "position = [0.0, 0.0, -0.001]", "X");
    refused(&axisymmetric(), POSITION, "position = [0.0, 0.0, -0.04]", "X");
    read(&SPATIAL.replace(POSITION, "position = [0.06, 0.0, -0.02]"));
    let lying = "orientation = [0.7071067811865476, 0.7071067811865476, 0, 0]";
    let rod = format!("shape.cylinder = {{ radius = 0.01, length = 0.1 }}\n{lying}");
    refused(&SPATIAL.replace(SPHERE, &rod), lying, "", "X");
}

#[test]
fn nothing_leaves_the_plane() {
    let base = planar();
    refused_with(&base, "bulk_modulus = 7e5", "velocity = [0, 1, 0]", "X");
    refused(&base, POSITION, "position = [0.0, 0.1, 0.01]", "X");
    refused(&base, VELOCITY, "velocity = [0.0, 1.0, -5.0]", "X");
    refused_with(&base, MASS, "angular_velocity = [1, 0, 0]", "X");
    refused_with(&base, MASS, "orientation = [0.6, 0.8, 0, 0]", "X");
    refused_with(&base, MASS, "inertia = [1, 1, 1, 0.1, 0, 0]", "X");
    read(&base.replace(MASS, "mass = 1.0\norientation = [0.6, 0, 0.8, 0]\nangular_velocity = [0, 3, 0]"));
}

#[test]
fn a_planar_wall_and_beam_stay_in_the_plane() {
    let base = wall(&l_beam()).replace("\"spatial\"", "\"planar\"").replace("width = 0.05, ", "");
    refused(&base, "normal = [0.0, 0.0, 1.0]", "normal = [0.0, 1.0, 1.0]", "X");
    refused(&base, "corner = [0.0, 0.0, 0.1]", "corner = [0.0, 0.2, 0.1]", "X");
}

#[test]
fn nothing_leaves_the_axis() {
    let base = axisymmetric();
    refused_with(&base, "bulk_modulus = 7e5", "velocity = [1, 0, 0]", "X");
    refused(&base, POSITION, "position = [0.1, 0.0, 0.01]", "X");
    refused(&base, VELOCITY, "velocity = [0.0, 1.0, -5.0]", "X");
    refused_with(&base, MASS, "angular_velocity = [0, 0, 1]", "X");
    refused_with(&base, MASS, "orientation = [0.6, 0.8, 0, 0]", "X");
    refused(&wall(&base), "normal = [0.0, 0.0, 1.0]", "normal = [0.1, 0.0, 1.0]", "X");
    read(&base.replace(MASS, "mass = 1.0\norientation = [0.6, 0, 0, 0.8]"));
}

#[test]
fn the_mesh_fits_the_gel() {
    refused(SPATIAL, SIZE, "size = 0.0", "X");
    refused(SPATIAL, SIZE, "size = 0.06", "X");
}

#[test]
fn grading_coarsens() {
    refused_with(SPATIAL, SIZE, "grading = { core = -0.01, growth = 1.2, largest = 0.01 }", "X");
    refused_with(SPATIAL, SIZE, "grading = { core = 0.01, growth = 1.0, largest = 0.01 }", "X");
    refused_with(SPATIAL, SIZE, "grading = { core = 0.01, growth = inf, largest = 0.01 }", "X");
    refused_with(SPATIAL, SIZE, "grading = { core = 0.01, growth = 1.2, largest = 1e-3 }", "X");
    refused_with(&l_beam(), SIZE, "grading = { core = 0.01, growth = 1.2, largest = 0.01 }", "X");
}

#[test]
fn fractions_are_fractions() {
    refused_table("[integrator]\ncfl = 0.0", "X");
    refused_table("[integrator]\ncfl = 1.5", "X");
    refused_table("[contact]\nrestitution = 1.1", "X");
    refused_table("[contact]\nbias = 0.6", "X");
    refused_table("[contact]\nlaw = \"reversal\"\nrestitution = 0.5", "X");
}

#[test]
fn output_is_bounded() {
    refused_table("[output]\nframes = 0", "X");
    refused_table("[output]\nframes = 10001", "X");
    refused_table("[output]\nforce_window = 0.1", "X");
}

/// The spatial scene with one value replaced.
#[track_caller]
fn resolved(change: &str) -> String {
    let change: Result<Override, _> = change.parse();
    match change.and_then(|change| scene::resolve(SPATIAL, &[change])) {
        Ok(text) => text,
        Err(error) => panic!("{error}"),
    }
}

#[track_caller]
fn not_an_override(change: &str, message: &str) {
    let change: Result<Override, _> = change.parse();
    match change.and_then(|change| scene::resolve(SPATIAL, &[change])) {
        Ok(text) => panic!("accepted\n{text}"),
        Err(error) => assert_eq!(error.to_string(), message),
    }
}

#[test]
fn an_override_changes_its_line_and_no_other() {
    assert_eq!(resolved("mesh.size=1e-3"), SPATIAL.replace(SIZE, "size = 1e-3"));
    let wider = resolved("projectile.shape.sphere.radius = 0.02");
    assert_eq!(wider, SPATIAL.replace("radius = 0.01", "radius = 0.02"));
}

#[test]
fn an_override_keeps_the_comment_behind_the_value() {
    let text = SPATIAL.replace(SIZE, "size = 5e-3 # fine");
    let change = "mesh.size=1e-3".parse().unwrap();
    assert!(scene::resolve(&text, &[change]).unwrap().contains("size = 1e-3 # fine\n"));
}

#[test]
fn an_override_adds_what_is_absent() {
    assert_eq!(read(&resolved("contact.restitution=0.25")).contact.restitution, 0.25);
    assert_eq!(read(&resolved("gel.supports.x_min=roller")).gel.supports.x_min, scene::Support::Roller);
    let graded = read(&resolved("mesh.grading={core = 0.01, growth = 1.5, largest = 0.02}"));
    assert_eq!(graded.mesh.grading.unwrap().largest, 0.02);
    let parts = ["core=0.01", "growth=1.5", "largest=0.02"].map(|p| format!("mesh.grading.{p}").parse().unwrap());
    assert_eq!(read(&scene::resolve(SPATIAL, &parts).unwrap()), graded);
}

#[test]
fn an_override_may_replace_a_whole_table() {
    let rod = read(&resolved("projectile.shape={cylinder={radius=0.01, length=0.02}}"));
    assert_eq!(rod.projectile.shape, scene::BodyShape::Cylinder { radius: 0.01, length: 0.02 });
}

#[test]
fn a_bare_word_is_text() {
    assert_eq!(read(&resolved("mesh.lattice=kuhn")).mesh.lattice, scene::Lattice::Kuhn);
}

#[test]
fn the_last_override_wins() {
    let changes = ["mesh.size=1e-3", "mesh.size=2e-3"].map(|change| change.parse().unwrap());
    assert_eq!(read(&scene::resolve(SPATIAL, &changes).unwrap()).mesh.size, 2e-3);
}

#[test]
fn without_overrides_the_text_stays() {
    assert_eq!(scene::resolve(SPATIAL, &[]).unwrap(), SPATIAL);
}

#[test]
fn what_is_not_a_key_and_a_value_is_refused() {
    not_an_override("mesh.size", "X");
    not_an_override("mesh.size=", "X");
    not_an_override("mesh.size=[1,", "X");
    not_an_override("mesh..size=1", "X");
    not_an_override("mesh.size.x=1", "X");
}

#[test]
fn an_override_of_an_unknown_key_is_refused_when_the_scene_is_read() {
    not_a_scene(&resolved("mesh.sizes=1"), "X");
    not_a_scene(&resolved("mesch.size=1"), "X");
}

#[test]
fn overrides_of_broken_text_are_refused() {
    assert_eq!(scene::resolve("[mesh\n", &[]).unwrap_err().to_string(), "X");
}

fn builtin(name: &str) -> Scene {
    read(scene::builtin(name).unwrap())
}

#[test]
fn the_builtin_scenes_are_the_promised_ones_and_the_first_is_the_default() {
    let names: Vec<&str> = scene::builtins().map(|(name, _)| name).collect();
    assert_eq!(names, ["sphere-block", "ball-bounce", "ball-square", "l-beam"]);
    assert_eq!(scene::builtin("sphere"), None);
}

#[test]
fn builtin_moduli_are_those_of_the_young_modulus_and_poisson_ratio_they_name() {
    for (name, poisson) in [("sphere-block", 0.45), ("ball-square", 0.45), ("l-beam", 0.3)] {
        let gel = builtin(name).gel;
        let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-14;
        assert!(close(gel.shear_modulus, 200e3 / (2.0 * (1.0 + poisson))), "{name}: {}", gel.shear_modulus);
        assert!(close(gel.bulk_modulus, 200e3 / (3.0 * (1.0 - 2.0 * poisson))), "{name}: {}", gel.bulk_modulus);
    }
}

#[test]
fn the_disc_of_ball_square_is_of_steel() {
    let disc = std::f64::consts::PI * 0.01 * 0.01;
    let mass = builtin("ball-square").projectile.mass.unwrap();
    assert!((mass / (7850.0 * disc) - 1.0).abs() < 1e-6, "{mass}");
}

#[test]
fn a_scene_written_as_toml_reads_as_itself() {
    for (name, text) in scene::builtins() {
        let before = read(text);
        assert_eq!(read(&toml::to_string(&before).unwrap()), before, "{name}");
    }
}
