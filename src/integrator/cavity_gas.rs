//! Air that flows into the cavity behind the projectile, through its entry and a perforated exit.
//!
//! The air is an ideal gas of one pressure p in the cavity. Its energy p V/(γ − 1) loses the work on the wall and gains
//! the enthalpy of the air that flows in from rest,
//!
//!   dp/dt = γ/V [p₀ C_d A √(R T₀) ψ(p/p₀) − p dV/dt],   ψ(r) = √{2γ/(γ − 1) [r^(2/γ) − r^((γ + 1)/γ)]},
//!
//! the flow of a nozzle (de Saint-Venant and Wantzel 1839), choked below r = (2/(γ + 1))^(γ/(γ − 1)). Air that flows out
//! has the temperature T₀, too.

use super::cavity::{mean_over, rise};
use super::system::DiscreteSystem;
use super::{AirInflow, CavityAir};
use crate::fem::{Potential, push};
use crate::math::Vector;
use crate::state::{CavityGas, Tick};

/// Ratio of the specific heats of air, γ.
const GAMMA: f64 = 1.4;
/// √(R T₀) of air at 20 °C, m/s, with R = 287.05 J/(kg K).
const SPEED: f64 = 290.08;
/// Time between two updates of the gas, in ramp lengths over [`SPEED`].
const INTERVAL: f64 = 0.1;

/// Updates the air in a cavity that is open to the surrounding air, if an update is due.
pub(super) fn update_gas<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    let Some(CavityAir { ramp, inflow: Some(inflow), .. }) = system.model.gel.loads.air else { return };
    let (time, last) = (system.model.grid.time(tick), system.state.record.gas);
    let elapsed = last.map_or(f64::INFINITY, |gas| time - system.model.grid.time(gas.tick));
    let (body, at) = (&system.model.bodies[0], &system.state.bodies[0]);
    let is_inside = at.active && body.rear(&at.at(body, time)) < system.entry_height(time);
    if !is_inside || elapsed * SPEED < INTERVAL * ramp {
        return;
    }
    let [volume, opening] = measure(system, ramp, time).map(|measure| measure * inflow.copies);
    let has_exit = system.state.record.contacts[0].exit.is_some();
    let area = opening.max(0.0) + if has_exit { inflow.exit_area } else { 0.0 };
    let volume = (volume - inflow.body_volume).max(inflow.exit_area * ramp);
    let pressure = last.map_or(1.0, |gas| advanced(&gas, volume, inflow.discharge * area * elapsed));
    system.state.record.gas = Some(CavityGas { pressure, volume, tick });
}

/// Returns the volume below the entry surface, m³, and the area of its opening, m², of the computed part: ∫ ∫w dz n_z dA
/// and ∫ w n_z dA over the wall, w being the weight of the pressure, which rises with the depth over the ramp.
fn measure<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, ramp: f64, time: f64) -> [f64; 2] {
    let (gel, entry) = (&system.model.gel, system.entry_height(time));
    let wall = gel.loads.facets.iter().filter(|loaded| loaded.can_bound_cavity());
    wall.fold([0.0; 2], |[volume, area], loaded| {
        let corners = loaded.facet.map(|node| system.position_at(node, time));
        // A pressure of 1 Pa pushes by −n dA.
        let upward = -push(gel.loads.section, &corners).forces.iter().sum::<Vector<D>>()[D - 1];
        let heights = &corners[..D].iter().map(|x| x[D - 1] - entry).collect::<Vec<f64>>();
        let depth = mean_over(heights, |z| {
            let depth = (-z).max(0.0);
            if depth < ramp { 0.5 * depth * depth / ramp } else { depth - 0.5 * ramp }
        });
        [volume + depth * upward, area + mean_over(heights, |z| rise(z, ramp)) * upward]
    })
}

/// Returns p/p₀ of a gas after a change of its volume, m³, and the flow through `exposure`, C_d A Δt, m² s.
fn advanced(gas: &CavityGas, volume: f64, exposure: f64) -> f64 {
    let expanded = gas.pressure * libm::pow(gas.volume / volume, GAMMA);
    let flow = GAMMA * SPEED * exposure / volume;
    if expanded < 1.0 {
        (expanded + flow * nozzle(expanded)).min(1.0)
    } else {
        // From the pressure p the flow is p/p₀ times that from p₀.
        (expanded - flow * expanded * nozzle(1.0 / expanded)).max(1.0)
    }
}

/// Returns ψ of a pressure ratio of at most 1.
fn nozzle(ratio: f64) -> f64 {
    let choked = libm::pow(2.0 / (GAMMA + 1.0), GAMMA / (GAMMA - 1.0));
    let r = ratio.clamp(choked, 1.0);
    let difference = libm::pow(r, 2.0 / GAMMA) - libm::pow(r, (GAMMA + 1.0) / GAMMA);
    (2.0 * GAMMA / (GAMMA - 1.0) * difference).sqrt()
}

impl AirInflow {
    /// Returns the share of the gauge pressure of a vacuum that acts on the wall.
    pub(super) fn share_of_vacuum(gas: Option<&CavityGas>) -> f64 {
        gas.map_or(0.0, |gas| 1.0 - gas.pressure)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAS: CavityGas = CavityGas { pressure: 0.4, volume: 2e-6, tick: 0 };

    #[test]
    fn without_an_opening_the_air_expands_as_in_a_sealed_cavity() {
        let expanded = advanced(&GAS, 6e-6, 0.0);
        assert!((expanded - 0.4 * 3.0_f64.powf(-1.4)).abs() < 1e-15, "{expanded}");
        let compressed = advanced(&GAS, 0.5e-6, 0.0);
        assert!((compressed - 0.4 * 4.0_f64.powf(1.4)).abs() < 1e-14, "{compressed}");
    }

    #[test]
    fn through_a_wide_opening_the_air_has_the_pressure_around_as_in_a_vented_cavity() {
        for volume in [6e-6, 2e-6, 0.2e-6] {
            assert_eq!(advanced(&GAS, volume, 1.0), 1.0, "{volume}");
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
