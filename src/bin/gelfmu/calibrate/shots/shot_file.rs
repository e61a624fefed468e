//! Table of measured shots: reading of the CSV file, and its errors by line and column.

use super::target::FitTarget;
use crate::calibrate::task;
use crate::failure::CommandError;
use crate::user_table::{TableFault, TableRow, UserTable};
use ballistic_gel::scene::{self, Override};
use csv::StringRecord;
use std::path::Path;

/// Names and texts of the built-in files.
const BUILTIN_FILES: [(&str, &str); 1] = [("gelatin-10", include_str!("../../../../../presets/gelatin-10.csv"))];
/// Columns that a file must have, and columns that it may have.
const COLUMNS: [&str; 9] = ["name", "speed", "measure", "value", "band", "scene", "set", "window", "limit"];
/// Number of [`COLUMNS`] that a file must have.
const REQUIRED_COLUMNS: usize = 5;

/// Measured quantity with the speeds, m/s, of its shots along −z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ShotMeasure {
    /// Rest depth, m.
    Depth {
        /// Speed of the shot; that of the scene if absent.
        speed: Option<f64>,
    },
    /// Change of the rest depth per change of speed, s.
    Slope {
        /// Lower and upper speed.
        speeds: [f64; 2],
    },
    /// Greatest diameter of the cavity over depth and time, m.
    Cavity {
        /// Speed of the shot.
        speed: f64,
    },
}

impl ShotMeasure {
    /// Returns the name in the column `measure`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Depth { .. } => "depth",
            Self::Slope { .. } => "slope",
            Self::Cavity { .. } => "cavity",
        }
    }
}

/// Measured shot.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredShot {
    /// Name.
    pub name: String,
    /// Name of a built-in scene or of a shot of `gelfmu validate`, or path of a scene file; the scene of the command
    /// line if absent.
    pub scene: Option<String>,
    /// Overrides of the scene.
    pub set: Vec<Override>,
    /// Measured quantity.
    pub measure: ShotMeasure,
    /// Measured value.
    pub target: FitTarget,
    /// Factor from the computed value to its limit in fine cells, held during a fit.
    pub limit: f64,
    /// Place in the file for messages; empty for a shot of the command line.
    pub place: String,
}

/// Record of the file with the columns of its cells.
struct ShotRecord<'a> {
    file: &'a str,
    table: &'a UserTable,
    line: u64,
    columns: &'a [&'static str],
    cells: &'a StringRecord,
}

/// Reads the shots of a file, or of a built-in file.
pub fn read(name: &str) -> Result<Vec<MeasuredShot>, CommandError> {
    let builtin = BUILTIN_FILES.iter().find(|(known, _)| *known == name);
    let table = builtin.map_or_else(|| UserTable::read(Path::new(name)), |(_, text)| UserTable::parse(text));
    let table = table.map_err(|fault| {
        let known: Vec<&str> = BUILTIN_FILES.iter().map(|(known, _)| *known).collect();
        let or_builtin = match fault {
            TableFault::Unreadable(_) => format!(" or one of {}", known.join(", ")),
            TableFault::Line { .. } => String::new(),
        };
        CommandError::BadInput(format!("--shots {name}: {fault}{or_builtin}"))
    })?;
    parse(name, &table)
}

/// Parses a table.
fn parse(file: &str, table: &UserTable) -> Result<Vec<MeasuredShot>, CommandError> {
    let columns = parse_header(file, &table.header)?;
    let shot =
        |TableRow { line, cells }: &TableRow| ShotRecord { file, table, line: *line, columns: &columns, cells }.parse();
    table.rows.iter().map(shot).collect()
}

/// Returns the columns of a header; refuses unknown, missing and repeated columns.
fn parse_header(file: &str, header: &TableRow) -> Result<Vec<&'static str>, CommandError> {
    let line = header.line;
    let refuse = |found: String, expected: String| {
        CommandError::BadInput(format!("{file}: line {line}: found {found}, expected {expected}"))
    };
    let mut columns: Vec<&'static str> = vec![];
    for name in &header.cells {
        let Some(column) = COLUMNS.iter().find(|column| **column == name) else {
            let hint = scene::did_you_mean(name, COLUMNS.iter().copied());
            return Err(refuse(format!("the column `{name}`{hint}"), format!("columns of {}", COLUMNS.join(", "))));
        };
        if columns.contains(column) {
            return Err(refuse(format!("the column `{name}` twice"), "each column once".to_owned()));
        }
        columns.push(column);
    }
    let required = &COLUMNS[..REQUIRED_COLUMNS];
    match required.iter().find(|column| !columns.contains(column)) {
        Some(missing) => Err(refuse(format!("no column `{missing}`"), format!("the columns {}", required.join(", ")))),
        None => Ok(columns),
    }
}

