//! Model error of a shot: how far the figures of its class, computed with the gel of a preset, are from measured ones.

use super::block_fit::approach;
use super::preset::ShotClass;
use super::{BodyShape, Dimension, GelSpec, MaterialModel, Preset, ProjectileSpec, Scene};
use crate::geometry::{ShapeGeometry, SignedDistance};
use crate::math::Vector3;
use std::fmt;

/// Relative margin around the speeds, calibres and lengths of a class: its data are no sharper.
const MARGIN: f64 = 0.1;
/// Keys of the networks of a gel, but for their scale: all presets have the same values.
const MODULI: [&str; 2] = ["gel.shear_modulus", "gel.branches"];
/// Keys of the damage of a gel: with other networks and damage the model error of the preset is not that of the gel.
const DAMAGE: [&str; 2] = ["gel.damage.critical_stretch", "gel.damage.delay"];

/// Returns the class of shots to which a body belongs that flies at the gel of a preset.
#[must_use]
pub fn shot_class(scene: &Scene, body: usize) -> Option<&'static ShotClass> {
    let preset = preset_of(scene).filter(|preset| has_networks_of(&scene.gel, *preset))?;
    let projectile = scene.body(body);
    let shot = ShotFigures::of(scene, projectile, &scene.shape_in_gel(body))?;
    let is_ball = matches!(projectile.shape, BodyShape::Sphere { .. });
    preset.shots().classes.iter().find(|class| class.is_of_balls == is_ball && class.has(&shot))
}

/// Returns the preset of a gel without layers that can be penetrated by a body, not by a prism.
pub(super) fn preset_of(scene: &Scene) -> Option<Preset> {
    let can_penetrate = scene.gel.material == MaterialModel::TwoNetwork && scene.layer.is_empty();
    scene.gel.preset.filter(|_| can_penetrate && scene.scene.dimension != Dimension::Planar)
}

/// Returns true if networks and damage of a gel are those of a preset.
pub(super) fn has_networks_of(gel: &GelSpec, preset: Preset) -> bool {
    let scale = preset.network_value("gel.strength_scale").map_or(Some(1.0), |text| text.parse().ok());
    has_values_of(gel, preset, &[MODULI, DAMAGE].concat()) && scale == Some(gel.strength_scale)
}

/// Returns true if the networks of a gel are those of its preset but for their scale.
pub(super) fn has_moduli_of_preset(gel: &GelSpec) -> bool {
    gel.preset.is_some_and(|preset| has_values_of(gel, preset, &MODULI))
}

/// Returns true if the values of these keys of a gel are those of a preset.
fn has_values_of(gel: &GelSpec, preset: Preset, keys: &[&str]) -> bool {
    let Ok(own) = toml::Value::try_from(gel) else { return false };
    let is_same = |key: &&str| {
        let found = key.split('.').skip(1).try_fold(&own, |value, name| value.get(name));
        let told = preset.network_value(key).and_then(|text| format!("value = {text}").parse::<toml::Table>().ok());
        told.is_some_and(|told| told.get("value") == found)
    };
    keys.iter().all(is_same)
}

/// Ratio of length to width, width, m, and speed, m/s, of a body that moves.
pub(super) struct ShotFigures {
    pub(super) aspect: f64,
    pub(super) calibre: f64,
    pub(super) speed: f64,
}

impl ShotFigures {
    /// Figures of a body; `None` of one that rests, is held, or has no volume.
    pub(super) fn of(scene: &Scene, body: &ProjectileSpec, shape: &ShapeGeometry) -> Option<Self> {
        shape.volume()?;
        let (calibre, speed) = (calibre(shape), approach(scene, body).norm());
        let is_shot = speed > 0.0 && !body.fixed && body.active;
        is_shot.then(|| Self { aspect: extent(shape, Vector3::z()) / calibre, calibre, speed })
    }
}

impl ShotClass {
    /// Returns true if the class has shots like this one.
    fn has(&self, shot: &ShotFigures) -> bool {
        let is_in =
            |value: f64, [least, most]: [f64; 2]| value >= least * (1.0 - MARGIN) && value <= most * (1.0 + MARGIN);
        is_in(shot.aspect, self.aspect) && is_in(shot.calibre, self.calibre) && is_in(shot.speed, self.speed)
    }
}

