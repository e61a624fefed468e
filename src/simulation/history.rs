//! What the elements of a new mesh were at rest: what their nodes say where that is true, else a deformation between the mean
//! of the old elements that they are made of and what their nodes say (numerics 4.6).

use super::shared::{measure, shares, stays};
use super::volumes::{rest_of, rests};
use crate::algebra::{Tensor, Vector, cofactor, cube_root, det};
use crate::element::{Memory, Potential, Reference, Section, Simplices};
use crate::mesh::{ElementId, Patches, Simplex};
use crate::remesh::{Proposal, Same, Source, Transferred};
use crate::state::Birth;

/// The nodes say what an element is if measure and distortion at rest are within this part of those of what it is made of.
const HOLDS: f64 = 1e-9;
/// Ī₁ of what is not distorted.
const UNDISTORTED: f64 = 3.0;
/// Halvings that find the deformation with the distortion of the old elements.
const HALVINGS: usize = 40;

/// What old elements make a new one of: means by mass, and the measure that they had at rest.
struct Mean<const D: usize> {
    strain: Strain<D>,
    /// Ī₁, whose mean the mean of F does not have.
    distortion: f64,
    /// Area or volume, or area times radius of a ring, at rest.
    rest: f64,
    /// ε_p.
    plastic: f64,
    /// g.
    left: f64,
    /// U′ as the strength feels it.
    felt: f64,
    is_ring: bool,
    /// Whether it is of a gel that flows: F is the elastic part then.
    flows: bool,
}

/// F and the stretch out of the plane.
#[derive(Clone, Copy)]
struct Strain<const D: usize> {
    f: Tensor<D>,
    out: f64,
}

impl<const D: usize> Strain<D> {
    /// Of an old element, or the elastic part where it flows; none of one that is inside out then.
    fn of(past: &Past<'_, D>, x: &[Vector<D>], element: ElementId) -> Self {
        let (f, out) = match past.memory.get(element.index()) {
            Some(memory) => {
                past.potential.elastic(element, x, memory).unwrap_or_else(|| (Tensor::<D>::identity(), 1.0))
            }
            None => past.potential.deformation(element, x),
        };
        Self { f, out }
    }

    fn zero() -> Self {
        Self { f: Tensor::<D>::zeros(), out: 0.0 }
    }

    fn plus(&self, other: &Self, part: f64) -> Self {
        Self { f: self.f + other.f * part, out: self.out + other.out * part }
    }

    /// From this one to another.
    fn between(&self, other: &Self, part: f64) -> Self {
        Self::zero().plus(self, 1.0 - part).plus(other, part)
    }

    /// F C, λ³: along the same axes, but stretched three times as far.
    fn thrice(&self) -> Self {
        Self { f: self.f * self.f.transpose() * self.f, out: self.out * self.out * self.out }
    }

    /// Ī₁ = tr(FᵀF)/J^⅔: what a distortion costs, whatever the volume.
    fn distortion(&self) -> f64 {
        let across = if D == 2 { self.out * self.out } else { 0.0 };
        let root = cube_root(det(&self.f) * self.out);
        (self.f.norm_squared() + across) / (root * root)
    }
}

/// What the elements of an old mesh were, and what they remember.
pub(super) struct Past<'a, const D: usize> {
    pub potential: &'a Simplices<D>,
    pub old: &'a Birth<D>,
    pub memory: &'a [Memory<D>],
    /// J of each old element as a part of that of its patch, 1 of one by itself.
    pub shares: Vec<f64>,
}

