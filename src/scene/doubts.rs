//! Warnings about a scene before it runs: it can be computed, but its figures may mislead.

use super::block_fit::approach;
use super::model_error::{ShotFigures, calibre, extent, has_networks_of, preset_of, shot_class};
use super::{
    BranchSpec, DifferingValue, Dimension, LibraryProjectile, MaterialModel, Preset, ProjectileSpec, Scene,
    block_doubts, body_name, describe_instant, numbered,
};
use crate::geometry::{ShapeGeometry, SignedDistance};
use crate::math::Vector3;

/// Greatest plausible density of a projectile, kg/m³: osmium, the densest material, has 22 590.
const DENSEST: f64 = 25e3;
/// Ratio of length to width from which a body counts as long.
const LONG: f64 = 1.05;

/// Reasons to doubt the results of the scene, one sentence each.
#[must_use]
pub fn doubts(scene: &Scene) -> Vec<String> {
    let bodies = (0..scene.n_bodies()).flat_map(|body| doubts_of(scene, body));
    let changed = scene.bodies().enumerate().flat_map(|(i, body)| {
        let projectile = body.library.as_deref().and_then(LibraryProjectile::named);
        projectile.map_or_else(Vec::new, |projectile| changed_values(&body_name(i), body, &projectile))
    });
    let of_gel = short_relaxation(scene).into_iter().chain(layer_doubts(scene));
    let told = |class| format!("scene.fidelity is instant: {}", describe_instant(class));
    let of_level = scene.reduced_class().map(told);
    of_level.into_iter().chain(bodies).chain(changed).chain(of_gel).chain(block_doubts(scene)).collect()
}

/// Doubts about layers: nothing is known of their validity, and a preset may meet a gel of another bulk modulus.
fn layer_doubts(scene: &Scene) -> Vec<String> {
    if scene.layer.is_empty() {
        return vec![];
    }
    let unknown = "layer: no model error of shots through layers is known, only perforation thresholds of skin were compared; strength \
                   and density of skin, bone or cloth are values of the scene";
    let of_preset = |preset: Option<Preset>| preset?.network_value("gel.bulk_modulus")?.parse::<f64>().ok();
    let reduced = of_preset(scene.gel.preset).map(|own| scene.gel.bulk_modulus / own).filter(|ratio| *ratio != 1.0);
    let unequal = scene.layer.iter().enumerate().filter_map(|(i, layer)| {
        let (ratio, modulus) = (reduced?, of_preset(layer.preset)?);
        let key = numbered("layer", i) + ".bulk_modulus";
        (layer.bulk_modulus == Some(modulus)).then(|| {
            format!(
                "{key} is that of its preset, {modulus:?} Pa, and gel.bulk_modulus is {ratio:.3} times that of its own: waves \
                 are reflected where these gels meet; give {key} = {:.3e}",
                ratio * modulus
            )
        })
    });
    std::iter::once(unknown.to_owned()).chain(unequal).collect()
}

/// Values of a body that the library has changed since the version that the scene states.
fn changed_values(table: &str, body: &ProjectileSpec, projectile: &LibraryProjectile) -> Vec<String> {
    let Some(version) = body.library_version.filter(|version| *version < projectile.since) else { return vec![] };
    let told = |DifferingValue { key, values: [own, known] }: DifferingValue| {
        let LibraryProjectile { name, since, .. } = projectile;
        format!("{table}.{key} is {own}, of version {version} of the library: {name} has {known} since version {since}")
    };
    projectile.differences(body).into_iter().map(told).collect()
}

/// Doubts about branches that relax within less than a step: the mesh and the step decide what their springs store.
fn short_relaxation(scene: &Scene) -> Vec<String> {
    let gel = &scene.gel;
    if gel.material != MaterialModel::TwoNetwork {
        return vec![];
    }
    let sound = (gel.bulk_modulus / gel.density).sqrt();
    let (step, rate) = (scene.integrator.cfl() * scene.mesh.size / sound, greatest_rate(scene));
    let doubt = |(i, branch): (usize, &BranchSpec)| {
        let (time, at) = relaxation_time(branch, rate)?;
        (time < step).then(|| {
            format!(
                "{}.{at} a relaxation time of {time:.1e} s, less than a step of the elements, about {step:.1e} s: the \
                 branch acts as a dashpot without its spring",
                numbered("gel.branches", i)
            )
        })
    };
    gel.branches.iter().enumerate().filter_map(doubt).collect()
}

