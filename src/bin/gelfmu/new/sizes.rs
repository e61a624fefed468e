//! Sizes of mesh and remeshing of a shot, by level, in radii of the projectile.

use super::shot::{MeshedPart, Shot};
use crate::rounding::rounded;

/// Sizes of one level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelSizes {
    /// Name of the level.
    pub level: &'static str,
    /// Finest cells of the first mesh, m.
    pub size: f64,
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

/// Levels about an axis: those of `fbi-bb`, whose error is measured (`gelfmu trade fbi-bb`).
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

impl LevelSizes {
    /// Sizes of all levels of a shot, from the cheapest; the third is `standard`.
    pub fn of(shot: &Shot) -> Vec<Self> {
        let radius = shot.radius();
        if shot.meshed_part() == MeshedPart::Meridian {
            return ABOUT_AXIS.iter().map(|ratios| about_axis(ratios, radius)).collect();
        }
        IN_SPACE.iter().map(|ratios| in_space(ratios, radius, shot.tip_radius())).collect()
    }

    /// Overrides that make this level of a scene at `standard`.
    pub fn overrides(&self) -> Vec<String> {
        let Self { size, slope, smallest, growth, tip_size, erosion_thickness, .. } = self;
        let mut set = vec![
            format!("mesh.size={size:?}"),
            format!("mesh.tree.slope={slope:?}"),
            format!("remesh.smallest={smallest:?}"),
            format!("remesh.growth={growth:?}"),
            format!("remesh.erosion_thickness={erosion_thickness:?}"),
        ];
        set.extend(tip_size.map(|size| format!("remesh.tip_size={size:?}")));
        set
    }
}

fn about_axis(ratios: &LevelRatios, radius: f64) -> LevelSizes {
    let &LevelRatios { level, cells_per_radius, slope, growth } = ratios;
    let size = radius / cells_per_radius;
    let [size, smallest, erosion_thickness] = [size, 0.5 * size, radius / 109.0].map(rounded);
    LevelSizes { level, size, slope, smallest, growth, tip_size: None, erosion_thickness }
}

/// In space the least target edge is two thirds of a cell, and that at a slender tip the radius of the tip by the cells
/// of half a radius.
fn in_space(ratios: &LevelRatios, radius: f64, tip_radius: Option<f64>) -> LevelSizes {
    let &LevelRatios { level, cells_per_radius, slope, growth } = ratios;
    let size = radius / cells_per_radius;
    let tip_size = tip_radius.map(|tip| rounded((2.0 * tip / cells_per_radius).min(size / 1.5)));
    let [size, smallest, erosion_thickness] = [size, size / 1.5, 0.36 * size].map(rounded);
    LevelSizes { level, size, slope, smallest, growth, tip_size, erosion_thickness }
}