impl<'a, const D: usize> Past<'a, D> {
    /// With the nodes at these positions.
    pub fn new((potential, old, memory): (&'a Simplices<D>, &'a Birth<D>, &'a [Memory<D>]), x: &[Vector<D>]) -> Self {
        Self { potential, old, memory, shares: shares(potential, x) }
    }

    /// What an old element remembers.
    fn memory(&self, same: Same) -> Memory<D> {
        self.memory[same.element.index()]
    }

    /// Area or volume, or area times radius of a ring, of an old element at rest.
    pub fn rest(&self, element: ElementId) -> f64 {
        self.potential.reference(element).size(self.potential.section() == Section::Axisymmetric)
    }
}

/// Strains and distortions of old elements that are in new ones, found once: most are in several.
#[derive(Default)]
struct Strains<const D: usize> {
    /// By old element, which of them is its own, if any.
    place: Vec<Option<u32>>,
    all: Vec<(Strain<D>, f64)>,
}

impl<const D: usize> Strains<D> {
    /// Of what new elements are made of, with the nodes at `x`.
    fn of(past: &Past<'_, D>, x: &[Vector<D>], sources: &[Source]) -> Self {
        let mut strains = Self { place: vec![None; past.potential.len()], all: vec![] };
        for old in sources.iter().map(|source| source.old) {
            if strains.place[old.index()].is_none() {
                strains.place[old.index()] = Some(strains.all.len() as u32);
                strains.all.push(Self::found(past, x, old));
            }
        }
        strains
    }

    fn found(past: &Past<'_, D>, x: &[Vector<D>], element: ElementId) -> (Strain<D>, f64) {
        let strain = Strain::of(past, x, element);
        (strain, strain.distortion())
    }

    /// That of an old element.
    fn at(&self, past: &Past<'_, D>, x: &[Vector<D>], element: ElementId) -> (Strain<D>, f64) {
        let place = self.place.get(element.index()).copied().flatten();
        place.map_or_else(|| Self::found(past, x, element), |place| self.all[place as usize])
    }
}

/// The elements of a new mesh, and what they are made of.
#[derive(Clone, Copy)]
pub(super) struct Made<'a, const D: usize> {
    /// Where its nodes are, and where their matter was at rest.
    pub position: &'a [Vector<D>],
    pub rest: &'a [Vector<D>],
    pub elements: &'a [Simplex],
    /// The old element that each is, if it is one.
    pub same: &'a [Option<Same>],
    /// What the others are made of, in their order.
    pub sources: &'a [Source],
    /// Whether it is the old mesh itself, where no other was taken: what stands in its patch goes on as it is.
    pub is_kept: bool,
}

impl<'a, const D: usize> Made<'a, D> {
    /// By an exchange.
    pub fn by(proposal: &'a Proposal<D>, new: &'a Transferred<D>) -> Self {
        let Transferred { rest, same, sources, .. } = new;
        Self { position: &proposal.position, elements: &proposal.elements, rest, same, sources, is_kept: false }
    }
}

/// What new elements are at rest where their nodes do not say it.
type References<const D: usize> = Vec<(ElementId, Reference<D>)>;

