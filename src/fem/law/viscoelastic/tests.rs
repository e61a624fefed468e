//! Viscoelastic elements: a hyperelastic equilibrium response plus Maxwell branches (numerics 6.4).

use super::simplex::{DeformationGradient, ElementKinematics, RestElement, isochoric_mean};
use super::{DEPTH, Dissipation, ElementResponse, HistoryVariables, Potential, Simplices};
use crate::constitutive::{MaxwellBranch, NeoHookean, Viscoelastic};
use crate::math::{Tensor, Vector, cofactor, cube_root, det};
use crate::mesh::ElementId;

/// Most history records of a viscoelastic element: C̄⁻¹ and J at its last tick, then C̄_i⁻¹ of each branch.
pub(super) const MOST_MEMORIES: usize = 1 + Viscoelastic::MOST_BRANCHES;

/// Sums over the branches of an element.
struct BranchForces<'a, const D: usize> {
    at: ElementKinematics<'a, D>,
    /// Σ μ_i C̄_i⁻¹, Pa.
    inverse_shapes: Tensor<D>,
    /// Out-of-plane component of Σ μ_i C̄_i⁻¹, Pa.
    out: f64,
    /// Σ μ_i tr b̄_i/3, Pa.
    mean: f64,
    /// Part of the branches in κ, N/m.
    stiffness: f64,
}

/// Deviator dev(C̄ C̄_i⁻¹), which has the eigenvalues of dev b̄ of a branch, with its out-of-plane component.
struct ShapeDeviator<const D: usize> {
    tensor: Tensor<D>,
    out: f64,
}

/// Relaxation of a branch at a constant strain.
struct BranchRelaxation<const D: usize> {
    /// Decrease of tr b̄.
    fall: f64,
    /// Deviator before the relaxation.
    deviator: ShapeDeviator<D>,
}

impl<const D: usize> ShapeDeviator<D> {
    /// Returns the linear combination `part` · self + `other_part` · other.
    fn combined(&self, part: f64, other: &Self, other_part: f64) -> Self {
        Self { tensor: self.tensor * part + other.tensor * other_part, out: self.out * part + other.out * other_part }
    }

    /// Returns the double contraction with another deviator.
    fn dot(&self, other: &Self) -> f64 {
        (self.tensor * other.tensor).trace() + self.out * other.out
    }
}

impl<const D: usize> Simplices<D> {
    /// Evaluates a patch without relaxation: its energy, J, and the responses of its elements.
    pub(super) fn evaluate_viscoelastic(
        &self,
        gel: &Viscoelastic,
        ids: &[ElementId],
        x: &[Vector<D>],
        memory: &[HistoryVariables<D>],
        answers: &mut [ElementResponse<D>; DEPTH],
    ) -> f64 {
        let elastic = self.evaluate_hyperelastic(gel.equilibrium(), ids, x, answers);
        ids.iter().zip(answers).fold(elastic, |energy, (id, answer)| {
            let mut own = [HistoryVariables::default(); MOST_MEMORIES];
            let own = &mut own[..self.memories()];
            own.copy_from_slice(&memory[self.history_range(*id)]);
            energy + self.add_branches(gel, *id, x, 0.0, own, answer).energy
        })
    }

    /// Evaluates a patch at its next tick, `step` s after the last, with relaxation of its branches.
    pub(super) fn advance_viscoelastic(
        &self,
        gel: &Viscoelastic,
        ids: &[ElementId],
        x: &[Vector<D>],
        step: f64,
        memory: &mut [HistoryVariables<D>],
        answers: &mut [ElementResponse<D>; DEPTH],
    ) -> Dissipation {
        let elastic = self.evaluate_hyperelastic(gel.equilibrium(), ids, x, answers);
        let mut sum = Dissipation { energy: elastic, ..Dissipation::default() };
        for (id, answer) in ids.iter().zip(answers) {
            let own = &mut memory[self.history_range(*id)];
            let spent = self.add_branches(gel, *id, x, step, own, answer);
            sum.energy += spent.energy;
            sum.viscous += spent.viscous;
        }
        sum
    }

    /// Returns the range of the history records of an element.
    fn history_range(&self, id: ElementId) -> std::ops::Range<usize> {
        let first = id.index() * self.memories();
        first..first + self.memories()
    }

