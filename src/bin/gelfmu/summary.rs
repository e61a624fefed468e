//! Table of the figures in `summary.json` for the console.

use ballistic_gel::output::peak_force_label;
use comfy_table::{Table, presets};
use serde_json::Value;
use std::path::Path;

/// Formats the summary of a run as a table, followed by the result files.
pub fn describe(summary: &Value, folder: &Path) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    let shot = [cavity_row(summary), course_row(summary), track_row(summary), neck_row(summary), overlap_row(summary)];
    let peak_force = peak_force_label(summary["force_window"].as_f64().unwrap_or(f64::NAN));
    for (name, text) in summary_rows(summary, &peak_force).into_iter().chain(shot.into_iter().flatten()) {
        table.add_row([name, &text]);
    }
    format!("{table}\n{}", list_files(folder))
}

fn summary_rows<'a>(s: &Value, peak_force: &'a str) -> Vec<(&'a str, String)> {
    vec![
        ("end", format!("{} at {}", describe_completion(s), format_quantity(&s["end_time"], "s"))),
        ("mesh", format!("{} elements, {} nodes", format_count(&s["elements"]), format_count(&s["nodes"]))),
        (
            "element time steps",
            format!("{} to {}", format_quantity(&s["smallest_step"], "s"), format_quantity(&s["largest_step"], "s")),
        ),
        ("element updates", describe_updates(s)),
        ("greatest depth", describe_peak_depth(s)),
        ("depth at the end", format_depth(&s["final_depth"])),
        ("rest depth", describe_rest(s)),
        ("speed at the end", format_quantity(&s["final_velocity"], "m/s")),
        ("rebound velocity", describe_rebound(s)),
        ("energy deposited", format_quantity(&s["energy_deposited"], "J")),
        ("contact duration", format_quantity(&s["contact_duration"], "s")),
        (peak_force, format_quantity(&s["peak_force"], "N")),
        ("total impulse", format_quantity(&s["total_impulse"], "N s")),
        (
            "energy",
            format!("imbalance {}, defect {}", format_small(&s["energy_error"]), format_small(&s["energy_defect"])),
        ),
        (
            "momentum",
            format!("{}, angular {}", format_small(&s["momentum_error"]), format_small(&s["angular_momentum_error"])),
        ),
        ("expected error", format_percent(&s["expected_error"])),
        ("model error", format_percent(&s["model_error"])),
        ("wall time", format_quantity(&s["wall_seconds"], "s")),
        ("CPU time", format_quantity(&s["cpu_seconds"], "s")),
        ("digest", s["digest"].as_str().unwrap_or("-").to_owned()),
    ]
}

/// Returns the row of the temporary cavity of a shot.
fn cavity_row(s: &Value) -> Option<(&'static str, String)> {
    s["greatest_cavity_diameter"].as_f64()?;
    let [greatest, last] =
        ["greatest_cavity_diameter", "final_cavity_diameter"].map(|key| format_quantity(&s[key], "m"));
    let time = format_quantity(&s["time_of_greatest_cavity"], "s");
    let still = if s["cavity_still_opening"] == Value::Bool(true) { ", still opening" } else { "" };
    let place =
        s["depth_of_greatest_cavity"].as_f64().map_or(String::new(), |depth| format!(" {:.0} mm deep", 1e3 * depth));
    Some(("cavity", format!("{greatest} wide{place} at {time}, {last} at the end{still}")))
}

/// Returns the row of the collapse and the pulsation of the cavity.
fn course_row(s: &Value) -> Option<(&'static str, String)> {
    s["time_of_cavity_collapse"].as_f64()?;
    let collapse = format!("below 40 % of its diameter at {}", format_quantity(&s["time_of_cavity_collapse"], "s"));
    let pulsation = s["cavity_pulsation_diameter"].as_f64().map(|_| {
        let [diameter, time] = [("cavity_pulsation_diameter", "m"), ("time_of_cavity_pulsation", "s")]
            .map(|(key, unit)| format_quantity(&s[key], unit));
        format!(", again {diameter} wide at {time}")
    });
    Some(("collapse of the cavity", collapse + &pulsation.unwrap_or_default()))
}

/// Returns the row of the permanent track in a damaged gel.
fn track_row(s: &Value) -> Option<(&'static str, String)> {
    s["greatest_track_diameter"].as_f64().filter(|diameter| *diameter > 0.0)?;
    Some(("permanent track", format!("{} wide at most", format_quantity(&s["greatest_track_diameter"], "m"))))
}

/// Returns the row of the neck of a bullet that turns over.
fn neck_row(s: &Value) -> Option<(&'static str, String)> {
    s["neck_length"].as_f64()?;
    Some(("neck", format!("{}, then the yaw passes 30°", format_quantity(&s["neck_length"], "m"))))
}

