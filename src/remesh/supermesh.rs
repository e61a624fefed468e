//! Mass and momentum of the new elements, from the old ones that they lie over.

use super::barycentric::{Cell, weighed};
use super::correspondence::Pairing;
use super::nodal_fields::{bearable_part, heights, least_height, levelled};
use super::overlap_candidates::Under;
use super::overlap_integrals::{Cutter, Moments, inertia};
use super::point_location::Locator;
use super::{Carried, Moved, Proposal, Symmetry};
use crate::math::Vector;
use crate::mesh::{ElementId, Simplex};

/// The part of an old element above which what no new element lies over is laid down. Rounding leaves 2e-15 in ordinary
/// meshes. At 1e-10 thirty meshes cut out anew had lost 1.3e-12 of the mass.
const UNCOVERED: f64 = 1e-13;
/// The part above which it is known where that is. Rounding leaves 4e-11 of elements a million times longer than wide: what is less is
/// laid down from the middle of the old element.
const PLACED: f64 = 1e-10;

/// What a new element has that is not an old one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part<const D: usize> {
    /// Which new element.
    pub element: usize,
    /// ∫ρ N_i N_j, kg.
    pub inertia: [[f64; 4]; 4],
    /// ∫ρ N_i v, N·s.
    pub momentum: [Vector<D>; 4],
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
    /// Part of the area or volume of the old one, of a ring with its radius.
    pub part: f64,
}

impl<const D: usize> Part<D> {
    /// ∫ρ N_i, kg.
    pub fn corner_mass(&self) -> [f64; 4] {
        self.inertia.map(|row| row.iter().sum())
    }
}

/// All changed elements.
pub(super) struct Parts<const D: usize> {
    /// In the order of the new elements.
    pub all: Vec<Part<D>>,
    /// What they are made of, in their order.
    pub sources: Vec<Source>,
    /// Old mass that they do not lie over, or twice, kg.
    pub stray_mass: f64,
}

/// An old element that is gone.
struct Gone<const D: usize> {
    cell: Cell<D>,
    /// Its corner masses, kg.
    own: [f64; 4],
    /// Density times measure at its corners, kg.
    heights: [f64; 4],
    velocity: [Vector<D>; 4],
    /// Corner masses that no new element lies over, kg.
    left: [f64; 4],
    /// How often new elements lie over it: parts of its measure, summed.
    covered: f64,
}

/// What new elements have of an old one that they lie over more than once, where the body lies over itself.
#[derive(Clone, Copy)]
struct Shared<const D: usize> {
    /// Of the mass that each has in common with it.
    mass: f64,
    /// Of the measure.
    part: f64,
    /// By how much that moves faster than it does in the old one, m/s: together they have its momentum.
    faster: Vector<D>,
}

/// Elements where their nodes are.
pub(super) fn cells<'a, const D: usize>(x: &[Vector<D>], elements: impl Iterator<Item = &'a Simplex>) -> Vec<Cell<D>> {
    elements.map(|nodes| Cell::of(x, nodes)).collect()
}

impl<const D: usize> Parts<D> {
    /// Of a new mesh: every changed element is cut along the old ones that are gone, and what lies over none of them
    /// is laid down at the nearest place.
    pub fn of(
        (old, carried): (&Moved<'_, D>, &Carried<'_, D>),
        (new, pairing): (&Proposal<D>, &Pairing),
        under: &Under<'_, D>,
    ) -> Self {
        let mut gone: Vec<Gone<D>> = pairing.gone.iter().map(|element| Gone::of(old, carried, *element)).collect();
        let changed = cells(&new.position, pairing.changed().map(|e| &new.elements[e]));
        let (mut cutter, mut sources) = (Cutter::default(), vec![]);
        let all = pairing.changed().zip(&changed).map(|(element, cell)| {
            let mut part = Part { element, inertia: [[0.0; 4]; 4], momentum: [Vector::zeros(); 4] };
            under.near(element, &cell.bounds(), |t| {
                let (mass, parts) = gone[t].give(cell, (&mut cutter, &mut part));
                // What weighs less than nothing is shared as well, and no source after that.
                if mass != 0.0 {
                    let part = gone[t].part(carried.symmetry, &parts);
                    sources.push(Source { new: ElementId(element as u32), old: pairing.gone[t], mass, part });
                }
            });
            part
        });
        let all = all.collect();
        let mut parts = Self { all, sources, stray_mass: 0.0 };
        let shared: Vec<_> = gone.iter().map(Gone::shared).collect();
        if shared.iter().any(Option::is_some) {
            parts.share((&mut gone, &pairing.gone), &shared, (&changed, &mut cutter));
        }
        parts.sources.retain(|source| source.mass > 0.0);
        if gone.iter().any(|gone| gone.misses(UNCOVERED)) {
            parts.lay_down(&gone, &Locator::new(&changed));
        }
        parts.all.iter_mut().for_each(Part::level);
        parts
    }

