//! Interface of the element kernel of a material, over [`Number`]: one element, or eight in vector lanes.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::rest_geometry::RestGeometry;
use crate::constitutive::{VolumetricEnergy, VolumetricResponse};
use crate::fem::history::{HistoryLanes, HistoryLayout};
use crate::fem::{GroupKick, MAX_NODES, Section};
use crate::math::{Number, array};
use std::fmt::Debug;

/// Input of a material.
pub(crate) struct LawInput<'a, V: Number, R> {
    /// Rest volume w, m³; 0 in an empty lane.
    pub volume: V,
    /// Inverse determinant of the rest edges, 1/mᴰ; 0 in an empty lane.
    pub scale: V,
    /// Rest data of the material.
    pub rest: &'a R,
    /// Kick by the forces, and the time since the previous tick.
    pub kick: GroupKick,
    /// History variables, updated by the evaluation.
    pub history: &'a mut [HistoryLanes<V::Lanes>],
}

/// Element kernel of a material.
pub(crate) trait ElementLaw<const D: usize>: HistoryLayout<D> + Copy {
    /// Rest data, with the numbers of its lanes side by side.
    type Rest<L: Copy + Default + Debug>: RestOperator<D, L>;
    /// True if elements may be strained at the rest positions of their nodes.
    const HAS_HISTORY: bool;
    /// Computes the rest data; 0 in empty lanes.
    fn rest<V: Number>(&self, shape: &RestGeometry<D, V>) -> Self::Rest<V::Lanes>;
    /// Returns the volumetric energy law.
    fn volume(&self) -> impl VolumetricEnergy;
    /// Returns the stabilisation modulus of a patch of a layered gel, relative to that of the gel, by which its elements
    /// exchange volume; `None` if their own part of the volumetric energy balances their shear energy instead.
    #[inline(always)]
    fn stabilisation<V: Number>(&self, _: &LaneRatios<V>) -> Option<V> {
        None
    }
    /// Evaluates the elements and updates their history variables.
    fn evaluate<V: Number>(
        &self,
        section: Section,
        input: LawInput<'_, V, Self::Rest<V::Lanes>>,
        strains: &ElementDeformation<D, V>,
        slopes: &VolumetricSlopes<V>,
    ) -> ElementForces<D, V>;
}

/// Rest data, which maps the edges of elements to deformation gradients.
pub(crate) trait RestOperator<const D: usize, L>: Clone + Default {
    /// Replaces the edges, as columns, by F or the tensor that the material uses instead.
    ///
    /// `strained` is 1 in strained lanes and 0 at rest, `scale` that of the element. Returns the factor from the
    /// determinant of the tensor to det F.
    fn deform<V: Number<Lanes = L>>(&self, strained: V, scale: V, edges: &mut [[V; D]; D]) -> V;
}

/// Forces, stiffness bounds, energy and dissipation.
#[derive(Clone, Copy)]
pub(crate) struct ElementForces<const D: usize, V> {
    /// Forces on all nodes but the first, which takes the reaction, without the hoop force, N.
    pub forces: [[V; D]; D],
    /// Hoop force of a ring on each node along r, N.
    pub hoop_force: V,
    /// Stiffness bound κ, N/m.
    pub stiffness: V,
    /// Stored energy without the volumetric part, J.
    pub energy: V,
    /// Dissipation by dashpots and by bulk viscosity, and energy released by damage, J.
    pub lost: [V; 3],
}

/// Deformation of an element.
#[derive(Clone, Copy)]
pub(crate) struct ElementDeformation<const D: usize, V> {
    /// F, or the tensor that the material uses instead.
    pub f: [[V; D]; D],
    /// Out-of-plane stretch λ.
    pub out: V,
    /// Hoop gradient 1/(3R̄), 1/m.
    pub hoop: V,
    /// det F in the plane or in space, without λ.
    pub det_f: V,
    /// 1 for a strained element, 0 at rest.
    pub strained: V,
}

/// Strength and bulk modulus of elements of a layered gel, relative to those of the gel; 1 in an empty lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LaneRatios<V> {
    pub strength: V,
    pub bulk: V,
}

/// U′ and max(U″, 0), element and patch parts together, Pa.
#[derive(Clone, Copy)]
pub(crate) struct VolumetricSlopes<V> {
    pub slope: V,
    pub curvature: V,
}

impl<const D: usize, V: Number> ElementDeformation<D, V> {
    /// Returns the deformation of elements at rest.
    #[inline(always)]
    pub fn at_rest(zero: V) -> Self {
        let (none, one) = ([[zero; D]; D], zero + 1.0);
        Self { f: none, out: one, hoop: zero, det_f: one, strained: zero }
    }

