//! Structured grids of a scene, and the first mesh made of them.

use super::build_error::BuildError;
use crate::math::{Vector, Vector3};
use crate::mesh::{self, BlockSpec, CellSplit, FaceConstraint, HeldFace, Mesh};
use crate::scene::{self, CellLattice, FaceSupport, GelShape, Scene};

/// Greatest number of cells that is built: some 24 million tetrahedra in 10 GB.
const MOST_CELLS: f64 = 2e6;
/// Greatest number of cells along an axis if all had the least size.
const MOST_PLANES: f64 = 1e5;
/// Refuses more planes along an axis than can be numbered.
pub(super) fn check_planes(scene: &Scene) -> Result<(), BuildError> {
    let planes = longest_dimension(&scene.gel.shape) / scene.mesh.size;
    if planes > MOST_PLANES {
        return Err(BuildError::TooFine { edges: planes, limit: MOST_PLANES });
    }
    Ok(())
}

fn longest_dimension(shape: &GelShape) -> f64 {
    match shape {
        GelShape::Block { size } => size.iter().copied().fold(0.0, f64::max),
        GelShape::Cylinder { radius, height, .. } => height.max(2.0 * radius),
        GelShape::Shell { outer, .. } => *outer,
        GelShape::LBeam { leg, width, .. } => leg.max(width.unwrap_or(0.0)),
    }
}

pub(super) fn plane_mesh(scene: &Scene) -> Result<Mesh<2>, BuildError> {
    let block = plane_block(scene);
    n_cells(&block)?;
    Ok(match &scene.gel.shape {
        GelShape::LBeam { thickness, angle, corner, .. } => {
            mesh::l_beam(block, *thickness, (*angle, Vector::<2>::new(corner[0], corner[2])))
        }
        GelShape::Block { .. } | GelShape::Cylinder { .. } | GelShape::Shell { .. } => mesh::block(block),
    })
}

/// Structured grid of a planar gel; that of the square around the legs of a beam.
pub(super) fn plane_block(scene: &Scene) -> BlockSpec<2> {
    match &scene.gel.shape {
        GelShape::LBeam { leg, thickness, .. } => {
            let planes = leg_planes(scene, *leg, *thickness);
            BlockSpec { planes: [planes.clone(), planes], split: cell_division(scene), faces: vec![] }
        }
        GelShape::Block { size } => {
            let planes = [centred_planes(scene, 0.5 * size[0]), depth_planes(scene, size[1])];
            let s = &scene.gel.supports;
            BlockSpec {
                planes,
                split: cell_division(scene),
                faces: supported_faces([(0, s.x_min, s.x_max), (1, s.z_min, s.z_max)]),
            }
        }
        GelShape::Cylinder { .. } | GelShape::Shell { .. } => {
            unreachable!("a planar gel is a block or an l-beam: the scene was checked")
        }
    }
}

pub(super) fn section_mesh(scene: &Scene) -> Result<Mesh<2>, BuildError> {
    let block = section_block(scene);
    n_cells(&block)?;
    Ok(if matches!(scene.gel.shape, GelShape::Shell { .. }) { mesh::shell(block) } else { mesh::block(block) })
}

/// Structured grid of the section of an axisymmetric gel; in radius and angle for a shell.
pub(super) fn section_block(scene: &Scene) -> BlockSpec<2> {
    let s = &scene.gel.supports;
    match scene.gel.shape {
        GelShape::Cylinder { radius, height, bore } => {
            let across =
                bore.map_or_else(|| axis_planes(scene, radius), |bore| mesh::uniform(bore, radius, scene.mesh.size));
            let wall = if bore.is_none() { FaceSupport::Roller } else { FaceSupport::Free };
            let faces = supported_faces([(0, wall, s.side), (1, s.z_min, s.z_max)]);
            BlockSpec { planes: [across, depth_planes(scene, height)], split: cell_division(scene), faces }
        }
        GelShape::Shell { inner, outer } => {
            let planes = mesh::shell_planes([inner, outer], scene.mesh.size);
            let faces = supported_faces([(0, FaceSupport::Free, s.side), (1, FaceSupport::Roller, s.z_max)]);
            BlockSpec { planes, split: cell_division(scene), faces }
        }
        GelShape::Block { .. } | GelShape::LBeam { .. } => {
            unreachable!("an axisymmetric gel is a cylinder or a shell: the scene was checked")
        }
    }
}

