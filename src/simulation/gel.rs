//! Gel of a scene: material, section, loads and settings of remeshing, free of any mesh.

use super::loads;
use crate::adapt::{AdaptSettings, GelDefinition};
use crate::constitutive::{
    BulkViscosity, DamageLaw, EquationOfState, Material, MaxwellBranch, MooneyRivlin, NeoHookean, Ogden, Viscoelastic,
    Viscoplastic,
};
use crate::fem::Section;
use crate::scene::{
    ConstantsSpec, Dimension, ElementKind, GelShape, GelSpec, MaterialModel, RemeshSpec, Scene, StrengthSpec,
};

/// Defines the gel of a scene.
pub(super) fn define_gel(scene: &Scene) -> GelDefinition {
    let scaled = scale_by_copies(&scene.gel);
    GelDefinition {
        section: match scene.scene.dimension {
            Dimension::Planar => Section::Planar { thickness: scene.thickness() },
            Dimension::Axisymmetric => Section::Axisymmetric,
            Dimension::Spatial => Section::Spatial,
        },
        material: build_material(&scaled),
        has_patches: scene.mesh.element == ElementKind::Patch,
        density: scaled.density,
        symmetry_planes: scene.gel.symmetry.mirrored(),
        pressures: loads::pressures(scene),
        remesh: scene.remesh.as_ref().map(|rules| adapt_settings(scene, rules)),
    }
}

/// Settings of remeshing with the edges of the mesh of a scene.
fn adapt_settings(scene: &Scene, rules: &RemeshSpec) -> AdaptSettings {
    let usual = scene.mesh.size;
    let graded = scene.mesh.grading.map(|grading| grading.largest);
    let doubled = scene.mesh.tree.map(|tree| usual * tree.coarsest as f64);
    let round = match scene.gel.shape {
        GelShape::Shell { inner, outer } => Some(usual * outer / inner),
        GelShape::Block { .. } | GelShape::Cylinder { .. } | GelShape::LBeam { .. } => None,
    };
    AdaptSettings {
        method: rules.method,
        quality: rules.quality,
        min_volume_ratio: rules.min_volume_ratio,
        adaptive: rules.adaptive,
        least: rules.smallest.unwrap_or(0.5 * usual),
        usual,
        longest: graded.or(doubled).or(round).unwrap_or(usual).max(usual),
        tip_size: rules.tip_size,
        curvature_angle: rules.curvature_angle.to_radians(),
        growth: rules.growth,
        erosion_thickness: rules.erosion_thickness,
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
