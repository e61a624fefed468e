//! What an immersed mesh must be like, whatever the old one was.

use super::super::samples::{held, moved, rings, square};
use super::super::{Acceptance, Quality, Rejected, judge};
use super::*;
use crate::algebra::Vector;
use crate::mesh::Mesh;
use proptest::prelude::*;

fn at(x: f64, y: f64) -> Vector<2> {
    Vector::<2>::new(x, y)
}

fn immersed(old: &Moved<'_, 2>, size: impl Fn(&Vector<2>) -> f64) -> (Steps, Result<Quality, Rejected>) {
    let sizes: Vec<f64> = old.position.iter().map(size).collect();
    let steps = immerse(old, &sizes, &Rules::default()).unwrap();
    let limits = Acceptance { area: rounding(old, &sizes) + 1e-12, quality: 0.0 };
    let found = judge(old, &steps.proposal, &limits);
    (steps, found)
}

#[test]
fn probe() {
    for n in [4, 7, 16, 33, 80] {
        for turn in [0.0, 0.1, 0.3, 0.785] {
            let mesh = square(n);
            let (s, c) = f64::sin_cos(turn);
            let position = moved(&mesh, |x| at(c * x[0] - s * x[1], s * x[0] + c * x[1]));
            let old = Moved { mesh: &mesh, position: &position };
            let (steps, found) = immersed(&old, |_| 1.0 / n as f64);
            println!("{n} {turn} {} {} {found:?}", mesh.elements.len(), steps.proposal.elements.len());
        }
    }
    let mesh = rings(2, 0.25);
    let (steps, found) = immersed(&Moved { mesh: &mesh, position: &mesh.rest }, |_| 0.2);
    println!("{} {found:?}", steps.proposal.elements.len());
    let _ = held(3);
}
