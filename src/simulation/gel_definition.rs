//! What a gel is made of, whatever its mesh: what is needed to make it again on another one.

use super::loads;
use crate::constitutive::{
    Branch, BulkViscosity, EquationOfState, Flowing, Material, MooneyRivlin, NeoHookean, Ogden, Softening, Viscoelastic,
};
use crate::fem::{Potential, Reference, Section, Simplices};
use crate::integrator::{Gel, Pressure, Surface, Wear};
use crate::math::{Vector, Vector3};
use crate::mesh::{ElementId, Facet, Mesh, NodeId, Patches, Simplex, facet_measure, poor_quality};
use crate::remesh::Neighbours;
use crate::scene::{
    ConstantsSpec, Dimension, ElementKind, Gel as GelTable, GelShape, MaterialModel, Remesh, Scene, StrengthSpec,
    Symmetry,
};
use crate::state::Birth;

/// What a gel is made of.
#[derive(Debug, Clone)]
pub(super) struct Recipe {
    pub section: Section,
    material: Material,
    kind: ElementKind,
    /// kg/m³, of all that the gel stands for.
    pub density: f64,
    /// Which part of it is computed.
    pub symmetry: Symmetry,
    /// What acts on its surface.
    pressures: Vec<Pressure>,
    /// Where its sensors are at rest, m.
    pub sensors: Vec<Vector3>,
    /// When and how its mesh is exchanged.
    pub remesh: Option<Sizes>,
}

/// How fine meshes are, and when they are worn.
#[derive(Debug, Clone)]
pub(super) struct Sizes {
    pub rules: Remesh,
    /// Edges: the least asked for, that of the scene, and the longest, m.
    pub least: f64,
    pub usual: f64,
    pub longest: f64,
}

/// An element is worn when it is so many times worse than when it was new: what the shape of the body imposes would otherwise wear
/// a mesh out at once.
const AGED: f64 = 0.6;
/// No new mesh need be of better quality than this.
const FAIR: f64 = 0.35;

impl Recipe {
    pub fn of(scene: &Scene) -> Self {
        let (usual, part) = (scene.mesh.size, part(&scene.gel));
        let graded = scene.mesh.grading.map(|grading| grading.largest);
        let doubled = scene.mesh.tree.map(|tree| usual * tree.coarsest as f64);
        let round = match scene.gel.shape {
            GelShape::Shell { inner, outer } => Some(usual * outer / inner),
            GelShape::Block { .. } | GelShape::Cylinder { .. } | GelShape::LBeam { .. } => None,
        };
        let longest = graded.or(doubled).or(round).unwrap_or(usual).max(usual);
        let sizes = |rules: Remesh| Sizes { least: rules.smallest.unwrap_or(0.5 * usual), usual, longest, rules };
        Self {
            section: match scene.scene.dimension {
                Dimension::Planar => Section::Planar { thickness: scene.thickness() },
                Dimension::Axisymmetric => Section::Axisymmetric,
                Dimension::Spatial => Section::Spatial,
            },
            material: material(&part),
            kind: scene.mesh.element,
            density: part.density,
            symmetry: scene.gel.symmetry,
            pressures: loads::pressures(scene),
            sensors: scene.sensor.iter().map(|sensor| sensor.position.into()).collect(),
            remesh: scene.remesh.clone().map(sizes),
        }
    }

    /// What rounding leaves of the energy of so much gel at rest, J.
    pub fn noise(&self, mass: f64) -> f64 {
        /// Of a strain of one; a real one is a millionth of that or more.
        const ROUND_OFF: f64 = 1e-14;
        ROUND_OFF * self.material.wave_modulus() * mass / self.density
    }

    /// μ V of so much gel, J: the torque that stresses of the size of the shear modulus have.
    pub fn shear_torque(&self, mass: f64) -> f64 {
        self.material.wave_modulus() * self.material.slowness_of_shear().powi(2) * mass / self.density
    }

    /// How many parts like the one that is computed make all of the gel.
    pub fn copies(&self) -> f64 {
        self.symmetry.copies()
    }