/// Returns a row that marks a run in which the gel overlaps itself, with or without self-contact.
fn overlap_row(s: &Value) -> Option<(&'static str, String)> {
    let volume = s["overlapped_volume"].as_f64().filter(|volume| *volume > 0.0)?;
    let mut off = s["switched_off"].as_array().into_iter().flatten().filter_map(Value::as_str);
    let cause = if off.any(|entry| entry.starts_with("self-contact of the gel: none")) {
        "there is no self-contact"
    } else {
        "self-contact stops it there and does not push it out"
    };
    Some(("self-overlap", format!("{:.3} cm³ of gel overlap other gel: {cause}", 1e6 * volume)))
}

fn describe_completion(s: &Value) -> &'static str {
    match (s["completed"].as_bool(), s["ended_by"].as_str()) {
        (Some(true), Some("exit")) => "reached, after the exit of the projectile,",
        (Some(true), Some("rest")) => "reached, with the projectile at rest,",
        (Some(true), _) => "reached",
        _ => "stopped early",
    }
}

/// Describes the exit of a projectile that has perforated the gel.
fn describe_perforation(s: &Value) -> String {
    let [velocity, time] =
        [("exit_velocity", "m/s"), ("exit_time", "s")].map(|(key, unit)| format_quantity(&s[key], unit));
    format!("none: perforated, exit at {velocity} and {time}, {} retained", format_quantity(&s["residual_energy"], "J"))
}

fn describe_peak_depth(s: &Value) -> String {
    format!("{} at {}", format_depth(&s["peak_depth"]), format_quantity(&s["time_of_peak_depth"], "s"))
}

/// Describes the rest of the projectile in the gel.
fn describe_rest(s: &Value) -> String {
    match s["rest_depth"].as_f64() {
        Some(_) => format!("{} from {}", format_depth(&s["rest_depth"]), format_quantity(&s["time_of_rest"], "s")),
        None => "none: the nose moves by 0.2 mm or more in the last millisecond (a later scene.end_time may show it), or is \
                 not in the gel"
            .to_owned(),
    }
}

/// Formats a depth, or the height above the entry surface if it is negative.
fn format_depth(value: &Value) -> String {
    match value.as_f64() {
        Some(depth) if depth < 0.0 => {
            format!("none, {} above the entry surface", format_quantity(&Value::from(-depth), "m"))
        }
        _ => format_quantity(value, "m"),
    }
}

fn describe_updates(s: &Value) -> String {
    let (done, synchronous) = (&s["element_updates"], &s["synchronous_updates"]);
    format!(
        "{}, {} with one global step, {} per second",
        format_count(done),
        format_count(synchronous),
        format_count(&s["updates_per_second"])
    )
}

fn describe_rebound(s: &Value) -> String {
    let speed = || format_quantity(&s["rebound_velocity"], "m/s");
    if s["perforated"] == Value::Bool(true) {
        return describe_perforation(s);
    }
    match (s["rebound_velocity"].as_f64(), s["contact_duration"].as_f64(), s["final_depth"].as_f64()) {
        (_, None, _) => "none: no contact with the gel".to_owned(),
        (None, Some(_), _) => "none yet: in contact, or contact ended too recently".to_owned(),
        (Some(back), _, Some(depth)) if back > 0.0 && depth > 0.0 => format!("{}, still in the gel", speed()),
        (Some(_), ..) => speed(),
    }
}