impl fmt::Display for ShotClass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { projectiles, calibre, speed, error, basis, .. } = self;
        let (widths, speeds) = (range(calibre.map(|width| 1e3 * width), "mm"), range(*speed, "m/s"));
        write!(f, "{projectiles} of {widths} at {speeds}: {:.0} % ({basis})", 100.0 * error)
    }
}

/// Greatest width across the axis of a body, m.
pub(super) fn calibre(shape: &ShapeGeometry) -> f64 {
    extent(shape, Vector3::x()).max(extent(shape, Vector3::y()))
}

/// Extent of a body along an axis, m.
pub(super) fn extent(shape: &ShapeGeometry, axis: Vector3) -> f64 {
    shape.reach(&axis) + shape.reach(&-axis)
}

fn range([least, most]: [f64; 2], unit: &str) -> String {
    let round = |value: f64| (100.0 * value).round() / 100.0;
    if least == most {
        format!("{} {unit}", round(least))
    } else {
        format!("{} to {} {unit}", round(least), round(most))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Override, builtin, read, resolve};
    use super::*;

    fn class_of(changes: &[&str]) -> Option<&'static str> {
        let changes: Vec<Override> = changes.iter().map(|change| change.parse().unwrap()).collect();
        let scene = read(&resolve(builtin("fbi-bb").unwrap(), &changes).unwrap()).unwrap();
        shot_class(&scene, 0).map(|class| class.projectiles)
    }

    #[test]
    fn a_shot_is_of_the_class_of_its_body_calibre_and_speed() {
        let mushroom = "projectile.shape={bullet={radius=9e-3, length=10.8e-3, nose=\"round\", edge_radius=1e-3}}";
        let place = "projectile.position=[0, 0, 0.0066]";
        let rod = "projectile.shape={cylinder={radius=2.2e-3, length=4.4e-3}}";
        for (changes, class) in [
            (&[][..], Some("steel balls")),
            (&["projectile.velocity=[0, 0, -1264]"], Some("steel balls")),
            (&["projectile.velocity=[0, 0, -1266]"], None),
            (&[mushroom, place, "projectile.velocity=[0, 0, -270]"], Some("recovered pistol bullets")),
            (&[mushroom, place, "projectile.velocity=[0, 0, -180]"], None),
            (&[rod, "projectile.position=[0, 0, 0.0022]"], None),
            (&["gel.strength_scale=1.01"], None),
            (&["gel.damage.delay=11e-6"], None),
            (&["gel.bulk_modulus=700e6"], Some("steel balls")),
            (&["projectile.velocity=[0, 0, 0]"], None),
            (&["layer=[{thickness=2e-3, strength_scale=2.0}]"], None),
        ] {
            assert_eq!(class_of(changes), class, "{changes:?}");
        }
    }

    /// Hence a layer of one preset is in proportion to a gel of another.
    #[test]
    fn all_presets_have_the_same_networks_but_for_their_scale() {
        for key in [MODULI, DAMAGE].concat() {
            let values = Preset::ALL.map(|preset| preset.network_value(key).unwrap());
            assert!(values.iter().all(|value| *value == values[0]), "{key}: {values:?}");
        }
        let plain = read(builtin("fbi-bb").unwrap()).unwrap().gel;
        assert!(has_moduli_of_preset(&plain));
        assert!(has_moduli_of_preset(&GelSpec { strength_scale: 2.0, density: 1e3, ..plain.clone() }));
        assert!(!has_moduli_of_preset(&GelSpec { shear_modulus: 21e3, ..plain.clone() }));
        assert!(!has_moduli_of_preset(&GelSpec { branches: vec![], ..plain.clone() }));
        assert!(!has_moduli_of_preset(&GelSpec { preset: None, ..plain }));
    }

    #[test]
    fn every_preset_has_its_own_networks_and_classes_in_order() {
        for preset in Preset::ALL {
            assert!(class_of(&[&format!("gel.preset={}", preset.name())]).is_some(), "{preset:?}");
            for class in preset.shots().classes {
                let ranges = [class.aspect, class.calibre, class.speed];
                assert!(ranges.iter().all(|[least, most]| least <= most && *least > 0.0), "{class:?}");
                assert!(class.error > 0.0 && class.error < 1.0, "{class}");
            }
        }
    }
}