impl ShotRecord<'_> {
    /// Parses the shot of the record.
    fn parse(&self) -> Result<MeasuredShot, CommandError> {
        let name = self.text("name");
        if name.is_empty() {
            return Err(self.refuse("name", "a name"));
        }
        let band = self.number("band", "a number above 0, the unit of the residual")?;
        if band <= 0.0 {
            return Err(self.refuse("band", "a number above 0, the unit of the residual"));
        }
        let window =
            if self.text("window").is_empty() { 0.0 } else { self.number("window", "0 or a positive number")? };
        if window < 0.0 {
            return Err(self.refuse("window", "0 or a positive number"));
        }
        let limit = self.positive("limit", 1.0, "a positive factor from the computed value to its limit")?;
        let value = self.number("value", "the value of the shot, a number in SI units")?;
        let scene = Some(self.text("scene").to_owned()).filter(|scene| !scene.is_empty());
        Ok(MeasuredShot {
            name: name.to_owned(),
            scene,
            set: self.parse_set()?,
            measure: self.parse_measure()?,
            target: FitTarget { value, band, window },
            limit,
            place: format!("{}: line {}: ", self.file, self.line),
        })
    }

    /// Parses the measure and its speeds.
    fn parse_measure(&self) -> Result<ShotMeasure, CommandError> {
        let speed = || match self.parse_speeds()?[..] {
            [speed] => Ok(speed),
            _ => Err(self.refuse("speed", "one speed, m/s")),
        };
        match self.text("measure") {
            "depth" => Ok(ShotMeasure::Depth { speed: Some(speed()?) }),
            "cavity" => Ok(ShotMeasure::Cavity { speed: speed()? }),
            "slope" => match self.parse_speeds()?[..] {
                [low, high] if low < high => Ok(ShotMeasure::Slope { speeds: [low, high] }),
                _ => Err(self.refuse("speed", "two speeds of a slope, the lower one first, such as 165/195")),
            },
            _ => Err(self.refuse("measure", "depth (m), slope (s) or cavity (m)")),
        }
    }

    /// Parses the speeds, m/s, which a slash separates.
    fn parse_speeds(&self) -> Result<Vec<f64>, CommandError> {
        let expected = "a positive speed, m/s, or two of a slope: 165/195";
        let speeds: Result<Vec<f64>, &str> =
            self.text("speed").split('/').map(|text| self.table.number(text.trim())).collect();
        let speeds = speeds.map_err(|form| self.refuse("speed", &format!("{expected}, {form}")))?;
        if speeds.iter().any(|speed| *speed <= 0.0) {
            return Err(self.refuse("speed", expected));
        }
        let excess = speeds.iter().find_map(|speed| task::explain_excess_speed(*speed));
        excess.map_or(Ok(speeds), |why| Err(CommandError::BadInput(format!("{}: {why}", self.place("speed")))))
    }

    /// Parses the overrides, which semicolons separate.
    fn parse_set(&self) -> Result<Vec<Override>, CommandError> {
        let entries = self.text("set").split(';').map(str::trim).filter(|entry| !entry.is_empty());
        let parsed: Result<Vec<Override>, _> = entries.map(str::parse::<Override>).collect();
        parsed.map_err(|_| self.refuse("set", "key=value; key=value, such as mesh.size=2e-3"))
    }

    /// Returns the text of a cell; empty if the file does not have the column.
    fn text(&self, column: &str) -> &str {
        self.columns.iter().position(|known| *known == column).and_then(|i| self.cells.get(i)).unwrap_or("")
    }

    /// Parses a finite number.
    fn number(&self, column: &str, expected: &str) -> Result<f64, CommandError> {
        self.table.number(self.text(column)).map_err(|form| self.refuse(column, &format!("{expected}, {form}")))
    }

    /// Parses a positive number; returns the default for an empty cell.
    fn positive(&self, column: &str, default: f64, expected: &str) -> Result<f64, CommandError> {
        let value = if self.text(column).is_empty() { default } else { self.number(column, expected)? };
        if value > 0.0 { Ok(value) } else { Err(self.refuse(column, expected)) }
    }

    /// Returns the file, the line and the column.
    fn place(&self, column: &str) -> String {
        format!("{}: line {}: {column}", self.file, self.line)
    }

    /// Returns the error of a cell.
    fn refuse(&self, column: &str, expected: &str) -> CommandError {
        let text = self.text(column);
        let found = if text.is_empty() { "nothing".to_owned() } else { format!("`{text}`") };
        CommandError::BadInput(format!("{}: found {found}, expected {expected}", self.place(column)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shots_of_a_file_are_read_with_quotes_comments_and_empty_cells() {
        let text = "# measured\nspeed,name,measure,value,band,set,window\n\
                    180,\"BB, steel\",depth,0.085,5e-4,\"mesh.size=1e-3; projectile.position=[0, 0, 1]\",\n\
                    165 / 195,growth,slope,5.1e-4,2e-5,,5e-5\n\n# fast\n720,ball,cavity,0.058,8e-3,,0\n";
        let shots = parse("shots.csv", &UserTable::parse(text).unwrap()).unwrap();
        assert_eq!(shots.len(), 3);
        assert_eq!(
            (shots[0].name.as_str(), shots[0].measure),
            ("BB, steel", ShotMeasure::Depth { speed: Some(180.0) })
        );
        let set: Vec<&str> = shots[0].set.iter().map(|set| set.value.as_str()).collect();
        assert_eq!(set, ["1e-3", "[0, 0, 1]"]);
        assert_eq!(shots[1].measure, ShotMeasure::Slope { speeds: [165.0, 195.0] });
        assert_eq!(shots[1].target, FitTarget { value: 5.1e-4, band: 2e-5, window: 5e-5 });
        assert_eq!(
            (shots[2].measure, shots[2].place.as_str()),
            (ShotMeasure::Cavity { speed: 720.0 }, "shots.csv: line 7: ")
        );
        assert_eq!(shots[2].scene, None);
        assert!(shots.iter().all(|shot| shot.limit == 1.0));
        let limited = UserTable::parse("name,speed,measure,value,band,limit\na,180,depth,0.085,1e-3,1.02\n").unwrap();
        assert_eq!(parse("s.csv", &limited).unwrap()[0].limit, 1.02);
    }

    #[test]
    fn shots_of_a_table_with_semicolons_have_decimal_commas() {
        let rows =
            "name;speed;measure;value;band;set\na;165,5/195;slope;5,1e-4;2e-5;\"mesh.size=1e-3; mesh.cells=2\"\n";
        let shots = parse("s.csv", &UserTable::parse(rows).unwrap()).unwrap();
        assert_eq!(shots[0].measure, ShotMeasure::Slope { speeds: [165.5, 195.0] });
        assert_eq!((shots[0].target.value, shots[0].set.len()), (5.1e-4, 2));
        let mixed = UserTable::parse(&rows.replace("2e-5", "0.2e-4")).unwrap();
        let mixed = parse("s.csv", &mixed).unwrap_err().to_string();
        assert!(
            mixed.contains("s.csv: line 2: value: found `5,1e-4`") && mixed.contains("with a decimal point, as"),
            "{mixed}"
        );
    }

    #[test]
    fn every_builtin_file_is_read() {
        for (name, _) in BUILTIN_FILES {
            assert!(read(name).unwrap().len() >= 3, "{name}");
        }
        let missing = read("nowhere.csv").unwrap_err().to_string();
        assert!(missing.contains("--shots nowhere.csv: found no readable file") && missing.contains("gelatin-10"));
    }

    #[test]
    fn a_faulty_file_is_refused_with_line_column_found_and_expected() {
        let row = |row: &str| format!("name,speed,measure,value,band,window,set\n{row}\n");
        let cases = [
            ("name,speed,measure,value,band,windw\n".to_owned(), "s.csv: line 1: found the column `windw`"),
            (
                "name,speed,measure,value\n".to_owned(),
                "s.csv: line 1: found no column `band`, expected the columns name,",
            ),
            ("name,name,speed,measure,value,band\n".to_owned(), "line 1: found the column `name` twice"),
            (row(",180,depth,0.085,1e-3,,"), "s.csv: line 2: name: found nothing, expected a name"),
            (row("a,180,depth,deep,1e-3,,"), "s.csv: line 2: value: found `deep`, expected the value of the shot"),
            (row("a,180,depth,NaN,1e-3,,"), "value: found `NaN`"),
            (row("a,180,depth,0.085,0,,"), "s.csv: line 2: band: found `0`, expected a number above 0"),
            (row("a,180,depth,0.085,-1e-3,,"), "band: found `-1e-3`, expected a number above 0"),
            (row("a,180,depth,0.085,1e-3,-1,"), "window: found `-1`, expected 0 or a positive number"),
            (row("a,180,width,0.085,1e-3,,"), "measure: found `width`, expected depth (m), slope (s) or cavity (m)"),
            (row("a,fast,depth,0.085,1e-3,,"), "speed: found `fast`, expected a positive speed"),
            (row("a,0,cavity,0.085,1e-3,,"), "speed: found `0`, expected a positive speed"),
            (row("a,165/195,depth,0.085,1e-3,,"), "speed: found `165/195`, expected one speed"),
            (row("a,195/165,slope,5e-4,1e-3,,"), "speed: found `195/165`, expected two speeds of a slope, the lower"),
            (row("a,165,slope,5e-4,1e-3,,"), "speed: found `165`, expected two speeds"),
            (row("a,180000,depth,0.085,1e-3,,"), "s.csv: line 2: speed: found 180000.0 m/s, expected at most"),
            (
                "name,speed,measure,value,band,limit\na,180,depth,0.085,1e-3,0\n".to_owned(),
                "limit: found `0`, expected a positive",
            ),
            (row("a,180,depth,0.085,1e-3,,mesh.size"), "set: found `mesh.size`, expected key=value"),
        ];
        for (text, message) in cases {
            let refused = parse("s.csv", &UserTable::parse(&text).unwrap()).unwrap_err().to_string();
            assert!(refused.contains(message), "{text}: {refused}");
        }
    }
}
