//! Layers of a target in the report and on the console: constants, speed at entry and energy of each.

use super::figures::{FigureRow, per_thickness, plain};
use super::format::{CONSOLE_DIGITS, PAGE_DIGITS, escape, millimetres, percent_in, quantity, quantity_in, ratio};
use super::plot::{CurvePlot, PlotCurve};
use super::tables;
use crate::output::penetration::LayerPassage;
use crate::output::saved_run::{SavedShot, layer_passages};
use crate::scene::{LayerSpec, MaterialModel, Preset, Scene, layer_name};
use std::path::Path;

/// Returns the rows of the console, one for each layer and the gel below; empty without the table of the layers.
///
/// The table is one of a run that has just been written. A damaged one has no rows.
#[must_use]
pub fn layer_rows(folder: &Path, scene: &Scene) -> Vec<FigureRow> {
    let row = |(n, passage): (usize, &LayerPassage)| {
        let speed = match passage.entry_speed {
            speed if speed.is_finite() => format!("{} at entry", plain(&quantity(speed, "m/s"))),
            _ => "not reached".to_owned(),
        };
        let energy = plain(&quantity_in(passage.energy, "J", CONSOLE_DIGITS)) + per_thickness(scene);
        let share = plain(&share(passage, CONSOLE_DIGITS));
        let text = format!("{} mm deep, {speed}, {energy} ({share})", extent(passage));
        FigureRow { name: format!("in {}", layer_name(&scene.layer, n)), text, is_key: false }
    };
    layer_passages(folder).unwrap_or_default().iter().enumerate().map(row).collect()
}

/// Returns the table of the layers and the gel below them; empty without layers.
pub(super) fn table(scene: &Scene, shot: &SavedShot) -> String {
    if shot.layers.is_empty() {
        return String::new();
    }
    let mut rows = String::new();
    for (n, passage) in shot.layers.iter().enumerate() {
        let mut cells = vec![format!("{} mm", extent(passage))];
        cells.extend(constants(scene, n));
        cells.extend([
            if passage.entry_speed.is_finite() { quantity(passage.entry_speed, "m/s") } else { "–".to_owned() },
            quantity(passage.energy, "J"),
            share(passage, PAGE_DIGITS),
        ]);
        tables::row(&mut rows, &layer_name(&scene.layer, n), &cells.iter().map(String::as_str).collect::<Vec<_>>());
    }
    let moduli: &[&str] = match scene.gel.material {
        MaterialModel::TwoNetwork => &["strength scale", "bulk modulus"],
        _ => &["shear modulus", "bulk modulus"],
    };
    let heads: [&[&str]; 3] =
        [&["layer", "depth", "preset", "density"], moduli, &["speed at entry", "energy given", "share of the energy"]];
    format!(
        "<figure class=\"layers\"><figcaption>Layers</figcaption>\n{}<p>Depths are those of the undeformed interfaces \
         below the entry surface. The energy is given while the foremost point of the projectile is between them, by \
         depth as in the plot above.</p></figure>\n",
        tables::table("Constants, speed and energy, front to back", &heads.concat(), &rows)
    )
}

/// Returns the cells of preset, density and moduli of the n-th layer, or of the gel below the last: those of the scene.
fn constants(scene: &Scene, n: usize) -> [String; 4] {
    let (gel, layer) = (&scene.gel, scene.layer.get(n));
    let own = |value: fn(&LayerSpec) -> Option<f64>, of_gel: f64| layer.and_then(value).unwrap_or(of_gel);
    let preset = layer.map_or(gel.preset, |layer| layer.preset);
    let density = own(|layer| layer.density, gel.density);
    let [strength, bulk] = if gel.material == MaterialModel::TwoNetwork {
        let strength = own(|layer| layer.strength_scale, gel.strength_scale);
        [ratio(strength), quantity(own(|layer| layer.bulk_modulus, gel.bulk_modulus), "Pa")]
    } else {
        let shear = own(|layer| layer.shear_modulus, gel.shear_modulus);
        [shear, gel.bulk_modulus * shear / gel.shear_modulus].map(|modulus| quantity(modulus, "Pa"))
    };
    [preset.map_or("–", Preset::name).to_owned(), ratio(density) + " kg/m³", strength, bulk]
}

/// Returns a vertical line at each interface that the projectile has passed, for the plot of the energy by depth.
pub(super) fn interface_curves(scene: &Scene, shot: &SavedShot) -> impl Iterator<Item = PlotCurve> {
    let height = shot.energies.iter().copied().fold(0.0, f64::max);
    let names = move |n: usize| [n - 1, n].map(|n| layer_name(&scene.layer, n));
    let passed = shot.layers.iter().enumerate().skip(1).filter(|(_, passage)| passage.entry_speed.is_finite());
    let line = move |(n, passage): (usize, &LayerPassage)| {
        let [above, below] = names(n).map(|name| escape(&name));
        let points = [0.0, height].map(|energy| (passage.depth_from, energy)).to_vec();
        PlotCurve::line(format!("interface of {above} and {below}"), points)
    };
    passed.map(line).take(CurvePlot::MAX_CURVES - 1)
}

/// Formats the share of the energy in percent, in a number of significant digits.
fn share(passage: &LayerPassage, digits: i32) -> String {
    if passage.energy_fraction.is_finite() { percent_in(passage.energy_fraction, digits) } else { "–".to_owned() }
}

/// Formats the depths of the interfaces in millimetres: "0–12.5".
fn extent(passage: &LayerPassage) -> String {
    [passage.depth_from, passage.depth_to].map(millimetres).join("–")
}
