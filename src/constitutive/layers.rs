//! Materials of a layered gel: one law with constants in proportion, and their mixture in an element.

/// Constants of a material relative to those of the gel, whose law it shares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaterialRatios {
    /// Moduli and dashpot stresses of the networks; all moduli of a hyperelastic gel.
    pub strength: f64,
    /// Pressures of the equation of state; of a hyperelastic gel equal to `strength`.
    pub bulk: f64,
    /// Density at rest.
    pub density: f64,
}

impl MaterialRatios {
    /// Gel itself.
    pub const GEL: Self = Self { strength: 1.0, bulk: 1.0, density: 1.0 };
}

/// Greatest number of materials: three layers and the gel below them.
pub const MOST_MATERIALS: usize = 4;

/// Parts of the materials in a volume, front to back: those of its mass, or those of its volume at rest. They sum to 1.
pub type MaterialParts = [f64; MOST_MATERIALS];

/// Layer of a stack.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaterialLayer {
    /// Thickness, m.
    pub thickness: f64,
    /// Material.
    pub ratios: MaterialRatios,
}

/// Layers on a gel, between planes across the z axis, and the gel as the last material.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerStack {
    /// Depths of the interfaces, m, ascending.
    depths: Vec<f64>,
    /// Materials front to back; those beyond the gel are the gel.
    ratios: [MaterialRatios; MOST_MATERIALS],
    moduli: MixedModuli,
}

/// Moduli of a mixture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MixedModuli {
    /// Strength and bulk modulus apart, of a two-network gel.
    Apart,
    /// All in proportion, of a hyperelastic gel: its volumetric energy balances the rest stress of its shear energy.
    InProportion,
}

impl LayerStack {
    /// Creates a stack from layers, front to back.
    ///
    /// # Panics
    /// If there are [`MOST_MATERIALS`] layers or more.
    #[must_use]
    pub fn new(layers: &[MaterialLayer], moduli: MixedModuli) -> Self {
        assert!(layers.len() < MOST_MATERIALS, "the gel is one of the materials");
        let mut ratios = [MaterialRatios::GEL; MOST_MATERIALS];
        ratios.iter_mut().zip(layers).for_each(|(ratios, layer)| *ratios = layer.ratios);
        let sum = |depth: &mut f64, layer: &MaterialLayer| {
            *depth += layer.thickness;
            Some(*depth)
        };
        Self { depths: layers.iter().scan(0.0, sum).collect(), ratios, moduli }
    }

    /// Returns the greatest speed of sound of a material, relative to that of the gel; at least 1.
    #[must_use]
    pub fn greatest_speed(&self) -> f64 {
        let speed = |ratios: &MaterialRatios| (ratios.bulk.max(ratios.strength) / ratios.density).sqrt();
        self.ratios.iter().map(speed).fold(1.0, f64::max)
    }

    /// Returns the depths of the interfaces, m, ascending.
    #[must_use]
    pub fn depths(&self) -> &[f64] {
        &self.depths
    }

    /// Returns the greatest of each constant over all materials.
    #[must_use]
    pub fn greatest(&self) -> MaterialRatios {
        let greatest = |of: fn(&MaterialRatios) -> f64| self.ratios.iter().map(of).fold(1.0, f64::max);
        MaterialRatios {
            strength: greatest(|ratios| ratios.strength),
            bulk: greatest(|ratios| ratios.bulk),
            density: greatest(|ratios| ratios.density),
        }
    }

    /// Returns the number of materials, that of the gel included.
    #[must_use]
    pub fn n_materials(&self) -> usize {
        self.depths.len() + 1
    }

    /// Returns the parts of mass of a volume with these parts of volume at rest.
    #[must_use]
    pub fn mass_parts(&self, volume_parts: &MaterialParts) -> MaterialParts {
        normalised(std::array::from_fn(|k| volume_parts[k] * self.ratios[k].density))
    }

    /// Returns the constants of a mixture with these parts of mass.
    ///
    /// The strength is the mean by volume (equal strains; Voigt), and the density that of the volumes together. The bulk
    /// modulus is the harmonic mean (equal pressures; Reuss, for fluids Wood), or in proportion to the strength. A pure
    /// material has its own, to the bit.
    #[must_use]
    pub fn mixed(&self, mass_parts: &MaterialParts) -> MaterialRatios {
        if let Some(pure) = mass_parts.iter().position(|part| *part == 1.0) {
            return self.ratios[pure];
        }
        let specific: MaterialParts = std::array::from_fn(|k| mass_parts[k] / self.ratios[k].density);
        let volume_parts = normalised(specific);
        let mean = |of: &dyn Fn(&MaterialRatios) -> f64| -> f64 {
            volume_parts.iter().zip(&self.ratios).map(|(part, ratios)| part * of(ratios)).sum()
        };
        let strength = mean(&|ratios| ratios.strength);
        MaterialRatios {
            strength,
            bulk: match self.moduli {
                MixedModuli::Apart => 1.0 / mean(&|ratios| 1.0 / ratios.bulk),
                MixedModuli::InProportion => strength,
            },
            density: 1.0 / specific.iter().sum::<f64>(),
        }
    }
}

/// Returns parts with the sum 1.
fn normalised(parts: MaterialParts) -> MaterialParts {
    let sum: f64 = parts.iter().sum();
    parts.map(|part| part / sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SKIN: MaterialRatios = MaterialRatios { strength: 3.0, bulk: 2.0, density: 1.5 };

    fn stack(moduli: MixedModuli) -> LayerStack {
        let layer = |thickness, ratios| MaterialLayer { thickness, ratios };
        LayerStack::new(&[layer(0.01, SKIN), layer(0.02, MaterialRatios::GEL)], moduli)
    }

    #[test]
    fn a_pure_material_has_its_own_constants() {
        let stack = stack(MixedModuli::Apart);
        assert_eq!((stack.depths(), stack.n_materials()), (&[0.01, 0.03][..], 3));
        let pure = |k: usize| stack.mixed(&stack.mass_parts(&std::array::from_fn(|i| f64::from(u8::from(i == k)))));
        assert_eq!([0, 1, 2].map(pure), [SKIN, MaterialRatios::GEL, MaterialRatios::GEL]);
    }

    /// Halves by volume: strength 2, compliance (1/2 + 1)/2, density 1.25.
    #[test]
    fn a_mixture_has_the_mean_strength_the_mean_compliance_and_the_mass_of_its_volumes() {
        let stack = stack(MixedModuli::Apart);
        let parts = stack.mass_parts(&[0.5, 0.5, 0.0, 0.0]);
        assert_eq!(parts, [0.6, 0.4, 0.0, 0.0]);
        let mixed = stack.mixed(&parts);
        assert!((mixed.strength - 2.0).abs() < 1e-15 && (mixed.density - 1.25).abs() < 1e-15, "{mixed:?}");
        assert!((mixed.bulk - 4.0 / 3.0).abs() < 1e-15, "{mixed:?}");
    }

    #[test]
    fn moduli_of_a_hyperelastic_mixture_stay_in_proportion() {
        let stack = stack(MixedModuli::InProportion);
        let mixed = stack.mixed(&stack.mass_parts(&[0.5, 0.5, 0.0, 0.0]));
        assert_eq!(mixed.bulk, mixed.strength);
    }
}
