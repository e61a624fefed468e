use super::simplex::{Element, Strain};
use super::viscoplastic::recalled;
use super::{Answer, DEPTH, Lanes, MAX_NODES, Measured, Memory, Potential, Spent, inversion_time, places};
use crate::constitutive::{Hyperelastic, Material, NeoHookean, Sheared, Volume, Volumetric};
use crate::math::{Tensor, Vector, cofactor, det};
use crate::mesh::{ElementId, Mesh, NodeId, Patches, Simplex, edges};

/// What the gel's plane or space stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Section {
    /// Plane strain in (x, z), for a thickness, m.
    Planar {
        /// Thickness, m.
        thickness: f64,
    },
    /// A body of revolution, (r, z), for the full revolution.
    Axisymmetric,
    /// Three dimensions.
    Spatial,
}

/// Constant-strain triangles or tetrahedra of a hyperelastic gel (numerics A1, A2, 1.3e).
///
/// F = Σ x_a ⊗ ∇N_a; of an element that has a [`Reference`] of its own, which is never at rest where its nodes are, 1 below is what F
/// is there. The stretch out of the plane is λ = 1 in `planar` and r̄/R̄ (mean radii of the three nodes) in
/// `axisymmetric`; J = λ det F. Forces f_a = −w P ∇N_a with the rest volume w (2πR̄A for a ring), in `axisymmetric` with
/// −w P_θθ/(3R̄) added along r. Strains come from displacements, so that a gel at rest has no force at all, not one of
/// rounding: F = 1 + Σ (x_a − X_a) ⊗ ∇N_a.
///
/// The elements of a patch share their volume change (numerics 5): V_P = Σ w [ψ_s(F) − m ln J] + W Λ/2 (ln J̄)², neo-Hookean
/// ψ_s = μ/2 (|F|² − 3), m = μ, Λ = λ,
/// with W = Σ w and J̄ = Σ w J/W. An element that is a patch by itself is the plain one, J̄ = J.
///
/// Stiffness bound (rigorous, 1.3e and A2):
/// κ = w {[a + |U′| s] Σ_a |∇N_a|² + b Σ_a |F∇N_a|² + max(U″, 0) Σ_a |b_a|²}, where δ²ψ_s ≤ a |δF|² + b (F:δF)² (neo-Hookean: a = μ,
/// b = 0), and |2 det δF| and its kin are bounded by s |δF|²:
/// s = 1 in the plane, √2 |F| ≥ s₁ + s₂ in space, the sum of the two largest of s₁, s₂, |λ| for a ring; b_a = ∂J/∂x_a.
/// For a ring |∇N_a|² is extended by 1/(9R̄²), F∇N_a by λ/(3R̄) along r. In a patch U′ and U″ are the sums of the element's own and the patch's:
/// the patch's volume change is a mean, and the square of a mean is at most the mean of the squares.
///
/// This is the reference: one element after the other, its gradients found anew. [`Lanes`] is the fast form.
#[derive(Debug, Clone)]
pub struct Simplices<const D: usize> {
    pub(crate) material: Material,
    pub(super) section: Section,
    elements: Vec<Simplex>,
    rest: Vec<Vector<D>>,
    /// Which of the references is that of an element that is not what its nodes say; empty if there are none.
    own: Vec<Option<u32>>,
    references: Vec<Reference<D>>,
    patches: Patches,
    /// The elements at rest, of a gel that remembers; else none.
    pub(super) kept: Vec<Element<D>>,
}

/// An element at rest, if its nodes do not say it: where a new mesh takes the place of a worn one, nodes that were told where
/// their matter was need not enclose the matter between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reference<const D: usize> {
    /// Edges from the first node at rest, as columns, m.
    pub edges: Tensor<D>,
    /// R̄ of a ring, m.
    pub radius: f64,
}

