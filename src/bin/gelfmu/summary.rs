//! Table of the figures of a run for the console.

use ballistic_gel::output::{figure_rows, layer_rows};
use ballistic_gel::scene::Scene;
use comfy_table::{Table, presets};
use serde_json::Value;
use std::path::Path;

/// Formats the summary of a run as a table, with one row for each layer, followed by the result files.
pub fn describe(summary: &Value, scene: &Scene, folder: &Path) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    for row in figure_rows(summary, scene).into_iter().chain(layer_rows(folder, scene)) {
        table.add_row([row.name, row.text]);
    }
    format!("{table}\n{}", list_files(folder))
}

fn list_files(folder: &Path) -> String {
    const FILES: [(&str, &str); 9] = [
        ("report.html", "the report, for a browser"),
        ("series.pvd", "the frames, for ParaView"),
        ("history.csv", "one row per communication step"),
        ("shot.csv", "speed, force and energy by depth"),
        ("cavity.csv", "radius and diameter of the cavity by time and depth"),
        ("track.csv", "permanent track and energy per centimetre by depth"),
        ("cracks.csv", "estimated crack length of each centimetre"),
        ("layers.csv", "speed at entry and energy of each layer"),
        ("summary.json", "the figures above"),
    ];
    let written = FILES.into_iter().filter(|(name, _)| folder.join(name).exists());
    let lines: Vec<String> = written.map(|(name, what)| format!("{}  {what}", folder.join(name).display())).collect();
    lines.join("\n")
}
