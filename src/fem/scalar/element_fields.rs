//! Cauchy stress, rate of deformation and viscous strain of elements, for output.

use super::element_pressure::{PatchVolume, StrainedElement};
use super::rest_element::DeformationGradient;
use super::simplices::Simplices;
use crate::constitutive::{Hyperelastic, IsochoricDeformation, Material, MaterialRatios, NeoHookean, TwoNetwork};
use crate::fem::{DEPTH, HistoryVariables, Section};
use crate::math::{SymmetricTensor, Tensor, Vector, array, diagonalise, ln};
use crate::mesh::{ElementId, edges};

/// Invariants of the Cauchy stress σ of an element.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StressInvariants {
    /// Pressure p = −tr σ/3, Pa; positive in compression.
    pub pressure: f64,
    /// Von Mises stress √(3/2 s:s) of the deviator s, Pa.
    pub von_mises: f64,
}

impl<const D: usize> Simplices<D> {
    /// Returns the stress invariants of the elements of a patch, in their order, at the nodal positions `x`.
    ///
    /// The pressure is that of [`Self::pressure`]. `memory` holds the history variables of all elements: the branches
    /// of a two-network gel keep the rest shapes of their last tick. Bulk viscosity is left out.
    #[must_use]
    pub fn stress_invariants(
        &self,
        patch: usize,
        x: &[Vector<D>],
        memory: &[HistoryVariables<D>],
    ) -> [StressInvariants; DEPTH] {
        let ids = self.patches.of(patch);
        let (ratios, strain) = (MaterialRatios::GEL, DeformationGradient::identity());
        let mut members = [StrainedElement { volume: 0.0, ratios, strain }; DEPTH];
        let members = &mut members[..ids.len()];
        for (id, member) in ids.iter().zip(&mut *members) {
            let element = self.rest_element(*id);
            let strain = self.element_deformation(*id, &element, x);
            *member = StrainedElement { volume: element.volume, ratios: self.ratios(*id), strain };
        }
        let volume = (ids.len() > 1).then(|| PatchVolume::of(members.iter().copied()));
        let n = self.records();
        let mut stresses = [StressInvariants::default(); DEPTH];
        for ((id, member), stress) in ids.iter().zip(members).zip(&mut stresses) {
            let records = &memory[id.index() * n..(id.index() + 1) * n];
            let pressure = self.pressure_of(*id, &member.strain, volume);
            let von_mises = self.ratios(*id).strength * self.von_mises(&member.strain, records);
            *stress = StressInvariants { pressure, von_mises };
        }
        stresses
    }

    /// Returns the von Mises stress of a deformed element of the gel's own material, Pa.
    ///
    /// A hyperelastic material has s = dev(∂ψ_s/∂F Fᵀ)/J, a two-network gel s = Σ μ_k dev b̄_k/J. J is at least the
    /// floor of the volumetric energy.
    fn von_mises(&self, strain: &DeformationGradient<D>, records: &[HistoryVariables<D>]) -> f64 {
        let kirchhoff = match &self.material {
            Material::NeoHookean(gel) => hyperelastic_stress(gel, strain),
            Material::MooneyRivlin(gel) => hyperelastic_stress(gel, strain),
            Material::Ogden(gel) => hyperelastic_stress(gel, strain),
            Material::TwoNetwork(gel) => network_stress(gel, strain, records),
        };
        let deviator = kirchhoff.deviator();
        (1.5 * deviator.dot(&deviator)).sqrt() / strain.jacobian().max(NeoHookean::FLOOR)
    }

    /// Returns the equivalent rate of deformation √(2/3 d′:d′) of an element, 1/s, at the positions `x`, m, and the
    /// velocities `v`, m/s, of all nodes.
    ///
    /// d is the symmetric part of ∂v/∂x in the present configuration, d′ its deviator in three dimensions. A ring has
    /// the hoop rate Σ v_r/Σ r over its nodes, the mean of v_r over the mean of r.
    #[must_use]
    pub fn strain_rate(&self, element: ElementId, x: &[Vector<D>], v: &[Vector<D>]) -> f64 {
        let nodes = &self.elements()[element.index()];
        let Some(inverse) = edges(x, nodes).try_inverse() else { return 0.0 };
        let gradient = edges(v, nodes) * inverse;
        let sum = |of: &[Vector<D>]| self.corners(element).iter().map(|node| of[node.index()][0]).sum::<f64>();
        let out = if self.section == Section::Axisymmetric { sum(v) / sum(x) } else { 0.0 };
        let inner = array::rows(&((gradient + gradient.transpose()) * 0.5));
        let deviator = SymmetricTensor { inner, out }.deviator();
        (2.0 / 3.0 * deviator.dot(&deviator)).sqrt()
    }

