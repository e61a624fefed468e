//! A row of the table of extremes.

/// What was tried, what was known before, what came out, and whether that is it.
#[derive(Debug, Clone)]
pub struct Row {
    case: String,
    expected: String,
    got: String,
    met: bool,
}

impl Row {
    /// A row whose verdict is given.
    pub fn new(case: impl Into<String>, expected: impl Into<String>, got: impl Into<String>, met: bool) -> Self {
        Self { case: case.into(), expected: expected.into(), got: got.into(), met }
    }

    /// Values that should all be `expected` within `tolerance`, a difference.
    pub fn near(case: impl Into<String>, expected: f64, tolerance: f64, got: &[f64]) -> Self {
        let met = got.iter().all(|got| (got - expected).abs() <= tolerance);
        Self::new(case, format!("{expected:.4} ± {tolerance}"), listed(got, 4), met)
    }

    /// Texts of which each should contain `part`.
    pub fn said(case: impl Into<String>, part: &str, got: &str) -> Self {
        Self::new(case, format!("refused: … {part} …"), shortened(got), got.contains(part))
    }

    /// What the table shows, and whether it is as expected.
    pub fn line(&self) -> String {
        let verdict = if self.met { "met" } else { "**missed**" };
        format!("| {} | {} | {} | {verdict} |", self.case, self.expected, self.got)
    }

    /// Whether it is as expected.
    pub fn is_met(&self) -> bool {
        self.met
    }
}

/// Numbers with so many decimals.
pub fn listed(numbers: &[f64], decimals: usize) -> String {
    let shown: Vec<String> = numbers.iter().map(|number| format!("{number:.decimals$}")).collect();
    shown.join(" / ")
}

/// The beginning of a long text.
pub fn shortened(text: &str) -> String {
    const MOST: usize = 110;
    let line = text.replace('\n', " ");
    if line.chars().count() <= MOST { line } else { line.chars().take(MOST).chain(['…']).collect() }
}
