//! Remeshing without motion: patch test (validation V1), and round trips.

use super::attempt::generate_mesh;
use super::{history, source_mesh};
use crate::constitutive::NeoHookean;
use crate::fem::{DEPTH, ElementResponse, Potential, ReferenceShape, Section, Simplices};
use crate::math::{Tensor, Tensor3, Vector, cofactor, det};
use crate::mesh::{
    BlockSpec, CellSplit, ElementId, ElementPatches, Mesh, Simplex, block, boundary, shape_quality, uniform,
};
use crate::remesh::{
    self, AcceptanceLimits, BodySymmetry, ConservationDefects, ConservedTotals, DeformedMesh, NodalFields,
    ProposedMesh, test_meshes,
};
use crate::state::MeshInstance;
use std::f64::consts::TAU;

/// Density, kg/m³, shear modulus and bulk modulus, Pa.
const GEL: (f64, f64, f64) = (1000.0, 7e4, 7e5);
/// Quality that a mesh by operations and an immersed mesh must reach if the old one did.
const EDITED_QUALITY: f64 = 0.3;
const IMMERSED_QUALITY: f64 = 0.1;
/// Greatest relative change of area or volume by operations, that of a run: they smooth a bent surface.
const EDITED_CHANGE: f64 = 1e-4;
const PLANAR: Section = Section::Planar { thickness: 1.0 };

/// Target size at a point, m.
type SizeAt<'a, const D: usize> = &'a dyn Fn(&Vector<D>) -> f64;
/// Maker of a mesh of target sizes.
type TestMesher<const D: usize> = fn(&DeformedMesh<'_, D>, Section, SizeAt<'_, D>) -> ProposedMesh<D>;

/// Gel on a mesh, without an engine.
struct TestGel<const D: usize> {
    birth: MeshInstance<D>,
    position: Vec<Vector<D>>,
    velocity: Vec<Vector<D>>,
    section: Section,
}

impl<const D: usize> TestGel<D> {
    /// Unit square or cube of `n` crossed cells along each side, deformed by `map`.
    fn new(n: usize, section: Section, map: impl Fn(&Vector<D>) -> Vector<D>) -> Self {
        let planes = std::array::from_fn(|_| uniform(0.0, 1.0, 1.0 / n as f64));
        let mesh = block(BlockSpec { planes, split: CellSplit::Centred, faces: vec![] });
        let position: Vec<Vector<D>> = mesh.rest.iter().map(map).collect();
        let simplices = simplices(&mesh, section, &[]);
        let mass: Vec<f64> = (0..mesh.elements.len() as u32).map(|e| GEL.0 * simplices.volume(ElementId(e))).collect();
        let corner_mass = remesh::corner_masses(&mesh.rest, &mesh.elements, &mass, symmetry(section));
        let mass = remesh::nodal_masses::<D>(position.len(), &mesh.elements, &corner_mass);
        let velocity = vec![Vector::zeros(); position.len()];
        let birth = MeshInstance {
            tick: 0,
            patches: ElementPatches::alone(mesh.elements.len()),
            mesh,
            position: position.clone(),
            mass,
            corner_mass,
            references: vec![],
            parts: vec![],
            steps: vec![],
        };
        Self { birth, position, velocity, section }
    }

    /// Gives every element an incompatible reference, by which it has this F.
    fn with_own_references(mut self, f: &Tensor<D>) -> Self {
        let inverse = f.try_inverse().expect("an F that can be inverted");
        let out = if self.section == Section::Axisymmetric { f[(0, 0)] } else { 1.0 };
        let reference = |(e, nodes)| {
            let now = ReferenceShape::of(&self.position, nodes);
            (ElementId(e), ReferenceShape { edges: inverse * now.edges, radius: now.radius / out })
        };
        self.birth.references = (0..).zip(&self.birth.mesh.elements).map(reference).collect();
        let simplices = self.simplices();
        let mass: Vec<f64> = (0..simplices.len() as u32).map(|e| GEL.0 * simplices.volume(ElementId(e))).collect();
        // Uniform density: the corner masses are those of the current shape.
        let elements = &self.birth.mesh.elements;
        self.birth.corner_mass = remesh::corner_masses(&self.position, elements, &mass, symmetry(self.section));
        self.birth.mass = remesh::nodal_masses::<D>(self.position.len(), elements, &self.birth.corner_mass);
        self
    }

