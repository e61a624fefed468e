//! Sensor figures of a run, evaluated from the history.

use super::files::OutputError;
use super::history::{HistoryFile, HistoryRow};
use crate::scene::Scene;
use serde::{Deserialize, Serialize};

/// Figures of a sensor, evaluated from the rows of the history, one row per communication step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct SensorFigures {
    /// Position of the sensor in the gel at rest, m.
    #[serde(deserialize_with = "super::numbers::vector")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m", "x-sampled" = "start")))]
    pub position: [f64; 3],
    /// Greatest pressure, Pa.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "Pa", "x-sampled" = "step")))]
    pub peak_pressure: f64,
    /// Time of the greatest pressure, s.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "s", "x-sampled" = "step")))]
    pub time_of_peak_pressure: f64,
    /// Greatest rate of the pressure between consecutive rows, Pa/s.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "Pa/s", "x-sampled" = "step")))]
    pub peak_pressure_rate: f64,
    /// Time of the greatest rate, s: the middle between the two rows.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "s", "x-sampled" = "step")))]
    pub time_of_peak_pressure_rate: f64,
    /// Dent of the entry surface, for a sensor on the surface.
    pub dent: Option<DentFigures>,
}

/// Dent of the entry surface of a block or a cylinder at one point, measured against the block.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct DentFigures {
    /// Greatest depth, m.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m", "x-sampled" = "step")))]
    pub depth: f64,
    /// Time of the greatest depth, s.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "s", "x-sampled" = "step")))]
    pub time_of_depth: f64,
    /// Viscous criterion VC_max = max V(t) C(t), m/s (Lau & Viano 1986). V is the speed of the dent and C the ratio
    /// of dent depth to gel height; the paper takes the deflection relative to the chest depth.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m/s", "x-sampled" = "step")))]
    pub viscous_criterion: f64,
    /// Time of the viscous criterion, s.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "s", "x-sampled" = "step")))]
    pub time_of_viscous_criterion: f64,
}

/// Greatest value and its time.
#[derive(Clone, Copy, Default)]
struct PeakValue {
    value: f64,
    time: f64,
}

impl PeakValue {
    fn update(&mut self, value: f64, time: f64) {
        if value > self.value {
            *self = Self { value, time };
        }
    }
}

/// Greatest values of a sensor so far.
#[derive(Clone, Default)]
struct SensorPeaks {
    /// Time, s, and pressure, Pa, of the previous row.
    before: Option<(f64, f64)>,
    pressure: PeakValue,
    rate: PeakValue,
    dent: PeakValue,
    criterion: PeakValue,
}

impl SensorPeaks {
    /// Adds a row: the columns of the sensor, height and velocity of a block that moves along z.
    fn update(&mut self, time: f64, columns: &[f64], block: [f64; 2]) {
        let &[pressure, _, _, height, _, _, velocity] = columns else { unreachable!("a sensor has seven columns") };
        let (height, velocity) = (height - block[0], velocity - block[1]);
        self.pressure.update(pressure, time);
        if let Some((then, was)) = self.before.filter(|(then, _)| *then < time) {
            self.rate.update((pressure - was) / (time - then), 0.5 * (time + then));
        }
        self.before = Some((time, pressure));
        self.dent.update(-height, time);
        self.criterion.update((-height).max(0.0) * (-velocity).max(0.0), time);
    }
}

/// Computes the figures of each sensor of a scene.
///
/// # Errors
/// [`OutputError`] if the history cannot be read back.
pub(super) fn figures(scene: &Scene, history: &HistoryFile) -> Result<Vec<SensorFigures>, OutputError> {
    let n = scene.sensor.len();
    if n == 0 {
        return Ok(vec![]);
    }
    let mut all = vec![SensorPeaks::default(); n];
    history.for_each_row(|row: &HistoryRow| {
        let [time, height, velocity] =
            ["time_s", "block_displacement_z_m", "block_velocity_z_m_per_s"].map(|name| row.get(name));
        all.iter_mut().enumerate().for_each(|(i, peaks)| peaks.update(time, row.sensor(i, n), [height, velocity]));
    })?;
    let figures = |(sensor, peaks): (&crate::scene::SensorSpec, SensorPeaks)| SensorFigures {
        position: sensor.position,
        peak_pressure: peaks.pressure.value,
        time_of_peak_pressure: peaks.pressure.time,
        peak_pressure_rate: peaks.rate.value,
        time_of_peak_pressure_rate: peaks.rate.time,
        dent: scene.gel.shape.thickness().filter(|_| sensor.position[2] == 0.0).map(|thickness| DentFigures {
            depth: peaks.dent.value,
            time_of_depth: peaks.dent.time,
            viscous_criterion: peaks.criterion.value / thickness,
            time_of_viscous_criterion: peaks.criterion.time,
        }),
    };
    Ok(scene.sensor.iter().zip(all).map(figures).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn greatest_values_and_rates_are_those_of_the_rows_and_only_what_goes_into_the_block_counts() {
        let mut peaks = SensorPeaks::default();
        for (time, pressure, height, velocity) in
            [(0.0, 0.0, 0.0, 0.0), (1.0, 3.0, -0.1, -2.0), (3.0, 5.0, -0.3, -1.0), (4.0, -9.0, -0.2, 8.0)]
        {
            let columns = [pressure, 0.0, 0.0, height + 0.5, 0.0, 0.0, velocity + 4.0];
            peaks.update(time, &columns, [0.5, 4.0]);
        }
        let found =
            [peaks.pressure, peaks.rate, peaks.dent, peaks.criterion].map(|greatest| (greatest.value, greatest.time));
        assert_eq!(found, [(5.0, 3.0), (3.0, 0.5), (0.3, 3.0), (0.3, 3.0)]);
    }
}
