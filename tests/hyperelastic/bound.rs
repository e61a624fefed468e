//! The bound of the stiffness of an element against its exact greatest eigenvalue.

use super::{Numbers, answer, gels, single};
use ballistic_gel::constitutive::Material;
use ballistic_gel::fem::{Section, Simplices};
use ballistic_gel::math::{Tensor, Vector, spectral};
use nalgebra::DMatrix;

/// Elements of each kind and gel.
const ELEMENTS: usize = 400;

/// The greatest eigenvalue of ∂²V/∂x∂x, by central differences of the forces.
fn greatest<const D: usize>(simplices: &Simplices<D>, x: &[Vector<D>], size: f64) -> f64 {
    let (n, step) = ((D + 1) * D, 1e-6 * size);
    let stiffness = DMatrix::from_fn(n, n, |row, column| {
        let probe = |s: f64| {
            let mut moved = x.to_vec();
            moved[column / D][column % D] += s;
            answer(simplices, &moved).1.forces[row / D][row % D]
        };
        (probe(-step) - probe(step)) / (2.0 * step)
    });
    (&stiffness + stiffness.transpose()).symmetric_eigenvalues().max() / 2.0
}

/// An upright element with its least height, a third of them slivers, and where its nodes have gone: stretches of up to e^±1.2 in any
/// direction, in space some turned inside out.
fn random<const D: usize>(numbers: &mut Numbers) -> (Vec<Vector<D>>, Vec<Vector<D>>, f64) {
    let flat = if numbers.next() < 0.33 { numbers.between(0.01, 0.1) } else { 1.0 };
    let first = Vector::<D>::from_fn(|i, _| if i == 0 { numbers.between(0.5, 2.0) } else { 0.0 });
    let mut rest = vec![first];
    for axis in 0..D {
        let mut edge = Vector::<D>::from_fn(|_, _| numbers.between(-0.3, 0.3));
        edge[axis] += 1.0;
        edge[D - 1] *= flat;
        rest.push(first + edge);
    }
    let mut f = Tensor::<D>::identity();
    for _ in 0..2 {
        let any = Tensor::<D>::from_fn(|_, _| numbers.between(-1.0, 1.0));
        let (_, turn) = spectral(&(any + any.transpose()));
        let stretch = Vector::<D>::from_fn(|_, _| numbers.between(-0.6, 0.6).exp());
        f = turn * Tensor::<D>::from_diagonal(&stretch) * turn.transpose() * f;
    }
    if numbers.next() < 0.1 {
        f = -f;
    }
    let moved = rest.iter().map(|x| first + f * (x - first)).collect();
    (rest, moved, flat)
}

fn check<const D: usize>(name: &str, gel: Material, section: Section) {
    let mut numbers = Numbers(7);
    let mut tightness = vec![];
    for _ in 0..ELEMENTS {
        let (rest, x, size) = random::<D>(&mut numbers);
        let simplices = single(&rest, gel, section);
        let (exact, bound) = (greatest(&simplices, &x, size), answer(&simplices, &x).1.stiffness);
        assert!(exact <= bound * (1.0 + 1e-6), "{name}, {section:?}: {exact} above the bound {bound}");
        tightness.push((exact / bound).max(0.0));
    }
    tightness.sort_by(f64::total_cmp);
    let at = |part: usize| tightness[part * (ELEMENTS - 1) / 100];
    println!("{name:24} {section:?}: exact over bound {:.3} / {:.3} / {:.3}", at(0), at(50), at(100));
    assert!(at(50) > 0.2, "the bound is idle: {} in the median", at(50));
}

/// Prints least, median and greatest of what the exact eigenvalue is of the bound.
#[test]
fn the_stiffness_bound_is_never_below_the_greatest_eigenvalue_and_not_idle() {
    for (name, gel) in gels() {
        check::<2>(name, gel, Section::Planar { thickness: 1.0 });
        check::<2>(name, gel, Section::Axisymmetric);
        check::<3>(name, gel, Section::Spatial);
    }
}
