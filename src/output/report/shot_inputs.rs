//! Inputs of a shot as people write them, with their SI values beside them on demand.

use super::format::{escape, quantity, shortest};
use super::inputs::ValueSources;
use crate::math::Vector3;
use crate::scene::{
    BodyShape, ExpansionSpec, GelShape, LayerSpec, LibraryProjectile, Preset, ProjectileSpec, Scene, body_name,
    layer_name, numbered,
};
use nalgebra::{Quaternion, UnitQuaternion};
use std::fmt::Write;

/// Least yaw that is told, degrees.
const MIN_YAW: f64 = 0.05;

/// Input as people write it.
struct InputRow {
    name: String,
    /// Value in the units of the trade.
    text: String,
    /// Value in SI units.
    si: String,
    /// Dotted key of the scene, by which the source is known.
    key: String,
}

impl InputRow {
    fn new(name: impl Into<String>, text: String, si: String, key: impl Into<String>) -> Self {
        Self { name: name.into(), text, si, key: key.into() }
    }
}

/// Returns the table of the inputs of the shot: projectile, fragments, layers, gel and level.
pub(super) fn table(scene: &Scene, level: &str, sources: &ValueSources) -> String {
    let bodies = scene.bodies().enumerate().flat_map(|(i, body)| body_rows(scene, i, body));
    let layers = scene.layer.iter().enumerate().map(|(i, layer)| layer_row(scene, i, layer));
    let end = scene.scene.end_time;
    let run = [
        InputRow::new("Level", level.to_owned(), level.to_owned(), "scene.fidelity"),
        InputRow::new("Time, at most", quantity(end, "s"), si(end, "s"), "scene.end_time"),
    ];
    let mut rows = String::new();
    for row in bodies.chain(layers).chain(gel_rows(scene)).chain(run) {
        writeln!(
            rows,
            "<tr><th scope=\"row\">{}</th><td>{}</td><td class=\"si\">{}</td><td>{}</td></tr>",
            escape(&row.name),
            row.text,
            escape(&row.si),
            escape(&sources.short(&row.key))
        )
        .expect("a string grows");
    }
    format!(
        "<p class=\"choice\"><label><input type=\"checkbox\" class=\"si-choice\"/> SI units beside them</label></p>\n\
         <div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"Inputs of the shot\"><table><caption>Inputs of the \
         shot</caption>\n<thead><tr><th scope=\"col\">input</th><th scope=\"col\">value</th><th scope=\"col\" \
         class=\"si\">SI units</th><th scope=\"col\">source</th></tr></thead>\n<tbody>\n{rows}</tbody></table></div>\n"
    )
}

fn body_rows(scene: &Scene, i: usize, body: &ProjectileSpec) -> Vec<InputRow> {
    let table = body_name(i);
    let of_body = |name: &str| if i == 0 { name.to_owned() } else { format!("{name}, fragment {i}") };
    let key = |name: &str| format!("{table}.{name}");
    let known = body.library.as_deref().and_then(LibraryProjectile::named);
    let mut rows = vec![];
    let title = known.as_ref().map_or_else(|| shape_name(&body.shape).to_owned(), |known| escape(&known.title));
    let library = body.library.clone().unwrap_or_else(|| "not of the library".to_owned());
    rows.push(InputRow::new(of_body("Projectile"), title, library, key("library")));
    if let Some(mass) = body.mass {
        rows.push(InputRow::new(of_body("Mass"), mass_text(mass), si(mass, "kg"), key("mass")));
    }
    if let Some(lengths) = shape_lengths(&body.shape) {
        rows.push(InputRow::new(of_body("Size"), sizes_text(&lengths), sizes_si(&lengths), key("shape")));
    }
    rows.extend(body.expansion.map(|expansion| expansion_row(of_body("Expansion"), &expansion, key("expansion"))));
    if body.fixed {
        rows.push(InputRow::new(of_body("Motion"), "fixed".to_owned(), "fixed".to_owned(), key("fixed")));
        return rows;
    }
    let velocity = Vector3::from(body.velocity) - Vector3::from(scene.gel.velocity);
    let speed = velocity.norm();
    rows.push(InputRow::new(of_body("Speed"), quantity(speed, "m/s"), si(speed, "m/s"), key("velocity")));
    let yaw = yaw(body, &velocity).to_degrees();
    if yaw > MIN_YAW && !matches!(body.shape, BodyShape::Sphere { .. }) {
        let radians = si(yaw.to_radians(), "rad");
        rows.push(InputRow::new(of_body("Yaw"), format!("{}°", shortest(yaw)), radians, key("orientation")));
    }
    rows
}

