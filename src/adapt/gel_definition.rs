//! Mesh-independent definition of a gel, from which it can be built on any mesh.

use super::layer_parts::first_parts;
use super::settings::{AdaptSettings, RemeshMethod};
use crate::constitutive::{LayerStack, Material, MaterialParts, MaterialRatios};
use crate::contact::ContactSurface;
use crate::fem::{Potential, ReferenceShape, Section, Simplices};
use crate::integrator::{
    CavityAir, DiscreteGel, DistortionLimits, Engine, LoadedFacet, PressureHistory, PressureLoads,
};
use crate::math::Vector;
use crate::mesh::{ElementId, ElementPatches, Facet, Mesh, NodeId, Simplex, facet_measure, poor_quality};
use crate::remesh::{BodySymmetry, ElementNeighbours};
use crate::state::MeshInstance;

/// Mesh-independent definition of a gel: material, section, symmetry, loads and remeshing settings.
#[derive(Debug, Clone)]
pub(crate) struct GelDefinition {
    pub section: Section,
    /// Material whose density, moduli and stresses are scaled by the number of symmetric copies.
    pub material: Material,
    /// True for F-bar patches, false for plain elements.
    pub has_patches: bool,
    /// Layers on the gel; `None` of a gel of one material.
    pub layers: Option<LayerStack>,
    /// Mass density, kg/m³, scaled by the number of symmetric copies.
    pub density: f64,
    /// Axes normal to the planes of symmetry, of which one side is computed.
    pub symmetry_planes: &'static [usize],
    /// True if contact of the gel with itself is detected.
    pub meets_itself: bool,
    /// Pressures on the surface.
    pub pressures: Vec<PressureHistory>,
    /// Air in the cavity behind the projectile.
    pub cavity: Option<CavityAir>,
    /// Settings of remeshing; `None` without remeshing.
    pub remesh: Option<AdaptSettings>,
}

/// Ratio of an element's quality to its quality when new, below which the mesh counts as distorted. Without this
/// ratio, a shape imposed by a body would trigger remeshing at once.
const AGED_RATIO: f64 = 0.6;
/// Element quality that is sufficient in any new mesh.
const SUFFICIENT_QUALITY: f64 = 0.35;

impl GelDefinition {
    /// Round-off of the energy of this mass of gel at rest, J.
    pub fn energy_round_off(&self, mass: f64) -> f64 {
        /// Round-off relative to the energy of a strain of one; real strains are a millionth of that or more.
        const ROUND_OFF: f64 = 1e-14;
        ROUND_OFF * self.greatest_modulus() * mass / self.density
    }

    /// Greatest speed of sound of a layer, relative to that of the gel; 1 of a gel of one material.
    pub fn greatest_speed(&self) -> f64 {
        self.layers.as_ref().map_or(1.0, LayerStack::greatest_speed)
    }

    /// Greatest modulus of pressure waves of a layer or the gel, Pa.
    pub fn greatest_modulus(&self) -> f64 {
        let most = self.layers.as_ref().map_or(MaterialRatios::GEL, LayerStack::greatest);
        most.bulk.max(most.strength) * self.material.wave_modulus()
    }

    /// Shear modulus times volume of this mass of gel, J: the torque of stresses of the size of the shear modulus.
    pub fn shear_torque(&self, mass: f64) -> f64 {
        self.greatest_modulus() * self.material.shear_wave_ratio().powi(2) * mass / self.density
    }

    /// Number of copies of the computed part that make the whole gel.
    pub fn copies(&self) -> f64 {
        f64::from(1 << self.symmetry_planes.len())
    }

    /// Symmetry of the body of this section.
    pub fn body_symmetry(&self) -> BodySymmetry {
        match self.section {
            Section::Planar { .. } => BodySymmetry::Planar,
            Section::Axisymmetric => BodySymmetry::Axisymmetric,
            Section::Spatial => BodySymmetry::Spatial,
        }
    }

    /// Finite elements of a first mesh in these patches.
    pub fn build_first_simplices<const D: usize>(&self, mesh: &Mesh<D>, patches: ElementPatches) -> Simplices<D> {
        let parts = self.layers.as_ref().map(|stack| first_parts(stack, self.section, &mesh.rest, &mesh.elements));
        self.build_simplices(mesh, patches, parts.unwrap_or_default())
    }

