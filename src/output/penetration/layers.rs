//! Layers along a shot: speed of the projectile at each, and energy that each is given.

use super::track::ProjectileTrack;
use crate::output::files::format_cell;
use crate::scene::{Scene, layer_name};
use std::fmt::Write;

/// File name of the table of the layers.
pub(in crate::output) const LAYERS: &str = "layers.csv";

/// Passage of the projectile through a layer, or through the gel below the last layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::output) struct LayerPassage {
    /// Depth of the upper interface in the undeformed gel, m.
    pub(in crate::output) depth_from: f64,
    /// Depth of the lower interface in the undeformed gel, m; of the last material that of the back face.
    pub(in crate::output) depth_to: f64,
    /// Density at rest, kg/m3.
    pub(in crate::output) density: f64,
    /// Speed along −z when the foremost point first passes the upper interface, m/s. NaN if it never does.
    pub(in crate::output) entry_speed: f64,
    /// Energy given to the gel while the foremost point advances from the upper to the lower interface, J.
    pub(in crate::output) energy: f64,
    /// Energy relative to that of all layers and the gel. NaN without energy.
    pub(in crate::output) energy_fraction: f64,
}

/// Returns the text of `layers.csv`.
pub(super) fn csv(scene: &Scene, track: &ProjectileTrack) -> String {
    let mut text =
        String::from("layer,depth_from_m,depth_to_m,density_kg_per_m3,entry_speed_m_per_s,energy_J,energy_fraction\n");
    for (n, passage) in passages(scene, track).into_iter().enumerate() {
        let LayerPassage { depth_from, depth_to, density, entry_speed, energy, energy_fraction } = passage;
        let row = [depth_from, depth_to, density, entry_speed, energy, energy_fraction].map(format_cell);
        writeln!(text, "{},{}", layer_name(&scene.layer, n), row.join(",")).expect("a string grows");
    }
    text
}

/// Returns the passages through the layers front to back, and last that through the gel below them.
fn passages(scene: &Scene, track: &ProjectileTrack) -> Vec<LayerPassage> {
    let (mut found, mut depth): (Vec<LayerPassage>, f64) = (vec![], 0.0);
    for n in 0..=scene.layer.len() {
        let layer = scene.layer.get(n);
        let end = layer.map_or(track.gel_depth(), |layer| (depth + layer.thickness).min(track.gel_depth()));
        found.push(LayerPassage {
            depth_from: depth,
            depth_to: end,
            density: layer.and_then(|layer| layer.density).unwrap_or(scene.gel.density),
            entry_speed: track.speed_at(depth).unwrap_or(f64::NAN),
            energy: track.energy_between(depth, end),
            energy_fraction: f64::NAN,
        });
        depth = end;
    }
    let total: f64 = found.iter().map(|passage| passage.energy).sum();
    for passage in &mut found {
        passage.energy_fraction = passage.energy / total;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a gel of 10 cm with a skin of 12 mm and a layer without a name of 28 mm.
    fn layered() -> Scene {
        let mut scene = crate::scene::read(crate::scene::builtin("fbi-bb").unwrap()).unwrap();
        let layers = "[[layer]]\nname = \"skin\"\nthickness = 0.012\ndensity = 1100.0\n[[layer]]\nthickness = 0.028\n";
        let table: toml::Table = layers.parse().unwrap();
        scene.layer = table["layer"].clone().try_into().unwrap();
        scene
    }

    /// Returns a track down to a depth, m, in steps of 1 cm, at 100 m/s with a force of 1 kN on a mass of 1 kg.
    fn braked(depth: f64) -> ProjectileTrack {
        let steps = (depth / 0.01).ceil() as u32;
        ProjectileTrack::with_depths((0..=steps).map(|i| (0.01 * f64::from(i)).min(depth)), 100.0, 1e3, 0.1)
    }

    #[test]
    fn the_energies_of_the_layers_are_those_of_the_centimetres() {
        let track = braked(0.075);
        let found = passages(&layered(), &track);
        let energies: Vec<f64> = found.iter().map(|passage| passage.energy).collect();
        for (energy, path) in energies.iter().zip([0.012, 0.028, 0.035]) {
            assert!((energy - 1e3 * path).abs() < 1e-9, "{energies:?}");
        }
        let total: f64 = track.energy_per_centimetre().iter().sum();
        assert!((energies.iter().sum::<f64>() / total - 1.0).abs() < 1e-12, "{energies:?}, {total}");
        assert!((found.iter().map(|passage| passage.energy_fraction).sum::<f64>() - 1.0).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn speeds_at_the_interfaces_are_interpolated_with_a_constant_force() {
        let found = passages(&layered(), &braked(0.075));
        for (passage, depth) in found.iter().zip([0.0, 0.012, 0.04]) {
            assert!((passage.depth_from - depth).abs() < 1e-15, "{found:?}");
            let speed = (100.0f64.powi(2) - 2e3 * depth).sqrt();
            assert!((passage.entry_speed / speed - 1.0).abs() < 1e-12, "{found:?}: {speed}");
        }
        assert_eq!((found[0].depth_to, found[2].depth_to), (found[1].depth_from, 0.1));
    }

    #[test]
    fn a_layer_that_is_not_reached_has_no_speed_and_no_energy() {
        let found = passages(&layered(), &braked(0.03));
        assert!(found[2].entry_speed.is_nan() && found[2].energy == 0.0, "{found:?}");
        assert!((found[1].energy - 18.0).abs() < 1e-9, "{found:?}");
        assert!(passages(&layered(), &braked(0.04))[2].entry_speed.is_nan(), "the front stops at the interface");
        let text = csv(&layered(), &braked(0.03));
        assert!(text.lines().last().unwrap().starts_with("gel,4e-2,1e-1,1.03e3,,0e0,"), "{text}");
        assert!(text.contains("\nskin,0e0,1.2e-2,1.1e3,1e2,") && text.contains("\nlayer-2,"), "{text}");
    }

    #[test]
    fn a_projectile_that_begins_below_an_interface_has_no_speed_there() {
        let track = ProjectileTrack::with_depths([0.02, 0.05].into_iter(), 100.0, 1e3, 0.1);
        let found = passages(&layered(), &track);
        assert!(found[0].entry_speed.is_nan() && found[1].entry_speed.is_nan() && found[2].entry_speed > 90.0);
        assert_eq!(found[0].energy, 0.0);
    }
}