/// Returns the relaxation time of a branch, s, and a phrase with its key; none for a power law without a rate, 1/s.
fn relaxation_time(branch: &BranchSpec, rate: f64) -> Option<(f64, String)> {
    if let Some(law) = branch.power_law {
        // A dashpot that saturates bears its stress at any greater rate, whatever its spring stores.
        let most = law.rate.unwrap_or(f64::INFINITY);
        let at = if rate < most { "the rate of the impact" } else { "the rate at which it saturates" };
        let rate = rate.min(most);
        let time = law.law().stress_at(rate) / (3.0 * branch.shear_modulus * rate);
        return (rate > 0.0).then(|| (time, format!("power_law has at {at}, {rate:.1e}/s,")));
    }
    branch.time.map(|time| (time, "time gives".to_owned()))
}

/// Returns the greatest rate of deformation, 1/s: the speed of a body over its radius.
fn greatest_rate(scene: &Scene) -> f64 {
    let rate = |body: usize| {
        let (projectile, shape) = (scene.body(body), scene.shape(body));
        let is_still = projectile.fixed || !projectile.active || shape.volume().is_none();
        if is_still { 0.0 } else { 2.0 * approach(scene, projectile).norm() / calibre(&shape) }
    };
    (0..scene.n_bodies()).map(rate).fold(0.0, f64::max)
}

/// Doubts about one body; none about a fixed or inactive body.
fn doubts_of(scene: &Scene, body: usize) -> Vec<String> {
    let (projectile, shape) = (scene.body(body), scene.shape_in_gel(body));
    if projectile.fixed || !projectile.active {
        return vec![];
    }
    let name = body_name(body);
    let has_own_networks = preset_of(scene).is_some_and(|preset| has_networks_of(&scene.gel, preset));
    let all = [
        density(scene, body),
        not_modelled(projectile).map(|what| format!("{name} {}. {what}", simplification(projectile))),
        is_turned_away(scene, projectile)
            .then(|| format!("{name}.velocity points away from the gel: the body will not strike it")),
        held_straight(scene, &shape).map(|found| format!("{name}.shape is {found}")),
        outside_classes(scene, projectile, &shape)
            .filter(|_| shot_class(scene, body).is_none() && has_own_networks)
            .map(|found| format!("{name} {found}")),
    ];
    all.into_iter().flatten().collect()
}

/// Simplification of a body.
fn simplification(body: &ProjectileSpec) -> &'static str {
    if body.expansion.is_some() { "is homogeneous and opens by a law" } else { "is rigid and homogeneous" }
}

/// Behaviour of a projectile of the library that a rigid body does not have.
fn not_modelled(body: &ProjectileSpec) -> Option<String> {
    let what = LibraryProjectile::named(body.library.as_deref()?)?.not_modelled?;
    Some(what.trim_end_matches('.').to_owned())
}

/// Doubt about an implausible density.
fn density(scene: &Scene, body: usize) -> Option<String> {
    let density = scene.body(body).mass? / scene.volume(body)?;
    let name = body_name(body);
    let given = format!("{name}.mass gives a density of {:.3} g/cm³", 1e-3 * density);
    if density > DENSEST {
        return Some(format!(
            "{given}, more than any material has ({:.0} g/cm³): give its mass in kg and its lengths in m, or with units, as in \"8.04 g\"",
            1e-3 * DENSEST
        ));
    }
    let gel = scene.gel.density;
    (density < gel).then(|| format!("{given}, less than the gel has ({:.3} g/cm³)", 1e-3 * gel))
}