    /// Leaves each new element its share of the old ones that are shared.
    fn share(
        &mut self,
        (gone, ids): (&mut [Gone<D>], &[ElementId]),
        shared: &[Option<Shared<D>>],
        (changed, cutter): (&[Cell<D>], &mut Cutter),
    ) {
        for source in &mut self.sources {
            let Ok(t) = ids.binary_search(&source.old) else { continue };
            let Some(share) = shared[t] else { continue };
            let Ok(n) = self.all.binary_search_by_key(&source.new.index(), |part| part.element) else { continue };
            if let Some(moments) = cutter.moments(&gone[t].cell, &gone[t].heights, &changed[n]) {
                self.all[n].leave(&moments, (&gone[t].velocity, share));
                (source.mass, source.part) = (source.mass * share.mass, source.part * share.part);
            }
        }
        gone.iter_mut().zip(shared).filter(|(_, shared)| shared.is_some()).for_each(|(gone, _)| gone.left = [0.0; 4]);
    }

    fn lay_down(&mut self, gone: &[Gone<D>], changed: &Locator<'_, D>) {
        for gone in gone.iter().filter(|gone| gone.misses(UNCOVERED)) {
            let mass: f64 = gone.left.iter().sum();
            self.stray_mass += mass.abs();
            let middle = [1.0 / (D + 1) as f64; 4];
            let weights = if gone.misses(PLACED) { gone.left.map(|left| left / mass) } else { middle };
            if let Some(place) = changed.nearest(&weighed(&gone.cell.corners, &weights)) {
                let part = &mut self.all[place.cell];
                part.add_point(mass, &weighed(&gone.velocity, &weights), &place.weights);
            }
        }
    }
}

impl<const D: usize> Part<D> {
    fn add(&mut self, moments: &Moments, velocity: &[Vector<D>; 4]) {
        for i in 0..=D {
            for (sum, term) in self.inertia[i].iter_mut().zip(moments.inertia[i]) {
                *sum += term;
            }
            self.momentum[i] += weighed(velocity, &moments.mixed[i]);
        }
    }

    /// Of what was added, leaves that share.
    fn leave(&mut self, moments: &Moments, (velocity, share): (&[Vector<D>; 4], Shared<D>)) {
        let less = share.mass - 1.0;
        for i in 0..=D {
            for (sum, term) in self.inertia[i].iter_mut().zip(moments.inertia[i]) {
                *sum += less * term;
            }
            let mass: f64 = moments.mixed[i].iter().sum();
            self.momentum[i] += weighed(velocity, &moments.mixed[i]) * less + share.faster * (share.mass * mass);
        }
    }

    /// Where the density would be more than D of its means below nothing at a corner, draws it to its mean until it is nothing there: at
    /// D + 1 means, as where a point of mass lies on the side across, a node in such a corner has no mass. Mass stays, its centre does not.
    ///
    /// Momenta are drawn to their mean by the same part, p′ = p̄ + part (p − p̄): their sum stays, V m becomes V m′, what corners move by
    /// otherwise than the whole shrinks, p′ − V m′ = part (p − V m), and no |p′| is above the greatest |p|, however little the whole weighs.
    fn level(&mut self) {
        let was = self.corner_mass();
        let whole: f64 = was.iter().sum();
        let is_far_below = least_height::<D>(&was) < -(D as f64) * whole;
        if let Some(part) = bearable_part::<D>(&was).filter(|_| is_far_below) {
            self.inertia = inertia::<D>(&heights::<D>(&levelled::<D>(&was)));
            let mean = self.momentum[..=D].iter().sum::<Vector<D>>() / (D + 1) as f64;
            self.momentum[..=D].iter_mut().for_each(|own| *own = mean + (*own - mean) * part);
        }
    }