    /// The elements of a mesh in these patches.
    pub fn simplices<const D: usize>(&self, mesh: &Mesh<D>, patches: Patches) -> Simplices<D> {
        Simplices::in_patches(mesh, patches, (self.material, self.section))
    }

    /// Whether neighbours of elements are asked for at all.
    pub fn asks_for_neighbours(&self) -> bool {
        self.kind == ElementKind::Patch || self.remesh.is_some()
    }

    /// Which elements of a mesh, whose nodes are there when it is new, with these neighbours share their change of volume.
    pub fn patches<const D: usize>(&self, (mesh, position): (&Mesh<D>, &[Vector<D>]), across: &Neighbours) -> Patches {
        match (self.kind, &self.material) {
            (ElementKind::Plain, _) => Patches::alone(mesh.elements.len()),
            (
                ElementKind::Patch,
                Material::NeoHookean(_) | Material::MooneyRivlin(_) | Material::Ogden(_) | Material::Viscoelastic(_),
            ) => Patches::among((&mesh.rest, &mesh.elements), across),
            // Of what has flowed the nodes do not say any more what was near what at rest.
            (ElementKind::Patch, Material::Flowing(_)) => Patches::among((position, &mesh.elements), across),
        }
    }

    /// The gel of these elements, the nodes of whose mesh are there when it is new, with these masses.
    pub fn gel<const D: usize>(
        &self,
        simplices: Simplices<D>,
        (mesh, position): (&Mesh<D>, &[Vector<D>]),
        mass: Vec<f64>,
    ) -> Gel<D, Simplices<D>> {
        let gel = Gel::new(simplices, mass, &mesh.held, self.surface(mesh, position)).mirrored(self.mirrored());
        loads::loaded(gel, mesh, (self.section, &self.pressures))
    }

