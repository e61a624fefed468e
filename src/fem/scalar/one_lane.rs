//! Patches of elements one by one: the kernels of the lanes, with one lane.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use super::simplices::Simplices;
use crate::constitutive::MaterialRatios;
use crate::fem::history::{HistoryLanes, MOST_ROWS};
use crate::fem::law::element_law::{
    ElementDeformation, ElementLaw, LaneRatios, LawInput, VolumetricSlopes, evaluate_elements, evaluate_volumetric,
};
use crate::fem::law::rest_geometry::RestGeometry;
use crate::fem::{DEPTH, Dissipation, ElementResponse, GroupKick, HistoryVariables, ReferenceShape, Section};
use crate::math::{Vector, array};
use crate::mesh::{ElementId, edges};

/// Element of one lane.
pub(super) struct LoneElement<const D: usize, R> {
    pub volume: f64,
    pub scale: f64,
    pub rest: R,
}

impl<const D: usize, R> LoneElement<D, R> {
    /// Prepares an element of this rest shape and material; its density is that of its lightest node.
    #[inline(always)]
    pub fn of<G: ElementLaw<D, Rest<f64> = R>>(
        gel: &G,
        section: Section,
        reference: &ReferenceShape<D>,
        material: MaterialRatios,
    ) -> Self {
        let shape = RestGeometry::new(&array::rows(&reference.edges), reference.radius, 1.0, section);
        let MaterialRatios { strength, bulk, density } = material;
        let geometry = RestGeometry { density, strength, bulk, ..shape };
        Self { volume: geometry.volume, scale: geometry.scale(), rest: gel.rest(&geometry) }
    }
}

/// Time and history of a patch at its evaluation.
pub(crate) struct PatchUpdate<'a, const D: usize> {
    /// Kick by the forces; a time above 0 since the last tick updates the history variables.
    pub kick: GroupKick,
    /// History variables of the elements of the patch, element by element.
    pub memory: &'a mut [HistoryVariables<D>],
    /// Viscous part of U′ of each element at the same tick, Pa.
    pub viscous: &'a [f64; DEPTH],
}

impl<const D: usize> Simplices<D> {
    /// Evaluates a patch: its energy, J, its dissipation, and the responses.
    #[inline(always)]
    pub(crate) fn evaluate_patch<G: ElementLaw<D>>(
        &self,
        gel: &G,
        ids: &[ElementId],
        x: &[Vector<D>],
        update: PatchUpdate<'_, D>,
        answers: &mut [ElementResponse<D>; DEPTH],
    ) -> Dissipation {
        let PatchUpdate { kick, memory, viscous } = update;
        let mut strains = [ElementDeformation::at_rest(0.0); DEPTH];
        let mut slopes = [VolumetricSlopes { slope: 0.0, curvature: 0.0 }; DEPTH];
        let mut volumes = [0.0; DEPTH];
        let elements: [_; DEPTH] = std::array::from_fn(|k| ids.get(k).map(|id| self.lone_element(gel, *id)));
        let n = ids.len();
        for (k, (id, element)) in ids.iter().zip(elements.iter().flatten()).enumerate() {
            volumes[k] = element.volume;
            self.strain_element::<G>(*id, element, x, &mut strains[k]);
        }
        let ratios: [_; DEPTH] = std::array::from_fn(|k| ids.get(k).map_or(MaterialRatios::GEL, |id| self.ratios(*id)))
            .map(|ratios| LaneRatios { strength: ratios.strength, bulk: ratios.bulk });
        let layered = self.is_layered().then_some(&ratios[..n]);
        let energy = evaluate_volumetric(gel, &volumes[..n], &strains[..n], &mut slopes[..n], layered);
        let strained = strains.iter().fold(0.0, |most: f64, strain| most.max(strain.strained));
        let mut sum = Dissipation { energy, ..Dissipation::default() };
        let records = memory.len() / n;
        for (k, element) in elements.iter().flatten().enumerate() {
            let memory = &mut memory[k * records..(k + 1) * records];
            let mut rows = [0.0; MOST_ROWS];
            gel.store_history(&mut rows[..gel.rows()], memory);
            gel.hold_viscous(&mut rows[..gel.rows()], viscous[k]);
            let mut history = rows.map(HistoryLanes);
            let LoneElement { volume, scale, rest } = element;
            let history_rows = &mut history[..gel.rows()];
            let input = LawInput { volume: *volume, scale: *scale, rest, kick, history: history_rows };
            let ratios = layered.map(|ratios| &ratios[k]);
            let forces = evaluate_elements(gel, self.section, input, &strains[k], &slopes[k], ratios);
            gel.load_history(&history.map(|row| row.0)[..gel.rows()], memory);
            sum.energy += forces.energy * strained;
            let [viscous, bulk, damage] = forces.lost;
            sum += Dissipation { energy: 0.0, viscous, bulk, damage };
            let kicks = forces.nodal_kicks(strained).map(|kick| Vector::<D>::from_fn(|i, _| kick[i]));
            answers[k] = ElementResponse { stiffness: forces.stiffness, jacobian: strains[k].jacobian(), ..answers[k] };
            answers[k].forces[..=D].copy_from_slice(&kicks[..=D]);
        }
        sum
    }

    /// Prepares an element at rest.
    #[inline(always)]
    fn lone_element<G: ElementLaw<D>>(&self, gel: &G, id: ElementId) -> LoneElement<D, G::Rest<f64>> {
        let material = MaterialRatios { density: self.relative_density(id), ..self.ratios(id) };
        LoneElement::of(gel, self.section, &self.reference(id), material)
    }

    /// Computes the deformation of an element; at rest, where no node has moved, without rounding.
    #[inline(always)]
    fn strain_element<G: ElementLaw<D>>(
        &self,
        id: ElementId,
        element: &LoneElement<D, G::Rest<f64>>,
        x: &[Vector<D>],
        strain: &mut ElementDeformation<D, f64>,
    ) {
        let nodes = self.corners(id);
        let has_moved = !self.is_compatible(id) || nodes.iter().any(|n| x[n.index()] != self.rest[n.index()]);
        strain.f = array::rows(&edges(x, &self.elements()[id.index()]));
        let radii = nodes[..3].iter().map(|node| x[node.index()][0]).fold(0.0, |sum, radius| sum + radius);
        let moved = if has_moved { 1.0 } else { 0.0 };
        strain.deform::<G>(self.section, &element.rest, element.volume, element.scale, moved, radii);
    }
}
