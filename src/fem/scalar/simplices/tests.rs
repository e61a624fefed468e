//! Forces, energy and stiffness bound of elements against central differences.

use super::*;
use crate::constitutive::{
    Branch, Dashpot, EquationOfState, Hyperelastic, MaterialLayer, MixedModuli, NeoHookean, TwoNetwork,
    VolumetricEnergy,
};
use crate::fem::{DEPTH, ElementResponse, HistoryVariables, Potential};
use crate::math::array;

fn triangle(section: Section) -> (Mesh<2>, Simplices<2>) {
    let rest = [[0.8, 0.1], [1.9, 0.3], [1.1, 1.2]].map(Vector::<2>::from).to_vec();
    let mesh = Mesh::new(rest, vec![[0, 1, 2, 0].map(NodeId)]);
    let simplices = Simplices::new(&mesh, NeoHookean::new(3.0, 40.0), section);
    (mesh, simplices)
}

fn tetrahedron() -> (Mesh<3>, Simplices<3>) {
    let rest = [[0.0, 0.1, 0.0], [1.2, 0.0, 0.1], [0.2, 0.9, -0.1], [0.1, 0.3, 1.1]];
    let rest = rest.map(Vector::<3>::from).to_vec();
    let mesh = Mesh::new(rest, vec![[0, 1, 2, 3].map(NodeId)]);
    let simplices = Simplices::new(&mesh, NeoHookean::new(3.0, 40.0), Section::Spatial);
    (mesh, simplices)
}

fn deformed<const D: usize>(mesh: &Mesh<D>, size: f64) -> Vec<Vector<D>> {
    let wave = |i: usize, a: usize| size * ((7 * a + 3 * i) as f64).sin();
    mesh.rest.iter().enumerate().map(|(a, x)| x + Vector::<D>::from_fn(|i, _| wave(i, a))).collect()
}

fn forces<const D: usize>(simplices: &Simplices<D>, x: &[Vector<D>]) -> (f64, ElementResponse<D>) {
    let mut answers = [ElementResponse::default(); DEPTH];
    let energy = simplices.evaluate(0, x, &[], &mut answers);
    (energy, answers[0])
}

/// Returns the energy with node `a` moved by `s` along axis `i`.
fn moved_energy<const D: usize>(simplices: &Simplices<D>, x: &[Vector<D>], (a, i): (usize, usize), s: f64) -> f64 {
    let mut moved = x.to_vec();
    moved[a][i] += s;
    forces(simplices, &moved).0
}

fn check_forces<const D: usize>(mesh: &Mesh<D>, simplices: &Simplices<D>) {
    let step = 1e-6;
    for size in [0.0, 0.1, 0.3] {
        let x = deformed(mesh, size);
        let f = forces(simplices, &x).1.forces;
        for component in (0..=D).flat_map(|a| (0..D).map(move |i| (a, i))) {
            let energy = |s: f64| moved_energy(simplices, &x, component, s);
            let slope = (energy(step) - energy(-step)) / (2.0 * step);
            let (a, i) = component;
            assert!((slope + f[a][i]).abs() < 1e-7 * (1.0 + f[a].norm()), "node {a}, direction {i}");
        }
    }
}

fn check_stiffness<const D: usize>(mesh: &Mesh<D>, simplices: &Simplices<D>) {
    let step = 1e-6;
    for size in [0.0, 0.05, 0.1, 0.2, 0.3, 0.4] {
        let x = deformed(mesh, size);
        let n = (D + 1) * D;
        let stiffness = nalgebra::DMatrix::from_fn(n, n, |row, column| {
            let probe = |s: f64| {
                let mut moved = x.clone();
                moved[column / D][column % D] += s;
                forces(simplices, &moved).1.forces[row / D][row % D]
            };
            (probe(-step) - probe(step)) / (2.0 * step)
        });
        let greatest = (&stiffness + stiffness.transpose()).symmetric_eigenvalues().max() / 2.0;
        let bound = forces(simplices, &x).1.stiffness;
        assert!(greatest <= bound * (1.0 + 1e-6), "{greatest} above the bound {bound}");
        assert!(greatest > 0.2 * bound, "the bound {bound} is idle against {greatest}");
    }
}

fn check_energy<const D: usize>(mesh: &Mesh<D>, simplices: &Simplices<D>) {
    let (gel, id) = (NeoHookean::new(3.0, 40.0), ElementId(0));
    for size in [0.0, 0.1, 0.3, 1.0] {
        let x = deformed(mesh, size);
        let (energy, answer) = forces(simplices, &x);
        let (f, out) = simplices.deformation_gradient(id, &x);
        let own = gel.sheared(&array::rows(&f), out).energy + gel.volume().volumetric(answer.jacobian).energy;
        let wanted = simplices.volume(id) * own;
        assert!((energy - wanted).abs() < 1e-12 * (1.0 + wanted.abs()), "{energy} for {wanted}");
    }
}

