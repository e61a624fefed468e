//! Elements of a viscoelastic gel in lanes: as [`super::viscoelastic`] has them, eight side by side.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::batch::wide;
use super::history::{Recall, Remembering, put_shape, rows_of_shape, shape};
use super::hyperelastic_simd::two_largest;
use super::kinematics::{AtNodes, Gradients, Placed};
use super::rest_geometry::{Shape, det};
use super::simd_material::{Eight, Pull, Slopes, Solid, Strains};
use super::simplex::isochoric;
use super::symmetric_tensor::Symmetric;
use super::{Memory, Section};
use crate::constitutive::{Hyperelastic, NeoHookean, Viscoelastic, Volume};
use crate::math::Number;
use fearless_simd::{Simd, SimdBase, f64x8};

/// Where eight elements are, or were: C̄⁻¹ and C̄, and what is above 0 where a branch can be drawn there.
#[derive(Clone, Copy)]
struct Place<const D: usize, V> {
    inverse: Symmetric<D, V>,
    shape: Symmetric<D, V>,
    upright: V,
}

/// What a branch has been drawn back from: dev(C̄ C̄_i⁻¹) with its component out of the plane, and its square.
struct Drawn<const D: usize, V> {
    inner: [[V; D]; D],
    out: V,
    square: V,
    /// What tr b̄ has fallen by.
    fall: V,
}

/// What the springs of eight elements do together: P = K + U′ ∂J/∂F, K = F (μ + Σ μ_i J^(−2/3) C̄_i⁻¹), and beside it what that has out of the plane, Pa;
/// U′ with what takes the trace from those of the branches, Pa; what they store, J/m³; and the curvature of the branches, N/m⁴.
struct Springs<const D: usize, V> {
    pulled: [[V; D]; D],
    out: V,
    slope: V,
    stored: V,
    curvature: V,
}

impl<const D: usize> Remembering<D> for Viscoelastic {
    /// C̄⁻¹ and J at the last own tick, then the C̄_i⁻¹ of its branches.
    fn rows(&self) -> usize {
        1 + (1 + self.branches().len()) * rows_of_shape::<D>()
    }

    fn put_memory(&self, rows: &mut [Recall], lane: usize, memory: &[Memory<D>]) {
        let (jacobian, shapes) = rows.split_first_mut().expect("where it was is remembered");
        jacobian.0[lane] = memory[0].jacobian;
        let shapes = shapes.chunks_exact_mut(rows_of_shape::<D>());
        shapes.zip(memory).for_each(|(rows, memory)| put_shape(rows, lane, memory));
    }

    fn take_memory(&self, rows: &[Recall], lane: usize, memory: &mut [Memory<D>]) {
        let shapes = rows[1..].chunks_exact(rows_of_shape::<D>());
        memory.iter_mut().zip(shapes).for_each(|(memory, rows)| *memory = shape(rows, lane));
        memory[0].jacobian = rows[0].0[lane];
    }
}

impl<const D: usize> Solid<D> for Viscoelastic {
    type Rest = Gradients<D>;
    const REMEMBERS: bool = true;

    #[inline(always)]
    fn rest<S: Simd>(&self, shape: &Shape<D, f64x8<S>>) -> Gradients<D> {
        Gradients::new(shape)
    }

    #[inline(always)]
    fn volume(&self) -> impl Volume {
        Hyperelastic::volume(self.equilibrium())
    }

