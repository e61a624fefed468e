//! Elements laid out for vector units: eight patches side by side, every quantity of the eight in one vector.
//!
//! The arithmetic is that of [`super::Simplices`] written per lane in plain operations, so that every instruction set
//! gives the same bits: no fused multiply-add, no call. What is gathered and scattered goes through rows of eight numbers
//! per node, turned by eight-by-eight transpositions.

use super::{MAX_NODES, Section};
use crate::algebra::Vector;
use crate::material::NeoHookean;
use fearless_simd::{Level, Simd, SimdBase, dispatch, f64x8};
use std::ops::Range;

/// Patches side by side.
pub const LANES: usize = 8;
/// Most elements of a patch.
pub const DEPTH: usize = 4;
/// Most nodes that a block may number for itself; a power of two.
pub const MOST_LOCAL_NODES: usize = 4096;

type Wide = [f64; LANES];

/// Displacement (three components and a gap) and velocity of a node.
pub type Row = [f64; 8];
/// Impulse of a node (three components), N·s, and Σ κ of the elements around it, N/m.
pub type Accumulated = [f64; 4];

/// The k-th elements of eight patches.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub struct Batch<const D: usize> {
    /// ∇N_a at rest for a = 1..=D, 1/m.
    gradients: [[Wide; D]; D],
    /// w, rest volume, m³; 0 in an empty lane.
    volume: Wide,
    /// Numbers of the nodes within the block.
    nodes: [[u16; LANES]; MAX_NODES],
}

/// The nodes of one block while it is swept.
#[derive(Debug)]
pub struct Local {
    rows: Box<[Row; MOST_LOCAL_NODES]>,
    accumulated: Box<[Accumulated; MOST_LOCAL_NODES]>,
}

/// What a group of patches answers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GroupAnswer {
    /// Σ V, J.
    pub energy: f64,
    /// Σ f·v, W.
    pub power: f64,
    /// Least J.
    pub least_jacobian: f64,
    /// Which elements have J ≤ 0: bit 8k + l for the k-th element of the patch in lane l.
    pub inverted: u32,
    /// How many elements are below the continuation.
    pub crushed: u32,
}

/// Elements in lanes.
#[derive(Debug, Clone)]
pub struct Lanes<const D: usize> {
    batches: Vec<Batch<D>>,
    depth: usize,
    material: NeoHookean,
    section: Section,
}

/// F, cof F, λ, det F and J of the elements of a batch.
struct Strains<const D: usize> {
    f: [[Wide; D]; D],
    cofactor: [[Wide; D]; D],
    out: Wide,
    hoop: Wide,
    inner: Wide,
    jacobian: Wide,
}

/// U′ and max(U″, 0) of an element with its share of the patch's.
#[derive(Clone, Copy)]
struct Slopes {
    slope: Wide,
    curvature: Wide,
}

impl Local {
    /// Room for the nodes of any block.
    #[must_use]
    pub fn new() -> Self {
        let boxed = |rows: Vec<Row>| rows.into_boxed_slice().try_into().expect("as many as there may be");
        let sums = vec![[0.0; 4]; MOST_LOCAL_NODES].into_boxed_slice().try_into().expect("as many as there may be");
        Self { rows: boxed(vec![[0.0; 8]; MOST_LOCAL_NODES]), accumulated: sums }
    }

    /// Sets displacement and velocity of a node, and nothing accumulated.
    #[inline]
    pub fn load<const D: usize>(&mut self, node: usize, displacement: &Vector<D>, velocity: &Vector<D>) {
        let row = &mut self.rows[node];
        for i in 0..D {
            (row[i], row[4 + i]) = (displacement[i], velocity[i]);
        }
        self.accumulated[node] = [0.0; 4];
    }

    /// What the sweep left at the first nodes.
    #[must_use]
    pub fn accumulated(&self, n_nodes: usize) -> &[Accumulated] {
        &self.accumulated[..n_nodes]
    }
}

impl Default for Local {
    fn default() -> Self {
        Self::new()
    }
}

