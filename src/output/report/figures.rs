//! Figures of a run: their units and meaning, from the one table that [`RunSummary`] is, and the rows that console and
//! report show.

use super::format::{CONSOLE_DIGITS, PAGE_DIGITS, count, peak_force_label, percent_in, quantity_in, ratio_in};
use crate::output::accounts::account_meanings;
use crate::output::summary::RunSummary;
use crate::scene::{Dimension, Scene};
use serde_json::{Value, json};
use std::collections::HashMap;
use std::ops::Index;
use std::sync::LazyLock;

/// JSON schema of `summary.json`: meaning, unit (`x-unit`) and sampling (`x-sampled`) of each figure.
///
/// A figure is sampled at the `start` or the `end` of the run, at each communication `step`, each `frame` and some
/// communication points between frames, each `tick` of the integrator at which the body is in contact or leaves, or each
/// `update` of an element. In a planar scene without `gel.thickness` masses, forces, impulses and energies are those of a
/// metre of thickness.
///
/// # Examples
/// ```
/// let schema = ballistic_gel::output::summary_schema();
/// assert_eq!(schema["properties"]["peak_depth"]["x-unit"], "m");
/// assert_eq!(schema["properties"]["energy"]["properties"]["remesh"]["x-unit"], "J");
/// ```
#[must_use]
pub fn summary_schema() -> Value {
    let mut schema = schemars::schema_for!(RunSummary).to_value();
    let account = |(name, meaning): (&str, &str)| {
        let sampled = if name == "initial" { "start" } else { "end" };
        (name.to_owned(), json!({ "description": meaning, "type": "number", "x-unit": "J", "x-sampled": sampled }))
    };
    schema["properties"]["energy"]["properties"] = Value::Object(account_meanings().map(account).collect());
    schema["properties"]["measured"] = json!({
        "description": "Curves of `--measured` beside those of the run, with their residuals", "type": "object"
    });
    allow_null(&mut schema);
    schema
}

/// Allows `null` in the place of each number with a unit: one that is not finite has no form in JSON.
fn allow_null(schema: &mut Value) {
    match schema {
        Value::Object(object) => {
            if object.contains_key("x-unit") {
                let number =
                    if object.contains_key("items") { &mut object["items"]["type"] } else { &mut object["type"] };
                if number == "number" {
                    *number = json!(["number", "null"]);
                }
            }
            object.values_mut().for_each(allow_null);
        }
        Value::Array(values) => values.iter_mut().for_each(allow_null),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

/// Unit of each figure of a run.
static UNITS: LazyLock<HashMap<String, String>> = LazyLock::new(|| {
    let schema = summary_schema();
    let all = schema["properties"].as_object().into_iter().flatten();
    all.filter_map(|(key, figure)| Some((key.clone(), figure["x-unit"].as_str()?.to_owned()))).collect()
});

/// Figure of a run for its readers: a name and a text.
pub struct FigureRow {
    /// Name.
    pub name: String,
    /// Value with its unit, or why there is none; plain text.
    pub text: String,
    /// True if the report shows the row among its key figures.
    pub is_key: bool,
}

/// Figures of a run by their keys, and the significant digits in which they are written.
struct SummaryFigures<'a> {
    values: &'a Value,
    digits: i32,
}

impl Index<&str> for SummaryFigures<'_> {
    type Output = Value;

    fn index(&self, key: &str) -> &Value {
        &self.values[key]
    }
}

/// Returns the rows of a run, in the order of the console. `summary` is the content of `summary.json`.
#[must_use]
pub fn figure_rows(summary: &Value, scene: &Scene) -> Vec<FigureRow> {
    rows(&SummaryFigures { values: summary, digits: CONSOLE_DIGITS }, scene)
}

/// Returns the rows of a run that the report shows, in the digits of the page.
pub(super) fn page_rows(summary: &Value, scene: &Scene) -> impl Iterator<Item = FigureRow> {
    let rows = rows(&SummaryFigures { values: summary, digits: PAGE_DIGITS }, scene);
    rows.into_iter().filter(|row| row.is_key)
}

fn rows(figures: &SummaryFigures, scene: &Scene) -> Vec<FigureRow> {
    let per = per_thickness(scene);
    let [way, mesh, balance] = [way_rows(figures, scene, per), mesh_rows(figures), balance_rows(figures)];
    mesh.into_iter().chain(way).chain(cavity_rows(figures)).chain(balance).collect()
}