/// The elements of a new mesh that are at rest not what their nodes say, and what all remember; `None` if one can be nothing.
///
/// Of a gel that flows no node knows what an element is at rest: each is made of the elastic part of what it is made of, and
/// remembers how far that has flowed, but not in which direction.
pub(super) fn inherited<const D: usize>(
    past: &Past<'_, D>,
    position: &[Vector<D>],
    (new, patches): (&Made<'_, D>, &Patches),
) -> Option<(References<D>, Vec<Memory<D>>)> {
    let flows = past.potential.remembers();
    let mut memory = vec![Memory::default(); if flows { new.elements.len() } else { 0 }];
    let mut all = vec![];
    let stays = stays(past.potential.patches(), patches, new.same);
    let again = (0..).map(ElementId).zip(new.same).filter_map(|(element, same)| Some((element, (*same)?)));
    for (element, same) in again {
        // What stands in the patch that it stood in goes on as it is; of what flows in the plane, whose shots are calibrated so, all
        // takes the J of its patch at an exchange.
        let goes_on = stays[element.index()] && (new.is_kept || !(D == 2 && flows));
        let share = if goes_on { 1.0 } else { past.shares[same.element.index()] };
        if flows {
            let now = Reference::of(new.position, &new.elements[element.index()]);
            let made = if goes_on { None } else { Mean::alone(past, position, same.element).again(&now) };
            // What goes on, and what is inside out, of which nothing can be made.
            let as_it_is = || (turned(&past.potential.reference(same.element), same).scaled(share), past.memory(same));
            let (reference, recalled) = made.unwrap_or_else(as_it_is);
            all.push((element, reference));
            memory[element.index()] = recalled;
            continue;
        }
        if share != 1.0 || !past.potential.is_compatible(same.element) {
            all.push((element, turned(&past.potential.reference(same.element), same).scaled(share)));
        }
    }
    let strains = Strains::of(past, position, new.sources);
    let rests = rests(past, position, new);
    let is_there = |element: ElementId| rests[element.index()] > 0.0;
    for sources in new.sources.chunk_by(|a, b| a.new == b.new).filter(|sources| is_there(sources[0].new)) {
        let (element, nodes) = (sources[0].new, &new.elements[sources[0].new.index()]);
        let [told, now] = [new.rest, new.position].map(|x| Reference::of(x, nodes));
        let mean = Mean::of(past, (position, &strains), (sources, rests[element.index()]));
        if !mean.is_told(&told, &now) {
            all.push((element, mean.made(&told, &now)?));
        }
        if flows {
            memory[element.index()] = mean.recalled();
        }
    }
    // What is made of nothing rests as it is.
    for (element, nodes) in
        (0..).map(ElementId).zip(new.elements).filter(|(e, _)| new.same[e.index()].is_none() && !is_there(*e))
    {
        all.push((element, Reference::of(new.position, nodes)));
    }
    all.sort_by_key(|(element, _)| *element);
    let is_ring = past.potential.section() == Section::Axisymmetric;
    for ((element, reference), memory) in all.iter().zip(&mut memory) {
        let now = Reference::of(new.position, &new.elements[element.index()]);
        let out = if is_ring { now.radius / reference.radius } else { 1.0 };
        memory.jacobian = det(&now.edges) / det(&reference.edges) * out;
    }
    // A ring of no radius is none.
    let stands = |(_, reference): &(ElementId, Reference<D>)| !is_ring || reference.radius > 0.0;
    all.iter().all(stands).then_some((all, memory))
}

/// The reference of an old element whose nodes may stand in another order now.
fn turned<const D: usize>(reference: &Reference<D>, same: Same) -> Reference<D> {
    let corner = |a: usize| if a == 0 { Vector::<D>::zeros() } else { reference.edges.column(a - 1).into_owned() };
    let corners = same.turned(&[0, 1, 2, 3].map(|a| if a <= D { corner(a) } else { Vector::<D>::zeros() }));
    Reference { edges: Tensor::<D>::from_fn(|i, j| corners[j + 1][i] - corners[0][i]), ..*reference }
}

impl<const D: usize> Mean<D> {
    /// Of one old element.
    fn alone(past: &Past<'_, D>, x: &[Vector<D>], element: ElementId) -> Self {
        let mass = past.old.corner_mass[element.index()].iter().sum();
        let source = Source { new: element, old: element, mass, part: 1.0 };
        let rest = rest_of(past, &source);
        Self::of(past, (x, &Strains::default()), (&[source], rest))
    }

    /// Of parts of old elements, with this measure at rest.
    fn of(past: &Past<'_, D>, (x, strains): (&[Vector<D>], &Strains<D>), (sources, rest): (&[Source], f64)) -> Self {
        let is_ring = past.potential.section() == Section::Axisymmetric;
        let (mut strain, mut distortion, mut mass) = (Strain::zero(), 0.0, 0.0);
        let (mut plastic, mut left, mut felt, mut stored) = (0.0, 0.0, 0.0, 0.0);
        let is_massive = sources.iter().any(|source| source.mass > 0.0);
        for source in sources {
            let (own, own_distortion) = strains.at(past, x, source.old);
            let memory = past.memory.get(source.old.index()).copied().unwrap_or_default();
            // What was made of nothing in the mesh before has no mass: its mean is by volume.
            let weight = if is_massive { source.mass } else { source.part * past.rest(source.old) };
            plastic += memory.plastic * weight;
            left += memory.left * weight;
            felt += memory.felt * weight;
            strain = strain.plus(&own, weight);
            distortion += own_distortion * weight;
            mass += weight;
            stored += (own_distortion - UNDISTORTED) * source.part * past.rest(source.old) * memory.left;
        }
        let flows = past.potential.remembers();
        let left = left / mass;
        // By what is stored, not by mass: where patches hand on volumes that their elements did not have, the two differ.
        let distortion = if flows { UNDISTORTED + (stored / rest / left).max(0.0) } else { distortion / mass };
        let strain = Strain::zero().plus(&strain, 1.0 / mass);
        Self { strain, distortion, plastic: plastic / mass, left, felt: felt / mass, rest, is_ring, flows }
    }

    /// An element of its own shape now, and what it remembers.
    fn again(&self, now: &Reference<D>) -> Option<(Reference<D>, Memory<D>)> {
        Some((self.made(now, now)?, self.recalled()))
    }

    /// What its element remembers.
    fn recalled(&self) -> Memory<D> {
        Memory { plastic: self.plastic, left: self.left, felt: self.felt, ..Memory::default() }
    }

    /// Whether the nodes say how much matter there is, and how it is distorted.
    fn is_told(&self, told: &Reference<D>, now: &Reference<D>) -> bool {
        let holds = |found: f64, wanted: f64| (found - wanted).abs() < HOLDS * wanted;
        let strain = self.said(told, now);
        !self.flows
            && holds(told.size(self.is_ring), self.rest)
            && strain.is_some_and(|strain| holds(strain.distortion(), self.distortion))
    }

    /// The deformation that the nodes say, if they stand upright at rest.
    fn said(&self, told: &Reference<D>, now: &Reference<D>) -> Option<Strain<D>> {
        let out = if self.is_ring { now.radius / told.radius } else { 1.0 };
        let outside = out > 0.0 && out.is_finite();
        inverse(&told.edges).filter(|_| outside && !self.flows).map(|inverse| Strain { f: now.edges * inverse, out })
    }

    /// What has the measure at rest of what it is made of, and its distortion: on the way from the mean, which has less, to what
    /// the nodes say, or where they say less, to more of the same.
    ///
    /// The mean of F alone forgets how old elements differ. A ball of 20 m/s lost 20 % of its energy by it on its way into gel,
    /// and what the nodes say alone, where they stood upright, gained 6 % (h = R/2, 18 meshes).
    fn made(&self, told: &Reference<D>, now: &Reference<D>) -> Option<Reference<D>> {
        let rest = Strain { f: Tensor::<D>::identity(), out: 1.0 };
        let mean = self.fitted(&self.strain, now);
        if let Some(fit) = mean.filter(|fit| {
            fit.1 >= (1.0 - HOLDS) * self.distortion && !(self.flows && fit.1 > (1.0 + HOLDS) * self.distortion)
        }) {
            return Some(fit.0);
        }
        // What lies between two that stand upright need not.
        let reaches = |strain: &Strain<D>| self.reaches(strain, now);
        let told = self.said(told, now).filter(reaches);
        // More than enough is only there where energy is handed on: on the way to it from rest then.
        let (from, aim) = match mean {
            Some(fit) if fit.1 > self.distortion => (rest, self.strain),
            _ => (self.strain, told.unwrap_or_else(|| self.strain.thrice())),
        };
        let (mut less, mut more) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (less + more);
            if reaches(&from.between(&aim, middle)) { more = middle } else { less = middle }
        }
        // Where the mean is turned inside out, nothing is known of the shape, and it rests in the one that it has.
        let fit = self.fitted(&from.between(&aim, less), now).or_else(|| self.fitted(&rest, now));
        fit.map(|fit| fit.0)
    }

    /// Whether an element with this F, but for the change of volume, and the measure at rest has the distortion or more, or is none.
    ///
    /// What [`Self::fitted`] finds, cubed and without its roots: F stretched by 1/s has det F/s^D = w/w₀, so that s drops out of Ī₁ in space
    /// and is s² = w₀ det F/w in the plane.
    fn reaches(&self, strain: &Strain<D>, now: &Reference<D>) -> bool {
        let (whole, turned) = (measure(&now.edges), det(&strain.f));
        let rest = if self.is_ring { self.rest * strain.out / now.radius } else { self.rest };
        let grown = whole / rest;
        let (square, volume) = match D {
            2 => (strain.f.norm_squared() / turned * grown + strain.out * strain.out, grown * strain.out),
            _ => (strain.f.norm_squared(), turned),
        };
        let cube = |x: f64| x * x * x;
        let is_upright = turned > 0.0 && grown > 0.0 && (!self.is_ring || strain.out > 0.0);
        !is_upright || cube(square) >= cube(self.distortion) * volume * volume
    }

    /// An element with this F, but for the change of volume, and the measure at rest; and its distortion.
    fn fitted(&self, strain: &Strain<D>, now: &Reference<D>) -> Option<(Reference<D>, f64)> {
        let radius = if self.is_ring { now.radius / strain.out } else { now.radius };
        let rest = if self.is_ring { self.rest / radius } else { self.rest };
        let edges = inverse(&strain.f)? * now.edges;
        let scale = rest / measure(&edges);
        let edges = edges * if D == 2 { scale.sqrt() } else { cube_root(scale) };
        let f = now.edges * inverse(&edges)?;
        let whole = edges.norm().is_finite() && radius.is_finite() && (!self.is_ring || radius > 0.0);
        whole.then(|| (Reference { edges, radius }, Strain { f, out: strain.out }.distortion()))
    }
}

