//! Stress and energy against closed forms and against each other.

use super::{answer, gels, mooney_rivlin, neo_hookean, ogden, single};
use ballistic_gel::constitutive::Material;
use ballistic_gel::fem::{Section, Simplices};
use ballistic_gel::math::{Tensor3, Vector};

const CONSTANTS: [f64; 2] = [1.2, 0.4];
const TERMS: [(f64, f64); 3] = [(2.0, 1.3), (0.1, 5.0), (-0.3, -2.0)];

fn corner() -> Vec<Vector<3>> {
    [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vector::<3>::from).to_vec()
}

/// First Piola stress, Pa, of a gel strained by F: the corner element's gradients are the axes, its volume is 1/6.
fn stress(gel: Material, f: &Tensor3) -> Tensor3 {
    let simplices = single(&corner(), gel, Section::Spatial);
    let x: Vec<_> = corner().iter().map(|x| f * x).collect();
    let forces = answer(&simplices, &x).1.forces;
    Tensor3::from_columns(&[1, 2, 3].map(|a: usize| forces[a] * -6.0))
}

/// Stress along the first axis, Pa, where the third is free: the pressure of a volume that is kept is taken out.
fn drawn(gel: Material, stretches: [f64; 3]) -> f64 {
    let p = stress(gel, &Tensor3::from_diagonal(&stretches.into()));
    p[(0, 0)] - p[(2, 2)] * stretches[2] / stretches[0]
}

fn agree(what: &str, found: f64, exact: f64) {
    assert!((found - exact).abs() < 1e-12 * (1.0 + exact.abs()), "{what}: {found}, not {exact}");
}

const STRETCHES: [f64; 6] = [0.4, 0.8, 1.0, 1.3, 2.0, 3.5];

#[test]
fn a_strip_that_is_drawn_out_has_the_stress_of_the_textbooks() {
    for s in STRETCHES {
        let [c1, c2] = CONSTANTS;
        let exact = 2.0 * (s - s.powi(-2)) * (c1 + c2 / s);
        let strip = [s, s.powf(-0.5), s.powf(-0.5)];
        agree("uniaxial, Mooney-Rivlin", drawn(mooney_rivlin(CONSTANTS), strip), exact);
        let exact: f64 = TERMS.iter().map(|(mu, a)| mu * (s.powf(a - 1.0) - s.powf(-0.5 * a - 1.0))).sum();
        agree("uniaxial, Ogden", drawn(ogden(&TERMS), strip), exact);
    }
}

#[test]
fn a_sheet_that_is_drawn_out_alike_has_the_stress_of_the_textbooks() {
    for s in [0.6_f64, 0.9, 1.0, 1.3, 2.0] {
        let [c1, c2] = CONSTANTS;
        let sheet = [s, s, s.powi(-2)];
        let exact = 2.0 * (s - s.powi(-5)) * (c1 + c2 * s * s);
        agree("equibiaxial, Mooney-Rivlin", drawn(mooney_rivlin(CONSTANTS), sheet), exact);
        let exact: f64 = TERMS.iter().map(|(mu, a)| mu * (s.powf(a - 1.0) - s.powf(-2.0 * a - 1.0))).sum();
        agree("equibiaxial, Ogden", drawn(ogden(&TERMS), sheet), exact);
    }
}

#[test]
fn simple_shear_has_the_stress_of_the_textbooks() {
    for shear in [0.0, 0.1, 0.7, 2.0, 4.0] {
        let mut f = Tensor3::identity();
        f[(0, 1)] = shear;
        let cauchy = |gel| stress(gel, &f) * f.transpose();
        let [c1, c2] = CONSTANTS;
        let sigma = cauchy(mooney_rivlin(CONSTANTS));
        agree("shear, Mooney-Rivlin", sigma[(0, 1)], 2.0 * (c1 + c2) * shear);
        agree("normal stress, Mooney-Rivlin", sigma[(0, 0)] - sigma[(1, 1)], 2.0 * (c1 + c2) * shear * shear);
        let s = 0.5 * (shear + (shear * shear + 4.0_f64).sqrt());
        let exact: f64 = TERMS.iter().map(|(mu, a)| mu * (s.powf(*a) - s.powf(-a)) / (s + 1.0 / s)).sum();
        agree("shear, Ogden", cauchy(ogden(&TERMS))[(0, 1)], exact);
    }
}

