//! Every way in which a scene can be wrong has its own message: key, line, what was found, what was expected.

#[path = "../scene/defaults.rs"]
mod defaults;

use ballistic_gel::scene::{self, Override, Scene};
use std::f64::consts::PI;

/// Scenes that read, what to replace in them, and the message then: see [`every_fault_has_its_message`].
const REFUSED: &str = include_str!("../scene/refused.txt");

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
const BULLET: &str = "shape.bullet = { radius = 0.01, length = 0.05, nose.ogive = { length = 0.03 }, \
     tail = { length = 0.01, radius = 0.008 }, edge_radius = 1e-3 }";
const MASS: &str = "mass = 0.033";
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

/// A scene with the gel of a preset.
fn shot() -> String {
    let values = "material = \"neo-hookean\"\ndensity = 1030.0\nshear_modulus = 7e4\nbulk_modulus = 7e5\n";
    SPATIAL.replace(values, "").replace("supports.z_min = \"fixed\"", "preset = \"gelatin-10\"")
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

/// The scenes that `refused.txt` names.
fn base(name: &str) -> String {
    let still = "fixed = true";
    let rod = "shape.cylinder = { radius = 0.01, length = 0.1 }\norientation = [0.7071067811865476, 0.7071067811865476, 0, 0]";
    match name {
        "spatial" => SPATIAL.to_owned(),
        "planar" => planar(),
        "axisymmetric" => axisymmetric(),
        "shot" => shot(),
        "l-beam" => l_beam(),
        "held" => held(SPATIAL),
        "wall" => wall(&l_beam()),
        "moving wall" => wall(&l_beam()).replace(still, "mass = 1.0\ninertia = [1, 1, 1, 0, 0, 0]"),
        "planar wall" => wall(&l_beam()).replace("\"spatial\"", "\"planar\"").replace("width = 0.05, ", ""),
        "axisymmetric wall" => wall(&axisymmetric()),
        "sliding mantle" => axisymmetric().replace("supports.z_min = \"fixed\"", "supports.side = \"roller\""),
        "bullet" => SPATIAL.replace(SPHERE, BULLET).replace("[0.0, 0.0, 0.01]", "[0.0, 0.0, 0.05]"),
        "two" => {
            SPATIAL.to_owned()
                + "[[fragment]]\nshape = { sphere = { radius = 0.006 } }\nmass = 0.001\nposition = [0.03, 0.0, 0.01]\n"
        }
        "lying rod" => SPATIAL.replace(SPHERE, rod),
        _ => panic!("refused.txt names the unknown scene {name:?}"),
    }
}

/// What is wrong with one entry of `refused.txt`, if anything.
fn objection(case: &str, expected: &str) -> Option<String> {
    let (name, change) = case.split_once(": ").expect("a case is `scene: from => to`");
    let (from, to) = change.split_once(" =>").expect("a case is `scene: from => to`");
    let (from, to) = (from.replace("\\n", "\n"), to.trim_start().replace("\\n", "\n"));
    let base = base(name);
    read(&base);
    assert!(base.contains(&from), "{case}: the scene has no {from:?}");
    match scene::read(&base.replacen(&from, &to, 1)) {
        Ok(_) => Some(format!("{case}\n    accepted")),
        Err(error) if error.to_string() == expected => None,
        Err(error) => Some(format!("{case}\n    {error}")),
    }
}

#[test]
fn every_fault_has_its_message() {
    let lines: Vec<&str> = REFUSED.lines().filter(|line| !line.is_empty() && !line.starts_with('#')).collect();
    let objections: Vec<String> = lines.chunks(2).filter_map(|pair| objection(pair[0], pair[1].trim_start())).collect();
    assert!(objections.is_empty(), "not as in refused.txt:\n{}", objections.join("\n"));
    assert!(lines.len() > 200, "refused.txt was not read");
}

#[test]
fn values_just_inside_their_bounds_are_accepted() {
    let with = |line: &str| read(&SPATIAL.replace(MASS, &format!("{MASS}\n{line}")));
    with("inertia = [1, 1, 2, 0, 0, 0]");
    with("orientation = [1.0009, 0, 0, 0]");
    read(&SPATIAL.replace("position = [0.0, 0.0, 0.01]", "position = [0.06, 0.0, -0.02]"));
    let turned = "mass = 1.0\norientation = [0.6, 0, 0.8, 0]\nangular_velocity = [0, 3, 0]";
    read(&planar().replace(MASS, turned));
    read(&axisymmetric().replace(MASS, "mass = 1.0\norientation = [0.6, 0, 0, 0.8]"));
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
    let parsed: Result<Override, _> = change.parse();
    match parsed.and_then(|change| scene::resolve(SPATIAL, &[change])) {
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
    assert_eq!(read(&resolved("gel.supports.x_min=roller")).gel.supports.x_min, scene::FaceSupport::Roller);
    let graded = read(&resolved("mesh.grading={core = 0.01, growth = 1.5, largest = 0.02}"));
    assert_eq!(graded.mesh.grading.unwrap().largest, 0.02);
    let parts = ["core=0.01", "growth=1.5", "largest=0.02"].map(|p| format!("mesh.grading.{p}").parse().unwrap());
    assert_eq!(read(&scene::resolve(SPATIAL, &parts).unwrap()), graded);
}

#[test]
fn an_override_may_replace_a_whole_table() {
    let rod = read(&resolved("projectile.shape={cylinder={radius=0.01, length=0.02}}"));
    assert_eq!(rod.projectile.shape, scene::BodyShape::Cylinder { radius: 0.01, length: 0.02, edge_radius: 0.0 });
}

#[test]
fn a_bare_word_is_text() {
    assert_eq!(read(&resolved("mesh.lattice=kuhn")).mesh.lattice, scene::CellLattice::Kuhn);
}

#[test]
fn elements_are_plain_unless_patches_are_asked_for() {
    assert_eq!(read(SPATIAL).mesh.element, scene::ElementKind::Plain);
    assert_eq!(read(&resolved("mesh.element=plain")).mesh.element, scene::ElementKind::Plain);
    assert_eq!(read(&resolved("mesh.element=patch")).mesh.element, scene::ElementKind::Patch);
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
fn a_malformed_override_is_refused() {
    not_an_override("mesh.size", "mesh.size: found no value, expected key=value, such as mesh.size=2e-3");
    not_an_override(
        "mesh.size=",
        "mesh.size: found no value, expected a TOML value, such as 2e-3, [0, 0, -2], true or \"text\"",
    );
    not_an_override(
        "mesh.size=[1,",
        "mesh.size: found `[1,`, expected a TOML value, such as 2e-3, [0, 0, -2], true or \"text\"",
    );
    not_an_override(
        "mesh..size=1",
        "mesh..size: found a broken key, expected a dotted key, such as mesh.size or fragment[1].mass",
    );
    not_an_override(
        "mesh.size.x=1",
        "mesh.size.x: found that mesh.size is a single value, expected a key inside a table",
    );
}

#[test]
fn an_override_may_name_a_component_of_a_vector() {
    let scene = scene::read(&resolved("projectile.velocity[3]=-1.5")).unwrap();
    assert_eq!(scene.projectile.velocity, [0.0, 0.0, -1.5]);
    let scene = scene::read(&resolved("projectile.velocity[1]=\"2 ft/s\"")).unwrap();
    assert!((scene.projectile.velocity[0] - 0.6096).abs() < 1e-12);
    not_an_override(
        "projectile.velocity[4]=1",
        "projectile.velocity[4]: found that projectile.velocity is a single value, expected a key inside a table",
    );
}

#[test]
fn an_override_of_an_unknown_key_is_refused_when_the_scene_is_read() {
    let text = scene::resolve(SPATIAL, &["projectile.mas=8.04 g".parse().unwrap()]).unwrap();
    assert!(scene::read(&text).unwrap_err().to_string().contains("unknown key `mas` (did you mean `mass`?)"));
    not_a_scene(
        &resolved("mesh.sizes=1"),
        "line 20: mesh.sizes: found the unknown key `sizes` (did you mean `size`?), expected one of `size`, `lattice`, `element`, `grading`, `tree`",
    );
    not_a_scene(
        &resolved("mesch.size=1"),
        "line 1: mesch: found the unknown key `mesch` (did you mean `mesh`?), expected one of `scene`, `gel`, `layer`, `projectile`, `fragment`, `load`, `sensor`, `mesh`, `remesh`, `integrator`, `contact`, `coupling`, `output`, `fidelity`, `instant`",
    );
}

#[test]
fn overrides_of_broken_text_are_refused() {
    let error = scene::resolve("[mesh\n", &[]).unwrap_err();
    assert_eq!(error.to_string(), "line 1: found `[mesh`, which is not TOML: unclosed table, expected `]`");
}

fn builtin(name: &str) -> Scene {
    scene::builtin(name).map_or_else(|| panic!("there is no {name}"), read)
}

#[test]
fn a_part_of_a_gel_that_does_not_stand_for_all_of_it_is_refused() {
    let wrong = |change: &str| {
        let changes: [Override; 1] = [change.parse().unwrap()];
        let text = scene::resolve(scene::builtin("fbi-bb-3d").unwrap(), &changes).unwrap();
        scene::read(&text).unwrap_err().to_string()
    };
    let aside = wrong("projectile.velocity=[1.0, 0.0, -179.8]");
    assert!(aside.contains("projectile.velocity") && aside.contains("gel.symmetry = \"none\""), "{aside}");
    let held = wrong("gel.supports.x_min=\"fixed\"");
    assert!(
        held.contains("gel.supports.x_min: found \"fixed\", expected nothing: the plane of symmetry is there"),
        "{held}"
    );
    let round = wrong("gel.shape={cylinder={radius=0.05, height=0.05}}");
    assert!(round.contains("gel.symmetry: found \"quarter\", expected \"none\""), "{round}");
}

#[test]
fn the_builtin_scenes_are_the_promised_ones_and_the_first_is_the_default() {
    let names: Vec<&str> = scene::builtins().map(|(name, _)| name).collect();
    let graded = ["sphere-graded-4", "sphere-graded-8", "sphere-graded-16"];
    assert_eq!(
        names,
        [
            [
                "fbi-bb",
                "fbi-bb-3d",
                "sphere-720",
                "bullet-yaw",
                "hydro-drag",
                "sphere-block",
                "sphere-deep",
                "ball-bounce",
                "bounce-visco",
                "backface-dent",
                "cavity-exact",
                "ball-square",
                "l-beam"
            ]
            .as_slice(),
            &graded
        ]
        .concat()
    );
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
    let disc = PI * 0.01 * 0.01;
    let mass = builtin("ball-square").projectile.mass.unwrap();
    assert!((mass / (7850.0 * disc) - 1.0).abs() < 1e-6, "{mass}");
}

/// Runs of `fbi-bb` whose speeds differ by a millionth rest within 0.5 mm of each other (`docs/studies.md`, *Scatter*).
#[test]
fn no_level_of_the_calibration_shot_promises_less_than_its_scatter() {
    let levels = builtin("fbi-bb").fidelity;
    for level in [levels.draft, levels.coarse, levels.standard, levels.fine, levels.reference] {
        let error = level.and_then(|level| level.error).expect("all levels are measured");
        assert!(error > 0.5 / 85.2, "{error}");
    }
}

#[test]
fn a_scene_written_as_toml_reads_as_itself() {
    for (name, text) in scene::builtins() {
        let before = read(text);
        assert_eq!(read(&toml::to_string(&before).unwrap()), before, "{name}");
    }
}

#[test]
fn a_mass_comes_from_the_density_where_none_is_given() {
    let steel = |text: &str| read(&text.replace("mass = 0.033", "density = 7850.0")).projectile.mass.unwrap();
    let (volume, section) = (4.0 / 3.0 * PI * 1e-6, PI * 1e-4);
    assert!((steel(SPATIAL) / (7850.0 * volume) - 1.0).abs() < 1e-14);
    assert!((steel(&axisymmetric()) / (7850.0 * volume) - 1.0).abs() < 1e-14);
    assert!((steel(&planar()) / (7850.0 * section) - 1.0).abs() < 1e-14);
    let thin = planar().replace("density = 1030.0", "density = 1030.0\nthickness = 0.02");
    assert!((steel(&thin) / (7850.0 * section * 0.02) - 1.0).abs() < 1e-14);
    let both = SPATIAL.replace("mass = 0.033", "mass = 0.033\ndensity = 7850.0");
    assert_eq!(read(&both).projectile.mass, Some(0.033), "a mass that is given counts");
    let rods = [("0.0", PI * 1e-4 * 0.1), ("0.005", PI * 1e-4 * 0.1)].map(|(edge, sharp)| {
        let shape = format!("shape.cylinder = {{ radius = 0.01, length = 0.1, edge_radius = {edge} }}");
        let scene = read(&SPATIAL.replace("shape.sphere.radius = 0.01", &shape).replace("0.01]", "0.05]"));
        1.0 - scene.volume(0).unwrap() / sharp
    });
    // A rounding takes the corner (1 − π/4) e² off, at about R − 0.22 e from the axis, at both ends (Pappus).
    let corner = (1.0 - PI / 4.0) * 25e-6 * 2.0 * PI * (0.01 - 0.2234 * 0.005) * 2.0 / (PI * 1e-4 * 0.1);
    assert!(rods[0].abs() < 1e-14 && (rods[1] / corner - 1.0).abs() < 1e-3, "{rods:?} {corner}");
}

/// A scene whose bodies are names of the library, on cells of 1 mm.
fn named(projectile: &str, fragment: &str) -> String {
    SPATIAL
        .replace("shape.sphere.radius = 0.01\nmass = 0.033", &format!("library = \"{projectile}\""))
        .replace(SIZE, "size = 1e-3")
        .replace("0.01]", "0.02]")
        + &format!("[[fragment]]\nlibrary = \"{fragment}\"\nposition = [0.03, 0.0, 0.02]\n")
}

#[test]
fn a_name_of_the_library_alone_gives_the_body_of_that_projectile() {
    for [projectile, fragment] in [["9mm-fmj", "bb"], ["fsp-1.1g", "45acp-fmj"]] {
        let scene = read(&named(projectile, fragment));
        for (body, name) in scene.bodies().zip([projectile, fragment]) {
            let known = scene::LibraryProjectile::named(name).unwrap();
            assert_eq!((&body.shape, body.mass), (&known.shape, Some(known.mass)), "{name}");
        }
        assert_eq!(read(&toml::to_string(&scene).unwrap()), scene, "the scene with its values reads as itself");
    }
    let held = named("9mm-fmj", "bb").replace(VELOCITY, "fixed = true");
    assert_eq!(read(&held).projectile.mass, None, "a body that is held has no mass");
}

#[test]
fn the_values_of_the_library_are_written_out_where_the_text_has_none() {
    let own = named("9mm-fmj", "bb").replace("library = \"bb\"", "library = \"bb\"\nmass = \"0.343 g\"");
    for text in [named("9mm-fmj", "bb"), own] {
        let filled = scene::fill_bodies(&text).unwrap();
        assert_eq!(read(&filled), read(&text));
        let without_names: String = filled
            .lines()
            .filter(|line| !line.starts_with("library"))
            .fold(String::new(), |text, line| text + line + "\n");
        let (with, without) = (read(&text), read(&without_names));
        let shape_and_mass = |scene: &Scene| scene.bodies().map(|b| (b.shape.clone(), b.mass)).collect::<Vec<_>>();
        assert_eq!(shape_and_mass(&with), shape_and_mass(&without));
    }
    assert_eq!(scene::fill_bodies(SPATIAL).unwrap(), SPATIAL);
}

/// The message of a scene with overrides that is refused, and the overrides at fault.
#[track_caller]
fn refused_with(text: &str, changes: &[&str]) -> (String, Vec<String>) {
    let changes: Vec<Override> = changes.iter().map(|change| change.parse().expect("a key and a value")).collect();
    let refused = scene::read_with(text, &changes, &scene::no_files).expect_err("a scene that is refused");
    (refused.error.to_string(), refused.overrides.into_iter().map(|o| o.key).collect())
}

#[test]
fn the_name_of_another_body_is_refused_with_the_keys_to_remove() {
    let fbi = scene::builtin("fbi-bb").unwrap();
    let (message, at_fault) = refused_with(fbi, &["projectile.library=45acp-fmj"]);
    let found =
        "projectile.library: found \"45acp-fmj\" beside another body: projectile.mass = 0.000343 (the library has";
    assert!(message.starts_with(found), "{message}");
    let remedy = "remove projectile.mass and projectile.shape for the body of the library, or projectile.library for a";
    assert!(message.contains(remedy), "{message}");
    assert_eq!(at_fault, ["projectile.library"]);
    let own_name = scene::resolve(fbi, &["projectile.library=bb".parse().unwrap()]).unwrap();
    assert_eq!(read(&own_name).projectile.mass, read(fbi).projectile.mass, "its own name is no contradiction");
    let filled = scene::fill_bodies(&named("9mm-fmj", "bb")).unwrap();
    let (message, _) = refused_with(&filled, &["fragment[1].library=sphere-4.8mm"]);
    assert!(message.contains("remove fragment[1].mass and fragment[1].shape"), "{message}");
    let (message, _) = refused_with(&named("9mm-fmj", "bb"), &["projectile.mass=8 g", "projectile.library=9mm-fmj"]);
    assert!(message.contains("remove projectile.mass for"), "{message}");
}

#[test]
fn another_name_is_refused_where_the_scene_is_chosen_for_the_first_one() {
    let (message, at_fault) =
        refused_with(&named("9mm-fmj", "bb"), &["mesh.size=2e-3", "projectile.library=45acp-fmj"]);
    assert_eq!(at_fault, ["projectile.library"]);
    assert_eq!(
        message,
        "projectile.library: found \"45acp-fmj\" in a scene of \"9mm-fmj\", expected \"9mm-fmj\", for which start, cells \
         and times of the scene are chosen: `gelfmu new --projectile 45acp-fmj` writes a scene of this one"
    );
}

#[test]
fn an_override_of_a_value_of_the_library_makes_the_body_that_of_the_scene() {
    let text = named("9mm-fmj", "bb").replace("library = \"bb\"", "library = \"bb\"\nlibrary_version = 1");
    let library = |name: &str| scene::LibraryProjectile::named(name).unwrap();
    let with = |changes: &[&str]| {
        let changes: Vec<Override> = changes.iter().map(|change| change.parse().unwrap()).collect();
        read(&scene::resolve(&text, &changes).unwrap())
    };
    let heavy = with(&["projectile.mass=9 g"]).projectile;
    assert_eq!((heavy.library, heavy.mass, heavy.shape), (None, Some(9e-3), library("9mm-fmj").shape));
    let flat = with(&["projectile.shape.bullet.nose=flat"]).projectile;
    assert_eq!((flat.library, flat.mass), (None, Some(library("9mm-fmj").mass)));
    let light = with(&["fragment[1].density=2700"]);
    assert_eq!((&light.fragment[0].library, light.projectile.library.as_deref()), (&None, Some("9mm-fmj")));
    assert!((light.fragment[0].mass.unwrap() / library("bb").mass - 2700.0 / 7850.0).abs() < 1e-3);
    assert_eq!(with(&["projectile.velocity[3]=-9"]).projectile.library.as_deref(), Some("9mm-fmj"));
}

/// Fragment tables that the documents show.
fn shown(document: &str) -> impl Iterator<Item = &str> {
    let blocks = document.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap_or_default());
    blocks.filter(|block| block.starts_with("[[fragment]]"))
}

#[test]
fn the_fragment_tables_of_the_documents_can_be_copied() {
    let (scenes, guide) = (include_str!("../../docs/scenes.md"), include_str!("../../docs/coupling.md"));
    let ball = scene::builtin("sphere-block").unwrap();
    for (document, n) in [(scenes, 2), (guide, 2)] {
        let scene = read(&(ball.to_owned() + "\n" + &shown(document).collect::<String>()));
        assert_eq!(scene.fragment.len(), n);
        assert!(matches!(scene.fragment[1].shape, scene::BodyShape::Dome { .. }));
    }
    let free = shown(guide).nth(1).expect("the guide shows two").replace("fixed = true", "mass = 1.0");
    let refused = scene::read(&(ball.to_owned() + "\n" + &free)).unwrap_err().to_string();
    assert!(refused.contains("inertia"), "{refused}");
}
