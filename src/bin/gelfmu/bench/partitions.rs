//! Load balance of contiguous partitions: a bound on strong scaling.
//!
//! The work of a run of elements is its updates per second at its steps in contact. A partition takes the consecutive
//! runs nearest to an even share, like the division among the engine's threads. The ratio of the mean to the greatest
//! work bounds the parallel efficiency.

use super::Measurement;
use super::scenes::{cell_size, drifting_gel, load_scene, new_simulation, step_to};
use super::settings::BenchSettings;
use super::table::BenchRow;
use crate::failure::CommandError;
use crate::options::SectionName;
use ballistic_gel::integrator::BlockLayout;

/// Numbers of partitions.
const PART_COUNTS: [usize; 6] = [2, 4, 8, 16, 32, 64];
/// Time of the measurement, s: the ball is in contact and has shortened the steps around it.
const MEASURED_TIME: f64 = 0.2e-3;
const GRADED_SCENES: [&str; 3] = ["sphere-graded-4", "sphere-graded-8", "sphere-graded-16"];

/// Division of the work into partitions.
#[derive(Debug, PartialEq)]
struct WorkDivision {
    /// Greatest work of a partition over the mean.
    imbalance: f64,
    /// Number of nodes in more than one partition.
    shared: usize,
}

/// Plans one measurement for each mesh.
pub fn plan(settings: &BenchSettings) -> Vec<Measurement> {
    let uniform = settings.elements.iter().map(|n| ("sphere-block", Some(*n)));
    let graded =
        GRADED_SCENES.iter().map(|name| (*name, None)).take(if settings.quick { 1 } else { GRADED_SCENES.len() });
    let measurement = |(name, n): (&'static str, Option<usize>)| Measurement {
        section: SectionName::Partitions,
        what: name.to_owned(),
        cost: n.map_or(1.0, |n| n as f64 * 1e-5),
        go: Box::new(move || measure(name, n)),
    };
    uniform.chain(graded).map(measurement).collect()
}

fn measure(name: &'static str, n_elements: Option<usize>) -> Result<Vec<BenchRow>, CommandError> {
    let overrides: Vec<_> = n_elements.map(cell_size).into_iter().chain([drifting_gel()]).collect();
    let mut simulation = new_simulation(&load_scene(name, &overrides)?, 1)?;
    step_to(&mut simulation, MEASURED_TIME)?;
    let (runs, cost) = (simulation.runs(), simulation.observe().cost);
    let row = |parts: usize| {
        let WorkDivision { imbalance, shared } = divide_work(&runs, parts, cost.nodes);
        BenchRow::default()
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
    Ok(PART_COUNTS.map(row).into())
}

/// Divides runs among partitions in proportion to their work.
fn divide_work(runs: &[BlockLayout<'_>], parts: usize, n_nodes: usize) -> WorkDivision {
    let whole: f64 = runs.iter().map(|run| run.rate).sum();
    let (mut work, mut owner) = (vec![0.0; parts], vec![None; n_nodes]);
    let (mut shared, mut before) = (vec![false; n_nodes], 0.0);
    for run in runs {
        // The middle of a run decides its partition.
        let part = (((before + 0.5 * run.rate) / whole * parts as f64) as usize).min(parts - 1);
        work[part] += run.rate;
        before += run.rate;
        for node in run.nodes {
            shared[node.index()] |= *owner[node.index()].get_or_insert(part) != part;
        }
    }
    let greatest = work.iter().copied().fold(0.0, f64::max);
    WorkDivision { imbalance: greatest * parts as f64 / whole, shared: shared.iter().filter(|shared| **shared).count() }
}

#[cfg(test)]
mod tests {
    use super::{BlockLayout, WorkDivision, divide_work};
    use ballistic_gel::mesh::NodeId;

    #[test]
    fn even_runs_make_even_parts_that_share_their_interface_nodes() {
        let nodes: Vec<NodeId> = (0..9).map(NodeId).collect();
        // Four runs along a line with three nodes each; neighbours share an end node.
        let run = |i: usize, rate| BlockLayout {
            nodes: &nodes[2 * i..2 * i + 3],
            groups: i..i + 1,
            n_elements: 2,
            rate,
            was_swept: true,
        };
        let even: Vec<BlockLayout<'_>> = (0..4).map(|i| run(i, 5.0)).collect();
        assert_eq!(divide_work(&even, 2, 9), WorkDivision { imbalance: 1.0, shared: 1 });
        assert_eq!(divide_work(&even, 4, 9), WorkDivision { imbalance: 1.0, shared: 3 });
        let uneven: Vec<BlockLayout<'_>> =
            [6.0, 1.0, 1.0, 2.0].into_iter().enumerate().map(|(i, rate)| run(i, rate)).collect();
        assert_eq!(divide_work(&uneven, 2, 9), WorkDivision { imbalance: 1.2, shared: 1 });
    }
}