    #[inline(always)]
    fn pull<S: Simd>(
        &self,
        section: Section,
        (batch, rest, kick, memory): Eight<'_, Gradients<D>>,
        (s, u): (&Strains<D, f64x8<S>>, &Slopes<f64x8<S>>),
    ) -> Pull<D, f64x8<S>> {
        let (simd, at) = (s.inner.simd, Placed::new(s));
        let (zero, volume) = (f64x8::splat(simd, 0.0), wide(simd, &batch.volume));
        let (nodes, still) = (at.at_nodes(rest), rest.at_rest(s.hoop));
        let (jacobian, shapes) = memory.split_first_mut().expect("where it was is remembered");
        let (last, branches) = shapes.split_at_mut(rows_of_shape::<D>());
        let before = Place::before(Symmetric::load(simd, last), wide(simd, &jacobian.0));
        let now = Place::now(&at);
        let (mut springs, mut lost) = (Springs::new(self.equilibrium(), s, u.slope), zero);
        for (branch, rows) in self.branches().iter().zip(branches.chunks_exact_mut(rows_of_shape::<D>())) {
            let mut own = Symmetric::load(simd, rows);
            if kick.elapsed > 0.0 {
                let fallen = forget(&mut own, [&before, &now], branch.left(kick.elapsed));
                lost += fallen * (0.5 * branch.shear_modulus);
                own.store(rows);
            }
            springs.add(&at, (branch.shear_modulus, &own), [&nodes, &still]);
        }
        now.inverse.chosen(now.upright, &before.inverse).store(last);
        s.jacobian().store_slice(&mut jacobian.0);
        let turning = u.slope.absolute() * turn(section, s) + self.equilibrium().shear_modulus();
        let bound = turning * still.metric.trace() + u.curvature * dilated(&at, &nodes) + springs.curvature;
        let pulled = (&springs.pulled, springs.out);
        let (forces, around) = at.forces(rest, pulled, (-volume, -(volume * springs.slope)));
        let (stiffness, energy) = (volume * bound, volume * springs.stored);
        Pull { forces, around, stiffness, energy, lost: [zero, volume * lost, zero] }
    }
}

/// Has the branches of eight elements forget where these were, and then where they are now, so much that these parts of their stress are
/// left; returns what they lose, in tr b̄.
#[inline(always)]
fn forget<const D: usize, V: Number>(
    branch: &mut Symmetric<D, V>,
    [before, now]: [&Place<D, V>; 2],
    parts: [f64; 2],
) -> V {
    let [first, second] = [before.draw_back(branch, parts[0]), now.draw_back(branch, parts[1])];
    let mut both = first.out * second.out;
    for i in 0..D {
        for j in 0..D {
            both = both + first.inner[i][j] * second.inner[j][i];
        }
    }
    // (d_b − s_a d_a):[(1 − s_b) d_b − (1 − s_a) d_a].
    let (left, gone) = (parts[0], parts.map(|part| 1.0 - part));
    let excess = second.square * gone[1] - both * (gone[0] + left * gone[1]) + first.square * (left * gone[0]);
    let none = excess.constant(0.0);
    first.fall + second.fall - before.upright.choose(now.upright, none).choose(excess * 0.5, none)
}

impl<const D: usize, V: Number> Place<D, V> {
    /// Where elements were, of what they remember of it.
    #[inline(always)]
    fn before(inverse: Symmetric<D, V>, jacobian: V) -> Self {
        Self { shape: inverse.inverse(), inverse, upright: jacobian - NeoHookean::FLOOR }
    }

    /// Where they are.
    #[inline(always)]
    fn now(at: &Placed<'_, D, V>) -> Self {
        let (s, none) = (at.strain, at.scale.constant(0.0));
        let over = at.scale.constant(1.0) / (s.inner * s.inner * at.scale);
        let square = s.out * s.out * at.scale;
        let mut now = Self {
            inverse: Symmetric::diagonal(none, if D == 2 { square.constant(1.0) / square } else { none }),
            shape: Symmetric::diagonal(none, if D == 2 { square } else { none }),
            upright: s.inner.choose(at.upright, none),
        };
        for i in 0..D {
            for j in i..D {
                let (mut inverse, mut shape) = (at.cofactor[0][i] * at.cofactor[0][j], s.f[0][i] * s.f[0][j]);
                for k in 1..D {
                    inverse = inverse + at.cofactor[k][i] * at.cofactor[k][j];
                    shape = shape + s.f[k][i] * s.f[k][j];
                }
                (now.inverse.inner[i][j], now.shape.inner[i][j]) = (inverse * over, shape * at.scale);
            }
        }
        now
    }