impl<const D: usize> Batch<D> {
    /// Nothing in any lane.
    fn empty() -> Self {
        Self { gradients: [[[0.0; LANES]; D]; D], volume: [0.0; LANES], nodes: [[0; LANES]; MAX_NODES] }
    }
}

impl<const D: usize> Lanes<D> {
    /// Empty lanes for so many slots, `depth` elements to a patch.
    ///
    /// # Panics
    /// If the slots do not fill their batches, or `depth` is none of 1, 2 and 4.
    #[must_use]
    pub(super) fn empty(n_slots: usize, depth: usize, law: (NeoHookean, Section)) -> Self {
        assert!(n_slots.is_multiple_of(LANES * depth), "slots fill whole groups");
        assert!(matches!(depth, 1 | 2 | 4), "a patch has one, two or four places");
        Self { batches: vec![Batch::empty(); n_slots / LANES], depth, material: law.0, section: law.1 }
    }

    /// Puts an element into a slot: ∇N_a for a = 1..=D, w, and the numbers of its nodes.
    pub(super) fn put(&mut self, slot: usize, (gradients, volume): (&[[f64; D]; D], f64), nodes: &[u16; MAX_NODES]) {
        let (batch, lane) = (&mut self.batches[slot / LANES], slot % LANES);
        for (wide, gradient) in batch.gradients.iter_mut().zip(gradients) {
            for (wide, component) in wide.iter_mut().zip(gradient) {
                wide[lane] = *component;
            }
        }
        batch.volume[lane] = volume;
        for (wide, node) in batch.nodes.iter_mut().zip(nodes) {
            wide[lane] = *node;
        }
    }

    /// Elements to a patch.
    #[must_use]
    pub fn depth(&self) -> usize {
        self.depth
    }

    /// Shows the numbers, within the block, of the nodes of the elements of a group, again and again where they share them.
    pub fn nodes(&self, group: usize, mut see: impl FnMut(u16)) {
        for batch in &self.batches[group * self.depth..(group + 1) * self.depth] {
            for lane in (0..LANES).filter(|lane| batch.volume[*lane] > 0.0) {
                batch.nodes[..=D].iter().for_each(|wide| see(wide[lane]));
            }
        }
    }