pub(super) fn space_mesh(scene: &Scene) -> Result<Mesh<3>, BuildError> {
    let block = space_block(scene);
    n_cells(&block)?;
    Ok(match &scene.gel.shape {
        GelShape::Block { .. } | GelShape::Shell { .. } => mesh::block(block),
        GelShape::Cylinder { radius, .. } => mesh::cylinder(*radius, block),
        GelShape::LBeam { thickness, angle, corner, .. } => {
            mesh::l_beam(block, *thickness, (*angle, Vector3::from(*corner)))
        }
    })
}

/// Structured grid of a spatial gel; that of the square around a cylinder or around the legs of a beam.
pub(super) fn space_block(scene: &Scene) -> BlockSpec<3> {
    let s = &scene.gel.supports;
    match &scene.gel.shape {
        GelShape::Block { size } => {
            let mirrored = |axis: usize| scene.gel.symmetry.mirrored().contains(&axis);
            let side = |i: usize, low, high| {
                let half = 0.5 * size[i];
                let planes = if mirrored(i) { axis_planes(scene, half) } else { centred_planes(scene, half) };
                (planes, (i, if mirrored(i) { FaceSupport::Roller } else { low }, high))
            };
            let ((x, across), (y, along)) = (side(0, s.x_min, s.x_max), side(1, s.y_min, s.y_max));
            let planes = [x, y, depth_planes(scene, size[2])];
            BlockSpec {
                planes,
                split: cell_division(scene),
                faces: supported_faces([across, along, (2, s.z_min, s.z_max)]),
            }
        }
        GelShape::Shell { .. } => unreachable!("a spatial gel is no shell: the scene was checked"),
        GelShape::Cylinder { radius, height, .. } => {
            let planes = [centred_planes(scene, *radius), centred_planes(scene, *radius), depth_planes(scene, *height)];
            let faces = supported_faces([(0, FaceSupport::Free, s.side), (2, s.z_min, s.z_max)]);
            BlockSpec { planes, split: cell_division(scene), faces }
        }
        GelShape::LBeam { leg, thickness, width, .. } => {
            let half = 0.5 * width.unwrap_or(*thickness);
            let planes = leg_planes(scene, *leg, *thickness);
            let width = mesh::uniform(-half, half, scene.mesh.size);
            BlockSpec { planes: [planes.clone(), width, planes], split: cell_division(scene), faces: vec![] }
        }
    }
}

/// Number of cells of a grid. A tree is counted before it is balanced, and no further than the greatest number that
/// is built.
///
/// # Errors
/// [`BuildError::TooLarge`] for more cells than a process can hold.
pub(super) fn n_cells<const D: usize>(block: &BlockSpec<D>) -> Result<f64, BuildError> {
    let cells = match block.split {
        CellSplit::Centred | CellSplit::Kuhn => block.planes.iter().map(|p| p.len() as f64 - 1.0).product(),
        CellSplit::Tree(tree) => tree.count(&block.planes, MOST_CELLS as usize + 1) as f64,
    };
    if cells > MOST_CELLS { Err(BuildError::TooLarge { cells, limit: MOST_CELLS }) } else { Ok(cells) }
}

fn cell_division(scene: &Scene) -> CellSplit {
    match (scene.mesh.tree, scene.mesh.lattice) {
        (Some(scene::OctreeSpec { coarsest, core, slope }), _) => {
            CellSplit::Tree(mesh::OctreeGrading { coarsest, core, slope })
        }
        (None, CellLattice::Centred) => CellSplit::Centred,
        (None, CellLattice::Kuhn) => CellSplit::Kuhn,
    }
}

/// Supports of the low and high face of each axis.
fn supported_faces<const N: usize>(sides: [(usize, FaceSupport, FaceSupport); N]) -> Vec<HeldFace> {
    let hold = |support| match support {
        FaceSupport::Free => None,
        FaceSupport::Roller => Some(FaceConstraint::Normal),
        FaceSupport::Fixed => Some(FaceConstraint::All),
    };
    let ends = sides.into_iter().flat_map(|(axis, low, high)| [(axis, false, low), (axis, true, high)]);
    ends.filter_map(|(axis, high, support)| hold(support).map(|hold| HeldFace { axis, high, hold })).collect()
}

