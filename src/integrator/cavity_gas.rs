//! Air that flows into the cavity behind the projectile, through its entry and a perforated exit.
//!
//! The air is an ideal gas of one pressure p in the cavity. Its energy p V/(γ − 1) loses the work on the wall and gains
//! the enthalpy of the air that flows in from rest,
//!
//!   dp/dt = γ/V [p₀ C_d A √(R T₀) ψ(p/p₀) − p dV/dt],   ψ(r) = √{2γ/(γ − 1) [r^(2/γ) − r^((γ + 1)/γ)]},
//!
//! the flow of a nozzle (de Saint-Venant and Wantzel 1839), choked below r = (2/(γ + 1))^(γ/(γ − 1)). What a closing cavity
//! would compress above p₀ leaves at once: in a cavity that is pinched off its volume is too uncertain for more, and an
//! overpressure from it blew shots apart.

use super::CavityAir;
use super::cavity::{mean_over, rise};
use super::load_input::LoadInput;
use crate::fem::{Potential, Section, push};
use crate::math::Vector;
use crate::state::CavityGas;

/// Ratio of the specific heats of air, γ.
const GAMMA: f64 = 1.4;
/// √(R T₀) of air at 20 °C, m/s, with R = 287.05 J/(kg K).
const SPEED: f64 = 290.08;
/// Time between two updates of the gas, in ramp lengths over [`SPEED`].
const INTERVAL: f64 = 0.1;
/// Depths between which the opening is measured, in ramp lengths: a dent of the entry face is none.
const THROAT: [f64; 2] = [0.5, 1.5];

/// Updates the air in a cavity that is open to the surrounding air, if an update is due.
pub(super) fn update_gas<const D: usize, P: Potential<D>>(input: &LoadInput<'_, D, P>, gas: &mut Option<CavityGas>) {
    let LoadInput { model, projectile: at, time, entry, .. } = *input;
    let Some(CavityAir { ramp, inflow: Some(inflow), .. }) = model.gel.loads.air else { return };
    let (last, body) = (*gas, &model.bodies[0]);
    let elapsed = last.map_or(f64::INFINITY, |gas| time - model.grid.time(gas.tick));
    let is_inside = at.active && body.rear(&at.at(body, time)) < entry;
    if !is_inside || elapsed * SPEED < INTERVAL * ramp {
        return;
    }
    let [volume, opening] = measure(input, ramp).map(|measure| measure * inflow.copies);
    let (exit, body_volume) = if input.has_left { (inflow.exit_area, 0.0) } else { (0.0, inflow.body_volume) };
    let (area, volume) = (opening.max(0.0) + exit, (volume - body_volume).max(inflow.exit_area * ramp));
    let pressure = last.map_or(1.0, |gas| advanced(&gas, volume, inflow.discharge * area * elapsed));
    *gas = Some(CavityGas { pressure, volume, tick: input.ticks.moment.tick });
}

/// Returns the volume of the cavity, m³, and the area of its opening, m², of the computed part: ∫w A dz and the mean of
/// its cross-section A over the depths of [`THROAT`].
fn measure<const D: usize, P: Potential<D>>(input: &LoadInput<'_, D, P>, ramp: f64) -> [f64; 2] {
    let (loads, entry) = (&input.model.gel.loads, input.entry);
    let wall = loads.facets.iter().filter(|loaded| loaded.can_bound_cavity());
    wall.fold([0.0; 2], |[volume, area], loaded| {
        let corners = input.corners(loaded);
        let flux = lateral_flux(loads.section, &corners);
        let part = |of: &dyn Fn(f64) -> f64| flux * mean_over(&corners[..D], |x| of(x[D - 1] - entry));
        [volume + part(&|z| rise(z, ramp)), area + part(&|z| throat(z, ramp))]
    })
}

/// Returns −∫ x·n dA through a facet, x being the horizontal position over its dimensions: summed over a wall it is the
/// volume between any two horizontal planes, also of a channel that is open at both ends.
fn lateral_flux<const D: usize>(section: Section, corners: &[Vector<D>; 3]) -> f64 {
    let forces = push(section, corners).forces;
    let sum: f64 = (0..D).map(|a| (0..D - 1).map(|i| forces[a][i] * corners[a][i]).sum::<f64>()).sum();
    if matches!(section, Section::Planar { .. }) { sum } else { 0.5 * sum }
}

/// Returns the weight of a height below the entry surface, m, in the area of the opening, 1/m.
fn throat(z: f64, ramp: f64) -> f64 {
    let [from, to] = THROAT.map(|part| part * ramp);
    if (from..to).contains(&-z) { 1.0 / (to - from) } else { 0.0 }
}

/// Returns p/p₀ of a gas after a change of its volume, m³, and the flow through `exposure`, C_d A Δt, m² s.
fn advanced(gas: &CavityGas, volume: f64, exposure: f64) -> f64 {
    let expanded = (gas.pressure * libm::pow(gas.volume / volume, GAMMA)).min(1.0);
    (expanded + GAMMA * SPEED * exposure / volume * nozzle(expanded)).min(1.0)
}

