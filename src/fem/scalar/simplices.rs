use super::simplex::{DeformationGradient, ReferenceShape, RestElement, Section};
use super::viscoplastic::patch_history;
use super::{
    DEPTH, Dissipation, ElementBatches, ElementResponse, ElementStates, HistoryVariables, MAX_NODES, Potential,
    inversion_time, max_patch_size,
};
use crate::constitutive::{Hyperelastic, Material, NeoHookean, ShearResponse, VolumetricEnergy, VolumetricResponse};
use crate::math::{Tensor, Vector, cofactor, det};
use crate::mesh::{ElementId, ElementPatches, Mesh, NodeId, Simplex};

/// Constant-strain triangles or tetrahedra of a hyperelastic gel (numerics A1, A2, 1.3e).
///
/// F = Σ x_a ⊗ ∇N_a. The out-of-plane stretch is λ = 1 in `planar` and r̄/R̄ (mean radii of the three nodes) in
/// `axisymmetric`; J = λ det F. The nodal forces are f_a = −w P ∇N_a with the rest volume w (2πR̄A for a ring), in
/// `axisymmetric` with −w P_θθ/(3R̄) added along r. Strains come from displacements, F = 1 + Σ (x_a − X_a) ⊗ ∇N_a, so
/// a gel at rest has zero forces, without rounding. For an incompatible element, with a [`ReferenceShape`] of its own, the
/// 1 is replaced by F at the rest positions of the nodes.
///
/// The elements of an F-bar patch (de Souza Neto et al. 2005) share their volume change (numerics 5):
/// V_P = Σ w [ψ_s(F) − m ln J] + W Λ/2 (ln J̄)², W = Σ w, J̄ = Σ w J/W; neo-Hookean ψ_s = μ/2 (|F|² − 3), m = μ, Λ = λ.
/// A patch of one element is a standard element, J̄ = J.
///
/// Stiffness bound (rigorous, 1.3e and A2):
///
/// κ = w {[a + |U′| s] Σ_a |∇N_a|² + b Σ_a |F∇N_a|² + max(U″, 0) Σ_a |b_a|²}, b_a = ∂J/∂x_a,
///
/// where δ²ψ_s ≤ a |δF|² + b (F:δF)²; neo-Hookean a = μ, b = 0. The factor s bounds the second-order terms of J, as in
/// |2 det δF| ≤ s |δF|²: s = 1 in the plane, √2 |F| ≥ s₁ + s₂ in space, the sum of the two largest of s₁, s₂, |λ| for
/// a ring. For a ring |∇N_a|² is extended by 1/(9R̄²), F∇N_a by λ/(3R̄) along r. In a patch U′ and U″ are the sums of
/// the element part and the patch part: the square of the mean volume change is at most the mean of the squares.
///
/// This is the scalar reference implementation, element by element; [`ElementBatches`] is the SIMD form.
#[derive(Debug, Clone)]
pub struct Simplices<const D: usize> {
    pub(crate) material: Material,
    pub(super) section: Section,
    elements: Vec<Simplex>,
    rest: Vec<Vector<D>>,
    /// Index into `references` of each incompatible element; empty if all elements are compatible.
    reference_index: Vec<Option<u32>>,
    references: Vec<ReferenceShape<D>>,
    patches: ElementPatches,
    /// Rest geometry of all elements, for a material with history variables; else empty.
    pub(super) rest_elements: Vec<RestElement<D>>,
}

impl<const D: usize> Simplices<D> {
    /// Creates the elements of a mesh, each a patch of its own.
    #[must_use]
    pub fn new(mesh: &Mesh<D>, material: impl Into<Material>, section: Section) -> Self {
        Self::in_patches(mesh, ElementPatches::alone(mesh.elements.len()), (material.into(), section))
    }

    /// Creates the elements of a mesh, grouped in F-bar patches.
    ///
    /// # Panics
    /// If a patch has more than [`max_patch_size`].
    #[must_use]
    pub fn in_patches(
        mesh: &Mesh<D>,
        patches: ElementPatches,
        (material, section): (impl Into<Material>, Section),
    ) -> Self {
        assert!(patches.largest() <= max_patch_size(D), "a patch has at most {} elements", max_patch_size(D));
        let (elements, rest) = (mesh.elements.clone(), mesh.rest.clone());
        let (material, reference_index, references, rest_elements) = (material.into(), vec![], vec![], vec![]);
        Self { material, section, elements, rest, reference_index, references, patches, rest_elements }
            .with_rest_elements()
    }