#[test]
fn the_energy_is_that_of_the_law_though_forces_follow_from_edges() {
    for section in [Section::Planar { thickness: 0.7 }, Section::Axisymmetric] {
        let (mesh, simplices) = triangle(section);
        check_energy(&mesh, &simplices);
    }
    let (mesh, simplices) = tetrahedron();
    check_energy(&mesh, &simplices);
}

#[test]
fn forces_are_minus_the_gradient_of_the_energy() {
    for section in [Section::Planar { thickness: 0.7 }, Section::Axisymmetric] {
        let (mesh, simplices) = triangle(section);
        check_forces(&mesh, &simplices);
    }
    let (mesh, simplices) = tetrahedron();
    check_forces(&mesh, &simplices);
}

#[test]
fn the_stiffness_bound_is_an_upper_bound_and_tight() {
    for section in [Section::Planar { thickness: 0.7 }, Section::Axisymmetric] {
        let (mesh, simplices) = triangle(section);
        check_stiffness(&mesh, &simplices);
    }
    let (mesh, simplices) = tetrahedron();
    check_stiffness(&mesh, &simplices);
}

#[test]
fn lumped_masses_add_up_to_the_mass() {
    for section in [Section::Planar { thickness: 0.7 }, Section::Axisymmetric] {
        let (mesh, simplices) = triangle(section);
        let total: f64 = simplices.lumped_masses(&mesh, 1030.0).iter().sum();
        assert!((total / (1030.0 * simplices.volume(ElementId(0))) - 1.0).abs() < 1e-14);
    }
}

/// Two elements of a patch, one of a layer, the other a mixture of it and the gel.
fn layered_patch(material: Material) -> (Mesh<3>, Simplices<3>) {
    let rest = [[0.0, 0.1, 0.0], [1.2, 0.0, 0.1], [0.2, 0.9, -0.1], [0.1, 0.3, 1.1], [1.2, 1.1, 1.0]];
    let nodes = [[0, 1, 2, 3], [1, 4, 2, 3]].map(|nodes| nodes.map(NodeId));
    let mesh = Mesh::new(rest.map(Vector::<3>::from).to_vec(), nodes.to_vec());
    let (bulk, moduli) = match material {
        Material::TwoNetwork(_) => (1.7, MixedModuli::Apart),
        _ => (2.5, MixedModuli::InProportion),
    };
    let layer = MaterialLayer { thickness: 1.0, ratios: MaterialRatios { strength: 2.5, bulk, density: 1.3 } };
    let stack = LayerStack::new(&[layer], moduli);
    let simplices = Simplices::in_patches(&mesh, ElementPatches::grouped(&mesh), (material, Section::Spatial));
    (mesh, simplices.with_layers(&stack, vec![[1.0, 0.0, 0.0, 0.0], [0.4, 0.6, 0.0, 0.0]]))
}

#[test]
fn forces_of_a_layered_patch_are_minus_the_gradient_of_its_energy() {
    let state = EquationOfState::new(40.0, 2.0, f64::INFINITY);
    let networks = TwoNetwork::new(3.0, &[Branch::new(2.0, Dashpot::linear(1.0))], state, 1.0);
    for material in [NeoHookean::new(3.0, 40.0).into(), networks.into()] {
        let (mesh, simplices) = layered_patch(material);
        assert_eq!(simplices.patches().len(), 1);
        let memory = vec![HistoryVariables::default(); 2 * simplices.memories()];
        let evaluate = |x: &[Vector<3>]| {
            let mut answers = [ElementResponse::default(); DEPTH];
            let energy = simplices.evaluate(0, x, &memory, &mut answers);
            let mut forces = vec![Vector::<3>::zeros(); 5];
            for (element, answer) in simplices.patches().of(0).iter().zip(answers) {
                let nodes = simplices.corners(*element).iter().zip(answer.forces);
                nodes.for_each(|(node, force)| forces[node.index()] += force);
            }
            (energy, forces)
        };
        // A uniform dilatation loads a patch of several materials uniformly; unstrained it stays at rest.
        let nearly = |factor: f64| mesh.rest.iter().map(|x| x * factor).collect::<Vec<_>>();
        let greatest = |x: &[Vector<3>]| evaluate(x).1.iter().map(Vector::<3>::norm).fold(0.0, f64::max);
        let [small, smaller] = [1e-6, 1e-7].map(|strain| greatest(&nearly(1.0 + strain)));
        assert!((small / smaller - 10.0).abs() < 0.01, "{small:e} {smaller:e}");
        let (step, x) = (1e-6, deformed(&mesh, 0.1));
        let forces = evaluate(&x).1;
        for (node, axis) in (0..5).flat_map(|node| (0..3).map(move |axis| (node, axis))) {
            let energy = |s: f64| {
                let mut moved = x.clone();
                moved[node][axis] += s;
                evaluate(&moved).0
            };
            let slope = (energy(step) - energy(-step)) / (2.0 * step);
            assert!(
                (slope + forces[node][axis]).abs() < 1e-6 * (1.0 + forces[node].norm()),
                "node {node}, axis {axis}"
            );
        }
    }
}
