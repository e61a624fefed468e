//! Viscoplastic elements, F = F_e F_p: radial return onto the yield surface (Simo & Hughes 1998, numerics A16).

use super::rest_element::{DeformationGradient, ElasticCauchyGreen, ElementKinematics};
use super::simplices::Simplices;
use crate::constitutive::{Material, StressReturn, Viscoplastic, VolumetricEnergy, VolumetricResponse};
use crate::fem::{DEPTH, Dissipation, ElementResponse, HistoryVariables, Section};
use crate::math::{Tensor, Vector, cube_root, det};
use crate::mesh::ElementId;

/// Viscoplastic element during its evaluation.
struct ViscoplasticElement<'a, const D: usize> {
    gel: &'a Viscoplastic,
    at: ElementKinematics<'a, D>,
}

impl<const D: usize> Simplices<D> {
    /// Evaluates a patch: its energy, J, its dissipation, and the responses of its elements.
    ///
    /// A step above 0 s updates the history. At step 0 the viscous part of U′ of each element is `held`, Pa.
    pub(crate) fn evaluate_viscoplastic(
        &self,
        (gel, ids): (&Viscoplastic, &[ElementId]),
        x: &[Vector<D>],
        (step, memory, held): (f64, &mut [HistoryVariables<D>; DEPTH], &[f64; DEPTH]),
        answers: &mut [ElementResponse<D>; DEPTH],
    ) -> Dissipation {
        let mut strains = [DeformationGradient::none(); DEPTH];
        let (mut volume, mut now) = (0.0, 0.0);
        for (id, strain) in ids.iter().zip(&mut strains) {
            let element = &self.rest_elements[id.index()];
            *strain = self.element_deformation(*id, element, x);
            volume += element.volume;
            now += element.volume * strain.jacobian();
        }
        let shared = if ids.len() > 1 { gel.shared(now / volume) } else { gel.volumetric(now / volume) };
        let mut spent = Dissipation { energy: volume * shared.energy, ..Dissipation::default() };
        let remembered = memory.iter_mut().zip(held);
        for (((id, strain), (memory, held)), answer) in ids.iter().zip(&strains).zip(remembered).zip(answers) {
            let element = &self.rest_elements[id.index()];
            let own = gel.own(strain.jacobian());
            let own = if ids.len() > 1 { own } else { VolumetricResponse { energy: 0.0, slope: 0.0, curvature: 0.0 } };
            let flow = ViscoplasticElement { gel, at: ElementKinematics::new(element, strain) };
            let sound = memory.left;
            let slope = own.slope + shared.slope;
            let (elastic, lost) = flow.returned((step, slope), memory);
            let left = gel.softening.map_or(sound, |softening| softening.after_step(sound, memory.plastic, step));
            memory.left = left;
            let sheared = 0.5 * gel.shear_modulus * (elastic.trace() - 3.0);
            spent.plastic += element.volume * lost * (0.5 * (sound + left));
            spent.damage += element.volume * sheared * (sound - left);
            let (rate, viscous) = if step > 0.0 { flow.viscous(step, memory) } else { (0.0, *held) };
            spent.viscous += element.volume * viscous * (strain.jacobian() - memory.jacobian);
            memory.jacobian = strain.jacobian();
            spent.energy += element.volume * (own.energy + sheared * left);
            let curvature = own.curvature.max(0.0) + shared.curvature.max(0.0);
            let mu = gel.shear_modulus * left;
            let stiffness = self.bound((&flow, &elastic), mu, (slope + viscous, curvature, rate));
            *answer = flow.answer(memory, (&elastic, mu), (slope + viscous, stiffness));
        }
        spent
    }

