//! Mass and momentum of the new elements, from the old ones that they lie over.

use super::bounds::Bounds;
use super::carried::heights;
use super::locate::Locator;
use super::overlay::{Cutter, Moments};
use super::pairing::Pairing;
use super::{Carried, Moved, Proposal, Triangle};
use crate::algebra::Vector;
use crate::mesh::{ElementId, Simplex};

/// The part of an old element above which what no new element lies over is laid down. Rounding leaves 2e-15 in ordinary
/// meshes and 4e-11 of elements a million times longer than wide; above 1e-10 the mass would not be kept to 1e-13.
const UNCOVERED: f64 = 1e-10;

/// What a new element has that is not an old one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    /// Which new element.
    pub element: usize,
    /// ∫ρ N_i N_j, kg.
    pub inertia: [[f64; 3]; 3],
    /// ∫ρ N_i v, N·s.
    pub momentum: [Vector<2>; 3],
}

/// How much of an old element is in a new one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Source {
    /// The new element.
    pub new: ElementId,
    /// The old one.
    pub old: ElementId,
    /// Mass of both, kg.
    pub mass: f64,
}

impl Part {
    /// ∫ρ N_i, kg.
    pub fn corner_mass(&self) -> [f64; 3] {
        self.inertia.map(|row| row.iter().sum())
    }
}

/// All changed elements.
pub(super) struct Parts {
    /// In the order of the new elements.
    pub all: Vec<Part>,
    /// What they are made of, in their order.
    pub sources: Vec<Source>,
    /// Old mass that they do not lie over, or twice, kg.
    pub stray_mass: f64,
}

/// An old element that is gone.
struct Gone {
    triangle: Triangle,
    /// Density times area at its corners, kg.
    heights: [f64; 3],
    velocity: [Vector<2>; 3],
    /// Corner masses that no new element lies over, kg.
    left: [f64; 3],
}

/// The triangles of elements, where their nodes are.
pub(super) fn triangles<'a>(x: &[Vector<2>], elements: impl Iterator<Item = &'a Simplex>) -> Vec<Triangle> {
    elements.map(|nodes| Triangle::of(x, nodes)).collect()
}

impl Parts {
    /// Of a new mesh: every changed element is cut along the old ones that are gone, and what lies over none of them
    /// is laid down at the nearest place.
    pub fn of(
        (old, carried): (&Moved<'_, 2>, &Carried<'_>),
        (new, pairing): (&Proposal<2>, &Pairing),
        locator: &Locator<'_>,
    ) -> Self {
        let mut gone: Vec<Gone> = pairing.gone.iter().map(|element| Gone::of(old, carried, *element)).collect();
        let changed = triangles(&new.position, pairing.changed().map(|e| &new.elements[e]));
        let (mut cutter, mut sources) = (Cutter::default(), vec![]);
        let parts = pairing.changed().zip(&changed).map(|(element, triangle)| {
            let mut part = Part { element, inertia: [[0.0; 3]; 3], momentum: [Vector::zeros(); 3] };
            locator.near(&Bounds::around(&triangle.corners), |t| {
                let mass = gone[t].give(triangle, (&mut cutter, &mut part));
                if mass > 0.0 {
                    sources.push(Source { new: ElementId(element as u32), old: pairing.gone[t], mass });
                }
            });
            part
        });
        let mut parts = Self { all: parts.collect(), sources: vec![], stray_mass: 0.0 };
        parts.sources = sources;
        if gone.iter().any(Gone::is_uncovered) {
            parts.lay_down(&gone, &Locator::new(&changed));
        }
        parts
    }

    fn lay_down(&mut self, gone: &[Gone], changed: &Locator<'_>) {
        for gone in gone.iter().filter(|gone| gone.is_uncovered()) {
            let mass: f64 = gone.left.iter().sum();
            self.stray_mass += mass.abs();
            let weights = gone.left.map(|left| left / mass);
            if let Some(place) = changed.nearest(&weighed(&gone.triangle.corners, &weights)) {
                self.all[place.triangle].add_point(mass, &weighed(&gone.velocity, &weights), &place.weights);
            }
        }
    }
}

impl Part {
    fn add(&mut self, moments: &Moments, velocity: &[Vector<2>; 3]) {
        for i in 0..3 {
            for (sum, term) in self.inertia[i].iter_mut().zip(moments.inertia[i]) {
                *sum += term;
            }
            self.momentum[i] += weighed(velocity, &moments.mixed[i]);
        }
    }

    /// Adds a mass at a point.
    fn add_point(&mut self, mass: f64, velocity: &Vector<2>, shape: &[f64; 3]) {
        for i in 0..3 {
            for j in 0..3 {
                self.inertia[i][j] += mass * shape[i] * shape[j];
            }
            self.momentum[i] += velocity * (mass * shape[i]);
        }
    }
}

impl Gone {
    fn of(old: &Moved<'_, 2>, carried: &Carried<'_>, element: ElementId) -> Self {
        let nodes = &old.mesh.elements[element.index()];
        let left = carried.corner_mass[element.index()];
        Self {
            triangle: Triangle::of(old.position, nodes),
            heights: heights(&left),
            velocity: std::array::from_fn(|a| carried.velocity[nodes[a].index()]),
            left,
        }
    }

    /// Gives a new element what that lies over; an element that is turned inside out has nothing to give. How much mass, kg.
    fn give(&mut self, new: &Triangle, (cutter, part): (&mut Cutter, &mut Part)) -> f64 {
        if !self.triangle.is_upright {
            return 0.0;
        }
        let mut mass = 0.0;
        if let Some(moments) = cutter.moments(&self.triangle, &self.heights, new) {
            mass = moments.corner_mass.iter().sum();
            part.add(&moments, &self.velocity);
            for (left, given) in self.left.iter_mut().zip(moments.corner_mass) {
                *left -= given;
            }
        }
        mass
    }

    fn is_uncovered(&self) -> bool {
        let mass: f64 = self.left.iter().sum();
        mass.abs() > UNCOVERED * self.heights.iter().sum::<f64>() / 3.0
    }
}

/// The sum of values with weights.
fn weighed(values: &[Vector<2>; 3], weights: &[f64; 3]) -> Vector<2> {
    values[0] * weights[0] + values[1] * weights[1] + values[2] * weights[2]
}
