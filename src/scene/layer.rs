//! Layers of another material in front of the gel.

use super::places::numbered;
use super::{GelSpec, MaterialModel, Preset};
use crate::constitutive::{LayerStack, MaterialLayer, MaterialRatios, MixedModuli};
use serde::{Deserialize, Serialize};

/// Layer across the line of fire, bonded to what lies below it: the first lies at the entry surface z = 0, each further one
/// below the one before it, and the gel below the last. A layer has the law of the gel with the constants given here; what
/// is absent is that of the gel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct LayerSpec {
    /// Name in tables and messages: letters, digits, `-` and `_`; `layer-1` and so on if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Thickness, m: at least one cell of the mesh.
    pub thickness: f64,
    /// Named gel, whose density, bulk modulus and strength fill the keys that are absent (a `two-network` gel of a preset
    /// only).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preset: Option<Preset>,
    /// Mass density at rest, kg/m3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// Factor on all moduli and dashpot stresses of the networks together, as `gel.strength_scale` (`two-network` only).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strength_scale: Option<f64>,
    /// Bulk modulus at rest, Pa (`two-network` only): the equation of state is that of the gel with all pressures in
    /// proportion to it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bulk_modulus: Option<f64>,
    /// Shear modulus at rest, Pa (hyperelastic gels only); all other moduli are in proportion to it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shear_modulus: Option<f64>,
}

impl LayerSpec {
    /// Constants of the layer relative to those of a gel.
    #[must_use]
    pub fn ratios(&self, gel: &GelSpec) -> MaterialRatios {
        let ratio = |own: Option<f64>, of_gel: f64| own.map_or(1.0, |own| own / of_gel);
        let density = ratio(self.density, gel.density);
        if gel.material == MaterialModel::TwoNetwork {
            let strength = ratio(self.strength_scale, gel.strength_scale);
            return MaterialRatios { strength, bulk: ratio(self.bulk_modulus, gel.bulk_modulus), density };
        }
        let strength = ratio(self.shear_modulus, gel.shear_modulus);
        MaterialRatios { strength, bulk: strength, density }
    }
}

/// Stack of these layers on a gel; `None` without layers.
#[must_use]
pub fn layer_stack(layers: &[LayerSpec], gel: &GelSpec) -> Option<LayerStack> {
    let material = |layer: &LayerSpec| MaterialLayer { thickness: layer.thickness, ratios: layer.ratios(gel) };
    let all: Vec<MaterialLayer> = layers.iter().map(material).collect();
    let moduli = match gel.material {
        MaterialModel::TwoNetwork => MixedModuli::Apart,
        _ => MixedModuli::InProportion,
    };
    (!all.is_empty()).then(|| LayerStack::new(&all, moduli))
}

/// Name of the n-th layer, counted from 0 at the entry surface; `gel` below the last.
#[must_use]
pub fn layer_name(layers: &[LayerSpec], n: usize) -> String {
    let own = |layer: &LayerSpec| layer.name.clone().unwrap_or_else(|| format!("layer-{}", n + 1));
    layers.get(n).map_or_else(|| "gel".to_owned(), own)
}

/// Describes the layers on a gel: the model in two sentences, and each layer; empty without layers.
pub(super) fn describe_layers(layers: &[LayerSpec], gel: &GelSpec) -> Vec<String> {
    if layers.is_empty() {
        return vec![];
    }
    let model = "layers: bonded, each with the law of the gel and constants in proportion; an element of two materials, as \
                 remeshing makes them at an interface, is a mixture";
    let shared = if gel.material == MaterialModel::TwoNetwork {
        "layers: relaxation times, the stretch at which damage begins, and the shape of the pressure law are those of the gel"
    } else {
        "layers: the shape of the elastic law, and the ratio of bulk to shear modulus, are those of the gel"
    };
    let of_layers = layers.iter().enumerate().map(|(i, layer)| {
        let MaterialRatios { strength, bulk, density } = layer.ratios(gel);
        let preset = layer.preset.map(|preset| format!(" of {}", preset.name())).unwrap_or_default();
        format!(
            "{}: {}{preset}, {:?} m thick, {strength:.4} times the strength, {bulk:.4} times the bulk modulus and \
             {density:.4} times the density of the gel",
            numbered("layer", i),
            layer_name(layers, i),
            layer.thickness
        )
    });
    [model, shared].into_iter().map(str::to_owned).chain(of_layers).collect()
}

