//! One line of the verification table.

/// How a result stands to its target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The target is met.
    Met,
    /// The target is out of the method's reach; the value stands where it was first measured.
    Frozen,
    /// Neither.
    Missed,
}

/// What was asked, what came out.
#[derive(Debug, Clone)]
pub struct Row {
    /// Which part of the suite.
    pub id: &'static str,
    /// What is asked.
    pub what: String,
    /// Closed form or target.
    pub expected: String,
    /// What came out.
    pub obtained: String,
    /// Order of convergence, or nothing.
    pub order: String,
    /// How it stands.
    pub verdict: Verdict,
}

impl Row {
    /// A row whose target is met or not.
    pub fn new((id, what): (&'static str, &str), expected: &str, obtained: String, met: bool) -> Self {
        let verdict = if met { Verdict::Met } else { Verdict::Missed };
        Self { id, what: what.into(), expected: expected.into(), obtained, order: String::new(), verdict }
    }

    /// With an order of convergence.
    pub fn with_order(mut self, order: f64) -> Self {
        self.order = format!("{order:.2}");
        self
    }

    /// A row that holds a value to what was first measured: the target itself is out of reach.
    pub fn frozen(mut self) -> Self {
        if self.verdict == Verdict::Met {
            self.verdict = Verdict::Frozen;
        }
        self
    }

    /// Fails the test that asks, with the whole row, if the target is missed.
    #[track_caller]
    pub fn check(rows: &[Self]) {
        for row in rows {
            assert!(
                row.verdict != Verdict::Missed,
                "{} {}: expected {}, obtained {}",
                row.id,
                row.what,
                row.expected,
                row.obtained
            );
        }
    }
}

/// The power of ten that a round-off figure stays below: "< 1e-14" does not change with the last bit.
pub fn below(value: f64) -> String {
    if value == 0.0 { "0".into() } else { format!("< 1e{:.0}", value.abs().log10().floor() + 1.0) }
}

/// Slope of the logarithms between the first and the last of (h, error).
pub fn order(points: &[(f64, f64)]) -> f64 {
    let (first, last) = (points[0], points[points.len() - 1]);
    (first.1 / last.1).abs().ln() / (first.0 / last.0).ln()
}

/// Values with one format, joined by slashes.
pub fn series(values: impl IntoIterator<Item = f64>, digits: u8) -> String {
    let scale = 10_f64.powf(f64::from(digits));
    // Adding zero turns −0 into 0.
    let rounded = values.into_iter().map(|v| (v * scale).round() / scale + 0.0);
    let texts: Vec<String> = rounded.map(|v| format!("{v:.0$}", usize::from(digits))).collect();
    texts.join(" / ")
}