    /// Returns the elements with the reference shapes of the incompatible elements.
    ///
    /// # Panics
    /// If an element does not exist or a reference shape is inverted.
    #[must_use]
    pub fn with_references(mut self, references: &[(ElementId, ReferenceShape<D>)]) -> Self {
        if !references.is_empty() {
            (self.reference_index, self.references) = (vec![None; self.elements.len()], vec![]);
        }
        for (index, (element, reference)) in (0..).zip(references) {
            let outside = self.section != Section::Axisymmetric || reference.radius > 0.0;
            assert!(det(&reference.edges) > 0.0 && outside, "an element is upright at rest, and beside its axis");
            self.reference_index[element.index()] = Some(index);
            self.references.push(*reference);
        }
        self.with_rest_elements()
    }

    /// Caches the rest geometry for a material with history variables, which needs it at every update.
    fn with_rest_elements(self) -> Self {
        let n = if self.remembers() { self.elements.len() as u32 } else { 0 };
        let rest_elements = (0..n).map(|e| self.rest_element_of(ElementId(e))).collect();
        Self { rest_elements, ..self }
    }

    /// Returns the kinematic model.
    #[must_use]
    pub fn section(&self) -> Section {
        self.section
    }

    /// Returns the reference shape of an element.
    #[must_use]
    pub fn reference(&self, element: ElementId) -> ReferenceShape<D> {
        let stored = self.stored_reference(element).copied();
        stored.unwrap_or_else(|| ReferenceShape::of(&self.rest, &self.elements[element.index()]))
    }

    /// Returns the stored reference shape of an incompatible element.
    fn stored_reference(&self, element: ElementId) -> Option<&ReferenceShape<D>> {
        let index = self.reference_index.get(element.index()).copied().flatten()?;
        Some(&self.references[index as usize])
    }

    /// Returns [`Potential::measure`] of an element at rest.
    #[must_use]
    pub fn rest_measure(&self, element: ElementId) -> f64 {
        self.measure_shape(&self.reference(element))
    }

    /// Returns [`Potential::measure`] of a shape.
    fn measure_shape(&self, shape: &ReferenceShape<D>) -> f64 {
        det(&shape.edges) * if self.measures_rings() { shape.radius } else { 1.0 }
    }

    /// Returns true if the rest positions of the nodes are the rest shape of the element.
    #[must_use]
    pub fn is_compatible(&self, element: ElementId) -> bool {
        self.reference_index.get(element.index()).is_none_or(Option::is_none)
    }

    /// Returns F and the out-of-plane stretch λ of an element at the nodal positions `x`.
    #[must_use]
    pub fn deformation_gradient(&self, element: ElementId, x: &[Vector<D>]) -> (Tensor<D>, f64) {
        let strain = self.element_deformation(element, &self.rest_element(element), x);
        (strain.f, strain.out)
    }