    /// Adds the energy, forces and stiffness of the branches of an element.
    ///
    /// After a step, s, since the last tick the branches relax at the strain of its start, then at the strain of its
    /// end.
    fn add_branches(
        &self,
        gel: &Viscoelastic,
        id: ElementId,
        x: &[Vector<D>],
        step: f64,
        memory: &mut [HistoryVariables<D>],
        answer: &mut ElementResponse<D>,
    ) -> Dissipation {
        let element = &self.rest_elements[id.index()];
        let strain = self.element_deformation(id, element, x);
        let (last, rest) = memory.split_first_mut().expect("an element with branches remembers where it was");
        let now = isochoric_shape(&strain);
        let mut sum = BranchForces::new(element, &strain);
        let mut spent = Dissipation::default();
        for (branch, own) in gel.branches().iter().zip(rest) {
            if step > 0.0 {
                let before = (last.jacobian >= NeoHookean::FLOOR).then_some(&*last);
                let lost = relax_branch(own, [before, now.as_ref()], branch.relaxation_factors(step));
                spent.viscous += element.volume * 0.5 * branch.shear_modulus * lost;
            }
            spent.energy += element.volume * sum.add(branch, own);
        }
        *last = now.unwrap_or(HistoryVariables { jacobian: strain.jacobian(), ..*last });
        sum.add_to(answer);
        spent
    }
}

/// Returns C̄⁻¹ of an element, the rest shape of a fully relaxed branch; none below the floor of J.
fn isochoric_shape<const D: usize>(strain: &DeformationGradient<D>) -> Option<HistoryVariables<D>> {
    let jacobian = strain.jacobian();
    (jacobian >= NeoHookean::FLOOR && strain.det_f > 0.0).then(|| {
        let root = cube_root(jacobian);
        let inverse = strain.cofactor.transpose() / strain.det_f;
        let out = if D == 2 { root * root / (strain.out * strain.out) } else { 1.0 };
        HistoryVariables {
            inverse: inverse * inverse.transpose() * (root * root),
            out,
            jacobian,
            ..HistoryVariables::default()
        }
    })
}

/// Relaxes a branch by the factors `parts`, at the strain before the step, then at the strain now; returns the loss
/// of tr b̄.
///
/// The loss is the fall of tr b̄ at both strains, corrected for the work of the branch between them. The nodes do
/// work against the mean of the first and the last stress; the excess of the two relaxed stresses over this mean is,
/// to second order, ½ (d_b − d_a):[(1 − s_b) d_b − (1 − s_a) d], d_a = s_a d.
fn relax_branch<const D: usize>(
    branch: &mut HistoryVariables<D>,
    [before, now]: [Option<&HistoryVariables<D>>; 2],
    parts: [f64; 2],
) -> f64 {
    let first = before.map(|shape| relax_at(branch, shape, parts[0]));
    let second = now.map(|shape| relax_at(branch, shape, parts[1]));
    let falls = [&first, &second].into_iter().flatten().map(|relaxation| relaxation.fall).sum::<f64>();
    let (Some(first), Some(second)) = (first, second) else { return falls };
    let (start, end) = (first.deviator, second.deviator);
    let change = end.combined(1.0, &start, -parts[0]);
    let excess = end.combined(1.0 - parts[1], &start, parts[0] - 1.0);
    falls - 0.5 * change.dot(&excess)
}

/// Relaxes dev b̄ of a branch to its part s at the constant strain C̄⁻¹.
///
/// b̄ = θ + d, tr d = 0, becomes θ' + s d with θ'³ − θ' s²|d|²/2 + s³ det d = 1, hence C̄_i⁻¹ becomes s C̄_i⁻¹ + (θ'
/// − sθ) C̄⁻¹; θ, |d|² and det d are those of C̄ C̄_i⁻¹, too, which has the eigenvalues of b̄.
fn relax_at<const D: usize>(
    branch: &mut HistoryVariables<D>,
    shape: &HistoryVariables<D>,
    left: f64,
) -> BranchRelaxation<D> {
    let product = cofactor(&shape.inverse).transpose() / det(&shape.inverse) * branch.inverse;
    let out = if D == 2 { branch.out / shape.out } else { 0.0 };
    let before = (product.trace() + out) / 3.0;
    let tensor = product - Tensor::<D>::identity() * before;
    let deviator = ShapeDeviator { tensor, out: if D == 2 { out - before } else { 0.0 } };
    let determinant = det(&tensor) * if D == 2 { deviator.out } else { 1.0 };
    let square = left * left * deviator.dot(&deviator);
    let after = isochoric_mean(before, 0.5 * square, left * left * left * determinant);
    let towards = after - left * before;
    branch.inverse = branch.inverse * left + shape.inverse * towards;
    branch.out = if D == 2 { branch.out * left + shape.out * towards } else { 1.0 };
    BranchRelaxation { fall: 3.0 * (before - after), deviator }
}