    /// Bytes held.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.batches.len() * size_of::<Batch<D>>()
    }

    /// Sweeps over those groups of a run for which `weight` gives the length of a kick, s: accumulates Σ weight · f and
    /// Σ κ at the nodes of the block, and writes κ of each slot and the answer of each group, both from the first group on.
    pub fn sweep(
        &self,
        level: Level,
        (groups, weight): (Range<usize>, impl Fn(usize) -> Option<f64>),
        local: &mut Local,
        found: (&mut [f64], &mut [GroupAnswer]),
    ) {
        match self.depth {
            1 => dispatch!(level, simd => self.sweep_in::<1, _>(simd, (groups, weight), local, found)),
            2 => dispatch!(level, simd => self.sweep_in::<2, _>(simd, (groups, weight), local, found)),
            _ => dispatch!(level, simd => self.sweep_in::<4, _>(simd, (groups, weight), local, found)),
        }
    }

    #[inline(always)]
    fn sweep_in<const N: usize, S: Simd>(
        &self,
        simd: S,
        (groups, weight): (Range<usize>, impl Fn(usize) -> Option<f64>),
        local: &mut Local,
        (stiffness, answers): (&mut [f64], &mut [GroupAnswer]),
    ) {
        for ((group, stiffness), answer) in groups.zip(stiffness.chunks_exact_mut(LANES * N)).zip(answers) {
            let Some(weight) = weight(group) else { continue };
            let batches: &[Batch<D>; N] = self.batches[group * N..].first_chunk().expect("a group is whole");
            *answer = self.sweep_group(simd, (batches, weight), local, stiffness);
        }
    }

    /// One group: first F and J of every element, then J̄ of every patch, then the forces.
    #[inline(always)]
    fn sweep_group<const N: usize, S: Simd>(
        &self,
        simd: S,
        (batches, weight): (&[Batch<D>; N], f64),
        local: &mut Local,
        stiffness: &mut [f64],
    ) -> GroupAnswer {
        let rows: [[[Wide; 8]; MAX_NODES]; N] = std::array::from_fn(|k| gather(simd, &batches[k], &local.rows));
        let strains: [Strains<D>; N] = std::array::from_fn(|k| self.strains(&batches[k], &rows[k]));
        let (energy, slopes) = self.volumetric(batches, &strains);
        let mut sums = Sums { energy, power: [0.0; LANES] };
        let mut answer = GroupAnswer { least_jacobian: f64::INFINITY, ..GroupAnswer::default() };
        for k in 0..N {
            let mut kicks = [[[0.0; LANES]; 4]; MAX_NODES];
            self.forces((&batches[k], weight), (&strains[k], &slopes[k]), &rows[k], (&mut kicks, &mut sums));
            scatter(simd, &batches[k], &kicks, &mut local.accumulated);
            stiffness[k * LANES..(k + 1) * LANES].copy_from_slice(&kicks[0][3]);
            note(&mut answer, k, &strains[k].jacobian);
        }
        answer.energy = sum(&sums.energy);
        answer.power = sum(&sums.power);
        answer
    }

    #[inline(always)]
    fn strains(&self, batch: &Batch<D>, rows: &[[Wide; 8]; MAX_NODES]) -> Strains<D> {
        let mut s = Strains {
            f: [[[0.0; LANES]; D]; D],
            cofactor: [[[0.0; LANES]; D]; D],
            out: [1.0; LANES],
            hoop: [0.0; LANES],
            inner: [0.0; LANES],
            jacobian: [0.0; LANES],
        };
        for l in 0..LANES {
            let u = |a: usize, i: usize| rows[a][i][l];
            let mut f = [[0.0; D]; D];
            for (i, row) in f.iter_mut().enumerate() {
                for (j, f) in row.iter_mut().enumerate() {
                    for a in 0..D {
                        *f += (u(a + 1, i) - u(0, i)) * batch.gradients[a][j][l];
                    }
                }
                row[i] += 1.0;
            }
            let (cofactor, inner) = cofactor(&f);
            if self.section == Section::Axisymmetric {
                let (ring, moved) = (ring(batch, l), u(0, 0) + u(1, 0) + u(2, 0));
                (s.hoop[l], s.out[l]) = (ring, 1.0 + moved * ring);
            }
            for (i, j) in (0..D).flat_map(|i| (0..D).map(move |j| (i, j))) {
                (s.f[i][j][l], s.cofactor[i][j][l]) = (f[i][j], cofactor[i][j]);
            }
            s.inner[l] = inner;
            s.jacobian[l] = inner * s.out[l];
        }
        s
    }

    /// Volumetric energy by lane, J, and slope and curvature of each element: U(J) of an element that is a patch by itself;
    /// else U_s(J) of each and U_v(J̄) of the patch (numerics 5).
    #[inline(always)]
    fn volumetric<const N: usize>(&self, batches: &[Batch<D>; N], strains: &[Strains<D>; N]) -> (Wide, [Slopes; N]) {
        let mut energy = [0.0; LANES];
        let mut slopes = [Slopes { slope: [0.0; LANES], curvature: [0.0; LANES] }; N];
        for l in 0..LANES {
            if N == 1 {
                let u = self.material.volumetric(strains[0].jacobian[l]);
                energy[l] = batches[0].volume[l] * u.energy;
                (slopes[0].slope[l], slopes[0].curvature[l]) = (u.slope, u.curvature.max(0.0));
                continue;
            }
            let (mut volume, mut now) = (0.0, 0.0);
            for k in 0..N {
                volume += batches[k].volume[l];
                now += batches[k].volume[l] * strains[k].jacobian[l];
            }
            // An empty lane has no volume and is at rest.
            let mean = if volume > 0.0 { now / volume } else { 1.0 };
            let shared = self.material.shared(mean);
            energy[l] = volume * shared.energy;
            for k in 0..N {
                let own = self.material.own(strains[k].jacobian[l]);
                energy[l] += batches[k].volume[l] * own.energy;
                slopes[k].slope[l] = own.slope + shared.slope;
                slopes[k].curvature[l] = own.curvature.max(0.0) + shared.curvature.max(0.0);
            }
        }
        (energy, slopes)
    }

    /// weight · f_a, κ, Σ V and Σ f·v of the elements of a batch, as [`super::Simplices`] has them.
    #[inline(always)]
    fn forces(
        &self,
        (batch, weight): (&Batch<D>, f64),
        (s, u): (&Strains<D>, &Slopes),
        rows: &[[Wide; 8]; MAX_NODES],
        (kicks, sums): (&mut [[Wide; 4]; MAX_NODES], &mut Sums),
    ) {
        let mu = self.material.shear_modulus();
        for l in 0..LANES {
            let (volume, ring) = (batch.volume[l], s.hoop[l]);
            let mut square = if D == 2 { s.out[l] * s.out[l] } else { 0.0 };
            let (mut spread, mut volumetric, mut power) = (0.0, 0.0, 0.0);
            let around = -volume * ((mu * s.out[l] + u.slope[l] * s.inner[l]) * ring);
            for i in 0..D {
                let (mut rest, mut push, mut own) = (0.0, 0.0, 0.0);
                let (extra, turned) = if i == 0 { (around, s.inner[l] * ring) } else { (0.0, 0.0) };
                for a in 0..D {
                    let (mut fg, mut cg) = (0.0, 0.0);
                    for j in 0..D {
                        fg += s.f[i][j][l] * batch.gradients[a][j][l];
                        cg += s.cofactor[i][j][l] * batch.gradients[a][j][l];
                    }
                    let cg = cg * s.out[l];
                    let f = -volume * (mu * fg + u.slope[l] * cg);
                    let b = cg + turned;
                    volumetric += b * b;
                    own += cg;
                    push -= f;
                    power += (f + extra) * rows[a + 1][4 + i][l];
                    kicks[a + 1][i][l] = weight * (f + extra);
                    let gradient = batch.gradients[a][i][l];
                    spread += gradient * gradient;
                    rest += gradient;
                }
                let b = turned - own;
                volumetric += b * b;
                spread += rest * rest;
                power += (push + extra) * rows[0][4 + i][l];
                kicks[0][i][l] = weight * (push + extra);
                for j in 0..D {
                    square += s.f[i][j][l] * s.f[i][j][l];
                }
            }
            let spread = spread + (D + 1) as f64 * (ring * ring);
            let turn = match self.section {
                Section::Planar { .. } => 1.0,
                Section::Spatial => (2.0 * square).sqrt(),
                Section::Axisymmetric => two_largest(square - s.out[l] * s.out[l], s.inner[l], s.out[l]),
            };
            let stiffness = volume * ((mu + u.slope[l].abs() * turn) * spread + u.curvature[l] * volumetric);
            for kick in kicks.iter_mut() {
                kick[3][l] = stiffness;
            }
            sums.energy[l] += volume * (0.5 * mu * (square - 3.0));
            sums.power[l] += power;
        }
    }
}

