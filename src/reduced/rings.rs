//! Cavity behind a body: rings of gel that the nose sets in motion as it passes, each opening and falling back by itself.
//!
//! A ring in an unbounded incompressible gel has the energy ½ ρ L (R Ṙ)² 2π + P π R² per length, with a constant pressure
//! P of the wall and a constant logarithm L of the radii: R² is a parabola of time. It starts at the section of the body
//! and turns at the greatest diameter D after the time t_D,
//!
//!   D = d √(q₀ + (u/U (d/8 mm)^m)^n (1 − exp(−s/(λ d)))),   t_D = τ (D/8 mm)^p,
//!
//! both identified; at a depth s of less than λ calibres the ring opens into the crater of the entry. It returns to the section of the body after 2 t_D, closes on along the parabola, and stays open at a
//! part of that section. Neighbours, the surface and the sides of the block do not act on a ring.

use serde::{Deserialize, Serialize};

/// Length d₀ that sizes are relative to, m.
const REFERENCE: f64 = 8e-3;

/// Coefficients of the rings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct RingLaw {
    /// Section q₀ of the ring behind a slow body, relative to that of the body.
    pub slow_section: f64,
    /// Speed U of a body of 8 mm that opens a section as large as its own in m/s.
    pub opening_speed: f64,
    /// Exponent n of the speed.
    pub speed_exponent: f64,
    /// Exponent m of the size.
    pub size_exponent: f64,
    /// Depth λ of the crater of the entry, calibres.
    pub crater_depth: f64,
    /// Time τ in which a ring of 8 mm opens in s.
    pub opening_time: f64,
    /// Exponent p of the diameter in that time.
    pub time_exponent: f64,
    /// Diameter that stays open, relative to that of the body.
    pub rest_diameter: f64,
}

/// Ring of gel that the nose has passed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CavityRing {
    /// Time at which the nose passed, s.
    pub time: f64,
    /// Greatest diameter, m.
    pub greatest: f64,
    /// Time from then to the greatest diameter, s.
    pub opening: f64,
    /// Energy per length of path that the nose left in it, J/m.
    pub energy: f64,
}

/// Nose as it passes a ring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RingStart {
    /// Depth, m.
    pub depth: f64,
    /// Speed, m/s.
    pub speed: f64,
    /// Time, s.
    pub time: f64,
    /// Energy per length that it leaves, J/m.
    pub energy: f64,
}

/// Energy of a ring per length, J/m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct RingEnergy {
    /// Kinetic energy.
    pub kinetic: f64,
    /// Work against the pressure of the wall, to be returned.
    pub stored: f64,
}

impl RingLaw {
    /// Returns all coefficients with their keys.
    #[must_use]
    pub fn entries(&self) -> [(&'static str, f64); 8] {
        [
            ("slow_section", self.slow_section),
            ("opening_speed", self.opening_speed),
            ("speed_exponent", self.speed_exponent),
            ("size_exponent", self.size_exponent),
            ("crater_depth", self.crater_depth),
            ("opening_time", self.opening_time),
            ("time_exponent", self.time_exponent),
            ("rest_diameter", self.rest_diameter),
        ]
    }

    /// Returns the ring that a nose of this diameter, m, leaves as it passes.
    pub(super) fn ring(&self, diameter: f64, nose: &RingStart) -> CavityRing {
        let drive = nose.speed / self.opening_speed * libm::pow(diameter / REFERENCE, self.size_exponent);
        let confined = 1.0 - libm::exp(-nose.depth / (self.crater_depth * diameter));
        let section = self.slow_section.max(1.0) + libm::pow(drive, self.speed_exponent) * confined;
        let greatest = diameter * section.sqrt();
        let opening = self.opening_time * libm::pow(greatest / REFERENCE, self.time_exponent);
        CavityRing { time: nose.time, greatest, opening, energy: nose.energy }
    }

    /// Returns the square of the radius of a ring behind a body of this diameter, m, at a time, s, in m².
    pub(super) fn radius_squared(&self, ring: &CavityRing, diameter: f64, time: f64) -> f64 {
        let (start, top) = (0.25 * diameter * diameter, 0.25 * ring.greatest * ring.greatest);
        let rest = start * self.rest_diameter * self.rest_diameter;
        (top - (top - start) * ring.phase(time).powi(2)).max(rest)
    }

    /// Returns the radial velocity times the radius of a ring, R Ṙ, m²/s.
    pub(super) fn radial_flow(&self, ring: &CavityRing, diameter: f64, time: f64) -> f64 {
        let (start, top) = (0.25 * diameter * diameter, 0.25 * ring.greatest * ring.greatest);
        let is_at_rest = top - (top - start) * ring.phase(time).powi(2) <= start * self.rest_diameter.powi(2);
        if is_at_rest { 0.0 } else { -(top - start) * ring.phase(time) / ring.opening }
    }
}

impl CavityRing {
    /// Returns the time since the greatest diameter relative to that up to it: −1 as the nose passes.
    fn phase(&self, time: f64) -> f64 {
        (time - self.time) / self.opening - 1.0
    }

