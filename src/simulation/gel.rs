//! Gel of a scene: material, section, loads and settings of remeshing, free of any mesh.

use super::loads;
use crate::adapt::{AdaptSettings, GelDefinition};
use crate::constitutive::{
    Branch, BulkViscosity, EquationOfState, Material, MooneyRivlin, NeoHookean, Ogden, StretchDamage, TwoNetwork,
};
use crate::fem::Section;
use crate::scene::{
    ConstantsSpec, Dimension, ElementKind, GelShape, GelSpec, MaterialModel, RemeshSpec, Scene, layer_stack,
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
        layers: layer_stack(&scene.layer, &scene.gel),
        density: scaled.density,
        symmetry_planes: scene.gel.symmetry.mirrored(),
        meets_itself: scene.meets_itself(),
        pressures: loads::pressures(scene),
        cavity: loads::cavity_air(scene),
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
        average: rules.elastic_average,
    }
}

/// Scales the moduli and dashpot stresses of the networks; relaxation times remain.
fn scale_networks(gel: &mut GelSpec, factor: f64) {
    gel.shear_modulus *= factor;
    for branch in &mut gel.branches {
        branch.shear_modulus *= factor;
        branch.power_law.iter_mut().for_each(|law| law.stress *= factor);
    }
}

/// Scales density, moduli and stresses of a gel by its number of symmetric copies (method A1).
fn scale_by_copies(gel: &GelSpec) -> GelSpec {
    let copies = gel.symmetry.copies();
    let mut scaled = gel.clone();
    scaled.density *= copies;
    scale_networks(&mut scaled, copies * gel.strength_scale);
    scaled.bulk_modulus *= copies;
    if let Some(tension) = scaled.volume.as_mut().and_then(|volume| volume.tension_limit.as_mut()) {
        *tension *= copies;
    }
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
        MaterialModel::TwoNetwork => build_networks(gel).into(),
    }
}

/// Two-network gel.
fn build_networks(gel: &GelSpec) -> TwoNetwork {
    let volume = gel.volume.unwrap_or_default();
    let tension = volume.tension_limit.unwrap_or(f64::INFINITY);
    let state = EquationOfState::new(gel.bulk_modulus, volume.hugoniot_slope, tension);
    let branches: Vec<Branch> = gel.branches.iter().map(|branch| branch.branch()).collect();
    let viscosity = gel.viscosity.unwrap_or_default();
    let bulk = BulkViscosity { linear: viscosity.linear, quadratic: viscosity.quadratic };
    let networks = TwoNetwork::new(gel.shear_modulus, &branches, state, gel.density).with_viscosity(bulk);
    match gel.damage {
        Some(damage) => networks.with_damage(StretchDamage::new(damage.critical_stretch, damage.delay)),
        None => networks,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{builtin, read};

    #[test]
    fn four_copies_have_four_times_the_moduli_and_stresses_of_all_networks() {
        let mut gel = read(builtin("fbi-bb-3d").unwrap()).unwrap().gel;
        gel.strength_scale = 1.5;
        gel.branches[0].power_law.as_mut().unwrap().rate = Some(1200.0);
        let scaled = scale_by_copies(&gel);
        assert_eq!(gel.symmetry.copies(), 4.0);
        let (one, four) = (gel.branches[0], scaled.branches[0]);
        assert_eq!(scaled.shear_modulus, 6.0 * gel.shear_modulus);
        assert_eq!(four.shear_modulus, 6.0 * one.shear_modulus);
        let [one, four] = [one, four].map(|branch| branch.power_law.unwrap());
        assert_eq!((four.stress, four.rate, four.exponent), (6.0 * one.stress, one.rate, one.exponent));
        assert_eq!((scaled.bulk_modulus, scaled.density), (4.0 * gel.bulk_modulus, 4.0 * gel.density));
        assert_eq!(scaled.damage, gel.damage);
    }
}