    /// Returns the equivalent viscous strain √(2/3 ε:ε) of an element, the mean over the branches by shear modulus; 0
    /// without branches.
    ///
    /// ε = ½ ln C_v is the Hencky strain of the rest shape of a branch, relative to that of the elastic network: C_v
    /// has the eigenvalues of A C̄_i. Both tensors change alike with the reference of the element. Without an elastic
    /// network A is not stored, and the strain is relative to the last reference that remeshing gave the element.
    #[must_use]
    pub fn viscous_strain(&self, element: ElementId, memory: &[HistoryVariables<D>]) -> f64 {
        let Material::TwoNetwork(gel) = &self.material else { return 0.0 };
        let n = gel.records();
        let records = &memory[element.index() * n..(element.index() + 1) * n];
        let root = inverse_root(&records[0].tensor());
        let branches = gel.branches().iter().zip(&records[gel.first_branch()..]);
        let (strain, modulus) = branches.fold((0.0, 0.0), |(strain, modulus), (branch, record)| {
            let own = branch.shear_modulus();
            (strain + own * equivalent_hencky_strain(&root, &record.tensor()), modulus + own)
        });
        if modulus > 0.0 { strain / modulus } else { 0.0 }
    }
}

/// Returns the Kirchhoff stress ∂ψ_s/∂F Fᵀ of a hyperelastic material, without its volumetric part, Pa.
fn hyperelastic_stress<const D: usize>(
    gel: &impl Hyperelastic,
    strain: &DeformationGradient<D>,
) -> SymmetricTensor<D, f64> {
    let sheared = gel.sheared(&array::rows(&strain.f), strain.out);
    let stress = Tensor::<D>::from_fn(|i, j| sheared.stress[i][j]) * strain.f.transpose();
    let out = if D == 2 { sheared.out * strain.out * strain.out } else { 0.0 };
    SymmetricTensor { inner: array::rows(&stress), out }
}

/// Returns the sum Σ μ_k b̄_k over the networks of a two-network gel, Pa, the elastic one weakened by its damage.
fn network_stress<const D: usize>(
    gel: &TwoNetwork,
    strain: &DeformationGradient<D>,
    records: &[HistoryVariables<D>],
) -> SymmetricTensor<D, f64> {
    let at = IsochoricDeformation::new(&array::rows(&strain.f), strain.out, strain.det_f);
    let elastic = |record: &HistoryVariables<D>| {
        let shape = record.tensor();
        at.elastic(&at.times_inverse_shape(&shape), shape.out)
    };
    let own = gel.shear_modulus() * (1.0 - records[0].damage);
    let sum = SymmetricTensor::diagonal(0.0, 0.0).combined(1.0, &elastic(&records[0]), own);
    let branches = gel.branches().iter().zip(&records[gel.first_branch()..]);
    branches.fold(sum, |sum, (branch, record)| sum.combined(1.0, &elastic(record), branch.shear_modulus()))
}

/// Returns A^(−1/2) of a positive definite tensor.
fn inverse_root<const D: usize>(tensor: &SymmetricTensor<D, f64>) -> SymmetricTensor<D, f64> {
    tensor.mapped(|value| 1.0 / value.sqrt())
}