/// Returns the suffix of a force or an energy in a planar scene without thickness.
pub(super) fn per_thickness(scene: &Scene) -> &'static str {
    match (scene.scene.dimension, scene.gel.thickness) {
        (Dimension::Planar, None) => " per metre of thickness",
        (Dimension::Planar | Dimension::Axisymmetric | Dimension::Spatial, _) => "",
    }
}

/// Row that the console alone shows.
fn row(name: &str, text: String) -> FigureRow {
    FigureRow { name: name.to_owned(), text, is_key: false }
}

/// Row that the report shows, too, if it is a key figure of the run.
fn key_row(name: &str, text: String, is_key: bool) -> FigureRow {
    FigureRow { is_key, ..row(name, text) }
}

/// Rows of the end, and of the mesh and its steps or the reduced model.
fn mesh_rows(s: &SummaryFigures) -> Vec<FigureRow> {
    let end = row("end", format!("{} at {}", describe_completion(s), figure(s, "end_time")));
    if s["fidelity"] == "instant" {
        let model = format!("none: reduced model, {} steps of the body", format_count(&s["element_updates"]));
        return vec![end, row("mesh", model)];
    }
    let steps = format!("{} to {}", figure(s, "smallest_step"), figure(s, "largest_step"));
    vec![
        end,
        row("mesh", format!("{} elements, {} nodes", format_count(&s["elements"]), format_count(&s["nodes"]))),
        row("element time steps", steps),
        row("element updates", describe_updates(s)),
    ]
}

/// Rows of the motion of the projectile and of the contact.
fn way_rows(s: &SummaryFigures, scene: &Scene, per: &str) -> Vec<FigureRow> {
    let (moves, perforated) = (!scene.projectile.fixed, s["perforated"] == Value::Bool(true));
    let stays = moves && !perforated;
    let with_per = |key: &str| figure(s, key) + if s[key].is_null() { "" } else { per };
    let peak_force = peak_force_label(s["force_window"].as_f64().unwrap_or(f64::NAN));
    let left = if perforated {
        key_row("exit", describe_exit(s, per), moves)
    } else {
        key_row("rebound velocity", describe_rebound(s), moves)
    };
    vec![
        key_row("greatest depth", describe_peak_depth(s), stays),
        key_row("depth at the end", format_depth(s, "final_depth"), stays),
        key_row("rest depth", describe_rest(s), !s["rest_depth"].is_null()),
        row("speed at the end", figure(s, "final_velocity")),
        left,
        key_row("energy deposited", with_per("energy_deposited"), moves),
        key_row("contact duration", figure(s, "contact_duration"), !s["contact_duration"].is_null()),
        key_row(&peak_force, with_per("peak_force"), true),
        row("total impulse", with_per("total_impulse")),
    ]
}

/// Rows of the balances, the known errors and the cost.
fn balance_rows(s: &SummaryFigures) -> Vec<FigureRow> {
    let both = |a: &str, b: &str| [a, b].map(|key| format_small(&s[key]));
    let [imbalance, defect] = both("energy_error", "energy_defect");
    let [momentum, angular] = both("momentum_error", "angular_momentum_error");
    vec![
        row("energy", format!("imbalance {imbalance}, defect {defect}")),
        row("momentum", format!("{momentum}, angular {angular}")),
        row("expected error", format_percent(&s["expected_error"])),
        row("model error", format_percent(&s["model_error"])),
        row("wall time", figure(s, "wall_seconds")),
        row("CPU time", figure(s, "cpu_seconds")),
        row("digest", s["digest"].as_str().unwrap_or("-").to_owned()),
    ]
}

/// Rows of what a shot leaves in the gel, each only where there is such a figure.
fn cavity_rows(s: &SummaryFigures<'_>) -> impl Iterator<Item = FigureRow> {
    [expansion_row(s), expansion_work_row(s), cavity_row(s), course_row(s), track_row(s), neck_row(s), overlap_row(s)]
        .into_iter()
        .flatten()
}