/// Returns the angle between the axis of a body and its velocity, rad; 0 for a body at rest.
fn yaw(body: &ProjectileSpec, velocity: &Vector3) -> f64 {
    let [w, x, y, z] = body.orientation;
    let axis = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)) * -Vector3::z();
    let angle = axis.angle(velocity);
    if velocity.norm() > 0.0 && angle.is_finite() { angle } else { 0.0 }
}

fn expansion_row(name: String, expansion: &ExpansionSpec, key: String) -> InputRow {
    let opened = &expansion.opened;
    let lengths = [2.0 * opened.radius, opened.length];
    let [opening, full] = [expansion.opening_speed, expansion.full_speed];
    let thresholds = match (opening, full) {
        (Some(opening), Some(full)) => {
            format!("; begins at {}, complete from {}", quantity(opening, "m/s"), quantity(full, "m/s"))
        }
        _ if expansion.is_prescribed() => "; prescribed by the importer".to_owned(),
        _ => String::new(),
    };
    let speeds = [opening, full].into_iter().flatten().map(|speed| si(speed, "m/s")).collect::<Vec<_>>().join(", ");
    let text = format!("opens to {}{thresholds}", sizes_text(&lengths));
    InputRow::new(name, text, [sizes_si(&lengths), speeds].join("; ").trim_end_matches("; ").to_owned(), key)
}

fn layer_row(scene: &Scene, i: usize, layer: &LayerSpec) -> InputRow {
    let ratios = layer.ratios(&scene.gel);
    let density = layer.density.unwrap_or(scene.gel.density);
    let preset = layer.preset.map_or(String::new(), |preset| format!("{}, ", gel_words(preset)));
    let text = format!(
        "{} thick, {preset}{} times the strength of the gel, {}",
        length_text(layer.thickness),
        shortest(ratios.strength),
        density_text(density)
    );
    let values = [si(layer.thickness, "m"), si(density, "kg/m³")].join(", ");
    InputRow::new(format!("Layer {}, {}", i + 1, layer_name(&scene.layer, i)), text, values, numbered("layer", i))
}

fn gel_rows(scene: &Scene) -> Vec<InputRow> {
    let gel = &scene.gel;
    let (words, name) = match gel.preset {
        Some(preset) => (gel_words(preset).to_owned(), preset.name().to_owned()),
        None => ("of the scene".to_owned(), "no preset".to_owned()),
    };
    let mut rows = vec![InputRow::new("Gel", words, name, "gel.preset")];
    if let Some((text, si)) = block_text(&gel.shape) {
        rows.push(InputRow::new("Block", text, si, "gel.shape"));
    }
    rows.push(InputRow::new("Density", density_text(gel.density), si(gel.density, "kg/m³"), "gel.density"));
    for (name, modulus, key) in [
        ("Shear modulus", gel.shear_modulus, "gel.shear_modulus"),
        ("Bulk modulus", gel.bulk_modulus, "gel.bulk_modulus"),
    ] {
        rows.push(InputRow::new(name, quantity(modulus, "Pa"), si(modulus, "Pa"), key));
    }
    if gel.strength_scale != 1.0 {
        let text = format!("{} times that of 10 % gelatin", shortest(gel.strength_scale));
        rows.push(InputRow::new("Strength", text, format!("{:?}", gel.strength_scale), "gel.strength_scale"));
    }
    rows
}

/// Returns a gel in words.
fn gel_words(preset: Preset) -> &'static str {
    match preset {
        Preset::Gelatin10 => "10 % gelatin at 4 °C",
        Preset::Gelatin20 => "20 % gelatin at 10 °C",
        Preset::SyntheticClear => "clear synthetic gel",
    }
}

