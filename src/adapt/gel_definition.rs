//! Mesh-independent definition of a gel, from which it can be rebuilt on another mesh.

use super::loads;
use crate::constitutive::{
    BulkViscosity, DamageLaw, EquationOfState, Material, MaxwellBranch, MooneyRivlin, NeoHookean, Ogden, Viscoelastic,
    Viscoplastic,
};
use crate::fem::{Potential, ReferenceShape, Section, Simplices};
use crate::integrator::{ContactSurface, DiscreteGel, DistortionLimits, PressureHistory};
use crate::math::{Vector, Vector3};
use crate::mesh::{ElementId, ElementPatches, Facet, Mesh, NodeId, Simplex, facet_measure, poor_quality};
use crate::remesh::ElementNeighbours;
use crate::scene::{
    ConstantsSpec, Dimension, ElementKind, GelShape, GelSpec, GelSymmetry, MaterialModel, RemeshSpec, Scene,
    StrengthSpec,
};
use crate::state::MeshInstance;

/// Mesh-independent definition of a gel: material, section, symmetry, loads, sensors and remeshing rules.
#[derive(Debug, Clone)]
pub(super) struct GelDefinition {
    pub section: Section,
    material: Material,
    kind: ElementKind,
    /// Mass density, kg/m³, scaled by the number of symmetric copies.
    pub density: f64,
    /// Part of the gel that is computed.
    pub symmetry: GelSymmetry,
    /// Pressures on the surface.
    pressures: Vec<PressureHistory>,
    /// Positions of the sensors at rest, m.
    pub sensors: Vec<Vector3>,
    /// Remeshing rules and edge lengths; `None` without remeshing.
    pub remesh: Option<RemeshSizes>,
}

/// Remeshing rules and target edge lengths.
#[derive(Debug, Clone)]
pub(super) struct RemeshSizes {
    pub rules: RemeshSpec,
    /// Least edge, edge of the scene, and longest edge, m.
    pub least: f64,
    pub usual: f64,
    pub longest: f64,
}

/// Ratio of an element's quality to its quality when new, below which the mesh counts as distorted. Without this
/// ratio, a shape imposed by a body would trigger remeshing at once.
const AGED_RATIO: f64 = 0.6;
/// Element quality that is sufficient in any new mesh.
const SUFFICIENT_QUALITY: f64 = 0.35;

impl GelDefinition {
    pub fn of(scene: &Scene) -> Self {
        let (usual, scaled) = (scene.mesh.size, scale_by_copies(&scene.gel));
        let graded = scene.mesh.grading.map(|grading| grading.largest);
        let doubled = scene.mesh.tree.map(|tree| usual * tree.coarsest as f64);
        let round = match scene.gel.shape {
            GelShape::Shell { inner, outer } => Some(usual * outer / inner),
            GelShape::Block { .. } | GelShape::Cylinder { .. } | GelShape::LBeam { .. } => None,
        };
        let longest = graded.or(doubled).or(round).unwrap_or(usual).max(usual);
        let sizes =
            |rules: RemeshSpec| RemeshSizes { least: rules.smallest.unwrap_or(0.5 * usual), usual, longest, rules };
        Self {
            section: match scene.scene.dimension {
                Dimension::Planar => Section::Planar { thickness: scene.thickness() },
                Dimension::Axisymmetric => Section::Axisymmetric,
                Dimension::Spatial => Section::Spatial,
            },
            material: build_material(&scaled),
            kind: scene.mesh.element,
            density: scaled.density,
            symmetry: scene.gel.symmetry,
            pressures: loads::pressures(scene),
            sensors: scene.sensor.iter().map(|sensor| sensor.position.into()).collect(),
            remesh: scene.remesh.clone().map(sizes),
        }
    }

    /// Round-off of the energy of this mass of gel at rest, J.
    pub fn energy_round_off(&self, mass: f64) -> f64 {
        /// Round-off relative to the energy of a strain of one; real strains are a millionth of that or more.
        const ROUND_OFF: f64 = 1e-14;
        ROUND_OFF * self.material.wave_modulus() * mass / self.density
    }