    fn simplices(&self) -> Simplices<D> {
        simplices(&self.birth.mesh, self.section, &self.birth.references)
    }

    /// Remeshes to other sizes as a run does; returns the gel and the changes by the transfer.
    fn remeshed(&self, size: SizeAt<'_, D>, mesher: TestMesher<D>) -> (Self, ConservationDefects<D>) {
        let moved = DeformedMesh { mesh: &self.birth.mesh, position: &self.position };
        let proposal = mesher(&moved, self.section, size);
        let carried = NodalFields {
            symmetry: symmetry(self.section),
            mass: &self.birth.mass,
            corner_mass: &self.birth.corner_mass,
            velocity: &self.velocity,
            is_level: false,
        };
        let new = remesh::transfer(&moved, &carried, &proposal);
        let (simplices, patches) = (self.simplices(), ElementPatches::alone(proposal.elements.len()));
        let source = source_mesh::SourceMesh::new(&simplices, &self.birth, &[], &self.position);
        let inherited = history::inherited(
            &source,
            &self.position,
            &source_mesh::TargetMesh::by(&proposal, &new, crate::constitutive::ElasticAverage::default()),
            &patches,
        );
        let references = inherited.map(|(references, _)| references);
        let references = references.expect("what elements were at rest");
        let facets = boundary::<D>(&proposal.elements);
        let mesh = Mesh { rest: new.rest, elements: proposal.elements, facets, held: new.held, marks: vec![] };
        let position = proposal.position.clone();
        let (mass, corner_mass) = (new.mass, new.corner_mass);
        let birth = MeshInstance {
            tick: 0,
            mesh,
            position: proposal.position,
            mass,
            corner_mass,
            references,
            patches,
            parts: vec![],
            steps: vec![],
        };
        (Self { birth, position, velocity: new.velocity, section: self.section }, new.defects)
    }

    /// Current volume, m³.
    fn volume(&self) -> f64 {
        let simplices = self.simplices();
        let of = |nodes: &Simplex| simplices.measure(&nodes.map(|node| self.position[node.index()]));
        self.birth.mesh.elements.iter().map(of).sum()
    }

    fn n_elements(&self) -> usize {
        self.birth.mesh.elements.len()
    }

    /// Greatest difference of an element's F, and of its stretch out of the plane, from these.
    fn unevenness(&self, f: &Tensor<D>, out: f64) -> f64 {
        let simplices = self.simplices();
        let of = |e: u32| simplices.deformation_gradient(ElementId(e), &self.position);
        let off = |(own, own_out): (Tensor<D>, f64)| (own - f).amax().max((own_out - out).abs());
        (0..self.n_elements() as u32).map(|e| off(of(e))).fold(0.0, f64::max)
    }

    /// Stored energy, J, and the greatest force on an inner node, N.
    fn stored(&self) -> (f64, f64) {
        let simplices = self.simplices();
        let mut force = vec![Vector::<D>::zeros(); self.position.len()];
        let mut energy = 0.0;
        for patch in 0..simplices.patches().len() {
            let mut answers = [ElementResponse::default(); DEPTH];
            energy += simplices.evaluate(patch, &self.position, &[], &mut answers);
            for (element, answer) in simplices.patches().of(patch).iter().zip(&answers) {
                for (node, f) in simplices.nodes(*element).iter().zip(&answer.forces) {
                    force[node.index()] += f;
                }
            }
        }
        for node in self.birth.mesh.facets.iter().flat_map(|facet| &facet[..D]) {
            force[node.index()] = Vector::zeros();
        }
        (energy, force.iter().map(Vector::norm).fold(0.0, f64::max))
    }

    fn books(&self) -> ConservedTotals<D> {
        ConservedTotals::of(&self.position, &self.birth.mass, &self.velocity)
    }

    /// Kinetic and stored energy, J.
    fn energies(&self) -> [f64; 2] {
        [self.books().kinetic, self.stored().0]
    }