impl<const D: usize> Simplices<D> {
    /// The elements of a mesh, each by itself.
    #[must_use]
    pub fn new(mesh: &Mesh<D>, material: impl Into<Material>, section: Section) -> Self {
        Self::in_patches(mesh, Patches::alone(mesh.elements.len()), (material.into(), section))
    }

    /// The elements of a mesh, those of a patch with one volume change.
    ///
    /// # Panics
    /// If a patch has more than [`places`].
    #[must_use]
    pub fn in_patches(mesh: &Mesh<D>, patches: Patches, (material, section): (impl Into<Material>, Section)) -> Self {
        assert!(patches.largest() <= places(D), "a patch has at most {} elements", places(D));
        let (elements, rest) = (mesh.elements.clone(), mesh.rest.clone());
        let (own, references) = (vec![], vec![]);
        Self { material: material.into(), section, elements, rest, own, references, patches, kept: vec![] }.prepared()
    }

    /// The same where some elements are at rest what these say, not what their nodes do.
    ///
    /// # Panics
    /// If there is no such element or one is turned inside out.
    #[must_use]
    pub fn with_references(mut self, references: &[(ElementId, Reference<D>)]) -> Self {
        if !references.is_empty() {
            (self.own, self.references) = (vec![None; self.elements.len()], vec![]);
        }
        for (place, (element, reference)) in (0..).zip(references) {
            let outside = self.section != Section::Axisymmetric || reference.radius > 0.0;
            assert!(det(&reference.edges) > 0.0 && outside, "an element is upright at rest, and beside its axis");
            self.own[element.index()] = Some(place);
            self.references.push(*reference);
        }
        self.prepared()
    }

    /// With what its elements are at rest at hand, if they are asked for it at every update.
    fn prepared(self) -> Self {
        let n = if self.remembers() { self.elements.len() as u32 } else { 0 };
        let kept = (0..n).map(|e| self.made(ElementId(e))).collect();
        Self { kept, ..self }
    }

    /// What the plane or space stands for.
    #[must_use]
    pub fn section(&self) -> Section {
        self.section
    }

    /// What an element is at rest.
    #[must_use]
    pub fn reference(&self, element: ElementId) -> Reference<D> {
        let own = self.own_reference(element).copied();
        own.unwrap_or_else(|| Reference::of(&self.rest, &self.elements[element.index()]))
    }

    /// That of an element which is not what its nodes say.
    fn own_reference(&self, element: ElementId) -> Option<&Reference<D>> {
        let place = self.own.get(element.index()).copied().flatten()?;
        Some(&self.references[place as usize])
    }

    /// [`Potential::measure`] of an element at rest.
    #[must_use]
    pub fn rest_measure(&self, element: ElementId) -> f64 {
        self.measured(&self.reference(element))
    }

    fn measured(&self, at: &Reference<D>) -> f64 {
        det(&at.edges) * if self.measures_rings() { at.radius } else { 1.0 }
    }

    /// Whether the nodes of an element say what it is at rest.
    #[must_use]
    pub fn is_compatible(&self, element: ElementId) -> bool {
        self.own.get(element.index()).is_none_or(Option::is_none)
    }

    /// F of an element and λ, the stretch out of the plane, with its nodes there.
    #[must_use]
    pub fn deformation(&self, element: ElementId, x: &[Vector<D>]) -> (Tensor<D>, f64) {
        let strain = self.strain((element, &self.element(element)), x);
        (strain.f, strain.out)
    }

    /// Lumped nodal masses for the rest density, kg: ρ w/(D + 1), and 2πρA (R_a + 3R̄)/12 for a ring (A1).
    #[must_use]
    pub fn lumped_masses(&self, mesh: &Mesh<D>, density: f64) -> Vec<f64> {
        let mut mass = vec![0.0; mesh.rest.len()];
        for id in (0..self.elements.len() as u32).map(ElementId) {
            let element = self.element(id);
            for node in self.nodes(id) {
                let share = match self.section {
                    Section::Planar { .. } | Section::Spatial => 1.0 / (D + 1) as f64,
                    Section::Axisymmetric => (3.0 * mesh.rest[node.index()][0] * element.hoop + 3.0) / 12.0,
                };
                mass[node.index()] += density * element.volume * share;
            }
        }
        mass
    }