    /// Returns κ, a bound of the stiffness eigenvalues of an element, raised for the stable step lost to viscosity.
    ///
    /// The volumetric part is δ²U = U″J² (tr L)² + U′J [(tr L)² − tr(LL)], the bracket at most s|L|² with s = 1 in the
    /// plane, else 2. Return mapping and damage only reduce the stiffness. `mu` is the damaged modulus.
    fn bound(
        &self,
        (flow, elastic): (&ViscoplasticElement<'_, D>, &ElasticCauchyGreen<D>),
        mu: f64,
        (slope, curvature, rate): (f64, f64, f64),
    ) -> f64 {
        let (hoop, j) = (flow.at.hoop(), flow.at.jacobian);
        let (mut spread, mut dilated) = (0.0, 0.0);
        for gradient in flow.at.gradients() {
            let mut whole = *gradient;
            whole[0] += hoop;
            spread += gradient.norm_squared() + hoop * hoop;
            dilated += whole.norm_squared();
        }
        let minors = if matches!(self.section, Section::Planar { .. }) { 1.0 } else { 2.0 };
        let shear = mu * flow.at.shear_bound(elastic);
        let volumetric = curvature * j * j * dilated + slope.abs() * j * minors * spread;
        flow.damped(flow.at.element.volume * (shear + volumetric), dilated, rate)
    }

    /// Returns the isochoric elastic stretch as the Cholesky factor L, LLᵀ = b̄, with the out-of-plane stretch.
    ///
    /// None for an inverted element and for a fluid. L stands for F_e without its rotation in means over elements.
    ///
    /// A mean of unit-determinant factors has a determinant of 1 or more, so no more than the mean distortion.
    #[must_use]
    pub fn elastic(&self, id: ElementId, x: &[Vector<D>], memory: &HistoryVariables<D>) -> Option<(Tensor<D>, f64)> {
        let element = self.rest_element(id);
        let strain = self.element_deformation(id, &element, x);
        let f = strain.f;
        if matches!(&self.material, Material::Flowing(gel) if gel.shear_modulus == 0.0) {
            return None;
        }
        let out = strain.out * memory.out.sqrt();
        let lower = nalgebra::Cholesky::new(f * memory.inverse * f.transpose())?.l();
        let jacobian = det(&lower) * out;
        let root = cube_root(jacobian);
        (jacobian > 0.0 && strain.det_f > 0.0).then(|| (lower / root, if D == 2 { out / root } else { 1.0 }))
    }
}

impl<const D: usize> ViscoplasticElement<'_, D> {
    /// Radial return mapping of b̄ after a step, s; returns b̄ and the dissipation, J/m³.
    ///
    /// Stresses are those of the undamaged material: damage scales stress and yield stress alike (numerics 6.2).
    fn returned(&self, (step, slope): (f64, f64), memory: &mut HistoryVariables<D>) -> (ElasticCauchyGreen<D>, f64) {
        let (strain, scale, mu) = (self.at.strain, self.at.scale, self.gel.shear_modulus);
        let trial = self.at.elastic(memory);
        let Some(strength) = self.gel.strength else { return (trial, 0.0) };
        let deviator = trial.deviator();
        let stress = mu * (1.5 * deviator.norm_squared()).sqrt();
        let before = std::mem::replace(&mut memory.stress, stress);
        memory.felt = strength.filtered_slope(memory.felt, slope, step);
        if step <= 0.0 || !self.at.is_above_floor() {
            return (trial, 0.0);
        }
        let StressReturn { stress: left, strain: flown } =
            strength.return_stress(stress, mu * trial.trace(), memory.felt, step, memory.rate);
        if flown == 0.0 {
            return (trial, 0.0);
        }
        let elastic = deviator.with_unit_determinant(left / stress, trial.trace() / 3.0);
        let inverse = strain.cofactor.transpose() / strain.det_f;
        memory.inverse = inverse * elastic.tensor * inverse.transpose() / scale;
        memory.out = if D == 2 { elastic.out / (strain.out * strain.out * scale) } else { 1.0 };
        memory.plastic += flown;
        (memory.rate, memory.stress) = (flown / step, left);
        // Dissipation at the mean of the last and the present stress, the one that acts on the nodes in between. q Δε_p
        // would neglect that Ī₁ is no quadratic form, and miss 8 % at q = μ/3 in tension.
        (elastic, mu * (trial.trace() - elastic.trace()) * 0.5 * (before + left) / (left + stress))
    }