/// Returns the equivalent strain √(2/3 ε:ε), ε the deviator of −½ ln(R S R), for R = `root` and S = `shape`.
fn equivalent_hencky_strain<const D: usize>(root: &SymmetricTensor<D, f64>, shape: &SymmetricTensor<D, f64>) -> f64 {
    let [outer, middle] = [root, shape].map(|tensor| Tensor::<D>::from_fn(|i, j| tensor.of(i, j)));
    let product = outer * middle * outer;
    let (values, _) = diagonalise(array::rows(&((product + product.transpose()) * 0.5)));
    let mut logarithms = [0.0; 3];
    logarithms[..D].copy_from_slice(&values.map(ln));
    if D == 2 {
        logarithms[2] = ln(root.out * shape.out * root.out);
    }
    let mean = logarithms.iter().sum::<f64>() / 3.0;
    let square: f64 = logarithms.iter().map(|logarithm| (0.5 * (logarithm - mean)).powi(2)).sum();
    (2.0 / 3.0 * square).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constitutive::{Branch, Dashpot, EquationOfState};
    use crate::fem::{ElementResponse, GroupKick, Potential};
    use crate::mesh::{ElementPatches, Mesh, NodeId};

    const MODULUS: f64 = 3.0;
    const BULK: f64 = 40.0;
    const SHEAR: f64 = 0.7;

    fn neo_hookean() -> Material {
        NeoHookean::new(MODULUS, BULK).into()
    }

    /// Returns a gel of a branch of modulus 2 Pa and time 1 s beside an elastic network.
    fn networks() -> Material {
        let branch = Branch::new(2.0, Dashpot::linear(1.0));
        TwoNetwork::new(MODULUS, &[branch], EquationOfState::new(BULK, 0.0, f64::INFINITY), 1.0).into()
    }

    /// Returns two triangles, or two tetrahedra, beside the axis.
    fn mesh<const D: usize>() -> Mesh<D> {
        let points: &[[f64; 3]] = if D == 2 {
            &[[0.8, 0.1, 0.0], [1.9, 0.3, 0.0], [1.1, 1.2, 0.0], [2.1, 1.4, 0.0]]
        } else {
            &[[0.0, 0.1, 0.0], [1.2, 0.0, 0.1], [0.2, 0.9, -0.1], [0.1, 0.3, 1.1], [1.2, 1.1, 1.0]]
        };
        let nodes: &[[u32; 4]] = if D == 2 { &[[0, 1, 2, 0], [1, 3, 2, 0]] } else { &[[0, 1, 2, 3], [1, 2, 3, 4]] };
        let rest = points.iter().map(|point| Vector::<D>::from_fn(|i, _| point[i])).collect();
        Mesh::new(rest, nodes.iter().map(|nodes| nodes.map(NodeId)).collect())
    }

    /// Returns positions after the deformation F.
    fn deformed<const D: usize>(mesh: &Mesh<D>, f: &Tensor<D>) -> Vec<Vector<D>> {
        mesh.rest.iter().map(|x| f * x).collect()
    }

    fn simple_shear<const D: usize>() -> Tensor<D> {
        Tensor::<D>::from_fn(|i, j| if i == j { 1.0 } else { SHEAR * f64::from(u8::from((i, j) == (0, 1))) })
    }

    /// Returns the elements, each alone and in a patch.
    fn elements<const D: usize>(gel: Material, section: Section) -> [Simplices<D>; 2] {
        let mesh = mesh::<D>();
        let patches = [ElementPatches::alone(2), ElementPatches::grouped(&mesh)];
        patches.map(|patches| Simplices::in_patches(&mesh, patches, (gel, section)))
    }

    fn check_neo_hookean<const D: usize>(section: Section, f: &Tensor<D>, expected: StressInvariants) {
        for simplices in elements::<D>(neo_hookean(), section) {
            let x = deformed(&mesh::<D>(), f);
            for patch in 0..simplices.patches().len() {
                let stresses = simplices.stress_invariants(patch, &x, &[]);
                for (element, stress) in simplices.patches().of(patch).iter().zip(stresses) {
                    let StressInvariants { pressure, von_mises } = stress;
                    assert!((pressure - expected.pressure).abs() < 1e-13 * BULK, "{pressure}");
                    assert!((von_mises - expected.von_mises).abs() < 1e-13 * BULK, "{von_mises}");
                    assert_eq!(pressure, simplices.pressure(*element, patch, |node| x[node.index()]));
                }
            }
        }
    }

    /// Simple shear γ of a neo-Hookean gel: s = μ dev b, hence √(3/2 s:s) = μ γ √(3 + γ²), p = −μ γ²/3.
    #[test]
    fn simple_shear_of_a_neo_hookean_gel_has_its_closed_stress() {
        let von_mises = MODULUS * SHEAR * (3.0 + SHEAR * SHEAR).sqrt();
        let expected = StressInvariants { pressure: -MODULUS * SHEAR * SHEAR / 3.0, von_mises };
        check_neo_hookean::<2>(Section::Planar { thickness: 1.0 }, &simple_shear(), expected);
        check_neo_hookean::<3>(Section::Spatial, &simple_shear(), expected);
    }

    /// Hydrostatic compression to lengths c: p = −U′(J) − μ c²/J with U′ = (Λ ln J − μ)/J, Λ = K − 2/3 μ.
    #[test]
    fn hydrostatic_compression_of_a_neo_hookean_gel_has_pressure_alone() {
        let c = 0.93_f64;
        let jacobian = c * c * c;
        let slope = ((BULK - 2.0 / 3.0 * MODULUS) * jacobian.ln() - MODULUS) / jacobian;
        let expected = StressInvariants { pressure: -slope - MODULUS * c * c / jacobian, von_mises: 0.0 };
        check_neo_hookean::<3>(Section::Spatial, &(Tensor::<3>::identity() * c), expected);
        check_neo_hookean::<2>(Section::Axisymmetric, &(Tensor::<2>::identity() * c), expected);
    }

    /// At a held shear the branch falls as e^(−t/τ), and the rest shape of its dashpot becomes that of the gel, whose
    /// Hencky strain is √(4/3) ln λ.
    #[test]
    fn a_held_two_network_gel_relaxes_to_its_elastic_network_while_its_viscous_strain_grows() {
        let stretch: f64 = 0.5 * SHEAR + (1.0 + 0.25 * SHEAR * SHEAR).sqrt();
        let whole = (4.0_f64 / 3.0).sqrt() * stretch.ln();
        for simplices in elements::<3>(networks(), Section::Spatial) {
            let (rest, x) = (mesh::<3>().rest, deformed(&mesh::<3>(), &simple_shear()));
            let mut memory = vec![HistoryVariables::default(); 2 * simplices.memories()];
            assert_eq!(simplices.stress_invariants(0, &rest, &memory)[0], StressInvariants::default());
            let mut last = 0.0;
            for (step, time) in [(1e-13, 0.0), (1.0, 1.0), (40.0, 41.0)] {
                let mut answers = [ElementResponse::default(); DEPTH];
                simplices.advance(0, &x, GroupKick { length: 0.0, elapsed: step }, &mut memory, &mut answers);
                let StressInvariants { pressure, von_mises } = simplices.stress_invariants(0, &x, &memory)[0];
                let modulus = MODULUS + 2.0 * f64::exp(-time);
                let expected = modulus * SHEAR * (3.0 + SHEAR * SHEAR).sqrt();
                assert!((von_mises - expected).abs() < 1e-10 && pressure.abs() < 1e-12, "{von_mises} at {time}");
                let strain = simplices.viscous_strain(ElementId(0), &memory);
                assert!(strain >= last && strain < whole + 1e-10, "{strain} at {time}");
                last = strain;
            }
            assert!((last - whole).abs() < 1e-10, "{last}, not {whole}");
        }
    }

    #[test]
    fn viscous_strain_does_not_depend_on_the_reference_of_an_element() {
        let simplices = &elements::<2>(networks(), Section::Axisymmetric)[0];
        let mut memory = vec![HistoryVariables::<2>::default(); 2 * simplices.memories()];
        let branch = simplices.memories() - 1;
        (memory[branch].inverse, memory[branch].out) = (Tensor::<2>::new(1.6, 0.3, 0.3, 0.7), 1.0 / (1.6 * 0.7 - 0.09));
        let own = simplices.viscous_strain(ElementId(0), &memory);
        let (g, out) = (Tensor::<2>::new(1.1, 0.4, -0.2, 0.9), 1.0 / (1.1 * 0.9 + 0.08));
        for record in &mut memory {
            record.inverse = g * record.inverse * g.transpose();
            record.out *= out * out;
        }
        let other = simplices.viscous_strain(ElementId(0), &memory);
        assert!(own > 0.2 && (own - other).abs() < 1e-14, "{own} {other}");
    }

    /// Compares the rate of a linear velocity field v = L x with the deviator of its symmetric part.
    fn check_rate<const D: usize>(section: Section, rate: &Tensor<D>, hoop: f64) {
        let simplices = &elements::<D>(neo_hookean(), section)[0];
        let x = deformed(&mesh::<D>(), &(simple_shear::<D>() * 0.9));
        let v: Vec<_> = x.iter().map(|x| rate * x).collect();
        let d = (rate + rate.transpose()) * 0.5;
        let mean = (d.trace() + hoop) / 3.0;
        let diagonal = if D == 2 { (hoop - mean) * (hoop - mean) } else { 0.0 };
        let square = (d - Tensor::<D>::identity() * mean).norm_squared() + diagonal;
        for element in [0, 1].map(ElementId) {
            let found = simplices.strain_rate(element, &x, &v);
            assert!((found / (2.0 / 3.0 * square).sqrt() - 1.0).abs() < 1e-14, "{found}");
        }
    }

    #[test]
    fn the_strain_rate_of_a_linear_velocity_is_exact_with_its_hoop_rate_about_the_axis() {
        check_rate::<3>(Section::Spatial, &Tensor::<3>::new(3.0, 1.0, -2.0, 0.5, -4.0, 0.2, 1.0, 2.0, 5.0), 0.0);
        let plane = Tensor::<2>::new(3.0, 1.0, -2.0, 0.5);
        check_rate::<2>(Section::Planar { thickness: 1.0 }, &plane, 0.0);
        check_rate::<2>(Section::Axisymmetric, &Tensor::<2>::new(3.0, 0.0, -2.0, 0.5), 3.0);
    }

    #[test]
    fn a_rigid_rotation_has_no_strain_rate() {
        let simplices = &elements::<3>(neo_hookean(), Section::Spatial)[0];
        let x = mesh::<3>().rest;
        let spin = Vector::<3>::new(1.0, -2.0, 0.5);
        let v: Vec<_> = x.iter().map(|x| spin.cross(x)).collect();
        assert!(simplices.strain_rate(ElementId(0), &x, &v) < 1e-14);
    }
}