/// By lane.
struct Sums {
    energy: Wide,
    power: Wide,
}

/// 1/(3R̄) from w = 2πR̄A and det(∇N_1, ∇N_2) = 1/(2A), 1/m.
#[inline(always)]
fn ring<const D: usize>(batch: &Batch<D>, l: usize) -> f64 {
    let g = &batch.gradients;
    let across = g[0][0][l] * g[1][1][l] - g[0][1][l] * g[1][0][l];
    let filled = batch.volume[l] > 0.0;
    if filled { std::f64::consts::PI / (3.0 * batch.volume[l] * across) } else { 0.0 }
}

/// Sum of the two largest of s₁ ≥ s₂ of the plane part and |λ|, from Σ s², s₁s₂ and λ.
#[inline(always)]
fn two_largest(square: f64, inner: f64, out: f64) -> f64 {
    let area = 2.0 * inner.abs();
    let (sum, difference) = ((square + area).sqrt(), (square - area).max(0.0).sqrt());
    sum.max(0.5 * (sum + difference) + out.abs())
}

/// cof F and det F.
#[inline(always)]
fn cofactor<const D: usize>(f: &[[f64; D]; D]) -> ([[f64; D]; D], f64) {
    let mut c = [[0.0; D]; D];
    if D == 2 {
        (c[0][0], c[0][1], c[1][0], c[1][1]) = (f[1][1], -f[1][0], -f[0][1], f[0][0]);
        return (c, f[0][0] * f[1][1] - f[0][1] * f[1][0]);
    }
    for i in 0..D {
        for j in 0..D {
            let (k, l, m, n) = ((i + 1) % D, (i + 2) % D, (j + 1) % D, (j + 2) % D);
            c[i][j] = f[k][m] * f[l][n] - f[k][n] * f[l][m];
        }
    }
    (c, f[0][0] * c[0][0] + f[0][1] * c[0][1] + f[0][2 % D] * c[0][2 % D])
}

