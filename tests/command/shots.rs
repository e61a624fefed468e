//! Projectiles of the library, scenes of shots, and their comparison with measured shots.

use super::{folder, gelfmu, gelfmu_in, json, refused};
use ballistic_gel::scene;
use std::fs;

#[test]
fn projectiles_lists_the_library_and_prints_one_with_its_sources() {
    let said = gelfmu(&["projectiles"]);
    assert!(scene::library().all(|(name, _)| said.out.contains(name)), "{}", said.out);
    let bullet = gelfmu(&["projectiles", "9mm-fmj"]);
    assert!(bullet.out.contains("mass = \"124 gr\"") && bullet.out.contains("[source]"), "{}", bullet.out);
    let value = json(&gelfmu(&["projectiles", "9mm-fmj", "--json"]).out);
    assert_eq!(value["mass"], 0.008_035_064_84);
    let unknown = gelfmu(&["projectiles", "9mm-fmk"]);
    assert_eq!(unknown.status, Some(2));
    assert!(unknown.err.contains("9mm-fmj"), "{}", unknown.err);
}

#[test]
fn new_writes_a_scene_that_checks_and_never_over_a_file() {
    let folder = folder();
    let shot = ["new", "--projectile", "9mm-fmj", "--speed", "1150 ft/s", "--yaw", "2", "--block", "15x15x40cm"];
    let with_file = [&shot[..], &["--out", "my.toml"]].concat();
    let said = gelfmu_in(folder.path(), &with_file);
    assert_eq!((said.status, said.err.as_str()), (Some(0), ""), "{}", said.out);
    let text = fs::read_to_string(folder.path().join("my.toml")).unwrap();
    let scene = scene::read(&text).unwrap();
    assert_eq!(scene.projectile.velocity, [0.0, 0.0, -350.52]);
    assert_eq!(text, gelfmu(&shot).out);
    assert!(text.contains("\nlibrary = \"9mm-fmj\"\nlibrary_version = 1\n# mass = 0.00803506484 # [R: "), "{text}");
    assert!(!text.contains("\nmass = ") && !text.contains("\nshape.bullet"), "{text}");
    let again = gelfmu_in(folder.path(), &with_file);
    assert_eq!(again.status, Some(2));
    assert!(again.err.contains("which is not replaced"), "{}", again.err);
    assert_eq!(fs::read_to_string(folder.path().join("my.toml")).unwrap(), text);
    let checked = gelfmu_in(folder.path(), &["check", "my.toml", "--set", "scene.fidelity=draft"]);
    assert!(checked.out.contains("The scene is valid"), "{}{}", checked.out, checked.err);
    assert!(checked.out.contains("from the library, version 1: 9mm-fmj, 9 mm Luger"), "{}", checked.out);
    assert!(checked.out.contains("projectile.mass = 0.00803506484: [R: "), "{}", checked.out);
    let other = gelfmu_in(folder.path(), &["check", "my.toml", "--set", "projectile.library=45acp-fmj"]);
    assert_eq!(other.status, Some(2));
    assert!(other.err.contains("`gelfmu new --projectile 45acp-fmj` writes a scene of this one"), "{}", other.err);
    refused(&["new", "--projectile", "bb", "--yaw", "2"], "--yaw 2: a sphere has no axis that could yaw; leave it out");
}

#[test]
fn new_and_check_warn_of_a_block_and_a_level_that_do_not_fit() {
    let folder = folder();
    let shot = ["new", "--projectile", "45acp-185-silvertip-recovered", "--block", "10x10x10cm", "--out", "small.toml"];
    let said = gelfmu_in(folder.path(), &shot);
    assert!(said.err.starts_with("warning: gel.shape: the temporary cavity of projectile"), "{}", said.err);
    let doubts = |set: &str| {
        let said = gelfmu_in(folder.path(), &["check", "small.toml", "--set", set, "--json"]);
        assert_eq!(said.status, Some(0), "{}", said.err);
        json(&said.out)["doubts"].as_array().unwrap().iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    // Cells of `draft` grow up to a size that a narrow block has room for.
    let all = doubts("scene.fidelity=draft");
    assert!(all.iter().any(|doubt| doubt.contains("room for 113 mm")), "{all:?}");
    assert!(!all.iter().any(|doubt| doubt.contains("fidelity")), "{all:?}");
    let refused = doubts("fidelity.draft.set=[\"mesh.size=0.02\"]");
    assert!(refused.iter().any(|doubt| doubt.contains("`gelfmu run --fidelity draft` will refuse")), "{refused:?}");
}

#[test]
fn new_puts_layers_on_the_gel_and_check_describes_them() {
    let folder = folder();
    let skin = "2mm,name=skin,strength_scale=3,density=1100";
    let shot = ["new", "--projectile", "bb", "--layer", skin, "--layer", "5mm,preset=gelatin-20", "--out", "skin.toml"];
    let said = gelfmu_in(folder.path(), &shot);
    assert_eq!((said.status, said.err.as_str()), (Some(0), ""), "{}", said.out);
    let scene = scene::read(&fs::read_to_string(folder.path().join("skin.toml")).unwrap()).unwrap();
    assert_eq!(scene.layer.iter().map(|layer| layer.thickness).collect::<Vec<_>>(), [2e-3, 5e-3]);
    let checked = gelfmu_in(folder.path(), &["check", "skin.toml", "--set", "scene.fidelity=draft", "--json"]);
    assert_eq!(checked.status, Some(0), "{}", checked.err);
    let result = json(&checked.out);
    let told =
        |key: &str, part: &str| result[key].as_array().unwrap().iter().any(|line| line.to_string().contains(part));
    assert!(told("modelled", "layer[1]: skin, 0.002 m thick, 3.0000 times the strength"), "{result}");
    assert!(told("doubts", "no model error of shots through layers is known"), "{result}");
    assert!(result["model_error"].is_null() && result["values"]["layer"][1]["strength_scale"] == 1.95, "{result}");
    for (layer, part) in [
        ("2mm,strength=3", "found the key \"strength\", expected a thickness, and after commas name=, preset="),
        ("0.2mm", "layer[1].thickness: found 0.0002, expected at least mesh.size, 0.00027 m"),
    ] {
        let said = gelfmu(&["new", "--projectile", "bb", "--layer", layer]);
        assert!(said.status == Some(2) && said.err.contains(part), "{layer}: {}", said.err);
    }
}

#[test]
fn a_run_takes_values_with_units() {
    let folder = folder();
    let set = ["--set", "projectile.mass=0.343 g", "--set", "scene.end_time=20 us", "--set", "mesh.size=0.54 mm"];
    let arguments =
        [&["run", "fbi-bb", "--direct", "--step", "10 us", "--no-frames", "--no-report"], &set[..]].concat();
    let said = gelfmu_in(folder.path(), &arguments);
    assert_eq!(said.status, Some(0), "{}", said.err);
    let kept = fs::read_to_string(folder.path().join("gelfmu-out/fbi-bb/scene.toml")).unwrap();
    assert!(kept.contains("mass = \"0.343 g\""), "{kept}");
    let length = gelfmu(&["check", "fbi-bb", "--set", "projectile.mass=9 mm"]);
    assert_eq!(length.status, Some(2));
    assert!(length.err.contains("projectile.mass"), "{}", length.err);
}