    /// The nodes of the elements.
    #[must_use]
    pub fn elements(&self) -> &[Simplex] {
        &self.elements
    }

    /// Rest volume, m³.
    #[must_use]
    pub fn volume(&self, element: ElementId) -> f64 {
        self.element(element).volume
    }

    pub(super) fn element(&self, id: ElementId) -> Element<D> {
        self.kept.get(id.index()).copied().unwrap_or_else(|| self.made(id))
    }

    /// An element at rest, from its reference.
    fn made(&self, id: ElementId) -> Element<D> {
        let nodes = &self.elements[id.index()];
        let element = Element::new(&self.reference(id), self.section);
        if self.is_compatible(id) {
            return element;
        }
        let told = Reference::of(&self.rest, nodes);
        let inverse = Tensor::<D>::from_fn(|i, j| element.gradients[i + 1][j]);
        Element { base: (told.edges * inverse, told.radius * 3.0 * element.hoop), ..element }
    }

    pub(super) fn strain(&self, placed: (ElementId, &Element<D>), x: &[Vector<D>]) -> Strain<D> {
        self.strain_where(placed, |node| x[node.index()])
    }

    /// The same, with the nodes where `x` says.
    pub(super) fn strain_where(
        &self,
        (id, element): (ElementId, &Element<D>),
        x: impl Fn(NodeId) -> Vector<D>,
    ) -> Strain<D> {
        let moved = |node: &NodeId| x(*node) - self.rest[node.index()];
        let nodes = self.nodes(id);
        let first = moved(&nodes[0]);
        let (mut f, mut radii) = (Tensor::<D>::zeros(), first[0]);
        for (node, gradient) in nodes[1..].iter().zip(&element.gradients[1..]) {
            let u = moved(node);
            f += (u - first) * gradient.transpose();
            radii += u[0];
        }
        f += element.base.0;
        let out = if self.section == Section::Axisymmetric { element.base.1 + radii * element.hoop } else { 1.0 };
        Strain { f, cofactor: cofactor(&f), out, inner: det(&f) }
    }

    fn stiffness(&self, [even, along]: [f64; 2], (element, strain): (&Element<D>, &Strain<D>), u: Volumetric) -> f64 {
        let s = match self.section {
            Section::Planar { .. } => 1.0,
            Section::Spatial => (2.0 * strain.f.norm_squared()).sqrt(),
            Section::Axisymmetric => two_largest(strain),
        };
        let volumetric: f64 = element.gradients[..=D]
            .iter()
            .map(|gradient| {
                let mut b = strain.cofactor * gradient * strain.out;
                b[0] += strain.inner * element.hoop;
                b.norm_squared()
            })
            .sum();
        let mut stretched = 0.0;
        if along > 0.0 {
            for gradient in &element.gradients[..=D] {
                let mut pull = strain.f * gradient;
                pull[0] += strain.out * element.hoop;
                stretched += along * pull.norm_squared();
            }
        }
        element.volume * ((even + u.slope.abs() * s) * element.spread + stretched + u.curvature * volumetric)
    }

    fn answer(&self, s: &Sheared<D>, (element, strain): (&Element<D>, &Strain<D>), u: Volumetric) -> Answer<D> {
        let p = s.stress + strain.cofactor * (u.slope * strain.out);
        let forces = element.forces(&p, s.out + u.slope * strain.inner);
        Answer { forces, stiffness: self.stiffness(s.curvature, (element, strain), u), jacobian: strain.jacobian() }
    }

