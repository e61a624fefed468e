//! Forces, stiffness bound, relaxation, damage and dissipation of two-network elements, one by one.

use super::*;
use crate::constitutive::{BulkViscosity, EquationOfState, StretchDamage};
use crate::fem::{DEPTH, Dissipation, ElementResponse, GroupKick, Potential, Simplices};
use crate::math::{Tensor, Vector, det};
use crate::mesh::{ElementId, Mesh, NodeId};

mod flow;

const TIMES: [f64; 2] = [2e-3, 7e-3];

fn state() -> EquationOfState {
    EquationOfState::new(40.0, 0.0, f64::INFINITY)
}

/// Linear and power-law branches beside a network that may be damaged.
fn gel() -> TwoNetwork {
    let power = Branch::new(4.0, Dashpot::power_law(0.05, 0.8));
    let linear = [(2.0, TIMES[0]), (5.0, TIMES[1])].map(|(mu, time)| Branch::new(mu, Dashpot::linear(time)));
    TwoNetwork::new(3.0, &[linear[0], power, linear[1]], state(), 1e-6).with_damage(StretchDamage::new(1.05, 1e-2))
}

/// Linear branches alone, beside a sound network.
fn linear() -> TwoNetwork {
    let branches = [(2.0, TIMES[0]), (5.0, TIMES[1])].map(|(mu, time)| Branch::new(mu, Dashpot::linear(time)));
    TwoNetwork::new(3.0, &branches, state(), 1e-6)
}

