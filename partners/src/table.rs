//! What a partner is: a table of real variables, and how they start and step.

/// The role of a variable, as FMI names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// Set before the first step.
    Parameter,
    /// Set before each step; the start value holds until then.
    Input,
    /// Read after each step.
    Output,
    /// State that a user may look at.
    Local,
}

/// One real variable; more than one component makes it an array.
#[derive(Debug, Clone, Copy)]
pub struct Variable {
    /// Name without index.
    pub name: &'static str,
    /// Its role.
    pub causality: Causality,
    /// Unit, as FMI writes it.
    pub unit: &'static str,
    /// Start values, one for each component; of outputs and locals they are computed, and this is only their number.
    pub start: &'static [f64],
    /// What it means.
    #[allow(dead_code, reason = "only what packs the partners writes it")]
    pub description: &'static str,
}

impl Variable {
    /// A parameter.
    pub const fn parameter(
        name: &'static str,
        unit: &'static str,
        start: &'static [f64],
        description: &'static str,
    ) -> Self {
        Self { name, causality: Causality::Parameter, unit, start, description }
    }

    /// An input; nothing acts as long as it is not set.
    pub const fn input(name: &'static str, unit: &'static str, size: usize, description: &'static str) -> Self {
        Self { name, causality: Causality::Input, unit, start: zeros(size), description }
    }

    /// An output.
    pub const fn output(name: &'static str, unit: &'static str, size: usize, description: &'static str) -> Self {
        Self { name, causality: Causality::Output, unit, start: zeros(size), description }
    }

    /// A state to look at.
    pub const fn local(name: &'static str, unit: &'static str, size: usize, description: &'static str) -> Self {
        Self { name, causality: Causality::Local, unit, start: zeros(size), description }
    }
}

/// So many zeros.
const fn zeros(size: usize) -> &'static [f64] {
    const MANY: [f64; 4] = [0.0; 4];
    MANY.split_at(size).0
}

/// A partner: its table and its two functions. Both work on the values of all variables, in the order of the table.
#[derive(Debug, Clone, Copy)]
pub struct Model {
    /// Name of the model and of its library.
    pub name: &'static str,
    /// What it is.
    pub description: &'static str,
    /// Its variables.
    pub variables: &'static [Variable],
    /// Outputs and locals from the parameters, or what is wrong with these.
    pub start: fn(&mut [f64]) -> Result<(), String>,
    /// One communication step of this length, s.
    #[allow(dead_code, reason = "what packs the partners does not step them")]
    pub step: fn(&mut [f64], f64) -> Result<(), String>,
}

impl Model {
    /// Start values of all components, as the table has them.
    pub fn values(&self) -> Vec<f64> {
        self.variables.iter().flat_map(|variable| variable.start).copied().collect()
    }

    /// Variable and component of each value.
    pub fn scalars(&self) -> impl Iterator<Item = (&'static Variable, usize)> {
        self.variables.iter().flat_map(|variable| (0..variable.start.len()).map(move |component| (variable, component)))
    }

    /// Identity of the interface: changes whenever the table does.
    #[allow(dead_code, reason = "what packs the partners keeps no states")]
    pub fn interface(&self) -> String {
        self.identity("")
    }

    /// GUID of an FMU that is packed with these start values: importers keep unpacked FMUs by it.
    pub fn guid(&self, starts: &[f64]) -> String {
        self.identity(&format!("{} {starts:?}", env!("CARGO_PKG_VERSION")))
    }

    /// The table and a text, hashed (FNV-1a, 64 bits, twice).
    fn identity(&self, more: &str) -> String {
        let hash = |seed: u64| {
            let facts = self.variables.iter().map(|variable| format!("{variable:?}"));
            let text = facts.fold(format!("{}{}{more}", self.name, self.description), |text, fact| text + &fact);
            text.bytes().fold(seed, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
        };
        format!("{{{:016x}{:016x}}}", hash(0xcbf2_9ce4_8422_2325), hash(0x8422_2325_cbf2_9ce4))
    }
}

/// Place of the first component of a variable among the values; a wrong name does not compile.
pub const fn place(variables: &[Variable], name: &str) -> usize {
    let (mut at, mut i) = (0, 0);
    while i < variables.len() {
        if equal(variables[i].name.as_bytes(), name.as_bytes()) {
            return at;
        }
        at += variables[i].start.len();
        i += 1;
    }
    panic!("no variable of this name")
}

const fn equal(a: &[u8], b: &[u8]) -> bool {
    let mut i = 0;
    while i < a.len() && i < b.len() && a[i] == b[i] {
        i += 1;
    }
    i == a.len() && i == b.len()
}