/// The inverse of what is upright.
fn inverse<const D: usize>(a: &Tensor<D>) -> Option<Tensor<D>> {
    let det = det(a);
    (det > 0.0).then(|| cofactor(a).transpose() / det)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::element::Simplices;
    use crate::material::{BulkViscosity, EquationOfState, Flowing, Material, Strength};
    use crate::mesh::{Block, Split, block};

    /// A gel that flows, of parts of 1.
    pub fn gel() -> Flowing {
        Flowing {
            shear_modulus: 4.8,
            state: EquationOfState::new(60.0, 0.0, 20.0),
            strength: Some(Strength::new(0.3, 0.2, 1.6)),
            softening: None,
            viscosity: BulkViscosity { linear: 0.1, quadratic: 1.0 },
            density: 1.0,
        }
    }

    #[test]
    fn an_element_that_is_inside_out_goes_on_as_it_is() {
        let mesh = block::<2>(Block { planes: [[0.0, 1.0]; 2].map(Vec::from), split: Split::Centred, faces: vec![] });
        let n = mesh.elements.len();
        let material = (Material::Flowing(gel()), Section::Planar { thickness: 1.0 });
        let simplices = Simplices::in_patches(&mesh, Patches::alone(n), material);
        let memory: Vec<_> = (0..n).map(|e| Memory { plastic: e as f64, jacobian: 1.0, ..Memory::default() }).collect();
        // The middle is pushed out through a side: the element there is turned over.
        let middle = Vector::<2>::new(0.5, 0.5);
        let out = Vector::<2>::new(0.5, -0.2);
        let position: Vec<_> = mesh.rest.iter().map(|x| if *x == middle { out } else { *x }).collect();
        let (elements, rest) = (mesh.elements.clone(), mesh.rest.clone());
        let corner_mass = vec![[1.0; 4]; n];
        let birth = Birth {
            tick: 0,
            position: position.clone(),
            mass: vec![1.0; rest.len()],
            corner_mass,
            references: vec![],
            mesh,
        };
        let past = Past::new((&simplices, &birth, &memory), &position);
        let same: Vec<_> = (0..n as u32).map(|e| Some(Same::in_order(ElementId(e)))).collect();
        let new =
            Made { position: &position, rest: &rest, elements: &elements, same: &same, sources: &[], is_kept: false };
        let (references, recalled) = inherited(&past, &position, (&new, &Patches::alone(n))).unwrap();
        let turned: Vec<_> = (0..n).filter(|e| measure(&Reference::of(&position, &elements[*e]).edges) < 0.0).collect();
        assert_eq!(turned.len(), 1);
        for (element, reference) in references {
            let e = element.index();
            let was = simplices.reference(element);
            assert_eq!(reference.edges == was.edges, turned.contains(&e), "{e}");
            assert!(
                (measure(&reference.edges) - measure(&was.edges)).abs() < 1e-14
                    && recalled[e].plastic == memory[e].plastic
            );
        }
    }

    #[test]
    fn what_is_made_of_nothing_rests_as_it_is_and_remembers_nothing() {
        let solid = Material::NeoHookean(crate::material::NeoHookean::new(20e3, 2e6));
        let (plane, ring) = (Section::Planar { thickness: 1.0 }, Section::Axisymmetric);
        let flowing = Material::Flowing(gel());
        for (section, material) in [(plane, flowing), (ring, flowing), (plane, solid), (ring, solid)] {
            let axis = || vec![1.0, 2.0];
            let mesh = block::<2>(Block { planes: [axis(), axis()], split: Split::Centred, faces: vec![] });
            let simplices = Simplices::in_patches(&mesh, Patches::alone(4), (material, section));
            let memory = vec![Memory { plastic: 0.7, left: 0.4, felt: -3.0, ..Memory::default() }; 4];
            // Stretched and sheared and let out.
            let position: Vec<_> =
                mesh.rest.iter().map(|x| Vector::<2>::new(1.1 * x[0] + 0.3 * x[1], 1.2 * x[1])).collect();
            let (elements, rest) = (mesh.elements.clone(), mesh.rest.clone());
            let (mass, corner_mass) = (vec![1.0; rest.len()], vec![[1.0; 4]; 4]);
            let birth = Birth { tick: 0, mesh, position: position.clone(), mass, corner_mass, references: vec![] };
            let past = Past::new((&simplices, &birth, &memory), &position);
            let same = [None, Some(1), Some(2), Some(3)].map(|e| e.map(|e| Same::in_order(ElementId(e))));
            let sources = [Source { new: ElementId(0), old: ElementId(0), mass: 0.3, part: 0.3 }];
            let new = Made {
                position: &position,
                rest: &rest,
                elements: &elements,
                same: &same,
                sources: &sources,
                is_kept: false,
            };
            let (references, recalled) = inherited(&past, &position, (&new, &Patches::alone(4))).unwrap();
            let (_, own) = references.iter().find(|(element, _)| element.index() == 0).unwrap();
            let now = Reference::of(&position, &elements[0]);
            assert!(own.edges == now.edges && own.radius == now.radius, "{section:?}: {own:?}");
            let expected = Memory { jacobian: 1.0, ..Memory::default() };
            assert!(recalled.is_empty() || recalled[0] == expected, "{section:?}: {:?}", recalled[0]);
        }
    }

    #[test]
    fn an_element_that_was_made_of_nothing_hands_on_what_it_is() {
        let planes = [[0.0, 1.0]; 3].map(Vec::from);
        let mesh = block::<3>(Block { planes, split: Split::Centred, faces: vec![] });
        let material = (Material::Flowing(gel()), Section::Spatial);
        let simplices = Simplices::in_patches(&mesh, Patches::alone(mesh.elements.len()), material);
        let memory = vec![Memory { plastic: 0.7, left: 0.4, felt: -3.0, ..Memory::default() }; mesh.elements.len()];
        let (position, corner_mass) = (mesh.rest.clone(), vec![[0.0; 4]; mesh.elements.len()]);
        let mass = vec![0.0; position.len()];
        let birth = Birth { tick: 0, position: position.clone(), mass, corner_mass, references: vec![], mesh };
        let past = Past::new((&simplices, &birth, &memory), &position);
        let source = Source { new: ElementId(0), old: ElementId(3), mass: 0.0, part: 1.0 };
        let rest = rest_of(&past, &source);
        let mean = Mean::of(&past, (&position, &Strains::default()), (&[source], rest));
        assert!(
            (mean.plastic - 0.7).abs() < 1e-15 && (mean.left - 0.4).abs() < 1e-15 && (mean.felt + 3.0).abs() < 1e-14,
            "{} {}",
            mean.plastic,
            mean.left
        );
        assert!((mean.distortion - UNDISTORTED).abs() < 1e-12 && mean.rest > 0.0);
    }
}