/// Returns true if a body outside of a block or cylinder moves away from it.
fn is_turned_away(scene: &Scene, body: &ProjectileSpec) -> bool {
    let (position, approach) = (Vector3::from(body.position), approach(scene, body));
    let Some(gel) = scene.gel.shape.bounding_box() else { return false };
    let way = position.sup(&gel.lower).inf(&gel.upper) - position;
    approach != Vector3::zeros() && way != Vector3::zeros() && approach.dot(&way) <= 0.0
}

/// Doubt about a long body that penetrates and cannot yaw.
fn held_straight(scene: &Scene, shape: &ShapeGeometry) -> Option<String> {
    shape.volume()?;
    let along = extent(shape, Vector3::z());
    let held = scene.freedom() == Dimension::Axisymmetric && scene.gel.material == MaterialModel::TwoNetwork;
    (held && along > LONG * calibre(shape)).then(|| {
        "longer than wide and cannot yaw in this scene: a real body turns over, the computed depth may be twice as \
         great; use a spatial scene with an initial yaw and gel.symmetry = \"half\" (gelfmu new … --yaw 2)"
            .to_owned()
    })
}

/// Doubt about a shot outside the classes that the preset was fitted to or checked with.
fn outside_classes(scene: &Scene, body: &ProjectileSpec, shape: &ShapeGeometry) -> Option<String> {
    let (preset, shot) = (preset_of(scene)?, ShotFigures::of(scene, body, shape)?);
    let classes: Vec<String> = preset.shots().classes.iter().map(ToString::to_string).collect();
    Some(format!(
        "is {:.2} calibres long, has a calibre of {:.2} mm and a speed of {:.1} m/s: no class of shots whose model error is \
         known for gel.preset = \"{}\" is like it ({}); compare with a measured depth of your own (gelfmu calibrate)",
        shot.aspect,
        1e3 * shot.calibre,
        shot.speed,
        preset.name(),
        classes.join("; ")
    ))
}

#[cfg(test)]
mod tests {
    use super::super::{Override, builtin, builtins, read, resolve};
    use super::*;

    fn doubts_with(name: &str, changes: &[&str]) -> Vec<String> {
        let changes: Vec<Override> = changes.iter().map(|change| change.parse().unwrap()).collect();
        doubts(&read(&resolve(builtin(name).unwrap(), &changes).unwrap()).unwrap())
    }

    #[test]
    fn built_in_scenes_are_doubted_where_it_is_meant() {
        for (name, text) in builtins() {
            let found = doubts(&read(text).unwrap());
            let expected: &[&str] = match name {
                // A ball of extreme mass.
                "hydro-drag" => &["projectile.mass"],
                _ => &[],
            };
            assert_eq!(found.len(), expected.len(), "{name}: {found:?}");
            assert!(found.iter().zip(expected).all(|(found, part)| found.contains(part)), "{name}: {found:?}");
        }
    }

    #[test]
    fn an_implausible_projectile_is_doubted_by_key() {
        for (name, change, part) in [
            ("fbi-bb", "projectile.mass=0.343", "more than any material has (25 g/cm³)"),
            ("fbi-bb", "projectile.mass=4e-5", "less than the gel has (1.030 g/cm³)"),
            ("fbi-bb", "projectile.velocity=[0, 0, 179.8]", "projectile.velocity points away"),
            ("sphere-block", "projectile.velocity=[3, 0, 0.1]", "projectile.velocity points away"),
            ("fbi-bb", "projectile.velocity=[0, 0, -350]", ""),
            ("fbi-bb", "projectile.velocity=[0, 0, -1300]", "no class of shots whose model error is known"),
            (
                "fbi-bb",
                "projectile.shape={capsule={radius=2.185e-3,length=8e-3}};projectile.position=[0, 0, 0.004]",
                "cannot yaw",
            ),
        ] {
            let found = doubts_with(name, &change.split(';').collect::<Vec<_>>());
            let told = found.iter().filter(|doubt| !part.is_empty() && doubt.contains(part)).count();
            assert_eq!(told, usize::from(!part.is_empty()), "{change}: {found:?}");
            assert!(!part.is_empty() || found.is_empty(), "{change}: {found:?}");
        }
    }