/// Returns the size of a gel in words, and in SI units; `None` for shapes without a usual size.
fn block_text(shape: &GelShape) -> Option<(String, String)> {
    match shape {
        GelShape::Block { size } => {
            let unit = |factor: f64| size.iter().map(|edge| shortest(factor * edge)).collect::<Vec<_>>().join(" × ");
            let values = size.iter().map(|edge| format!("{edge:?}")).collect::<Vec<_>>().join(" × ");
            Some((format!("{} cm", unit(100.0)), format!("{values} m")))
        }
        GelShape::Cylinder { radius, height, .. } => {
            let [across, long] = [2.0 * radius, *height].map(|length| shortest(100.0 * length));
            let values = format!("radius {radius:?} m, height {height:?} m");
            Some((format!("cylinder, {across} cm across and {long} cm long"), values))
        }
        GelShape::Shell { .. } | GelShape::LBeam { .. } => None,
    }
}

/// Returns the name of a shape.
fn shape_name(shape: &BodyShape) -> &'static str {
    match shape {
        BodyShape::Sphere { .. } => "sphere",
        BodyShape::Cylinder { .. } => "cylinder",
        BodyShape::Capsule { .. } => "capsule",
        BodyShape::Bullet(_) => "bullet",
        BodyShape::Mushroom(_) => "expanded bullet",
        BodyShape::Plate { .. } => "plate",
        BodyShape::Chisel(_) => "chisel-nosed cylinder",
        BodyShape::Stl(_) => "surface of an STL file",
        BodyShape::HalfSpace { .. } => "half-space",
        BodyShape::Dome { .. } => "bulge of a back face",
    }
}

/// Returns width and length of a shape, or its edges, m.
fn shape_lengths(shape: &BodyShape) -> Option<Vec<f64>> {
    Some(match shape {
        BodyShape::Sphere { radius } => vec![2.0 * radius],
        BodyShape::Cylinder { radius, length, .. } | BodyShape::Capsule { radius, length } => {
            vec![2.0 * radius, *length]
        }
        BodyShape::Bullet(bullet) => vec![2.0 * bullet.radius, bullet.length],
        BodyShape::Mushroom(mushroom) => vec![2.0 * mushroom.radius, mushroom.length],
        BodyShape::Chisel(chisel) => vec![2.0 * chisel.radius, chisel.length],
        BodyShape::Plate { size, .. } => size.to_vec(),
        BodyShape::Stl(_) | BodyShape::HalfSpace { .. } | BodyShape::Dome { .. } => return None,
    })
}

fn sizes_text(lengths: &[f64]) -> String {
    match lengths {
        [across] => format!("{} across", length_text(*across)),
        [across, long] => format!("{} across, {} long", length_text(*across), length_text(*long)),
        edges => edges.iter().map(|edge| shortest(1e3 * edge)).collect::<Vec<_>>().join(" × ") + " mm",
    }
}

fn sizes_si(lengths: &[f64]) -> String {
    lengths.iter().map(|length| si(*length, "m")).collect::<Vec<_>>().join(", ")
}

fn length_text(length: f64) -> String {
    format!("{} mm", shortest(1e3 * length))
}

fn mass_text(mass: f64) -> String {
    if mass < 1.0 { format!("{} g", shortest(1e3 * mass)) } else { format!("{} kg", shortest(mass)) }
}

fn density_text(density: f64) -> String {
    format!("{} g/cm³", shortest(1e-3 * density))
}

/// Returns an SI value in all its digits, up to round-off.
fn si(value: f64, unit: &str) -> String {
    let rounded: f64 = format!("{value:.9e}").parse().unwrap_or(value);
    format!("{rounded:?} {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_written_in_the_units_of_the_trade() {
        assert_eq!(mass_text(8.04e-3), "8.04 g");
        assert_eq!(block_text(&GelShape::Block { size: vec![0.15, 0.15, 0.4] }).unwrap().0, "15 × 15 × 40 cm");
        assert_eq!(sizes_text(&[9.02e-3, 0.0156]), "9.02 mm across, 15.6 mm long");
        assert_eq!(density_text(1030.0), "1.03 g/cm³");
        assert_eq!(si(2.0 * 2.185e-3, "m"), "0.00437 m");
    }
}
