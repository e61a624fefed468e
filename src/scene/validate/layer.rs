//! Validation of layers: a flat stack in front of the gel that the mesh resolves, of materials in proportion to the gel.

use super::ROUND_OFF;
use super::domain::{CheckResult, positive, require};
use crate::constitutive::{MOST_MATERIALS, MaterialRatios};
use crate::scene::model_error::has_moduli_of_preset;
use crate::scene::{LayerSpec, MaterialModel, RemeshMethod, Scene, SceneError, layer_name, numbered};
use std::ops::RangeInclusive;

/// Greatest number of layers.
const MOST_LAYERS: usize = MOST_MATERIALS - 1;
/// Moduli relative to those of the gel: beyond them a layer is a wall, or nothing.
const MODULUS_RATIOS: RangeInclusive<f64> = 1e-3..=1e3;
/// Density relative to that of the gel: from foam to lead.
const DENSITY_RATIOS: RangeInclusive<f64> = 0.1..=20.0;

pub(super) fn check(scene: &Scene) -> CheckResult {
    let layers = &scene.layer;
    if layers.is_empty() {
        return Ok(());
    }
    let found = || format!("{} layers", layers.len());
    require(layers.len() <= MOST_LAYERS, "layer", found, &format!("at most {MOST_LAYERS}"))?;
    layers.iter().enumerate().try_for_each(|(i, layer)| {
        check_name(layers, i)?;
        let key = numbered("layer", i);
        check_preset(scene, layer, &key)?;
        check_constants(scene, layer, &key)?;
        check_ratios(scene, layer, &key)?;
        check_stiffness(scene, layer, &key)
    })?;
    check_stack(scene)?;
    let is_immersed = scene.remesh.as_ref().is_some_and(|remesh| remesh.method == RemeshMethod::Immersed);
    let expected = "\"local\": immersed remeshing would mix the materials of all elements at each new mesh";
    require(!is_immersed, "remesh.method", || "\"immersed\" beside layers".to_owned(), expected)
}

/// Checks the name of layer `i`, from 0.
fn check_name(layers: &[LayerSpec], i: usize) -> CheckResult {
    let (key, name) = (numbered("layer", i) + ".name", layer_name(layers, i));
    let found = || format!("{name:?}");
    let allowed = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    let is_legal = !name.is_empty() && name.chars().all(allowed);
    require(is_legal, &key, found, "letters, digits, - and _: it stands in tables")?;
    let is_unique = name != "gel" && (0..i).all(|other| layer_name(layers, other) != name);
    require(is_unique, &key, found, "a name other than \"gel\" and those of the layers before it")
}

/// Refuses the preset of a layer on a gel whose networks are not in proportion to it.
fn check_preset(scene: &Scene, layer: &LayerSpec, key: &str) -> CheckResult {
    let Some(preset) = layer.preset else { return Ok(()) };
    let gel = &scene.gel;
    let (found, remedy) = if gel.material != MaterialModel::TwoNetwork {
        ("a gel that is not \"two-network\"", "density and shear_modulus")
    } else if gel.preset.is_none() {
        ("a gel without a preset", "density, strength_scale and bulk_modulus")
    } else {
        ("a gel with a shear_modulus or branches of its own", "density, strength_scale and bulk_modulus")
    };
    let is_in_proportion = gel.material == MaterialModel::TwoNetwork && has_moduli_of_preset(gel);
    let expected = format!(
        "a \"two-network\" gel of a gel.preset as it is, to whose networks those of the layer are in proportion; leave \
         the preset of the layer out and give its {remedy}"
    );
    require(is_in_proportion, &format!("{key}.preset"), || format!("\"{}\" on {found}", preset.name()), &expected)
}

