//! Strong scaling on paper: how evenly the work divides into contiguous parts, and what they share.
//!
//! The work of a run of elements is its updates per second at the steps it has in contact. A part is as many runs in a row as
//! come nearest to an even share, as the engine divides them among its threads. The greatest part over the mean bounds the
//! speed that so many threads can have.

use super::Measurement;
use super::scenes::{advance, awake, scene, simulation, size};
use super::settings::Settings;
use super::table::Row;
use crate::failure::Failure;
use crate::options::SectionName;
use ballistic_gel::integrator::Run;

/// Numbers of parts.
const PARTS: [usize; 6] = [2, 4, 8, 16, 32, 64];
/// When to look, s: the ball is in contact and its neighbours have the steps it leaves them.
const AT: f64 = 0.2e-3;
const GRADED: [&str; 3] = ["sphere-graded-4", "sphere-graded-8", "sphere-graded-16"];

/// Work divided among parts.
#[derive(Debug, PartialEq)]
struct Division {
    /// Work of the greatest part over the mean.
    imbalance: f64,
    /// Nodes that more than one part gives something to.
    shared: usize,
}

pub fn plan(settings: &Settings) -> Vec<Measurement> {
    let uniform = settings.elements.iter().map(|n| ("sphere-block", Some(*n)));
    let graded = GRADED.iter().map(|name| (*name, None)).take(if settings.quick { 1 } else { GRADED.len() });
    let of = |(name, n): (&'static str, Option<usize>)| Measurement {
        section: SectionName::Partitions,
        what: name.to_owned(),
        cost: n.map_or(1.0, |n| n as f64 * 1e-5),
        go: Box::new(move || rows(name, n)),
    };
    uniform.chain(graded).map(of).collect()
}

fn rows(name: &'static str, n_elements: Option<usize>) -> Result<Vec<Row>, Failure> {
    let keys: Vec<_> = n_elements.map(size).into_iter().chain([awake()]).collect();
    let mut simulation = simulation(&scene(name, &keys)?, 1)?;
    advance(&mut simulation, AT)?;
    let (runs, cost) = (simulation.runs(), simulation.observe().cost);
    let row = |parts: usize| {
        let Division { imbalance, shared } = divide(&runs, parts, cost.nodes);
        Row::default()
            .with("mesh", name)
            .with("elements", cost.elements)
            .with("runs", runs.len())
            .with("parts", parts)
            .with("greatest_over_mean", imbalance)
            .with("times_as_fast_at_most", parts as f64 / imbalance)
            .with("shared_nodes_percent", 100.0 * shared as f64 / cost.nodes as f64)
            .and("shared_nodes", shared)
            .and("million_updates_per_simulated_s", runs.iter().map(|run| run.rate).sum::<f64>() / 1e6)
    };
    Ok(PARTS.map(row).into())
}

fn divide(runs: &[Run<'_>], parts: usize, n_nodes: usize) -> Division {
    let whole: f64 = runs.iter().map(|run| run.rate).sum();
    let (mut work, mut owner) = (vec![0.0; parts], vec![None; n_nodes]);
    let (mut shared, mut before) = (vec![false; n_nodes], 0.0);
    for run in runs {
        // A run belongs where its middle is.
        let part = (((before + 0.5 * run.rate) / whole * parts as f64) as usize).min(parts - 1);
        work[part] += run.rate;
        before += run.rate;
        for node in run.nodes {
            shared[node.index()] |= *owner[node.index()].get_or_insert(part) != part;
        }
    }
    let greatest = work.iter().copied().fold(0.0, f64::max);
    Division { imbalance: greatest * parts as f64 / whole, shared: shared.iter().filter(|shared| **shared).count() }
}

#[cfg(test)]
mod tests {
    use super::{Division, Run, divide};
    use ballistic_gel::mesh::NodeId;

    #[test]
    fn parts_are_even_where_runs_are_and_share_the_nodes_between_them() {
        let nodes: Vec<NodeId> = (0..9).map(NodeId).collect();
        // Four runs along a line, each with three nodes, the last of which is the first of the next.
        let run = |i: usize, rate| Run {
            nodes: &nodes[2 * i..2 * i + 3],
            groups: i..i + 1,
            n_elements: 2,
            rate,
            was_swept: true,
        };
        let even: Vec<Run<'_>> = (0..4).map(|i| run(i, 5.0)).collect();
        assert_eq!(divide(&even, 2, 9), Division { imbalance: 1.0, shared: 1 });
        assert_eq!(divide(&even, 4, 9), Division { imbalance: 1.0, shared: 3 });
        let uneven: Vec<Run<'_>> = [6.0, 1.0, 1.0, 2.0].into_iter().enumerate().map(|(i, rate)| run(i, rate)).collect();
        assert_eq!(divide(&uneven, 2, 9), Division { imbalance: 1.2, shared: 1 });
    }
}