/// Enters J of the k-th elements.
#[inline(always)]
fn note(answer: &mut GroupAnswer, k: usize, jacobian: &Wide) {
    for (l, j) in jacobian.iter().enumerate() {
        answer.least_jacobian = if *j < answer.least_jacobian { *j } else { answer.least_jacobian };
        answer.inverted |= u32::from(*j <= 0.0) << (k * LANES + l);
        answer.crushed += u32::from(*j < NeoHookean::FLOOR);
    }
}

/// In the order of the lanes.
#[inline(always)]
fn sum(wide: &Wide) -> f64 {
    wide.iter().sum()
}

/// The rows of the nodes of eight elements, turned: component by component, eight lanes each.
#[inline(always)]
fn gather<const D: usize, S: Simd>(
    simd: S,
    batch: &Batch<D>,
    rows: &[Row; MOST_LOCAL_NODES],
) -> [[Wide; 8]; MAX_NODES] {
    let mut gathered = [[[0.0; LANES]; 8]; MAX_NODES];
    for (gathered, nodes) in gathered[..=D].iter_mut().zip(&batch.nodes) {
        let eight = nodes.map(|node| f64x8::from_slice(simd, &rows[place(node)]));
        *gathered = transposed(simd, eight).map(Into::into);
    }
    gathered
}

/// Adds what eight elements give to their nodes, one lane after the other.
#[inline(always)]
fn scatter<const D: usize, S: Simd>(
    simd: S,
    batch: &Batch<D>,
    kicks: &[[Wide; 4]; MAX_NODES],
    accumulated: &mut [Accumulated; MOST_LOCAL_NODES],
) {
    for pair in 0..MAX_NODES / 2 {
        let (a, b) = (2 * pair, 2 * pair + 1);
        if a > D {
            return;
        }
        let eight = std::array::from_fn(|q| f64x8::from_slice(simd, &kicks[a + q / 4][q % 4]));
        let turned: [Wide; 8] = transposed(simd, eight).map(Into::into);
        for (l, both) in turned.iter().enumerate() {
            add(&mut accumulated[place(batch.nodes[a][l])], &both[..4]);
            if b <= D {
                add(&mut accumulated[place(batch.nodes[b][l])], &both[4..]);
            }
        }
    }
}

#[inline(always)]
fn add(sum: &mut Accumulated, part: &[f64]) {
    for (sum, part) in sum.iter_mut().zip(part) {
        *sum += part;
    }
}

/// A number within the block; the mask tells the compiler that it is in bounds.
#[inline(always)]
fn place(node: u16) -> usize {
    usize::from(node) & (MOST_LOCAL_NODES - 1)
}

/// Rows and columns of eight times eight numbers exchanged: three rounds of shuffling, as three bits of an index turn.
#[inline(always)]
fn transposed<S: Simd>(simd: S, mut r: [f64x8<S>; 8]) -> [f64x8<S>; 8] {
    for _ in 0..3 {
        let mut next = r;
        for i in 0..4 {
            next[2 * i] = simd.zip_low_f64x8(r[i], r[i + 4]);
            next[2 * i + 1] = simd.zip_high_f64x8(r[i], r[i + 4]);
        }
        r = next;
    }
    r
}