    /// Adds a mass at a point.
    fn add_point(&mut self, mass: f64, velocity: &Vector<D>, shape: &[f64; 4]) {
        for i in 0..=D {
            for j in 0..=D {
                self.inertia[i][j] += mass * shape[i] * shape[j];
            }
            self.momentum[i] += velocity * (mass * shape[i]);
        }
    }
}

impl<const D: usize> Gone<D> {
    fn of(old: &Moved<'_, D>, carried: &Carried<'_, D>, element: ElementId) -> Self {
        let nodes = &old.mesh.elements[element.index()];
        let was = carried.corner_mass[element.index()];
        let own = if carried.is_level { levelled::<D>(&was) } else { was };
        let velocity = std::array::from_fn(|a: usize| carried.velocity[nodes[a.min(D)].index()]);
        let mut gone = Self {
            cell: Cell::of(old.position, nodes),
            own,
            heights: heights::<D>(&own),
            velocity,
            left: own,
            covered: 0.0,
        };
        if own != was {
            let lacking: [f64; 4] = std::array::from_fn(|a| was[a] - own[a]);
            let faster = weighed(&velocity, &lacking) / own.iter().sum::<f64>();
            gone.velocity.iter_mut().for_each(|velocity| *velocity += faster);
        }
        gone
    }

    /// Gives a new element what that lies over; an element that is turned inside out has nothing to give. How much mass, kg,
    /// and ∫λ_a over it as parts of its measure.
    fn give(&mut self, new: &Cell<D>, (cutter, part): (&mut Cutter, &mut Part<D>)) -> (f64, [f64; 4]) {
        if !self.cell.is_upright {
            return (0.0, [0.0; 4]);
        }
        let (mut mass, mut parts) = (0.0, [0.0; 4]);
        if let Some(moments) = cutter.moments(&self.cell, &self.heights, new) {
            mass = moments.corner_mass.iter().sum();
            parts = moments.parts;
            self.covered += parts.iter().sum::<f64>();
            part.add(&moments, &self.velocity);
            for (left, given) in self.left.iter_mut().zip(moments.corner_mass) {
                *left -= given;
            }
        }
        (mass, parts)
    }

    /// What new elements may keep of it, if they lie over it more than once and have more than it had.
    fn shared(&self) -> Option<Shared<D>> {
        let given: [f64; 4] = std::array::from_fn(|a| self.own[a] - self.left[a]);
        let [own, all] = [self.own, given].map(|masses| masses.iter().sum::<f64>());
        (self.covered > 1.0 + PLACED && all > own && own > 0.0).then(|| {
            let mass = own / all;
            let lacking = std::array::from_fn(|a| self.own[a] - mass * given[a]);
            Shared { mass, part: 1.0 / self.covered, faster: weighed(&self.velocity, &lacking) / own }
        })
    }

    /// The part of it that these weights say, of a ring with its radius.
    fn part(&self, symmetry: Symmetry, parts: &[f64; 4]) -> f64 {
        if symmetry != Symmetry::Axisymmetric {
            return parts.iter().sum();
        }
        let radii = self.cell.corners.map(|corner| corner[0]);
        let mean = radii[..=D].iter().sum::<f64>() / (D + 1) as f64;
        parts.iter().zip(radii).map(|(part, radius)| part * radius).sum::<f64>() / mean
    }

