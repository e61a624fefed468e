//! Measured curves over the computed ones: residuals, and their section of the page.

use super::MEASURED_PLACE;
use super::format::{bullet_list, escape, percent, quantity};
use super::plot::{CurvePlot, HorizontalAxis, PlotCurve, VerticalScale};
use super::tables::{row, table};
use serde::Serialize;

/// Point of a curve: abscissa (time, s, or depth, m) and value, SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// Time, s, or depth, m.
    pub at: f64,
    /// Value.
    pub value: f64,
}

/// Abscissa of compared curves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum CurveAbscissa {
    /// Time since the start of the run, s.
    Time,
    /// Depth below the entry surface, m.
    Depth,
}

impl CurveAbscissa {
    /// Returns the name in the report.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Depth => "depth",
        }
    }

    /// Returns the SI unit.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Time => "s",
            Self::Depth => "m",
        }
    }
}

/// Residual of a measured curve: computed minus measured, SI units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CurveResidual {
    /// Number of measured points within the computed curve.
    pub points: usize,
    /// Number of measured points beyond the computed curve, which are not compared.
    pub outside: usize,
    /// Root of the mean square.
    pub rms: f64,
    /// Greatest residual by magnitude, with its sign.
    pub greatest: f64,
    /// Abscissa of the greatest residual.
    pub greatest_at: f64,
    /// `rms` in percent of the greatest measured magnitude.
    pub rms_percent: Option<f64>,
    /// `greatest` in percent of the greatest measured magnitude.
    pub greatest_percent: Option<f64>,
}

/// Measured curve with the computed curve of the same quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparedCurve {
    /// Title, such as "Velocity by depth".
    pub title: &'static str,
    /// Name of the column of the measured values.
    pub column: String,
    /// Abscissa of both curves.
    pub abscissa: CurveAbscissa,
    /// SI unit of the values.
    pub unit: &'static str,
    /// Computed curve, ascending.
    pub computed: Vec<CurvePoint>,
    /// Measured points.
    pub measured: Vec<CurvePoint>,
}

impl ComparedCurve {
    /// Returns the residual; `None` if no measured point lies within the computed curve.
    #[must_use]
    pub fn residual(&self) -> Option<CurveResidual> {
        let difference = |point: &CurvePoint| {
            Some(CurvePoint { at: point.at, value: interpolate(&self.computed, point.at)? - point.value })
        };
        let residuals: Vec<CurvePoint> = self.measured.iter().filter_map(difference).collect();
        let greatest = residuals.iter().copied().reduce(|a, b| if b.value.abs() > a.value.abs() { b } else { a })?;
        // Squares of a fraction of the greatest do not overflow.
        let size = greatest.value.abs().max(f64::MIN_POSITIVE);
        let square_sum: f64 = residuals.iter().map(|point| (point.value / size).powi(2)).sum();
        let rms = size * (square_sum / residuals.len() as f64).sqrt();
        let scale = self.measured.iter().map(|point| point.value.abs()).fold(0.0, f64::max);
        let in_percent = |value: f64| (scale > 0.0).then(|| 100.0 * (value / scale));
        Some(CurveResidual {
            points: residuals.len(),
            outside: self.measured.len() - residuals.len(),
            rms,
            greatest: greatest.value,
            greatest_at: greatest.at,
            rms_percent: in_percent(rms),
            greatest_percent: in_percent(greatest.value),
        })
    }

    fn plot(&self) -> CurvePlot {
        let points = |points: &[CurvePoint]| points.iter().map(|point| (point.at, point.value)).collect::<Vec<_>>();
        let all = self.computed.iter().chain(&self.measured).map(|point| point.at);
        let end = all.fold(0.0, f64::max);
        CurvePlot {
            title: self.title,
            unit: self.unit,
            vertical: VerticalScale::FromZero,
            horizontal: HorizontalAxis { name: self.abscissa.name(), unit: self.abscissa.unit(), range: 0.0..end },
            curves: vec![
                PlotCurve::line("computed", points(&self.computed)),
                PlotCurve::dots("measured", points(&self.measured)),
            ],
        }
    }

