//! `history.csv`: one row per communication step, complete on disk after each row.

use super::files::{OutputError, format_cell, parse_cell, with_path};
#[cfg(feature = "cli")]
use super::reading::{MOST_RESULT_BYTES, read_limited_text};
use crate::scene::Scene;
use crate::simulation::{BlockMotion, BodyReport, Observation, SensorReport, ShapeMotion};
use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Column of the table: name with unit, and value.
type HistoryColumn = (&'static str, fn(&Observation) -> f64);

const COLUMNS: [HistoryColumn; 71] = [
    ("time_s", |o| o.time),
    ("position_x_m", |o| o.projectile().kinematics.position.x),
    ("position_y_m", |o| o.projectile().kinematics.position.y),
    ("position_z_m", |o| o.projectile().kinematics.position.z),
    ("velocity_x_m_per_s", |o| o.projectile().kinematics.velocity.x),
    ("velocity_y_m_per_s", |o| o.projectile().kinematics.velocity.y),
    ("velocity_z_m_per_s", |o| o.projectile().kinematics.velocity.z),
    ("orientation_w", |o| o.projectile().kinematics.orientation[0]),
    ("orientation_x", |o| o.projectile().kinematics.orientation[1]),
    ("orientation_y", |o| o.projectile().kinematics.orientation[2]),
    ("orientation_z", |o| o.projectile().kinematics.orientation[3]),
    ("angular_velocity_x_rad_per_s", |o| o.projectile().kinematics.angular_velocity.x),
    ("angular_velocity_y_rad_per_s", |o| o.projectile().kinematics.angular_velocity.y),
    ("angular_velocity_z_rad_per_s", |o| o.projectile().kinematics.angular_velocity.z),
    ("yaw_rad", |o| o.projectile().kinematics.yaw_from(&o.block.velocity)),
    ("depth_m", |o| o.projectile().depth),
    ("expansion", |o| o.projectile().expansion()),
    ("impulse_x_N_s", |o| o.projectile().exchange.impulse.x),
    ("impulse_y_N_s", |o| o.projectile().exchange.impulse.y),
    ("impulse_z_N_s", |o| o.projectile().exchange.impulse.z),
    ("angular_impulse_x_N_m_s", |o| o.projectile().exchange.angular_impulse.x),
    ("angular_impulse_y_N_m_s", |o| o.projectile().exchange.angular_impulse.y),
    ("angular_impulse_z_N_m_s", |o| o.projectile().exchange.angular_impulse.z),
    ("force_x_N", |o| o.projectile().exchange.mean_force().x),
    ("force_y_N", |o| o.projectile().exchange.mean_force().y),
    ("force_z_N", |o| o.projectile().exchange.mean_force().z),
    ("total_impulse_x_N_s", |o| o.projectile().contact.total_impulse.x),
    ("total_impulse_y_N_s", |o| o.projectile().contact.total_impulse.y),
    ("total_impulse_z_N_s", |o| o.projectile().contact.total_impulse.z),
    ("contact_area_m2", |o| o.projectile().contact.area),
    ("penetration_m", |o| o.projectile().contact.penetration),
    ("energy_kinetic_J", |o| o.energy.kinetic),
    ("energy_projectile_J", |o| o.energy.projectile),
    ("energy_elastic_J", |o| o.energy.elastic),
    ("energy_contact_J", |o| o.energy.contact),
    ("energy_self_contact_J", |o| o.energy.self_contact),
    ("energy_friction_J", |o| o.energy.friction),
    ("energy_contact_bias_J", |o| o.energy.contact_bias),
    ("energy_integration_J", |o| o.energy.integration),
    ("energy_external_J", |o| o.energy.external),
    ("energy_importer_J", |o| o.energy.importer),
    ("energy_expansion_J", |o| o.energy.expansion),
    ("energy_remesh_J", |o| o.energy.remesh),
    ("energy_remesh_returned_J", |o| o.energy.remesh_returned),
    ("energy_load_J", |o| o.energy.load),
    ("energy_air_J", |o| o.energy.air),
    ("energy_damping_J", |o| o.energy.damping),
    ("energy_bulk_viscous_J", |o| o.energy.bulk_viscous),
    ("energy_viscous_J", |o| o.energy.viscous),
    ("energy_eroded_J", |o| o.energy.eroded),
    ("energy_damage_J", |o| o.energy.damage),
    ("energy_imbalance_J", |o| o.energy.imbalance),
    ("energy_error", |o| o.energy.energy_error),
    ("momentum_imbalance_x_N_s", |o| o.momentum_imbalance.x),
    ("momentum_imbalance_y_N_s", |o| o.momentum_imbalance.y),
    ("momentum_imbalance_z_N_s", |o| o.momentum_imbalance.z),
    ("momentum_error", |o| o.momentum_error),
    ("angular_momentum_imbalance_x_N_m_s", |o| o.angular_momentum_imbalance.x),
    ("angular_momentum_imbalance_y_N_m_s", |o| o.angular_momentum_imbalance.y),
    ("angular_momentum_imbalance_z_N_m_s", |o| o.angular_momentum_imbalance.z),
    ("angular_momentum_error", |o| o.angular_momentum_error),
    ("element_updates", |o| o.cost.element_updates),
    ("min_jacobian", |o| o.cost.min_jacobian),
    ("remeshes", |o| o.cost.remeshes as f64),
    ("incompatible_fraction", |o| o.cost.incompatible_fraction),
    ("block_displacement_x_m", |o| o.block.displacement.x),
    ("block_displacement_y_m", |o| o.block.displacement.y),
    ("block_displacement_z_m", |o| o.block.displacement.z),
    ("block_velocity_x_m_per_s", |o| o.block.velocity.x),
    ("block_velocity_y_m_per_s", |o| o.block.velocity.y),
    ("block_velocity_z_m_per_s", |o| o.block.velocity.z),
];

/// Column of a fragment, behind [`COLUMNS`]; the name follows `fragment1_`, `fragment2_`, …
type FragmentColumn = (&'static str, fn(&BodyReport, &BlockMotion) -> f64);

const FRAGMENT_COLUMNS: [FragmentColumn; 24] = [
    ("active", |b, _| f64::from(u8::from(b.active))),
    ("position_x_m", |b, _| b.kinematics.position.x),
    ("position_y_m", |b, _| b.kinematics.position.y),
    ("position_z_m", |b, _| b.kinematics.position.z),
    ("velocity_x_m_per_s", |b, _| b.kinematics.velocity.x),
    ("velocity_y_m_per_s", |b, _| b.kinematics.velocity.y),
    ("velocity_z_m_per_s", |b, _| b.kinematics.velocity.z),
    ("orientation_w", |b, _| b.kinematics.orientation[0]),
    ("orientation_x", |b, _| b.kinematics.orientation[1]),
    ("orientation_y", |b, _| b.kinematics.orientation[2]),
    ("orientation_z", |b, _| b.kinematics.orientation[3]),
    ("angular_velocity_x_rad_per_s", |b, _| b.kinematics.angular_velocity.x),
    ("angular_velocity_y_rad_per_s", |b, _| b.kinematics.angular_velocity.y),
    ("angular_velocity_z_rad_per_s", |b, _| b.kinematics.angular_velocity.z),
    ("yaw_rad", |b, block| b.kinematics.yaw_from(&block.velocity)),
    ("depth_m", |b, _| b.depth),
    ("impulse_x_N_s", |b, _| b.exchange.impulse.x),
    ("impulse_y_N_s", |b, _| b.exchange.impulse.y),
    ("impulse_z_N_s", |b, _| b.exchange.impulse.z),
    ("bulge_height_m", |b, _| bulge_size(b, 0)),
    ("bulge_radius_m", |b, _| bulge_size(b, 1)),
    ("bulge_height_impulse_N_s", |b, _| bulge_impulse(b, 0)),
    ("bulge_radius_impulse_N_s", |b, _| bulge_impulse(b, 1)),
    ("expansion", |b, _| b.expansion()),
];

/// Returns height or base radius of a dome, m; 0 for any other body.
fn bulge_size(body: &BodyReport, i: usize) -> f64 {
    body.shape_motion.as_ref().and_then(ShapeMotion::bulge).map_or(0.0, |bulge| bulge.size[i])
}

/// Returns the impulse on height or base radius of a dome, N·s; 0 for any other body.
fn bulge_impulse(body: &BodyReport, i: usize) -> f64 {
    body.shape_motion.as_ref().and_then(ShapeMotion::bulge).map_or(0.0, |_| body.exchange.shape_impulse[i])
}

/// Column of a sensor, behind the columns of the fragments; the name follows `sensor1_`, `sensor2_`, …
type SensorColumn = (&'static str, fn(&SensorReport) -> f64);

const SENSOR_COLUMNS: [SensorColumn; 7] = [
    ("pressure_Pa", |s| s.pressure),
    ("displacement_x_m", |s| s.displacement.x),
    ("displacement_y_m", |s| s.displacement.y),
    ("displacement_z_m", |s| s.displacement.z),
    ("velocity_x_m_per_s", |s| s.velocity.x),
    ("velocity_y_m_per_s", |s| s.velocity.y),
    ("velocity_z_m_per_s", |s| s.velocity.z),
];

fn column_names(n_fragments: usize, n_sensors: usize) -> String {
    let own = COLUMNS.iter().map(|(name, _)| (*name).to_owned());
    let fragment = |i: usize| FRAGMENT_COLUMNS.iter().map(move |(name, _)| format!("fragment{i}_{name}"));
    let sensor = |i: usize| SENSOR_COLUMNS.iter().map(move |(name, _)| format!("sensor{i}_{name}"));
    let others = (1..=n_fragments).flat_map(fragment).chain((1..=n_sensors).flat_map(sensor));
    own.chain(others).collect::<Vec<_>>().join(",")
}

fn row_text(observation: &Observation) -> String {
    let own = COLUMNS.iter().map(|(_, value)| value(observation));
    let block = &observation.block;
    let of_fragment = |fragment| FRAGMENT_COLUMNS.iter().map(move |(_, value)| value(fragment, block));
    let of_sensor = |sensor| SENSOR_COLUMNS.iter().map(move |(_, value)| value(sensor));
    let all = own.chain(observation.bodies[1..].iter().flat_map(of_fragment));
    let all = all.chain(observation.sensors.iter().flat_map(of_sensor));
    all.map(format_cell).collect::<Vec<_>>().join(",")
}

/// Row of the history, read back from the file.
pub(super) struct HistoryRow(Vec<f64>);

impl HistoryRow {
    /// Returns the value in the named column.
    pub(super) fn get(&self, name: &str) -> f64 {
        let column = COLUMNS.iter().position(|(known, _)| *known == name);
        self.0[column.unwrap_or_else(|| panic!("history has no column {name}"))]
    }

    /// Returns the columns of sensor `i` out of `n`, counted from 0. The sensors are the last columns of a row.
    pub(super) fn sensor(&self, i: usize, n: usize) -> &[f64] {
        let first = self.0.len() - (n - i) * SENSOR_COLUMNS.len();
        &self.0[first..first + SENSOR_COLUMNS.len()]
    }

    /// Returns the x, y and z columns of a vector: `vector("position_", "_m")`.
    pub(super) fn vector(&self, before: &str, after: &str) -> crate::math::Vector3 {
        ["x", "y", "z"].map(|axis| self.get(&format!("{before}{axis}{after}"))).into()
    }
}

/// Time and end of a row in the file.
#[derive(Debug, Clone, Copy)]
struct RowEnd {
    /// Time, s.
    time: f64,
    /// Offset of the end of the row, bytes.
    offset: u64,
}

/// History file, open for appending.
#[derive(Debug)]
pub(super) struct HistoryFile {
    path: PathBuf,
    file: File,
    /// Length of the header line, bytes.
    header: u64,
    /// Number of columns.
    columns: usize,
    /// Rows of the file in order.
    rows: Vec<RowEnd>,
}

impl HistoryFile {
    /// Creates a history file with the header alone.
    pub(super) fn create(path: &Path, scene: &Scene) -> Result<Self, OutputError> {
        let names = column_names(scene.fragment.len(), scene.sensor.len()) + "\n";
        let open = || {
            let mut file = OpenOptions::new().read(true).write(true).create(true).truncate(true).open(path)?;
            file.write_all(names.as_bytes())?;
            Ok(file)
        };
        let file = open().map_err(with_path(path))?;
        let (header, columns) = (names.len() as u64, names.split(',').count());
        Ok(Self { path: path.to_path_buf(), file, header, columns, rows: Vec::new() })
    }

    /// Sets the path after the file was moved.
    pub(super) fn set_path(&mut self, path: PathBuf) {
        self.path = path;
    }

    /// Appends one row in a single write, therefore a killed process leaves whole rows.
    pub(super) fn append(&mut self, observation: &Observation) -> Result<(), OutputError> {
        let line = row_text(observation) + "\n";
        self.file.write_all(line.as_bytes()).map_err(with_path(&self.path))?;
        self.rows.push(RowEnd { time: observation.time, offset: self.end_offset() + line.len() as u64 });
        Ok(())
    }

    /// Drops the rows after `time`, s.
    pub(super) fn rewind(&mut self, time: f64) -> Result<(), OutputError> {
        self.rows.truncate(self.rows.partition_point(|row| row.time <= time));
        let end = self.end_offset();
        let cut = |file: &mut File| file.set_len(end).and_then(|()| file.seek(SeekFrom::Start(end)));
        cut(&mut self.file).map(|_| ()).map_err(with_path(&self.path))
    }

    /// Calls `show` with every row of the file.
    pub(super) fn for_each_row(&self, mut show: impl FnMut(&HistoryRow)) -> Result<(), OutputError> {
        let mut read_file = |file| {
            for line in BufReader::new(file).lines().skip(1) {
                show(&parse_row(&line?, self.columns)?);
            }
            Ok(())
        };
        File::open(&self.path).and_then(&mut read_file).map_err(with_path(&self.path))
    }

    fn end_offset(&self) -> u64 {
        self.rows.last().map_or(self.header, |row| row.offset)
    }
}

/// Reads at most `limit` rows of the history of a scene, evenly spaced by number, the last row included.
#[cfg(feature = "cli")]
pub(super) fn read_thinned(path: &Path, scene: &Scene, limit: usize) -> io::Result<Vec<HistoryRow>> {
    let text = read_limited_text(path, MOST_RESULT_BYTES)?;
    let columns = column_names(scene.fragment.len(), scene.sensor.len()).split(',').count();
    let lines: Vec<&str> = text.lines().skip(1).collect();
    let (stride, last) = (lines.len().div_ceil(limit).max(1), lines.len().saturating_sub(1));
    let wanted = lines.iter().enumerate().filter(|(i, _)| (last - i).is_multiple_of(stride));
    wanted.map(|(_, line)| parse_row(line, columns)).collect()
}

fn parse_row(line: &str, columns: usize) -> io::Result<HistoryRow> {
    let values: Result<Vec<f64>, _> = line.split(',').map(parse_cell).collect();
    match values {
        Ok(values) if values.len() == columns => Ok(HistoryRow(values)),
        _ => Err(io::Error::new(io::ErrorKind::InvalidData, "a row has other columns than gelfmu writes")),
    }
}