/// Formats a number with four digits and an SI prefix; an array is replaced by its norm.
fn format_quantity(value: &Value, unit: &str) -> String {
    const PREFIXES: [(f64, &str); 6] = [(1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n")];
    let Some(number) = to_number(value) else { return "-".to_owned() };
    let size = number.abs();
    let fits = PREFIXES.into_iter().find(|(scale, _)| size >= 0.9999 * scale);
    let (scale, prefix) = if size == 0.0 { (1.0, "") } else { fits.unwrap_or((1e-9, "n")) };
    let scaled = number / scale;
    let decimals = if scaled.abs() >= 99.995 { 1 } else { 3 };
    format!("{scaled:.decimals$} {prefix}{unit}")
}

fn to_number(value: &Value) -> Option<f64> {
    match value {
        Value::Array(parts) => parts.iter().map(Value::as_f64).sum::<Option<f64>>().map(|_| euclidean_norm(parts)),
        other => other.as_f64(),
    }
}

fn euclidean_norm(parts: &[Value]) -> f64 {
    parts.iter().filter_map(Value::as_f64).map(|part| part * part).sum::<f64>().sqrt()
}

fn format_count(value: &Value) -> String {
    value
        .as_f64()
        .map_or("-".to_owned(), |n| if n < 1e6 { format!("{n:.0}") } else { format!("{:.3} million", n * 1e-6) })
}

fn format_percent(value: &Value) -> String {
    value.as_f64().map_or("not measured for these values".to_owned(), |part| format!("{:.2} %", 100.0 * part))
}

fn format_small(value: &Value) -> String {
    value.as_f64().map_or("-".to_owned(), |x| format!("{x:.1e}"))
}

fn list_files(folder: &Path) -> String {
    const FILES: [(&str, &str); 7] = [
        ("report.html", "the report, for a browser"),
        ("series.pvd", "the frames, for ParaView"),
        ("history.csv", "one row per communication step"),
        ("shot.csv", "speed, force and energy by depth"),
        ("cavity.csv", "radius and diameter of the cavity by time and depth"),
        ("track.csv", "permanent track and energy per centimetre by depth"),
        ("summary.json", "the figures above"),
    ];
    let written = FILES.into_iter().filter(|(name, _)| folder.join(name).exists());
    let lines: Vec<String> = written.map(|(name, what)| format!("{}  {what}", folder.join(name).display())).collect();
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::{describe, format_quantity};
    use ballistic_gel::scene;
    use serde_json::{Value, json};
    use std::path::Path;

    #[test]
    fn quantities_carry_the_prefix_that_fits() {
        assert_eq!(format_quantity(&json!(0.01405), "m"), "14.050 mm");
        assert_eq!(format_quantity(&json!(1e-5), "s"), "10.000 µs");
        assert_eq!(format_quantity(&json!(1e-3), "s"), "1.000 ms");
        assert_eq!(format_quantity(&json!(-1234.5), "N"), "-1.234 kN");
        assert_eq!(format_quantity(&json!(0.0), "m"), "0.000 m");
        assert_eq!(format_quantity(&json!(350), "N"), "350.0 N");
        assert_eq!(format_quantity(&json!(2e-13), "m"), "0.000 nm");
    }

    #[test]
    fn a_list_shows_its_norm_and_an_absent_value_a_dash() {
        assert_eq!(format_quantity(&json!([3.0, 0.0, 4.0]), "N s"), "5.000 N s");
        assert_eq!(format_quantity(&json!(null), "m"), "-");
        assert_eq!(format_quantity(&json!([1.0, null, 2.0]), "m"), "-");
    }

    #[test]
    fn a_projectile_that_has_not_left_is_in_contact() {
        let ended = |contact: Value, rebound: Value, depth: f64| {
            let summary = json!({ "rebound_velocity": rebound, "contact_duration": contact, "final_depth": depth });
            describe(&summary, Path::new("nowhere"))
        };
        let text = ended(json!(1e-3), json!(null), 0.01);
        assert!(text.contains("in contact") && text.contains("stopped early"), "{text}");
        let text = ended(json!(null), json!(null), -0.01);
        assert!(text.contains("none: no contact with the gel"), "{text}");
        assert!(text.contains("none, 10.000 mm above the entry surface"), "{text}");
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
        let text = describe(&summary, Path::new("nowhere"));
        assert!(text.contains("peak force, mean over 24 µs") && text.contains("133.0 N"), "{text}");
        assert!(text.contains("95.400 mm wide") && text.contains("still opening"), "{text}");
        assert!(text.contains("reached, with the projectile at rest, at"), "{text}");
    }

    #[test]
    fn a_projectile_that_perforated_the_gel_left_at_the_back() {
        let summary = json!({
            "completed": true, "ended_by": "exit", "end_time": 4e-3, "perforated": true, "contact_duration": 2e-3,
            "exit_velocity": [0.0, 0.0, -98.5], "exit_time": 1.93e-3, "residual_energy": 38.8, "energy_deposited": 451.2,
        });
        let text = describe(&summary, Path::new("nowhere"));
        assert!(text.contains("reached, after the exit of the projectile, at 4.000 ms"), "{text}");
        assert!(text.contains("none: perforated, exit at 98.500 m/s and 1.930 ms, 38.800 J retained"), "{text}");
        assert!(text.contains("451.2 J"), "{text}");
    }

    #[test]
    fn gel_that_overlaps_itself_is_said_to_lack_self_contact_only_where_it_does() {
        let overlapping = |name: &str| {
            let scene = scene::read(scene::builtin(name).unwrap()).unwrap();
            let summary = json!({ "overlapped_volume": 2.5e-8, "switched_off": scene::switched_off(&scene) });
            describe(&summary, Path::new("nowhere"))
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