    /// Appends the row of the residual to a table.
    fn add_row(&self, rows: &mut String) {
        let name = format!("{} ({})", self.title, self.column);
        let none = || "–".to_owned();
        let Some(residual) = self.residual() else {
            let points = format!("none of {} within the computed curve", self.measured.len());
            row(rows, &name, &[&points, &none(), &none(), &none()]);
            return;
        };
        let told = |value: f64, share: Option<f64>| {
            let share = share.map_or(String::new(), |share| format!(" ({})", percent(0.01 * share)));
            quantity(value, self.unit) + &share
        };
        let points = match residual.outside {
            0 => residual.points.to_string(),
            outside => format!("{}, {outside} more beyond the computed curve", residual.points),
        };
        row(
            rows,
            &name,
            &[
                &points,
                &told(residual.rms, residual.rms_percent),
                &told(residual.greatest, residual.greatest_percent),
                &quantity(residual.greatest_at, self.abscissa.unit()),
            ],
        );
    }
}

/// Returns the value of an ascending curve by linear interpolation; `None` beyond its ends.
fn interpolate(curve: &[CurvePoint], at: f64) -> Option<f64> {
    let next = curve.partition_point(|point| point.at < at);
    let b = curve.get(next)?;
    if b.at == at {
        return Some(b.value);
    }
    let a = curve.get(next.checked_sub(1)?)?;
    Some(a.value + (b.value - a.value) * (at - a.at) / (b.at - a.at))
}

/// Returns a report with the section of the measured curves; `notes` say which columns of the file were used.
#[must_use]
pub fn insert_comparison(page: &str, file: &str, curves: &[ComparedCurve], notes: &[String]) -> String {
    let mut rows = String::new();
    for curve in curves {
        curve.add_row(&mut rows);
    }
    let heads = ["quantity (column)", "points", "rms residual", "greatest residual", "found at"];
    let table = if rows.is_empty() { rows } else { table("Residuals: computed minus measured", &heads, &rows) };
    let figures: String = curves.iter().map(|curve| curve.plot().figure()).collect();
    let section = format!(
        "<section><h2>Compared with the laboratory</h2>\n<p>Measured curves of <code>{}</code>. Percentages are of the \
         greatest measured value.</p>\n{table}<div class=\"plots\">{figures}</div>{}</section>\n",
        escape(file),
        bullet_list(notes)
    );
    page.replacen(MEASURED_PLACE, &section, 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(points: &[[f64; 2]]) -> Vec<CurvePoint> {
        points.iter().map(|[at, value]| CurvePoint { at: *at, value: *value }).collect()
    }

    fn compared(measured: &[[f64; 2]]) -> ComparedCurve {
        ComparedCurve {
            title: "Velocity by depth",
            column: "v <m/s>".to_owned(),
            abscissa: CurveAbscissa::Depth,
            unit: "m/s",
            computed: curve(&[[0.0, 100.0], [0.1, 0.0]]),
            measured: curve(measured),
        }
    }

    #[test]
    fn residuals_are_those_of_the_interpolated_curve() {
        let residual = compared(&[[0.0, 103.0], [0.05, 46.0], [0.2, 1.0]]).residual().unwrap();
        assert_eq!((residual.points, residual.outside), (2, 1));
        assert!((residual.rms - 12.5f64.sqrt()).abs() < 1e-12 && (residual.greatest - 4.0).abs() < 1e-12);
        assert!(residual.greatest_at == 0.05 && (residual.greatest_percent.unwrap() - 400.0 / 103.0).abs() < 1e-12);
        assert_eq!(compared(&[[0.2, 1.0]]).residual(), None);
        let huge = compared(&[[0.0, 1e305], [0.05, -1e305]]).residual().unwrap();
        assert_eq!((huge.rms, huge.rms_percent), (1e305, Some(100.0)), "squares would overflow");
    }

    #[test]
    fn the_section_takes_its_place_and_escapes_the_text_of_the_user() {
        let page = format!("<main>{MEASURED_PLACE}</main>");
        let page = insert_comparison(&page, "lab & co.csv", &[compared(&[[0.05, 46.0]])], &["a < b".to_owned()]);
        assert!(page.contains("lab &amp; co.csv") && page.contains("v &lt;m/s&gt;") && page.contains("a &lt; b"));
        assert!(page.contains("4.00 m/s (8.70 %)") && !page.contains(MEASURED_PLACE.trim()));
    }
}
