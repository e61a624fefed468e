//! Pressures on faces of the gel: their histories, and the facets on which they act.

use crate::fem::Section;
use crate::mesh::{CAVITY_MARK, ElementId, Facet};

/// Pressure history: linear between its points, constant before the first and after the last, with the depth below
/// which all of it acts.
#[derive(Debug, Clone, PartialEq)]
pub struct PressureHistory {
    /// Times, s, and pressures, Pa.
    points: Vec<(f64, f64)>,
    /// Depth below z = 0 in the frame of the block, over which the pressure rises from zero, m; 0 if it acts at any
    /// height.
    depth: f64,
}

impl PressureHistory {
    /// Creates a pressure from ascending times, s, and the pressures there, Pa.
    ///
    /// # Panics
    /// If there is no point or the times do not ascend.
    #[must_use]
    pub fn new(points: Vec<(f64, f64)>) -> Self {
        let ascending = points.windows(2).all(|pair| pair[0].0 < pair[1].0);
        assert!(!points.is_empty() && ascending, "a pressure has points whose times ascend");
        Self { points, depth: 0.0 }
    }

    /// Sets the depth, m, over which the pressure rises from zero at z = 0.
    #[must_use]
    pub fn below(self, depth: f64) -> Self {
        Self { depth, ..self }
    }

    /// Returns the pressure at a time, s, in Pa.
    #[must_use]
    pub fn at(&self, time: f64) -> f64 {
        let after = self.points.partition_point(|(t, _)| *t <= time);
        let [before, next] = [after.saturating_sub(1), after.min(self.points.len() - 1)].map(|i| self.points[i]);
        if before.0 < next.0 && time > before.0 {
            before.1 + (next.1 - before.1) * ((time - before.0) / (next.0 - before.0))
        } else {
            before.1
        }
    }

    /// Returns the fraction of the pressure that acts at a height z, m, and its derivative with respect to depth,
    /// 1/m.
    fn part(&self, z: f64) -> (f64, f64) {
        match -z / self.depth {
            _ if self.depth == 0.0 => (1.0, 0.0),
            part if part > 0.0 && part < 1.0 => (part, 1.0 / self.depth),
            part => (if part >= 1.0 { 1.0 } else { 0.0 }, 0.0),
        }
    }
}

/// Facet under pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadedFacet {
    /// Nodes of the facet, outward oriented.
    pub facet: Facet,
    /// Element that the facet bounds.
    pub behind: ElementId,
    /// Bit set of the pressures that act: bit i for the i-th.
    pub mark: u8,
}

impl LoadedFacet {
    /// Returns true if the facet belongs to the wall of the cavity once it lies deep.
    pub(super) fn can_bound_cavity(&self) -> bool {
        self.mark & CAVITY_MARK != 0
    }
}

/// Air in the cavity behind the projectile, body 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CavityAir {
    /// Gauge pressure in a sealed cavity, Pa, that of a vacuum where air flows in; scaled by the number of symmetric
    /// copies: positive pushes the wall outwards.
    pub gauge: f64,
    /// Ramp length δ below z = 0 over which the pressure rises, m: by the depth of the wall, and by that of the rear of
    /// the projectile.
    pub ramp: f64,
    /// Flow of air into the cavity; none into a sealed one.
    pub inflow: Option<AirInflow>,
}

/// Flow of air into the cavity behind the projectile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AirInflow {
    /// Discharge coefficient C_d of the openings.
    pub discharge: f64,
    /// Number of symmetric copies of the computed part.
    pub copies: f64,
    /// Volume of the projectile, m³.
    pub body_volume: f64,
    /// Area of the opening that a perforation leaves, m².
    pub exit_area: f64,
}

/// Pressure loads of a gel.
#[derive(Debug, Clone, PartialEq)]
pub struct PressureLoads {
    /// Kinematics of the gel, which tell the area that a plane facet stands for.
    pub section: Section,
    /// Pressure histories.
    pub pressures: Vec<PressureHistory>,
    /// Air in the cavity; it acts on the facets with [`CAVITY_MARK`].
    pub air: Option<CavityAir>,
    /// Loaded facets.
    pub facets: Vec<LoadedFacet>,
}

impl PressureLoads {
    /// Creates a set of no loads.
    #[must_use]
    pub fn none() -> Self {
        Self { section: Section::Spatial, pressures: vec![], air: None, facets: vec![] }
    }

    /// Returns the sum of the marked pressures at a height z, m, in Pa, and the sum of their derivatives with respect
    /// to depth, Pa/m.
    pub(super) fn pressure(&self, mark: u8, now: &[f64], z: f64) -> (f64, f64) {
        let named = (0..self.pressures.len()).filter(|i| mark >> i & 1 == 1);
        named.fold((0.0, 0.0), |(sum, growth), i| {
            let (part, steepness) = self.pressures[i].part(z);
            (sum + part * now[i], growth + steepness * now[i].abs())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pressure_is_straight_between_its_points_and_constant_outside() {
        let pressure = PressureHistory::new(vec![(1.0, 10.0), (2.0, 30.0), (4.0, 0.0)]);
        let found = [0.0, 1.0, 1.5, 2.0, 3.0, 4.0, 9.0].map(|time| pressure.at(time));
        assert_eq!(found, [10.0, 10.0, 20.0, 30.0, 15.0, 0.0, 0.0]);
    }

    #[test]
    fn a_pressure_below_a_depth_rises_from_nothing_at_the_surface() {
        let pressure = PressureHistory::new(vec![(0.0, 8.0)]).below(0.25);
        let found = [1.0, 0.0, -0.125, -0.25, -3.0].map(|z| pressure.part(z));
        assert_eq!(found, [(0.0, 0.0), (0.0, 0.0), (0.5, 4.0), (1.0, 0.0), (1.0, 0.0)]);
        assert_eq!(PressureHistory::new(vec![(0.0, 8.0)]).part(1.0), (1.0, 0.0));
    }
}