    /// Scales Σ m |v|, N·s, and Σ m |x| |v|, N·m·s.
    fn scales(&self) -> [f64; 2] {
        let all = || self.position.iter().zip(&self.velocity).zip(&self.birth.mass);
        [all().map(|((_, v), m)| m * v.norm()).sum(), all().map(|((x, v), m)| m * x.norm() * v.norm()).sum()]
    }
}

fn simplices<const D: usize>(
    mesh: &Mesh<D>,
    section: Section,
    references: &[(ElementId, ReferenceShape<D>)],
) -> Simplices<D> {
    Simplices::new(mesh, NeoHookean::new(GEL.1, GEL.2), section).with_references(references)
}

/// Least quality of an element.
fn worst<const D: usize>(x: &[Vector<D>], elements: &[Simplex]) -> f64 {
    elements.iter().map(|element| shape_quality(x, element)).fold(f64::INFINITY, f64::min)
}

/// Makes a mesh by operations.
fn edited<const D: usize>(moved: &DeformedMesh<'_, D>, section: Section, size: SizeAt<'_, D>) -> ProposedMesh<D> {
    let proposal = test_meshes::edited(moved, symmetry(section), size);
    let quality = worst(moved.position, &moved.mesh.elements).min(EDITED_QUALITY);
    remesh::check_acceptance(moved, &proposal, &AcceptanceLimits { measure: EDITED_CHANGE, quality }).unwrap();
    proposal
}

/// Makes a mesh by the immersed method.
fn immersed(moved: &DeformedMesh<'_, 2>, _: Section, size: SizeAt<'_, 2>) -> ProposedMesh<2> {
    let sizes: Vec<f64> = moved.position.iter().map(size).collect();
    let (proposal, measure) = generate_mesh(moved, &sizes, 1.0).unwrap();
    let quality = worst(moved.position, &moved.mesh.elements).min(IMMERSED_QUALITY);
    remesh::check_acceptance(moved, &proposal, &AcceptanceLimits { measure, quality }).unwrap();
    proposal
}

fn symmetry(section: Section) -> BodySymmetry {
    match section {
        Section::Planar { .. } => BodySymmetry::Planar,
        Section::Axisymmetric => BodySymmetry::Axisymmetric,
        Section::Spatial => BodySymmetry::Spatial,
    }
}

/// Rotation with stretch and shear; a stretch for a ring.
fn affine<const D: usize>(section: Section) -> (Tensor<D>, f64) {
    if section == Section::Axisymmetric {
        return (Tensor::<D>::from_fn(|i, j| if i == j { [1.15, 0.8][i] } else { 0.0 }), 1.15);
    }
    let all = Tensor3::new(0.9, -0.5, 0.2, 0.6, 1.1, -0.1, -0.3, 0.2, 0.8);
    (Tensor::<D>::from_fn(|i, j| all[(i, j)]), 1.0)
}

/// Errors of a patch test.
struct PatchErrors {
    uneven: f64,
    force: f64,
    own: usize,
    change: f64,
}

/// Remeshes to half the size and from there to three times the size. Returns the unevenness of F, the greatest force
/// on an inner node in units of |P| h^(D−1), the number of incompatible references, and the relative change of volume.
fn patch_test<const D: usize>(
    start: &TestGel<D>,
    h: f64,
    f: &Tensor<D>,
    out: f64,
    mesher: TestMesher<D>,
) -> [PatchErrors; 2] {
    let stress = GEL.1 * (f - cofactor(f) / det(f)).norm();
    let mut at = start.remeshed(&|_| 0.5 * h, mesher);
    let measured = |(gel, defects): &(TestGel<D>, ConservationDefects<D>)| {
        assert!(defects.unchanged < 0.5, "{} of the elements are old ones", defects.unchanged);
        let force = (1..D).fold(gel.stored().1 / stress, |force, _| force / h);
        let change = (gel.volume() / start.volume() - 1.0).abs();
        PatchErrors { uneven: gel.unevenness(f, out), force, own: gel.birth.references.len(), change }
    };
    let fine = measured(&at);
    at = at.0.remeshed(&|_| 3.0 * h, mesher);
    [fine, measured(&at)]
}

