//! Gels beyond neo-Hookean: closed forms, the bound of their stiffness, what a bounce and a new mesh keep, and what is refused.

#[path = "../hyperelastic/bound.rs"]
mod bound;
#[path = "../hyperelastic/closed.rs"]
mod closed;
#[path = "../hyperelastic/runs.rs"]
mod runs;

use ballistic_gel::constitutive::{Material, MooneyRivlin, NeoHookean, Ogden, OgdenTerm};
use ballistic_gel::fem::{DEPTH, ElementResponse, Potential, Section, Simplices};
use ballistic_gel::math::Vector;
use ballistic_gel::mesh::{Mesh, NodeId};

/// K of the gels here, Pa.
const BULK: f64 = 80.0;

fn mooney_rivlin(constants: [f64; 2]) -> Material {
    Material::MooneyRivlin(MooneyRivlin::new(constants, BULK))
}

fn ogden(terms: &[(f64, f64)]) -> Material {
    let terms: Vec<OgdenTerm> = terms.iter().map(|&(modulus, exponent)| OgdenTerm { modulus, exponent }).collect();
    Material::Ogden(Ogden::new(&terms, BULK))
}

/// Gels of one, two and three terms, of exponents above and below 2 and below 0.
fn gels() -> Vec<(&'static str, Material)> {
    vec![
        ("Mooney-Rivlin, C2 = 0", mooney_rivlin([1.5, 0.0])),
        ("Mooney-Rivlin", mooney_rivlin([1.2, 0.4])),
        ("Ogden 2", ogden(&[(3.0, 2.0)])),
        ("Ogden 0.7", ogden(&[(4.0, 0.7)])),
        ("Ogden 8", ogden(&[(0.7, 8.0)])),
        ("Ogden -3", ogden(&[(-1.5, -3.0)])),
        ("Ogden 1.3, 5, -2", ogden(&[(2.0, 1.3), (0.1, 5.0), (-0.3, -2.0)])),
    ]
}

/// An element by itself.
fn single<const D: usize>(rest: &[Vector<D>], gel: impl Into<Material>, section: Section) -> Simplices<D> {
    let nodes = if D == 2 { [0, 1, 2, 0] } else { [0, 1, 2, 3] };
    Simplices::new(&Mesh::new(rest.to_vec(), vec![nodes.map(NodeId)]), gel, section)
}

fn answer<const D: usize>(simplices: &Simplices<D>, x: &[Vector<D>]) -> (f64, ElementResponse<D>) {
    let mut answers = [ElementResponse::default(); DEPTH];
    (simplices.evaluate(0, x, &[], &mut answers), answers[0])
}

/// Numbers from 0 to 1 that are the same in every run.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

fn neo_hookean(shear_modulus: f64) -> Material {
    NeoHookean::new(shear_modulus, BULK).into()
}