/// Checks that the constants of a layer are positive, and those of the material of the gel.
fn check_constants(scene: &Scene, layer: &LayerSpec, key: &str) -> CheckResult {
    let own = |name: &str| format!("{key}.{name}");
    let has_networks = scene.gel.material == MaterialModel::TwoNetwork;
    let of_networks =
        "nothing: only on a gel of material \"two-network\"; shear_modulus scales all moduli of other layers";
    let of_others = "nothing: on a gel of material \"two-network\" strength_scale scales the moduli of a layer";
    let values = [
        ("density", layer.density, true, "a positive density, kg/m3", ""),
        ("strength_scale", layer.strength_scale, has_networks, "a positive factor, as gel.strength_scale", of_networks),
        ("bulk_modulus", layer.bulk_modulus, has_networks, "a positive modulus, Pa", of_networks),
        ("shear_modulus", layer.shear_modulus, !has_networks, "a positive modulus, Pa", of_others),
    ];
    for (name, value, is_known, expected, otherwise) in values {
        let Some(value) = value else { continue };
        require(is_known, &own(name), || format!("{value:?}"), otherwise)?;
        positive(&own(name), value, expected)?;
    }
    Ok(())
}

/// Checks that the constants of a layer are near enough to those of the gel.
fn check_ratios(scene: &Scene, layer: &LayerSpec, key: &str) -> CheckResult {
    let MaterialRatios { strength, bulk, density } = layer.ratios(&scene.gel);
    let has_networks = scene.gel.material == MaterialModel::TwoNetwork;
    let modulus = if has_networks { "strength_scale" } else { "shear_modulus" };
    let ratios = [
        (modulus, strength, MODULUS_RATIOS),
        ("bulk_modulus", bulk, MODULUS_RATIOS),
        ("density", density, DENSITY_RATIOS),
    ];
    ratios.into_iter().try_for_each(|(name, ratio, range)| {
        let found = || format!("{ratio:.3e} times that of the gel");
        let expected = format!("{:?} to {:?} times gel.{name}", range.start(), range.end());
        require(range.contains(&ratio), &format!("{key}.{name}"), found, &expected)
    })
}

/// Checks that the shear moduli of a layer are below 3/2 of its bulk modulus.
fn check_stiffness(scene: &Scene, layer: &LayerSpec, key: &str) -> CheckResult {
    let gel = &scene.gel;
    if gel.material != MaterialModel::TwoNetwork {
        return Ok(());
    }
    let shear = gel.shear_modulus + gel.branches.iter().map(|branch| branch.shear_modulus).sum::<f64>();
    let strength = layer.strength_scale.unwrap_or(gel.strength_scale);
    let least = 2.0 / 3.0 * strength * shear;
    let bulk = layer.bulk_modulus.unwrap_or(gel.bulk_modulus);
    let (name, found, expected) = if layer.bulk_modulus.is_some() {
        let expected = format!("more than 2/3 of all shear moduli of the layer together, {:?} Pa", legible(least));
        ("bulk_modulus", bulk, expected)
    } else {
        let most = legible(strength * bulk / least);
        let expected = format!(
            "less than {most:?}: 2/3 of all shear moduli of the layer together would exceed the bulk modulus of the gel; \
             or give the layer a greater bulk_modulus"
        );
        ("strength_scale", strength, expected)
    };
    require(bulk > least, &format!("{key}.{name}"), || format!("{found:?}"), &expected)
}

/// Returns a number without the round-off of its computation.
fn legible(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

/// Checks that each layer has a cell of the mesh, and the gel below them one.
fn check_stack(scene: &Scene) -> CheckResult {
    let expected = "a gel.shape that is a block or a cylinder: only these have a flat entry surface for layers";
    let depth = scene.gel.shape.thickness();
    let depth = depth.ok_or_else(|| SceneError::value("layer", "layers on another shape", expected))?;
    let (size, mut sum) = (scene.mesh.size, 0.0);
    for (i, layer) in scene.layer.iter().enumerate() {
        let (key, thickness) = (numbered("layer", i) + ".thickness", layer.thickness);
        positive(&key, thickness, "a positive length, m")?;
        let expected = format!(
            "at least mesh.size, {size:?} m: the mesh cannot show a layer thinner than a cell; take a finer mesh.size or a \
             thicker layer"
        );
        require(thickness >= size * (1.0 - ROUND_OFF), &key, || format!("{thickness:?}"), &expected)?;
        sum += thickness;
        let expected = format!(
            "at most {:?} m for all layers together, the depth of gel.shape less a cell of gel (mesh.size): take a deeper \
             shape or thinner layers",
            legible(depth - size)
        );
        let found = || format!("{thickness:?}, its lower end at {:?} m", legible(sum));
        require(sum <= (depth - size) * (1.0 + ROUND_OFF), &key, found, &expected)?;
    }
    Ok(())
}