    /// Returns the energy of the ring: it has given all to heat once it is back at the section of the body.
    pub(super) fn energy_at(&self, time: f64) -> RingEnergy {
        let phase = self.phase(time);
        if phase >= 1.0 {
            return RingEnergy::default();
        }
        let moving = phase * phase;
        RingEnergy { kinetic: moving * self.energy, stored: (1.0 - moving) * self.energy }
    }

    /// Returns true if all numbers are finite and the ring opens.
    pub(super) fn is_valid(&self) -> bool {
        let Self { time, greatest, opening, energy } = self;
        [time, greatest, opening, energy].iter().all(|x| x.is_finite()) && *opening > 0.0 && *greatest >= 0.0
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub const LAW: RingLaw = RingLaw {
        slow_section: 1.2,
        opening_speed: 100.0,
        speed_exponent: 2.0,
        size_exponent: 0.5,
        crater_depth: 2.0,
        opening_time: 1e-3,
        time_exponent: 1.0,
        rest_diameter: 0.8,
    };

    const DEEP: RingStart = RingStart { depth: 1.0, speed: 200.0, time: 0.0, energy: 50.0 };

    #[test]
    fn rings_near_the_entry_are_narrower() {
        let at = |depth: f64| LAW.ring(6e-3, &RingStart { depth, ..DEEP }).greatest;
        assert!(at(0.0) < at(6e-3) && at(6e-3) < at(0.1));
        assert!((at(0.0) / (6e-3 * 1.2_f64.sqrt()) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_ring_opens_from_the_section_of_the_body_and_falls_back_to_it() {
        let ring = LAW.ring(8e-3, &RingStart { depth: 1.0, speed: 300.0, time: 1e-3, energy: 50.0 });
        assert!((ring.greatest / (8e-3 * 10.2_f64.sqrt()) - 1.0).abs() < 1e-12, "{ring:?}");
        let radius = |share: f64| LAW.radius_squared(&ring, 8e-3, ring.time + share * ring.opening).sqrt();
        assert!((radius(0.0) - 4e-3).abs() < 1e-12 && (radius(2.0) - 4e-3).abs() < 1e-12);
        assert!((2.0 * radius(1.0) - ring.greatest).abs() < 1e-12);
        assert!((radius(9.0) - 3.2e-3).abs() < 1e-12, "the track stays");
    }

    #[test]
    fn the_flow_is_half_the_derivative_of_the_squared_radius() {
        let ring = LAW.ring(6e-3, &DEEP);
        for share in [0.1, 0.7, 1.4, 5.0] {
            let (time, step) = (share * ring.opening, 1e-9);
            let squared = |time: f64| LAW.radius_squared(&ring, 6e-3, time);
            let found = (squared(time + step) - squared(time - step)) / (4.0 * step);
            let flow = LAW.radial_flow(&ring, 6e-3, time);
            assert!((flow - found).abs() < 1e-6 * (1.0 + flow.abs()), "{share}: {flow} {found}");
        }
    }

    #[test]
    fn energy_goes_from_motion_to_the_wall_and_back_and_is_spent() {
        let ring = LAW.ring(6e-3, &DEEP);
        let at = |share: f64| ring.energy_at(share * ring.opening);
        assert_eq!(at(0.0), RingEnergy { kinetic: 50.0, stored: 0.0 });
        assert_eq!(at(1.0), RingEnergy { kinetic: 0.0, stored: 50.0 });
        assert!((at(0.5).kinetic + at(0.5).stored - 50.0).abs() < 1e-12);
        assert_eq!(at(2.0), RingEnergy::default());
    }
}