    /// Energy of a patch of an elastic gel, and what its elements answer.
    pub(super) fn stretch(
        &self,
        gel: &impl Hyperelastic,
        ids: &[ElementId],
        x: &[Vector<D>],
        answers: &mut [Answer<D>; DEPTH],
    ) -> f64 {
        let volume = gel.volume();
        let strained = |id: &ElementId| {
            let element = self.element(*id);
            let strain = self.strain((*id, &element), x);
            (element, strain)
        };
        if let [id] = ids {
            let (element, strain) = strained(id);
            let (u, sheared) = (volume.volumetric(strain.jacobian()), gel.sheared(&strain.f, strain.out));
            let safe = Volumetric { curvature: u.curvature.max(0.0), ..u };
            answers[0] = self.answer(&sheared, (&element, &strain), safe);
            return element.volume * (sheared.energy + u.energy);
        }
        let sums = ids.iter().map(strained).fold((0.0, 0.0), |(whole, now), (element, strain)| {
            (whole + element.volume, now + element.volume * strain.jacobian())
        });
        let shared = volume.shared(sums.1 / sums.0);
        let mut energy = sums.0 * shared.energy;
        for (id, answer) in ids.iter().zip(answers) {
            let (element, strain) = strained(id);
            let (own, sheared) = (volume.own(strain.jacobian()), gel.sheared(&strain.f, strain.out));
            let curvature = own.curvature.max(0.0) + shared.curvature.max(0.0);
            let both = Volumetric { energy: 0.0, slope: own.slope + shared.slope, curvature };
            *answer = self.answer(&sheared, (&element, &strain), both);
            energy += element.volume * (sheared.energy + own.energy);
        }
        energy
    }
}

/// Sum of the two largest of the singular values s₁ ≥ s₂ of the plane part and |λ|.
fn two_largest<const D: usize>(strain: &Strain<D>) -> f64 {
    let (square, area) = (strain.f.norm_squared(), 2.0 * strain.inner.abs());
    let (sum, difference) = ((square + area).sqrt(), (square - area).max(0.0).sqrt());
    sum.max(0.5 * (sum + difference) + strain.out.abs())
}

impl<const D: usize> Reference<D> {
    /// What the nodes of an element say.
    #[must_use]
    pub fn of(rest: &[Vector<D>], nodes: &Simplex) -> Self {
        let radius = nodes[..=D].iter().map(|n| rest[n.index()][0]).sum::<f64>() / (D + 1) as f64;
        Self { edges: edges(rest, nodes), radius }
    }
}

impl<const D: usize> Potential<D> for Simplices<D> {
    fn len(&self) -> usize {
        self.elements.len()
    }

    fn nodes(&self, element: ElementId) -> &[NodeId] {
        &self.elements[element.index()][..=D]
    }

    fn patches(&self) -> &Patches {
        &self.patches
    }

    fn evaluate(&self, patch: usize, x: &[Vector<D>], memory: &[Memory<D>], answers: &mut [Answer<D>; DEPTH]) -> f64 {
        let ids = self.patches.of(patch);
        match &self.material {
            Material::NeoHookean(gel) => self.stretch(gel, ids, x, answers),
            Material::MooneyRivlin(gel) => self.stretch(gel, ids, x, answers),
            Material::Ogden(gel) => self.stretch(gel, ids, x, answers),
            Material::Flowing(_) => self.again(patch, x, (memory, &[0.0; DEPTH]), answers),
            Material::Viscoelastic(gel) => self.at_hold(gel, (ids, x), memory, answers),
        }
    }

    fn advance(
        &self,
        patch: usize,
        x: &[Vector<D>],
        (step, memory): (f64, &mut [Memory<D>]),
        answers: &mut [Answer<D>; DEPTH],
    ) -> Spent {
        let ids = self.patches.of(patch);
        match &self.material {
            Material::NeoHookean(_) | Material::MooneyRivlin(_) | Material::Ogden(_) => {
                Spent { energy: self.evaluate(patch, x, memory, answers), ..Spent::default() }
            }
            Material::Flowing(gel) => {
                let mut own = recalled(memory, ids);
                let spent = self.flow((gel, ids), x, (step, &mut own, &[0.0; DEPTH]), answers);
                ids.iter().zip(own).for_each(|(id, own)| memory[id.index()] = own);
                spent
            }
            Material::Viscoelastic(gel) => self.relaxed(gel, (ids, x), (step, memory), answers),
        }
    }