    /// Shear modulus times volume of this mass of gel, J: the torque of stresses of the size of the shear modulus.
    pub fn shear_torque(&self, mass: f64) -> f64 {
        self.material.wave_modulus() * self.material.shear_wave_ratio().powi(2) * mass / self.density
    }

    /// Number of copies of the computed part that make the whole gel.
    pub fn copies(&self) -> f64 {
        self.symmetry.copies()
    }

    /// Finite elements of a mesh in these patches.
    pub fn build_simplices<const D: usize>(&self, mesh: &Mesh<D>, patches: ElementPatches) -> Simplices<D> {
        Simplices::in_patches(mesh, patches, (self.material, self.section))
    }

    /// Returns true if the neighbours of elements are needed.
    pub fn needs_adjacency(&self) -> bool {
        self.kind == ElementKind::Patch || self.remesh.is_some()
    }

    /// F-bar patches of a mesh with these neighbours; `position` holds its nodal positions when new.
    pub fn build_patches<const D: usize>(
        &self,
        mesh: &Mesh<D>,
        position: &[Vector<D>],
        adjacency: &ElementNeighbours,
    ) -> ElementPatches {
        match (self.kind, &self.material) {
            (ElementKind::Plain, _) => ElementPatches::alone(mesh.elements.len()),
            (
                ElementKind::Patch,
                Material::NeoHookean(_) | Material::MooneyRivlin(_) | Material::Ogden(_) | Material::Viscoelastic(_),
            ) => ElementPatches::grouped_at((&mesh.rest, &mesh.elements), adjacency),
            // After plastic flow the rest positions no longer tell which elements are neighbours in space.
            (ElementKind::Patch, Material::Flowing(_)) => {
                ElementPatches::grouped_at((position, &mesh.elements), adjacency)
            }
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
        let gel =
            DiscreteGel::new(simplices, mass, &mesh.held, self.build_surface(mesh, position)).mirrored(self.mirrored());
        loads::apply_pressures(gel, mesh, self.section, &self.pressures)
    }

    /// Axes across which the gel may touch its mirror image: normals of the planes of symmetry, or the radius about
    /// an axis of revolution.
    fn mirrored(&self) -> &'static [usize] {
        if self.section == Section::Axisymmetric { &[0] } else { self.symmetry.mirrored() }
    }

    /// Contact surface: the boundary without the axis of revolution and the planes of symmetry. Areas are those at
    /// rest, sizes those of the current facets.
    fn build_surface<const D: usize>(&self, mesh: &Mesh<D>, position: &[Vector<D>]) -> ContactSurface {
        let rest = |facet: &Facet, i: usize| mesh.rest[facet[i].index()];
        let is_image = |facet: &Facet| self.mirrored().iter().any(|i| (0..D).all(|node| rest(facet, node)[*i] == 0.0));
        let facets = mesh.facets.iter().copied().filter(|facet| !is_image(facet)).collect();
        let planes =
            |node: NodeId| self.symmetry.mirrored().iter().filter(|i| mesh.rest[node.index()][**i] == 0.0).count();
        let surface = ContactSurface::new::<D>(mesh.rest.len(), facets, |facet| {
            let area = facet_measure(&mesh.rest, facet)
                * match self.section {
                    Section::Planar { thickness } => thickness,
                    Section::Axisymmetric => std::f64::consts::PI * (rest(facet, 0)[0] + rest(facet, 1)[0]),
                    Section::Spatial => self.copies(),
                };
            (area, facet_measure(position, facet))
        });
        surface.mirrored(planes)
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
        let distortion_quality = self.remesh.as_ref().map_or(0.0, |sizes| sizes.rules.quality / AGED_RATIO);
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
        let RemeshSpec { quality, min_volume_ratio: compression, .. } = self.remesh.as_ref()?.rules;
        let least = |(element, nodes): (ElementId, &Simplex)| {
            let new = potential.measure(&nodes.map(|node| position[node.index()]));
            (compression * potential.rest_measure(element)).min(AGED_RATIO * new)
        };
        Some(DistortionLimits {
            quality: qualities.iter().map(|shape| quality.min(AGED_RATIO * shape)).collect(),
            least: (0..).map(ElementId).zip(potential.elements()).map(least).collect(),
        })
    }
}

