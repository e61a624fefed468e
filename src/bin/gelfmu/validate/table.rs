//! Table of a validation: as CSV, as Markdown and for the terminal.

use super::case::{cases_of, counted_level};
use super::measured::{MeasuredFigure, ValidationShot};
use super::queue::FinishedCase;
use super::row::CaseRow;
use std::fmt::Write;

/// Deviation from the measured range up to which a shot agrees.
pub const BAND: f64 = 0.20;

/// Shot with the rows of its cases.
pub struct ShotResult {
    /// Measured shot.
    pub measured: ValidationShot,
    /// Rows in the order of the cases.
    pub rows: Vec<CaseRow>,
    /// Reasons of the cases without a row.
    pub failures: Vec<String>,
}

/// Groups finished cases by their shots.
pub fn by_shot(finished: &[FinishedCase], shots: &[ValidationShot]) -> Vec<ShotResult> {
    let of_shot = |measured: &ValidationShot| {
        let (mut rows, mut failures) = (vec![], vec![]);
        for case in cases_of(measured) {
            match finished.iter().find(|other| other.case == case).map(|other| &other.row) {
                Some(Ok(row)) => rows.push(row.clone()),
                Some(Err(why)) => failures.push(format!("{}: {why}", case.label())),
                None => (),
            }
        }
        ShotResult { measured: measured.clone(), rows, failures }
    };
    shots.iter().map(of_shot).collect()
}

impl ShotResult {
    /// Row at the level that counts.
    pub fn counted(&self) -> Option<&CaseRow> {
        self.rows.iter().find(|row| row.level == counted_level(&self.measured))
    }

    /// Computed values of the rows at `draft`, m.
    pub fn scatter(&self) -> Vec<f64> {
        let draft = self.rows.iter().filter(|row| row.level == "draft");
        draft.filter_map(|row| row.value(self.measured.measure)).collect()
    }

    /// Computed value of the row that counts, m.
    pub fn value(&self) -> Option<f64> {
        self.counted()?.value(self.measured.measure)
    }

    /// Returns true if the computed value is in the band around the measured range; a run that did not get there does
    /// not agree. `None` without the run that counts.
    pub fn agrees(&self) -> Option<bool> {
        self.counted()?;
        Some(self.value().is_some_and(|value| (self.measured.ratio(value) - 1.0).abs() <= BAND))
    }
}

/// Judged shots that agree, and those whose run counts.
pub struct AgreementCount {
    /// Number of shots that agree.
    pub agreeing: usize,
    /// Number of shots that were run.
    pub judged: usize,
}

/// Counts the shots of grade B that the gel is not fitted to.
pub fn count_agreement(results: &[ShotResult]) -> AgreementCount {
    let counted = results.iter().filter(|result| result.measured.is_judged());
    let judged: Vec<bool> = counted.filter_map(ShotResult::agrees).collect();
    AgreementCount { agreeing: judged.iter().filter(|agrees| **agrees).count(), judged: judged.len() }
}

/// All rows as CSV.
pub fn to_csv(results: &[ShotResult]) -> String {
    let mut writer = csv::Writer::from_writer(vec![]);
    for row in results.iter().flat_map(|result| &result.rows) {
        writer.serialize(row).expect("a vector grows");
    }
    String::from_utf8(writer.into_inner().expect("a vector grows")).expect("numbers and names are text")
}

/// Table as Markdown.
pub fn to_markdown(results: &[ShotResult]) -> String {
    let mut text = String::from(
        "| shot | figure | measured, mm | grade | level | computed, mm | to the measured | scatter at `draft`, mm \
         | cavity, mm | energy, J/cm | wall s |\n|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for result in results {
        let ShotResult { measured, .. } = result;
        let figure = match measured.measure {
            MeasuredFigure::Depth => "depth",
            MeasuredFigure::Neck => "neck",
        };
        let counted = result.counted();
        let ratio = result.value().map(|value| format!("{:+.0} %", 100.0 * (measured.ratio(value) - 1.0)));
        let scatter = result.scatter();
        let range = scatter.iter().copied().reduce(f64::min).zip(scatter.iter().copied().reduce(f64::max));
        writeln!(
            text,
            "| {} | {figure} | {} | {:?}{} | {} | {} | {} | {} | {} | {} | {} |",
            measured.name,
            span(measured.low, measured.high),
            measured.grade,
            if measured.fitted { ", fitted" } else { "" },
            counted_level(measured),
            computed(result),
            ratio.unwrap_or_default(),
            range.map(|(low, high)| span(low, high)).unwrap_or_default(),
            counted.and_then(|row| row.cavity_m).map(millimetres).unwrap_or_default(),
            counted.and_then(|row| row.energy_per_cm_j).map(|energy| format!("{energy:.0}")).unwrap_or_default(),
            counted.map(|row| format!("{:.0}", row.seconds)).unwrap_or_default(),
        )
        .expect("a string grows");
    }
    text
}

fn computed(result: &ShotResult) -> String {
    match (result.counted(), result.value()) {
        (None, _) => String::new(),
        (Some(row), Some(value)) if row.perforated && result.measured.measure == MeasuredFigure::Depth => {
            format!("through {} at {:.0} m/s", millimetres(value), row.last_speed_m_per_s)
        }
        (Some(row), None) if !row.completed => "stopped early".to_owned(),
        (Some(_), None) => "not reached".to_owned(),
        (Some(_), Some(value)) => millimetres(value),
    }
}

fn millimetres(length: f64) -> String {
    format!("{:.0}", 1e3 * length)
}

fn span(low: f64, high: f64) -> String {
    if low == high { millimetres(low) } else { format!("{}–{}", millimetres(low), millimetres(high)) }
}