    /// Leaves this part of dev b̄ of branches where elements are held here.
    #[inline(always)]
    fn draw_back(&self, branch: &mut Symmetric<D, V>, left: f64) -> Drawn<D, V> {
        let none = branch.out.constant(0.0);
        let mut inner = [[none; D]; D];
        let mut out = if D == 2 { self.shape.out * branch.out } else { none };
        let mut trace = out;
        for i in 0..D {
            for j in 0..D {
                let mut sum = self.shape.of(i, 0) * branch.of(0, j);
                for k in 1..D {
                    sum = sum + self.shape.of(i, k) * branch.of(k, j);
                }
                inner[i][j] = sum;
            }
            trace = trace + inner[i][i];
        }
        let before = trace * (1.0 / 3.0);
        if D == 2 {
            out = out - before;
        }
        let mut square = out * out;
        for i in 0..D {
            inner[i][i] = inner[i][i] - before;
            square = square + inner[i][i] * inner[i][i];
            for j in 0..i {
                square = square + inner[i][j] * inner[j][i] * 2.0;
            }
        }
        let determinant = determinant(&inner, out);
        let after = isochoric(before, (square * (0.5 * left * left), determinant * (left * left * left)));
        let drawn = branch.combined(left, (&self.inverse, after - before * left));
        *branch = drawn.chosen(self.upright, branch);
        Drawn { inner, out, square, fall: self.upright.choose((before - after) * 3.0, none) }
    }
}

/// Of a tensor and its component out of the plane.
#[inline(always)]
fn determinant<const D: usize, V: Number>(a: &[[V; D]; D], out: V) -> V {
    let inner = det(a);
    if D == 2 { inner * out } else { inner }
}

impl<const D: usize, V: Number> Springs<D, V> {
    /// That of the long run alone.
    #[inline(always)]
    fn new(gel: &NeoHookean, s: &Strains<D, V>, slope: V) -> Self {
        let (mu, none) = (gel.shear_modulus(), slope.constant(0.0));
        let mut pulled = s.f;
        for i in 0..D {
            for j in 0..D {
                pulled[i][j] = s.f[i][j] * mu;
            }
        }
        let square = if D == 2 { s.out * s.out + square(&s.f) } else { square(&s.f) };
        Self { pulled, out: none + mu, slope, stored: (square - 3.0) * (0.5 * mu), curvature: none }
    }

    /// Takes up a branch with its rest shape.
    #[inline(always)]
    fn add(&mut self, at: &Placed<'_, D, V>, (mu, own): (f64, &Symmetric<D, V>), [nodes, still]: [&AtNodes<D, V>; 2]) {
        let (pulled, part, none) = (at.pulled(own), at.scale * mu, at.scale.constant(0.0));
        let elastic = at.elastic(&pulled, own.out);
        let trace = elastic.trace();
        for i in 0..D {
            for j in 0..D {
                self.pulled[i][j] = self.pulled[i][j] + pulled[i][j] * part;
            }
        }
        self.out = self.out + own.out * part;
        self.slope = self.slope - at.upright.choose(trace * (1.0 / 3.0) * mu / at.jacobian, none);
        self.stored = self.stored + (trace - 3.0) * (0.5 * mu);
        let mut curvature = nodes.shear_bound(&elastic);
        if (-at.upright).any_positive() {
            // Where J^(−2/3) is held at the continuation W is quadratic.
            curvature = at.upright.choose(curvature, own.dot(&still.metric) * at.scale);
        }
        self.curvature = self.curvature + curvature * mu;
    }
}

/// |F|² in the plane or in space.
#[inline(always)]
fn square<const D: usize, V: Number>(f: &[[V; D]; D]) -> V {
    let mut sum = f[0][0].constant(0.0);
    for i in 0..D {
        for j in 0..D {
            sum = sum + f[i][j] * f[i][j];
        }
    }
    sum
}

/// s of κ ([`super::Simplices`]).
#[inline(always)]
fn turn<const D: usize, V: Number>(section: Section, s: &Strains<D, V>) -> V {
    match section {
        Section::Planar { .. } => s.out.constant(1.0),
        Section::Spatial => (square(&s.f) * 2.0).root(),
        Section::Axisymmetric => two_largest(square(&s.f), s.inner, s.out),
    }
}

/// Σ |∂J/∂x_a|², 1/m².
#[inline(always)]
fn dilated<const D: usize, V: Number>(at: &Placed<'_, D, V>, nodes: &AtNodes<D, V>) -> V {
    let ring = at.strain.inner * at.strain.hoop;
    let mut sum = nodes.metric.inner[0][0];
    for i in 1..D {
        sum = sum + nodes.metric.inner[i][i];
    }
    let sum = sum * at.jacobian * at.jacobian;
    if D == 2 { sum + ring * ring * (D + 1) as f64 } else { sum }
}