    /// Returns ε̇ and the viscous part η ε̇ of U′, Pa; its dissipation per rest volume is η ε̇ J̇.
    fn viscous(&self, step: f64, memory: &HistoryVariables<D>) -> (f64, f64) {
        let rate = (self.at.strain.jacobian() - memory.jacobian) / (self.at.jacobian * step);
        (rate, self.resistance(rate) * rate)
    }

    fn resistance(&self, rate: f64) -> f64 {
        self.gel.viscosity.at(self.gel.density, self.gel.sound_speed(), self.height(), rate)
    }

    /// Returns the least height of the element, m.
    fn height(&self) -> f64 {
        1.0 / self.at.gradients().iter().map(Vector::<D>::norm_squared).fold(0.0, f64::max).sqrt()
    }

    /// Returns the undamped stiffness with the stable step of κ with viscosity, N/m.
    ///
    /// The viscous forces are −C v with |C| ≤ c = w η J Σ|b|², twice that of the quadratic part. With the velocity of
    /// half a step before, a node of mass m is stable up to (2/ω)(√(1 + ξ²) − ξ), ω² = κ/m, ξ = c/(2mω) (numerics
    /// 1.3g). This limit is 2√m/(√(κ + s²) + s) with s = c/(2√m).
    fn damped(&self, kappa: f64, dilated: f64, rate: f64) -> f64 {
        let c = self.at.element.volume * self.resistance(2.0 * rate) * self.at.jacobian * dilated;
        let mass = self.gel.density * self.at.element.volume / (D + 1) as f64;
        let s = 0.5 * c / mass.sqrt();
        let root = (kappa + s * s).sqrt() + s;
        root * root
    }

