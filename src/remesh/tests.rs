//! What a new mesh must be like, whatever the old one was.

use super::samples::{held, moved, rings, square};
use super::*;
use crate::mesh::least_angle;
use std::collections::HashSet;

const ANY: Acceptance = Acceptance { area: 1.0, quality: 0.0 };
const SAME_AREA: Acceptance = Acceptance { area: 1e-12, quality: 0.0 };

/// The new mesh as a mesh at rest, with the sizes that were asked for.
fn settled(new: &Proposal<2>, size: impl Fn(&Vector<2>) -> f64) -> (Mesh<2>, Vec<f64>) {
    let mesh = Mesh::new(new.position.clone(), new.elements.clone());
    let sizes = mesh.rest.iter().map(size).collect();
    (mesh, sizes)
}

fn worst_angle(x: &[Vector<2>], elements: &[Simplex]) -> f64 {
    elements.iter().map(|e| if signed_volume(x, e) > 0.0 { least_angle(x, e) } else { 0.0 }).fold(180.0, f64::min)
}

fn remeshed(mesh: &Mesh<2>, position: &[Vector<2>], size: impl Fn(&Vector<2>) -> f64) -> Proposal<2> {
    let sizes: Vec<f64> = position.iter().map(size).collect();
    propose(&Moved { mesh, position }, &sizes, &Rules::default()).unwrap()
}

#[test]
fn explore() {
    let fine = |x: &Vector<2>| (0.02 + 0.2 * (x - Vector::<2>::new(0.5, 1.0)).norm()).min(0.1);
    let cases: Vec<(&str, Mesh<2>, Box<dyn Fn(&Vector<2>) -> Vector<2>>, Box<dyn Fn(&Vector<2>) -> f64>)> = vec![
        ("same", square(16), Box::new(|x| *x), Box::new(|_| 1.0 / 16.0)),
        ("sheared", square(16), Box::new(|x| Vector::<2>::new(x[0] + 1.5 * x[1], x[1])), Box::new(|_| 1.0 / 16.0)),
        ("stretched", square(16), Box::new(|x| Vector::<2>::new(x[0] * 3.0, x[1] / 3.0)), Box::new(|_| 1.0 / 16.0)),
        ("refined", square(16), Box::new(|x| *x), Box::new(|_| 1.0 / 50.0)),
        ("graded", square(16), Box::new(|x| *x), Box::new(fine)),
        ("coarse", square(64), Box::new(|x| *x), Box::new(|_| 1.0 / 10.0)),
        (
            "indented",
            square(32),
            Box::new(|x| {
                let d = 0.4 * (-((x[0] - 0.5) / 0.12).powi(2)).exp() * x[1].powi(2);
                Vector::<2>::new(x[0], x[1] - d)
            }),
            Box::new(|_| 1.0 / 32.0),
        ),
        (
            "twirl",
            square(32),
            Box::new(|x| {
                let c = Vector::<2>::new(0.5, 0.5);
                let d = x - c;
                let t = 3.0 * (-(d.norm() / 0.15).powi(2)).exp();
                c + Vector::<2>::new(d[0] * t.cos() - d[1] * t.sin(), d[0] * t.sin() + d[1] * t.cos())
            }),
            Box::new(|_| 1.0 / 32.0),
        ),
        ("rings", rings(2, 0.25), Box::new(|x| Vector::<2>::new(x[0] + 0.7 * x[1], x[1])), Box::new(|_| 0.25)),
    ];
    for (name, mesh, map, size) in cases {
        let position = moved(&mesh, map);
        let old = Moved { mesh: &mesh, position: &position };
        let t = std::time::Instant::now();
        let new = remeshed(&mesh, &position, &size);
        let t = t.elapsed();
        let q = judge(&old, &new, &ANY);
        println!(
            "{name}: {} -> {} angle {:.1} {q:?} {t:?}",
            mesh.elements.len(),
            new.elements.len(),
            worst_angle(&position, &mesh.elements)
        );
        let (mut mesh, mut sizes) = settled(&new, &size);
        for _ in 0..3 {
            let old = Moved { mesh: &mesh, position: &mesh.rest };
            let again = propose(&old, &sizes, &Rules::default()).unwrap();
            let sorted = |e: &Simplex| {
                let mut e = [e[0], e[1], e[2]];
                e.sort_unstable();
                e
            };
            let olds: HashSet<[NodeId; 3]> = mesh.elements.iter().map(sorted).collect();
            let kept = again.origin.iter().filter(|o| matches!(o, Origin::Kept(_))).count();
            println!(
                "   again same {} nodes {}/{}/{} elements in place {}/{} {:?}",
                again.elements == mesh.elements,
                mesh.rest.len(),
                kept,
                again.position.len(),
                again.elements.iter().filter(|e| olds.contains(&sorted(e))).count(),
                mesh.elements.len(),
                judge(&old, &again, &ANY).map(|q| q.angle)
            );
            (mesh, sizes) = settled(&again, &size);
        }
    }
}
