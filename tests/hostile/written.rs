//! Files of a run: numbers that are none must not be in them.

#[path = "../output/grid.rs"]
pub mod grid;

use std::fs;
use std::path::Path;

/// Most bytes of a text file of a short run: its tables have a bounded number of rows.
const MOST_BYTES: u64 = 8_000_000;

/// Names the first file of a folder of results that holds a value that is not finite, or is too long.
pub fn defect(folder: &Path) -> Result<(), String> {
    for name in ["history.csv", "shot.csv", "cavity.csv", "track.csv", "cracks.csv", "layers.csv"] {
        checked(&folder.join(name), table)?;
    }
    for name in ["summary.json", "report.html", "series.pvd"] {
        checked(&folder.join(name), text)?;
    }
    let frames = fs::read_dir(folder.join("frames")).into_iter().flatten().flatten();
    for entry in frames {
        checked(&entry.path(), grid)?;
    }
    Ok(())
}

fn checked(path: &Path, check: impl Fn(&[u8]) -> Result<(), String>) -> Result<(), String> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    match fs::metadata(path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Ok(found) if found.len() <= MOST_BYTES => {}
        found => return Err(format!("{name}: {found:?}")),
    }
    let bytes = fs::read(path).map_err(|error| format!("{name}: {error}"))?;
    check(&bytes).map_err(|found| format!("{name}: {found}"))
}

/// Cells are empty or finite numbers, but for the names of layers.
fn table(bytes: &[u8]) -> Result<(), String> {
    let text = String::from_utf8_lossy(bytes);
    let names: Vec<&str> = text.lines().next().unwrap_or_default().split(',').collect();
    for (row, line) in text.lines().enumerate().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let is_sound = |(name, cell): (&&str, &&str)| {
            cell.is_empty() || *name == "layer" || cell.parse().is_ok_and(f64::is_finite)
        };
        if cells.len() != names.len() {
            return Err(format!("row {row} has {} cells", cells.len()));
        }
        if let Some(column) = names.iter().zip(&cells).position(|cell| !is_sound(cell)) {
            return Err(format!("{} is {} in row {row}", names[column], cells[column]));
        }
    }
    Ok(())
}

/// No word is that of a number that is none; pictures do not count.
fn text(bytes: &[u8]) -> Result<(), String> {
    let text = String::from_utf8_lossy(bytes);
    for (i, part) in text.split("base64,").enumerate() {
        let part = if i == 0 { part } else { part.split_once('"').map_or("", |(_, rest)| rest) };
        let mut words = part.split(|c: char| !c.is_alphanumeric());
        if let Some(word) = words.find(|word| ["NaN", "nan", "inf"].contains(word)) {
            return Err(format!("{word} is in it"));
        }
    }
    Ok(())
}

/// Floating-point arrays of a grid are finite.
fn grid(bytes: &[u8]) -> Result<(), String> {
    for grid::GridArray { line, bytes: data } in grid::arrays(bytes) {
        let value = |key: &str| line.split_once(key).and_then(|(_, rest)| rest.split_once('"')).map(|(value, _)| value);
        let (kind, name) = (value("type=\"").unwrap_or_default(), value("Name=\"").unwrap_or_default());
        let is_finite = match kind {
            "Float32" => data.as_chunks().0.iter().all(|bytes| f32::from_le_bytes(*bytes).is_finite()),
            "Float64" => data.as_chunks().0.iter().all(|bytes| f64::from_le_bytes(*bytes).is_finite()),
            _ => true,
        };
        if !is_finite {
            return Err(format!("{name} holds a number that is not finite"));
        }
    }
    Ok(())
}