/// Row of the temporary cavity of a shot.
fn cavity_row(s: &SummaryFigures) -> Option<FigureRow> {
    s["greatest_cavity_diameter"].as_f64()?;
    let [greatest, time, last] =
        ["greatest_cavity_diameter", "time_of_greatest_cavity", "final_cavity_diameter"].map(|key| figure(s, key));
    let still = if s["cavity_still_opening"] == Value::Bool(true) { ", still opening" } else { "" };
    let place = if s["depth_of_greatest_cavity"].is_null() {
        String::new()
    } else {
        format!(" {} deep", figure(s, "depth_of_greatest_cavity"))
    };
    Some(key_row("temporary cavity", format!("{greatest} wide{place} at {time}, {last} at the end{still}"), true))
}

/// Row of the collapse and the pulsation of the cavity.
fn course_row(s: &SummaryFigures) -> Option<FigureRow> {
    s["time_of_cavity_collapse"].as_f64()?;
    let collapse = format!("below 40 % of its diameter at {}", figure(s, "time_of_cavity_collapse"));
    let pulsation = s["cavity_pulsation_diameter"].as_f64().map(|_| {
        let [diameter, time] = ["cavity_pulsation_diameter", "time_of_cavity_pulsation"].map(|key| figure(s, key));
        format!(", again {diameter} wide at {time}")
    });
    Some(key_row("collapse of the cavity", collapse + &pulsation.unwrap_or_default(), true))
}

/// Row of the permanent track in a damaged gel.
fn track_row(s: &SummaryFigures) -> Option<FigureRow> {
    s["greatest_track_diameter"].as_f64().filter(|diameter| *diameter > 0.0)?;
    Some(key_row("permanent track", format!("{} wide at most", figure(s, "greatest_track_diameter")), true))
}

/// Row of the opening of an expanding projectile.
fn expansion_row(s: &SummaryFigures) -> Option<FigureRow> {
    let opening = s["expansion"].as_f64()?;
    Some(key_row("expansion", format!("{:.0} % open, {} wide", 1e2 * opening, figure(s, "expanded_diameter")), true))
}

/// Row of the work of the surface of an expanding projectile.
fn expansion_work_row(s: &SummaryFigures) -> Option<FigureRow> {
    let part = s["expansion_work_fraction"].as_f64()?;
    Some(row("work of the expansion", format!("{:+.1} % of the energy given, an account of its own", 1e2 * part)))
}

/// Row of the neck of a bullet that turns over.
fn neck_row(s: &SummaryFigures) -> Option<FigureRow> {
    s["neck_length"].as_f64()?;
    Some(key_row("neck", format!("{}, then the yaw passes 30°", figure(s, "neck_length")), true))
}

/// Row of a run in which the gel overlaps itself, with or without self-contact.
fn overlap_row(s: &SummaryFigures) -> Option<FigureRow> {
    let volume = s["overlapped_volume"].as_f64().filter(|volume| *volume > 0.0)?;
    let mut off = s["switched_off"].as_array().into_iter().flatten().filter_map(Value::as_str);
    let cause = if off.any(|entry| entry.starts_with("self-contact of the gel: none")) {
        "there is no self-contact"
    } else {
        "self-contact stops it there and does not push it out"
    };
    Some(row("self-overlap", format!("{:.3} cm³ of gel overlap other gel: {cause}", 1e6 * volume)))
}

fn describe_completion(s: &SummaryFigures) -> &'static str {
    match (s["completed"].as_bool(), s["ended_by"].as_str()) {
        (Some(true), Some("exit")) => "reached, after the exit of the projectile,",
        (Some(true), Some("rest")) => "reached, with the projectile at rest,",
        (Some(true), _) => "reached",
        _ => "stopped early",
    }
}

/// Describes the exit of a projectile that has perforated the gel.
fn describe_exit(s: &SummaryFigures, per: &str) -> String {
    let [velocity, time, energy] = ["exit_velocity", "exit_time", "residual_energy"].map(|key| figure(s, key));
    format!("{velocity} at {time}, {energy}{per} retained")
}

fn describe_peak_depth(s: &SummaryFigures) -> String {
    format!("{} at {}", format_depth(s, "peak_depth"), figure(s, "time_of_peak_depth"))
}

/// Describes the rest of the projectile in the gel.
fn describe_rest(s: &SummaryFigures) -> String {
    match s["rest_depth"].as_f64() {
        Some(_) => format!("{} from {}", format_depth(s, "rest_depth"), figure(s, "time_of_rest")),
        None => "none: the nose moves by 0.2 mm or more in the last millisecond (a later scene.end_time may show it), or is \
                 not in the gel"
            .to_owned(),
    }
}