    /// The axes across which it meets its image: those of the planes of symmetry, or the first about an axis of revolution.
    fn mirrored(&self) -> &'static [usize] {
        if self.section == Section::Axisymmetric { &[0] } else { self.symmetry.mirrored() }
    }

    /// All of the boundary but the axis of revolution and the planes of symmetry: areas at rest, sizes where the nodes are.
    fn surface<const D: usize>(&self, mesh: &Mesh<D>, position: &[Vector<D>]) -> Surface {
        let rest = |facet: &Facet, i: usize| mesh.rest[facet[i].index()];
        let is_image = |facet: &Facet| self.mirrored().iter().any(|i| (0..D).all(|node| rest(facet, node)[*i] == 0.0));
        let facets = mesh.facets.iter().copied().filter(|facet| !is_image(facet)).collect();
        let planes =
            |node: NodeId| self.symmetry.mirrored().iter().filter(|i| mesh.rest[node.index()][**i] == 0.0).count();
        let surface = Surface::new::<D>(mesh.rest.len(), facets, |facet| {
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

    /// Whether all elements of a mesh are at rest on the side of the axis where matter is, if there is one.
    pub fn holds<const D: usize>(&self, birth: &Birth<D>) -> bool {
        if self.section != Section::Axisymmetric {
            return true;
        }
        let mesh = &birth.mesh;
        let radius = |nodes: &Simplex| Reference::of(&mesh.rest, nodes).radius;
        let mut own = birth.references.iter().peekable();
        let outside = |(element, nodes): (ElementId, &Simplex)| {
            let reference = own.next_if(|(own, _)| *own == element);
            reference.map_or_else(|| radius(nodes), |(_, reference)| reference.radius) > 0.0
        };
        (0..).map(ElementId).zip(&mesh.elements).all(outside)
    }

    /// The quality of an element of a mesh that is exchanged, infinite if it is too good to matter: to when a mesh is worn, or to how bad
    /// a new one may be.
    pub fn shape<const D: usize>(&self, x: &[Vector<D>], nodes: &Simplex) -> f64 {
        let worn = self.remesh.as_ref().map_or(0.0, |sizes| sizes.rules.quality / AGED);
        poor_quality(x, nodes, worn.max(FAIR))
    }

    /// Those of all elements.
    pub fn shapes<const D: usize>(&self, elements: &[Simplex], x: &[Vector<D>]) -> Vec<f64> {
        elements.iter().map(|nodes| self.shape(x, nodes)).collect()
    }

    /// When a mesh is worn whose nodes are there when it is new, and whose elements have these qualities then; never, if it is not
    /// exchanged.
    pub fn wear<const D: usize>(
        &self,
        potential: &Simplices<D>,
        position: &[Vector<D>],
        shapes: &[f64],
    ) -> Option<Wear> {
        let Remesh { quality, compression, .. } = self.remesh.as_ref()?.rules;
        let least = |(element, nodes): (ElementId, &Simplex)| {
            let new = potential.measure(&nodes.map(|node| position[node.index()]));
            (compression * potential.rest_measure(element)).min(AGED * new)
        };
        Some(Wear {
            quality: shapes.iter().map(|shape| quality.min(AGED * shape)).collect(),
            least: (0..).map(ElementId).zip(potential.elements()).map(least).collect(),
        })
    }
}

/// What stands for so many parts that move alike: as many times as heavy, as stiff and as strong (numerics A1).
fn part(gel: &GelTable) -> GelTable {
    let copies = gel.symmetry.copies();
    let mut part = gel.clone();
    part.density *= copies;
    part.shear_modulus *= copies;
    part.bulk_modulus *= copies;
    if let Some(strength) = &mut part.strength {
        strength.yield_stress *= copies;
        strength.cap *= copies;
        strength.confined.iter_mut().for_each(|confined| confined.pressure *= copies);
    }
    if let Some(tension) = part.volume.as_mut().and_then(|volume| volume.tension_limit.as_mut()) {
        *tension *= copies;
    }
    part.branches.iter_mut().for_each(|branch| branch.shear_modulus *= copies);
    part.terms.iter_mut().for_each(|term| term.modulus *= copies);
    if let Some(constants) = &mut part.constants {
        (constants.c1, constants.c2) = (copies * constants.c1, copies * constants.c2);
    }
    part
}

/// What a gel is made of.
pub(super) fn material(gel: &GelTable) -> Material {
    match gel.material {
        MaterialModel::NeoHookean => NeoHookean::new(gel.shear_modulus, gel.bulk_modulus).into(),
        MaterialModel::MooneyRivlin => {
            let ConstantsSpec { c1, c2 } = gel.constants.expect("a checked Mooney-Rivlin gel has constants");
            Material::MooneyRivlin(MooneyRivlin::new([c1, c2], gel.bulk_modulus))
        }
        MaterialModel::Ogden => Material::Ogden(Ogden::new(&gel.ogden_terms(), gel.bulk_modulus)),
        MaterialModel::Viscoelastic => {
            let branches: Vec<Branch> =
                gel.branches.iter().map(|b| Branch { shear_modulus: b.shear_modulus, time: b.time }).collect();
            let equilibrium = NeoHookean::new(gel.shear_modulus, gel.bulk_modulus);
            Material::Viscoelastic(Viscoelastic::new(equilibrium, &branches))
        }
        MaterialModel::Flowing => {
            let volume = gel.volume.unwrap_or_default();
            let viscosity = gel.viscosity.unwrap_or_default();
            Material::Flowing(Flowing {
                shear_modulus: gel.shear_modulus,
                state: EquationOfState::new(
                    gel.bulk_modulus,
                    volume.hugoniot_slope,
                    volume.tension_limit.unwrap_or(f64::INFINITY),
                ),
                strength: gel.strength.map(StrengthSpec::law),
                softening: gel.softening.map(|s| Softening::new(s.strain, s.residual, s.time)),
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
    fn what_stands_for_four_parts_bears_four_times_as_much_at_four_times_the_pressure() {
        let mut gel = read(builtin("fbi-bb-3d").unwrap()).unwrap().gel;
        let strength = gel.strength.as_mut().unwrap();
        strength.confined = Some(ConfinedSpec { pressure: 7.5e6, factor: 6.0, time: 2e-6 });
        let (one, four) = (strength.yield_stress, part(&gel).strength.unwrap());
        assert_eq!((four.yield_stress, four.cap), (4.0 * one, 4.0 * gel.strength.unwrap().cap));
        assert_eq!(four.confined, Some(ConfinedSpec { pressure: 30e6, factor: 6.0, time: 2e-6 }));
    }
}
