use super::rest_element::{DeformationGradient, RestElement};
use crate::constitutive::{LayerStack, Material, MaterialParts, MaterialRatios};
use crate::fem::law::rest_geometry::volume_of;
use crate::fem::{ReferenceShape, Section, max_patch_size};
use crate::math::{Tensor, Vector, array, det};
use crate::mesh::{ElementId, ElementPatches, Mesh, NodeId, Simplex};

/// Round-off of a relative density.
const ROUND_OFF: f64 = 1e-12;

/// Constant-strain triangles or tetrahedra of a hyperelastic gel (method A1, A2, 1.3e).
///
/// F = Σ x_a ⊗ ∇N_a. The out-of-plane stretch is λ = 1 in `planar` and r̄/R̄ (mean radii of the three nodes) in
/// `axisymmetric`; J = λ det F. The nodal forces are f_a = −w P ∇N_a with the rest volume w (2πR̄A for a ring), in
/// `axisymmetric` with −w P_θθ/(3R̄) added along r. A gel at rest has zero forces, without rounding: an element none of
/// whose nodes has moved has J = 1. Not so an incompatible element, with a [`ReferenceShape`] of its own.
///
/// The elements of an F-bar patch (de Souza Neto et al. 2005) share their volume change (method 5):
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
/// This is the scalar form, element by element; [`crate::fem::ElementBatches`] runs the same kernels in vector lanes.
#[derive(Debug, Clone)]
pub struct Simplices<const D: usize> {
    pub(crate) material: Material,
    pub(crate) section: Section,
    elements: Vec<Simplex>,
    pub(crate) rest: Vec<Vector<D>>,
    /// Index into `references` of each incompatible element; empty if all elements are compatible.
    reference_index: Vec<Option<u32>>,
    references: Vec<ReferenceShape<D>>,
    /// Relative density of each element; empty if all have that of the gel.
    density: Vec<f64>,
    /// Parts of mass of the materials of each element; empty of a gel of one material.
    parts: Vec<MaterialParts>,
    /// Constants of these mixtures.
    ratios: Vec<MaterialRatios>,
    pub(crate) patches: ElementPatches,
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
        let (reference_index, references, density, parts, ratios) = (vec![], vec![], vec![], vec![], vec![]);
        let material = material.into();
        Self { material, section, elements, rest, reference_index, references, density, parts, ratios, patches }
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
        self
    }

    /// Returns the elements of a layered gel with these parts of mass of its materials.
    ///
    /// # Panics
    /// If an element has none.
    #[must_use]
    pub fn with_layers(mut self, stack: &LayerStack, parts: Vec<MaterialParts>) -> Self {
        assert_eq!(parts.len(), self.elements.len(), "each element of a layered gel has materials");
        self.ratios = parts.iter().map(|parts| stack.mixed(parts)).collect();
        self.parts = parts;
        self
    }

    /// Returns true for a layered gel.
    #[must_use]
    pub fn is_layered(&self) -> bool {
        !self.ratios.is_empty()
    }

    /// Returns the parts of mass of the materials of all elements; empty of a gel of one material.
    #[must_use]
    pub fn material_parts(&self) -> &[MaterialParts] {
        &self.parts
    }

    /// Returns the constants of the material of an element, relative to those of the gel.
    #[must_use]
    pub fn ratios(&self, element: ElementId) -> MaterialRatios {
        self.ratios.get(element.index()).copied().unwrap_or(MaterialRatios::GEL)
    }

    /// Returns the elements with the relative densities that these nodal masses, kg, give them, of nodes at `x` when they
    /// were new (method 1.3h): remeshing moves mass and rest volume apart. Only viscosity depends on it.
    #[must_use]
    pub fn with_masses(mut self, mass: &[f64], x: &[Vector<D>]) -> Self {
        let Material::TwoNetwork(gel) = &self.material else { return self };
        let all = || (0..self.elements.len() as u32).map(ElementId);
        let mut usual = vec![0.0; mass.len()];
        for element in all() {
            let density = gel.density() * self.ratios(element).density;
            let (whole, nodes) = (density * self.volume(element), self.corners(element));
            let radii = nodes.iter().map(|node| x[node.index()][0]).sum::<f64>();
            for node in nodes {
                let share = match self.section {
                    Section::Planar { .. } | Section::Spatial => 1.0 / (D + 1) as f64,
                    Section::Axisymmetric => (3.0 * x[node.index()][0] / radii + 3.0) / 12.0,
                };
                usual[node.index()] += whole * share;
            }
        }
        let relative = |node: &NodeId| mass[node.index()] / usual[node.index()];
        let least = |element| self.corners(element).iter().map(relative).fold(1.0, f64::min);
        // Sums of shares differ by round-off.
        let of_lightest = |element: ElementId| {
            let least = least(element);
            self.ratios(element).density * if least > 1.0 - ROUND_OFF { 1.0 } else { least }
        };
        self.density = all().map(of_lightest).collect();
        self
    }

    /// Returns the density of an element relative to that of the gel: that of its lightest node, and at most that of its
    /// material.
    #[must_use]
    pub fn relative_density(&self, element: ElementId) -> f64 {
        self.density.get(element.index()).copied().unwrap_or_else(|| self.ratios(element).density)
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

    /// Returns [`crate::fem::Potential::measure`] of an element at rest.
    #[must_use]
    pub fn rest_measure(&self, element: ElementId) -> f64 {
        self.measure_shape(&self.reference(element))
    }

    /// Returns [`crate::fem::Potential::measure`] of a shape.
    pub(crate) fn measure_shape(&self, shape: &ReferenceShape<D>) -> f64 {
        det(&shape.edges) * if self.has_ring_volumes() { shape.radius } else { 1.0 }
    }

    /// Returns the number of history records of an element.
    pub(crate) fn records(&self) -> usize {
        match &self.material {
            Material::NeoHookean(_) | Material::MooneyRivlin(_) | Material::Ogden(_) => 0,
            Material::TwoNetwork(gel) => gel.records(),
        }
    }

    /// Returns true if the measure of an element is a volume of revolution.
    pub(crate) fn has_ring_volumes(&self) -> bool {
        self.records() > 0 && self.section == Section::Axisymmetric
    }

    /// Returns the nodes of an element.
    pub(crate) fn corners(&self, element: ElementId) -> &[NodeId] {
        &self.elements[element.index()][..=D]
    }

    /// Returns true if the rest positions of the nodes are the rest shape of the element.
    #[must_use]
    pub fn is_compatible(&self, element: ElementId) -> bool {
        self.reference_index.get(element.index()).is_none_or(Option::is_none)
    }

    /// Returns true if the rest positions of the nodes are the rest shapes of most elements: beside eroded gel a few have
    /// their own.
    #[must_use]
    pub fn has_rest_map(&self) -> bool {
        2 * self.references.len() < self.elements.len()
    }

    /// Returns F and the out-of-plane stretch λ of an element at the nodal positions `x`.
    #[must_use]
    pub fn deformation_gradient(&self, element: ElementId, x: &[Vector<D>]) -> (Tensor<D>, f64) {
        let strain = self.element_deformation(element, &self.rest_element(element), x);
        (strain.f, strain.out)
    }

    /// Returns the lumped nodal masses for the rest density of the gel, kg/m³, in kg: ρ w/(D + 1), and 2πρA (R_a + 3R̄)/12 for a
    /// ring (A1).
    #[must_use]
    pub fn lumped_masses(&self, mesh: &Mesh<D>, density: f64) -> Vec<f64> {
        let mut mass = vec![0.0; mesh.rest.len()];
        for id in (0..self.elements.len() as u32).map(ElementId) {
            let element = self.rest_element(id);
            for node in self.corners(id) {
                let share = match self.section {
                    Section::Planar { .. } | Section::Spatial => 1.0 / (D + 1) as f64,
                    Section::Axisymmetric => (3.0 * mesh.rest[node.index()][0] * element.hoop + 3.0) / 12.0,
                };
                mass[node.index()] += density * self.ratios(id).density * element.volume * share;
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
        let reference = self.reference(element);
        volume_of::<D, f64>(array::det(&array::rows(&reference.edges)), reference.radius, self.section)
    }

    /// Computes the rest geometry of an element from its reference shape.
    pub(crate) fn rest_element(&self, id: ElementId) -> RestElement<D> {
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
    pub(crate) fn element_deformation(
        &self,
        id: ElementId,
        element: &RestElement<D>,
        x: &[Vector<D>],
    ) -> DeformationGradient<D> {
        self.element_deformation_by(id, element, |node| x[node.index()])
    }

    /// Computes the deformation gradient of an element, with a function for the nodal positions.
    pub(crate) fn element_deformation_by(
        &self,
        id: ElementId,
        element: &RestElement<D>,
        x: impl Fn(NodeId) -> Vector<D>,
    ) -> DeformationGradient<D> {
        let moved = |node: &NodeId| x(*node) - self.rest[node.index()];
        let nodes = self.corners(id);
        let first = moved(&nodes[0]);
        let (mut f, mut radii) = (Tensor::<D>::zeros(), first[0]);
        for (node, gradient) in nodes[1..].iter().zip(&element.gradients[1..]) {
            let u = moved(node);
            f += (u - first) * gradient.transpose();
            radii += u[0];
        }
        f += element.rest_f;
        let out = if self.section == Section::Axisymmetric { element.rest_stretch + radii * element.hoop } else { 1.0 };
        DeformationGradient { f, out, det_f: det(&f) }
    }
}

#[cfg(test)]
mod tests;