/// Returns the physics of layers that is left out.
pub(super) fn omitted_in_layers(layers: &[LayerSpec]) -> &'static str {
    if layers.is_empty() {
        "layers: none, the gel is of one material"
    } else {
        "fracture of layers: none, they do not come off the gel, splinter or have fibres"
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Override, Preset, SceneError, builtin, modelled_physics, read, resolve, switched_off};
    use super::*;
    use crate::scene::Scene;

    fn scene_with(changes: &[&str]) -> Result<Scene, SceneError> {
        let changes: Vec<Override> = changes.iter().map(|change| change.parse().unwrap()).collect();
        read(&resolve(builtin("fbi-bb").unwrap(), &changes).unwrap())
    }

    #[test]
    fn the_preset_of_a_layer_fills_the_keys_that_are_absent() {
        let layers =
            "layer=[{thickness='2 mm', preset='gelatin-20'}, {thickness=3e-3, preset='gelatin-10', density=900.0}]";
        let scene = scene_with(&[layers]).unwrap();
        let values = |layer: &LayerSpec| (layer.preset, layer.density, layer.bulk_modulus, layer.strength_scale);
        let [first, second] = &scene.layer[..] else { panic!("{:?}", scene.layer) };
        assert_eq!(values(first), (Some(Preset::Gelatin20), Some(1060.0), Some(2.61e9), Some(1.95)));
        assert_eq!(values(second), (Some(Preset::Gelatin10), Some(900.0), Some(2.38e9), Some(1.0)));
        assert_eq!((first.thickness, first.shear_modulus), (2e-3, None));
        // The text of the resolved scene is the same scene.
        assert_eq!(read(&toml::to_string(&scene).unwrap()).unwrap(), scene);
    }

    #[test]
    fn a_key_that_is_absent_is_that_of_the_gel() {
        let scene =
            scene_with(&["layer=[{thickness=2e-3}, {name='skin', thickness=1e-3, strength_scale=3.0}]"]).unwrap();
        assert_eq!(scene.layer[0].ratios(&scene.gel), MaterialRatios::GEL);
        assert_eq!(scene.layer[1].ratios(&scene.gel), MaterialRatios { strength: 3.0, ..MaterialRatios::GEL });
        assert_eq!([0, 1, 2].map(|n| layer_name(&scene.layer, n)), ["layer-1", "skin", "gel"]);
        assert_eq!(layer_stack(&scene.layer, &scene.gel).unwrap().depths(), [2e-3, 3e-3]);
        assert_eq!(layer_stack(&[], &scene.gel), None);
    }

    #[test]
    fn layers_are_described_and_absent_ones_listed_as_such() {
        let none = "layers: none, the gel is of one material".to_owned();
        let bare = scene_with(&[]).unwrap();
        assert!(
            switched_off(&bare).contains(&none) && !modelled_physics(&bare).iter().any(|line| line.contains("layer"))
        );
        let skin = scene_with(&["layer=[{name='skin', thickness=2e-3, strength_scale=3.0, density=1133.0}]"]).unwrap();
        let told = "layer[1]: skin, 0.002 m thick, 3.0000 times the strength, 1.0000 times the bulk modulus and 1.1000 times \
                    the density of the gel";
        assert!(modelled_physics(&skin).iter().any(|line| line == told), "{:?}", modelled_physics(&skin));
        assert!(!switched_off(&skin).contains(&none));
    }

    #[test]
    fn overrides_reach_the_keys_of_a_layer() {
        let layers = "layer=[{thickness=2e-3}, {thickness=3e-3}]";
        let scene = scene_with(&[layers, "layer[2].thickness=4 mm", "layer[1].strength_scale=2"]).unwrap();
        assert_eq!((scene.layer[1].thickness, scene.layer[0].strength_scale), (4e-3, Some(2.0)));
        let tables = builtin("fbi-bb").unwrap().to_owned() + "\n[[layer]]\nthickness = 2e-3\n";
        let replaced = |change: &str| read(&resolve(&tables, &[change.parse().unwrap()]).unwrap());
        assert_eq!(replaced("layer[1].thickness=4 mm").unwrap().layer[0].thickness, 4e-3);
        assert_eq!(replaced("layer=[]").unwrap().layer, []);
    }
}
