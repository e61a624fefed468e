//! Sizes of mesh and remeshing of a shot, by level, in radii of the projectile.

use super::block::MeshedPart;
use super::shot::Shot;
use crate::rounding::rounded;

/// Sizes of one level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelSizes {
    /// Name of the level.
    pub level: &'static str,
    /// Finest cells of the first mesh, m.
    pub size: f64,
    /// Edge of the largest cells of the first mesh, in finest ones: a power of two.
    pub coarsest: usize,
    /// Growth of the cells with the distance from the point of entry.
    pub slope: f64,
    /// Least target edge of remeshing, m.
    pub smallest: f64,
    /// Growth of the target edge with the distance.
    pub growth: f64,
    /// Target edge at the tip of a slender nose, m.
    pub tip_size: Option<f64>,
    /// Thickness below which sheets are eroded, m.
    pub erosion_thickness: f64,
}

/// Cells per radius, slope and growth of a level.
struct LevelRatios {
    level: &'static str,
    cells_per_radius: f64,
    slope: f64,
    growth: f64,
}

/// Levels about an axis: those of `fbi-bb`, whose error is measured (`python -m ballistic_gel trade fbi-bb`).
const ABOUT_AXIS: [LevelRatios; 4] = [
    LevelRatios { level: "draft", cells_per_radius: 2.86, slope: 0.4243, growth: 0.2828 },
    LevelRatios { level: "coarse", cells_per_radius: 4.05, slope: 0.3, growth: 0.2 },
    LevelRatios { level: "standard", cells_per_radius: 8.1, slope: 0.15, growth: 0.1 },
    LevelRatios { level: "fine", cells_per_radius: 11.45, slope: 0.1061, growth: 0.07071 },
];

/// Levels in space: what a tumbling bullet costs bounds them (`docs/shots.md`).
const IN_SPACE: [LevelRatios; 4] = [
    LevelRatios { level: "draft", cells_per_radius: 2.0, slope: 0.4, growth: 0.4 },
    LevelRatios { level: "coarse", cells_per_radius: 3.0, slope: 0.3, growth: 0.3 },
    LevelRatios { level: "standard", cells_per_radius: 4.0, slope: 0.25, growth: 0.25 },
    LevelRatios { level: "fine", cells_per_radius: 6.0, slope: 0.2, growth: 0.2 },
];

/// Index of `standard` among the levels.
pub const STANDARD: usize = 2;
/// Edge of the largest cells, in finest ones, unless the block is too small or too large for it.
const USUAL_COARSEST: usize = 16;
/// Greatest number of largest cells in the meshed part: a third more than the smallest fragment has in 40 cm at `fine`.
/// Beyond it cells far from the path, which nothing reaches, would be the most of the mesh.
const MOST_LARGEST: f64 = 6e4;

impl LevelSizes {
    /// Sizes of all levels of a shot, from the cheapest.
    pub fn of(shot: &Shot) -> Vec<Self> {
        let is_axial = shot.meshed_part() == MeshedPart::Meridian;
        let ratios = if is_axial { &ABOUT_AXIS } else { &IN_SPACE };
        ratios.iter().map(|ratios| if is_axial { about_axis(ratios, shot) } else { in_space(ratios, shot) }).collect()
    }

    /// Overrides that make this level of a scene at `standard`.
    pub fn overrides(&self, standard: &Self) -> Vec<String> {
        let Self { size, coarsest, slope, smallest, growth, tip_size, erosion_thickness, .. } = self;
        let mut set = vec![format!("mesh.size={size:?}"), format!("mesh.tree.slope={slope:?}")];
        set.extend((*coarsest != standard.coarsest).then(|| format!("mesh.tree.coarsest={coarsest}")));
        set.extend([
            format!("remesh.smallest={smallest:?}"),
            format!("remesh.growth={growth:?}"),
            format!("remesh.erosion_thickness={erosion_thickness:?}"),
        ]);
        set.extend(tip_size.map(|size| format!("remesh.tip_size={size:?}")));
        set
    }
}