    /// Returns the lumped nodal masses for the rest density, kg/m³, in kg: ρ w/(D + 1), and 2πρA (R_a + 3R̄)/12 for a
    /// ring (A1).
    #[must_use]
    pub fn lumped_masses(&self, mesh: &Mesh<D>, density: f64) -> Vec<f64> {
        let mut mass = vec![0.0; mesh.rest.len()];
        for id in (0..self.elements.len() as u32).map(ElementId) {
            let element = self.rest_element(id);
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

    /// Returns the nodes of all elements.
    #[must_use]
    pub fn elements(&self) -> &[Simplex] {
        &self.elements
    }

    /// Returns the rest volume of an element, m³.
    #[must_use]
    pub fn volume(&self, element: ElementId) -> f64 {
        self.rest_element(element).volume
    }

    /// Returns the rest geometry of an element, cached or computed.
    pub(super) fn rest_element(&self, id: ElementId) -> RestElement<D> {
        self.rest_elements.get(id.index()).copied().unwrap_or_else(|| self.rest_element_of(id))
    }

    /// Computes the rest geometry of an element from its reference shape.
    fn rest_element_of(&self, id: ElementId) -> RestElement<D> {
        let nodes = &self.elements[id.index()];
        let element = RestElement::new(&self.reference(id), self.section);
        if self.is_compatible(id) {
            return element;
        }
        let nodal = ReferenceShape::of(&self.rest, nodes);
        let inverse = Tensor::<D>::from_fn(|i, j| element.gradients[i + 1][j]);
        let (rest_f, rest_stretch) = (nodal.edges * inverse, nodal.radius * 3.0 * element.hoop);
        RestElement { rest_f, rest_stretch, ..element }
    }

    /// Computes the deformation gradient at the nodal positions `x`.
    pub(super) fn element_deformation(
        &self,
        id: ElementId,
        element: &RestElement<D>,
        x: &[Vector<D>],
    ) -> DeformationGradient<D> {
        self.element_deformation_by(id, element, |node| x[node.index()])
    }

    /// Computes the deformation gradient of an element, with a function for the nodal positions.
    pub(super) fn element_deformation_by(
        &self,
        id: ElementId,
        element: &RestElement<D>,
        x: impl Fn(NodeId) -> Vector<D>,
    ) -> DeformationGradient<D> {
        let moved = |node: &NodeId| x(*node) - self.rest[node.index()];
        let nodes = self.nodes(id);
        let first = moved(&nodes[0]);
        let (mut f, mut radii) = (Tensor::<D>::zeros(), first[0]);
        for (node, gradient) in nodes[1..].iter().zip(&element.gradients[1..]) {
            let u = moved(node);
            f += (u - first) * gradient.transpose();
            radii += u[0];
        }
        f += element.rest_f;
        let out = if self.section == Section::Axisymmetric { element.rest_stretch + radii * element.hoop } else { 1.0 };
        DeformationGradient { f, cofactor: cofactor(&f), out, det_f: det(&f) }
    }

    /// Returns the stiffness bound κ, N/m, from the curvature bound `[a, b]` of ψ_s and the volumetric response.
    fn stiffness_bound(
        &self,
        [a, b]: [f64; 2],
        element: &RestElement<D>,
        strain: &DeformationGradient<D>,
        u: VolumetricResponse,
    ) -> f64 {
        let s = match self.section {
            Section::Planar { .. } => 1.0,
            Section::Spatial => (2.0 * strain.f.norm_squared()).sqrt(),
            Section::Axisymmetric => strain.two_largest_stretches(),
        };
        let volumetric: f64 = element.gradients[..=D]
            .iter()
            .map(|gradient| {
                let mut b = strain.cofactor * gradient * strain.out;
                b[0] += strain.det_f * element.hoop;
                b.norm_squared()
            })
            .sum();
        let mut stretched = 0.0;
        if b > 0.0 {
            for gradient in &element.gradients[..=D] {
                let mut pull = strain.f * gradient;
                pull[0] += strain.out * element.hoop;
                stretched += b * pull.norm_squared();
            }
        }
        element.volume * ((a + u.slope.abs() * s) * element.spread + stretched + u.curvature * volumetric)
    }

    /// Returns the forces, stiffness bound and J of an element.
    fn response(
        &self,
        s: &ShearResponse<D>,
        element: &RestElement<D>,
        strain: &DeformationGradient<D>,
        u: VolumetricResponse,
    ) -> ElementResponse<D> {
        let p = s.stress + strain.cofactor * (u.slope * strain.out);
        let forces = element.forces(&p, s.out + u.slope * strain.det_f);
        ElementResponse {
            forces,
            stiffness: self.stiffness_bound(s.curvature, element, strain, u),
            jacobian: strain.jacobian(),
        }
    }

    /// Evaluates a patch of a hyperelastic material: its energy, J, and the responses of its elements.
    pub(super) fn evaluate_hyperelastic(
        &self,
        gel: &impl Hyperelastic,
        ids: &[ElementId],
        x: &[Vector<D>],
        answers: &mut [ElementResponse<D>; DEPTH],
    ) -> f64 {
        let volume = gel.volume();
        let strained = |id: &ElementId| {
            let element = self.rest_element(*id);
            let strain = self.element_deformation(*id, &element, x);
            (element, strain)
        };
        if let [id] = ids {
            let (element, strain) = strained(id);
            let (u, sheared) = (volume.volumetric(strain.jacobian()), gel.sheared(&strain.f, strain.out));
            let convex = VolumetricResponse { curvature: u.curvature.max(0.0), ..u };
            answers[0] = self.response(&sheared, &element, &strain, convex);
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
            let both = VolumetricResponse { energy: 0.0, slope: own.slope + shared.slope, curvature };
            *answer = self.response(&sheared, &element, &strain, both);
            energy += element.volume * (sheared.energy + own.energy);
        }
        energy
    }
}

impl<const D: usize> Potential<D> for Simplices<D> {
    fn len(&self) -> usize {
        self.elements.len()
    }

    fn nodes(&self, element: ElementId) -> &[NodeId] {
        &self.elements[element.index()][..=D]
    }

    fn patches(&self) -> &ElementPatches {
        &self.patches
    }

    fn evaluate(
        &self,
        patch: usize,
        x: &[Vector<D>],
        memory: &[HistoryVariables<D>],
        answers: &mut [ElementResponse<D>; DEPTH],
    ) -> f64 {
        let ids = self.patches.of(patch);
        match &self.material {
            Material::NeoHookean(gel) => self.evaluate_hyperelastic(gel, ids, x, answers),
            Material::MooneyRivlin(gel) => self.evaluate_hyperelastic(gel, ids, x, answers),
            Material::Ogden(gel) => self.evaluate_hyperelastic(gel, ids, x, answers),
            Material::Flowing(_) => self.again(patch, x, (memory, &[0.0; DEPTH]), answers),
            Material::Viscoelastic(gel) => self.evaluate_viscoelastic(gel, ids, x, memory, answers),
        }
    }

    fn advance(
        &self,
        patch: usize,
        x: &[Vector<D>],
        (step, memory): (f64, &mut [HistoryVariables<D>]),
        answers: &mut [ElementResponse<D>; DEPTH],
    ) -> Dissipation {
        let ids = self.patches.of(patch);
        match &self.material {
            Material::NeoHookean(_) | Material::MooneyRivlin(_) | Material::Ogden(_) => {
                Dissipation { energy: self.evaluate(patch, x, memory, answers), ..Dissipation::default() }
            }
            Material::Flowing(gel) => {
                let mut own = patch_history(memory, ids);
                let spent = self.evaluate_viscoplastic((gel, ids), x, (step, &mut own, &[0.0; DEPTH]), answers);
                ids.iter().zip(own).for_each(|(id, own)| memory[id.index()] = own);
                spent
            }
            Material::Viscoelastic(gel) => self.advance_viscoelastic(gel, ids, x, step, memory, answers),
        }
    }

    fn again(
        &self,
        patch: usize,
        x: &[Vector<D>],
        (memory, viscous): (&[HistoryVariables<D>], &[f64; DEPTH]),
        answers: &mut [ElementResponse<D>; DEPTH],
    ) -> f64 {
        let Material::Flowing(gel) = &self.material else { return self.evaluate(patch, x, memory, answers) };
        let ids = self.patches.of(patch);
        self.evaluate_viscoplastic((gel, ids), x, (0.0, &mut patch_history(memory, ids), viscous), answers).energy
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
        inversion_time::closing_rate_of_element(jacobian, &self.elements[element.index()], self.section, now.0, now.1)
    }

    fn measure(&self, corners: &[Vector<D>; MAX_NODES]) -> f64 {
        self.measure_shape(&ReferenceShape::of(corners, &[0, 1, 2, 3].map(NodeId)))
    }

    fn measures_rings(&self) -> bool {
        self.remembers() && self.section == Section::Axisymmetric
    }

    fn rest(&self) -> &[Vector<D>] {
        &self.rest
    }

    fn lanes(
        &self,
        slots: &[Option<ElementId>],
        depth: usize,
        local: &[[u16; MAX_NODES]],
    ) -> Option<ElementBatches<D>> {
        self.build_batches(slots, depth, local)
    }

    fn measure_all(&self, x: &[Vector<D>], memory: &[HistoryVariables<D>]) -> ElementStates {
        self.evaluate_all(x, memory)
    }
}

#[cfg(test)]
mod tests;