fn simplex<const D: usize>(section: Section, gel: TwoNetwork) -> (Vec<Vector<D>>, Simplices<D>) {
    let corners = [[0.8, 0.1, 0.0], [1.9, 0.3, 0.1], [1.1, 1.2, -0.1], [1.0, 0.4, 1.1]];
    let rest: Vec<_> = corners[..=D].iter().map(|x| Vector::<D>::from_fn(|i, _| x[i])).collect();
    let nodes = if D == 2 { [0, 1, 2, 0] } else { [0, 1, 2, 3] };
    let mesh = Mesh::new(rest.clone(), vec![nodes.map(NodeId)]);
    let material = crate::constitutive::Material::TwoNetwork(gel);
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
    let kick = GroupKick { length: step, elapsed: step };
    let spent = simplices.advance(0, x, kick, memory, &mut answers);
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

/// Spins the element about an axis while it deforms with relaxation, damage and bulk viscosity.
fn check_objectivity<const D: usize>(rest: &[Vector<D>], simplices: &Simplices<D>, turn: impl Fn(f64) -> Tensor<D>) {
    let (mut still, mut spun) = (fresh(simplices), fresh(simplices));
    for (k, part) in [0.0, -0.5, 0.3, 1.0, 0.8].into_iter().enumerate() {
        let (x, q) = (moved(rest, 0.3 * part), turn(0.9 * k as f64));
        let turned: Vec<_> = x.iter().map(|x| q * x).collect();
        let (lost, own) = advance(simplices, &x, (1.5e-3, &mut still));
        let (also_lost, other) = advance(simplices, &turned, (1.5e-3, &mut spun));
        for (f, g) in own.forces.iter().zip(&other.forces) {
            assert!((q * f - g).norm() < 1e-12 * (1.0 + f.norm()), "step {k}: {f} turned is {g}");
        }
        let off = [
            lost.energy - also_lost.energy,
            lost.bulk - also_lost.bulk,
            lost.viscous - also_lost.viscous,
            lost.damage - also_lost.damage,
        ];
        assert!(off.iter().all(|off| off.abs() < 1e-12), "step {k}: {off:?}");
        let energies = [held(simplices, &x, &still).0, held(simplices, &turned, &spun).0];
        assert!((energies[0] - energies[1]).abs() < 1e-12, "step {k}: {energies:?}");
    }
    assert!(still[0].damage > 0.0 && still.iter().any(|record| record.stress > 0.0), "{still:?}");
    for (own, other) in still.iter().zip(&spun) {
        assert!((own.inverse - other.inverse).norm() < 1e-12 && (own.damage - other.damage).abs() < 1e-12);
    }
}

#[test]
fn the_law_is_objective_under_a_superposed_rotation() {
    let shocked = gel().with_viscosity(BulkViscosity { linear: 0.3, quadratic: 1.5 });
    let (rest, simplices) = simplex::<2>(Section::Planar { thickness: 0.7 }, shocked);
    check_objectivity(&rest, &simplices, |angle| *nalgebra::Rotation2::new(angle).matrix());
    let (rest, simplices) = simplex::<3>(Section::Spatial, shocked);
    let axis = crate::math::Vector3::new(0.7, -1.1, 0.4);
    check_objectivity(&rest, &simplices, |angle| *nalgebra::Rotation3::new(axis * angle).matrix());
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
fn of_branches<const D: usize>(answer: &ElementResponse<D>, rest: &ElementResponse<D>) -> impl Iterator<Item = f64> {
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
    let branch = Branch::new(5.0, Dashpot::linear(TIMES[0]));
    everywhere!(check_relaxation, TwoNetwork::new(3.0, &[branch], state(), 1e-6));
}

fn check_losses<const D: usize>(rest: &[Vector<D>], simplices: &Simplices<D>) {
    let mut memory = fresh(simplices);
    let x = moved(rest, 0.4);
    let stored = advance(simplices, &x, (0.0, &mut memory)).0.energy;
    let lost: f64 = (0..50)
        .map(|_| {
            let spent = advance(simplices, &x, (1e-3, &mut memory)).0;
            assert!(spent.viscous >= 0.0 && spent.damage >= 0.0);
            spent.viscous + spent.damage
        })
        .sum();
    assert_eq!(memory[0].damage > 0.0, simplices.material == gel().into());
    let left = held(simplices, &x, &memory).0;
    assert!(lost > 0.1 * stored && (stored - left - lost).abs() < 1e-12 * stored);
    let shapes = memory[1..].iter().map(|own| det(&own.inverse) * own.out);
    shapes.for_each(|volume| assert!((volume - 1.0).abs() < 1e-13));
}

#[test]
fn dissipation_at_constant_strain_is_the_loss_of_stored_energy() {
    everywhere!(check_losses, gel());
    everywhere!(check_losses, linear());
}

#[test]
fn dissipation_of_the_branches_is_the_work_that_is_not_stored() {
    let (rest, simplices) = simplex::<3>(Section::Spatial, linear());
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
fn a_small_strain_ramp_of_linear_branches_is_exact() {
    let (rest, simplices) = simplex::<3>(Section::Spatial, linear());
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
    for (own, before) in memory.iter().zip(&before) {
        assert_eq!((own.inverse, own.out, own.damage), (before.inverse, before.out, before.damage));
    }
    assert!(memory.iter().all(HistoryVariables::is_valid));
}

fn check_damage<const D: usize>(rest: &[Vector<D>], simplices: &Simplices<D>) {
    let mut memory = fresh(simplices);
    let x = moved(rest, 0.5);
    let before = advance(simplices, &x, (0.0, &mut memory)).0.energy;
    let spent = advance(simplices, &x, (2e-3, &mut memory)).0;
    let (f, out) = simplices.deformation_gradient(ElementId(0), &x);
    let jacobian = det(&f) * out;
    let b = f * f.transpose() * jacobian.powf(-2.0 / 3.0);
    let most = crate::math::spectral(&b).0.max().max(if D == 2 { out * out * jacobian.powf(-2.0 / 3.0) } else { 0.0 });
    let wanted = 2e-3 / 1e-2 * (most.sqrt() / 1.05 - 1.0);
    assert!((memory[0].damage - wanted).abs() < 1e-12 && wanted > 0.02 && wanted < 1.0, "{}", memory[0].damage);
    assert!((before - spent.energy - spent.damage).abs() < 1e-12 * before && spent.viscous.abs() < 1e-12 * before);
    advance(simplices, &x, (10.0, &mut memory));
    assert_eq!(memory[0].damage, 1.0);
    let (energy, answer) = held(simplices, &x, &memory);
    assert!(energy < before && answer.stiffness > 0.0);
}

#[test]
fn damage_grows_with_the_greatest_stretch_and_releases_what_was_stored() {
    // A branch so slow that it does not flow keeps its energy.
    let still = Branch::new(2.0, Dashpot::linear(1e30));
    let gel = TwoNetwork::new(3.0, &[still], state(), 1e-6).with_damage(StretchDamage::new(1.05, 1e-2));
    everywhere!(check_damage, gel);
}

#[test]
fn bulk_viscosity_acts_on_the_rate_of_volume_and_is_held_at_the_same_tick() {
    let gel = linear().with_viscosity(BulkViscosity { linear: 0.3, quadratic: 1.0 });
    let (rest, simplices) = simplex::<3>(Section::Spatial, gel);
    let mut memory = fresh(&simplices);
    let squeezed: Vec<_> = rest.iter().map(|x| x * 0.99).collect();
    let spent = advance(&simplices, &squeezed, (1e-3, &mut memory)).0;
    assert!(spent.bulk > 0.0);
    let again = advance(&simplices, &squeezed, (1e-3, &mut memory)).0;
    assert_eq!(again.bulk, 0.0);
}

#[test]
fn bulk_viscosity_has_the_present_density() {
    let gel = linear().with_viscosity(BulkViscosity { linear: 0.3, quadratic: 0.0 });
    // V₀ q ΔJ with q = ρ₀/J b₁cℓ ΔJ/(J Δt), after ΔJ = kJ: k² b₁ρ₀cℓV₀/Δt, in proportion to the size ℓ.
    let dissipated = |stretch: f64| {
        let (rest, simplices) = simplex::<3>(Section::Spatial, gel);
        let mut memory = fresh(&simplices);
        let at = |factor: f64| rest.iter().map(|x| x * stretch * factor).collect::<Vec<_>>();
        advance(&simplices, &at(1.0), (1.0, &mut memory));
        advance(&simplices, &at(1.0 + 1e-3), (1e-3, &mut memory)).0.bulk
    };
    assert!((dissipated(4.0) / dissipated(1.0) - 4.0).abs() < 1e-9);
}

/// An element whose transfers have left a node a ten-thousandth of its usual mass was damped ten thousand times too much:
/// a torn web of a rifle bullet's cavity exploded.
#[test]
fn the_step_of_a_light_node_is_stable_with_bulk_viscosity() {
    let gel = linear().with_viscosity(BulkViscosity { linear: 1.0, quadratic: 0.0 });
    let (rest, usual) = simplex::<3>(Section::Spatial, gel);
    let share = gel.density() * usual.volume(ElementId(0)) / 4.0;
    let mass = [share, share, share, 1e-4 * share];
    let light = usual.clone().with_masses(&mass, &rest);
    assert!((light.relative_density(ElementId(0)) - 1e-4).abs() < 1e-15);
    assert_eq!(usual.with_masses(&[share; 4], &rest).relative_density(ElementId(0)), 1.0);
    let mut memory = fresh(&light);
    let stiffness = advance(&light, &rest, (1e-9, &mut memory)).1.stiffness;
    let step = 0.8 * 2.0 / (stiffness / mass[3]).sqrt();
    let (mut x, mut v) = (rest, vec![Vector::<3>::zeros(); 4]);
    v[3] = Vector::<3>::new(0.3, -0.2, 1.0) * 1e-6 / step;
    let begun = v[3].norm();
    for _ in 0..200 {
        x.iter_mut().zip(&v).for_each(|(x, v)| *x += v * step);
        let forces = advance(&light, &x, (step, &mut memory)).1.forces;
        v.iter_mut().zip(forces).zip(mass).for_each(|((v, force), mass)| *v += force * (step / mass));
    }
    assert!(v[3].norm() < 2.0 * begun, "{} times", v[3].norm() / begun);
}

#[test]
fn bulk_viscosity_has_no_part_in_a_kick_that_is_taken_back() {
    let viscosity = BulkViscosity { linear: 0.3, quadratic: 1.0 };
    let forces = |gel: TwoNetwork, length: f64| {
        let (rest, simplices) = simplex::<3>(Section::Spatial, gel);
        let squeezed: Vec<_> = rest.iter().map(|x| x * 0.99).collect();
        let mut answers = [ElementResponse::default(); DEPTH];
        simplices.advance(0, &squeezed, GroupKick { length, elapsed: 1e-3 }, &mut fresh(&simplices), &mut answers);
        answers[0].forces
    };
    let (plain, viscous) = (linear(), linear().with_viscosity(viscosity));
    assert_eq!(forces(viscous, -1e-3), forces(plain, -1e-3));
    assert_ne!(forces(viscous, 1e-3), forces(plain, 1e-3));
}
