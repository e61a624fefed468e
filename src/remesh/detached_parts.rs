//! Detached parts of a body after erosion.

use crate::mesh::ElementId;

/// Adds to the eroded elements the parts that they detach. Of the remainder of each body the heaviest part stays, and
/// so does every part above `most` of the total mass, as a body of its own. Nothing is eroded if nothing would remain,
/// or if the eroded elements alone exceed `most` of the mass. `across` holds the face neighbours of each element,
/// `mass` the masses, kg.
///
/// Parts that touch only in a node or an edge are separate.
#[must_use]
pub fn with_detached_parts(across: &[[Option<ElementId>; 4]], mass: &[f64], gone: &[bool], most: f64) -> Vec<bool> {
    let light = most * mass.iter().sum::<f64>();
    let lost: f64 = mass.iter().zip(gone).filter(|(_, gone)| **gone).map(|(mass, _)| mass).sum();
    let bodies = parts(across, &vec![false; gone.len()]);
    let left = parts(across, gone);
    let weights = weights(&left, mass);
    if weights.is_empty() || lost > light {
        return vec![false; gone.len()];
    }
    let heaviest = heaviest(&bodies, &left, &weights);
    let stays = |part: usize| heaviest[part] || weights[part] > light;
    left.iter().map(|part| part.is_none_or(|part| !stays(part))).collect()
}

/// Part of each remaining element; parts are numbered by their first elements.
fn parts(across: &[[Option<ElementId>; 4]], gone: &[bool]) -> Vec<Option<usize>> {
    let (mut part, mut n) = (vec![None; gone.len()], 0);
    for start in 0..gone.len() {
        if gone[start] || part[start].is_some() {
            continue;
        }
        let mut waiting = vec![start];
        part[start] = Some(n);
        while let Some(e) = waiting.pop() {
            for other in across[e].iter().flatten().map(|other| other.index()) {
                if !gone[other] && part[other].is_none() {
                    part[other] = Some(n);
                    waiting.push(other);
                }
            }
        }
        n += 1;
    }
    part
}

/// Mass of each part, kg.
fn weights(part: &[Option<usize>], mass: &[f64]) -> Vec<f64> {
    let mut weights = vec![0.0; part.iter().flatten().max().map_or(0, |last| last + 1)];
    part.iter().zip(mass).filter_map(|(part, mass)| Some(((*part)?, mass))).for_each(|(part, m)| weights[part] += m);
    weights
}

/// Marks the heaviest remaining part of each body.
fn heaviest(bodies: &[Option<usize>], left: &[Option<usize>], weights: &[f64]) -> Vec<bool> {
    let mut of_body: Vec<Option<usize>> = vec![None; bodies.len()];
    for (body, part) in bodies.iter().zip(left).filter_map(|(body, part)| Some(((*body)?, (*part)?))) {
        if of_body[body].is_none_or(|best| weights[part] > weights[best]) {
            of_body[body] = Some(part);
        }
    }
    let mut is_heaviest = vec![false; weights.len()];
    of_body.iter().flatten().for_each(|part| is_heaviest[*part] = true);
    is_heaviest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of elements: neighbours are those before and after within a row.
    fn rows(lengths: &[usize]) -> Vec<[Option<ElementId>; 4]> {
        let mut across = vec![];
        for length in lengths {
            let first = across.len();
            let id = |k: usize| Some(ElementId(k as u32));
            across.extend((first..first + length).map(|e| {
                [id(e.wrapping_sub(1)).filter(|_| e > first), id(e + 1).filter(|_| e + 1 < first + length), None, None]
            }));
        }
        across
    }

    fn gone(lengths: &[usize], which: &[usize], most: f64) -> Vec<usize> {
        let across = rows(lengths);
        let named: Vec<bool> = (0..across.len()).map(|e| which.contains(&e)).collect();
        let gone = with_detached_parts(&across, &vec![1.0; across.len()], &named, most);
        (0..gone.len()).filter(|e| gone[*e]).collect()
    }

    #[test]
    fn parts_detached_by_an_erosion_are_eroded_with_it() {
        assert_eq!(gone(&[10], &[7], 1.0), [7, 8, 9]);
        assert_eq!(gone(&[10], &[2, 7], 1.0), [0, 1, 2, 7, 8, 9]);
        assert!(gone(&[10], &[], 1.0).is_empty());
    }

    #[test]
    fn a_detached_part_above_the_mass_limit_remains_as_a_separate_body() {
        assert_eq!(gone(&[10], &[6], 0.2), [6]);
        assert_eq!(gone(&[10], &[1, 7], 0.2), [0, 1, 7, 8, 9]);
        assert!(gone(&[10], &[4, 5, 6], 0.2).is_empty(), "more than may go");
        assert!(gone(&[3], &[0, 1, 2], 1.0).is_empty(), "nothing would be left");
    }

    #[test]
    fn a_body_that_nothing_breaks_off_stays_however_light_it_is() {
        assert_eq!(gone(&[1, 10, 3], &[8], 1.0), [8, 9, 10]);
        assert_eq!(gone(&[1, 10, 3], &[0], 1.0), [0]);
    }
}