    /// Finite elements of a mesh in these patches, with these parts of mass of the materials of a layered gel.
    pub fn build_simplices<const D: usize>(
        &self,
        mesh: &Mesh<D>,
        patches: ElementPatches,
        parts: Vec<MaterialParts>,
    ) -> Simplices<D> {
        let simplices = Simplices::in_patches(mesh, patches, (self.material, self.section));
        match &self.layers {
            Some(stack) => simplices.with_layers(stack, parts),
            None => simplices,
        }
    }

    /// Returns true if elements are remade by local operations before they fail.
    pub fn is_edited(&self) -> bool {
        let is_edited = |settings: &AdaptSettings| settings.method == RemeshMethod::Local && settings.quality > 0.0;
        self.remesh.as_ref().is_some_and(is_edited)
    }

    /// Stable steps of the elements of a new mesh, s; empty where no limit depends on them.
    pub fn steps_when_new<const D: usize>(&self, engine: &Engine<D, Simplices<D>>) -> Vec<f64> {
        match &engine.state().birth {
            _ if !self.is_edited() => vec![],
            Some(birth) if matches!(self.material, Material::TwoNetwork(_)) => birth.steps.clone(),
            _ => engine.stable_steps(),
        }
    }

    /// Returns true if the neighbours of elements are needed.
    pub fn needs_adjacency(&self) -> bool {
        self.has_patches || self.remesh.is_some()
    }

    /// F-bar patches of a mesh with these neighbours; `position` holds its nodal positions when new.
    pub fn build_patches<const D: usize>(
        &self,
        mesh: &Mesh<D>,
        position: &[Vector<D>],
        adjacency: &ElementNeighbours,
    ) -> ElementPatches {
        if !self.has_patches {
            return ElementPatches::alone(mesh.elements.len());
        }
        match &self.material {
            Material::NeoHookean(_) | Material::MooneyRivlin(_) | Material::Ogden(_) => {
                ElementPatches::grouped_at((&mesh.rest, &mesh.elements), adjacency)
            }
            // After viscous flow the rest positions no longer tell which elements are neighbours in space.
            Material::TwoNetwork(_) => ElementPatches::grouped_at((position, &mesh.elements), adjacency),
        }
    }

    /// Gel of these elements with these nodal masses; `position` holds the nodal positions of the mesh when new.
    pub fn build_gel<const D: usize>(
        &self,
        simplices: Simplices<D>,
        mesh: &Mesh<D>,
        position: &[Vector<D>],
        mass: Vec<f64>,
    ) -> DiscreteGel<D, Simplices<D>> {
        let simplices = simplices.with_masses(&mass, position);
        let gel = DiscreteGel::new(simplices, mass, &mesh.held, self.build_surface(mesh, position));
        let gel = gel.mirrored(self.mirrored()).with_self_contact(self.meets_itself);
        self.with_pressures(gel, mesh)
    }

    /// Applies the pressures to the gel of a mesh.
    fn with_pressures<const D: usize>(
        &self,
        gel: DiscreteGel<D, Simplices<D>>,
        mesh: &Mesh<D>,
    ) -> DiscreteGel<D, Simplices<D>> {
        if mesh.marks.is_empty() {
            return gel;
        }
        let surface = gel.surface.facets.iter().zip(&gel.behind);
        let mut behind: Vec<(Facet, _)> = surface.map(|(facet, behind)| (*facet, *behind)).collect();
        behind.sort_unstable();
        let of = |(facet, mark): (&Facet, &u8)| {
            let at = behind.binary_search_by_key(facet, |(facet, _)| *facet).ok()?;
            (*mark != 0).then(|| LoadedFacet { facet: *facet, behind: behind[at].1, mark: *mark })
        };
        let facets = mesh.facets.iter().zip(&mesh.marks).filter_map(of).collect();
        let (section, pressures, air) = (self.section, self.pressures.clone(), self.cavity);
        gel.with_loads(PressureLoads { section, pressures, air, facets })
    }

