//! Pressure loads: marks the facets of the first mesh, and gives their pressures.

use super::build_error::BuildError;
use crate::geometry::SignedDistance;
use crate::integrator::{AirInflow, CavityAir, PressureHistory};
use crate::math::{Vector3, embed};
use crate::mesh::{CAVITY_MARK, Mesh};
use crate::scene::{Dimension, GelFace, GelShape, LoadSpec, Scene, numbered};

/// Relative distance from a round face within which a node lies on it: the round-off of the mapping.
const ROUND: f64 = 1e-9;

/// Load markers of the facets of the first mesh of a scene; empty without loads and with a vented cavity.
///
/// # Errors
/// [`BuildError::Unloaded`] if a load selects no facet.
pub(super) fn load_markers<const D: usize>(scene: &Scene, mesh: &Mesh<D>) -> Result<Vec<u8>, BuildError> {
    let has_air = cavity_air(scene).is_some();
    if scene.load.is_empty() && !has_air {
        return Ok(vec![]);
    }
    let mut marks = vec![0; mesh.facets.len()];
    for (i, load) in scene.load.iter().enumerate() {
        let before: u32 = marks.iter().copied().map(u8::count_ones).sum();
        for (facet, mark) in mesh.facets.iter().zip(&mut marks) {
            let corners: Vec<Vector3> = facet[..D].iter().map(|node| embed(&mesh.rest[node.index()])).collect();
            *mark |= u8::from(is_loaded(scene, load, &corners)) << i;
        }
        if marks.iter().copied().map(u8::count_ones).sum::<u32>() == before {
            return Err(BuildError::Unloaded { key: numbered("load", i) });
        }
    }
    for (facet, mark) in mesh.facets.iter().zip(&mut marks).filter(|_| has_air) {
        let corners: Vec<Vector3> = facet[..D].iter().map(|node| embed(&mesh.rest[node.index()])).collect();
        if is_face(scene, GelFace::ZMax, &corners) {
            *mark |= CAVITY_MARK;
        }
    }
    Ok(marks)
}

/// Returns true if the load acts on a facet with these corners.
fn is_loaded(scene: &Scene, load: &LoadSpec, corners: &[Vector3]) -> bool {
    let is_inside = load
        .within
        .is_none_or(|region| corners.iter().all(|x| (0..3).all(|i| (region.low[i]..=region.high[i]).contains(&x[i]))));
    is_inside && load.on.is_none_or(|face| is_face(scene, face, corners)) && !is_axis(scene, corners)
}

/// Returns true if a facet of a section lies on the axis of revolution.
fn is_axis(scene: &Scene, corners: &[Vector3]) -> bool {
    scene.scene.dimension == Dimension::Axisymmetric && corners.iter().all(|x| x.x == 0.0)
}

fn is_face(scene: &Scene, face: GelFace, corners: &[Vector3]) -> bool {
    let all = |is_there: &dyn Fn(&Vector3) -> bool| corners.iter().all(is_there);
    let shape = &scene.gel.shape;
    match face {
        GelFace::XMin => all(&|x| x.x == -half_width(shape, 0)),
        GelFace::XMax => all(&|x| x.x == half_width(shape, 0)),
        GelFace::YMin => all(&|x| x.y == -half_width(shape, 1)),
        GelFace::YMax => all(&|x| x.y == half_width(shape, 1)),
        GelFace::ZMin => all(&|x| x.z == -height(shape)),
        GelFace::ZMax => all(&|x| x.z == 0.0),
        GelFace::Side => is_round(shape, outer_radius(shape), corners),
        GelFace::Inner => is_round(shape, inner_radius(shape), corners),
    }
}

/// Returns true if corners lie on the lateral surface of a cylinder or on a sphere of this radius. The corners of an
/// end face have one height.
fn is_round(shape: &GelShape, radius: f64, corners: &[Vector3]) -> bool {
    let is_sphere = matches!(shape, GelShape::Shell { .. });
    let distance = |x: &Vector3| if is_sphere { x.norm() } else { x.xy().norm() };
    let rises = is_sphere || corners.iter().any(|x| x.z != corners[0].z);
    rises && corners.iter().all(|x| (distance(x) - radius).abs() <= ROUND * radius)
}

/// Half the edge of a block along x or y, m.
fn half_width(shape: &GelShape, axis: usize) -> f64 {
    match shape {
        GelShape::Block { size } => 0.5 * size[axis],
        GelShape::Cylinder { .. } | GelShape::Shell { .. } | GelShape::LBeam { .. } => f64::NAN,
    }
}

/// Height of a block or a cylinder, m.
fn height(shape: &GelShape) -> f64 {
    shape.thickness().unwrap_or(f64::NAN)
}

fn outer_radius(shape: &GelShape) -> f64 {
    match shape {
        GelShape::Cylinder { radius, .. } => *radius,
        GelShape::Shell { outer, .. } => *outer,
        GelShape::Block { .. } | GelShape::LBeam { .. } => f64::NAN,
    }
}

fn inner_radius(shape: &GelShape) -> f64 {
    match shape {
        GelShape::Cylinder { bore, .. } => bore.unwrap_or(f64::NAN),
        GelShape::Shell { inner, .. } => *inner,
        GelShape::Block { .. } | GelShape::LBeam { .. } => f64::NAN,
    }
}

/// Pressures of a scene.
pub(super) fn pressures(scene: &Scene) -> Vec<PressureHistory> {
    scene.load.iter().map(|load| PressureHistory::new(load.history()).below(load.depth)).collect()
}

/// Ramp length of the air in a cavity, relative to the radius of the greatest ball inside the
/// projectile.
const AIR_RAMP: f64 = 0.5;

/// Air in the cavity behind the projectile of a scene, unless it is vented; none for an unbounded body, which leaves no
/// cavity.
pub(super) fn cavity_air(scene: &Scene) -> Option<CavityAir> {
    let (copies, radius) = (scene.gel.symmetry.copies(), scene.shape(0).inner_radius());
    let gauge = scene.gel.cavity.gauge_pressure()? * copies;
    let inflow = scene.gel.cavity.discharge().map(|discharge| AirInflow {
        discharge,
        copies,
        body_volume: scene.volume(0).unwrap_or(0.0),
        exit_area: match scene.scene.dimension {
            Dimension::Planar => 2.0 * radius * scene.thickness(),
            Dimension::Axisymmetric | Dimension::Spatial => std::f64::consts::PI * radius * radius,
        },
    });
    (radius > 0.0 && radius.is_finite()).then_some(CavityAir { gauge, ramp: AIR_RAMP * radius, inflow })
}
