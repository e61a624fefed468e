//! The component far from the ordinary: each case gives what is known beforehand, or stops with a reason.

mod gel;
mod impact;
mod matter;
mod row;
mod time;

use row::Row;
use std::io::Write as _;

/// Cases that take seconds: every change runs them.
pub const QUICK: [fn() -> Vec<Row>; 17] = [
    time::cfl,
    time::communication,
    time::many_steps,
    time::long_run,
    time::threads,
    time::gravity,
    time::pressed,
    matter::poisson,
    matter::stiffness,
    matter::slivers,
    matter::resonance,
    matter::one_cell,
    impact::masses,
    impact::slow,
    impact::fast,
    impact::sizes,
    impact::free_flight,
];

/// Cases that take minutes.
pub const LONG: [fn() -> Vec<Row>; 7] = [
    impact::too_much,
    matter::worst_slivers,
    matter::worst_resonance,
    impact::supersonic,
    impact::two_million,
    time::longest_run,
    time::most_steps,
];

/// Runs the cases, prints their table as it grows, and gives the rows that missed.
pub fn table(cases: &[fn() -> Vec<Row>]) -> Vec<String> {
    println!("| case | expected | got | verdict |\n|---|---|---|---|");
    let mut missed = vec![];
    for row in cases.iter().flat_map(|case| case()) {
        println!("{}", row.line());
        std::io::stdout().flush().expect("standard output");
        if !row.is_met() {
            missed.push(row.line());
        }
    }
    missed
}