/// Returns ψ of a pressure ratio of at most 1.
fn nozzle(ratio: f64) -> f64 {
    let choked = libm::pow(2.0 / (GAMMA + 1.0), GAMMA / (GAMMA - 1.0));
    let r = ratio.clamp(choked, 1.0);
    let difference = libm::pow(r, 2.0 / GAMMA) - libm::pow(r, (GAMMA + 1.0) / GAMMA);
    (2.0 * GAMMA / (GAMMA - 1.0) * difference).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAS: CavityGas = CavityGas { pressure: 0.4, volume: 2e-6, tick: 0 };

    /// Facets of the wall of a channel of radius, or half width, 0.3 from z = 0 to −2, whose void is on the axis' side.
    fn channel(n: i32) -> Vec<[Vector<2>; 3]> {
        let at = |i: i32| Vector::<2>::new(0.3, -2.0 * f64::from(i) / f64::from(n));
        (0..n).map(|i| [at(i), at(i + 1), Vector::zeros()]).collect()
    }

    #[test]
    fn volume_and_opening_are_those_of_the_channel_whether_or_not_it_has_a_bottom() {
        let bottom = [Vector::<2>::new(0.3, -2.0), Vector::<2>::new(0.0, -2.0), Vector::zeros()];
        let round = std::f64::consts::PI * 0.09;
        for (section, cross) in [(Section::Axisymmetric, round), (Section::Planar { thickness: 0.7 }, 0.3 * 0.7)] {
            for wall in [channel(4001), [channel(4001), vec![bottom]].concat()] {
                let sum = |of: &dyn Fn(f64) -> f64| -> f64 {
                    let part = |c: &[Vector<2>; 3]| lateral_flux(section, c) * mean_over(&c[..2], |x| of(x[1]));
                    wall.iter().map(part).sum()
                };
                // The pressure rises over 0.4: half of the volume above counts.
                assert!((sum(&|z| rise(z, 0.4)).abs() / (cross * 1.8) - 1.0).abs() < 1e-6, "{section:?}");
                assert!((sum(&|z| throat(z, 0.4)).abs() / cross - 1.0).abs() < 2e-3, "{section:?}");
                assert!(sum(&|z| rise(z, 0.4)) > 0.0, "a void is positive");
            }
        }
        // A prism in space, with a wall of two triangles on each side.
        let corners = [[0.2, 0.1], [-0.2, 0.1], [-0.2, -0.1], [0.2, -0.1]];
        let at = |i: usize, z: f64| Vector::<3>::new(corners[i % 4][0], corners[i % 4][1], z);
        let side =
            |i: usize| [[at(i, 0.0), at(i, -1.0), at(i + 1, 0.0)], [at(i + 1, 0.0), at(i, -1.0), at(i + 1, -1.0)]];
        let volume: f64 = (0..4).flat_map(side).map(|facet| lateral_flux(Section::Spatial, &facet)).sum();
        assert!((volume.abs() - 0.08).abs() < 1e-15, "{volume}");
    }

    #[test]
    fn without_an_opening_the_air_expands_as_an_ideal_gas() {
        let expanded = advanced(&GAS, 6e-6, 0.0);
        assert!((expanded - 0.4 * 3.0_f64.powf(-1.4)).abs() < 1e-15, "{expanded}");
        assert!((advanced(&GAS, 1.9e-6, 0.0) - 0.4 * (2.0_f64 / 1.9).powf(1.4)).abs() < 1e-15);
    }

    #[test]
    fn through_a_wide_opening_the_air_has_the_pressure_around_as_in_a_vented_cavity() {
        // 2 cm² for 1 ms fill some millilitres.
        for volume in [6e-6, 2e-6, 0.2e-6] {
            assert_eq!(advanced(&GAS, volume, 2e-4 * 1e-3), 1.0, "{volume}");
        }
    }

    #[test]
    fn a_closing_cavity_has_no_pressure_above_that_around() {
        for (volume, exposure) in [(0.5e-6, 0.0), (1e-12, 0.0), (1e-12, 1e-9)] {
            assert_eq!(advanced(&GAS, volume, exposure), 1.0, "{volume}");
        }
    }

    #[test]
    fn the_flow_is_that_of_a_nozzle() {
        // ψ of choked air, √γ (2/(γ + 1))^((γ + 1)/(2 (γ − 1))) = 0.6847, whatever the pressure behind it.
        assert!([0.0, 0.2, 0.528].iter().all(|r| (nozzle(*r) - 0.6847).abs() < 1e-4));
        assert_eq!(nozzle(1.0), 0.0);
        // A small difference drives the flow of an incompressible fluid, √(2 (1 − r)).
        assert!((nozzle(1.0 - 1e-6) / 2e-6_f64.sqrt() - 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_filling_takes_the_time_of_its_flow() {
        // Choked, dp/dt = p₀ γ C_d A √(R T₀) 0.6847/V.
        let (mut gas, n) = (CavityGas { pressure: 0.0, ..GAS }, 1000);
        let exposure = 0.5 * GAS.volume / (GAMMA * SPEED * 0.684_731_5);
        for _ in 0..n {
            gas.pressure = advanced(&gas, GAS.volume, exposure / f64::from(n));
        }
        assert!((gas.pressure - 0.5).abs() < 1e-6, "{}", gas.pressure);
    }
}