/// Planes from 0 to `length`.
fn axis_planes(scene: &Scene, length: f64) -> Vec<f64> {
    let size = scene.mesh.size;
    match (scene.mesh.grading, scene.mesh.tree) {
        (Some(grading), _) => mesh::graded(length, size, (grading.core, grading.growth, grading.largest)),
        (None, Some(tree)) => mesh::uniform_divisible(length, size, tree.coarsest),
        (None, None) => mesh::uniform(0.0, length, size),
    }
}

/// Planes from −`half` to `half`, with a plane at 0 if graded.
fn centred_planes(scene: &Scene, half: f64) -> Vec<f64> {
    if scene.mesh.grading.is_none() && scene.mesh.tree.is_none() {
        return mesh::uniform(-half, half, scene.mesh.size);
    }
    let right = axis_planes(scene, half);
    right.iter().rev().map(|x| -x).chain(right.iter().skip(1).copied()).collect()
}

/// Planes from −`height` to the entry surface at 0, one of them at each interface of the layers.
fn depth_planes(scene: &Scene, height: f64) -> Vec<f64> {
    let (planes, layers) = (axis_planes(scene, height), scene::layer_stack(&scene.layer, &scene.gel));
    let depths = match &layers {
        Some(layers) => follow_interfaces(&planes, layers.depths()),
        None => planes,
    };
    depths.iter().rev().map(|z| -z).collect()
}

/// Moves planes so that each interface lies on one of them, bit for bit; those between two interfaces in proportion.
///
/// A layer takes the cells nearest to its thickness, but at least one, and leaves one for each material below it: on
/// uniform planes its cells are then two thirds to one and a half of the others. The number of planes stays, as a tree
/// needs it, unless there are fewer cells than materials. Large cells of a tree do not use all planes: where such a cell
/// spans an interface, its elements are mixtures.
fn follow_interfaces(planes: &[f64], interfaces: &[f64]) -> Vec<f64> {
    let n_cells = planes.len() - 1;
    let last = planes[n_cells];
    if n_cells <= interfaces.len() {
        return std::iter::once(planes[0]).chain(interfaces.iter().copied()).chain([last]).collect();
    }
    let mut moved = vec![planes[0]];
    for (i, &depth) in interfaces.iter().enumerate() {
        let above = moved.len() - 1;
        let unmoved = planes[above] + depth - moved[above];
        let next = planes.partition_point(|z| *z < unmoved).clamp(1, n_cells);
        let is_nearer = unmoved - planes[next - 1] <= planes[next] - unmoved;
        let nearest = if is_nearer { next - 1 } else { next };
        append_scaled(&mut moved, &planes[above..=nearest.clamp(above + 1, n_cells + i - interfaces.len())], depth);
    }
    let above = moved.len() - 1;
    append_scaled(&mut moved, &planes[above..], last);
    moved
}

/// Appends planes behind the first of them, with equal ratios of their distances, from the last plane up to `end`.
fn append_scaled(moved: &mut Vec<f64>, planes: &[f64], end: f64) {
    let (start, first, n) = (moved[moved.len() - 1], planes[0], planes.len() - 1);
    let scale = (end - start) / (planes[n] - first);
    moved.extend(planes[1..n].iter().map(|z| start + (z - first) * scale));
    moved.push(end);
}