impl<'a, const D: usize> BranchForces<'a, D> {
    /// Creates empty sums for a deformed element.
    fn new(element: &'a RestElement<D>, strain: &'a DeformationGradient<D>) -> Self {
        let at = ElementKinematics::new(element, strain);
        Self { at, inverse_shapes: Tensor::<D>::zeros(), out: 0.0, mean: 0.0, stiffness: 0.0 }
    }

    /// Adds a branch with its rest shape; returns its energy, J/m³.
    fn add(&mut self, branch: &MaxwellBranch, own: &HistoryVariables<D>) -> f64 {
        let (mu, elastic) = (branch.shear_modulus, self.at.elastic(own));
        let trace = elastic.trace();
        self.inverse_shapes += own.inverse * mu;
        self.out += own.out * mu;
        // Thirds of each trace: at rest the sum is exactly Σ μ_i.
        self.mean += mu * (trace * (1.0 / 3.0));
        let curvature =
            if self.at.is_above_floor() { self.at.shear_bound(&elastic) } else { self.floor_curvature(own) };
        self.stiffness += self.at.element.volume * mu * curvature;
        0.5 * mu * (trace - 3.0)
    }

    /// Returns the curvature of a branch below the floor of J, where J^(−2/3) is constant and W quadratic, 1/m².
    fn floor_curvature(&self, own: &HistoryVariables<D>) -> f64 {
        let element = self.at.element;
        let hoop = element.hoop * element.hoop * own.out;
        let of = |gradient: &Vector<D>| gradient.dot(&(own.inverse * gradient)) + hoop;
        self.at.scale * element.gradients[..=D].iter().map(of).sum::<f64>()
    }

