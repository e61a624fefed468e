//! Layers of another material in front of the gel.

use super::{GelSpec, MaterialModel, Preset};
use crate::constitutive::{LayerStack, MaterialRatios};
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
    let all: Vec<(f64, MaterialRatios)> = layers.iter().map(|layer| (layer.thickness, layer.ratios(gel))).collect();
    (!all.is_empty()).then(|| LayerStack::new(&all))
}

/// Name of the n-th layer, counted from 0 at the entry surface; `gel` below the last.
#[must_use]
pub fn layer_name(layers: &[LayerSpec], n: usize) -> String {
    let own = |layer: &LayerSpec| layer.name.clone().unwrap_or_else(|| format!("layer-{}", n + 1));
    layers.get(n).map_or_else(|| "gel".to_owned(), own)
}
