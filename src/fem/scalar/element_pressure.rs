//! Pressure of an element from its material law.

use super::rest_element::DeformationGradient;
use super::simplices::Simplices;
use crate::constitutive::{Hyperelastic, Material, MaterialRatios, NeoHookean, VolumetricEnergy};
use crate::math::{Tensor, Vector, array};
use crate::mesh::{ElementId, NodeId};

impl<const D: usize> Simplices<D> {
    /// Returns the pressure p = −tr σ/3 of an element of a patch, Pa, at the nodal positions `x`; positive in
    /// compression.
    ///
    /// U′ is the sum of the patch part at J̄ and the element part at J. A hyperelastic material has
    /// σ = ∂ψ_s/∂F Fᵀ/J + U′ 1, so p = −U′ − ∂ψ_s/∂F:F/(3J), neo-Hookean −U′ − μ I₁/(3J). The networks of a
    /// two-network gel are deviatoric, so p = −U′. Bulk viscosity, which only spreads shocks, is left out.
    #[must_use]
    pub fn pressure(&self, element: ElementId, patch: usize, x: impl Fn(NodeId) -> Vector<D> + Copy) -> f64 {
        let ids = self.patches.of(patch);
        let own = self.element_deformation_by(element, &self.rest_element(element), x);
        let strains = ids.iter().map(|id| {
            let element = self.rest_element(*id);
            let strain = self.element_deformation_by(*id, &element, x);
            StrainedElement { volume: element.volume, ratios: self.ratios(*id), strain }
        });
        self.pressure_of(element, &own, (ids.len() > 1).then(|| PatchVolume::of(strains)))
    }

    /// Returns the pressure of a deformed element, Pa, in a patch of several elements by the volume of the patch.
    pub(super) fn pressure_of(
        &self,
        element: ElementId,
        strain: &DeformationGradient<D>,
        patch: Option<PatchVolume>,
    ) -> f64 {
        let MaterialRatios { strength, bulk, .. } = self.ratios(element);
        // A hyperelastic law is in proportion to the strength, but for the part that is common to the patch.
        let mean = patch.map(|patch| PatchVolume { bulk: patch.bulk / strength, ..patch });
        match (&self.material, patch) {
            (Material::NeoHookean(gel), _) => strength * hyperelastic_pressure(gel, strain, mean),
            (Material::MooneyRivlin(gel), _) => strength * hyperelastic_pressure(gel, strain, mean),
            (Material::Ogden(gel), _) => strength * hyperelastic_pressure(gel, strain, mean),
            (Material::TwoNetwork(gel), None) => -bulk * gel.volumetric(strain.jacobian()).slope,
            (Material::TwoNetwork(gel), Some(PatchVolume { jacobian, bulk, strength })) => {
                let stabilisation = gel.relative_stabilisation(strength, bulk);
                let whole = gel.volumetric(jacobian).slope;
                let sharing = gel.own(strain.jacobian()).slope + gel.shared(jacobian).slope - whole;
                -(bulk * whole + stabilisation * sharing)
            }
        }
    }
}

/// Element of a patch: its rest volume, m³, its material, and its deformation.
#[derive(Clone, Copy)]
pub(super) struct StrainedElement<const D: usize> {
    pub volume: f64,
    pub ratios: MaterialRatios,
    pub strain: DeformationGradient<D>,
}

/// Volume ratio J̄ of a patch, and the means of its relative bulk moduli and strengths by volume.
#[derive(Clone, Copy)]
pub(super) struct PatchVolume {
    jacobian: f64,
    bulk: f64,
    strength: f64,
}

impl PatchVolume {
    /// Returns the volume ratio and the moduli of these elements together.
    pub(super) fn of<const D: usize>(members: impl Iterator<Item = StrainedElement<D>>) -> Self {
        let (mut rest, mut sum) = (0.0, Self { jacobian: 0.0, bulk: 0.0, strength: 0.0 });
        for StrainedElement { volume, ratios, strain } in members {
            rest += volume;
            sum.jacobian += volume * strain.jacobian();
            sum.bulk += volume * ratios.bulk;
            sum.strength += volume * ratios.strength;
        }
        Self { jacobian: sum.jacobian / rest, bulk: sum.bulk / rest, strength: sum.strength / rest }
    }
}