    /// Adds the forces of P = Σ μ_i [J^(−2/3) F C̄_i⁻¹ − tr b̄_i/(3J) ∂J/∂F], and κ, to a response.
    fn add_to(&self, answer: &mut ElementResponse<D>) {
        let (strain, scale) = (self.at.strain, self.at.scale);
        let volumetric = if self.at.is_above_floor() { -self.mean / self.at.jacobian } else { 0.0 };
        let p = strain.f * self.inverse_shapes * scale + strain.cofactor * (volumetric * strain.out);
        let forces = self.at.element.forces(&p, scale * strain.out * self.out + volumetric * strain.det_f);
        answer.forces.iter_mut().zip(forces).for_each(|(force, own)| *force += own);
        answer.stiffness += self.stiffness;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Section;
    use crate::mesh::{Mesh, NodeId};

    const TIMES: [f64; 2] = [2e-3, 7e-3];

    fn gel() -> Viscoelastic {
        let branches =
            [(2.0, TIMES[0]), (5.0, TIMES[1])].map(|(shear_modulus, time)| MaxwellBranch { shear_modulus, time });
        Viscoelastic::new(NeoHookean::new(3.0, 40.0), &branches)
    }

    fn simplex<const D: usize>(section: Section, gel: Viscoelastic) -> (Vec<Vector<D>>, Simplices<D>) {
        let corners = [[0.8, 0.1, 0.0], [1.9, 0.3, 0.1], [1.1, 1.2, -0.1], [1.0, 0.4, 1.1]];
        let rest: Vec<_> = corners[..=D].iter().map(|x| Vector::<D>::from_fn(|i, _| x[i])).collect();
        let nodes = if D == 2 { [0, 1, 2, 0] } else { [0, 1, 2, 3] };
        let mesh = Mesh::new(rest.clone(), vec![nodes.map(NodeId)]);
        let material = crate::constitutive::Material::Viscoelastic(gel);
        (rest, Simplices::in_patches(&mesh, crate::mesh::ElementPatches::alone(1), (material, section)))
    }

    fn moved<const D: usize>(rest: &[Vector<D>], size: f64) -> Vec<Vector<D>> {
        let wave = |i: usize, a: usize| size * ((7 * a + 3 * i) as f64).sin();
        rest.iter().enumerate().map(|(a, x)| x + Vector::<D>::from_fn(|i, _| wave(i, a))).collect()
    }

    fn fresh<const D: usize>(simplices: &Simplices<D>) -> Vec<HistoryVariables<D>> {
        vec![HistoryVariables::default(); simplices.memories()]
    }

    /// Advances the element to the positions `x`.
    fn advance<const D: usize>(
        simplices: &Simplices<D>,
        x: &[Vector<D>],
        (step, memory): (f64, &mut [HistoryVariables<D>]),
    ) -> (Dissipation, ElementResponse<D>) {
        let mut answers = [ElementResponse::default(); DEPTH];
        let spent = simplices.advance(0, x, (step, memory), &mut answers);
        (spent, answers[0])
    }

    fn held<const D: usize>(
        simplices: &Simplices<D>,
        x: &[Vector<D>],
        memory: &[HistoryVariables<D>],
    ) -> (f64, ElementResponse<D>) {
        let mut answers = [ElementResponse::default(); DEPTH];
        (simplices.evaluate(0, x, memory, &mut answers), answers[0])
    }

    /// Runs a check in the plane, about an axis and in space.
    macro_rules! everywhere {
        ($check:ident, $gel:expr) => {
            let (rest, simplices) = simplex::<2>(Section::Planar { thickness: 0.7 }, $gel);
            $check(&rest, &simplices);
            let (rest, simplices) = simplex::<2>(Section::Axisymmetric, $gel);
            $check(&rest, &simplices);
            let (rest, simplices) = simplex::<3>(Section::Spatial, $gel);
            $check(&rest, &simplices);
        };
    }

    /// Returns the history of an element deformed to `size` by a detour, with relaxation.
    fn bent<const D: usize>(rest: &[Vector<D>], simplices: &Simplices<D>, size: f64) -> Vec<HistoryVariables<D>> {
        let mut memory = fresh(simplices);
        advance(simplices, rest, (0.0, &mut memory));
        for part in [-0.5, 0.3, 1.0] {
            advance(simplices, &moved(rest, part * size), (1.5e-3, &mut memory));
        }
        memory
    }

    fn check_forces<const D: usize>(rest: &[Vector<D>], simplices: &Simplices<D>) {
        let step = 1e-6;
        for size in [0.0, 0.1, 0.3] {
            let (memory, x) = (bent(rest, simplices, size), moved(rest, 0.8 * size));
            let f = held(simplices, &x, &memory).1.forces;
            for (a, i) in (0..=D).flat_map(|a| (0..D).map(move |i| (a, i))) {
                let energy = |s: f64| {
                    let mut x = x.clone();
                    x[a][i] += s;
                    held(simplices, &x, &memory).0
                };
                let slope = (energy(step) - energy(-step)) / (2.0 * step);
                assert!((slope + f[a][i]).abs() < 1e-7 * (1.0 + f[a].norm()), "node {a}, direction {i}");
            }
        }
    }

    #[test]
    fn forces_are_minus_the_gradient_of_the_energy_without_relaxation() {
        everywhere!(check_forces, gel());
    }

    fn check_stiffness<const D: usize>(rest: &[Vector<D>], simplices: &Simplices<D>) {
        let step = 1e-6;
        for size in [0.0, 0.05, 0.1, 0.2, 0.3, 0.4, 1.5] {
            let (memory, x) = (bent(rest, simplices, size), moved(rest, size));
            let n = (D + 1) * D;
            let stiffness = nalgebra::DMatrix::from_fn(n, n, |row, column| {
                let probe = |s: f64| {
                    let mut x = x.clone();
                    x[column / D][column % D] += s;
                    held(simplices, &x, &memory).1.forces[row / D][row % D]
                };
                (probe(-step) - probe(step)) / (2.0 * step)
            });
            let greatest = (&stiffness + stiffness.transpose()).symmetric_eigenvalues().max() / 2.0;
            let bound = held(simplices, &x, &memory).1.stiffness;
            assert!(greatest <= bound * (1.0 + 1e-6), "{greatest} above the bound {bound} at {size}");
            assert!(greatest > 0.1 * bound, "the bound {bound} is idle against {greatest} at {size}");
        }
    }

    #[test]
    fn the_stiffness_bound_is_an_upper_bound_and_tight() {
        everywhere!(check_stiffness, gel());
    }

    /// The forces of the branches alone: all but those of the gel in the long run.
    fn of_branches<const D: usize>(
        answer: &ElementResponse<D>,
        rest: &ElementResponse<D>,
    ) -> impl Iterator<Item = f64> {
        let both = answer.forces.into_iter().zip(rest.forces).take(D + 1);
        both.flat_map(|(all, rest)| (all - rest).iter().copied().collect::<Vec<_>>())
    }

    fn check_relaxation<const D: usize>(rest: &[Vector<D>], simplices: &Simplices<D>) {
        let x = moved(rest, 0.3);
        let mut start = fresh(simplices);
        let (_, first) = advance(simplices, &x, (0.0, &mut start));
        let mut forgotten = start.clone();
        let (_, end) = advance(simplices, &x, (1e3, &mut forgotten));
        let mut answers = vec![];
        for n in [1, 7, 1000] {
            let mut memory = start.clone();
            let step = TIMES[0] / f64::from(n);
            let (_, last) = (0..n).map(|_| advance(simplices, &x, (step, &mut memory))).last().unwrap();
            let exact = (-1.0_f64).exp();
            for (now, before) in of_branches(&last, &end).zip(of_branches(&first, &end)) {
                assert!((now - exact * before).abs() < 1e-12 * (1.0 + before.abs()), "{n}: {now} of {before}");
            }
            answers.push(last);
        }
        let size = answers[0].forces[0].norm();
        assert!((answers[0].forces[0] - answers[2].forces[0]).norm() < 1e-12 * size);
    }

    #[test]
    fn stress_falls_as_the_exponential_at_any_strain_and_in_any_steps() {
        let rest = NeoHookean::new(3.0, 40.0);
        everywhere!(check_relaxation, Viscoelastic::new(rest, &[MaxwellBranch { shear_modulus: 5.0, time: TIMES[0] }]));
    }

    fn check_losses<const D: usize>(rest: &[Vector<D>], simplices: &Simplices<D>) {
        let mut memory = fresh(simplices);
        let x = moved(rest, 0.4);
        let stored = advance(simplices, &x, (0.0, &mut memory)).0.energy;
        let lost: f64 = (0..50)
            .map(|_| {
                let spent = advance(simplices, &x, (1e-3, &mut memory)).0;
                assert!(spent.viscous >= 0.0);
                spent.viscous
            })
            .sum();
        let left = held(simplices, &x, &memory).0;
        assert!(lost > 0.1 * stored && (stored - left - lost).abs() < 1e-12 * stored);
        let shapes = memory[1..].iter().map(|own| det(&own.inverse) * own.out);
        shapes.for_each(|volume| assert!((volume - 1.0).abs() < 1e-13));
    }

    #[test]
    fn dissipation_at_constant_strain_is_the_loss_of_stored_energy() {
        everywhere!(check_losses, gel());
    }

    #[test]
    fn dissipation_of_the_branches_is_the_work_that_is_not_stored() {
        let (rest, simplices) = simplex::<3>(Section::Spatial, gel());
        for step in [1e-5, 1e-3, 1.0] {
            let mut memory = fresh(&simplices);
            let passed = |i: u32| moved(&rest, 1e-3 * (0.3 * f64::from(i)).sin());
            let (mut before, mut push) = (passed(0), advance(&simplices, &passed(0), (0.0, &mut memory)).1.forces);
            let (mut work, mut lost, mut stored) = (0.0, 0.0, 0.0);
            for i in 1..=100 {
                let x = passed(i);
                let (spent, answer) = advance(&simplices, &x, (step, &mut memory));
                for a in 0..4 {
                    work -= 0.5 * (push[a] + answer.forces[a]).dot(&(x[a] - before[a]));
                }
                (before, push, stored, lost) = (x, answer.forces, spent.energy, lost + spent.viscous);
            }
            let start = held(&simplices, &passed(0), &fresh(&simplices)).0;
            let missing = work - (stored - start) - lost;
            assert!(missing.abs() < 1e-3 * lost, "{step}: {missing:e} of {lost:e}");
        }
    }

    #[test]
    fn a_small_strain_ramp_is_exact() {
        let (rest, simplices) = simplex::<3>(Section::Spatial, gel());
        let end = |n: u32| {
            let mut memory = fresh(&simplices);
            let step = 4e-3 / f64::from(n);
            let passed = |i: u32| moved(&rest, 1e-4 * f64::from(i) / f64::from(n));
            advance(&simplices, &rest, (0.0, &mut memory));
            (1..=n).map(|i| advance(&simplices, &passed(i), (step, &mut memory)).1.forces[0]).last().unwrap()
        };
        let exact = end(4096);
        for n in [1, 3, 16] {
            assert!((end(n) - exact).norm() < 1e-3 * exact.norm(), "{n}");
        }
    }

    #[test]
    fn an_inverted_element_keeps_its_history() {
        let (rest, simplices) = simplex::<3>(Section::Spatial, gel());
        let mut memory = bent(&rest, &simplices, 0.2);
        let before = memory.clone();
        let mut flat = rest.clone();
        flat[3] = rest[0] + (rest[0] - rest[3]) * 0.3;
        let (spent, answer) = advance(&simplices, &flat, (0.0, &mut memory));
        assert!(answer.jacobian < 0.0 && spent.energy.is_finite() && answer.stiffness.is_finite());
        assert_eq!(advance(&simplices, &flat, (1.0, &mut memory)).0.viscous, 0.0);
        assert_eq!(memory[1..], before[1..]);
        assert!(memory.iter().all(HistoryVariables::is_valid));
    }
}