    fn again(
        &self,
        patch: usize,
        x: &[Vector<D>],
        (memory, viscous): (&[Memory<D>], &[f64; DEPTH]),
        answers: &mut [Answer<D>; DEPTH],
    ) -> f64 {
        let Material::Flowing(gel) = &self.material else { return self.evaluate(patch, x, memory, answers) };
        let ids = self.patches.of(patch);
        self.flow((gel, ids), x, (0.0, &mut recalled(memory, ids), viscous), answers).energy
    }

    fn memories(&self) -> usize {
        match &self.material {
            Material::NeoHookean(_) | Material::MooneyRivlin(_) | Material::Ogden(_) => 0,
            Material::Flowing(_) => 1,
            Material::Viscoelastic(gel) => 1 + gel.branches().len(),
        }
    }

    fn is_crushed(&self, jacobian: f64) -> bool {
        jacobian < NeoHookean::FLOOR
    }

    fn closing(&self, element: ElementId, jacobian: f64, now: (&[Vector<D>], &[Vector<D>])) -> f64 {
        inversion_time::of_one(jacobian, (&self.elements[element.index()], self.section), now)
    }

    fn measure(&self, corners: &[Vector<D>; MAX_NODES]) -> f64 {
        self.measured(&Reference::of(corners, &[0, 1, 2, 3].map(NodeId)))
    }

    fn measures_rings(&self) -> bool {
        self.remembers() && self.section == Section::Axisymmetric
    }

    fn rest(&self) -> &[Vector<D>] {
        &self.rest
    }

    fn lanes(&self, slots: &[Option<ElementId>], depth: usize, local: &[[u16; MAX_NODES]]) -> Option<Lanes<D>> {
        self.in_lanes(slots, depth, local)
    }

    fn measure_all(&self, x: &[Vector<D>], memory: &[Memory<D>]) -> Measured {
        self.measured_at(x, memory)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(section: Section) -> (Mesh<2>, Simplices<2>) {
        let rest = [[0.8, 0.1], [1.9, 0.3], [1.1, 1.2]].map(Vector::<2>::from).to_vec();
        let mesh = Mesh::new(rest, vec![[0, 1, 2, 0].map(NodeId)]);
        let simplices = Simplices::new(&mesh, NeoHookean::new(3.0, 40.0), section);
        (mesh, simplices)
    }

    fn tetrahedron() -> (Mesh<3>, Simplices<3>) {
        let rest =
            [[0.0, 0.1, 0.0], [1.2, 0.0, 0.1], [0.2, 0.9, -0.1], [0.1, 0.3, 1.1]].map(Vector::<3>::from).to_vec();
        let mesh = Mesh::new(rest, vec![[0, 1, 2, 3].map(NodeId)]);
        let simplices = Simplices::new(&mesh, NeoHookean::new(3.0, 40.0), Section::Spatial);
        (mesh, simplices)
    }

    fn deformed<const D: usize>(mesh: &Mesh<D>, size: f64) -> Vec<Vector<D>> {
        let wave = |i: usize, a: usize| size * ((7 * a + 3 * i) as f64).sin();
        mesh.rest.iter().enumerate().map(|(a, x)| x + Vector::<D>::from_fn(|i, _| wave(i, a))).collect()
    }

    fn forces<const D: usize>(simplices: &Simplices<D>, x: &[Vector<D>]) -> (f64, Answer<D>) {
        let mut answers = [Answer::default(); DEPTH];
        let energy = simplices.evaluate(0, x, &[], &mut answers);
        (energy, answers[0])
    }

    /// Energy with node `a` moved by `s` along axis `i`.
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
    fn the_stiffness_bound_is_an_upper_bound_and_not_idle() {
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
}