fn describe_rebound(s: &SummaryFigures) -> String {
    let speed = figure(s, "rebound_velocity");
    match (s["rebound_velocity"].as_f64(), s["contact_duration"].as_f64(), s["final_depth"].as_f64()) {
        (_, None, _) => "none: no contact with the gel".to_owned(),
        (None, Some(_), _) => "none yet: in contact, or contact ended too recently".to_owned(),
        (Some(back), _, Some(depth)) if back > 0.0 && depth > 0.0 => format!("{speed}, still in the gel"),
        (Some(_), ..) => speed,
    }
}

fn describe_updates(s: &SummaryFigures) -> String {
    let [done, synchronous, rate] =
        ["element_updates", "synchronous_updates", "updates_per_second"].map(|key| format_count(&s[key]));
    format!("{done}, {synchronous} with one global step, {rate} per second")
}

/// Formats a depth, or the height above the entry surface if it is negative.
fn format_depth(s: &SummaryFigures, key: &str) -> String {
    match s[key].as_f64() {
        Some(depth) if depth < 0.0 => {
            format!("none, {} above the entry surface", plain(&quantity_in(-depth, "m", s.digits)))
        }
        _ => figure(s, key),
    }
}

/// Formats a figure with its unit; a vector is replaced by its norm, a missing one by a dash.
fn figure(s: &SummaryFigures, key: &str) -> String {
    let number = match &s[key] {
        Value::Array(parts) => {
            parts.iter().map(|part| part.as_f64().map(|part| part * part)).sum::<Option<f64>>().map(f64::sqrt)
        }
        other => other.as_f64(),
    };
    let unit = UNITS.get(key).map_or("", String::as_str);
    number.map_or("-".to_owned(), |number| plain(&quantity_in(number, unit, s.digits)))
}

/// Replaces the marks of the report in a number: a terminal shows powers, minus and spaces as plain characters.
pub(super) fn plain(number: &str) -> String {
    number.replace("<sup>", "^").replace("</sup>", "").replace('−', "-").replace('\u{202f}', " ")
}

fn format_count(value: &Value) -> String {
    let text = |n: f64| if n < 1e6 { count(n) } else { format!("{} million", ratio_in(n * 1e-6, CONSOLE_DIGITS)) };
    value.as_f64().map_or("-".to_owned(), |n| plain(&text(n)))
}

fn format_percent(value: &Value) -> String {
    value.as_f64().map_or("not measured for these values".to_owned(), |part| plain(&percent_in(part, CONSOLE_DIGITS)))
}

