//! What the sensors of a run have measured, from its history.

use super::files::OutputError;
use super::history::{History, Row};
use crate::scene::Scene;
use serde::Serialize;

/// The figures of a sensor; all are those of the rows of the history, one per communication step.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SensorFigures {
    /// Where its gel is at rest, m.
    pub position: [f64; 3],
    /// Greatest pressure, Pa.
    pub peak_pressure: f64,
    /// When, s.
    pub time_of_peak_pressure: f64,
    /// Greatest rise of pressure from one row to the next, Pa/s.
    pub peak_pressure_rate: f64,
    /// When, in the middle between the two, s.
    pub time_of_peak_pressure_rate: f64,
    /// What has become of the entry surface; of a sensor on it.
    pub dent: Option<Dent>,
}

/// How far a point of the entry surface of a block or a cylinder was driven in.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Dent {
    /// Greatest depth, m.
    pub depth: f64,
    /// When, s.
    pub time_of_depth: f64,
    /// The viscous criterion VC_max = max V(t) C(t), m/s: V the speed of the dent, C its depth as a part of the height of the gel
    /// (Lau & Viano 1986, where C is the deflection as a part of the depth of the chest).
    pub viscous_criterion: f64,
    /// When, s.
    pub time_of_viscous_criterion: f64,
}

/// A greatest value, and when it was.
#[derive(Clone, Copy, Default)]
struct Greatest {
    value: f64,
    time: f64,
}

impl Greatest {
    fn see(&mut self, value: f64, time: f64) {
        if value > self.value {
            *self = Self { value, time };
        }
    }
}

/// Greatest values of a sensor so far.
#[derive(Clone, Default)]
struct Seen {
    /// Time, s, and pressure, Pa, of the row before.
    before: Option<(f64, f64)>,
    pressure: Greatest,
    rate: Greatest,
    dent: Greatest,
    criterion: Greatest,
}

impl Seen {
    fn see(&mut self, time: f64, columns: &[f64]) {
        let &[pressure, _, _, height, _, _, velocity] = columns else { unreachable!("a sensor has seven columns") };
        self.pressure.see(pressure, time);
        if let Some((then, was)) = self.before.filter(|(then, _)| *then < time) {
            self.rate.see((pressure - was) / (time - then), 0.5 * (time + then));
        }
        self.before = Some((time, pressure));
        self.dent.see(-height, time);
        self.criterion.see((-height).max(0.0) * (-velocity).max(0.0), time);
    }
}

/// Those of each sensor of a scene.
///
/// # Errors
/// [`OutputError`] when the history cannot be read back.
pub(super) fn figures(scene: &Scene, history: &History) -> Result<Vec<SensorFigures>, OutputError> {
    let n = scene.sensor.len();
    if n == 0 {
        return Ok(vec![]);
    }
    let mut all = vec![Seen::default(); n];
    history.each(|row: &Row| {
        let time = row.get("time_s");
        all.iter_mut().enumerate().for_each(|(i, seen)| seen.see(time, row.sensor(i, n)));
    })?;
    let figures = |(sensor, seen): (&crate::scene::Sensor, Seen)| SensorFigures {
        position: sensor.position,
        peak_pressure: seen.pressure.value,
        time_of_peak_pressure: seen.pressure.time,
        peak_pressure_rate: seen.rate.value,
        time_of_peak_pressure_rate: seen.rate.time,
        dent: scene.gel.shape.thickness().filter(|_| sensor.position[2] == 0.0).map(|thickness| Dent {
            depth: seen.dent.value,
            time_of_depth: seen.dent.time,
            viscous_criterion: seen.criterion.value / thickness,
            time_of_viscous_criterion: seen.criterion.time,
        }),
    };
    Ok(scene.sensor.iter().zip(all).map(figures).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn greatest_values_and_rates_are_those_of_the_rows_and_only_what_goes_in_counts() {
        let mut seen = Seen::default();
        for (time, pressure, height, velocity) in
            [(0.0, 0.0, 0.0, 0.0), (1.0, 3.0, -0.1, -2.0), (3.0, 5.0, -0.3, -1.0), (4.0, -9.0, -0.2, 8.0)]
        {
            seen.see(time, &[pressure, 0.0, 0.0, height, 0.0, 0.0, velocity]);
        }
        let found =
            [seen.pressure, seen.rate, seen.dent, seen.criterion].map(|greatest| (greatest.value, greatest.time));
        assert_eq!(found, [(5.0, 3.0), (3.0, 0.5), (0.3, 3.0), (0.3, 3.0)]);
    }
}