/// Scales density, moduli and stresses of a gel by its number of symmetric copies (numerics A1).
fn scale_by_copies(gel: &GelSpec) -> GelSpec {
    let copies = gel.symmetry.copies();
    let mut scaled = gel.clone();
    scaled.density *= copies;
    scaled.shear_modulus *= copies;
    scaled.bulk_modulus *= copies;
    if let Some(strength) = &mut scaled.strength {
        strength.yield_stress *= copies;
        strength.cap *= copies;
        strength.confined.iter_mut().for_each(|confined| confined.pressure *= copies);
    }
    if let Some(tension) = scaled.volume.as_mut().and_then(|volume| volume.tension_limit.as_mut()) {
        *tension *= copies;
    }
    scaled.branches.iter_mut().for_each(|branch| branch.shear_modulus *= copies);
    scaled.terms.iter_mut().for_each(|term| term.modulus *= copies);
    if let Some(constants) = &mut scaled.constants {
        (constants.c1, constants.c2) = (copies * constants.c1, copies * constants.c2);
    }
    scaled
}

/// Constitutive model of a gel.
pub(super) fn build_material(gel: &GelSpec) -> Material {
    match gel.material {
        MaterialModel::NeoHookean => NeoHookean::new(gel.shear_modulus, gel.bulk_modulus).into(),
        MaterialModel::MooneyRivlin => {
            let ConstantsSpec { c1, c2 } = gel.constants.expect("a checked Mooney-Rivlin gel has constants");
            Material::MooneyRivlin(MooneyRivlin::new([c1, c2], gel.bulk_modulus))
        }
        MaterialModel::Ogden => Material::Ogden(Ogden::new(&gel.ogden_terms(), gel.bulk_modulus)),
        MaterialModel::Viscoelastic => {
            let branches: Vec<MaxwellBranch> =
                gel.branches.iter().map(|b| MaxwellBranch { shear_modulus: b.shear_modulus, time: b.time }).collect();
            let equilibrium = NeoHookean::new(gel.shear_modulus, gel.bulk_modulus);
            Material::Viscoelastic(Viscoelastic::new(equilibrium, &branches))
        }
        MaterialModel::Flowing => {
            let volume = gel.volume.unwrap_or_default();
            let viscosity = gel.viscosity.unwrap_or_default();
            Material::Flowing(Viscoplastic {
                shear_modulus: gel.shear_modulus,
                state: EquationOfState::new(
                    gel.bulk_modulus,
                    volume.hugoniot_slope,
                    volume.tension_limit.unwrap_or(f64::INFINITY),
                ),
                strength: gel.strength.map(StrengthSpec::law),
                softening: gel.softening.map(|s| DamageLaw::new(s.strain, s.residual, s.time)),
                viscosity: BulkViscosity { linear: viscosity.linear, quadratic: viscosity.quadratic },
                density: gel.density,
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{ConfinedSpec, builtin, read};

    #[test]
    fn four_copies_have_four_times_the_strength_and_confining_pressure() {
        let mut gel = read(builtin("fbi-bb-3d").unwrap()).unwrap().gel;
        let strength = gel.strength.as_mut().unwrap();
        strength.confined = Some(ConfinedSpec { pressure: 7.5e6, factor: 6.0, time: 2e-6 });
        let (one, four) = (strength.yield_stress, scale_by_copies(&gel).strength.unwrap());
        assert_eq!((four.yield_stress, four.cap), (4.0 * one, 4.0 * gel.strength.unwrap().cap));
        assert_eq!(four.confined, Some(ConfinedSpec { pressure: 30e6, factor: 6.0, time: 2e-6 }));
    }
}