    #[test]
    fn values_that_the_library_has_changed_since_the_stated_version_are_doubted() {
        let mut scene = read(builtin("fbi-bb").unwrap()).unwrap();
        let named = LibraryProjectile::named("bb").unwrap();
        let changed = LibraryProjectile { since: 3, mass: 0.35e-3, ..named };
        for (version, expected) in [(None, 0), (Some(3), 0), (Some(2), 1)] {
            scene.projectile.library_version = version;
            let found = changed_values("projectile", &scene.projectile, &changed);
            assert_eq!(found.len(), expected, "{found:?}");
            let told = "projectile.mass is 0.000343, of version 2 of the library: bb has 0.00035 since version 3";
            assert!(found.iter().all(|doubt| doubt == told), "{found:?}");
        }
    }

    #[test]
    fn layers_are_doubted_and_so_is_a_preset_beside_a_softer_gel() {
        let layer = |keys: &str| doubts_with("fbi-bb", &[&format!("layer=[{{thickness=2e-3{keys}}}]")]);
        let [unknown] = &layer(", strength_scale=3.0")[..] else { panic!("{:?}", layer(", strength_scale=3.0")) };
        assert!(unknown.contains("no model error of shots through layers"), "{unknown}");
        let found = layer(", preset='gelatin-20'");
        let told =
            "layer[1].bulk_modulus is that of its preset, 2610000000.0 Pa, and gel.bulk_modulus is 0.277 times that of";
        assert!(found.len() == 2 && found[1].starts_with(told), "{found:?}");
        assert_eq!(layer(", preset='gelatin-20', bulk_modulus=723e6").len(), 1);
    }

    #[test]
    fn a_branch_that_relaxes_within_a_step_is_doubted_by_key() {
        let law = |stress: f64| {
            format!("gel.branches=[{{shear_modulus=4.8e6, power_law={{stress={stress}, exponent=0.8}}}}]")
        };
        // 37 / (3 * 4.8e6) * 82288^(-0.2) s = 2.67e-7 s against 0.8 * 0.27e-3 / 800 s = 2.70e-7 s.
        let rate = "gel.branches[1].power_law has at the rate of the impact, 8.2e4/s, a relaxation time of 2.7e-7 s, \
                    less than a step of the elements, about 2.7e-7 s";
        let linear =
            "gel.branches[2].time gives a relaxation time of 1.0e-7 s, less than a step of the elements, about";
        let both = "gel.branches=[{shear_modulus=1e3, time=1e-3}, {shear_modulus=1e3, time=1e-7}]";
        for (changes, part) in [
            (vec![law(37.0)], rate),
            (vec![law(38.0)], ""),
            // One that saturates bears its stress.
            (vec![law(1e5).replace("exponent", "rate=1e3, exponent")], ""),
            (vec![law(37.0), "projectile.velocity=[0, 0, 0]".to_owned()], ""),
            (vec![both.to_owned()], linear),
        ] {
            let found = doubts_with("fbi-bb", &changes.iter().map(String::as_str).collect::<Vec<_>>());
            assert_eq!(found.len(), usize::from(!part.is_empty()), "{changes:?}: {found:?}");
            assert!(found.iter().all(|doubt| doubt.starts_with(part)), "{changes:?}: {found:?}");
        }
    }

    #[test]
    fn a_long_body_that_can_yaw_or_does_not_go_in_is_not_doubted_for_it() {
        let capsule = "projectile.shape={capsule={radius=0.01,length=0.03}}";
        assert!(
            doubts_with("sphere-block", &[capsule, "projectile.mass=0.08", "projectile.position=[0, 0, 0.015]"])
                .is_empty()
        );
        let quarter = ["gel.symmetry=quarter", "gel.preset=gelatin-10", "gel.material=two-network"];
        let found = doubts_with("bullet-yaw", &[quarter[0], "projectile.orientation=[1, 0, 0, 0]"]);
        assert!(found.iter().any(|doubt| doubt.contains("cannot yaw")), "{found:?}");
    }
}