/// Returns the pressure of a hyperelastic element of the gel's own strength, Pa, in a patch of several elements by its
/// volume.
fn hyperelastic_pressure<const D: usize>(
    gel: &impl Hyperelastic,
    strain: &DeformationGradient<D>,
    patch: Option<PatchVolume>,
) -> f64 {
    let (volume, jacobian) = (gel.volume(), strain.jacobian());
    let slope = patch.map_or_else(
        || volume.volumetric(jacobian).slope,
        |patch| volume.own(jacobian).slope + patch.bulk * volume.shared(patch.jacobian).slope,
    );
    let sheared = gel.sheared(&array::rows(&strain.f), strain.out);
    let stress = Tensor::<D>::from_fn(|i, j| sheared.stress[i][j]);
    let out_of_plane = if D == 2 { sheared.out * strain.out * strain.out } else { 0.0 };
    -slope - (stress.dot(&strain.f) + out_of_plane) / (3.0 * jacobian.max(NeoHookean::FLOOR))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constitutive::{Branch, Dashpot, EquationOfState, MooneyRivlin, Ogden, OgdenTerm, TwoNetwork};
    use crate::fem::{DEPTH, ElementResponse, HistoryVariables, Potential, Section};
    use crate::mesh::{ElementPatches, Mesh};

    fn gels() -> [Material; 4] {
        let rest = NeoHookean::new(3.0, 40.0);
        let branch = Branch::new(2.0, Dashpot::linear(1.0));
        let state = EquationOfState::new(40.0, 2.0, f64::INFINITY);
        let terms = [OgdenTerm { modulus: 1.0, exponent: 4.0 }, OgdenTerm { modulus: -1.0, exponent: -2.0 }];
        [
            rest.into(),
            Material::MooneyRivlin(MooneyRivlin::new([1.0, 0.5], 40.0)),
            Material::Ogden(Ogden::new(&terms, 40.0)),
            TwoNetwork::new(3.0, &[branch], state, 1.0).into(),
        ]
    }

    /// Compares the pressure with the virial Σ f_a·x_a = −∫ tr σ dv of one element.
    fn check<const D: usize>(rest: Vec<Vector<D>>, section: Section) {
        let nodes = if D == 2 { [0, 1, 2, 0] } else { [0, 1, 2, 3] };
        let mesh = Mesh::new(rest, vec![nodes.map(NodeId)]);
        let wave = |i: usize, a: usize| 0.15 * ((7 * a + 3 * i) as f64).sin();
        let x: Vec<_> =
            mesh.rest.iter().enumerate().map(|(a, x)| x * 0.9 + Vector::<D>::from_fn(|i, _| wave(i, a))).collect();
        for gel in gels() {
            let simplices = Simplices::in_patches(&mesh, ElementPatches::alone(1), (gel, section));
            let memory = vec![HistoryVariables::default(); simplices.memories()];
            let mut answers = [ElementResponse::default(); DEPTH];
            simplices.evaluate(0, &x, &memory, &mut answers);
            let virial: f64 = answers[0].forces[..=D].iter().zip(&x).map(|(f, x)| f.dot(x)).sum();
            let now = simplices.volume(ElementId(0)) * answers[0].jacobian;
            let pressure = simplices.pressure(ElementId(0), 0, |node| x[node.index()]);
            assert!((virial / (3.0 * now) - pressure).abs() < 1e-12 * pressure.abs(), "{pressure}");
            assert!(pressure.abs() > 1.0);
        }
    }

    #[test]
    fn pressure_agrees_with_the_virial_of_the_nodal_forces() {
        let flat = [[0.8, 0.1], [1.9, 0.3], [1.1, 1.2]].map(Vector::<2>::from);
        check(flat.to_vec(), Section::Axisymmetric);
        let solid = [[0.0, 0.1, 0.0], [1.2, 0.0, 0.1], [0.2, 0.9, -0.1], [0.1, 0.3, 1.1]].map(Vector::<3>::from);
        check(solid.to_vec(), Section::Spatial);
    }

    #[test]
    fn a_uniformly_compressed_patch_has_the_pressure_of_its_elements() {
        let corners = [[0.8, 0.1], [1.9, 0.3], [1.1, 1.2], [2.1, 1.4]].map(Vector::<2>::from);
        let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2, 0].map(NodeId), [1, 3, 2, 0].map(NodeId)]);
        let squeeze = Tensor::<2>::new(0.97, 0.02, 0.01, 0.95);
        let x = |node: NodeId| squeeze * mesh.rest[node.index()];
        for gel in gels() {
            let of = |patches: ElementPatches, patch: usize| {
                Simplices::in_patches(&mesh, patches, (gel, Section::Planar { thickness: 1.0 })).pressure(
                    ElementId(1),
                    patch,
                    x,
                )
            };
            let (alone, pair) = (of(ElementPatches::alone(2), 1), of(ElementPatches::grouped(&mesh), 0));
            assert!((alone - pair).abs() < 1e-12 * alone.abs() && alone > 1.0, "{alone} {pair}");
        }
    }
}
