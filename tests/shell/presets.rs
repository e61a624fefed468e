//! Gels that are known by name: what they fill, what a scene sets over them, and that the documentation says the same.

use ballistic_gel::scene::{self, ApplicableModels, Override, Preset, PresetValue, Scene};

/// A gel of which only the shape is said, and its name.
const NAMED: &str = r#"
[scene]
name = "named"
dimension = "axisymmetric"
end_time = 1e-4
communication_step = 1e-5
[gel]
shape.cylinder = { radius = 0.05, height = 0.1 }
preset = "gelatin-10"
[projectile]
shape.sphere.radius = 5e-3
mass = 4e-3
position = [0.0, 0.0, 5e-3]
[mesh]
size = 5e-3
"#;
const DOCUMENT: &str = include_str!("../../docs/materials.md");

fn read(text: &str, changes: &[&str]) -> Result<Scene, String> {
    let changes: Vec<Override> = changes.iter().map(|change| change.parse().unwrap()).collect();
    scene::read(&scene::resolve(text, &changes).unwrap()).map_err(|error| error.to_string())
}

/// Whether a scene has the value of a fact.
fn has(scene: &Scene, fact: &PresetValue) -> bool {
    let mut found = toml::Value::try_from(scene).unwrap();
    for name in fact.key.split('.') {
        found = found[name].clone();
    }
    let told: toml::Table = toml::from_str(&format!("value = {}", fact.value)).unwrap();
    found == told["value"]
}

const MODELS: [&str; 2] = ["two-network", "neo-hookean"];

#[test]
fn a_preset_fills_what_a_scene_does_not_set() {
    for preset in Preset::ALL {
        for model in MODELS {
            let (named, made) = (format!("gel.preset={}", preset.name()), format!("gel.material={model}"));
            let scene = read(NAMED, &[&named, &made]).unwrap();
            let facts: Vec<&PresetValue> = preset.facts().iter().filter(|fact| fact.of.includes(model)).collect();
            assert!(facts.len() >= 4, "{model}: {facts:?}");
            for fact in facts.into_iter().filter(|fact| fact.key != "gel.material") {
                assert!(has(&scene, fact), "{}, {model}: {fact:?}", preset.name());
            }
        }
        assert!(preset.facts().iter().all(|fact| fact.key == "gel.material"
            || fact.of != ApplicableModels::All
            || ["gel.density", "gel.shear_modulus"].contains(&fact.key)));
    }
}

#[test]
fn a_value_set_by_a_scene_overrides_its_preset_at_any_depth() {
    let scene = read(NAMED, &["gel.damage.critical_stretch=2.5", "gel.density=1000.0"]).unwrap();
    let damage = scene.gel.damage.unwrap();
    assert_eq!((damage.critical_stretch, damage.delay, scene.gel.density), (2.5, 10e-6, 1000.0));
    let text = scene::resolve(NAMED, &["gel.density=1000.0".parse().unwrap()]).unwrap();
    let given = scene::from_preset(&text);
    assert!(
        given.iter().any(|fact| fact.key == "gel.damage.delay") && given.iter().all(|fact| fact.key != "gel.density")
    );
    assert_eq!(read(&toml::to_string(&scene).unwrap(), &[]).unwrap(), scene);
}

#[test]
fn presets_are_refused_by_name_and_a_gel_without_one_must_say_what_it_is() {
    for (changes, said) in [
        (
            &["gel.preset=gelatin-12"][..],
            "line 9: gel.preset: found \"gelatin-12\" (did you mean `gelatin-10`?), expected one of `gelatin-10`, `gelatin-20`",
        ),
        (&["gel.damage=3.0"], "gel.damage: found 3.0, expected a table"),
        (&["gel.material=ogden"], "gel.bulk_modulus: found nothing, expected this key"),
        (&["gel.damage.critical_stretch=0.5"], "gel.damage.critical_stretch: found 0.5, expected a stretch above 1"),
        (&["gel.branches=[]"], "gel.damage: found damage without a branch, expected at least one gel.branches"),
    ] {
        let error = read(NAMED, changes).unwrap_err();
        assert!(error.contains(said), "{changes:?}: {error}");
    }
    let error = scene::read(&NAMED.replace("preset = \"gelatin-10\"\n", "")).unwrap_err();
    assert!(error.to_string().contains("gel.material: found nothing"), "{error}");
}

#[test]
fn the_gels_of_both_shots_are_those_that_they_were_measured_with() {
    for (name, bulk, volume, quadratic) in
        [("fbi-bb", 659.2e6, (0.0, 2e6), 0.0), ("sphere-720", 2.38e9, (2.0, 5e6), 1.2)]
    {
        let scene = scene::read(scene::builtin(name).unwrap()).unwrap();
        let gel = &scene.gel;
        let (damage, own, viscosity) = (gel.damage.unwrap(), gel.volume.unwrap(), gel.viscosity.unwrap());
        assert_eq!((gel.density, gel.bulk_modulus, gel.strength_scale), (1030.0, bulk, 1.0), "{name}");
        assert_eq!((damage.critical_stretch, damage.delay), (3.0, 10e-6), "{name}");
        let facts = Preset::Gelatin10.facts().iter().filter(|fact| fact.of.includes("two-network"));
        let networks = facts.filter(|fact| ["gel.shear_modulus", "gel.branches"].contains(&fact.key));
        assert_eq!(networks.filter(|fact| has(&scene, fact)).count(), 2, "{name}");
        assert_eq!((own.hugoniot_slope, own.tension_limit.unwrap()), volume, "{name}");
        assert_eq!((viscosity.linear, viscosity.quadratic), (0.05, quadratic), "{name}");
    }
}

/// The rows of the table of a preset.
fn rows(preset: Preset) -> Vec<String> {
    let of = |fact: &PresetValue| match fact.of {
        ApplicableModels::All => "all",
        ApplicableModels::NeoHookean => "neo-hookean",
        ApplicableModels::TwoNetwork => "two-network",
    };
    preset.facts().iter().map(|f| format!("| `{}` | `{}` | {} | {} |", f.key, f.value, of(f), f.source)).collect()
}

#[test]
fn the_document_lists_every_value_with_its_source() {
    for preset in Preset::ALL {
        let heading = format!("### `{}`\n\n| key | value | materials | source |\n|---|---|---|---|\n", preset.name());
        let expected = heading + &rows(preset).join("\n") + "\n";
        assert!(DOCUMENT.contains(&expected), "docs/materials.md should have\n{expected}");
    }
}

#[test]
fn the_document_says_which_shots_each_preset_was_fitted_to() {
    for preset in Preset::ALL {
        let shots = preset.shots();
        let said = format!("Fitted to {}. Validated on {}. A shot", shots.fitted, shots.validated);
        assert_eq!(DOCUMENT.matches(&said).count(), 1, "docs/materials.md should have {said}");
    }
}