    /// Returns J = λ det F.
    #[inline(always)]
    pub fn jacobian(&self) -> V {
        if D == 2 { self.det_f * self.out } else { self.det_f }
    }

    /// Replaces the edges x_a − x_0, the columns of `f`, by F, with J and λ.
    ///
    /// `volume` and `scale` are those of [`LawInput`]. `moved` is positive where a node is not at rest or the element
    /// is incompatible; `radii` is the sum of the radii of a ring. J is exactly 1, without rounding, for elements at
    /// rest and in empty lanes.
    #[inline(always)]
    pub fn deform<G: ElementLaw<D>>(
        &mut self,
        section: Section,
        rest: &G::Rest<V::Lanes>,
        volume: V,
        scale: V,
        moved: V,
        radii: V,
    ) {
        let (zero, one) = (volume.constant(0.0), volume.constant(1.0));
        let away = moved * volume;
        let strained = away.choose(one, zero);
        let unit = rest.deform(strained, scale, &mut self.f);
        self.det_f = away.choose(array::fused_det(&self.f) * unit, one);
        if D == 2 && section == Section::Axisymmetric {
            self.hoop = hoop_gradient(volume, scale);
            self.out = away.choose(radii * self.hoop, one);
        }
        self.strained = if G::HAS_HISTORY { one } else { strained };
    }
}

/// Returns the hoop gradient 1/(3R̄), 1/m, from w = 2πR̄A and the scale 1/(2A); 0 in an empty lane.
#[inline(always)]
fn hoop_gradient<V: Number>(volume: V, scale: V) -> V {
    let volume = volume * scale * 3.0;
    volume.choose(volume.constant(std::f64::consts::PI) / volume, volume.constant(0.0))
}

/// Evaluates the volumetric energy of a patch, J, with the slope and curvature of each element (method 5).
///
/// The energy is U(J) for a patch of one element, else the element part at each J plus the patch part at J̄. `ratios` are
/// those of the elements of a layered gel, whose energies they multiply; the patch part has their mean by volume.
#[inline(always)]
pub(crate) fn evaluate_volumetric<const D: usize, V: Number>(
    gel: &impl ElementLaw<D>,
    volumes: &[V],
    strains: &[ElementDeformation<D, V>],
    slopes: &mut [VolumetricSlopes<V>],
    ratios: Option<&[LaneRatios<V>]>,
) -> V {
    if volumes.len() == 1 {
        let u = gel.volume().volumetric(strains[0].jacobian());
        slopes[0] = VolumetricSlopes { slope: u.slope, curvature: u.curvature.at_least(0.0) };
        let Some(ratios) = ratios else { return volumes[0] * u.energy };
        slopes[0] = slopes[0].scaled(ratios[0].bulk);
        return volumes[0] * u.energy * ratios[0].bulk;
    }
    if let Some(ratios) = ratios {
        return evaluate_layered_patch(gel, volumes, strains, slopes, ratios);
    }
    let mut volume = volumes[0];
    let mut now = volume * strains[0].jacobian();
    for k in 1..volumes.len() {
        (volume, now) = (volume + volumes[k], now + volumes[k] * strains[k].jacobian());
    }
    // An empty lane has no volume; the smallest number keeps it from 0/0.
    let shared = gel.volume().shared(now / volume.at_least(f64::MIN_POSITIVE));
    let mut energy = volume * shared.energy;
    for k in 0..volumes.len() {
        let own = gel.volume().own(strains[k].jacobian());
        energy = energy + volumes[k] * own.energy;
        slopes[k].slope = own.slope + shared.slope;
        slopes[k].curvature = own.curvature.at_least(0.0) + shared.curvature.at_least(0.0);
    }
    energy
}

/// Evaluates the volumetric energy of a patch of several elements of a layered gel.
#[inline(always)]
fn evaluate_layered_patch<const D: usize, V: Number, G: ElementLaw<D>>(
    gel: &G,
    volumes: &[V],
    strains: &[ElementDeformation<D, V>],
    slopes: &mut [VolumetricSlopes<V>],
    ratios: &[LaneRatios<V>],
) -> V {
    let zero = volumes[0].constant(0.0);
    let (mut volume, mut now) = (zero, zero);
    let mut mean = LaneRatios { strength: zero, bulk: zero };
    for k in 0..volumes.len() {
        volume = volume + volumes[k];
        now = now + volumes[k] * strains[k].jacobian();
        mean.strength = mean.strength + volumes[k] * ratios[k].strength;
        mean.bulk = mean.bulk + volumes[k] * ratios[k].bulk;
    }
    let whole = volume.at_least(f64::MIN_POSITIVE);
    (mean.strength, mean.bulk) = (mean.strength / whole, mean.bulk / whole);
    let (jacobian, stabilisation) = (now / whole, gel.stabilisation(&mean));
    let shared = shared_part(gel, jacobian, &mean, stabilisation);
    let mut energy = volume * shared.energy;
    for k in 0..volumes.len() {
        let own = gel.volume().own(strains[k].jacobian());
        let factor = stabilisation.unwrap_or(ratios[k].bulk);
        energy = energy + volumes[k] * own.energy * factor;
        slopes[k].slope = own.slope * factor + shared.slope;
        slopes[k].curvature = own.curvature.at_least(0.0) * factor + shared.curvature.at_least(0.0);
    }
    energy
}