/// Planes along a leg, one of them at its thickness.
fn leg_planes(scene: &Scene, leg: f64, thickness: f64) -> Vec<f64> {
    let mut planes = mesh::uniform(0.0, thickness, scene.mesh.size);
    planes.extend(mesh::uniform(thickness, leg, scene.mesh.size).into_iter().skip(1));
    planes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Override, builtin, read, resolve};

    fn scene_with(name: &str, changes: &[&str]) -> Scene {
        let changes: Vec<Override> = changes.iter().map(|change| change.parse().unwrap()).collect();
        read(&resolve(builtin(name).unwrap(), &changes).unwrap()).unwrap()
    }

    #[test]
    fn planes_follow_interfaces_to_the_bit_and_keep_their_number() {
        let planes = mesh::uniform(0.0, 0.1, 1e-3);
        for interfaces in [&[1.7e-3][..], &[1e-3, 2e-3, 3e-3], &[1.51e-3, 3.49e-3], &[0.0973, 0.0983], &[0.05]] {
            let moved = follow_interfaces(&planes, interfaces);
            assert_eq!((moved.len(), moved[0], moved[100]), (101, 0.0, 0.1));
            assert!(interfaces.iter().all(|depth| moved.contains(depth)), "{interfaces:?}");
            let longest = moved.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
            assert!(moved.windows(2).all(|pair| pair[1] > pair[0]) && longest <= 1.6e-3, "{interfaces:?}: {longest}");
        }
        assert_eq!(follow_interfaces(&[0.0, 1.0, 2.0, 4.0], &[1.5]), [0.0, 1.5, 2.333_333_333_333_333_5, 4.0]);
        assert_eq!(follow_interfaces(&[0.0, 1.0, 2.0, 4.0], &[1.75]), [0.0, 0.875, 1.75, 4.0]);
    }

    #[test]
    fn each_layer_has_a_cell_where_cells_grow() {
        assert_eq!(follow_interfaces(&[0.0, 1.0, 5.0, 21.0], &[1.0, 2.0]), [0.0, 1.0, 2.0, 21.0]);
        assert_eq!(follow_interfaces(&[0.0, 1.0, 21.0], &[1.0, 2.0]), [0.0, 1.0, 2.0, 21.0]);
        assert_eq!(follow_interfaces(&[0.0, 10.0, 20.0], &[19.0]), [0.0, 19.0, 20.0]);
    }

    #[test]
    fn the_planes_of_every_shape_follow_its_layers() {
        let layers = "layer=[{thickness=5e-3, density=900.0}, {thickness=7.3e-3, density=1100.0}]";
        let depths = [5e-3, 5e-3 + 7.3e-3].map(|depth: f64| -depth);
        let has_all = |planes: &[f64]| depths.iter().all(|depth| planes.contains(depth));
        let grading = "mesh.grading={core=0.01, growth=1.5, largest=0.02}";
        for (name, change) in
            [("sphere-block", "mesh.size=4e-3"), ("sphere-block", grading), ("fbi-bb-3d", "mesh.size=1e-3")]
        {
            let [bare, layered] = [&[change][..], &[change, layers]].map(|set| space_block(&scene_with(name, set)));
            assert_eq!((&bare.planes[..2], bare.planes[2].len()), (&layered.planes[..2], layered.planes[2].len()));
            assert!(has_all(&layered.planes[2]) && !has_all(&bare.planes[2]), "{name} {change}");
        }
        assert!(has_all(&section_block(&scene_with("fbi-bb", &[layers])).planes[1]));
        assert!(has_all(&plane_block(&scene_with("ball-square", &[layers])).planes[1]));
    }

    /// In space those that join the centres of cells on both sides do, unless the cells are divided by Kuhn.
    #[test]
    fn triangles_do_not_cross_an_interface_and_a_sixth_of_the_cells_on_both_sides_does() {
        let layer = "layer=[{thickness=7.3e-3, density=900.0}]";
        let plane = plane_mesh(&scene_with("ball-square", &[layer])).unwrap();
        assert!(plane.elements.len() > 100 && crossing_volume(&plane) == 0.0);
        let [centred, kuhn] = ["centred", "kuhn"].map(|lattice| {
            let scene = scene_with("sphere-block", &[layer, "mesh.size=7e-3", &format!("mesh.lattice={lattice}")]);
            crossing_volume(&space_mesh(&scene).unwrap())
        });
        assert_eq!(kuhn, 0.0);
        let block = space_block(&scene_with("sphere-block", &[layer, "mesh.size=7e-3"]));
        let [x, y, z] = block.planes;
        let below = z[z.len() - 2] - z[z.len() - 3];
        let expected = (x[x.len() - 1] - x[0]) * (y[y.len() - 1] - y[0]) * (7.3e-3 + below) / 6.0;
        assert!((centred / expected - 1.0).abs() < 1e-9, "{centred} {expected}");
    }

    /// Volume of the elements on both sides of a depth of 7.3 mm.
    fn crossing_volume<const D: usize>(mesh: &Mesh<D>) -> f64 {
        let crosses = |element: &&mesh::Simplex| {
            let heights = || element[..=D].iter().map(|node| mesh.rest[node.index()][D - 1]);
            heights().any(|z| z > -7.3e-3) && heights().any(|z| z < -7.3e-3)
        };
        mesh.elements.iter().filter(crosses).map(|element| mesh.measure(element)).sum()
    }
}