fn check_patch<const D: usize>(section: Section, mesher: TestMesher<D>) {
    let (f, out) = affine::<D>(section);
    let n = if D == 2 { 12 } else { 5 };
    let gel = TestGel::new(n, section, |x| f * x);
    for PatchErrors { uneven, force, own, .. } in patch_test(&gel, 1.0 / n as f64, &f, out, mesher) {
        println!("{section:?}: F {uneven:.1e}, forces {force:.1e}, references {own}");
        assert!(uneven < 1e-12 && force < 1e-12, "{uneven:e} {force:e}");
        assert_eq!(own, 0, "the nodes say what the elements were");
    }
}

#[test]
fn a_uniform_deformation_stays_uniform_on_a_new_mesh() {
    check_patch::<2>(PLANAR, edited);
    check_patch::<2>(Section::Axisymmetric, edited);
    check_patch::<3>(Section::Spatial, edited);
    check_patch::<2>(PLANAR, immersed);
    check_patch::<2>(Section::Axisymmetric, immersed);
}

fn check_own<const D: usize>(section: Section, mesher: TestMesher<D>, is_cut: bool) {
    let (f, out) = affine::<D>(section);
    let n = if D == 2 { 12 } else { 5 };
    // Deformations by the nodes: none; larger than that of the elements, along the same axes; and along others.
    let ring = section == Section::Axisymmetric;
    let other = Tensor::<D>::from_fn(|i, j| if i == j { [0.7, 1.3, 1.1][i] } else { 0.0 });
    for nodal in [Tensor::<D>::identity(), f * f.transpose() * f, other] {
        let out = if ring { f[(0, 0)] } else { out };
        let gel = TestGel::new(n, section, |x| nodal * x).with_own_references(&f);
        assert!(gel.unevenness(&f, out) < 1e-12);
        for PatchErrors { uneven, force, own, change } in patch_test(&gel, 1.0 / n as f64, &f, out, mesher) {
            println!("{section:?}: F {uneven:.1e}, forces {force:.1e}, references {own}");
            // Rest volume is kept: where cutting takes the tip of a sharp corner, the rest of the gel is stretched
            // less.
            let bound = if is_cut { 1e-12 + change } else { 1e-12 };
            assert!(uneven < bound && own > 0, "{uneven:e}, with the nodal deformation {nodal}");
        }
    }
}

#[test]
fn a_uniform_incompatible_deformation_stays_uniform_on_a_new_mesh() {
    check_own::<2>(PLANAR, edited, false);
    check_own::<2>(Section::Axisymmetric, edited, false);
    check_own::<3>(Section::Spatial, edited, false);
    check_own::<2>(PLANAR, immersed, true);
    check_own::<2>(Section::Axisymmetric, immersed, true);
}

/// Remeshings of a round trip.
const TRIPS: usize = 10;

/// Rotated, stretched and bent position, with waves of this length.
fn bent<const D: usize>(x: &Vector<D>, wavelength: f64) -> Vector<D> {
    let wave = |s: f64| 0.15 * wavelength / TAU * (TAU * s / wavelength).sin();
    let next = |axis: usize| x[(axis + 1) % D];
    let bow = 0.15 * x[0] * x[0];
    let y = Vector::<D>::from_fn(|axis, _| [1.2, 0.9, 0.95][axis] * x[axis] + wave(next(axis)) + [0.0, bow, 0.0][axis]);
    let (s, c) = 0.6_f64.sin_cos();
    Vector::<D>::from_fn(|axis, _| match axis {
        0 => c * y[0] - s * y[1],
        1 => s * y[0] + c * y[1],
        _ => y[axis],
    })
}

/// Velocity of waves of this length, drifting and turning.
fn wavy<const D: usize>(x: &Vector<D>, wavelength: f64) -> Vector<D> {
    let wave = |s: f64| (TAU * s / wavelength).sin();
    Vector::<D>::from_fn(|axis, _| 0.3 + wave(x[(axis + 1) % D]) + if axis == 0 { -0.5 * x[1] } else { 0.5 * x[0] })
}

/// Changes by remeshing: mean |Δ| of kinetic and stored energy, their mean drift, and the greatest errors of mass and
/// momenta.
///
/// The drift is that from the second remeshing to the last, between which the mesh is fine at the same positions. The
/// errors are relative and count from the start.
#[derive(Default)]
struct RoundTripChanges {
    change: [f64; 2],
    drift: [f64; 2],
    mass: f64,
    momentum: f64,
    angular: f64,
}