    /// Computes the forces of P = μ J^(−2/3) F C̄_p⁻¹ + (U′ − μ Ī₁/(3J)) ∂J/∂F, μ being the damaged modulus.
    fn answer(
        &self,
        memory: &HistoryVariables<D>,
        (elastic, mu): (&ElasticCauchyGreen<D>, f64),
        (slope, stiffness): (f64, f64),
    ) -> ElementResponse<D> {
        let (strain, scale) = (self.at.strain, self.at.scale);
        let sheared = if self.at.is_above_floor() { mu * elastic.trace() / (3.0 * self.at.jacobian) } else { 0.0 };
        let volumetric = slope - sheared;
        let p = strain.f * memory.inverse * (mu * scale) + strain.cofactor * (volumetric * strain.out);
        let forces = self.at.element.forces(&p, mu * scale * strain.out * memory.out + volumetric * strain.det_f);
        ElementResponse { forces, stiffness, jacobian: strain.jacobian() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constitutive::{BulkViscosity, DamageLaw, EquationOfState, PressureHardening, YieldLaw};
    use crate::fem::Potential;
    use crate::mesh::{ElementPatches, Mesh, NodeId};

    fn gel() -> Viscoplastic {
        Viscoplastic {
            shear_modulus: 4.8,
            state: EquationOfState::new(60.0, 0.0, 20.0),
            strength: Some(YieldLaw::new(0.3, 0.2, 1.6)),
            softening: Some(DamageLaw::new(0.1, 0.05, 0.1)),
            viscosity: BulkViscosity { linear: 0.1, quadratic: 1.0 },
            density: 1.0,
        }
    }

    /// Returns a patch of two triangles or two tetrahedra.
    fn pair<const D: usize>(section: Section) -> (Mesh<D>, Simplices<D>) {
        pair_of(gel(), section)
    }

    fn pair_of<const D: usize>(gel: Viscoplastic, section: Section) -> (Mesh<D>, Simplices<D>) {
        let corners = [[0.8, 0.1, 0.0], [1.9, 0.3, 0.1], [1.1, 0.2, 1.2], [0.9, 1.3, 0.3], [1.7, 1.2, 1.0]];
        let flat = [[0.8, 0.1], [1.9, 0.3], [1.1, 1.2], [2.1, 1.4]];
        let rest: Vec<Vector<D>> = if D == 2 {
            flat.iter().map(|x| Vector::<D>::from_fn(|i, _| x[i])).collect()
        } else {
            corners.iter().map(|x| Vector::<D>::from_fn(|i, _| x[i])).collect()
        };
        let ids = |nodes: [u32; 4]| nodes.map(NodeId);
        let elements = if D == 2 {
            vec![ids([0, 1, 2, 0]), ids([1, 3, 2, 0])]
        } else {
            vec![ids([0, 1, 3, 2]), ids([1, 4, 3, 2])]
        };
        let mut mesh = Mesh::new(rest, elements);
        mesh.held = vec![[false; D]; mesh.rest.len()];
        let patches = ElementPatches::grouped(&mesh);
        assert_eq!(patches.of(0).len(), 2);
        let simplices = Simplices::in_patches(&mesh, patches, (Material::Flowing(gel), section));
        (mesh, simplices)
    }

    fn waved<const D: usize>(mesh: &Mesh<D>, size: f64) -> Vec<Vector<D>> {
        let wave = |i: usize, a: usize| size * ((7 * a + 3 * i) as f64).sin();
        mesh.rest.iter().enumerate().map(|(a, x)| x + Vector::<D>::from_fn(|i, _| wave(i, a))).collect()
    }

    /// Returns the history of two elements after a large shear in small steps.
    fn flown<const D: usize>(mesh: &Mesh<D>, simplices: &Simplices<D>) -> Vec<HistoryVariables<D>> {
        let mut memory = vec![HistoryVariables::default(); 2];
        for step in 1..=50 {
            let x = waved(mesh, 0.004 * f64::from(step));
            simplices.advance(0, &x, 0.01, &mut memory, &mut [ElementResponse::default(); DEPTH]);
        }
        assert!(memory.iter().all(|memory| memory.plastic > 0.01), "{memory:?}");
        memory
    }

    /// Energy, and the forces on all nodes.
    fn pull<const D: usize>(
        simplices: &Simplices<D>,
        x: &[Vector<D>],
        memory: &[HistoryVariables<D>],
    ) -> (f64, Vec<Vector<D>>, f64) {
        let mut answers = [ElementResponse::default(); DEPTH];
        let energy = simplices.evaluate(0, x, memory, &mut answers);
        let mut forces = vec![Vector::<D>::zeros(); x.len()];
        for (element, answer) in answers[..2].iter().enumerate() {
            for (node, force) in simplices.nodes(ElementId(element as u32)).iter().zip(&answer.forces) {
                forces[node.index()] += force;
            }
        }
        (energy, forces, answers[0].stiffness + answers[1].stiffness)
    }

    fn check_forces<const D: usize>(section: Section) {
        let (mesh, simplices) = pair::<D>(section);
        let memory = flown(&mesh, &simplices);
        let step = 1e-6;
        for size in [0.0, 0.05, 0.2, 0.25] {
            let x = waved(&mesh, size);
            let forces = pull(&simplices, &x, &memory).1;
            for (a, i) in (0..x.len()).flat_map(|a| (0..D).map(move |i| (a, i))) {
                let energy = |s: f64| {
                    let mut moved = x.clone();
                    moved[a][i] += s;
                    pull(&simplices, &moved, &memory).0
                };
                let slope = (energy(step) - energy(-step)) / (2.0 * step);
                assert!((slope + forces[a][i]).abs() < 1e-6 * (1.0 + forces[a].norm()), "{section:?} {size} {a} {i}");
            }
        }
    }

    #[test]
    fn forces_are_minus_the_gradient_of_the_energy_after_plastic_flow() {
        check_forces::<2>(Section::Planar { thickness: 0.7 });
        check_forces::<2>(Section::Axisymmetric);
        check_forces::<3>(Section::Spatial);
    }

    fn check_stiffness<const D: usize>(section: Section) {
        let (mesh, simplices) = pair::<D>(section);
        let memory = flown(&mesh, &simplices);
        let step = 1e-6;
        for size in [0.0, 0.05, 0.2, 0.25] {
            let x = waved(&mesh, size);
            let n = x.len() * D;
            let stiffness = nalgebra::DMatrix::from_fn(n, n, |row, column| {
                let probe = |s: f64| {
                    let mut moved = x.clone();
                    moved[column / D][column % D] += s;
                    pull(&simplices, &moved, &memory).1[row / D][row % D]
                };
                (probe(-step) - probe(step)) / (2.0 * step)
            });
            let greatest = (&stiffness + stiffness.transpose()).symmetric_eigenvalues().max() / 2.0;
            let bound = pull(&simplices, &x, &memory).2;
            assert!(greatest <= bound, "{section:?} {size}: {greatest} above the bound {bound}");
            assert!(greatest > 0.05 * bound, "{section:?} {size}: the bound {bound} is idle against {greatest}");
        }
    }

    #[test]
    fn the_stiffness_bound_holds_after_plastic_flow() {
        check_stiffness::<2>(Section::Planar { thickness: 0.7 });
        check_stiffness::<2>(Section::Axisymmetric);
        check_stiffness::<3>(Section::Spatial);
    }

    #[test]
    fn plastic_flow_is_isochoric_and_ends_on_the_yield_surface() {
        let (mesh, simplices) = pair::<2>(Section::Axisymmetric);
        let mut memory = flown(&mesh, &simplices);
        let x = waved(&mesh, 0.21);
        simplices.advance(0, &x, 0.01, &mut memory, &mut [ElementResponse::default(); DEPTH]);
        for (id, memory) in (0..).map(ElementId).zip(&memory) {
            assert!((det(&memory.inverse) * memory.out - 1.0).abs() < 1e-12);
            let (element, gel) = (simplices.rest_element(id), gel());
            let strain = simplices.element_deformation(id, &element, &x);
            let elastic = ElementKinematics::new(&element, &strain).elastic(memory);
            let stress = gel.shear_modulus * (1.5 * elastic.deviator().norm_squared()).sqrt();
            let bears = gel.strength.unwrap().at(memory.rate);
            assert!((stress / bears - 1.0).abs() < 1e-8, "{stress} {bears}");
        }
    }

    #[test]
    fn pressure_raises_the_yield_stress_and_tension_does_not() {
        let (mesh, _) = pair::<3>(Section::Spatial);
        let mesh = Mesh::new(mesh.rest, mesh.elements[..1].to_vec());
        let (strength, plain) = (gel().strength.unwrap(), gel());
        let gel = Viscoplastic {
            strength: Some(strength.with_confinement(PressureHardening { pressure: 3.0, factor: 5.0, time: 0.0 })),
            softening: None,
            ..plain
        };
        let simplices = Simplices::new(&mesh, Material::Flowing(gel), Section::Spatial);
        // K (1/J − 1) with K = 60 at the sizes to which the rest is brought.
        for (size, confined) in
            [(1.02, 1.0), (0.99_f64, 1.0 + 4.0 * 60.0 * (0.99_f64.powi(-3) - 1.0) / 3.0), (0.9, 5.0)]
        {
            let mut memory = vec![HistoryVariables::default()];
            for step in 0..=50 {
                let shear = 0.01 * f64::from(step);
                let x: Vec<_> = mesh.rest.iter().map(|x| (x + Vector::<3>::x() * shear * x[2]) * size).collect();
                simplices.advance(0, &x, 0.01, &mut memory, &mut [ElementResponse::default(); DEPTH]);
                if step == 50 {
                    let (element, bears) =
                        (simplices.rest_element(ElementId(0)), confined * strength.at(memory[0].rate));
                    let strain = simplices.element_deformation(ElementId(0), &element, &x);
                    let elastic = ElementKinematics::new(&element, &strain).elastic(&memory[0]);
                    let stress = gel.shear_modulus * (1.5 * elastic.deviator().norm_squared()).sqrt();
                    assert!((stress / bears - 1.0).abs() < 1e-8, "{size}: {stress} for {bears}");
                }
            }
        }
    }

    /// Returns the relative energy residual of a pair sheared there and back.
    fn residual(gel: Viscoplastic, steps: u32) -> f64 {
        let (mesh, simplices) = pair_of::<2>(gel, Section::Axisymmetric);
        let mut memory = vec![HistoryVariables::default(); 2];
        let (mut work, mut lost, mut before) = (0.0, 0.0, (mesh.rest.clone(), vec![Vector::<2>::zeros(); 4]));
        let (mut energy, mut damage) = (0.0, 0.0);
        for step in 0..=steps {
            let along = f64::from(step) / f64::from(steps);
            let x = waved(&mesh, 0.25 * (std::f64::consts::PI * along).sin());
            let mut answers = [ElementResponse::default(); DEPTH];
            let time = if step == 0 { 0.0 } else { 1.0 / f64::from(steps) };
            let spent = simplices.advance(0, &x, time, &mut memory, &mut answers);
            let mut forces = vec![Vector::<2>::zeros(); 4];
            for (element, answer) in answers[..2].iter().enumerate() {
                let nodes = simplices.nodes(ElementId(element as u32));
                nodes.iter().zip(&answer.forces).for_each(|(node, force)| forces[node.index()] += force);
            }
            let moved = x.iter().zip(&before.0).zip(forces.iter().zip(&before.1));
            work -= moved.map(|((x, old), (f, g))| 0.5 * (f + g).dot(&(x - old))).sum::<f64>();
            assert!(spent.plastic >= 0.0 && spent.viscous >= 0.0 && spent.damage >= 0.0);
            damage += spent.damage;
            lost += spent.plastic + spent.viscous + spent.damage;
            energy = spent.energy;
            before = (x, forces);
        }
        assert!(lost > 0.2 * work && energy > 0.0 && damage > 0.01 * work, "{lost}, {damage} of {work} is lost");
        (work - energy - lost) / work
    }

    #[test]
    fn damage_grows_under_cyclic_strain_and_never_heals() {
        let (mesh, simplices) = pair::<2>(Section::Axisymmetric);
        let (mut memory, mut left) = (vec![HistoryVariables::default(); 2], [1.0; 2]);
        for step in 1..=200 {
            let x = waved(&mesh, 0.25 * (f64::from(step) * 0.0314).sin());
            simplices.advance(0, &x, 0.01, &mut memory, &mut [ElementResponse::default(); DEPTH]);
            assert!(memory.iter().zip(left).all(|(memory, left)| memory.left <= left && memory.left > 0.05));
            left = [memory[0].left, memory[1].left];
        }
        assert!(left.iter().all(|left| *left < 0.3), "{left:?}");
    }

    #[test]
    fn damage_scales_all_shear_stress_and_no_plastic_flow() {
        let (mesh, simplices) = pair::<2>(Section::Axisymmetric);
        let memory = flown(&mesh, &simplices);
        let sound: Vec<HistoryVariables<2>> =
            memory.iter().map(|memory| HistoryVariables { left: 1.0, ..*memory }).collect();
        let gone: Vec<HistoryVariables<2>> =
            memory.iter().map(|memory| HistoryVariables { left: 0.0, ..*memory }).collect();
        let half: Vec<HistoryVariables<2>> =
            memory.iter().map(|memory| HistoryVariables { left: 0.5, ..*memory }).collect();
        let x = waved(&mesh, 0.2);
        let [sound, gone, half] = [sound, gone, half].map(|memory| pull(&simplices, &x, &memory));
        assert!((half.0 - 0.5 * (sound.0 + gone.0)).abs() < 1e-12 * sound.0 && gone.0 < sound.0);
        for ((half, sound), gone) in half.1.iter().zip(&sound.1).zip(&gone.1) {
            assert!((half - (sound + gone) * 0.5).norm() < 1e-12 * sound.norm());
        }
    }

    #[test]
    fn dissipation_is_the_work_that_is_not_stored() {
        let felt = |time: f64| {
            let strength =
                gel().strength.map(|own| own.with_confinement(PressureHardening { pressure: 3.0, factor: 5.0, time }));
            Viscoplastic { strength, ..gel() }
        };
        for (gel, most) in [(gel(), 3e-5), (felt(0.0), 6e-4), (felt(0.02), 6e-4)] {
            let [coarse, fine] = [400, 1600].map(|steps| residual(gel, steps).abs());
            assert!(coarse < most && fine < 0.3 * coarse, "{coarse:e} {fine:e}");
        }
    }
}
