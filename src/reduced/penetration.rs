//! Penetration law: the resistance of the gel to a body with a hemispherical nose that flies along its axis.
//!
//! After Poncelet, a shear part and an inertia part. For a body of section A = πd²/4 at the speed u, its nose at the
//! depth s in a gel of the density ρ and the thickness T,
//!
//!   F = A e(s) [ S xʰ/(1 + xʰ) + ½ ρ u² (C + C_c u/(c + u) + C_e exp(−s/(λ d))) ] + k w,   x = u/(ε d).
//!
//! The shear part is the stress of a dashpot that saturates, as that of the gel does: u/d is the strain rate of the flow. C_e is the added mass
//! that the body sets in motion on its first calibres, ½ C_e λ ρ A d. Behind s = T − d the section in gel fades to
//! nothing over three calibres, e(s). k w is a spring of the stiffness k = A E/(Λ d) that slips at w = Λ d: on the way
//! in it adds A E, and it pushes the body, of the mass m, back once that stands, critically damped: F = k w − 2 √(k m) |u|.

use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Speed c at which half of the growth of the drag is there, m/s. Greatest depths and exit speeds of spheres, fitted, were a
/// fifth and a third nearer than with a growth in proportion to the speed.
const GROWTH_SPEED: f64 = 300.0;
/// Place at which the section in gel begins to fade, in calibres before the back face, and the length over which it does.
/// The forces on spheres are 0.8 of the law in the last half of a calibre, and 0.7 in the first half behind the face.
const EXIT: [f64; 2] = [1.0, 3.0];

/// Coefficients of the penetration law.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct PenetrationLaw {
    /// Stress S at which the shear part saturates in Pa.
    pub shear_stress: f64,
    /// Strain rate ε at which the shear part has half of that stress in 1/s.
    pub shear_rate: f64,
    /// Exponent h of the strain rate.
    pub shear_exponent: f64,
    /// Drag coefficient C of the inertia part.
    pub drag: f64,
    /// Growth C_c of the drag coefficient from low to high speed.
    pub drag_growth: f64,
    /// Additional drag coefficient C_e at the entry.
    pub entry_drag: f64,
    /// Path λ over which the entry drag decays, calibres.
    pub entry_path: f64,
    /// Stress E of the spring in Pa.
    pub spring_stress: f64,
    /// Travel Λ at which the spring slips, calibres.
    pub spring_travel: f64,
}

/// Motion of a nose in the gel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NoseMotion {
    /// Calibre d, m.
    pub diameter: f64,
    /// Density ρ of the gel, kg/m³.
    pub density: f64,
    /// Speed u into the gel, m/s; negative on the way out.
    pub speed: f64,
    /// Depth s of the nose, m.
    pub depth: f64,
    /// Distance s − T behind the back face, m; negative in the gel.
    pub behind: f64,
    /// Travel w of the spring, m.
    pub travel: f64,
    /// Mass m of the body, kg.
    pub mass: f64,
}

/// Resistance of the gel against the motion into it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Resistance {
    /// Force, N.
    pub force: f64,
    /// Derivative of the force by the speed, N·s/m.
    pub slope: f64,
    /// Part of the force that sets gel in motion, N: the energy of the cavity per length of path.
    pub inertia: f64,
}