fn shapes() -> (Vec<Vector<2>>, Vec<Vector<3>>) {
    let flat = [[0.8, 0.1], [1.9, 0.3], [1.1, 1.2]].map(Vector::<2>::from).to_vec();
    let solid = [[0.0, 0.1, 0.0], [1.2, 0.0, 0.1], [0.2, 0.9, -0.1], [0.1, 0.3, 1.1]];
    (flat, solid.map(Vector::<3>::from).to_vec())
}

fn waved<const D: usize>(rest: &[Vector<D>], size: f64) -> Vec<Vector<D>> {
    let wave = |i: usize, a: usize| size * ((7 * a + 3 * i) as f64).sin();
    rest.iter().enumerate().map(|(a, x)| x + Vector::<D>::from_fn(|i, _| wave(i, a))).collect()
}

/// Checks it of elements in the plane, about an axis and in space.
fn everywhere(gel: Material, flat: impl Fn(&[Vector<2>], &Simplices<2>), solid: impl Fn(&[Vector<3>], &Simplices<3>)) {
    let (plane, space) = shapes();
    for section in [Section::Planar { thickness: 0.7 }, Section::Axisymmetric] {
        flat(&plane, &single(&plane, gel, section));
    }
    solid(&space, &single(&space, gel, Section::Spatial));
}

fn check_forces<const D: usize>(rest: &[Vector<D>], simplices: &Simplices<D>) {
    let step = 1e-6;
    // At 1.2 all of them are turned inside out.
    for size in [0.0, 0.1, 0.3, 0.6, 1.2] {
        let x = waved(rest, size);
        let forces = answer(simplices, &x).1.forces;
        for (a, i) in (0..=D).flat_map(|a| (0..D).map(move |i| (a, i))) {
            let energy = |s: f64| {
                let mut moved = x.clone();
                moved[a][i] += s;
                answer(simplices, &moved).0
            };
            let slope = (energy(step) - energy(-step)) / (2.0 * step);
            assert!((slope + forces[a][i]).abs() < 2e-7 * (1.0 + forces[a].norm()), "node {a}, direction {i}, {size}");
        }
    }
}

#[test]
fn forces_are_minus_the_gradient_of_the_energy() {
    for (_, gel) in gels() {
        everywhere(gel, check_forces, check_forces);
    }
}

#[test]
fn a_gel_at_rest_has_no_force_and_no_energy_to_the_bit() {
    fn check<const D: usize>(rest: &[Vector<D>], simplices: &Simplices<D>) {
        let (energy, answer) = answer(simplices, rest);
        assert!(energy == 0.0 && answer.forces.iter().all(|force| *force == Vector::<D>::zeros()), "{energy:e}");
    }
    for (_, gel) in gels() {
        everywhere(gel, check, check);
    }
}

fn compare<const D: usize>(rest: &[Vector<D>], section: Section, gels: &[Material; 2]) {
    for size in [0.05, 0.3, 0.6] {
        let x = waved(rest, size);
        let [(energy, own), (exact, other)] = gels.each_ref().map(|gel| answer(&single(rest, *gel, section), &x));
        assert!((energy / exact - 1.0).abs() < 1e-13, "{energy} of {exact}");
        assert!((own.stiffness / other.stiffness - 1.0).abs() < 1e-13);
        let size = other.forces.iter().map(Vector::<D>::norm).fold(0.0, f64::max);
        assert!((0..=D).all(|a| (own.forces[a] - other.forces[a]).norm() < 1e-13 * size), "{section:?}");
    }
}

#[test]
fn without_a_second_constant_or_with_an_exponent_of_two_they_are_neo_hookean() {
    let (plane, space) = shapes();
    for gel in [mooney_rivlin([1.5, 0.0]), ogden(&[(3.0, 2.0)]), ogden(&[(1.0, 2.0), (2.0, 2.0)])] {
        for section in [Section::Planar { thickness: 0.7 }, Section::Axisymmetric] {
            compare(&plane, section, &[gel, neo_hookean(3.0)]);
        }
        compare(&space, Section::Spatial, &[gel, neo_hookean(3.0)]);
    }
}

#[test]
fn moduli_at_rest_are_those_of_small_strains() {
    for (name, gel) in gels() {
        let (small, bulk) = (1e-6, super::BULK);
        let along = stress(gel, &Tensor3::from_diagonal(&[1.0 + small, 1.0, 1.0].into()))[(0, 0)] / small;
        assert!((along / gel.wave_modulus() - 1.0).abs() < 1e-4, "{name}: {along} of {}", gel.wave_modulus());
        let swollen = stress(gel, &(Tensor3::identity() * (1.0 + small)))[(0, 0)] / (3.0 * small);
        assert!((swollen / bulk - 1.0).abs() < 1e-4, "{name}: {swollen} of {bulk}");
    }
}