fn format_small(value: &Value) -> String {
    value.as_f64().map_or("-".to_owned(), |x| format!("{x:.1e}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene;

    /// All rows of a summary, in a scene without a fixed projectile.
    fn describe(summary: &Value) -> String {
        let scene = scene::read(scene::builtin("sphere-block").unwrap()).unwrap();
        let line = |row: FigureRow| format!("{}: {}\n", row.name, row.text);
        figure_rows(summary, &scene).into_iter().map(line).collect()
    }

    /// All properties of a schema, also those of the objects in it.
    fn properties<'a>(schema: &'a Value, into: &mut Vec<(&'a String, &'a Value)>) {
        match schema {
            Value::Object(object) => {
                into.extend(object.get("properties").and_then(Value::as_object).into_iter().flatten());
                object.values().for_each(|value| properties(value, into));
            }
            Value::Array(values) => values.iter().for_each(|value| properties(value, into)),
            Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
        }
    }

    #[test]
    fn every_number_of_a_summary_has_a_unit_a_sampling_and_a_meaning() {
        const SAMPLINGS: [&str; 6] = ["start", "end", "step", "frame", "tick", "update"];
        let (schema, mut all) = (summary_schema(), vec![]);
        properties(&schema, &mut all);
        let mut numbers = 0;
        for (key, figure) in all.into_iter().filter(|(key, _)| *key != "format") {
            assert!(figure["description"].is_string() || figure["$ref"].is_string(), "{key}: {figure}");
            let kinds = figure["type"].to_string() + &figure["items"]["type"].to_string();
            if ["number", "integer"].iter().any(|kind| kinds.contains(kind)) {
                assert!(figure["x-unit"].is_string(), "{key}: {figure}");
                assert!(SAMPLINGS.iter().any(|known| figure["x-sampled"] == *known), "{key}: {figure}");
                numbers += 1;
            }
        }
        assert!(numbers > 80, "{numbers}");
        assert_eq!(UNITS["rest_depth"], "m");
    }

    #[test]
    fn rows_are_plain_text_whatever_their_size() {
        for size in [1e-30, -2.5e-7, 12_345.0, 3e14, 1e300] {
            let summary =
                json!({ "element_updates": size, "expected_error": size, "peak_depth": size, "final_depth": size });
            let text = describe(&summary);
            assert!(!text.contains(['<', '>', '−', '\u{202f}']), "{text}");
        }
    }

    #[test]
    fn a_list_shows_its_norm_and_an_absent_value_a_dash() {
        let impulse = |value: Value| {
            let values = &json!({ "total_impulse": value });
            figure(&SummaryFigures { values, digits: 4 }, "total_impulse")
        };
        assert_eq!(impulse(json!([3.0, 0.0, 4.0])), "5.000 N s");
        assert_eq!([impulse(json!(null)), impulse(json!([1.0, null, 2.0]))], ["-", "-"]);
    }

    #[test]
    fn a_projectile_that_has_not_left_is_in_contact() {
        let ended = |contact: Value, rebound: Value, depth: f64| {
            let summary = json!({ "rebound_velocity": rebound, "contact_duration": contact, "final_depth": depth });
            describe(&summary)
        };
        let text = ended(json!(1e-3), json!(null), 0.01);
        assert!(text.contains("in contact") && text.contains("stopped early"), "{text}");
        let text = ended(json!(null), json!(null), -0.01);
        assert!(text.contains("none: no contact with the gel"), "{text}");
        assert!(text.contains("none, 10.00 mm above the entry surface"), "{text}");
        let text = ended(json!(1e-3), json!(1.5), 0.08);
        assert!(text.contains("1.500 m/s, still in the gel"), "{text}");
        let text = ended(json!(1e-3), json!(1.5), -0.01);
        assert!(text.contains("1.500 m/s") && !text.contains("still"), "{text}");
    }

    #[test]
    fn a_peak_force_names_its_window_and_a_cavity_that_grows_says_so() {
        let summary = json!({
            "peak_force": 133.0, "force_window": 24e-6, "ended_by": "rest", "completed": true,
            "greatest_cavity_diameter": 0.0954, "cavity_still_opening": true,
        });
        let text = describe(&summary);
        assert!(text.contains("peak force, mean over 24 µs") && text.contains("133.0 N"), "{text}");
        assert!(text.contains("95.40 mm wide") && text.contains("still opening"), "{text}");
        assert!(text.contains("reached, with the projectile at rest, at"), "{text}");
    }

    #[test]
    fn a_projectile_that_perforated_the_gel_left_at_the_back() {
        let summary = json!({
            "completed": true, "ended_by": "exit", "end_time": 4e-3, "perforated": true, "contact_duration": 2e-3,
            "exit_velocity": [0.0, 0.0, -98.5], "exit_time": 1.93e-3, "residual_energy": 38.8, "energy_deposited": 451.2,
        });
        let text = describe(&summary);
        assert!(text.contains("reached, after the exit of the projectile, at 4.000 ms"), "{text}");
        assert!(text.contains("exit: 98.50 m/s at 1.930 ms, 38.80 J retained"), "{text}");
        assert!(text.contains("451.2 J"), "{text}");
    }

    #[test]
    fn gel_that_overlaps_itself_is_said_to_lack_self_contact_only_where_it_does() {
        let overlapping = |name: &str| {
            let scene = scene::read(scene::builtin(name).unwrap()).unwrap();
            let summary = json!({ "overlapped_volume": 2.5e-8, "switched_off": scene::switched_off(&scene) });
            describe(&summary)
        };
        let text = overlapping("sphere-block");
        assert!(text.contains("0.025 cm³ of gel overlap other gel: there is no self-contact"), "{text}");
        // About an axis, and in space, where its limit is named among what is switched off.
        for name in ["fbi-bb", "bullet-yaw"] {
            let text = overlapping(name);
            assert!(
                text.contains("other gel: self-contact stops it there") && !text.contains("no self-contact"),
                "{text}"
            );
        }
    }
}