fn about_axis(ratios: &LevelRatios, shot: &Shot) -> LevelSizes {
    let &LevelRatios { level, cells_per_radius, slope, growth } = ratios;
    let size = shot.radius() / cells_per_radius;
    let coarsest = largest_cells(shot, size);
    let [size, smallest, erosion_thickness] = [size, 0.5 * size, shot.radius() / 109.0].map(rounded);
    LevelSizes { level, size, coarsest, slope, smallest, growth, tip_size: None, erosion_thickness }
}

/// In space the least target edge is two thirds of a cell, and that at a slender tip the radius of the tip by the cells
/// of half a radius.
fn in_space(ratios: &LevelRatios, shot: &Shot) -> LevelSizes {
    let &LevelRatios { level, cells_per_radius, slope, growth } = ratios;
    let size = shot.radius() / cells_per_radius;
    let coarsest = largest_cells(shot, size);
    let tip_size = shot.tip_radius().map(|tip| rounded((2.0 * tip / cells_per_radius).min(size / 1.5)));
    let [size, smallest, erosion_thickness] = [size, size / 1.5, 0.36 * size].map(rounded);
    LevelSizes { level, size, coarsest, slope, smallest, growth, tip_size, erosion_thickness }
}

/// Edge of the largest cells, in finest ones: no longer than the way from the path to a face, and few enough.
fn largest_cells(shot: &Shot, size: f64) -> usize {
    let fits = |coarsest: usize| coarsest as f64 * rounded(size) <= shot.way_to_face();
    let is_few = |coarsest: usize| shot.n_cells(coarsest as f64 * size) <= MOST_LARGEST;
    let mut coarsest = USUAL_COARSEST;
    while coarsest > 2 && !fits(coarsest) {
        coarsest /= 2;
    }
    while !is_few(coarsest) && fits(2 * coarsest) {
        coarsest *= 2;
    }
    coarsest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::new::{BlockSize, named_projectile, scene_text};
    use ballistic_gel::scene::{self, Preset};
    use ballistic_gel::simulation::memory_estimate;

    fn shot(name: &str, roll: f64, edges: [f64; 3]) -> Shot {
        let projectile = named_projectile(name).unwrap();
        let ([width, height, length], speed) = (edges, projectile.speed);
        let yaw = if roll == 0.0 { 0.0 } else { 2.0 };
        let block = BlockSize { width, height, length };
        Shot { projectile, speed, yaw, roll, block, gel: Preset::Gelatin10, layers: vec![], arrival: None }
    }

    #[test]
    fn every_level_of_a_shot_has_a_mesh_in_any_block() {
        let shots = [("bb", 0.0), ("45acp-185-silvertip-recovered", 0.0), ("fsp-0.16g", 0.0), ("9mm-fmj", 45.0)];
        for ((name, roll), edges) in
            shots.into_iter().flat_map(|shot| [[0.044; 3], [0.1; 3], [3.0; 3]].map(|e| (shot, e)))
        {
            let text = scene_text(&shot(name, roll, edges)).unwrap();
            // Large cells do not fit into a small block, small ones into the memory for a large one.
            let levels: &[&str] = if edges[0] > 1.0 { &["fine"] } else { &["draft", "coarse", "standard"] };
            for level in levels {
                let text = scene::resolve(&text, &[format!("scene.fidelity={level}").parse().unwrap()]).unwrap();
                let scene = scene::read(&text).unwrap_or_else(|error| panic!("{name} {edges:?} {level}: {error}"));
                let memory =
                    memory_estimate(&scene).unwrap_or_else(|error| panic!("{name} {edges:?} {level}: {error}"));
                assert!(memory.building < 4_000_000_000, "{name} {edges:?} {level}: {memory:?}");
            }
        }
    }

    #[test]
    fn cells_of_a_usual_block_grow_sixteenfold() {
        for (name, roll) in [("bb", 0.0), ("45acp-185-silvertip-recovered", 0.0), ("fsp-0.16g", 0.0), ("762-m80", 45.0)]
        {
            let sizes = LevelSizes::of(&shot(name, roll, [0.15, 0.15, 0.4]));
            assert!(sizes.iter().all(|level| level.coarsest == USUAL_COARSEST), "{name}: {sizes:?}");
        }
    }
}