impl PenetrationLaw {
    /// Returns all coefficients with their keys.
    #[must_use]
    pub fn entries(&self) -> [(&'static str, f64); 9] {
        [
            ("shear_stress", self.shear_stress),
            ("shear_rate", self.shear_rate),
            ("shear_exponent", self.shear_exponent),
            ("drag", self.drag),
            ("drag_growth", self.drag_growth),
            ("entry_drag", self.entry_drag),
            ("entry_path", self.entry_path),
            ("spring_stress", self.spring_stress),
            ("spring_travel", self.spring_travel),
        ]
    }

    /// Returns the travel at which the spring slips, m.
    pub(super) fn slip(&self, diameter: f64) -> f64 {
        self.spring_travel * diameter
    }

    /// Returns the stiffness of the spring, N/m.
    pub(super) fn stiffness(&self, diameter: f64) -> f64 {
        0.25 * PI * diameter * self.spring_stress / self.spring_travel
    }

    /// Returns the resistance to a nose in the gel.
    pub(super) fn resistance(&self, at: &NoseMotion) -> Resistance {
        let stiffness = self.stiffness(at.diameter);
        let spring = stiffness * at.travel;
        if at.speed < 0.0 {
            let damping = 2.0 * (stiffness * at.mass).sqrt();
            return Resistance { force: spring + damping * at.speed, slope: damping, inertia: 0.0 };
        }
        let area = 0.25 * PI * at.diameter * at.diameter * at.section_in_gel();
        let power = libm::pow(at.speed / (self.shear_rate * at.diameter), self.shear_exponent);
        let entry = self.entry_drag * libm::exp(-at.depth.max(0.0) / (self.entry_path * at.diameter));
        let (share, speed) = (at.speed / (GROWTH_SPEED + at.speed), at.speed);
        let drag = self.drag + entry + self.drag_growth * share;
        let inertia = 0.5 * area * at.density * speed * speed * drag;
        let shear = area * self.shear_stress * power / (1.0 + power);
        let stiffening = if at.speed > 0.0 { shear * self.shear_exponent / ((1.0 + power) * at.speed) } else { 0.0 };
        let drag_slope = self.drag_growth * share * (1.0 - share);
        let slope = stiffening + area * at.density * speed * (drag + 0.5 * drag_slope);
        Resistance { force: shear + inertia + spring, slope, inertia }
    }
}

impl NoseMotion {
    /// Returns the part of the section that is in gel near the back face.
    fn section_in_gel(&self) -> f64 {
        let [before, length] = EXIT;
        (1.0 - (self.behind / self.diameter + before) / length).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Coefficients of round figures.
    pub const LAW: PenetrationLaw = PenetrationLaw {
        shear_stress: 1e6,
        shear_rate: 1000.0,
        shear_exponent: 2.0,
        drag: 0.2,
        drag_growth: 0.3,
        entry_drag: 0.5,
        entry_path: 0.4,
        spring_stress: 2e4,
        spring_travel: 1.2,
    };
    const AT: NoseMotion = NoseMotion {
        diameter: 0.008,
        density: 1030.0,
        speed: 200.0,
        depth: 0.02,
        behind: -0.3,
        travel: 0.004,
        mass: 3e-3,
    };

    #[test]
    fn the_slope_is_the_derivative_of_the_force() {
        for speed in [1.0, 30.0, 200.0, 900.0, -2.0] {
            let force = |speed: f64| LAW.resistance(&NoseMotion { speed, ..AT }).force;
            let step = 1e-5 * speed;
            let found = (force(speed + step) - force(speed - step)) / (2.0 * step);
            let slope = LAW.resistance(&NoseMotion { speed, ..AT }).slope;
            assert!((slope / found - 1.0).abs() < 1e-6, "{speed} m/s: {slope} {found}");
        }
    }

    /// Shear with x = 25, inertia with C = 0.2 + 0.3 · 0.4, and no entry drag left.
    #[test]
    fn a_deep_nose_meets_shear_inertia_and_the_slipping_spring() {
        let area = PI * 16e-6;
        let travel = LAW.slip(AT.diameter);
        let found = LAW.resistance(&NoseMotion { travel, depth: 0.2, ..AT });
        let inertia = area * 515.0 * 4e4 * 0.32;
        assert!((found.inertia / inertia - 1.0).abs() < 1e-12, "{found:?}");
        let expected = area * (1e6 * 625.0 / 626.0 + 2e4) + inertia;
        assert!((found.force / expected - 1.0).abs() < 1e-12, "{found:?}, {expected}");
    }

    #[test]
    fn the_section_fades_over_three_calibres_at_the_back_face() {
        let force = |behind: f64| LAW.resistance(&NoseMotion { behind, travel: 0.0, ..AT }).force;
        assert_eq!(force(-0.3), force(-0.008));
        assert!((force(0.004) / force(-0.3) - 0.5).abs() < 1e-12);
        assert_eq!(force(0.016), 0.0);
    }
}