/// Remeshes between a third of the cell size and the cell size, with fine and coarse regions moving back and forth.
fn round_trips<const D: usize>(n: usize, section: Section, mesher: TestMesher<D>) -> RoundTripChanges {
    let h = 1.0 / n as f64;
    let wavelength = 10.0 * h;
    let mut gel = TestGel::<D>::new(n, section, |x| bent(x, wavelength));
    gel.velocity = gel.position.iter().map(|x| wavy(x, wavelength)).collect();
    let (start, scales) = (gel.books(), gel.scales());
    let mut energies = vec![gel.energies()];
    let mut trips = RoundTripChanges::default();
    for trip in 1..=TRIPS {
        let fine = |x: &Vector<D>| 0.5 - 0.5 * (TAU * (0.5 * x[0] + 0.5 * trip as f64)).cos();
        let (next, defects) = gel.remeshed(&|x| h / (1.0 + 2.0 * fine(x)), mesher);
        gel = next;
        let now = gel.books();
        energies.push(gel.energies());
        trips.mass = trips.mass.max((now.mass / start.mass - 1.0).abs());
        trips.momentum = trips.momentum.max((now.momentum - start.momentum).norm() / scales[0]);
        trips.angular = trips.angular.max((now.angular - start.angular).norm() / scales[1]);
        let [kinetic, elastic] = [0, 1].map(|i| energies[trip][i] / energies[trip - 1][i] - 1.0);
        println!(
            "{section:?} {trip}: {} elements, {:.2} old, {} own; kinetic {kinetic:+.2e}, elastic {elastic:+.2e}",
            gel.n_elements(),
            defects.unchanged,
            gel.birth.references.len(),
        );
    }
    let change = |i: usize| energies.windows(2).map(|pair| (pair[1][i] / pair[0][i] - 1.0).abs()).sum::<f64>();
    trips.change = [0, 1].map(|i| change(i) / TRIPS as f64);
    trips.drift = [0, 1].map(|i| (energies[TRIPS][i] / energies[2][i] - 1.0) / (TRIPS - 2) as f64);
    trips
}

/// Measured changes and drifts of kinetic and stored energy.
type MeasuredChanges = [[f64; 2]; 2];

fn check_trips(trips: &RoundTripChanges, measured: &MeasuredChanges) {
    let RoundTripChanges { change, drift, mass, momentum, angular } = *trips;
    println!("changes {change:?}, drifts {drift:?}, mass {mass:.0e}, P {momentum:.0e}, L {angular:.0e}");
    assert!(mass < 1e-12 && momentum < 1e-12 && angular < 1e-12, "{mass:e} {momentum:e} {angular:e}");
    let is_within = |found: [f64; 2], was: [f64; 2]| (0..2).all(|i| found[i].abs() < 1.5 * was[i]);
    assert!(is_within(change, measured[0]) && is_within(drift, measured[1]), "{change:?} {drift:?}");
}

#[test]
fn ten_round_trips_conserve_mass_and_momenta_and_lose_the_measured_energy() {
    let plane = round_trips::<2>(20, PLANAR, edited);
    let immersed = round_trips::<2>(20, PLANAR, immersed);
    let space = round_trips::<3>(6, Section::Spatial, edited);
    check_trips(&plane, &PLANE);
    check_trips(&immersed, &IMMERSED);
    check_trips(&space, &SPACE);
}

/// Measured figures: of operations in the plane, of the immersed method, and of operations in space. A finer mesh has
/// less kinetic energy of the same waves: most of the change, and reversible. The irreversible part is the loss of
/// stored energy by averaging, 0.057, 0.039 and 0.16 % each time.
const PLANE: MeasuredChanges = [[5.308e-3, 1.102e-3], [1.240e-5, 5.740e-4]];
const IMMERSED: MeasuredChanges = [[1.107e-2, 1.367e-3], [2.283e-5, 3.896e-4]];
const SPACE: MeasuredChanges = [[1.051e-3, 1.884e-3], [1.997e-5, 1.587e-3]];
