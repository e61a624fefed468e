//! The element phase: a pure map from positions to forces, so that threads cannot change a bit.

use super::Pool;
use crate::algebra::Vector;
use crate::element::{Evaluation, Potential};
use crate::mesh::ElementId;
use rayon::prelude::*;

/// Patches per task: about 50 µs of work, above what a fork and join costs.
const CHUNK: usize = 512;

/// Forces (`stride` per patch) and answers of the patches in `due`.
pub(super) fn evaluate<const D: usize, P: Potential<D>>(
    potential: &P,
    (x, due): (&[Vector<D>], &[ElementId]),
    (forces, answers): (&mut Vec<Vector<D>>, &mut Vec<Evaluation>),
    pool: Option<&Pool>,
) {
    let stride = potential.stride();
    forces.resize(due.len() * stride, Vector::zeros());
    answers.resize(due.len(), Evaluation::default());
    let chunk = |due: &[ElementId], forces: &mut [Vector<D>], answers: &mut [Evaluation]| {
        for ((patch, forces), answer) in due.iter().zip(forces.chunks_mut(stride)).zip(answers) {
            *answer = potential.evaluate(*patch, x, forces);
        }
    };
    match pool {
        Some(pool) if due.len() > 2 * CHUNK => pool.run(|| {
            let forces = forces.par_chunks_mut(CHUNK * stride);
            let tasks = due.par_chunks(CHUNK).zip(forces).zip(answers.par_chunks_mut(CHUNK));
            tasks.for_each(|((due, forces), answers)| chunk(due, forces, answers));
        }),
        _ => chunk(due, forces, answers),
    }
}