/// Returns the patch part of the volumetric energy of a layered gel at J̄: U and the stabilisation, each with its modulus.
#[inline(always)]
fn shared_part<const D: usize, V: Number, G: ElementLaw<D>>(
    gel: &G,
    jacobian: V,
    mean: &LaneRatios<V>,
    stabilisation: Option<V>,
) -> VolumetricResponse<V> {
    let shared = gel.volume().shared(jacobian);
    let Some(stabilisation) = stabilisation else {
        return VolumetricResponse {
            energy: shared.energy * mean.bulk,
            slope: shared.slope * mean.bulk,
            curvature: shared.curvature * mean.bulk,
        };
    };
    let whole = gel.volume().volumetric(jacobian);
    let both = |whole: V, shared: V| whole * mean.bulk + (shared - whole) * stabilisation;
    VolumetricResponse {
        energy: both(whole.energy, shared.energy),
        slope: both(whole.slope, shared.slope),
        curvature: both(whole.curvature, shared.curvature),
    }
}

/// Evaluates elements, those of a layered gel with their strength and bulk modulus: `slopes` are the whole ones.
#[inline(always)]
pub(crate) fn evaluate_elements<const D: usize, V: Number, G: ElementLaw<D>>(
    gel: &G,
    section: Section,
    input: LawInput<'_, V, G::Rest<V::Lanes>>,
    strains: &ElementDeformation<D, V>,
    slopes: &VolumetricSlopes<V>,
    ratios: Option<&LaneRatios<V>>,
) -> ElementForces<D, V> {
    let over = ratios.map_or(*slopes, |ratios| slopes.over(ratios.strength));
    let forces = gel.evaluate(section, input, strains, &over);
    ratios.map_or(forces, |ratios| forces.scaled(ratios.strength))
}

impl<V: Number> VolumetricSlopes<V> {
    /// Returns the slopes of a multiple of the energy.
    #[inline(always)]
    pub fn scaled(&self, factor: V) -> Self {
        Self { slope: self.slope * factor, curvature: self.curvature * factor }
    }

    /// Returns the slopes over the strength of the element, with which a law is evaluated whose result is
    /// [scaled](ElementForces::scaled) by it.
    #[inline(always)]
    pub fn over(&self, strength: V) -> Self {
        Self { slope: self.slope / strength, curvature: self.curvature / strength }
    }
}

impl<const D: usize, V: Number> ElementForces<D, V> {
    /// Returns the response of a material of a multiple of the moduli, stresses and viscosities.
    #[inline(always)]
    pub fn scaled(&self, factor: V) -> Self {
        let mut forces = self.forces;
        for a in 0..D {
            for i in 0..D {
                forces[a][i] = forces[a][i] * factor;
            }
        }
        Self {
            forces,
            hoop_force: self.hoop_force * factor,
            stiffness: self.stiffness * factor,
            energy: self.energy * factor,
            lost: self.lost.map(|lost| lost * factor),
        }
    }

    /// Returns weight · f and κ at every node.
    #[inline(always)]
    pub fn nodal_kicks(&self, weight: V) -> [[V; 4]; MAX_NODES] {
        let zero = weight.constant(0.0);
        let mut kicks = [[zero, zero, zero, self.stiffness]; MAX_NODES];
        for i in 0..D {
            for a in 0..D {
                kicks[a + 1][i] = self.forces[a][i] * weight;
                kicks[0][i] = kicks[0][i] - kicks[a + 1][i];
            }
        }
        if D == 2 {
            let hoop_force = self.hoop_force * weight;
            for a in 0..=D {
                kicks[a][0] = kicks[a][0] + hoop_force;
            }
        }
        kicks
    }

    /// Returns the power Σ f·v, W, for the velocities of the nodes.
    #[inline(always)]
    pub fn power(&self, v: &[[V; 4]; MAX_NODES]) -> V {
        let zero = self.hoop_force.constant(0.0);
        let mut power = if D == 2 { self.hoop_force * (v[0][0] + v[1][0] + v[2][0]) } else { zero };
        for i in 0..D {
            for a in 0..D {
                power = self.forces[a][i].multiply_add(v[a + 1][i] - v[0][i], power);
            }
        }
        power
    }
}