    /// Axes across which the gel may touch its mirror image: normals of the planes of symmetry, or the radius about
    /// an axis of revolution.
    fn mirrored(&self) -> &'static [usize] {
        if self.section == Section::Axisymmetric { &[0] } else { self.symmetry_planes }
    }

    /// Contact surface: the boundary without the axis of revolution and the planes of symmetry. Areas are those at
    /// rest, sizes those of the current facets.
    fn build_surface<const D: usize>(&self, mesh: &Mesh<D>, position: &[Vector<D>]) -> ContactSurface {
        let rest = |facet: &Facet, i: usize| mesh.rest[facet[i].index()];
        let is_image = |facet: &Facet| self.mirrored().iter().any(|i| (0..D).all(|node| rest(facet, node)[*i] == 0.0));
        let facets = mesh.facets.iter().copied().filter(|facet| !is_image(facet)).collect();
        let planes = |node: NodeId| self.symmetry_planes.iter().filter(|i| mesh.rest[node.index()][**i] == 0.0).count();
        // A facet that has been stretched is held no deeper in a body than one of the first mesh.
        let greatest = match self.remesh.as_ref().filter(|_| self.is_edited()) {
            Some(settings) if D == 2 => settings.usual,
            Some(settings) => 0.5 * settings.usual * settings.usual,
            None => f64::INFINITY,
        };
        let surface = ContactSurface::new::<D>(mesh.rest.len(), facets, |facet| {
            let area = facet_measure(&mesh.rest, facet)
                * match self.section {
                    Section::Planar { thickness } => thickness,
                    Section::Axisymmetric => std::f64::consts::PI * (rest(facet, 0)[0] + rest(facet, 1)[0]),
                    Section::Spatial => self.copies(),
                };
            (area, facet_measure(position, facet).min(greatest))
        });
        surface.mirrored(planes)
    }

    /// Returns true if these parts are of the materials of this gel.
    pub fn has_materials(&self, parts: &[MaterialParts]) -> bool {
        let Some(stack) = &self.layers else { return parts.is_empty() };
        let is_known = |parts: &MaterialParts| parts[stack.n_materials()..].iter().all(|part| *part == 0.0);
        !parts.is_empty() && parts.iter().all(is_known)
    }

    /// Returns true if all elements lie at rest at a positive radius, where there is an axis.
    pub fn has_positive_radii<const D: usize>(&self, birth: &MeshInstance<D>) -> bool {
        if self.section != Section::Axisymmetric {
            return true;
        }
        let mesh = &birth.mesh;
        let radius = |nodes: &Simplex| ReferenceShape::of(&mesh.rest, nodes).radius;
        let mut own = birth.references.iter().peekable();
        let has_positive_radius = |(element, nodes): (ElementId, &Simplex)| {
            let reference = own.next_if(|(own, _)| *own == element);
            reference.map_or_else(|| radius(nodes), |(_, reference)| reference.radius) > 0.0
        };
        (0..).map(ElementId).zip(&mesh.elements).all(has_positive_radius)
    }

    /// Quality of an element for the distortion monitor and for acceptance; infinite if it is too good to matter for
    /// either.
    pub fn element_quality<const D: usize>(&self, x: &[Vector<D>], nodes: &Simplex) -> f64 {
        let distortion_quality = self.remesh.as_ref().map_or(0.0, |settings| settings.quality / AGED_RATIO);
        poor_quality(x, nodes, distortion_quality.max(SUFFICIENT_QUALITY))
    }

    /// Qualities of all elements.
    pub fn element_qualities<const D: usize>(&self, elements: &[Simplex], x: &[Vector<D>]) -> Vec<f64> {
        elements.iter().map(|nodes| self.element_quality(x, nodes)).collect()
    }

    /// Limits of the distortion monitor: least qualities and volumes of the elements. `position` and `qualities` are
    /// those of the new mesh; `None` without remeshing.
    pub fn distortion_limits<const D: usize>(
        &self,
        potential: &Simplices<D>,
        position: &[Vector<D>],
        qualities: &[f64],
    ) -> Option<DistortionLimits> {
        let AdaptSettings { quality, min_volume_ratio, .. } = *self.remesh.as_ref()?;
        let least = |(element, nodes): (ElementId, &Simplex)| {
            let new = potential.measure(&nodes.map(|node| position[node.index()]));
            (min_volume_ratio * potential.rest_measure(element)).min(AGED_RATIO * new)
        };
        Some(DistortionLimits::of_shape(
            qualities.iter().map(|shape| quality.min(AGED_RATIO * shape)).collect(),
            (0..).map(ElementId).zip(potential.elements()).map(least).collect(),
        ))
    }
}