    /// Whether more than this part of its mass, which may be below nothing, is left.
    fn misses(&self, part: f64) -> bool {
        let mass: f64 = self.left.iter().sum();
        mass.abs() > part * self.heights.iter().sum::<f64>().abs() / (D + 1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::NodeId;

    /// An element with that density times measure at its corners, which moves so there.
    fn part<const D: usize>(heights: &[f64; 4], velocity: &[Vector<D>; 4]) -> Part<D> {
        let inertia = inertia::<D>(heights);
        Part { element: 0, inertia, momentum: inertia.map(|row| weighed(velocity, &row)) }
    }

    /// Beside an element that moves in the same way and weighs 1 kg, no node comes to more than twice the speed that there was.
    #[track_caller]
    fn check_kicks<const D: usize>(heights: [f64; 4], velocity: [Vector<D>; 4]) {
        let mut part = part(&heights, &velocity);
        let was = part.momentum;
        part.level();
        let sum = |momenta: &[Vector<D>; 4]| momenta.iter().sum::<Vector<D>>();
        assert!((sum(&part.momentum) - sum(&was)).amax() < 1e-15);
        let greatest = |momenta: &[Vector<D>; 4]| momenta.iter().map(Vector::<D>::norm).fold(0.0, f64::max);
        assert!(greatest(&part.momentum) <= greatest(&was), "{:?} after {was:?}", part.momentum);
        let beside = 1.0 / (D + 1) as f64;
        for ((mass, momentum), velocity) in part.corner_mass().iter().zip(part.momentum).zip(velocity).take(D + 1) {
            let speed = ((momentum + velocity * beside) / (mass + beside)).norm();
            assert!(*mass > 0.0 && speed < 2.0, "{speed} m/s");
        }
    }

    /// Stray mass was taken from them until they weighed a thousandth: drawn to the mean as the whole moves, at 230 to 280 m/s, they threw
    /// nodes of a field of 1 m/s at 45 to 140 m/s.
    #[test]
    fn what_is_drawn_to_its_mean_kicks_no_node_out_of_its_field() {
        let v = |x: f64, y: f64| Vector::<2>::new(x, y);
        check_kicks([-1.0, -1.0, 2.003, 0.0], [v(1.0, 0.0), v(0.0, 1.0), v(-0.6, -0.8), v(0.0, 0.0)]);
        let v = |x: f64, y: f64, z: f64| Vector::<3>::new(x, y, z);
        check_kicks(
            [-1.0, -1.0, -1.0, 3.004],
            [v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0), v(0.0, 0.0, 1.0), v(-0.6, -0.8, 0.0)],
        );
    }

    /// All of an old element that weighs less than nothing has been given away: where the last of it would lie was 0/0.
    #[test]
    fn of_an_element_below_nothing_that_is_given_away_nothing_is_laid_down() {
        let x = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(Vector::<2>::from);
        let cell = Cell::of(&x, &[NodeId(0), NodeId(1), NodeId(2), NodeId(0)]);
        let own = [-1.0, -1.0, -2.0, 0.0];
        let velocity = [Vector::<2>::new(1.0, 0.0); 4];
        let gone = |left| Gone { cell, own, heights: heights::<2>(&own), velocity, left, covered: 0.0 };
        let laid = |left| {
            let mut parts = Parts { all: vec![part::<2>(&[1.0; 4], &velocity)], sources: vec![], stray_mass: 0.0 };
            parts.lay_down(&[gone(left)], &Locator::new(&[cell]));
            (parts.all[0].corner_mass().iter().sum::<f64>(), parts.stray_mass)
        };
        assert_eq!(laid([0.0; 4]), (1.0, 0.0));
        let (mass, stray) = laid(own);
        assert!((mass + 3.0).abs() < 1e-14 && stray == 4.0, "{mass} kg, {stray} kg");
    }

    #[test]
    fn what_is_drawn_to_its_mean_moves_as_before() {
        let velocity = Vector::<2>::new(-60.0, 70.0);
        let mut part =
            Part { element: 0, inertia: inertia::<2>(&[1e-6, 1e-6, 1e-6, 0.0]), momentum: [velocity * 1e-6 / 3.0; 4] };
        part.momentum[3] = Vector::zeros();
        // What hung on it, twenty times its mass, near one of its corners.
        part.add_point(20e-6, &velocity, &[0.98, 0.01, 0.01, 0.0]);
        let corners = part.corner_mass();
        part.level();
        let level = part.corner_mass();
        assert!(level[0] < corners[0] && heights::<2>(&level)[1] >= -1e-18, "{level:?}");
        assert!((level.iter().sum::<f64>() - 21e-6).abs() < 1e-18);
        for (momentum, mass) in part.momentum.iter().zip(level) {
            assert!((momentum - velocity * mass).amax() < 1e-15, "{momentum} of {mass} kg");
        }
    }
}
